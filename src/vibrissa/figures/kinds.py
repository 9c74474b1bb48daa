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
    """

    name: str
    columns: tuple[str, ...]
    plot: Callable[[pd.DataFrame], Figure]


def kind(
    name: str, *, columns: tuple[str, ...]
) -> Callable[[Callable[[pd.DataFrame], Figure]], Kind]:
    """Make a kind of figure of the function that plots it; see `Kind`."""
    return lambda plot: Kind(name=name, columns=columns, plot=plot)
