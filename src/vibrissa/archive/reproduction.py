"""Whether an archived study makes its results again, bit for bit; and if not, what differs."""

import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from rocrate.rocrate import ROCrate

from vibrissa.archive.crate import CHECKSUMS, RUN, ArchiveError, checksum

# It holds times and the machine: it is made again, but not the same.
TIMED = "report.html"


def checksums(folder: Path) -> dict[str, str]:
    """Read the checksums of an unpacked archive, by file.

    Raises
    ------
    ArchiveError
        If this is not one.
    """
    path = folder / CHECKSUMS
    if not path.is_file():
        raise ArchiveError(
            f"{folder} is not an unpacked archive: it has no {CHECKSUMS}; make archive makes one"
        )
    lines = [line.partition("  ") for line in path.read_text(encoding="utf-8").splitlines()]
    return {name: recorded for recorded, _, name in lines}


def damaged(folder: Path, recorded: Mapping[str, str]) -> Iterator[str]:
    """Yield the files of an unpacked archive that are gone or changed."""
    for name, sum in recorded.items():
        path = folder / name
        if not path.is_file():
            yield f"{name} is gone"
        elif checksum(path) != sum:
            yield f"{name} was changed"


def study_file(folder: Path) -> str:
    """Name of the study file of an unpacked archive."""
    return unquote(ROCrate(folder).get(RUN)["object"].id)


def run_again(folder: Path, recorded: Mapping[str, str], scratch: Path) -> int:
    """Copy an unpacked archive without its results, and run its study there.

    Parameters
    ----------
    folder : Path
        The unpacked archive.
    recorded : mapping of str
        Its checksums by file.
    scratch : Path
        Empty folder.

    Returns
    -------
    int
        Exit status of the run.
    """
    for name in recorded:
        if not name.startswith("results/"):
            (scratch / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(folder / name, scratch / name)
    command = [sys.executable, "workflow/run.py", "--configfile", study_file(folder)]
    return subprocess.run(command, cwd=scratch, check=False).returncode


def differences(folder: Path, scratch: Path, recorded: Mapping[str, str]) -> Iterator[str]:
    """Compare the results that were made again with those of the archive.

    Parameters
    ----------
    folder, scratch : Path
        The unpacked archive, and where its study was run again.
    recorded : mapping of str
        Checksums by file.

    Yields
    ------
    str
        A line for each result that is not the same, bit for bit; the report is left out.
    """
    for name, sum in recorded.items():
        path = scratch / name
        if not name.startswith("results/") or path.name == TIMED:
            continue
        if not path.is_file():
            yield f"{name} was not made"
        elif checksum(path) != sum:
            if path.suffix == ".parquet":
                yield f"{name}: {_table_difference(folder / name, path)}"
            else:
                yield f"{name} has other bytes"


def _largest_change(old: pa.Table, new: pa.Table) -> float | None:
    """Find the largest change, relative to the largest number of its column.

    None where other things than numbers differ, or a number stands where there was none.
    """
    sizes = []
    for one, other in zip(old.itercolumns(), new.itercolumns(), strict=True):
        if not pa.types.is_floating(one.type):
            return None
        was, now = (column.to_pandas().to_numpy() for column in (one, other))
        known = np.isfinite(was)
        if not known.any() or (known != np.isfinite(now)).any():
            return None
        largest = np.abs([was[known], now[known]]).max()
        sizes.append(float(np.abs(now[known] - was[known]).max() / largest))
    return max(sizes)


def _table_difference(one: Path, other: Path) -> str:
    """Say in which columns two tables differ, or that only what stands beside them does."""
    old, new = pq.read_table(one), pq.read_table(other)
    if old.column_names != new.column_names or len(old) != len(new):
        return f"rows and columns were {old.shape} and are {new.shape}"
    columns = [name for name in old.column_names if not old[name].equals(new[name])]
    if columns:
        size = _largest_change(old.select(columns), new.select(columns))
        rounding = f", by {size:.1g} of the largest number of a column at most" if size else ""
        return f"other values in {', '.join(columns)}{rounding}"
    was, now = old.schema.metadata or {}, new.schema.metadata or {}
    keys = sorted(key.decode() for key in was.keys() | now.keys() if was.get(key) != now.get(key))
    return f"the same values; other metadata ({', '.join(keys) or 'of the file format'})"
