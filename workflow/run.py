"""Run the study: python workflow/run.py [--configfile FILE] [any other Snakemake arguments].

`vibrissa.pipeline.run` says what it does beyond `snakemake`.
"""

import sys

from vibrissa.pipeline.run import main

sys.exit(main(sys.argv[1:]))
