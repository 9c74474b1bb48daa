"""What differs between two tables of the same layout, row by row and column by column."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np
import pandas as pd

from vibrissa.checking.layouts import Layout, Tolerance
from vibrissa.numerics.arrays import FloatArray

# Rows that a message names.
SHOWN = 3


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
    REFUTED
        Values of a column that are further from their enclosures than they may move.
    """

    GONE = "table gone"
    NEW = "table new"
    COLUMNS = "other columns"
    DOUBLED = "rows doubled"
    MISSING = "rows missing"
    EXTRA = "rows extra"
    MOVED = "moved"
    REFUTED = "refuted"


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


def _numbers(column: pd.Series) -> FloatArray:
    return pd.to_numeric(column, errors="coerce").to_numpy(dtype=float)


def moved(old: pd.Series, new: pd.Series, tolerance: Tolerance | None) -> Any:
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
            changed = moved(old[column], new[column], tolerance)
            if changed.any():
                values = {"before": old[column][changed], "after": new[column][changed]}
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
