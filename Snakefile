# A parameter study of the sticking period of a tapered rod. One study file defines what is
# computed: config.yaml, or the file given with --configfile in its place.
#
#   study file -> grids    -> chunks -> stiction       -> figures, claims, report
#              -> scans    -> chunks -> scans, periods ->
#              -> readings -> chunks -> friction       ->
#              -> states, comparisons                  ->
#
# docs/architecture.md follows a grid point and a step of a scan through the code.
from snakemake.utils import min_version

min_version("9.0")


include: "workflow/rules/common.smk"
include: "workflow/rules/tables.smk"
include: "workflow/rules/results.smk"


onstart:
    try:
        ownership.claim(FOLDER, STUDY_FILE)
    except (VibrissaError, OSError) as error:
        sys.exit(str(error))


onsuccess:
    # With --touch a run succeeds although files are missing.
    asked = {job.name for job in workflow.dag.jobs}
    if "summary" in asked and (FOLDER / "summary.txt").is_file():
        print((FOLDER / "summary.txt").read_text(encoding="utf-8"), end="", file=sys.stderr)
    if "report" in asked and (FOLDER / "report.html").is_file():
        print(f"Report: {FOLDER}/report.html", file=sys.stderr)
    if reason := why_unknown():
        print(f"The commit of the code is not known: {reason}.", file=sys.stderr)


rule all:
    default_target: True
    input:
        expand(f"{RESULTS}/{{file}}", file=STUDY.results),
