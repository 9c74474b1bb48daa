"""What makes a function a kind of figure."""

from collections.abc import Callable
from dataclasses import dataclass

import pandas as pd
from matplotlib.figure import Figure

# Columns that say which point or which scan is shown and what came out.
POINT = ("theta", "mu0", "eta", "dx0", "status", "message")
SCAN = ("theta", "mu0", "eta", "dx0", "status")


@dataclass(frozen=True, kw_only=True)
class Kind:
    """A kind of figure.

    Attributes
    ----------
    name : str
        As a study file spells it.
    columns : tuple of str
        Columns of the table that are shown; no other is read.
    plot : callable
        Takes the rows that are to be shown, at least one, and returns the figure.
    along : str
        Axis along which lines of it run, so that values that refine added to the axis belong to
        them; empty where there is none. Values that were added to another axis are not shown: each
        would be a series of its own.
    """

    name: str
    columns: tuple[str, ...]
    plot: Callable[[pd.DataFrame], Figure]
    along: str


def kind(
    name: str, *, columns: tuple[str, ...], along: str = ""
) -> Callable[[Callable[[pd.DataFrame], Figure]], Kind]:
    """Make a kind of figure of the function that plots it; see `Kind`."""
    return lambda plot: Kind(name=name, columns=columns, plot=plot, along=along)
