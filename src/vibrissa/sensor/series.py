"""Tables of the sensor: CSV or Parquet by the file's ending, each column with its unit.

A CSV file has one header line; each name is followed by its unit in brackets, as in
``footpoint [mm],force_x [N]``. A Parquet file has the unit in each column's metadata.
"""

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from vibrissa.arrays import FloatArray, IntArray
from vibrissa.files import write_atomically

ENDINGS = (".csv", ".parquet")


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

    values: Sequence[Any] | FloatArray | IntArray
    unit: str
    description: str


def check_ending(path: Path) -> None:
    """Refuse a file whose ending says neither CSV nor Parquet, or whose folder is missing."""
    if path.suffix.lower() not in ENDINGS:
        raise ValueError(f"{path}: the ending must be {' or '.join(ENDINGS)}")
    if not path.parent.is_dir():
        raise ValueError(f"{path}: there is no folder {path.parent}")


def write(path: Path, columns: Mapping[str, Column]) -> None:
    """Write a table as a whole.

    Parameters
    ----------
    path : Path
        With the ending ``.csv`` or ``.parquet``.
    columns : mapping
        Name to column; all of one length.
    """
    check_ending(path)
    with write_atomically(path) as temporary:
        if path.suffix.lower() == ".csv":
            with temporary.open("w", encoding="utf-8", newline="") as file:
                table = csv.writer(file, lineterminator="\n")
                table.writerow(
                    [f"{name} [{c.unit}]" if c.unit else name for name, c in columns.items()]
                )
                table.writerows(
                    zip(*(_as_text(column.values) for column in columns.values()), strict=True)
                )
            return
        fields, arrays = [], []
        for name, column in columns.items():
            array = pa.array(column.values)
            metadata = {"unit": column.unit, "description": column.description}
            fields.append(pa.field(name, array.type, metadata=metadata))
            arrays.append(array)
        pq.write_table(pa.Table.from_arrays(arrays, schema=pa.schema(fields)), temporary)


def _as_text(values: Any) -> list[str]:
    return [repr(v) if isinstance(v, float) else str(v) for v in np.asarray(values).tolist()]


@dataclass(frozen=True, eq=False)
class Table:
    """A table that was read.

    Attributes
    ----------
    path : str
        Where from, for messages.
    columns : dict
        Name to values; NaN where a value is missing.
    units : dict
        Name to unit, for columns that have one.
    line : ndarray of int
        Line of the file that each row stands in (row number, from 1, of a Parquet file).
    """

    path: str
    columns: dict[str, FloatArray]
    units: dict[str, str]
    line: IntArray

    def place(self, row: int) -> str:
        """Name a row in a message."""
        return f"{self.path}, line {self.line[row]}"


MISSING = frozenset({"", "nan", "na", "null", "none", "-"})
# Narrower than Python's float, which also takes 1_0 and digits of other scripts.
NUMBER = re.compile(r"\s*[-+]?(\d+\.?\d*|\.\d+|inf(inity)?)(e[-+]?\d+)?\s*", re.ASCII | re.I)


def read(path: Path, names: Sequence[str], optional: Sequence[str] = ()) -> Table:
    """Read columns of numbers.

    Parameters
    ----------
    path : Path
        With the ending ``.csv`` or ``.parquet``.
    names, optional : sequence of str
        Columns that must and that may be there; others are left alone.

    Returns
    -------
    Table

    Raises
    ------
    ValueError
        If the file cannot be read as such a table; the message names the file and the line.
    """
    check_ending(path)
    if not path.is_file():
        raise ValueError(f"{path}: there is no such file")
    table = _read_csv(path) if path.suffix.lower() == ".csv" else _read_parquet(path)
    missing = [name for name in names if name not in table.columns]
    if missing:
        raise ValueError(
            f"{path}: column {', '.join(missing)} is missing; there are: "
            f"{', '.join(table.columns) or 'none'}"
        )
    wanted = [*names, *(name for name in optional if name in table.columns)]
    if not len(table.line):
        raise ValueError(f"{path}: the table has no rows")
    columns = {}
    for name in wanted:
        values = np.empty(len(table.line))
        for row, cell in enumerate(table.columns[name]):
            try:
                missing_here = cell is None or str(cell).strip().lower() in MISSING
                if isinstance(cell, bool) or not (missing_here or NUMBER.fullmatch(str(cell))):
                    raise ValueError
                values[row] = np.nan if missing_here else float(cell)
            except (TypeError, ValueError):
                raise ValueError(
                    f"{table.place(row)}: {name} must be a number, got {cell!r}"
                ) from None
            if np.isinf(values[row]):
                raise ValueError(f"{table.place(row)}: {name} must be finite, got {cell!r}")
        columns[name] = values
    units = {name: unit for name, unit in table.units.items() if name in wanted}
    return Table(str(path), columns, units, table.line)


def _read_csv(path: Path) -> Any:
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.reader(file, strict=True)
            header = next(reader, [])
            cells, lines = [], []
            for row in reader:
                if not row:
                    continue
                if len(row) != len(header):
                    raise ValueError(
                        f"{path}, line {reader.line_num}: {len(row)} values, but the header "
                        f"has {len(header)}"
                    )
                cells.append(row)
                lines.append(reader.line_num)
    except UnicodeDecodeError:
        raise ValueError(f"{path}: not a text file in UTF-8") from None
    except csv.Error as error:
        raise ValueError(f"{path}, line {reader.line_num}: {error}") from None
    names, units = [], {}
    for title in header:
        name, _, rest = title.partition("[")
        names.append(name.strip())
        if rest:
            units[name.strip()] = rest.partition("]")[0].strip()
    if len(set(names)) < len(names):
        raise ValueError(f"{path}, line 1: a column stands there twice: {', '.join(names)}")
    columns: Any = {name: [row[i] for row in cells] for i, name in enumerate(names)}
    return Table(str(path), columns, units, np.array(lines, dtype=np.int64))


def _read_parquet(path: Path) -> Any:
    try:
        table = pq.read_table(path)
    except (pa.ArrowException, OSError) as error:
        raise ValueError(f"{path}: not a Parquet file: {str(error).splitlines()[0]}") from None
    units = {
        field.name: field.metadata[b"unit"].decode()
        for field in table.schema
        if field.metadata and field.metadata.get(b"unit")
    }
    columns: Any = {name: table[name].to_pylist() for name in table.column_names}
    return Table(str(path), columns, units, np.arange(1, len(table) + 1))
