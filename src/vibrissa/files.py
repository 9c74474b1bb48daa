"""Atomic writing of files: a file is complete or absent."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from uuid import uuid4

# Pattern of the names of temporary files; a killed process leaves such a file behind.
TEMPORARY = ".*-*.tmp*"


@contextmanager
def write_atomically(path: Path) -> Iterator[Path]:
    """Yield the path of a temporary file beside the target, then move the file to the target.

    The temporary file has the target's suffix. If the caller raises an exception, the temporary
    file is removed, and the target stays as it was.
    """
    temporary = path.with_name(f".{path.stem}-{uuid4().hex}.tmp{path.suffix}")
    # Create the file at once, so that an unwritable folder is found before any work is done.
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
