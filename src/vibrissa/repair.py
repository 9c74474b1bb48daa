"""What killed runs, full disks and accidents leave in a study's folder, found and removed."""

import fcntl
import os
import re
import shutil
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path

# The folders that a study's rules write to, below results/<study>/.
FOLDERS = ("blocks", "tables", "figures", "logs", "benchmarks")
# How a job says that a table is not what it should be (see `vibrissa.tables.read`).
NAMED = re.compile(r"error: (\S+\.parquet) .*delete it and run again, it is made anew")
# What failed has been removed when one looks, so a full disk has some room again.
LEAST_SPACE = 1024**2
FULL = re.compile("No space left on device|Disk quota exceeded")
MAGIC = b"PAR1"


def remove_leftovers(folder: Path) -> int:
    """Remove temporary files of `vibrissa.files.write_atomically` that nobody writes any more.

    Parameters
    ----------
    folder : Path
        Folder of a study; it need not exist.

    Returns
    -------
    int
        How many there were.
    """
    removed = 0
    for path in folder.rglob(".*-*.tmp*"):
        # Who writes holds a lock: a job of a run that was killed may still be at work.
        with suppress(OSError), path.open("r+b") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            path.unlink()
            removed += 1
    return removed


def cut_short(folder: Path) -> Iterator[Path]:
    """Files of a study that are empty or have no end, and its tables if they are damaged anywhere.

    Blocks are not read through, as there may be thousands of them: who needs one, does so.

    Parameters
    ----------
    folder : Path
        Folder of a study; it need not exist.

    Yields
    ------
    Path
    """
    for path in sorted(folder.glob("figures/[!.]*")):
        if path.is_file() and path.stat().st_size == 0:
            yield path
    for path in sorted(folder.glob("blocks/*/[!.]*.parquet")):
        # What cannot be opened, or is gone by now, is not known to be damaged.
        with suppress(OSError):
            if not _has_an_end(path):
                yield path
    yield from damaged(sorted(folder.glob("tables/[!.]*.parquet")))


def damaged(paths: Sequence[Path]) -> Iterator[Path]:
    """Those of some tables that are damaged or do not belong where they are.

    Parameters
    ----------
    paths : sequence of Path
        Parquet files.

    Yields
    ------
    Path
    """
    if not paths:
        return
    # Only who has tables waits for pyarrow.
    from vibrissa import tables

    for path in paths:
        try:
            tables.check_file(path)
        except tables.TableError as error:
            # Not a table that merely cannot be opened.
            if NAMED.match(f"error: {error}"):
                yield path


def _has_an_end(path: Path) -> bool:
    with path.open("rb") as file:
        start = file.read(len(MAGIC))
        file.seek(max(0, path.stat().st_size - len(MAGIC)))
        return start == file.read() == MAGIC


def misplaced(folder: Path) -> str:
    """Tell what stands in the way of a study's folders.

    Parameters
    ----------
    folder : Path
        Folder of a study; it need not exist.

    Returns
    -------
    str
        A message with what to do, or nothing.
    """
    for path in (folder.parent, folder, *(folder / name for name in FOLDERS)):
        if os.path.lexists(path) and not path.is_dir():
            return f"{path} is a file where a folder is needed; move it away and run again."
    return ""


def obstacles(folder: Path, said: str) -> list[str]:
    """Tell why nothing could be written to a study's folder, with what to do.

    Parameters
    ----------
    folder : Path
        Folder of a study; it need not exist.
    said : str
        What was said by what failed.

    Returns
    -------
    list of str
        Empty if there is space and permission.
    """
    candidates = (Path.cwd(), folder.parent, folder, *(folder / name for name in FOLDERS))
    places = [path for path in candidates if path.is_dir()]
    found = []
    full = [path for path in places if shutil.disk_usage(path).free < LEAST_SPACE]
    if full or FULL.search(said):
        what = f"The disk of {full[0] if full else folder} (or your share of it)"
        found.append(f"{what} is full; make space and run the same command again.")
    for path in places:
        if not os.access(path, os.W_OK):
            found.append(f"{path} cannot be written to; allow it and run the same command again.")
            break
    return found
