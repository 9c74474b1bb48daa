"""Comparison with proved intervals: distance of each number from the true value.

Enclosures stand in ``enclosures.csv`` beside the reference tables; `python -m validation proof`
writes them.
"""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path

import pandas as pd

from vibrissa.checking.differences import Difference
from vibrissa.checking.layouts import Layout, Tolerance
from vibrissa.errors import ComparisonError

FILE = "enclosures.csv"
# Columns by which a proof names a row of each table.
KEYS = {
    "stiction": ["theta", "mu0", "eta", "dx0"],
    "curves": ["theta", "eta"],
    "scans": ["scan", "theta", "mu0", "eta", "dx0", "cycle"],
    "states": ["state"],
}


@dataclass(frozen=True, kw_only=True)
class Enclosed:
    """A number of the results, and the enclosure of the true one, midpoint ± radius.

    Attributes
    ----------
    row : str
        Keys of the row with their values.
    tolerance : Tolerance or None
        None where the column is exact.
    """

    table: str
    column: str
    row: str
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
    def refuted(self) -> bool:
        """Whether the number is further from its interval than the tolerance of its column."""
        if self.tolerance is None:  # it has to be the nearest double
            return self.off > Decimal(math.ulp(float(self.midpoint))) / 2
        relative = Decimal(self.tolerance.relative) * abs(self.midpoint)
        return self.off > Decimal(self.tolerance.absolute) + relative


def enclosed(
    frames: Mapping[str, pd.DataFrame], reference: Path, layouts: Mapping[str, Layout]
) -> list[Enclosed]:
    """Select the condensed results that have an enclosure; empty without a file of enclosures.

    Raises
    ------
    ComparisonError
        If the file does not hold enclosures.
    """
    path = reference / FILE
    if not path.is_file():
        return []
    try:
        proofs = pd.read_csv(path, dtype=str, keep_default_na=False).groupby("table")
        return [
            number
            for name, rows in proofs
            if name in frames and name in layouts
            for number in _enclosed_in(name, rows, frames[name], layouts[name].columns)
        ]
    except (ValueError, KeyError, ArithmeticError) as error:
        raise ComparisonError(
            f"{path} has no enclosures ({error!r}); restore it from version control, or delete it "
            "and make it anew with: python -m validation proof"
        ) from None


def _enclosed_in(
    table: str,
    proofs: pd.DataFrame,
    frame: pd.DataFrame,
    columns: Mapping[str, Tolerance | None],
) -> Iterator[Enclosed]:
    """Match the proofs of a table with its rows; a point of two grids has two rows."""
    keys = KEYS[table]
    proofs = proofs[proofs["quantity"].isin(columns)][[*keys, "quantity", "midpoint", "radius"]]
    proofs = proofs.astype({key: frame[key].dtype for key in keys})
    for pair in proofs.merge(frame, on=keys).to_dict("records"):
        column = pair["quantity"]
        yield Enclosed(
            table=table,
            column=column,
            row=", ".join(f"{key} {pair[key]}" for key in keys),
            # What is proved and has no number here failed.
            value=math.nan if pd.isna(pair[column]) else float(pair[column]),
            midpoint=Decimal(pair["midpoint"]),
            radius=Decimal(pair["radius"]),
            tolerance=columns[column],
        )


def verdict(numbers: Collection[Enclosed]) -> str:
    """Whether the numbers agree with their proofs, in one line; empty without proofs."""
    if not numbers:
        return ""
    worst = max(numbers, key=lambda number: number.off)
    wrong = sum(number.refuted for number in numbers)
    result = f"{wrong:,} of {len(numbers):,} proved numbers DISAGREE"
    if not wrong:
        result = f"All {len(numbers):,} proved numbers agree"
    return (
        f"{result}. Largest difference: {worst.off:.1e}, {worst.table}.{worst.column} at "
        f"{worst.row}."
    )


def refuted(numbers: Sequence[Enclosed]) -> list[Difference]:
    """Return a difference for each column with numbers that their proofs refute."""
    found = []
    for table, column in dict.fromkeys((number.table, number.column) for number in numbers):
        every = [one for one in numbers if (one.table, one.column) == (table, column)]
        if wrong := [number for number in every if number.refuted]:
            worst = max(wrong, key=lambda number: number.off)
            text = (
                f"{table}.{column}: {len(wrong)} of {len(every)} numbers are refuted by their "
                f"proofs, by up to {worst.off:.2g}: at {worst.row}, computed {worst.value!r}, "
                f"proved {worst.midpoint}"
            )
            found.append(
                Difference(
                    table=table, column=column, problem="refuted", rows=len(wrong), text=text
                )
            )
    return found
