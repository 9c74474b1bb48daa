"""Tables in CSV or Parquet files, with a unit for each column.

The titles of a CSV file are as in ``footpoint [mm],force_x [N]``. Lines above the titles, such as
``# zero_force_x = 310 ± 0.3 mN``, hold for the whole table.
"""

import csv
import re
import sys
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import numpy as np

from vibrissa.errors import ArgumentError, OtherTableError, RecordingError
from vibrissa.extras import require
from vibrissa.files import write_atomically
from vibrissa.numerics.arrays import FloatArray, IntArray, StrArray
from vibrissa.wording import counted

if TYPE_CHECKING:
    from pandas import DataFrame, Series

PARQUET = ".parquet"
ENDINGS = (".csv", PARQUET)
# Cells without a value.
MISSING = ("", "-", "nan", "na", "n/a", "#n/a", "#nv", "null", "none")
# A number, with its decimal sign in place of the braces.
NUMBER = r"[-+]?([0-9]+{0}?[0-9]*|{0}[0-9]+)([eE][-+]?[0-9]+)?"
# Largest number that is accepted: powers of larger numbers overflow.
LARGEST = 1e50
# Number of errors of one kind that are listed.
LISTED = 10
TITLE = re.compile(r"\s*(.*?)\s*(?:\[\s*([^\[\]]*?)\s*\])?\s*", re.DOTALL)
HEADER = re.compile(r"#\s*(\w+)\s*=\s*(.+)")
# Standard input or output, as CSV.
STANDARD = Path("-")


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes
    ----------
    unit : str
        Unit of the values; ``1`` if they have no dimension, empty for text.
    """

    values: Sequence[Any] | FloatArray | IntArray | StrArray
    unit: str
    description: str


def check_ending(path: Path, endings: Sequence[str] = ENDINGS) -> None:
    """Refuse a file with none of the `endings`, and a Parquet file if pyarrow is missing."""
    if path == STANDARD and set(ENDINGS) <= set(endings):
        return
    if path.suffix.lower() not in endings:
        raise ArgumentError(f"{path}: the ending must be {' or '.join(endings)}")
    if path.suffix.lower() == PARQUET:
        require("tables", "pyarrow")


class Tabular(ABC):
    """A result that can be written as a table with units."""

    @abstractmethod
    def columns(self) -> dict[str, Column]:
        """Columns by name, with units."""

    def header(self) -> dict[str, str]:
        """Quantities that hold for the whole table: texts such as ``310 ± 0.3 mN``, by name."""
        return {}

    def to_pandas(self) -> "DataFrame":
        """Make a DataFrame of the columns.

        Returns
        -------
        DataFrame
            Its ``attrs`` have the ``units`` and ``descriptions`` by column, and the ``header``.
        """
        import pandas as pd  # takes half a second to load

        columns = self.columns()
        frame = pd.DataFrame({name: column.values for name, column in columns.items()})
        frame.attrs = {
            "header": self.header(),
            "units": {name: column.unit for name, column in columns.items()},
            "descriptions": {name: column.description for name, column in columns.items()},
        }
        return frame


def write(path: Path, table: Tabular) -> None:
    """Write a table to a file; an error leaves no incomplete file.

    Parameters
    ----------
    path : Path
        File with the ending ``.csv`` or ``.parquet``; ``-`` for standard output.
    table : Tabular
        A CSV file has its header in lines ``# name = text`` above the titles. A Parquet file has
        header, units and descriptions as the ``attrs`` of its DataFrame.

    Raises
    ------
    ArgumentError
        If the file has another ending.
    """
    check_ending(path)
    frame = table.to_pandas()
    if path == STANDARD:
        _write_csv(sys.stdout, frame)
        return
    with write_atomically(path) as temporary:
        if path.suffix.lower() == PARQUET:
            frame.to_parquet(temporary, index=False)
        else:
            with temporary.open("w", encoding="utf-8", newline="") as file:
                _write_csv(file, frame)


def _write_csv(file: TextIO, frame: "DataFrame") -> None:
    file.writelines(f"# {name} = {text}\n" for name, text in frame.attrs["header"].items())
    units = frame.attrs["units"]
    titles = [f"{name} [{unit}]" if unit else name for name, unit in units.items()]
    frame.to_csv(file, header=titles, index=False, na_rep="nan", lineterminator="\n")


@dataclass(frozen=True, eq=False, kw_only=True)
class Table:
    """Columns of numbers that were read from a file or a DataFrame.

    Attributes
    ----------
    source : str
        Name of the file, for messages.
    columns, units : dict
        Values and units of the columns, by name; a column without a unit is not in `units`.
    line : ndarray of int
        Line number of each row in the file; for Parquet or a DataFrame, number of the row from 1.
    header : dict
        Quantities that hold for the whole table, by name: texts such as ``310 ± 0.3 mN``.
    """

    source: str
    columns: dict[str, FloatArray]
    units: dict[str, str]
    line: IntArray
    header: dict[str, str]

    def place(self, row: int) -> str:
        """Name the source and the line of a row, for messages."""
        return f"{self.source}, line {self.line[row]}"


def read(source: "Path | DataFrame", names: Sequence[str], optional: Sequence[str] = ()) -> Table:
    """Read the columns `names`, and the `optional` columns that the table has, as numbers.

    Parameters
    ----------
    source : Path or DataFrame
        A file with the ending ``.csv`` or ``.parquet``, ``-`` for standard input, or a DataFrame
        with the titles of such a file.

    Raises
    ------
    RecordingError
        If the source is not such a table; the message has a line for each wrong cell. The error
        is an OtherTableError if a column is missing, lines have different numbers of cells, or
        the encoding is not UTF-8.
    ArgumentError
        If the file has another ending.
    """
    where, frame = _cells(source)
    there, units = _columns(frame, where, {*names, *optional})
    missing = [name for name in names if name not in there]
    if missing:
        raise OtherTableError(
            f"{where}: column {', '.join(missing)} is missing; the columns are: "
            f"{', '.join(there) or 'none'}"
        )
    if frame.empty:
        raise RecordingError(f"{where}: the table has no rows")
    wanted = [*names, *(name for name in optional if name in there)]
    return Table(
        source=where,
        columns=numbers({name: there[name] for name in wanted}, where),
        units={name: unit for name, unit in units.items() if name in wanted},
        line=frame.index.to_numpy(),
        header=frame.attrs.get("header", {}),
    )


def _cells(source: "Path | DataFrame") -> tuple[str, "DataFrame"]:
    """Return the name of a source and its cells, unchecked; the index has the line of each row."""
    if not isinstance(source, Path):
        if not hasattr(source, "attrs"):
            raise RecordingError(
                f"a recording is a file or a DataFrame, not a {type(source).__name__}"
            )
        return "the DataFrame", source.set_axis(range(1, len(source) + 1))
    check_ending(source)
    if source.suffix.lower() != PARQUET:
        where = name_of(source)
        return where, _read_csv(content_of(source), where)
    import pandas as pd

    try:
        frame = pd.read_parquet(source)
    except ValueError as error:
        raise RecordingError(f"{source}: not a Parquet file: {error}") from None
    return str(source), frame.set_axis(range(1, len(frame) + 1))


def _read_csv(data: bytes, source: str) -> "DataFrame":
    try:
        lines = lines_of(data.decode("utf-8-sig"))
    except UnicodeDecodeError:
        raise OtherTableError(f"{source}: not a text file in UTF-8") from None
    above = lines.str.startswith("#").cummin()
    frame = split(lines[~above], source)
    if len(frame):
        frame = frame.iloc[1:].set_axis(frame.iloc[0], axis=1)
    found = map(HEADER.fullmatch, lines[above])
    frame.attrs = {"header": {one[1]: one[2] for one in found if one}}
    return frame


def _columns(
    frame: "DataFrame", source: str, needed: set[str]
) -> tuple[dict[str, "Series[Any]"], dict[str, str]]:
    """Split titles such as ``footpoint [mm]``; return the columns and the units by name."""
    units = {name: unit for name, unit in frame.attrs.get("units", {}).items() if unit}
    columns: dict[str, Series[Any]] = {}
    for title, column in frame.items():
        name, unit = TITLE.fullmatch(str(title)).groups(default="")  # type: ignore[union-attr]
        if name in columns and name in needed:
            raise RecordingError(f"{source}: column {name} occurs twice")
        columns[name] = column
        if unit:
            units[name] = unit
    return columns, units


def numbers(
    columns: Mapping[str, "Series[Any]"], source: str, decimal: str = "."
) -> dict[str, FloatArray]:
    """Convert columns of cells to numbers; NaN where a value is missing.

    Raises
    ------
    RecordingError
        With a line for each cell that is no finite number.
    """
    allowed = f"such as 0{decimal}012 or 1{decimal}2e-2, at most {LARGEST:g}"
    values, wrong = {}, []
    for name, column in columns.items():
        text = column.astype(str).fillna("").str.strip()
        good = text.str.fullmatch(NUMBER.format(re.escape(decimal))).to_numpy(dtype=bool)
        plain = text.where(good, "nan").str.replace(decimal, ".", regex=False)
        values[name] = plain.to_numpy(dtype=object).astype(float)
        missing = text.str.lower().isin(MISSING).to_numpy()
        bad = ~(good | missing) | (np.abs(values[name]) > LARGEST)
        wrong += [
            (line, f"{name} must be empty or a number {allowed}, got {cell!r}")
            for line, cell in column[bad].astype(str).items()
        ]
    if wrong:
        wrong.sort(key=lambda one: one[0])
        raise RecordingError(listed(f"{source}, line {line}: {what}" for line, what in wrong))
    return values


def name_of(path: Path) -> str:
    """Return the name of a file for messages."""
    return "standard input" if path == STANDARD else str(path)


def content_of(path: Path) -> bytes:
    """Read a file, or standard input, as a whole."""
    return sys.stdin.buffer.read() if path == STANDARD else path.read_bytes()


def listed(messages: Iterable[str]) -> str:
    """Join messages, one in a line; messages after the first `LISTED` are only counted."""
    every = list(messages)
    more = [f"and {len(every) - LISTED} more"] if len(every) > LISTED else []
    return "\n".join([*every[:LISTED], *more])


def lines_of(text: str, blank: str | None = None) -> "Series[str]":
    """Split a text into lines that are not blank, with the line numbers as index.

    Parameters
    ----------
    blank : str, optional
        Characters of blank lines; by default all white space.
    """
    import pandas as pd  # takes half a second to load

    lines = pd.Series(text.replace("\r\n", "\n").replace("\r", "\n").split("\n"), dtype=str)
    lines.index += 1
    return lines[lines.str.strip(blank) != ""]


def split(lines: "Series[str]", source: str) -> "DataFrame":
    """Split lines into cells, which are texts.

    Raises
    ------
    OtherTableError
        If lines have different numbers of cells; the message names these lines.
    RecordingError
        If a quote is not closed.
    """
    import pandas as pd

    rows: list[list[str]] = []
    for number, line in lines.items():
        try:
            rows += csv.reader([line], strict=True)
        except csv.Error as error:
            raise RecordingError(f"{source}, line {number}: unpaired quotes ({error})") from None
    others = [
        f"{source}, line {number}: {counted(len(row), 'value')}, but line {lines.index[0]} has "
        f"{len(rows[0])}"
        for number, row in zip(lines.index, rows, strict=True)
        if len(row) != len(rows[0])
    ]
    if others:
        raise OtherTableError(listed(others))
    return pd.DataFrame(rows, index=lines.index, dtype=str)
