"""Snakemake, started by `vibrissa.pipeline` with all signals blocked."""

import gc
import signal
import sys

from vibrissa.pipeline import stopping

ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def main() -> None:
    """Run Snakemake with the arguments of the command line."""
    signal.signal(signal.SIGINT, stopping.stop)
    # What came before waits until now, and ends the run without a traceback.
    signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING)
    # The modules stay as long as the process. To search them for unused objects, while they load
    # and later, takes a third of the time of the start.
    gc.disable()
    from snakemake.cli import main as snakemake

    gc.freeze()
    gc.enable()
    sys.argv[0] = "snakemake"
    snakemake()


if __name__ == "__main__":
    main()
