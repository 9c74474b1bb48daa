"""Tables of the sensor: CSV or Parquet by the file's ending, each column with its unit.

Titles are as in ``footpoint [mm],force_x [N]``. Lines above them, such as
``# zero_force_x = 310 ± 0.3 mN``, hold for the whole table.
"""

import csv
import io
import json
import re
import sys
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TextIO

import numpy as np

from vibrissa.errors import ArgumentError, OtherTableError, RecordingError
from vibrissa.extras import require
from vibrissa.files import write_atomically
from vibrissa.numerics.arrays import FloatArray, IntArray, StrArray
from vibrissa.sensor.quantities import Units
from vibrissa.wording import counted

if TYPE_CHECKING:
    from pandas import DataFrame, Series

ENDINGS = (".csv", ".parquet")
NO_HEADER: Mapping[str, str] = {}
# Cells without a value.
MISSING = (
    *("", "-", "nan", "na", "n/a", "#n/a", "#nv", "null", "none"),
    *("-nan", "1.#qnan", "-1.#ind", "nan(ind)"),
)
# So many errors of one kind are listed.
LISTED = 10
HEADER = re.compile(r"#\s*(\w+)\s*=\s*(.+)")
# Between cells that were in quotes, in which every other separator may stand.
UNIT_SEPARATOR = "\x1f"
# Standard input or output, as CSV.
STANDARD = Path("-")


class Notation(NamedTuple):
    """A way to write numbers: a regular expression, the decimal sign, the sign between groups."""

    number: str
    decimal: str
    groups: str = ""

    def value(self, cell: str) -> float:
        """Value of a number in this notation."""
        return float(cell.replace(self.groups, "").replace(self.decimal, "."))


POINT = Notation(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?", ".")


@dataclass(frozen=True)
class Column:
    """A column to be written.

    Attributes
    ----------
    unit : str
        Its unit; ``1`` for a number, empty for text.
    """

    values: Sequence[Any] | FloatArray | IntArray | StrArray
    unit: str
    description: str

    def told(self, units: Units) -> "Column":
        """Convert to the user's units."""
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
    """Refuse a file that cannot be written: unknown ending, missing folder or library."""
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

    def header(self) -> dict[str, str]:
        """Quantities that hold for the whole table, as texts by name."""
        return {}

    def to_pandas(self) -> "DataFrame":
        """Make a DataFrame of the columns.

        Returns
        -------
        DataFrame
            Its ``attrs`` are ``units`` and ``descriptions``, by column, and the ``header``.
        """
        columns = self.columns()
        frame = _frame(columns, list(columns))
        frame.attrs = {
            "header": self.header(),
            "units": {name: column.unit for name, column in columns.items()},
            "descriptions": {name: column.description for name, column in columns.items()},
        }
        return frame


def write(path: Path, columns: Mapping[str, Column], header: Mapping[str, str] = NO_HEADER) -> None:
    """Write a table as a whole.

    Parameters
    ----------
    path : Path
        With the ending ``.csv`` or ``.parquet``; ``-`` for standard output.
    header : mapping of str to str
        Quantities that hold for the whole table: lines ``# name = text`` above that of the titles,
        or metadata of a Parquet file.

    Raises
    ------
    ArgumentError
        If the ending is another one or the folder is missing.
    """
    check_ending(path)
    if path == STANDARD:
        _write_csv(sys.stdout, columns, header)
        return
    with write_atomically(path) as temporary:
        if path.suffix.lower() == ".csv":
            with temporary.open("w", encoding="utf-8", newline="") as file:
                _write_csv(file, columns, header)
        else:
            _write_parquet(temporary, columns, header)


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


def _frame(columns: Mapping[str, Column], names: Sequence[str]) -> "DataFrame":
    import pandas as pd  # takes half a second to load

    values = (column.values for column in columns.values())
    return pd.DataFrame(dict(zip(names, values, strict=True)))


def _write_csv(file: TextIO, columns: Mapping[str, Column], header: Mapping[str, str]) -> None:
    file.writelines(f"# {name} = {text}\n" for name, text in header.items())
    _frame(columns, titles(columns)).to_csv(file, index=False, na_rep="nan", lineterminator="\n")


def _write_parquet(path: Path, columns: Mapping[str, Column], header: Mapping[str, str]) -> None:
    import pyarrow as pa  # takes a fifth of a second to load, and CSV is the rule
    import pyarrow.parquet as pq

    arrays = [pa.array(column.values) for column in columns.values()]
    fields = [
        pa.field(name, a.type, metadata={"unit": c.unit, "description": c.description})
        for (name, c), a in zip(columns.items(), arrays, strict=True)
    ]
    schema = pa.schema(fields, metadata=dict(header))
    pq.write_table(pa.Table.from_arrays(arrays, schema=schema), path)


@dataclass(frozen=True, eq=False, kw_only=True)
class Table:
    """Columns of numbers that were read.

    Attributes
    ----------
    line : ndarray of int
        Line of the file in which each row stands; number of the row, from 1, in a Parquet file or
        a DataFrame.
    header : dict
        Quantities that hold for the whole table, by name: texts such as ``310 ± 0.3 mN``.
    """

    source: str
    columns: dict[str, FloatArray]
    units: dict[str, str]
    line: IntArray
    header: dict[str, str]

    def place(self, row: int) -> str:
        """Name a row in a message."""
        return f"{self.source}, line {self.line[row]}"


def read(source: "Path | DataFrame", names: Sequence[str], optional: Sequence[str] = ()) -> Table:
    """Read columns of numbers.

    Parameters
    ----------
    source : Path or DataFrame
        A file with the ending ``.csv`` or ``.parquet``, ``-`` for standard input, or a table whose
        columns are called as in the header of a CSV file.

    Raises
    ------
    RecordingError
        If it cannot be read as such a table, with a line for each wrong cell. An OtherTableError
        if columns, separators or the encoding are others.
    ArgumentError
        If the ending is another one or the folder is missing.
    """
    where, frame = _cells(source)
    there, units = _columns(frame, where)
    missing = [name for name in names if name not in there]
    if missing:
        raise OtherTableError(
            f"{where}: column {', '.join(missing)} is missing; there are: "
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


def numbers(
    columns: Mapping[str, "Series[Any]"], source: str, notation: Notation = POINT
) -> dict[str, FloatArray]:
    """Convert columns of cells to numbers; NaN where a value is missing.

    Raises
    ------
    RecordingError
        With a line for each cell that is no finite number.
    """
    values, wrong = {}, []
    for name, column in columns.items():
        if column.dtype.kind in "iuf":
            values[name] = column.to_numpy(dtype=float, na_value=np.nan)
            bad = np.isinf(values[name])
        else:
            text = column.fillna("").astype(str).str.strip()
            good = text.str.fullmatch(notation.number).to_numpy(dtype=bool)
            plain = text.where(good, "nan")
            if notation.groups:
                plain = plain.str.replace(notation.groups, "", regex=False)
                plain = plain.str.replace(notation.decimal, ".", regex=False)
            values[name] = plain.to_numpy(dtype=object).astype(float)
            missing = text.str.lower().isin(MISSING).to_numpy()
            bad = ~(good | missing) | np.isinf(values[name])
        wrong += [
            (line, f"{name} must be a finite number, or empty where it is missing, got {cell!r}")
            for line, cell in column[bad].astype(str).items()
        ]
    if wrong:
        wrong.sort(key=lambda one: one[0])
        raise RecordingError(listed(f"{source}, line {line}: {what}" for line, what in wrong))
    return values


def check_file(path: Path) -> None:
    """Refuse a file that is not there, and a folder."""
    if path.is_dir():
        raise RecordingError(f"{path} is a folder: give a file")
    if not path.is_file():
        raise RecordingError(f"{path}: there is no such file")


def listed(messages: Iterable[str]) -> str:
    """Join messages line by line; count those beyond the first few."""
    every = list(messages)
    more = [f"and {len(every) - LISTED} more"] if len(every) > LISTED else []
    return "\n".join([*every[:LISTED], *more])


def _cells(source: "Path | DataFrame") -> tuple[str, "DataFrame"]:
    """Read cells that may be anything; the index is the line of each row."""
    if not isinstance(source, Path):
        if not hasattr(source, "attrs"):
            raise RecordingError(
                f"a recording is a file or a DataFrame, not a {type(source).__name__}"
            )
        return "the DataFrame", source.rename(columns=str).set_axis(range(1, len(source) + 1))
    check_ending(source)
    if source == STANDARD:
        return "standard input", _read_csv(sys.stdin.buffer.read(), "standard input")
    check_file(source)
    if source.suffix.lower() == ".parquet":
        return str(source), _read_parquet(source)
    return str(source), _read_csv(source.read_bytes(), str(source))


def _columns(frame: "DataFrame", source: str) -> tuple[dict[str, "Series[Any]"], dict[str, str]]:
    """Take titles such as ``footpoint [mm]`` apart: columns by name, and their units."""
    units = {name: unit for name, unit in frame.attrs.get("units", {}).items() if unit}
    columns: dict[str, Series[Any]] = {}
    for title, column in frame.items():
        name, _, unit = str(title).partition("[")
        if {";", "\t"} & set(title):  # between other separators a line is one title
            name, unit = title, ""
        if name.strip() in columns:
            raise RecordingError(f"{source}: column {name.strip()} occurs twice")
        columns[name.strip()] = column
        if unit:
            units[name.strip()] = unit.partition("]")[0].strip()
    return columns, units


def _read_csv(data: bytes, source: str) -> "DataFrame":
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise OtherTableError(f"{source}: not a text file in UTF-8") from None
    lines = lines_of(text)
    rows = lines[~lines.str.startswith("#").cummin()]
    frame = split(rows, source)
    if len(rows):
        frame = frame.iloc[1:].set_axis(frame.iloc[0], axis=1)
    told = (HEADER.fullmatch(line) for line in lines.drop(rows.index))
    frame.attrs = {"header": {one[1]: one[2] for one in told if one}}
    return frame


def lines_of(text: str) -> "Series[str]":
    """Split a text into lines that are not blank, with the line numbers as index."""
    import pandas as pd  # takes half a second to load

    lines = pd.Series(text.replace("\r\n", "\n").replace("\r", "\n").split("\n"), dtype=str)
    lines.index += 1
    return lines[lines.str.strip() != ""]


def split(lines: "Series[str]", source: str, separator: str = ",") -> "DataFrame":
    """Split lines into cells, which are texts.

    Raises
    ------
    OtherTableError
        With a line for each that has another number of cells.
    RecordingError
        If a quote is not closed.
    """
    import pandas as pd

    if lines.empty:
        return pd.DataFrame()
    if lines.str.contains('"', regex=False).any():
        lines = _unquoted(lines, source, separator)
        separator = UNIT_SEPARATOR
    counts = lines.str.count(re.escape(separator)) + 1
    others = counts[counts != counts.iloc[0]]
    if len(others):
        than = f"but line {lines.index[0]} has {counts.iloc[0]}"
        raise OtherTableError(
            listed(
                f"{source}, line {line}: {counted(count, 'value')}, {than}"
                for line, count in others.items()
            )
        )
    frame = pd.read_csv(
        io.BytesIO("\n".join(lines).encode()),
        sep=separator,
        header=None,
        dtype=str,
        na_filter=False,
        quoting=csv.QUOTE_NONE,
        skip_blank_lines=False,
    )
    return frame.set_axis(lines.index)


def _unquoted(lines: "Series[str]", source: str, separator: str) -> "Series[str]":
    """Put another sign in the place of separators, so that no cell needs quotes."""
    import pandas as pd

    cells: list[list[str]] = []
    for number, line in lines.items():
        try:
            cells += csv.reader([line], delimiter=separator, strict=True)
        except csv.Error as error:
            raise RecordingError(f"{source}, line {number}: {error}") from None
    return pd.Series(map(UNIT_SEPARATOR.join, cells), index=lines.index, dtype=str)


def _read_parquet(path: Path) -> "DataFrame":
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.read_table(path)
    except (pa.ArrowException, OSError) as error:
        raise RecordingError(f"{path}: not a Parquet file: {str(error).splitlines()[0]}") from None
    frame = table.to_pandas(ignore_metadata=True).set_axis(range(1, len(table) + 1))
    frame.attrs = {
        "units": {field.name: _texts(field.metadata).get("unit") for field in table.schema},
        "header": _texts(table.schema.metadata),
    }
    return frame


def _texts(metadata: Mapping[bytes, bytes] | None) -> dict[str, str]:
    return {name.decode(): text.decode() for name, text in (metadata or {}).items()}
