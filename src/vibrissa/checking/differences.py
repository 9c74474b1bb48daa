"""What differs between two tables of the same layout, row by row and column by column."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Self

import numpy as np
import pandas as pd

from vibrissa.checking.layouts import Layout, Tolerance
from vibrissa.numerics.arrays import FloatArray, IntArray

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


@dataclass(frozen=True, kw_only=True)
class Matched:
    """Rows of two tables that have the same keys; of rows that stand twice the first counts.

    Attributes
    ----------
    every : tuple of Index
        Keys of all rows of both tables, as text.
    rows : tuple of array of int
        Where the common rows stand in each, in the order of the first.
    """

    every: tuple[pd.Index, pd.Index]
    rows: tuple[IntArray, IntArray]

    @classmethod
    def of(cls, old: pd.Index, new: pd.Index) -> Self:
        """Match rows by their keys."""
        first, other = (np.flatnonzero(~index.duplicated()) for index in (old, new))
        place = new[other].get_indexer(old[first])
        both = place >= 0
        return cls(every=(old, new), rows=(first[both], other[place[both]]))

    def __len__(self) -> int:
        """Count the common rows."""
        return len(self.rows[0])

    def moved(self, old: pd.Series, new: pd.Series, tolerance: Tolerance | None) -> pd.DataFrame:
        """Find the values of a column that moved.

        Parameters
        ----------
        old, new : Series of str
            The column of either table, all rows.
        tolerance : Tolerance or None

        Returns
        -------
        DataFrame of str
            ``before`` and ``after``; the index has the keys.
        """
        before, after = (
            column.take(rows).reset_index(drop=True)
            for column, rows in zip((old, new), self.rows, strict=True)
        )
        changed = moved(before, after, tolerance)
        return pd.DataFrame(
            {"before": before.array[changed], "after": after.array[changed]},
            index=self.every[0][self.rows[0][changed]],
        )

    def differences(self, table: str, sides: tuple[str, str]) -> list[Difference]:
        """Rows that one table alone has, or that stand twice.

        Parameters
        ----------
        table : str
            Name of the table.
        sides : tuple of str
            What the two are called.
        """
        found = []
        for index, where in zip(self.every, sides, strict=True):
            twice = index[index.duplicated()]
            found += _rows(table, Problem.DOUBLED, f"stand twice in {where}", twice)
        was, now = (index.unique() for index in self.every)
        found += _rows(table, Problem.MISSING, "are missing", was.difference(now))
        return found + _rows(table, Problem.EXTRA, "are extra", now.difference(was))


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
    matched = Matched.of(*(table.set_index(keys).index for table in (reference, found)))
    differences += matched.differences(name, sides)
    for column, tolerance in layout.columns.items():
        if column in reference:
            values = matched.moved(reference[column], found[column], tolerance)
            if len(values):
                differences.append(moved_column(name, column, values, len(matched)))
    return differences


def _rows(table: str, problem: Problem, words: str, rows: pd.Index) -> list[Difference]:
    """Difference of rows that stand in one of two tables alone, or twice; empty for no rows."""
    if not len(rows):
        return []
    examples = [_row(rows.names, row) for row in rows[:SHOWN]]
    shown = "; ".join(map(_spell_row, examples)) + ("; ..." if len(rows) > SHOWN else "")
    text = f"{table}: {len(rows)} rows {words}: {shown}"
    return [Difference(table=table, problem=problem, rows=len(rows), text=text, examples=examples)]


def _row(keys: Sequence[str], row: Any) -> dict[str, str]:
    """Keys of a row by their names."""
    return dict(zip(keys, row if isinstance(row, tuple) else (row,), strict=True))


def _spell_row(row: Mapping[str, str]) -> str:
    return ", ".join(f"{key} {value}" for key, value in row.items())


def moved_column(table: str, column: str, values: pd.DataFrame, of: int) -> Difference:
    """Difference of a column, of whose values those that moved are given.

    Parameters
    ----------
    table, column : str
    values : DataFrame of str
        As `Matched.moved` has them.
    of : int
        How many rows were compared.
    """
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
        As `Matched.moved` has them.

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
