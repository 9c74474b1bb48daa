"""What happens in Snakemake's process when a run is stopped."""

import os
import signal
import time
from collections.abc import Callable
from types import FrameType
from typing import Any

_watched: list[tuple[Any, Callable[[float], str]]] = []
_started = time.time()


def watch(workflow: Any, kept: Callable[[float], str]) -> None:
    """Name the workflow that runs in this process, and what describes its finished results.

    Parameters
    ----------
    workflow : snakemake.workflow.Workflow
    kept : callable
        Takes the time at which the run began; returns one line on the results that are there.
    """
    _watched.append((workflow, kept))


def stop(number: int, frame: FrameType | None) -> None:
    """End the jobs on this machine, and Snakemake, without a word of either.

    Jobs that end in this way have failed for Snakemake, which would print their logs. Jobs on a
    cluster are cancelled by Snakemake itself.
    """
    for each in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(each, signal.SIG_IGN)
    screen = os.dup(2)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    os.killpg(0, signal.SIGTERM)
    if os.isatty(screen):
        os.write(screen, b"\x1b[?25h\n")  # a progress bar has hidden the cursor
    is_local = True
    for workflow, kept in _watched:
        os.write(screen, f"{kept(_started)}\n".encode())
        is_local = workflow.local_exec
    if is_local:
        # As after a kill: every file is complete or absent.
        os._exit(128 + number)
    raise KeyboardInterrupt
