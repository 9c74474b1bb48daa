"""Atomic writing of files: a file is complete or absent."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from uuid import uuid4

# Names of temporary files, of which a killed writer leaves one.
TEMPORARY = ".*-*.tmp*"


@contextmanager
def write_atomically(path: Path) -> Iterator[Path]:
    """Write a temporary file with the target's suffix beside it, sync, and move into place.

    If the caller raises, the temporary file is removed and the target stays as it was.
    """
    temporary = path.with_name(f".{path.stem}-{uuid4().hex}.tmp{path.suffix}")
    # It is there from the beginning, so that a folder that cannot be written is found first.
    temporary.touch()
    try:
        yield temporary
        _sync(temporary)
        temporary.replace(path)
        _sync(path.parent)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def _sync(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
