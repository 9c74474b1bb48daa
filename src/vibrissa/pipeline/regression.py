"""Reference tables: results as text that reads well in a diff, and what moved against them.

A results folder is condensed to a few tables with one row for each key. Floats are written with
`DIGITS` digits; what a table holds and how far a number may move is said by its `Layout`.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import yaml

from vibrissa.errors import ComparisonError
from vibrissa.files import write_atomically
from vibrissa.numerics.arrays import FloatArray
from vibrissa.tables import schemas, store
from vibrissa.tables.frames import to_pandas

# Fewer than a double has, more than any tolerance asks for.
DIGITS = 12
# Rows that a message names.
SHOWN = 3


@dataclass(frozen=True)
class Tolerance:
    """How far a number may be from its reference: |change| ≤ absolute + relative·|reference|."""

    absolute: float
    relative: float


@dataclass(frozen=True)
class Layout:
    """What a reference table holds.

    Attributes
    ----------
    keys : tuple of str
        Columns that tell its rows apart.
    columns : dict
        Tolerance of each further column; None where it must be the same.
    """

    keys: tuple[str, ...]
    columns: dict[str, Tolerance | None]


class Problem(StrEnum):
    """What is different.

    Attributes
    ----------
    GONE, NEW
        A table that the reference or the results alone have.
    COLUMNS
        Other columns.
    DOUBLED
        Rows that stand twice.
    MISSING, EXTRA
        Rows that the reference or the results alone have.
    MOVED
        Values of a column.
    """

    GONE = "table gone"
    NEW = "table new"
    COLUMNS = "other columns"
    DOUBLED = "rows doubled"
    MISSING = "rows missing"
    EXTRA = "rows extra"
    MOVED = "moved"


@dataclass(frozen=True, kw_only=True)
class Change:
    """A value before and after, as text, empty for nothing; and the row that it stands in."""

    row: Mapping[str, str]
    before: str
    after: str
    size: float | None  # absolute or relative; None where it is no number

    def __str__(self) -> str:
        """Say where it is, and the values."""
        before, after = self.before or "nothing", self.after or "nothing"
        return f"at {_spell_row(self.row)} ({before} -> {after})"


@dataclass(frozen=True, kw_only=True)
class Difference:
    """Something that is not as its reference.

    Attributes
    ----------
    table : str
    problem : Problem
    text : str
        One line for people.
    column : str
        The column that moved, or empty.
    rows : int
        How many rows are concerned.
    of : int
        Rows in which a column was compared.
    absolute, relative : Change or None
        Largest changes of a column of numbers.
    examples : list
        Keys of the first rows that are missing, extra or doubled.
    """

    table: str
    problem: Problem
    text: str
    column: str = ""
    rows: int = 0
    of: int = 0
    absolute: Change | None = None
    relative: Change | None = None
    examples: Sequence[Mapping[str, str]] = ()

    def __str__(self) -> str:
        """Return the line for people."""
        return self.text


def parse_layouts(text: str, where: str) -> dict[str, Layout]:
    """Read the layouts of reference tables.

    Parameters
    ----------
    text : str
        YAML: for each table ``keys``, a list, and ``columns``, each ``exact`` or ``{absolute: a,
        relative: r}``.
    where : str
        Name of the file, for messages.

    Returns
    -------
    dict of Layout
        By table.

    Raises
    ------
    ComparisonError
    """
    try:
        content = yaml.safe_load(text)
        return {
            name: Layout(
                tuple(table["keys"]),
                {column: _tolerance(value) for column, value in table["columns"].items()},
            )
            for name, table in content.items()
        }
    except (yaml.YAMLError, KeyError, TypeError, AttributeError, ValueError) as error:
        raise ComparisonError(
            f"{where} does not say what to compare ({error}); allowed: for each table keys: a "
            "list, and columns: each exact or {absolute: number, relative: number}"
        ) from None


def _tolerance(value: Any) -> Tolerance | None:
    if value == "exact":
        return None
    tolerance = Tolerance(float(value["absolute"]), float(value["relative"]))
    if len(value) > 2 or not (tolerance.absolute >= 0.0 and tolerance.relative >= 0.0):
        raise ValueError(f"{value} is no tolerance")
    return tolerance


def condensed(folder: Path) -> dict[str, pd.DataFrame]:
    """Condense the tables of a results folder; see `condense`.

    Parameters
    ----------
    folder : Path
        ``results/<study>``.

    Returns
    -------
    dict of DataFrame
        By name of the reference table.

    Raises
    ------
    ComparisonError
        If there are no results.
    TableError
        If a table is damaged.
    """
    if not (folder / "tables/stiction.parquet").is_file():
        raise ComparisonError(f"{folder} has no tables/stiction.parquet; run the study first")
    found = {
        name: store.read(path, schemas.TABLES[name])
        for name in ("stiction", "scans", "states")
        if (path := folder / f"tables/{name}.parquet").is_file()
    }
    return condense(found)


def condense(found: Mapping[str, pa.Table]) -> dict[str, pd.DataFrame]:
    """Condense tables to what is compared.

    Parameters
    ----------
    found : mapping of pyarrow.Table
        ``stiction`` and, where the study has them, ``scans`` and ``states``.

    Returns
    -------
    dict of DataFrame
        ``stiction``; ``curves``, one row for each θ and η; ``scans``, one row for each cycle;
        ``states``.
    """
    rows = to_pandas(found["stiction"])
    of_curve = [
        "study",
        "method",
        "theta",
        "eta",
        "x1_init",
        "mu_lock",
        *(n for n in rows if n.endswith("_init")),
    ]
    result = {
        "stiction": rows,
        "curves": rows[list(dict.fromkeys(of_curve))].drop_duplicates(),
    }
    if "scans" in found:
        result["scans"] = _cycles(found["scans"])
    if "states" in found:
        states = to_pandas(found["states"])
        result["states"] = states.assign(top=[_largest(shape) for shape in states["shape_y"]])
    return result


def _largest(values: Any) -> float:
    return max(values, default=np.nan)


def _cycles(table: pa.Table) -> pd.DataFrame:
    """One row for each cycle of each scan."""
    rows = to_pandas(table)
    # Of each shape where its middle is and how high it reaches.
    rows["middle_x"] = [shape[len(shape) // 2] if len(shape) else np.nan for shape in rows.shape_x]
    rows["middle_y"] = [shape[len(shape) // 2] if len(shape) else np.nan for shape in rows.shape_y]
    rows["top"] = [_largest(shape) for shape in rows.shape_y]
    keys = ["scan", "theta", "mu0", "eta", "dx0", "cycle"]
    return (
        rows.groupby(keys, dropna=False)
        .agg(
            study=("study", "last"),
            method=("method", "last"),
            status=("status", "last"),
            steps=("step", "max"),
            slips=("phase", lambda phase: int((phase == "slip").sum())),
            footpoint_end=("footpoint", "last"),
            x0_largest=("x0", "max"),
            x1_begin=("x1", "first"),
            x1_end=("x1", "last"),
            f_largest=("f", "max"),
            alpha_smallest=("alpha", "min"),
            phi1_smallest=("phi1", "min"),
            m_smallest=("reaction_m", "min"),
            m_largest=("reaction_m", "max"),
            middle_x_mean=("middle_x", "mean"),
            middle_y_mean=("middle_y", "mean"),
            top=("top", "max"),
        )
        .reset_index()
    )


def as_text(frame: pd.DataFrame, layout: Layout, name: str) -> pd.DataFrame:
    """Text of a table, as it is written, in the order of its keys.

    Parameters
    ----------
    frame : DataFrame
    layout : Layout
    name : str
        Name of the table, for messages.

    Returns
    -------
    DataFrame of str
        The keys and the columns of the layout; an empty text stands for nothing.

    Raises
    ------
    ComparisonError
        If a column is not there.
    """
    names = [*layout.keys, *layout.columns]
    if unknown := [column for column in names if column not in frame]:
        raise ComparisonError(
            f"{name} has no column {', '.join(unknown)}; it has {', '.join(map(str, frame))}"
        )
    ordered = frame.sort_values(list(layout.keys))
    return pd.DataFrame({column: [_spell(v) for v in ordered[column]] for column in names})


def _spell(value: Any) -> str:
    if pd.isna(value):
        return ""
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, float | np.floating):
        return f"{value + 0.0:.{DIGITS}g}"  # + 0.0 turns -0.0 into 0.0
    return str(value)


def read(path: Path) -> pd.DataFrame:
    """Read a reference table as text.

    Parameters
    ----------
    path : Path

    Returns
    -------
    DataFrame of str

    Raises
    ------
    ComparisonError
        If the file is not a table.
    """
    try:
        return pd.read_csv(path, dtype=str, keep_default_na=False, index_col=False)
    except ValueError as error:  # pandas' own errors and undecodable bytes are among them
        raise ComparisonError(
            f"{path} is not a table ({str(error).strip()}); restore it from version control, or "
            "delete it and make it anew with: make bless"
        ) from None


def write(text: pd.DataFrame, path: Path) -> None:
    """Write a reference table whole or not at all."""
    with write_atomically(path) as temporary:
        text.to_csv(temporary, index=False, lineterminator="\n")


def _numbers(column: pd.Series) -> FloatArray:
    return pd.to_numeric(column, errors="coerce").to_numpy(dtype=float)


def _moved(old: pd.Series, new: pd.Series, tolerance: Tolerance | None) -> Any:
    """Which values are not their references."""
    differs = (old != new).to_numpy()
    if tolerance is None:
        return differs
    was, now = _numbers(old), _numbers(new)
    with np.errstate(invalid="ignore"):  # infinity less infinity
        near = np.abs(now - was) <= tolerance.absolute + tolerance.relative * np.abs(was)
    # Nothing is near to nothing or to infinity.
    return differs & ~(near & np.isfinite(was))


def moved_values(
    reference: pd.DataFrame, found: pd.DataFrame, layout: Layout
) -> dict[str, pd.DataFrame]:
    """Find the values that moved, in the rows that both tables have.

    Parameters
    ----------
    reference, found : DataFrame of str
        As `as_text` makes them, with all columns of the layout.
    layout : Layout

    Returns
    -------
    dict of DataFrame
        For each column that moved ``before`` and ``after``, text; the index has the keys.
    """
    old, new, _ = _matched(reference, found, layout)
    return dict(_moved_values(old, new, layout))


def _matched(
    reference: pd.DataFrame, found: pd.DataFrame, layout: Layout
) -> tuple[pd.DataFrame, pd.DataFrame, tuple[pd.Index, pd.Index]]:
    """Rows of the same keys, in the same order; and all keys of both, where some stand twice."""
    keys = list(layout.keys)
    old, new = reference.set_index(keys), found.set_index(keys)
    every = old.index, new.index
    old, new = (rows[~rows.index.duplicated()] for rows in (old, new))
    common = old.index.intersection(new.index, sort=False)
    return old.loc[common], new.loc[common], every


def _moved_values(
    old: pd.DataFrame, new: pd.DataFrame, layout: Layout
) -> Iterator[tuple[str, pd.DataFrame]]:
    for column, tolerance in layout.columns.items():
        if column in old:
            moved = _moved(old[column], new[column], tolerance)
            if moved.any():
                values = {"before": old[column][moved], "after": new[column][moved]}
                yield column, pd.DataFrame(values)


def compare(
    reference: pd.DataFrame,
    found: pd.DataFrame,
    layout: Layout,
    name: str,
    sides: tuple[str, str] = ("the reference", "the results"),
) -> list[Difference]:
    """Find what moved.

    Parameters
    ----------
    reference, found : DataFrame of str
        As `as_text` makes them.
    layout : Layout
    name : str
        Name of the table.
    sides : tuple of str, optional
        What the two tables are called.

    Returns
    -------
    list of Difference
        One for each column that moved, and for rows that are missing, extra or doubled; empty if
        nothing moved.
    """
    differences = []
    columns = [*layout.keys, *layout.columns]
    if list(reference.columns) != columns:
        absent = ", ".join(column for column in columns if column not in reference) or "none"
        more = ", ".join(column for column in reference if column not in columns) or "none"
        text = f"{name}: other columns than the reference: new {absent}, gone {more}"
        differences.append(Difference(table=name, problem=Problem.COLUMNS, text=text))
        if set(layout.keys) - set(reference):
            return differences
    keys = list(layout.keys)
    old, new, every = _matched(reference, found, layout)
    for index, where in zip(every, sides, strict=True):
        twice = index[index.duplicated()]
        differences += _rows(name, Problem.DOUBLED, f"stand twice in {where}", keys, twice)
    was, now = (index.unique() for index in every)
    differences += _rows(name, Problem.MISSING, "are missing", keys, was.difference(now))
    differences += _rows(name, Problem.EXTRA, "are extra", keys, now.difference(was))
    differences += (
        _moved_column(name, column, values, len(old))
        for column, values in _moved_values(old, new, layout)
    )
    return differences


def _rows(
    table: str, problem: Problem, words: str, keys: Sequence[str], rows: pd.Index
) -> list[Difference]:
    """Difference of rows that stand in one of two tables alone, or twice; empty for no rows."""
    if not len(rows):
        return []
    examples = [_row(keys, row) for row in rows[:SHOWN]]
    shown = "; ".join(map(_spell_row, examples)) + ("; ..." if len(rows) > SHOWN else "")
    text = f"{table}: {len(rows)} rows {words}: {shown}"
    return [Difference(table=table, problem=problem, rows=len(rows), text=text, examples=examples)]


def _row(keys: Sequence[str], row: Any) -> dict[str, str]:
    """Keys of a row by their names."""
    return dict(zip(keys, row if isinstance(row, tuple) else (row,), strict=True))


def _spell_row(row: Mapping[str, str]) -> str:
    return ", ".join(f"{key} {value}" for key, value in row.items())


def _moved_column(table: str, column: str, values: pd.DataFrame, of: int) -> Difference:
    """Difference of a column, of whose values those that moved are given."""
    absolute, relative, text = _largest_change(values)
    return Difference(
        table=table,
        column=column,
        problem=Problem.MOVED,
        rows=len(values),
        of=of,
        absolute=absolute,
        relative=relative,
        text=f"{table}.{column}: {len(values)} of {of} rows moved; {text}",
    )


def changes(values: pd.DataFrame) -> tuple[FloatArray, FloatArray]:
    """Absolute and relative changes of values that moved.

    Parameters
    ----------
    values : DataFrame of str
        As `moved_values` has them.

    Returns
    -------
    tuple of array, shape (rows,)
        Magnitudes of after − before, in the unit of the column and divided by the larger of the
        two magnitudes; NaN where one is no number.
    """
    was, now = _numbers(values["before"]), _numbers(values["after"])
    with np.errstate(divide="ignore", invalid="ignore"):  # infinity less infinity
        change = np.abs(now - was)
        return change, change / np.maximum(np.abs(was), np.abs(now))


def change_at(values: pd.DataFrame, index: int, size: float | None) -> Change:
    """Return one of the values that moved, by its position."""
    row = _row(values.index.names, values.index[index])
    before, after = values.iloc[index][["before", "after"]]
    return Change(row=row, before=before, after=after, size=size)


def _largest_change(values: pd.DataFrame) -> tuple[Change | None, Change | None, str]:
    """Largest absolute and relative change and where, if any is a number; and both in words."""
    change, share = changes(values)

    def at(index: int, size: float | None) -> Change:
        return change_at(values, index, size)

    if not np.isfinite(change).any():
        return None, None, str(at(0, None))
    far, much = int(np.nanargmax(change)), int(np.nanargmax(share))
    absolute, relative = at(far, float(change[far])), at(much, float(share[much]))
    text = f"by up to {change[far]:.2g} {absolute}, relative {share[much]:.2g}"
    if much != far:
        text += f" {relative}"
    if lost := int(np.isnan(change).sum()):
        example = at(int(np.argmax(np.isnan(change))), None)
        text += f"; {lost} of them to or from nothing, such as {example}"
    return absolute, relative, text


def blessed(reference: pd.DataFrame | None, found: pd.DataFrame, layout: Layout) -> pd.DataFrame:
    """Make a reference table anew, in which what did not move keeps its spelling.

    Parameters
    ----------
    reference : DataFrame of str or None
        The table that is there.
    found : DataFrame of str
    layout : Layout

    Returns
    -------
    DataFrame of str
    """
    keys = list(layout.keys)
    if reference is None or set(keys) - set(reference):
        return found
    result = found.set_index(keys)
    old = reference.drop_duplicates(keys).set_index(keys).reindex(result.index)
    for column, tolerance in layout.columns.items():
        if column in old:
            stays = old[column].notna().to_numpy()
            before = old[column].where(stays, "")
            stays = stays & ~_moved(before, result[column], tolerance)
            result[column] = result[column].where(~stays, before)
    return result.reset_index()
