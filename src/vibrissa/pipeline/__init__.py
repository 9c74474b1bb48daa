"""Running a study: Snakemake with the project's profile, and the log of each job."""

from vibrissa.extras import require

require("workflow", "snakemake", "yaml")
