"""Data files beside a study file: friction and heights over the position, and lines of a text."""

import csv
from collections.abc import Sequence
from hashlib import sha256
from math import isfinite
from pathlib import Path
from typing import NamedTuple


def file_below(folder: Path, name: str) -> Path:
    """Return the path of a data file of a study.

    Raises
    ------
    ValueError
        If there is no such file in the folder of the study file or below it, so that an archive
        of the study would lack it.
    """
    path = Path(name)
    if path.is_absolute() or ".." in path.parts or not (folder / path).is_file():
        raise ValueError(f"there is no file {name} in the study file's folder or below it")
    return folder / path


def digest_of(path: Path) -> str:
    """Compute a digest of a file's content."""
    return sha256(path.read_bytes()).hexdigest()[:16]


class Profile(NamedTuple):
    """Values at increasing positions (L): friction coefficients, or heights (L)."""

    x: list[float]
    values: list[float]


def read_profile(path: Path) -> Profile:
    """Read a profile of friction from a CSV file with the columns ``x`` and ``mu0``.

    Raises
    ------
    ValueError
        If the file cannot be used; the message has its line.
    """
    return _read_profile(path, "mu0", least=0.0)


def read_heights(path: Path) -> Profile:
    """Read heights from a CSV file with the columns ``x`` and ``height``.

    Raises
    ------
    ValueError
        If the file cannot be used; the message has its line.
    """
    return _read_profile(path, "height", least=float("-inf"))


def _read_profile(path: Path, name: str, *, least: float) -> Profile:
    """Read a column of values above `least` over increasing positions."""
    rows = _read_columns(path, ("x", name))
    for before, row in zip([None, *rows], rows, strict=False):
        x, value = row.values
        if not value > least:
            raise ValueError(f"{path}:{row.line}: {name} must be above {least:g}, got {value:g}")
        if before is not None and not x > before.values[0]:
            last = before.values[0]
            raise ValueError(f"{path}:{row.line}: x must increase; {x:g} is not above {last:g}")
    if len(rows) < 2:
        raise ValueError(f"{path}: a profile needs two rows or more")
    x_column, values = zip(*(row.values for row in rows), strict=True)
    return Profile(x=list(x_column), values=list(values))


class TextLine(NamedTuple):
    """A line of a file, with its number from 1."""

    number: int
    text: str


def lines_of(path: Path) -> list[TextLine]:
    """Read the lines of a text in UTF-8, without those that are empty or begin with #.

    Raises
    ------
    ValueError
        If the file cannot be read as such a text.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(f"{path} cannot be read as a text in UTF-8: {error}") from None
    return [
        TextLine(number=number, text=line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]


class _Row(NamedTuple):
    """Numbers in a line of a file."""

    line: int
    values: list[float]


def _read_columns(path: Path, names: Sequence[str]) -> list[_Row]:
    """Read columns of numbers from a CSV file; lines that are empty or begin with # are left out.

    Raises
    ------
    ValueError
        If a column is missing or there twice, a row is too long, or a value is no finite number.
    """
    lines = lines_of(path)
    cells = list(csv.reader([line.text for line in lines], skipinitialspace=True))
    head = [name.strip() for name in cells[0]] if cells else []
    _check_head(path, head, names)
    rows = []
    for line, row in zip(lines[1:], cells[1:], strict=True):
        place = f"{path}:{line.number}"
        if len(row) > len(head):
            raise ValueError(
                f"{place}: {len(row)} values for {len(head)} columns; write 0.5, not 0,5"
            )
        written = dict(zip(head, row, strict=False))
        values = [_number(place, name, written.get(name, "")) for name in names]
        rows.append(_Row(line=line.number, values=values))
    return rows


def _check_head(path: Path, head: Sequence[str], names: Sequence[str]) -> None:
    """Refuse a first line without each of the columns `names` exactly once."""
    absent = [name for name in names if name not in head]
    if absent:
        has = ", ".join(head) or "nothing"
        raise ValueError(
            f"{path} has no column {', '.join(absent)}; its first line has {has}, and must name "
            f"the columns {', '.join(names)}, separated by commas"
        )
    for name in names:
        if head.count(name) > 1:
            raise ValueError(f"{path} has the column {name} twice; remove one of them")


def _number(place: str, name: str, written: str) -> float:
    try:
        value = float(written)
    except ValueError:
        value = float("nan")
    if not isfinite(value):
        raise ValueError(f"{place}: {name} must be a number, got {written!r}")
    return value
