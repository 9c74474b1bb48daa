"""How a study is run: what its jobs are, what a run says, and what it repairs.

No other package imports it.
"""

from vibrissa.extras import require

require("workflow", "snakemake", "grimp", "yaml")
