# What all rules share: the checked study, its folder, and the blocks its curves are solved in.
import sys

import yaml

from vibrissa import grid
from vibrissa.plan import PlanError, planned_blocks
from vibrissa.sources import sources
from vibrissa.study import StudyError, parse_study, refuse_repeated_keys

ENDINGS = ["pdf", "svg", "png"]

with open(workflow.source_path("../schemas/study.schema.yaml")) as schema:
    try:
        for path in workflow.configfiles:
            refuse_repeated_keys(Path(path).read_text(encoding="utf-8"))
        STUDY = parse_study(config, yaml.safe_load(schema))
    except StudyError as error:
        raise WorkflowError(f"the study file cannot be run: {error}") from None

RESULTS = f"results/{STUDY.name}"


def study_file(*sections):
    """Part of the study file that a table answers, for its metadata."""
    keys = ("study", "contact", "method", *sections)
    return yaml.safe_dump({key: config[key] for key in keys if key in config}, sort_keys=False)


def study_texts():
    """Study files as they were written, and what the command line changed in them."""
    texts, merged = {}, {}
    for path in map(Path, workflow.configfiles):
        texts[path.name] = path.read_text(encoding="utf-8")
        merged |= yaml.safe_load(texts[path.name])
    changed = {key: value for key, value in config.items() if merged.get(key) != value}
    if changed:
        texts["changes on the command line"] = yaml.safe_dump(changed, sort_keys=False)
    return texts


SCAN_GRIDS = {name: scan.grid for name, scan in STUDY.scans.items()}


def is_solved(block):
    """Whether a block's curves are there; jobs take the plan as it stands."""
    curves = Path(RESULTS, "blocks", STUDY.solver, f"{block}.curves.parquet")
    return curves.exists() or not workflow.is_main_process


try:
    BLOCKS = planned_blocks(
        Path(RESULTS, "blocks", f"{STUDY.solver}.json"),
        grid.curve_keys([*STUDY.grids.values(), *SCAN_GRIDS.values()], STUDY.by_step),
        STUDY.block_size,
        is_solved,
        remember=not workflow.output_settings.dryrun,
    )
except PlanError as error:
    raise WorkflowError(str(error)) from None

# Blocks that grid points are read from, and what is read; a scan may have blocks of its own.
READINGS = {
    block: readings
    for block, members in BLOCKS.items()
    if (readings := grid.block_readings(members, STUDY.grids))
}


def blocks_of_scan(scan):
    """Blocks that hold the curves of a set of scans."""
    keys = set(grid.curve_keys([SCAN_GRIDS[scan]], STUDY.by_step))
    return [block for block, members in BLOCKS.items() if keys.intersection(members)]


wildcard_constraints:
    block="[0-9a-f]{12}",
    scan="|".join(STUDY.scans) or "none",
    figure="|".join(STUDY.figures) or "none",
