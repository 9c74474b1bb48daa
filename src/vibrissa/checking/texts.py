"""Tables as text that reads well in a diff: as they are compared, and kept in files."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from vibrissa.checking.layouts import Layout
from vibrissa.errors import ComparisonError
from vibrissa.files import write_atomically

# Significant digits of a float: fewer than a double has, more than any tolerance asks for.
DIGITS = 12


def as_text(frame: pd.DataFrame, layout: Layout, name: str) -> pd.DataFrame:
    """Text of a table, as it is written, in the order of its keys.

    Parameters
    ----------
    frame : DataFrame
    layout : Layout
    name : str
        Name of the table, for messages.

    Returns
    -------
    DataFrame of str
        The keys and the columns of the layout; an empty text stands for nothing.

    Raises
    ------
    ComparisonError
        If a column is not there.
    """
    names = [*layout.keys, *layout.columns]
    if unknown := [column for column in names if column not in frame]:
        raise ComparisonError(
            f"{name} has no column {', '.join(unknown)}; it has {', '.join(map(str, frame))}"
        )
    ordered = frame.sort_values(list(layout.keys))
    return pd.DataFrame({column: spelled(ordered[column]) for column in names})


def spelled(values: pd.Series) -> pd.Series:
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

    Parameters
    ----------
    path : Path

    Returns
    -------
    DataFrame of str

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


def write(text: pd.DataFrame, path: Path) -> None:
    """Write a reference table whole or not at all."""
    with write_atomically(path) as temporary:
        text.to_csv(temporary, index=False, lineterminator="\n")
