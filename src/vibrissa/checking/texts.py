"""Reference tables: CSV files that read well in a diff. Tables are compared in this form."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from vibrissa.checking.layouts import Layout
from vibrissa.errors import ComparisonError
from vibrissa.files import write_atomically

# Significant digits of a float: fewer than a double has, more than any tolerance asks for.
DIGITS = 12


def as_text(frame: pd.DataFrame, layout: Layout) -> pd.DataFrame:
    """Text of the keys and columns of a layout, in the order of the keys; empty for nothing.

    Raises
    ------
    ComparisonError
        If a column is not there.
    """
    names = [*layout.keys, *layout.columns]
    if unknown := [column for column in names if column not in frame]:
        raise ComparisonError(f"no column {', '.join(unknown)}; there are {', '.join(frame)}")
    ordered = frame.sort_values(list(layout.keys))
    return pd.DataFrame({column: _spelled(ordered[column]) for column in names})


def _spelled(values: pd.Series) -> pd.Series:
    """Text of each value of a column; equal values are spelled once."""
    codes, different = pd.factorize(values, use_na_sentinel=False)
    texts = pd.Series([_spell(value) for value in different], dtype=str)
    return texts.take(codes).reset_index(drop=True)


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


def csv(table: pd.DataFrame) -> str:
    """Spell a table as its file holds it."""
    return table.to_csv(index=False, lineterminator="\n")


def write(table: pd.DataFrame, path: Path) -> None:
    """Write a reference table atomically."""
    with write_atomically(path) as temporary:
        temporary.write_text(csv(table), encoding="utf-8")
