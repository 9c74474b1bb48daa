"""Files that are either there whole or not there."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

# Names of temporary files, of which a killed writer leaves one.
TEMPORARY = ".*-*.tmp*"


@contextmanager
def write_atomically(path: Path) -> Iterator[Path]:
    """Write under a temporary name beside the target, sync, and move into place.

    Parameters
    ----------
    path : Path
        File to be written; its folder exists.

    Yields
    ------
    Path
        Temporary file with the target's suffix, to be written by the caller. If the caller raises,
        it is removed and the target stays as it was.
    """
    handle, name = tempfile.mkstemp(
        dir=path.parent, prefix=f".{path.stem}-", suffix=f".tmp{path.suffix}"
    )
    temporary = Path(name)
    try:
        yield temporary
        _sync(temporary)
        # mkstemp makes files private; give the result the rights that the user's files have.
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)
        temporary.replace(path)
        _sync(path.parent)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
    finally:
        os.close(handle)


def _sync(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
