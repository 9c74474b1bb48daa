"""What every job of the workflow does around its work: a log, and a record until it is done."""

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from pathlib import Path

from vibrissa.errors import DamagedTableError, VibrissaError
from vibrissa.files import write_atomically

# In place of the suffix of a log.
RECORD = ".failure.json"


@dataclass(frozen=True, kw_only=True)
class Failure:
    """Why a job is not done, as far as `vibrissa.pipeline.run` acts on it; the log has the words.

    Nothing is known of a job that was killed, or whose program has a mistake.
    """

    damaged: str | None = None  # path of a table that must be deleted, so that it is made anew
    errno: int | None = None  # of an error of the operating system


def failure(log: str | Path) -> Failure | None:
    """Return what the job with this log recorded; None if it is done, or has not begun."""
    path = Path(log).with_suffix(RECORD)
    return Failure(**json.loads(path.read_text() or "{}")) if path.is_file() else None


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
    record = Path(log).with_suffix(RECORD)
    try:
        record.write_text("")
        # Until the process ends, so that Python shows a mistake in the program there, too.
        sys.stdout = sys.stderr = open(log, "w", buffering=1, encoding="utf-8")
        yield
        record.unlink(missing_ok=True)
    except (VibrissaError, OSError) as error:
        # Damaged files and full disks are not mistakes in the program: no traceback.
        with suppress(OSError):
            print(f"error: {error}", file=sys.stderr)
            found = Failure(
                damaged=str(error.path) if isinstance(error, DamagedTableError) else None,
                errno=error.errno if isinstance(error, OSError) else None,
            )
            with write_atomically(record) as temporary:
                temporary.write_text(json.dumps(asdict(found)))
        sys.exit(1)
