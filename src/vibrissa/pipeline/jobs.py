"""The log of every job of the workflow; if a job fails, its log has the reason."""

import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from vibrissa.errors import DamagedTableError, VibrissaError


@contextmanager
def logged(log: str | Path) -> Iterator[None]:
    """Redirect the output of a job to its log; on an error, log the reason and exit with status 1.

    Damaged tables are removed, and the log names them. A full disk may have no room for the log:
    then the reason goes to the screen of the run.
    """
    # What a job has imported and made stays until it ends. A search for unused objects, which takes
    # long, need not visit it: neither now nor at the end.
    gc.freeze()
    try:
        # Redirected until the process ends, so that a traceback goes to the log, too.
        sys.stdout = sys.stderr = open(log, "w", buffering=1, encoding="utf-8")
        yield
        gc.freeze()
    except (VibrissaError, OSError, ExceptionGroup) as error:
        reasons = "\n".join(_reasons(error))
        try:
            print(reasons, flush=True)
        except OSError:
            sys.stdout, sys.stderr = sys.__stdout__, sys.__stderr__
            print(reasons, file=sys.stderr)
        sys.exit(1)


def _reasons(error: Exception) -> Iterator[str]:
    """Say what is wrong, and remove damaged tables."""
    for one in error.exceptions if isinstance(error, ExceptionGroup) else (error,):
        yield f"error: {one}"
        if isinstance(one, DamagedTableError) and one.path.is_file():
            one.path.unlink()
            yield f"{one.path} is removed; run the same command to make it again"
