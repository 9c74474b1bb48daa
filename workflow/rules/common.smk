# Shared by all rules: the study, its folder, and the version of the program.
import os
import shlex
import sys
from importlib.metadata import version
from pathlib import Path

from snakemake.exceptions import WorkflowError

try:
    from vibrissa.errors import VibrissaError
    from vibrissa.pipeline import outdated, ownership, places
    from vibrissa.provenance import digest
    from vibrissa.study.reading import read_study
    from vibrissa.wording import figure_name
except ImportError as error:
    raise WorkflowError(
        f"the workflow's own Python package is missing or incomplete ({error}). Run make reproduce "
        f"in its folder, or install it for {sys.executable}: pip install 'vibrissa[workflow]'"
    ) from None

# Snakemake inserts the path of its Python into shell commands without quotes. Quoted here, jobs also
# start if the path has a space. A path that is already quoted names no file, and stays as it is.
if Path(sys.executable).is_file():
    sys.executable = shlex.quote(sys.executable)

# With --sdm conda, envs/vibrissa.post-deploy.sh adds this folder to the environment of the jobs.
os.environ.update(VIBRISSA_PACKAGES=str(places.PACKAGE.parent))


# For --sdm apptainer; docs/study.md describes how to make the image.
container: "vibrissa.sif"


# As a module of another workflow: the config that it gives is the study.
INCLUDED = workflow.modifier.skip_configfile

if not workflow.configfiles:  # with a file given, this directive would merge both

    configfile: str(places.PAPER)


STUDY_FILE, *others = map(places.near, map(Path, workflow.configfiles or [workflow.main_snakefile]))
if others and not INCLUDED:  # the last would count, and nobody would notice
    sys.exit(f"give one study file with --configfile, not {STUDY_FILE} and {others[0]}")
try:
    if INCLUDED:
        STUDY = read_study(None, config)
    else:
        STUDY = read_study(STUDY_FILE, workflow.config_settings.config)
    RESULTS = f"results/{STUDY.name}"
    ownership.check(Path(RESULTS), STUDY_FILE)
    SOLVER = {"contact": STUDY.contact, "section": STUDY.section, "method": STUDY.method}
    if workflow.is_main_process:
        parts = {f"tables/{name}.parquet": STUDY.part(name) for name in STUDY.tables}
        for name, chunk in STUDY.chunks.items():
            parts[f"chunks/{name}.parquet"] = chunk.part(SOLVER)
        for name, chunk in STUDY.scan_chunks.items():
            for table in ("scans", "periods"):
                parts[f"scan_chunks/{table}/{name}.parquet"] = chunk.part(SOLVER)
        outdated.need_records(Path(RESULTS), parts)
except VibrissaError as error:
    sys.exit(str(error))

# Digests of the code, and versions of what it computes and draws with. They are `params` of rules,
# like `SOLVER`: when they change, Snakemake runs these rules again.
SOLVING_CODE = [
    digest(
        *("numerics", "mechanics", "sticking", "tables"),
        *(f"study/{name}.py" for name in ("axes", "chunks", "surfaces")),
    ),
    "Python {}.{}".format(*sys.version_info),
    *(f"{library} {version(library)}" for library in ("numpy", "scipy")),
]
SCANNING_CODE = [digest("scanning"), *SOLVING_CODE]
STUDY_CODE = [
    digest("study", "figures", "paper", "report", "explorer"),
    *SOLVING_CODE,
    *(f"{library} {version(library)}" for library in ("pandas", "pyarrow", "matplotlib")),
]


wildcard_constraints:
    chunk="|".join(STUDY.chunks),
    scan_chunk=".+",
