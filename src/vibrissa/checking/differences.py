"""Differences between two tables of the same layout, by row and by column."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from vibrissa.checking.tolerances import TableLayout, Tolerance
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.wording import counted

# Largest number of rows in a message.
SHOWN = 3


@dataclass(frozen=True, kw_only=True)
class Difference:
    """A difference between the results and the reference, described by one line of text.

    Attributes
    ----------
    column : str
        Column whose values differ; empty if the difference concerns rows or a whole table.
    absolute, relative : float or None
        Largest change of a number in the column, and largest ratio of a change to the larger of
        the old and the new magnitude; None if no number changed, or if a change is infinite.
    """

    table: str
    problem: str
    text: str
    column: str = ""
    rows: int = 0
    absolute: float | None = None
    relative: float | None = None


def compare(
    pairs: Iterable[tuple[pd.DataFrame, pd.DataFrame]], layout: TableLayout, name: str
) -> Iterator[Difference]:
    """Find columns with changed values, and rows that are missing, extra or doubled.

    Parameters
    ----------
    pairs : iterable of tuple of DataFrame
        Parts of the reference and of the results, each pair with the same keys. They hold texts, as
        `vibrissa.checking.reference.as_text` returns them.
    """
    keys, rows, columns = layout.keys, dict[str, _Rows](), dict[str, _Moved]()
    told, total = False, 0
    for reference, found in pairs:
        others = _other_columns(reference, layout, name)
        if others and not told:
            told = True
            yield others
        if set(keys) - set(reference):
            return
        sides = {"twice in the reference": reference, "twice in the results": found}
        for where, frame in sides.items():
            _add(rows, where, "rows doubled", frame[frame.duplicated(keys)][keys])
        pairs_of_rows = reference.drop_duplicates(keys).merge(
            found.drop_duplicates(keys),
            on=keys,
            how="outer",
            suffixes=("", " now"),
            indicator="side",
        )
        side = pairs_of_rows["side"]
        _add(rows, "missing", "rows missing", pairs_of_rows.loc[side == "left_only", keys])
        extra = pairs_of_rows.loc[side == "right_only", keys]
        _add(rows, "not in the reference", "rows extra", extra)
        both = pairs_of_rows[side == "both"]
        total += len(both)
        for column, tolerance in layout.columns.items():
            if column in reference:
                was, now = both[column], both[f"{column} now"]
                changed = moved(was, now, tolerance)
                if changed.any():
                    more = _moved_rows(both[keys].assign(was=was, now=now)[changed])
                    columns[column] = more.joined(columns.get(column))
    yield from (one.difference(name, words) for words, one in rows.items())
    for column in layout.columns:
        if column in columns:
            yield columns[column].difference(name, column, total)


def _other_columns(reference: pd.DataFrame, layout: TableLayout, name: str) -> Difference | None:
    """Return the difference of the columns, if there is one."""
    columns = [*layout.keys, *layout.columns]
    absent = [column for column in columns if column not in reference]
    more = [column for column in reference if column not in columns]
    if not (absent or more):
        return None
    new, gone = (", ".join(some) or "none" for some in (absent, more))
    text = f"{name}: the columns differ from the reference: new {new}, gone {gone}"
    if set(layout.keys) & set(absent):
        text += "; its rows cannot be identified: review the results, then make bless"
    return Difference(table=name, problem="other columns", text=text)


@dataclass(frozen=True, kw_only=True)
class _Rows:
    """Rows that are missing, extra or doubled: their number, and the texts of the first."""

    problem: str
    count: int
    shown: list[str]

    def difference(self, table: str, words: str) -> Difference:
        """Describe the rows."""
        more = "; ..." if self.count > SHOWN else ""
        text = f"{table}: {counted(self.count, 'row')} {words}: {'; '.join(self.shown)}{more}"
        return Difference(table=table, problem=self.problem, rows=self.count, text=text)


def _add(rows: dict[str, _Rows], words: str, problem: str, more: pd.DataFrame) -> None:
    """Add rows of a part to those of the parts before it."""
    if len(more):
        before = rows.get(words, _Rows(problem=problem, count=0, shown=[]))
        shown = [*before.shown, *map(spell_row, more.head(SHOWN).to_dict("records"))][:SHOWN]
        count = before.count + len(more)
        rows[words] = _Rows(problem=problem, count=count, shown=shown)


@dataclass(frozen=True, kw_only=True)
class _Moved:
    """Changes in a column: their number, and the largest, at a place; see `Difference`."""

    rows: int
    change: float
    share: float
    place: str
    was: str
    now: str

    def joined(self, other: "_Moved | None") -> "_Moved":
        """Join the changes of two parts."""
        if other is None:
            return self
        most = max(other, self, key=lambda one: -1.0 if np.isnan(one.change) else one.change)
        share = float(np.fmax(self.share, other.share))
        return replace(most, rows=self.rows + other.rows, share=share)

    def difference(self, table: str, column: str, total: int) -> Difference:
        """Describe the changes, in so many rows of `total`."""
        known, by = bool(np.isfinite(self.change)), ""
        if known:
            by = f"by up to {self.change:.2g} (relative {self.share:.2g}) "
        return Difference(
            table=table,
            column=column,
            problem="moved",
            rows=self.rows,
            absolute=self.change if known else None,
            relative=self.share if known else None,
            text=f"{table}.{column}: {self.rows} of {total} rows moved {by}at {self.place} "
            f"({self.was or 'nothing'} -> {self.now or 'nothing'})",
        )


def moved(before: pd.Series, after: pd.Series, tolerance: Tolerance) -> BoolArray:
    """Return which texts changed; a change of a number within the tolerance does not count."""
    was, now = _numbers(before), _numbers(after)
    with np.errstate(invalid="ignore"):  # infinity less infinity
        near = np.abs(now - was) <= tolerance.absolute + tolerance.relative * np.abs(was)
    # A missing or infinite reference allows no change.
    differs: BoolArray = (before != after).to_numpy()
    return differs & ~(near & np.isfinite(was))


def _numbers(column: pd.Series) -> FloatArray:
    return pd.to_numeric(column, errors="coerce").to_numpy(dtype=float)


def spell_row(row: Mapping[Any, Any]) -> str:
    """Format the keys of a row as ``theta 2, mu0 0.4``, without keys whose value is empty or 0."""
    return ", ".join(f"{key} {value}" for key, value in row.items() if value not in ("", "0"))


def _moved_rows(rows: pd.DataFrame) -> _Moved:
    """Summarise changed rows, which have keys and the texts ``was`` and ``now``."""
    was, now = _numbers(rows["was"]), _numbers(rows["now"])
    with np.errstate(divide="ignore", invalid="ignore"):  # infinity less infinity
        change = np.abs(now - was)
        share = change / np.maximum(np.abs(was), np.abs(now))
    largest = int(np.where(np.isnan(change), -1.0, change).argmax())
    *keys, before, after = rows.iloc[largest].items()
    return _Moved(
        rows=len(rows),
        change=float(change[largest]),
        share=float(np.fmax.reduce(share)),
        place=spell_row(dict(keys)),
        was=str(before[1]),
        now=str(after[1]),
    )
