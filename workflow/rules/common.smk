# Shared by all rules: the study, its folder, and the version of the program.
import os
import shlex
import sys
from pathlib import Path

from snakemake.exceptions import WorkflowError

try:
    from vibrissa.errors import VibrissaError
    from vibrissa.pipeline import outdated, ownership, places, stopping, suitable
    from vibrissa.provenance import (
        display_code,
        reading_code,
        scanning_code,
        solver_code,
        why_unknown,
    )
    from vibrissa.study import yaml12
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


# A module of another workflow has no file of its own, but the Snakefile that includes it.
study_files = [
    places.near(Path(name)) for name in workflow.configfiles or [workflow.main_snakefile]
]
STUDY_FILE, *others = study_files
if others and not INCLUDED:  # the last would count, and nobody would notice
    sys.exit(f"give one study file with --configfile, not {STUDY_FILE} and {others[0]}")
# Jobs need not check again what the process that started them has checked.
check = suitable.readings if workflow.is_main_process else None
try:
    if INCLUDED:
        changes = yaml12.as_written(config, map(Path, workflow.configfiles))
        STUDY = read_study(None, changes, check)
    else:
        changes = yaml12.changes_of(workflow.config_settings.config_args or ())
        STUDY = read_study(STUDY_FILE, changes, check)
    RESULTS = f"results/{STUDY.name}"
    # In a module with a prefix the folder is elsewhere; Snakemake adds the prefix to rules alone.
    FOLDER = Path(workflow.modifier.path_modifier.replace_prefix(RESULTS))
    ownership.check(FOLDER, STUDY_FILE)
    # Files to be made again. Jobs on other machines do what this process decides.
    OUTDATED = outdated.to_make_again(FOLDER, STUDY) if workflow.is_main_process else set()
    if workflow.is_main_process:
        stopping.watch(workflow, lambda began: outdated.kept(FOLDER, STUDY, OUTDATED, began))
except VibrissaError as error:
    sys.exit(str(error))

# The code and its libraries. They are `params` of rules, like the solver: when they change, Snakemake
# runs these rules again.
SOLVING_CODE = solver_code()
SCANNING_CODE = scanning_code()
READING_CODE = reading_code()
DISPLAY_CODE = display_code()
MARKS = outdated.marks(STUDY)


def force_outdated(*names):
    """Return an input function that adds no input file, but has outdated outputs made again.

    Snakemake calls the functions of a rule's inputs only for jobs that are asked for: the outputs
    of these jobs, `names` in the study's folder, are forced if they are outdated. Snakemake itself
    compares with its own records, which results from elsewhere do not have.
    """

    def no_files(wildcards):
        paths = {str(FOLDER / name.format(**wildcards)) for name in names}
        workflow.dag.forcefiles.update(paths & OUTDATED)
        return []

    return no_files


wildcard_constraints:
    chunk=".+",
    scan_chunk=".+",
    reading_chunk=".+",
