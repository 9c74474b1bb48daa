"""How the study is run: its jobs, what a run says and repairs, and the regression test.

No other package imports it.
"""

from vibrissa.extras import require

require("workflow", "snakemake", "grimp", "yaml")
