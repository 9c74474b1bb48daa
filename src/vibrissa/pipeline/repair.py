"""Find what killed runs, full disks and accidents leave in a study's folder.

In all functions `folder` is the folder of a study, which need not exist.
"""

import base64
import errno
import fcntl
import os
import shutil
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path

from vibrissa.errors import DamagedTableError, TableError
from vibrissa.pipeline.jobs import RECORD
from vibrissa.wording import counted

# The folders that a study's rules write to, below results/<study>/.
FOLDERS = ("blocks", "tables", "figures", "logs", "benchmarks")
# Bytes. A full disk has a little room again once the files of a failed job are removed.
LEAST_SPACE = 1024**2
# The operating system's errors that mean a full disk, or a user's share of it.
FULL = frozenset({errno.ENOSPC, errno.EDQUOT})
MAGIC = b"PAR1"
# Where Snakemake keeps a record of each result that it made, under the encoded path; and its locks.
RECORDS, LOCKS = Path(".snakemake/metadata"), Path(".snakemake/locks")
# Files that a message names.
FEW = 3


def remove_leftovers(folder: Path) -> None:
    """Remove records of failures, and the temporary files that killed writers left."""
    for path in folder.glob(f"logs/**/*{RECORD}"):
        with suppress(OSError):
            path.unlink()
    for path in folder.rglob(".*-*.tmp*"):
        # A writer holds a lock: a job of a run that was killed may still be at work.
        with suppress(OSError), path.open("r+b") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            path.unlink()


def cut_short(folder: Path) -> Iterator[Path]:
    """Yield figures that are empty, blocks that have no end, and tables that are damaged anywhere.

    There may be thousands of blocks: only a job that needs a block reads all of it.
    """
    for path in sorted(folder.glob("figures/[!.]*")):
        if path.is_file() and path.stat().st_size == 0:
            yield path
    for path in sorted(folder.glob("blocks/*/[!.]*.parquet")):
        # A file that cannot be opened, or is gone by now, may be sound.
        with suppress(OSError):
            if not _has_an_end(path):
                yield path
    yield from damaged(sorted(folder.glob("tables/[!.]*.parquet")))


def damaged(paths: Sequence[Path]) -> Iterator[Path]:
    """Yield those of some tables that are damaged or do not belong where they are."""
    if not paths:
        return
    # It imports pyarrow, which takes time.
    from vibrissa.tables import store

    for path in paths:
        try:
            store.check_file(path)
        except DamagedTableError:
            yield path
        except TableError:
            pass  # a file that cannot be opened may be sound


def _has_an_end(path: Path) -> bool:
    with path.open("rb") as file:
        start = file.read(len(MAGIC))
        file.seek(max(0, path.stat().st_size - len(MAGIC)))
        return start == file.read() == MAGIC


def misplaced(folder: Path) -> str:
    """Tell what stands in the way of a study's folders, and what to do; or return nothing."""
    for path in (folder.parent, folder, *(folder / name for name in FOLDERS)):
        if os.path.lexists(path) and not path.is_dir():
            return f"{path} is a file where a folder is needed; move it away and run again."
    return ""


def others(folder: Path, made: Collection[str]) -> str:
    """Tell which files in a study's folder are not its results, or return nothing.

    They are of an earlier study file, or a person's own: nothing removes them.

    Parameters
    ----------
    folder : Path
    made : collection of str
        `vibrissa.study.model.Study.results`.
    """
    paths = [*folder.glob("tables/[!.]*"), *folder.glob("figures/[!.]*"), folder / "claims.md"]
    names = sorted(path.relative_to(folder).as_posix() for path in paths if path.is_file())
    names = [name for name in names if name not in made]
    if not names:
        return ""
    shown = ", ".join(names[:FEW]) + (" ..." if len(names) > FEW else "")
    return (
        f"Not of the study file as it is now, and in neither report nor archive: {shown} "
        f"({counted(len(names), 'file')} in {folder}; remove what you do not need)"
    )


def without_record(folder: Path) -> Path | None:
    """Find a table or block of points of which Snakemake has no record here; None if it has all.

    It would trust such a file: a record alone says whether it is of the study file as it is now.

    Parameters
    ----------
    folder : Path
        As Snakemake names it.
    """
    kinds = "tables/[!.]*.parquet", "blocks/*/[!.]*.points.parquet"
    paths = (path for kind in kinds for path in sorted(folder.glob(kind)))
    return next((path for path in paths if not _has_record(path)), None)


def _has_record(path: Path) -> bool:
    name = base64.urlsafe_b64encode(path.as_posix().encode()).decode()
    return (RECORDS / name).is_file()


def obstacles(folder: Path, errors: Iterable[int | None] = ()) -> list[str]:
    """Tell why nothing could be written to a study's folder, and what to do.

    Parameters
    ----------
    folder : Path
    errors : iterable of int or None, optional
        Numbers of the operating system's errors that were met.

    Returns
    -------
    list of str
        Empty if there is space and permission.
    """
    candidates = (Path.cwd(), folder.parent, folder, *(folder / name for name in FOLDERS))
    places = [path for path in candidates if path.is_dir()]
    found = []
    full = [path for path in places if shutil.disk_usage(path).free < LEAST_SPACE]
    if full or FULL.intersection(errors):
        what = f"The disk of {full[0] if full else folder} (or your share of it)"
        found.append(f"{what} is full; make space and run the same command again.")
    for path in places:
        if not os.access(path, os.W_OK):
            found.append(f"{path} cannot be written to; allow it and run the same command again.")
            break
    return found
