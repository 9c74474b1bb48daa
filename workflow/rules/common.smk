# What all rules share: the checked study, its folder, and the blocks its curves are solved in.
import os
import shlex
import sys

import yaml

import vibrissa
from vibrissa.errors import PlanError, StudyError
from vibrissa.pipeline import places
from vibrissa.pipeline.blocks import (
    ends_of_gaps,
    gaps_of_block,
    grids_of_blocks,
    known_blocks,
    planned_blocks,
)
from vibrissa.pipeline.effort import effort
from vibrissa.pipeline.sources import sources_file
from vibrissa.study import costs
from vibrissa.study.boxes import meets, size
from vibrissa.study.codec import (
    encode_box,
    encode_gaps,
    encode_grid,
    encode_refinement,
    encode_values,
)
from vibrissa.study.reading import read_study, retyped

# Snakemake (9.27) writes the path of its Python into shell commands, of `script:` rules and of cluster
# jobs, as it stands. Without quotes no job would start in a folder with a space in its name. A path
# that is quoted already, by an earlier reading of this file, names no file.
if Path(sys.executable).is_file():
    sys.executable = shlex.quote(sys.executable)

# For envs/vibrissa.post-deploy.sh.
os.environ.update(VIBRISSA_PACKAGES=str(Path(vibrissa.__file__).parents[1]))


# The image that `--sdm apptainer` runs jobs in, below the working directory as Snakemake takes no
# path with a space; docs/study.md says how it is made.
container: "vibrissa.sif"


for key, value in workflow.config_settings.config.items():
    if config.get(key) == value:
        config[key] = retyped(value)

try:
    given = workflow.overwrite_configfiles or workflow.configfiles[-1:]
    STUDY = read_study([Path(path) for path in given], config)
except StudyError as error:
    sys.exit("\n".join(error.mistakes))

RESULTS = f"results/{STUDY.name}"

# On a cluster `curves` and `points` of a block are one job, so that they wait in the queue once. Not
# where curves are added: points then need curves of other blocks, too, and all blocks would be one job.
GROUP = None if any(one.curve_axes for one in STUDY.refinements.values()) else "block"


def study_file(*sections):
    """Part of the study file that a table answers, for its metadata."""
    keys = ("study", "contact", "section", "method", *sections)
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


def is_solved(block):
    """Whether a block's curves are there."""
    return Path(RESULTS, "blocks", STUDY.blocks_name, f"{block}.curves.parquet").exists()


PLAN = Path(RESULTS, "blocks", f"{STUDY.blocks_name}.json")
try:
    if workflow.is_main_process:
        BLOCKS = planned_blocks(
            PLAN,
            STUDY.curves,
            STUDY.curves_per_job,
            is_solved,
            remember=not workflow.output_settings.dryrun,
        )
    else:  # jobs take the plan as it stands
        BLOCKS = known_blocks(PLAN)
except PlanError as error:
    raise WorkflowError(str(error)) from None

if workflow.is_main_process:
    print(
        effort(STUDY, BLOCKS, is_solved, workflow.resource_settings.cores or 1),
        file=sys.stderr,
        flush=True,
    )

# Blocks whose curves have grid points on them; a scan may have blocks of its own.
HAS_POINTS = [meets(grid.curves(STUDY.method.by_step)) for grid in STUDY.point_grids.values()]
POINT_BLOCKS = [
    block
    for block, curves in BLOCKS.items()
    if any(has_points(curves) for has_points in HAS_POINTS)
]

# Parts of the grids that lie on the curves of a block.
GRIDS_OF = grids_of_blocks(STUDY.point_grids)

# At most so many points are read off a curve.
POINTS_ON_CURVE = STUDY.points_on_curve


# The machine where the workflow runs collects the table; on a cluster other jobs have other machines.
SETTINGS = workflow.resource_settings
COLLECTING_THREADS = costs.collecting_threads(
    POINTS_ON_CURVE * sum(size(BLOCKS[block]) for block in POINT_BLOCKS),
    min(filter(None, (SETTINGS.cores, SETTINGS.local_cores)), default=1),
)


def minutes_of_block(block):
    """What solving the curves of a block may take."""
    return costs.minutes(costs.curve_seconds(BLOCKS[block], STUDY.method, STUDY.contact))


def megabytes_of_blocks(blocks):
    """What a job may need that holds the curves of some blocks."""
    return costs.megabytes(sum(size(BLOCKS[block]) for block in blocks))


def gaps_of(block):
    """Gaps that begin at curves of a block and may get curves in between."""
    return gaps_of_block(BLOCKS[block], STUDY.point_grids, STUDY.refinements)


def refining_of_block(block):
    """How points are added to the grids on the curves of a block, and in which gaps curves may be."""
    names = GRIDS_OF(BLOCKS[block]).keys() & STUDY.refinements.keys() if STUDY.refinements else []
    return {
        "refinements": {name: encode_refinement(STUDY.refinements[name]) for name in sorted(names)},
        "gaps": {name: encode_gaps(gaps) for name, gaps in gaps_of(block).items()},
    }


def neighbours_of_block(block):
    """Other blocks that hold the curves at which these gaps end."""
    gaps = gaps_of(block)
    if not gaps:  # as of most studies, of which some have very many blocks
        return []
    ends = list(map(meets, ends_of_gaps(BLOCKS[block], STUDY.point_grids, gaps)))
    return [
        other
        for other, curves in BLOCKS.items()
        if other != block and any(has_end(curves) for has_end in ends)
    ]


# So many curves are expected, at most, to be added for each curve of a block where some may be.
ADDED_CURVES = 4


def seconds_of_points(block):
    """What reading the points of a block may take, and solving the curves that are added."""
    added = ADDED_CURVES if gaps_of(block) else 0
    curves = BLOCKS[block]
    solving = added * costs.curve_seconds(curves, STUDY.method, STUDY.contact)
    return solving + (1 + added) * costs.POINT * POINTS_ON_CURVE * size(curves)


def blocks_of_scan(scan):
    """Blocks that hold the curves of a set of scans."""
    is_needed = meets(STUDY.scan_grids[scan].curves(STUDY.method.by_step))
    return [block for block, curves in BLOCKS.items() if is_needed(curves)]


wildcard_constraints:
    block="[0-9a-f]{12}",
    scan="|".join(STUDY.scans) or "none",
    figure="|".join(STUDY.figures) or "none",
