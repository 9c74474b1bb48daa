"""How a study is run: Snakemake with our profile, and what a job does around its work."""

from vibrissa.extras import require

require("workflow", "snakemake", "yaml")
