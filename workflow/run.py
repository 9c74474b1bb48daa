"""Run the study: python workflow/run.py [--configfile FILE] [any other Snakemake arguments].

`vibrissa.pipeline.run` says what it does beyond `snakemake`.
"""

import sys

try:
    from vibrissa.pipeline.run import main
except ImportError as error:  # it says what to install
    sys.exit(str(error))
except KeyboardInterrupt:  # while it loads, nothing is begun
    sys.exit(130)

sys.exit(main(sys.argv[1:]))
