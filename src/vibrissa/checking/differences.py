"""Differences between two tables of the same layout, by row and by column."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from vibrissa.checking.tolerances import Layout, Tolerance
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
    reference: pd.DataFrame, found: pd.DataFrame, layout: Layout, name: str
) -> Iterator[Difference]:
    """Find columns with changed values, and rows that are missing, extra or doubled.

    Both tables hold texts, as `vibrissa.checking.reference.as_text` returns them.
    """
    keys, columns = layout.keys, [*layout.keys, *layout.columns]
    absent = [column for column in columns if column not in reference]
    more = [column for column in reference if column not in columns]
    cannot_be_identified = set(keys) & set(absent)
    if absent or more:
        new, gone = (", ".join(some) or "none" for some in (absent, more))
        text = f"{name}: the columns differ from the reference: new {new}, gone {gone}"
        if cannot_be_identified:
            text += "; its rows cannot be identified: review the results, then make bless"
        yield Difference(table=name, problem="other columns", text=text)
    if cannot_be_identified:
        return
    for frame, where in ((reference, "the reference"), (found, "the results")):
        yield from _rows(name, "rows doubled", f"twice in {where}", frame[frame.duplicated(keys)])
    pairs = reference.drop_duplicates(keys).merge(
        found.drop_duplicates(keys), on=keys, how="outer", suffixes=("", " now"), indicator="side"
    )
    only = {side: pairs.loc[pairs["side"] == side, keys] for side in ("left_only", "right_only")}
    yield from _rows(name, "rows missing", "missing", only["left_only"])
    yield from _rows(name, "rows extra", "not in the reference", only["right_only"])
    both = pairs[pairs["side"] == "both"]
    for column, tolerance in layout.columns.items():
        if column in reference:
            rows = both[keys].assign(was=both[column], now=both[f"{column} now"])
            changed = moved(rows["was"], rows["now"], tolerance)
            if changed.any():
                yield _moved_column(name, column, rows[changed], len(rows))


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


def _rows(table: str, problem: str, words: str, rows: pd.DataFrame) -> Iterator[Difference]:
    """Yield a difference if there are missing, extra or doubled rows."""
    if len(rows):
        shown = "; ".join(spell_row(row) for row in rows.head(SHOWN).to_dict("records"))
        more = "; ..." if len(rows) > SHOWN else ""
        text = f"{table}: {counted(len(rows), 'row')} {words}: {shown}{more}"
        yield Difference(table=table, problem=problem, rows=len(rows), text=text)


def spell_row(row: Mapping[Any, Any]) -> str:
    """Format the keys of a row as ``theta 2, mu0 0.4``, without keys whose value is empty or 0."""
    return ", ".join(f"{key} {value}" for key, value in row.items() if value not in ("", "0"))


def _moved_column(table: str, column: str, rows: pd.DataFrame, total: int) -> Difference:
    """Describe the changes of a column; `rows` has keys and the texts ``was`` and ``now``."""
    was, now = _numbers(rows["was"]), _numbers(rows["now"])
    with np.errstate(divide="ignore", invalid="ignore"):  # infinity less infinity
        change = np.abs(now - was)
        share = change / np.maximum(np.abs(was), np.abs(now))
    largest = int(np.where(np.isnan(change), -1.0, change).argmax())
    absolute = relative = None
    by = ""
    if np.isfinite(change[largest]):
        absolute, relative = float(change[largest]), float(np.nanmax(share))
        by = f"by up to {absolute:.2g} (relative {relative:.2g}) "
    *keys, before, after = rows.iloc[largest].items()
    return Difference(
        table=table,
        column=column,
        problem="moved",
        rows=len(rows),
        absolute=absolute,
        relative=relative,
        text=f"{table}.{column}: {len(rows)} of {total} rows moved {by}at {spell_row(dict(keys))} "
        f"({before[1] or 'nothing'} -> {after[1] or 'nothing'})",
    )
