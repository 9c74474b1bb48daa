# A parameter study of the sticking period of a tapered rod. One study file decides what is
# computed: config.yaml, or the one given with --configfile, which then takes its place.
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.utils import min_version

from vibrissa.errors import ClusterError
from vibrissa.pipeline import slurm

min_version("9.0")

# A configfile directive alone would merge the two files.
if not workflow.overwrite_configfiles:

    configfile: Path(workflow.basedir, "config.yaml")


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
        f"{RESULTS}/tables/stiction.parquet",
        f"{RESULTS}/tables/scans.parquet" if STUDY.scans else [],
        f"{RESULTS}/tables/states.parquet" if STUDY.states else [],
        f"{RESULTS}/tables/comparisons.parquet" if STUDY.comparisons else [],
        f"{RESULTS}/tables/claims.parquet" if STUDY.claims else [],
        expand(f"{RESULTS}/figures/{{figure}}.{{ending}}", figure=STUDY.figures, ending=ENDINGS),
        f"{RESULTS}/figures/captions.md" if STUDY.figures else [],
        f"{RESULTS}/report.html",
