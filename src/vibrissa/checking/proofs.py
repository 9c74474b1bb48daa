"""Comparison of results with proved intervals that contain the true values.

The intervals are in ``enclosures.csv`` beside the reference tables; `python -m validation proof`
writes them.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from vibrissa.checking.differences import Difference, spell_row
from vibrissa.checking.tolerances import TableLayout
from vibrissa.errors import ComparisonError

FILE = "enclosures.csv"
# Columns that identify a row of each table in a proof.
KEYS = {
    "stiction": ["theta", "mu0", "eta", "dx0"],
    "curves": ["theta", "eta"],
    "scans": ["scan", "theta", "mu0", "eta", "dx0", "cycle"],
    "states": ["state"],
}


def read(reference: Path) -> pd.DataFrame | None:
    """Read the proved intervals in a reference folder; None if it has no file of proofs.

    Raises
    ------
    ComparisonError
        If the file cannot be read.
    """
    path = reference / FILE
    try:
        found = pd.read_csv(path, dtype={"midpoint": str})
        return found.assign(table=found["table"].astype(str))
    except FileNotFoundError:
        return None
    except (ValueError, KeyError) as error:
        raise _no_proofs(path, error) from None


def _no_proofs(path: Path, error: Exception) -> ComparisonError:
    return ComparisonError(
        f"{path} is no table of proved intervals ({error!r}); restore it from version control, or "
        "delete it and make it anew with: python -m validation proof"
    )


def proved(
    table: str,
    proofs: pd.DataFrame | None,
    frame: pd.DataFrame,
    layout: TableLayout,
    reference: Path,
) -> pd.DataFrame:
    """Compare rows of a condensed table with the proved intervals, as `read` returns them.

    The result has a row for each number that has a proof, and no rows if there is no file of
    proofs. Its columns are ``table``, ``quantity`` and the keys that identify the number in its
    table; the ``value``; ``midpoint`` and ``radius`` of the proved interval; ``off``, the distance
    of the value from the interval; and ``refuted``, whether this distance exceeds the tolerance.

    Raises
    ------
    ComparisonError
        If the proofs cannot be used.
    """
    some = None if proofs is None else proofs[proofs["table"] == table]
    if some is None or not len(some):
        return pd.DataFrame()
    try:
        return _proved_in(table, some, frame, layout)
    except (ValueError, KeyError) as error:
        raise _no_proofs(reference / FILE, error) from None


def _proved_in(
    table: str, proofs: pd.DataFrame, frame: pd.DataFrame, layout: TableLayout
) -> pd.DataFrame:
    """Match the proofs of a table with its rows; a point in two grids matches two rows."""
    keys = KEYS[table]
    quantities = [name for name in layout.columns if name in set(proofs["quantity"])]
    values = frame[[*keys, *quantities]].melt(keys, var_name="quantity")
    proofs = proofs.astype({key: frame[key].dtype for key in keys})
    pairs = proofs[["table", "quantity", *keys, "midpoint", "radius"]].merge(
        values, on=[*keys, "quantity"]
    )
    value, midpoint = (
        pairs["value"].astype("Float64").to_numpy(float),
        pairs["midpoint"].astype(float),
    )
    # A proved number that is missing in the results is infinitely far off.
    off = np.nan_to_num(np.abs(value - midpoint) - pairs["radius"], nan=np.inf).clip(min=0.0)
    tolerances = [layout.columns[name] for name in pairs["quantity"]]
    absolute = np.array([one.absolute for one in tolerances])
    relative = np.array([one.relative for one in tolerances])
    is_wrong = off > absolute + relative * midpoint.abs()
    return pairs.assign(off=off, refuted=is_wrong)


def verdict(numbers: pd.DataFrame) -> str:
    """Return one line on whether the numbers agree with their proofs; empty without proofs."""
    if numbers.empty:
        return ""
    wrong, worst = numbers["refuted"].sum(), _worst(numbers)
    result = f"{wrong:,} of {len(numbers):,} proved numbers DISAGREE with the results"
    if not wrong:
        result = f"All {len(numbers):,} proved numbers agree with the results"
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
                f"{table}.{column}: {wrong} of {len(every)} numbers are outside of their proved "
                f"intervals, by up to {worst['off']:.2g}: at {_row(worst)}, computed "
                f"{worst['value']!r}, proved {worst['midpoint']}"
            )
            yield Difference(table=table, column=column, problem="refuted", rows=wrong, text=text)


def _worst(numbers: pd.DataFrame) -> pd.Series:
    return numbers.iloc[int(numbers["off"].to_numpy().argmax())]


def _row(number: pd.Series) -> str:
    return spell_row(number[KEYS[number["table"]]].to_dict())
