"""Comparison with proved intervals: distance of each number from the true value.

The intervals stand in ``enclosures.csv`` beside the reference tables; `python -m validation proof`
writes them.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from vibrissa.checking.differences import Difference, spell_row
from vibrissa.checking.tolerances import Layout
from vibrissa.errors import ComparisonError

FILE = "enclosures.csv"
# Columns by which a proof names a row of each table.
KEYS = {
    "stiction": ["theta", "mu0", "eta", "dx0"],
    "curves": ["theta", "eta"],
    "scans": ["scan", "theta", "mu0", "eta", "dx0", "cycle"],
    "states": ["state"],
}


def proved(
    frames: Mapping[str, pd.DataFrame], reference: Path, layouts: Mapping[str, Layout]
) -> pd.DataFrame:
    """Select the condensed results that have a proof: a row for each number.

    Its columns are ``table``, ``quantity``, the ``value``, the ``midpoint`` of the interval of the
    true value, the distance ``off`` from that interval, whether the value is ``refuted``, as it is
    further off than its tolerance, and the keys of all tables. Empty without a file of proofs.

    Raises
    ------
    ComparisonError
        If the file does not hold proofs.
    """
    path = reference / FILE
    try:
        proofs = pd.read_csv(path, dtype={"midpoint": str}).groupby("table")
        return pd.concat(
            _proved_in(str(name), rows, frames[str(name)], layouts[str(name)])
            for name, rows in proofs
            if name in frames and name in layouts
        )
    except FileNotFoundError:
        return pd.DataFrame()
    except (ValueError, KeyError) as error:
        raise ComparisonError(
            f"{path} has no enclosures ({error!r}); restore it from version control, or delete it "
            "and make it anew with: python -m validation proof"
        ) from None


def _proved_in(
    table: str, proofs: pd.DataFrame, frame: pd.DataFrame, layout: Layout
) -> pd.DataFrame:
    """Match the proofs of a table with its rows; a point of two grids has two rows."""
    keys = KEYS[table]
    quantities = [name for name in layout.columns if name in set(proofs["quantity"])]
    values = frame[[*keys, *quantities]].melt(keys, var_name="quantity")
    proofs = proofs.astype({key: frame[key].dtype for key in keys})
    pairs = proofs[["table", "quantity", *keys, "midpoint", "radius"]].merge(
        values, on=[*keys, "quantity"]
    )
    value, midpoint = pairs["value"].astype("Float64").to_numpy(float), pairs["midpoint"].map(float)
    # What is proved and has no number here failed.
    off = np.nan_to_num(np.abs(value - midpoint) - pairs["radius"], nan=np.inf).clip(min=0.0)
    tolerances = [layout.columns[name] for name in pairs["quantity"]]
    absolute, relative = np.array([(one.absolute, one.relative) for one in tolerances]).T
    is_wrong = off > absolute + relative * midpoint.abs()
    return pairs.assign(off=off, refuted=is_wrong)


def verdict(numbers: pd.DataFrame) -> str:
    """Whether the numbers agree with their proofs, in one line; empty without proofs."""
    if numbers.empty:
        return ""
    wrong, worst = numbers["refuted"].sum(), _worst(numbers)
    result = f"{wrong:,} of {len(numbers):,} proved numbers DISAGREE"
    if not wrong:
        result = f"All {len(numbers):,} proved numbers agree"
    return (
        f"{result}. Largest difference: {worst['off']:.1e}, {worst['table']}.{worst['quantity']} "
        f"at {_row(worst)}."
    )


def refuted(numbers: pd.DataFrame) -> Iterator[Difference]:
    """Find each column with numbers that their proofs refute."""
    if numbers.empty:
        return
    for (table, column), every in numbers.groupby(["table", "quantity"], sort=False):
        if wrong := int(every["refuted"].sum()):
            worst = _worst(every)
            text = (
                f"{table}.{column}: {wrong} of {len(every)} numbers are refuted by their proofs, "
                f"by up to {worst['off']:.2g}: at {_row(worst)}, computed {worst['value']!r}, "
                f"proved {worst['midpoint']}"
            )
            yield Difference(table=table, column=column, problem="refuted", rows=wrong, text=text)


def _worst(numbers: pd.DataFrame) -> pd.Series:
    return numbers.iloc[int(numbers["off"].to_numpy().argmax())]


def _row(number: pd.Series) -> str:
    return spell_row(number[KEYS[number["table"]]].to_dict())
