"""Snakemake's own command line, for `vibrissa.pipeline.run`: Ctrl-C while it loads is no error."""

import sys

try:
    from snakemake.cli import main

    sys.argv[0] = "snakemake"
    main()
except KeyboardInterrupt:
    sys.exit(130)
