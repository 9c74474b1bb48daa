# What all rules share: the study, its folder, and the version of the program.
import os
import shlex
import sys
from pathlib import Path

from snakemake.exceptions import WorkflowError

try:
    from vibrissa.errors import StudyError
    from vibrissa.pipeline import ownership, places
    from vibrissa.provenance import digest
    from vibrissa.study.reading import name_in, read_study
    from vibrissa.wording import figure_name
except ImportError as error:
    raise WorkflowError(
        f"the workflow's own Python package is missing or incomplete ({error}). Run make reproduce "
        f"in its folder, or install it for {sys.executable}: pip install 'vibrissa[workflow]'"
    ) from None

# Snakemake writes the path of its Python into shell commands as it stands: quoted, jobs start in a
# folder with a space in its name, too. A quoted path names no file.
if Path(sys.executable).is_file():
    sys.executable = shlex.quote(sys.executable)

# With --sdm conda the environment of a job finds the package by it (envs/vibrissa.post-deploy.sh).
os.environ.update(VIBRISSA_PACKAGES=str(places.PACKAGE.parent))


# For --sdm apptainer; docs/study.md says how the image is made.
container: "vibrissa.sif"


if not workflow.configfiles:  # with another one this directive would merge the two

    configfile: str(places.PAPER)


STUDY_FILE = places.near(Path(workflow.configfiles[-1]))
try:
    if name_in(STUDY_FILE):
        STUDY = read_study(STUDY_FILE, workflow.config_settings.config)
    else:  # of a workflow that has this one as a module, and its study as a part of its own
        STUDY = read_study(None, config)
    RESULTS = f"results/{STUDY.name}"
    ownership.check(Path(RESULTS), STUDY_FILE)
except StudyError as error:
    sys.exit("\n".join(error.mistakes))

# How the points are solved, and with which program: both stand in the `params` of a rule, so that
# Snakemake makes its output anew when they change.
SOLVER = {
    "contact": STUDY.contact.value,
    "section": STUDY.section.value,
    "method": STUDY.method.value,
}
SOLVING_CODE = digest(
    "numerics", "mechanics", "sticking", "study/axes.py", "study/chunks.py", "tables"
)
ALL_CODE = digest()


wildcard_constraints:
    chunk="|".join(STUDY.chunks),
