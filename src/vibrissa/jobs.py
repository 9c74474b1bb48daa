"""What every job of the workflow does around its work."""

import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path

from vibrissa.tables import TableError


@contextmanager
def logged(log: str | Path) -> Iterator[None]:
    """Send what a job prints to its log, and end it with status 1 and the reason if it fails.

    Parameters
    ----------
    log : str or Path
        Log file of the job.

    Yields
    ------
    None
    """
    with open(log, "w", buffering=1, encoding="utf-8") as file:
        with redirect_stdout(file), redirect_stderr(file):
            try:
                yield
            except (TableError, OSError) as error:
                # Damaged files and full disks are not mistakes in the code: no traceback.
                print(f"error: {error}", file=sys.stderr)
                sys.exit(1)
            except Exception:
                traceback.print_exc()
                sys.exit(1)
