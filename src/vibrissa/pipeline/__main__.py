"""Snakemake with this workflow: ``python -m vibrissa.pipeline`` takes the options of ``snakemake``.

Ctrl-C, SIGTERM and the closing of the terminal end both Snakemake and its jobs.
"""

import os
import signal
import subprocess
import sys
from contextlib import suppress

from vibrissa.pipeline.places import HOME, SNAKEFILE

ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
PROFILE = HOME / "workflow/profiles/default"


def main(arguments: list[str]) -> int:
    """Run the workflow with Snakemake's arguments; return the exit status."""
    for number in ENDING:
        if signal.getsignal(number) is not signal.SIG_IGN:  # as nohup ignores SIGHUP
            signal.signal(number, _stop)
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(SNAKEFILE)]
    command += ["--workflow-profile", str(PROFILE), *arguments]  # the last profile wins
    child = None
    try:
        # In a session of its own Snakemake gets each signal once.
        child = subprocess.Popen(command, stdin=subprocess.DEVNULL, start_new_session=True)
        return child.wait()
    except KeyboardInterrupt:
        if child is not None:
            # On SIGINT Snakemake removes its jobs from a cluster's queue, but waits for local jobs.
            # SIGTERM ends local jobs, and also, silently, a Snakemake that is still loading.
            with suppress(ProcessLookupError):
                os.killpg(child.pid, signal.SIGTERM)
                child.send_signal(signal.SIGINT)
            child.wait()
    print("Stopped. Finished results are kept: run the same command to resume.", file=sys.stderr)
    return 128 + signal.SIGINT


def _stop(*_: object) -> None:
    """End the run; further signals have no effect while it ends."""
    for number in ENDING:
        signal.signal(number, lambda *_: None)
    raise KeyboardInterrupt


sys.exit(main(sys.argv[1:]))
