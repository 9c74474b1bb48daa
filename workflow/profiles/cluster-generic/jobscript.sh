#!/bin/sh
# properties = {properties}
# The scheduler runs this script (Snakemake fills in the braces). It runs the job, then writes its
# exit status into the working directory, where status.sh reads it.
cd "${{SLURM_SUBMIT_DIR:-${{PBS_O_WORKDIR:-$SGE_O_WORKDIR}}}}" || exit 1
exit_status=.snakemake/cluster/${{SLURM_JOB_ID:-${{PBS_JOBID:-$JOB_ID}}}}.exit
rm -f "$exit_status" # left by an earlier attempt on a lost node
(
    {exec_job}
)
echo $? >"$exit_status"
