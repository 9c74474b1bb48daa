"""Snakemake's own command line, for `vibrissa.pipeline.run`: Ctrl-C while it loads is no error."""

import signal
import sys

try:
    from snakemake.cli import main

    sys.argv[0] = "snakemake"
    main()
except KeyboardInterrupt:
    sys.exit(130)
finally:
    # All is done; Python's own end is not to be interrupted.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
