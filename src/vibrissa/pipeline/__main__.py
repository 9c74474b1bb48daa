"""Snakemake with this workflow: ``python -m vibrissa.pipeline`` takes the options of ``snakemake``.

Ctrl-C, SIGTERM and the closing of the terminal end both Snakemake and its jobs.
"""

import os
import re
import shutil
import signal
import subprocess
import sys
from contextlib import suppress
from itertools import pairwise
from pathlib import Path

from vibrissa.errors import StudyError
from vibrissa.pipeline.places import HOME, SNAKEFILE
from vibrissa.study.yaml12 import loaded, text_of

ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
PROFILE = HOME / "workflow/profiles/default"
DIRECTORY = ("--directory", "-d")
DRY_RUN = ("--dry-run", "--dryrun", "-n")


def main(arguments: list[str]) -> int:
    """Run the workflow with Snakemake's arguments; return the exit status."""
    # Signals wait until the child is there. It inherits this, and lets them in when it is ready.
    signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)
    for number in ENDING:
        if signal.getsignal(number) is not signal.SIG_IGN:  # as nohup ignores SIGHUP
            signal.signal(number, _stop)
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


def unsuitable(arguments: list[str]) -> str:
    """Return what prevents a run with these arguments here, and what to type; or nothing."""
    if not os.access(".", os.W_OK) and not set(DIRECTORY) & set(arguments):
        return (
            f"error: {Path.cwd()} cannot be written, and results go there. Name another folder: "
            "python -m vibrissa.pipeline --directory FOLDER"
        )
    if _executor(arguments) == "slurm" and not shutil.which("sbatch"):
        if not set(DRY_RUN) & set(arguments):
            return (
                "error: there is no SLURM on this machine (no command sbatch). Run the command on "
                "the login node of a cluster, or without PROFILE on this machine"
            )
    for option, value in pairwise(arguments):
        if option == "--configfile" and Path(value).is_file():
            # Snakemake, which reads it first, would name neither the file nor the line.
            try:
                loaded(Path(value), text_of(Path(value)))
            except StudyError as error:
                return str(error)
    return ""


def _executor(arguments: list[str]) -> str:
    """Return the executor that the last profile names; empty for jobs on this machine."""
    options = ("--workflow-profile", "--profile")
    profiles = [value for option, value in pairwise(arguments) if option in options]
    for profile in reversed(profiles):
        with suppress(OSError):
            text = Path(profile, "config.yaml").read_text(encoding="utf-8")
            if found := re.search(r"^executor: *(\S+)", text, re.M):
                return found[1]
    return ""


def _stop(*_: object) -> None:
    """End the run; further signals have no effect while it ends."""
    for number in ENDING:
        signal.signal(number, lambda *_: None)
    raise KeyboardInterrupt


sys.exit(main(sys.argv[1:]))
