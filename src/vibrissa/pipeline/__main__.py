"""Snakemake with this workflow: ``python -m vibrissa.pipeline`` takes the options of ``snakemake``.

Ctrl-C, SIGTERM and the closing of the terminal end both Snakemake and its jobs.
"""

import os
import signal
import subprocess
import sys
from contextlib import suppress

from vibrissa.pipeline.places import HOME, SNAKEFILE

PROFILE = HOME / "workflow/profiles/default"


def main(arguments: list[str]) -> int:
    """Run the workflow with Snakemake's arguments; return the exit status."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    if signal.getsignal(signal.SIGHUP) is signal.SIG_DFL:  # nohup ignores it
        signal.signal(signal.SIGHUP, signal.default_int_handler)
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(SNAKEFILE)]
    command += ["--workflow-profile", str(PROFILE), *arguments]  # the last profile wins
    child = None
    try:
        # In a session of its own Snakemake gets each signal once.
        child = subprocess.Popen(command, stdin=subprocess.DEVNULL, start_new_session=True)
        return child.wait()
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    if child is not None:
        # On SIGINT Snakemake removes its jobs from a cluster's queue, but waits for local jobs.
        # SIGTERM ends local jobs, and also, silently, a Snakemake that is still loading.
        with suppress(ProcessLookupError):
            os.killpg(child.pid, signal.SIGTERM)
            child.send_signal(signal.SIGINT)
        child.wait()
    print("Stopped. Finished results are kept: run the same command to resume.", file=sys.stderr)
    return 128 + signal.SIGINT


sys.exit(main(sys.argv[1:]))
