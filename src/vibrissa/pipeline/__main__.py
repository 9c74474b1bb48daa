"""Snakemake with this workflow: ``python -m vibrissa.pipeline`` takes the options of ``snakemake``.

Ctrl-C, SIGTERM and the closing of the terminal end both Snakemake and its jobs.
"""

import signal
import subprocess
import sys
from contextlib import suppress

from vibrissa.pipeline.places import HOME, SNAKEFILE

ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
PROFILE = HOME / "workflow/profiles/default"


def main(arguments: list[str]) -> int:
    """Run the workflow with Snakemake's arguments; return the exit status."""
    # Signals wait until the child is there. It inherits this, and lets them in when it is ready.
    signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)
    for number in ENDING:
        if signal.getsignal(number) is not signal.SIG_IGN:  # as nohup ignores SIGHUP
            signal.signal(number, _stop)
    # It takes some tenths of a second to load, in which a signal would end the program silently.
    from vibrissa.pipeline.suitable import unsuitable

    if problem := unsuitable(arguments):
        print(problem, file=sys.stderr)
        return 1
    command = [sys.executable, "-m", "vibrissa.pipeline.child", "--snakefile", str(SNAKEFILE)]
    command += ["--workflow-profile", str(PROFILE), *arguments]  # the last profile wins
    # In a session of its own Snakemake gets each signal once.
    child = subprocess.Popen(command, stdin=subprocess.DEVNULL, start_new_session=True)
    try:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDING)
        return child.wait()
    except KeyboardInterrupt:
        # See `vibrissa.pipeline.stopping.stop`.
        with suppress(ProcessLookupError):
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
