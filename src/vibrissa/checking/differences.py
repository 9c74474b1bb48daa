"""What differs between two tables of the same layout, row by row and column by column."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from vibrissa.checking.layouts import Layout, Tolerance
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.wording import counted

# Rows that a message names.
SHOWN = 3


@dataclass(frozen=True, kw_only=True)
class Difference:
    """A deviation from the reference, with a line of text.

    Attributes
    ----------
    column : str
        The column that moved, or empty.
    absolute, relative : float or None
        Largest changes of a column of numbers, if they are finite.
    """

    table: str
    problem: str
    text: str
    column: str = ""
    rows: int = 0
    absolute: float | None = None
    relative: float | None = None

    def __str__(self) -> str:
        """Return the line for people."""
        return self.text


def compare(
    reference: pd.DataFrame, found: pd.DataFrame, layout: Layout, name: str
) -> Iterator[Difference]:
    """Find each column that moved, and rows that are missing, extra or doubled."""
    keys, columns = list(layout.keys), [*layout.keys, *layout.columns]
    if list(reference.columns) != columns:
        absent = ", ".join(column for column in columns if column not in reference) or "none"
        more = ", ".join(column for column in reference if column not in columns) or "none"
        text = f"{name}: other columns than the reference: new {absent}, gone {more}"
        if set(keys) - set(reference):
            text += "; its rows cannot be identified: review the results, then make bless"
        yield Difference(table=name, problem="other columns", text=text)
        if set(keys) - set(reference):
            return
    for frame, where in ((reference, "the reference"), (found, "the results")):
        twice = frame[frame.duplicated(keys)]
        yield from _rows(name, "rows doubled", f"twice in {where}", twice[keys])
    pairs = reference.drop_duplicates(keys).merge(
        found.drop_duplicates(keys), on=keys, how="outer", suffixes=("", " now"), indicator="side"
    )
    only = {side: pairs.loc[pairs["side"] == side, keys] for side in ("left_only", "right_only")}
    yield from _rows(name, "rows missing", "missing", only["left_only"])
    yield from _rows(name, "rows extra", "not in the reference", only["right_only"])
    both = pairs[pairs["side"] == "both"].reset_index(drop=True)
    for column, tolerance in layout.columns.items():
        if column in reference:
            before, after = both[column], both[f"{column} now"]
            changed = moved(before, after, tolerance)
            if changed.any():
                yield _moved_column(name, column, both[keys], before, after, changed)


def moved(before: pd.Series, after: pd.Series, tolerance: Tolerance | None) -> BoolArray:
    """Mark values beyond the tolerance of their reference; without one, those of another text."""
    differs: BoolArray = (before != after).to_numpy()
    if tolerance is None:
        return differs
    was, now = _numbers(before), _numbers(after)
    with np.errstate(invalid="ignore"):  # infinity less infinity
        near = np.abs(now - was) <= tolerance.absolute + tolerance.relative * np.abs(was)
    # A missing or infinite reference allows no change.
    return differs & ~(near & np.isfinite(was))


def _numbers(column: pd.Series) -> FloatArray:
    return pd.to_numeric(column, errors="coerce").to_numpy(dtype=float)


def _finite(number: float) -> float | None:
    return float(number) if np.isfinite(number) else None


def _rows(table: str, problem: str, words: str, rows: pd.DataFrame) -> Iterator[Difference]:
    """Difference for missing, extra or doubled rows; nothing without such rows."""
    if len(rows):
        shown = "; ".join(spell_row(row) for row in rows.head(SHOWN).to_dict("records"))
        more = "; ..." if len(rows) > SHOWN else ""
        text = f"{table}: {counted(len(rows), 'row')} {words}: {shown}{more}"
        yield Difference(table=table, problem=problem, rows=len(rows), text=text)


def spell_row(row: Mapping[str, str]) -> str:
    """Spell the keys of a row that are neither empty nor 0."""
    return ", ".join(f"{key} {value}" for key, value in row.items() if value not in ("", "0"))


def _moved_column(
    table: str,
    column: str,
    keys: pd.DataFrame,
    before: pd.Series,
    after: pd.Series,
    changed: BoolArray,
) -> Difference:
    """Difference of a column of which some values moved."""
    was, now = _numbers(before[changed]), _numbers(after[changed])
    with np.errstate(divide="ignore", invalid="ignore"):  # infinity less infinity
        change = np.abs(now - was)
        share = change / np.maximum(np.abs(was), np.abs(now))
    numbers = bool(np.isfinite(change).any())
    largest = int(np.nanargmax(change)) if numbers else 0
    place = np.flatnonzero(changed)[largest]
    row = spell_row(keys.iloc[place].to_dict())
    values = f"{before.iloc[place] or 'nothing'} -> {after.iloc[place] or 'nothing'}"
    how = f"by up to {change[largest]:.2g} (relative {np.nanmax(share):.2g}) " if numbers else ""
    return Difference(
        table=table,
        column=column,
        problem="moved",
        rows=int(changed.sum()),
        absolute=_finite(change[largest]),
        relative=_finite(np.nanmax(share)) if numbers else None,
        text=f"{table}.{column}: {changed.sum()} of {len(keys)} rows moved {how}"
        f"at {row} ({values})",
    )
