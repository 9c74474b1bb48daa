"""Tables of the sensor: CSV or Parquet by the file's ending, each column with its unit.

A CSV file has one header line; each name is followed by its unit in brackets, as in
``footpoint [mm],force_x [N]``. The columns of a DataFrame have the same titles, or
their units are in its ``attrs``. A Parquet file has the unit in each column's metadata.
"""

import csv
import io
import json
import re
import sys
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, TextIO

import numpy as np

from vibrissa.errors import ArgumentError, OtherTableError, RecordingError
from vibrissa.extras import require
from vibrissa.files import write_atomically
from vibrissa.numerics.arrays import FloatArray, IntArray, StrArray
from vibrissa.sensor.quantities import Units

if TYPE_CHECKING:
    from pandas import DataFrame

ENDINGS = (".csv", ".parquet")
# Standard input or output, as CSV.
STANDARD = Path("-")


@dataclass(frozen=True)
class Column:
    """A column to be written.

    Attributes
    ----------
    values : sequence
    unit : str
        Its unit; ``1`` for a number, empty for text.
    description : str
        What it is.
    """

    values: Sequence[Any] | FloatArray | IntArray | StrArray
    unit: str
    description: str

    def told(self, units: Units) -> "Column":
        """Give it in the units in which a person thinks."""
        for kind in units.wished:
            if self.unit == units.name(kind):
                factor, name = units.told(1.0, kind)
                return replace(self, values=np.asarray(self.values) * factor, unit=name)
        return self

    @property
    def text(self) -> str:
        """Its only value, with its unit."""
        (value,) = self.values
        return f"{value:.8g} {self.unit}".removesuffix(" 1") if self.unit else str(value)


def check_ending(path: Path, *others: str) -> None:
    """Refuse a file that cannot be: an ending of another kind, no folder, no library for it."""
    if path == STANDARD:
        return
    if path.suffix.lower() not in (*ENDINGS, *others):
        raise ArgumentError(f"{path}: the ending must be {' or '.join((*ENDINGS, *others))}")
    if not path.parent.is_dir():
        raise ArgumentError(f"{path}: there is no folder {path.parent}")
    if path.suffix.lower() == ".parquet":
        require("tables", "pyarrow")


def titles(columns: Mapping[str, Column]) -> list[str]:
    """Names of columns with their units, as in the header of a CSV file."""
    return [f"{name} [{c.unit}]" if c.unit else name for name, c in columns.items()]


class Tabular(ABC):
    """A result that is a table: columns with units. It prints as text, as the commands show it."""

    @abstractmethod
    def columns(self) -> dict[str, Column]:
        """Columns by name, with units."""

    def to_pandas(self) -> "DataFrame":
        """Make a DataFrame of the columns.

        Returns
        -------
        DataFrame
            Its ``attrs`` are ``units`` and ``descriptions``, by column.
        """
        require("tables", "pandas")
        import pandas as pd  # takes half a second to load

        columns = self.columns()
        frame = pd.DataFrame({name: column.values for name, column in columns.items()})
        frame.attrs = {
            "units": {name: column.unit for name, column in columns.items()},
            "descriptions": {name: column.description for name, column in columns.items()},
        }
        return frame


def write(path: Path, columns: Mapping[str, Column]) -> None:
    """Write a table as a whole.

    Parameters
    ----------
    path : Path
        With the ending ``.csv`` or ``.parquet``; ``-`` for standard output.
    columns : mapping
        Name to column; all of one length.

    Raises
    ------
    ArgumentError
        If the ending is another one or the folder is missing.
    """
    check_ending(path)
    if path == STANDARD:
        _write_csv(sys.stdout, columns)
        return
    with write_atomically(path) as temporary:
        if path.suffix.lower() == ".csv":
            with temporary.open("w", encoding="utf-8", newline="") as file:
                _write_csv(file, columns)
        else:
            _write_parquet(temporary, columns)


def as_json(columns: Mapping[str, Column]) -> str:
    """Write a table as JSON: the unit of each column, and a row for each result; NaN is null."""
    values = [np.asarray(column.values).tolist() for column in columns.values()]
    rows = [
        {
            name: None if value != value or value in (np.inf, -np.inf) else value
            for name, value in zip(columns, row, strict=True)
        }
        for row in zip(*values, strict=True)
    ]
    units = {name: column.unit for name, column in columns.items()}
    return json.dumps({"units": units, "rows": rows}, ensure_ascii=False, indent=1)


def _write_csv(file: TextIO, columns: Mapping[str, Column]) -> None:
    table = csv.writer(file, lineterminator="\n")
    table.writerow(titles(columns))
    table.writerows(zip(*(_as_text(c.values) for c in columns.values()), strict=True))


def _write_parquet(path: Path, columns: Mapping[str, Column]) -> None:
    import pyarrow as pa  # takes a fifth of a second to load, and CSV is the rule
    import pyarrow.parquet as pq

    arrays = [pa.array(column.values) for column in columns.values()]
    fields = [
        pa.field(name, a.type, metadata={"unit": c.unit, "description": c.description})
        for (name, c), a in zip(columns.items(), arrays, strict=True)
    ]
    pq.write_table(pa.Table.from_arrays(arrays, schema=pa.schema(fields)), path)


def _as_text(values: Any) -> list[str]:
    return [repr(v) if isinstance(v, float) else str(v) for v in np.asarray(values).tolist()]


@dataclass(frozen=True, eq=False, kw_only=True)
class Table:
    """A table that was read.

    Attributes
    ----------
    source : str
        Where from, for messages.
    columns : dict
        Name to values; NaN where a value is missing.
    units : dict
        Name to unit, for columns that have one.
    line : ndarray of int
        Line of the file in which each row stands; number of the row, from 1, in a Parquet file or
        a DataFrame.
    """

    source: str
    columns: dict[str, FloatArray]
    units: dict[str, str]
    line: IntArray

    def place(self, row: int) -> str:
        """Name a row in a message."""
        return f"{self.source}, line {self.line[row]}"


@dataclass(frozen=True, eq=False, kw_only=True)
class _Cells(Table):
    """A table whose cells may still be anything."""

    columns: dict[str, Sequence[Any]]  # type: ignore[assignment]

    def numbers(self, name: str) -> FloatArray:
        """Convert a column; NaN where a value is missing."""
        values = np.empty(len(self.line))
        for row, cell in enumerate(self.columns[name]):
            number = _number(cell)
            if number is None:
                raise RecordingError(f"{self.place(row)}: {name} must be a number, got {cell!r}")
            if np.isinf(number):
                raise RecordingError(f"{self.place(row)}: {name} must be finite, got {cell!r}")
            values[row] = number
        return values


MISSING = frozenset({"", "nan", "na", "null", "none", "-"})
# Narrower than Python's float, which also takes 1_0 and digits of other scripts.
NUMBER = re.compile(r"\s*[-+]?(\d+\.?\d*|\.\d+|inf(inity)?)(e[-+]?\d+)?\s*", re.ASCII | re.I)


def _number(cell: Any) -> float | None:
    """Value of a cell: NaN where it is missing, None where it is no number."""
    text = str(cell)
    if cell is None or text.strip().lower() in MISSING:
        return float("nan")
    if isinstance(cell, bool) or NUMBER.fullmatch(text) is None:
        return None
    return float(text)


def read(source: "Path | DataFrame", names: Sequence[str], optional: Sequence[str] = ()) -> Table:
    """Read columns of numbers.

    Parameters
    ----------
    source : Path or DataFrame
        A file with the ending ``.csv`` or ``.parquet``, ``-`` for standard input, or a table whose
        columns are called as in the header of a CSV file.
    names, optional : sequence of str
        Columns that must and that may be there; others are left alone.

    Returns
    -------
    Table

    Raises
    ------
    RecordingError
        If it cannot be read as such a table; the message names the file and the line. An
        OtherTableError if columns, separators or the encoding are others.
    ArgumentError
        If the ending is another one or the folder is missing.
    """
    cells = _read_cells(source)
    missing = [name for name in names if name not in cells.columns]
    if missing:
        raise OtherTableError(
            f"{cells.source}: column {', '.join(missing)} is missing; there are: "
            f"{', '.join(cells.columns) or 'none'}"
        )
    if not len(cells.line):
        raise RecordingError(f"{cells.source}: the table has no rows")
    wanted = [*names, *(name for name in optional if name in cells.columns)]
    return Table(
        source=cells.source,
        columns={name: cells.numbers(name) for name in wanted},
        units={name: unit for name, unit in cells.units.items() if name in wanted},
        line=cells.line,
    )


def _read_cells(source: "Path | DataFrame") -> _Cells:
    if not isinstance(source, Path):
        if not hasattr(source, "attrs"):
            raise RecordingError(
                f"a recording is a file or a DataFrame, not a {type(source).__name__}"
            )
        return _from_frame(source)
    check_ending(source)
    if source == STANDARD:
        return _read_csv(io.BytesIO(sys.stdin.buffer.read()), "standard input")
    if not source.is_file():
        raise RecordingError(f"{source}: there is no such file")
    if source.suffix.lower() == ".parquet":
        return _read_parquet(source)
    with source.open("rb") as file:
        return _read_csv(file, str(source))


def _names_and_units(header: Sequence[str], place: str) -> tuple[list[str], dict[str, str]]:
    """Take titles such as ``footpoint [mm]`` apart."""
    # Between other separators a line is one title.
    one = [title for title in header if ";" in title or "\t" in title]
    parts = [(title, "", "") if title in one else title.partition("[") for title in header]
    names = [name.strip() for name, _, _ in parts]
    units = {name.strip(): rest.partition("]")[0].strip() for name, _, rest in parts if rest}
    if len(set(names)) < len(names):
        raise RecordingError(f"{place}: a column stands there twice: {', '.join(names)}")
    return names, units


def _read_csv(file: BinaryIO, source: str) -> _Cells:
    rows, lines = [], []
    with io.TextIOWrapper(file, encoding="utf-8-sig", newline="") as text:
        reader = csv.reader(text, strict=True)
        try:
            header = next(reader, [])
            for row in filter(None, reader):
                if len(row) != len(header):
                    raise OtherTableError(
                        f"{source}, line {reader.line_num}: {len(row)} values, but the header "
                        f"has {len(header)}"
                    )
                rows.append(row)
                lines.append(reader.line_num)
        except UnicodeDecodeError:
            raise OtherTableError(f"{source}: not a text file in UTF-8") from None
        except csv.Error as error:
            raise RecordingError(f"{source}, line {reader.line_num}: {error}") from None
    names, units = _names_and_units(header, f"{source}, line 1")
    return _Cells(
        source=source,
        columns={name: [row[i] for row in rows] for i, name in enumerate(names)},
        units=units,
        line=np.array(lines, dtype=np.int64),
    )


def _read_parquet(path: Path) -> _Cells:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.read_table(path)
    except (pa.ArrowException, OSError) as error:
        raise RecordingError(f"{path}: not a Parquet file: {str(error).splitlines()[0]}") from None
    units = {
        field.name: field.metadata[b"unit"].decode()
        for field in table.schema
        if field.metadata and field.metadata.get(b"unit")
    }
    return _Cells(
        source=str(path),
        columns={name: table[name].to_pylist() for name in table.column_names},
        units=units,
        line=np.arange(1, len(table) + 1),
    )


def _from_frame(frame: "DataFrame") -> _Cells:
    source = "the DataFrame"
    names, units = _names_and_units([str(title) for title in frame.columns], source)
    units = {**frame.attrs.get("units", {}), **units}
    return _Cells(
        source=source,
        columns={name: frame.iloc[:, i].tolist() for i, name in enumerate(names)},
        units=units,
        line=np.arange(1, len(frame) + 1),
    )
