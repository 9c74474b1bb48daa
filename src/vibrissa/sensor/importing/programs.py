"""Files of other programs: Excel, MATLAB, TDMS, LabVIEW measurement and Parquet files.

Each is read by the library made for it; all other files are text.
"""

import datetime
import io
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibrissa.errors import RecordingError
from vibrissa.extras import require
from vibrissa.sensor.importing.delimited import (
    FEWEST_COLUMNS,
    FEWEST_ROWS,
    Grid,
    decoded,
    grid_of_rows,
    no_table,
)
from vibrissa.sensor.importing.layout import Layout, layout_of_grid, layout_of_text
from vibrissa.sensor.importing.numbers import Signs
from vibrissa.wording import counted

if TYPE_CHECKING:
    from vibrissa.sensor.importing.settings import Settings

# Group of optional packages with the libraries.
EXTRA = "files"
# Number of tables and of titles that a message lists.
LISTED = 8
# Functions of MATLAB that write its objects as text.
WRITERS = {"table": "writetable", "timetable": "writetimetable"}
# A number that is no text: Excel's cells are exact decimals with a point.
POINT = Signs(".")


class Named(NamedTuple):
    """A column of a file that has names: title, unit, and values."""

    title: str
    unit: str
    values: Any


# Columns of tables by the name of the table.
Tables = Mapping[str, Sequence[Named]]


def layout_in(data: bytes, name: str, settings: "Settings") -> Layout:
    """Find the table in a file, by the format that its first bytes show.

    Raises
    ------
    RecordingError
        If the file is damaged or has no table, or if it has several and none is chosen.
    MissingExtraError
        If the library that reads the format is not installed.
    """
    reader = _reader(data, name)
    if reader is _excel:
        return _excel(data, name, settings)
    if reader is not None:
        tables = {
            table: columns for table, columns in reader(data, name).items() if _is_table(columns)
        }
        chosen = _chosen(
            {table: _summary(columns) for table, columns in tables.items()}, name, settings.table
        )
        return _named_layout(tables[chosen], chosen)
    if settings.table is not None:
        raise RecordingError(f"{name}: a text file has no table of a name: leave out --table")
    return layout_of_text(data, name, settings.decimal, settings.title_line, settings.unit_line)


def _reader(data: bytes, name: str) -> Callable[..., Any] | None:
    signatures: dict[bytes, Callable[..., Any]] = {
        b"PK\x03\x04": _excel,
        b"\xd0\xcf\x11\xe0": _excel,
        b"MATLAB 7.3": _matlab_hdf,
        b"\x89HDF": _matlab_hdf,
        b"MATLAB": _matlab,
        b"TDSm": _tdms,
        b"PAR1": _parquet,
        b"LabVIEW Measurement": _lvm,
    }
    reader = next((read for begin, read in signatures.items() if data.startswith(begin)), None)
    # Version 4 of MATLAB has no signature.
    return _matlab if reader is None and name.lower().endswith(".mat") else reader


def _load(what: str, name: str, read: Callable[[], Any]) -> Any:
    """Call a library; whatever error it raises, the file is damaged."""
    try:
        return read()
    except Exception as error:
        line = str(error).strip().partition("\n")[0] or type(error).__name__
        raise RecordingError(f"{name}: not a {what} that can be read: {line}") from None


def _chosen(tables: Mapping[str, str], name: str, wanted: str | None) -> str:
    """Choose one of several tables, which are given with a summary each.

    Raises
    ------
    RecordingError
        If there is no table, none of this name, or several of which none is chosen; the message
        lists them.
    """
    if not tables:
        raise RecordingError(no_table(name))
    if wanted is None and len(tables) == 1:
        return next(iter(tables))
    named = [table for table in tables if table == (wanted or "").strip()]
    if named:
        return named[0]
    shown = [f"  {table}: {summary}" for table, summary in list(tables.items())[:LISTED]]
    more = [f"  and {len(tables) - LISTED} more"] if len(tables) > LISTED else []
    problem = (
        "there are several tables" if wanted is None else f"there is no table called {wanted!r}"
    )
    example = next(iter(tables))
    lines = [f"{name}: {problem}: choose one, as in --table {example!r}", *shown, *more]
    raise RecordingError("\n".join(lines))


def _summary(columns: Sequence[Named]) -> str:
    titles = [column.title for column in columns]
    more = ", ..." if len(titles) > LISTED else ""
    return f"{counted(len(columns[0].values), 'row')} of {', '.join(titles[:LISTED])}{more}"


def _is_table(columns: Sequence[Named]) -> bool:
    return len(columns) >= FEWEST_COLUMNS and len(columns[0].values) >= FEWEST_ROWS


def _named_layout(columns: Sequence[Named], table: str) -> Layout:
    """Lay out named columns; times of day become seconds from the first row."""
    import pandas as pd

    cells = {number: _plain(column) for number, column in enumerate(columns)}
    frame = pd.DataFrame({number: column.values for number, column in cells.items()})
    frame.index += 1
    rows = counted(len(frame), "row")
    return Layout(
        titles=[column.title for column in columns],
        units=[column.unit for column in cells.values()],
        cells=frame,
        samples=np.arange(len(frame)),
        signs=POINT,
        notes=(f"table {table}, {rows}" if table else rows,),
        heads={},
    )


def _plain(column: Named) -> Named:
    """Convert dates and durations to seconds; other columns stay numbers or texts."""
    values = np.asarray(column.values)
    if values.dtype.kind == "M":
        values = values - values[~np.isnat(values)][:1] if len(values) else values
    if values.dtype.kind == "m":
        seconds = values.astype("timedelta64[ns]").astype(float) / 1e9
        return Named(column.title, "s", np.where(np.isnat(values), np.nan, seconds))
    if values.dtype.kind in "biuf":
        return column._replace(values=values.astype(float))
    return column._replace(values=["" if value is None else str(value) for value in values])


# Excel


def _excel(data: bytes, name: str, settings: "Settings") -> Layout:
    """Find the table of a sheet: also of .xls, .xlsb and .ods files."""
    require(EXTRA, "python_calamine")
    from python_calamine import CalamineWorkbook

    book = _load("spreadsheet", name, lambda: CalamineWorkbook.from_filelike(io.BytesIO(data)))
    wanted = [sheet for sheet in book.sheet_names if sheet == settings.table] or book.sheet_names
    sheets = _load("spreadsheet", name, lambda: {sheet: _cells_of(book, sheet) for sheet in wanted})
    grids: dict[str, Grid] = {}
    for sheet, cells in sheets.items():
        rows = {line: [_text_of(cell) for cell in row] for line, row in enumerate(cells, 1)}
        if grid := grid_of_rows(rows, f"sheet {sheet}"):
            grids[sheet] = grid
    summaries = {sheet: counted(len(grid.cells), "row") for sheet, grid in grids.items()}
    chosen = _chosen(summaries, name, settings.table)
    typed = any(isinstance(cell, float) for row in sheets[chosen] for cell in row)
    decimal = "." if typed else settings.decimal
    return layout_of_grid(grids[chosen], name, decimal, settings.title_line, settings.unit_line)


def _cells_of(book: Any, sheet: str) -> list[list[Any]]:
    """Cells of a sheet by row, from its first row and column on."""
    cells: list[list[Any]] = book.get_sheet_by_name(sheet).to_python(skip_empty_area=False)
    return cells


def _text_of(cell: object) -> str:
    """Write a cell of a sheet as text; numbers keep all their digits."""
    if isinstance(cell, float):
        return repr(int(cell)) if cell.is_integer() and abs(cell) < 1e15 else repr(cell)
    if isinstance(cell, datetime.datetime):
        return cell.isoformat(sep=" ", timespec="microseconds")
    if isinstance(cell, datetime.date):  # midnight
        return f"{cell.isoformat()} 00:00:00"
    if isinstance(cell, datetime.time):
        return cell.isoformat(timespec="microseconds")
    if isinstance(cell, datetime.timedelta):
        return repr(cell.total_seconds())
    return str(cell).strip()


# MATLAB


def _matlab(data: bytes, name: str) -> Tables:
    """Read a file of MATLAB 4 to 7.2."""
    from scipy.io import loadmat
    from scipy.io.matlab import MatlabOpaque

    variables = _load("MATLAB file", name, lambda: loadmat(io.BytesIO(data), simplify_cells=True))
    objects = [variable for variable in variables.values() if isinstance(variable, MatlabOpaque)]
    classes = {
        variable["s0"].item().decode(): variable["s2"].item().decode() for variable in objects
    }
    return _tables_of_variables(variables, name, classes)


def _matlab_hdf(data: bytes, name: str) -> Tables:
    """Read a file of MATLAB 7.3, which is an HDF5 file."""
    require(EXTRA, "mat73")
    from mat73 import loadmat

    variables = _load("MATLAB file", name, lambda: loadmat(io.BytesIO(data), verbose=False))
    return _tables_of_variables(variables, name, _classes_in(data))


def _classes_in(data: bytes) -> dict[str, str]:
    """Classes of the variables in a file of MATLAB 7.3."""
    import h5py

    with h5py.File(io.BytesIO(data)) as file:
        return {
            key: variable.attrs["MATLAB_class"].decode()
            for key, variable in file.items()
            if "MATLAB_class" in variable.attrs
        }


def _tables_of_variables(
    variables: Mapping[str, Any], name: str, classes: Mapping[str, str]
) -> Tables:
    """Group the columns of each struct, and those of all other variables, by their length.

    Raises
    ------
    RecordingError
        If there is no table. Of tables of MATLAB, which are objects of some `classes`, no library
        reads more than the name.
    """
    tables: dict[str, list[Named]] = {}
    known = {key: value for key, value in variables.items() if not key.startswith("__")}
    structs = {key: value for key, value in known.items() if isinstance(value, Mapping)}
    groups = {key: _columns_in(value) for key, value in structs.items()}
    others = {key: value for key, value in known.items() if key not in structs}
    groups[""] = _columns_in(others)
    for group, columns in groups.items():
        lengths: dict[int, list[Named]] = defaultdict(list)
        for column in columns:
            lengths[len(column.values)].append(column)
        fitting = {n: of for n, of in lengths.items() if _is_table(of)}
        for of in fitting.values():
            first = of[0].title.partition("(")[0]
            key = group if group and len(fitting) == 1 else f"{group}.{first}".strip(".")
            tables[key] = of
    written = [(key, WRITERS[of]) for key, of in classes.items() if of in WRITERS]
    if not tables and written:
        key, write = written[0]
        raise RecordingError(
            f"{name}: {key} is a {classes[key]} object, which only MATLAB can read: type "
            f"{write}({key}, '{key}.csv') in MATLAB, and import {key}.csv"
        )
    if not tables:
        raise RecordingError(f"{no_table(name)} (variables: {', '.join(known) or 'none'})")
    return tables


def _columns_in(variables: Mapping[str, Any], prefix: str = "") -> list[Named]:
    """Columns of the numeric arrays in variables, and in the structs among them."""
    columns: list[Named] = []
    for key, value in variables.items():
        if isinstance(value, Mapping):
            columns += _columns_in(value, f"{prefix}{key}.")
            continue
        array = np.squeeze(np.asarray(value, dtype=None if value is not None else float))
        if array.dtype.kind not in "biuf" or array.ndim not in (1, 2):
            continue
        if array.ndim == 1:
            columns.append(Named(f"{prefix}{key}", "", array))
            continue
        upright = array.shape[0] >= array.shape[1]
        place = "(:,{})" if upright else "({},:)"
        columns += [
            Named(f"{prefix}{key}{place.format(number)}", "", column)
            for number, column in enumerate(array.T if upright else array, 1)
        ]
    return columns


# TDMS


def _tdms(data: bytes, name: str) -> Tables:
    """Read the groups of a TDMS file; a waveform has its time."""
    require(EXTRA, "nptdms")
    from nptdms import TdmsFile

    return _load("TDMS file", name, lambda: _groups(TdmsFile.read(io.BytesIO(data))))


def _groups(file: Any) -> Tables:
    """Tables of the groups of a TDMS file: channels of equal length."""
    tables: dict[str, list[Named]] = {}
    for group in file.groups():
        lengths: dict[int, list[Any]] = defaultdict(list)
        for channel in group.channels():
            lengths[len(channel)].append(channel)
        for length, channels in lengths.items():
            table = group.name if len(lengths) == 1 else f"{group.name} ({length})"
            tables[table] = _waveforms(channels)
    return tables


def _waveforms(channels: Iterable[Any]) -> list[Named]:
    """Columns of channels of equal length, and their time if all have the same."""
    columns, times = [], []
    for channel in channels:
        unit = str(channel.properties.get("unit_string", ""))
        columns.append(Named(channel.name, unit, channel[:]))
        if "wf_increment" in channel.properties:
            times.append(channel.time_track())
    same = times and all(np.array_equal(time, times[0]) for time in times)
    named = any(column.title.casefold() == "time" for column in columns)
    return [Named("time", "s", times[0]), *columns] if same and not named else columns


# LabVIEW


def _lvm(data: bytes, name: str) -> Tables:
    """Segments of a LabVIEW measurement file, joined where their columns and times go on."""
    require(EXTRA, "lvm_read")
    from lvm_read import read_str

    text = decoded(data, name)
    file = _load("LabVIEW measurement file", name, lambda: read_str(text))
    heads = sum(line.startswith("X_Value") for line in text.splitlines())
    if heads != file["Segments"]:
        raise RecordingError(
            f"{name}: of {heads} segments (lines X_Value) only {file['Segments']} can be read: "
            "each segment needs an empty line before its head"
        )
    every = [_segment(file[number], file) for number in range(file["Segments"])]
    joined: list[list[Named]] = []
    for segment in every:
        if joined and _goes_on(joined[-1], segment):
            pairs = zip(joined[-1], segment, strict=True)
            joined[-1] = [a._replace(values=np.append(a.values, b.values)) for a, b in pairs]
        else:
            joined.append(segment)
    whole = len(joined) == 1
    return {"" if whole else str(number): segment for number, segment in enumerate(joined, 1)}


def _segment(segment: Mapping[str, Any], file: Mapping[str, Any]) -> list[Named]:
    """Columns of a segment; without a column of times they are computed from its step."""
    titles = segment["Channel names"]
    values = segment["data"]
    filled = len(titles) - (titles[-1] == "Comment")
    with_time = file.get("X_Columns", "One") != "No"
    units = [unit.strip() for unit in segment.get("Y_Unit_Label", [])]
    dimension = segment.get("X_Dimension", ["Time"])[0].strip()
    x_unit = "s" if dimension in ("", "Time") else ""
    units = [*([x_unit] if with_time else []), *units, *[""] * len(titles)]
    columns = [
        Named(titles[number].strip(), units[number], values[:, number]) for number in range(filled)
    ]
    if with_time:
        return columns
    begin, step = (float(segment.get(key, [np.nan])[0]) for key in ("X0", "Delta_X"))
    return [Named("time", x_unit, begin + step * np.arange(len(values))), *columns]


def _goes_on(before: Sequence[Named], after: Sequence[Named]) -> bool:
    """Whether a segment has the columns of the one before, and later times."""
    same = [column[:2] for column in before] == [column[:2] for column in after]
    return same and bool(len(after[0].values)) and after[0].values[0] > before[0].values[-1]


# Parquet


def _parquet(data: bytes, name: str) -> Tables:
    """Read the table of a Parquet file, with the units that `vibrissa` writes."""
    require(EXTRA, "pyarrow")
    import pandas as pd

    frame = _load("Parquet file", name, lambda: pd.read_parquet(io.BytesIO(data)))
    if not isinstance(frame.index, pd.RangeIndex):
        frame = frame.reset_index()
    units = frame.attrs.get("units", {})
    return {
        "": [
            Named(str(title), str(units.get(title, "")), column.to_numpy())
            for title, column in frame.items()
        ]
    }
