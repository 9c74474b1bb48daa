"""The log of every job of the workflow; if a job fails, its log has the reason."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from vibrissa.errors import DamagedTableError, VibrissaError


@contextmanager
def logged(log: str | Path) -> Iterator[None]:
    """Redirect the output of a job to its log; on an error, log the reason and exit with status 1.

    Damaged tables are removed, and the log names them.
    """
    # Redirected until the process ends, so that a traceback goes to the log, too.
    sys.stdout = sys.stderr = output = open(log, "w", buffering=1, encoding="utf-8")
    try:
        yield
    except (VibrissaError, OSError, ExceptionGroup) as error:
        with suppress(OSError):  # a full disk has no room for the log either
            for one in error.exceptions if isinstance(error, ExceptionGroup) else (error,):
                print(f"error: {one}")
                if isinstance(one, DamagedTableError) and one.path.is_file():
                    one.path.unlink()
                    print(f"{one.path} is removed; run the same command to make it again")
            output.close()
        sys.exit(1)
