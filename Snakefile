# A parameter study of the sticking period of a tapered rod. One study file decides what is
# computed: config.yaml, or the one given with --configfile, which then takes its place.
import sys
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.utils import min_version

min_version("9.0")

HERE = Path(workflow.current_basedir.get_path_or_uri(secret_free=True))

try:
    from vibrissa.errors import ClusterError
    from vibrissa.pipeline import slurm
except ImportError as error:
    raise WorkflowError(
        f"the workflow's own Python package is missing or incomplete ({error}). Run make reproduce "
        f"in {HERE}, or install it for {sys.executable}: pip install '{HERE}[workflow]'"
    ) from None

# A configfile directive alone would merge the two files.
if not workflow.overwrite_configfiles:

    configfile: HERE / "config.yaml"


include: "workflow/rules/common.smk"
include: "workflow/rules/solve.smk"
include: "workflow/rules/scans.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/claims.smk"
include: "workflow/rules/report.smk"
include: "workflow/rules/check.smk"


onstart:
    if workflow.executor_plugin.name == "slurm":
        try:
            slurm.watch(workflow)
        except ClusterError as error:
            raise WorkflowError(str(error)) from None


rule all:
    default_target: True
    input:
        expand(f"{RESULTS}/{{file}}", file=STUDY.results),
