"""Results beside proofs: how far each number is from the true value.

The enclosures of a study stand in ``enclosures.csv`` beside its reference tables;
`python -m validation proof` writes them.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Any

import pandas as pd

from vibrissa.checking.differences import Difference, Problem
from vibrissa.checking.layouts import Layout, Tolerance
from vibrissa.tables.proofs import FILE, KEYS, read, spell_key

# Bounds of the histogram, in units in the last place: up to 0.5 it is the nearest double.
BOUNDS = (0.5, 1.0, 10.0, 100.0, 1000.0)


@dataclass(frozen=True, kw_only=True)
class Enclosed:
    """A number of the results, and the enclosure of the true one.

    Attributes
    ----------
    row : mapping of str
        Keys of the row.
    value : float
        What was computed.
    midpoint, radius : Decimal
        Enclosure of the true value.
    tolerance : Tolerance or None
        How far the column may move; None where it is exact.
    """

    table: str
    column: str
    row: Mapping[str, str]
    value: float
    midpoint: Decimal
    radius: Decimal
    tolerance: Tolerance | None

    @property
    def off(self) -> Decimal:
        """Distance from the nearest number that may be the true one."""
        if not math.isfinite(self.value):
            return Decimal("Infinity")
        return max(abs(Decimal(self.value) - self.midpoint) - self.radius, Decimal(0))

    @property
    def ulps(self) -> float:
        """The same in units in the last place of the true value; 0 inside the enclosure."""
        return float(self.off / Decimal(math.ulp(float(self.midpoint))))

    @property
    def refuted(self) -> bool:
        """Whether the number is further off than its column may move."""
        if self.tolerance is None:
            return self.ulps > BOUNDS[0]
        relative = Decimal(self.tolerance.relative) * abs(self.midpoint)
        return self.off > Decimal(self.tolerance.absolute) + relative

    def __str__(self) -> str:
        """Say which number it is."""
        row = ", ".join(f"{name} {value}" for name, value in self.row.items())
        return f"{self.table}.{self.column} at {row}"


def enclosed(
    frames: Mapping[str, pd.DataFrame], reference: Path, layouts: Mapping[str, Layout]
) -> list[Enclosed]:
    """Find the numbers of results that have an enclosure.

    Parameters
    ----------
    frames : mapping of DataFrame
        Tables of the results, as `vibrissa.checking.condensing.condensed` returns them.
    reference : Path
        Folder with the reference tables.
    layouts : mapping of Layout
        What is compared.

    Returns
    -------
    list of Enclosed
        Of the compared columns; empty without a file of enclosures.

    Raises
    ------
    TableError
        If the file is none of enclosures.
    """
    path = reference / FILE
    if not path.is_file():
        return []
    found = []
    proofs = read(path, {name: KEYS[name] for name in KEYS.keys() & frames.keys()})
    rows = {name: _rows_by_key(frames[name], KEYS[name]) for name in {p.table for p in proofs}}
    for proof in proofs:
        columns = layouts[proof.table].columns
        if proof.quantity in columns:
            # A point of two grids has two rows.
            for computed in rows[proof.table].get(spell_key(proof.row.values()), ()):
                value = computed[proof.quantity]
                found.append(
                    Enclosed(
                        table=proof.table,
                        column=proof.quantity,
                        row=proof.row,
                        # What is proved and has no number here failed.
                        value=math.nan if pd.isna(value) else float(value),
                        midpoint=proof.midpoint,
                        radius=proof.radius,
                        tolerance=columns[proof.quantity],
                    )
                )
    return found


def _rows_by_key(frame: pd.DataFrame, keys: Sequence[str]) -> dict[str, list[dict[str, Any]]]:
    """Rows of a table by the spelling of their keys."""
    found: dict[str, list[dict[str, Any]]] = {}
    for row in frame.to_dict("records"):
        found.setdefault(spell_key(row[key] for key in keys), []).append(row)
    return found


def histogram(numbers: Sequence[Enclosed]) -> dict[str, int]:
    """Count the numbers by how many units in the last place they are off.

    Returns
    -------
    dict of int
        By a text that names the class.
    """
    names = [f"at most {bound:g}" for bound in BOUNDS] + [f"more than {BOUNDS[-1]:g}"]
    counts = dict.fromkeys(names, 0)
    for number in numbers:
        above = sum(number.ulps > bound for bound in BOUNDS)
        counts[names[above]] += 1
    return counts


def verdict(numbers: Sequence[Enclosed]) -> str:
    """Whether the numbers agree with their proofs, in one line; empty without proofs."""
    if not numbers:
        return ""
    worst = max(numbers, key=lambda number: number.ulps)
    wrong = sum(number.refuted for number in numbers)
    result = f"All {len(numbers)} proved numbers agree"
    if wrong:
        result = f"{wrong} of {len(numbers)} proved numbers DISAGREE"
    classes = ", ".join(f"{count} {name}" for name, count in histogram(numbers).items() if count)
    return (
        f"{result}. Differences in units in the last place: {classes}; largest {worst.ulps:.4g}, "
        f"{worst}."
    )


def refuted(numbers: Sequence[Enclosed]) -> list[Difference]:
    """Find the numbers that are further from their proofs than they may move.

    Returns
    -------
    list of Difference
        One for each column.
    """
    by_column: dict[tuple[str, str], list[Enclosed]] = {}
    for number in numbers:
        by_column.setdefault((number.table, number.column), []).append(number)
    return [
        _difference(table, column, wrong, len(every))
        for (table, column), every in by_column.items()
        if (wrong := [number for number in every if number.refuted])
    ]


def _difference(table: str, column: str, wrong: Sequence[Enclosed], of: int) -> Difference:
    worst = max(wrong, key=lambda number: number.off)
    return Difference(
        table=table,
        column=column,
        problem=Problem.REFUTED,
        rows=len(wrong),
        of=of,
        text=f"{table}.{column}: {len(wrong)} of {of} numbers are refuted by their proofs, by up "
        f"to {worst.off:.2g}: {worst}, computed {worst.value!r}, proved {worst.midpoint}",
    )
