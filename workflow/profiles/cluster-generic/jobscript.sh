#!/bin/sh
# properties = {properties}
# What the scheduler runs (Snakemake fills in the braces): the job, and then its exit status into
# the working directory, where status.sh reads it.
cd "${{SLURM_SUBMIT_DIR:-${{PBS_O_WORKDIR:-$SGE_O_WORKDIR}}}}" || exit 1
exit_status=.snakemake/cluster/${{SLURM_JOB_ID:-${{PBS_JOBID:-$JOB_ID}}}}.exit
rm -f "$exit_status" # of an attempt on a node that was lost
(
    {exec_job}
)
echo $? >"$exit_status"
