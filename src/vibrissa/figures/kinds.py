"""Registration of functions as kinds of figures."""

from collections.abc import Callable
from dataclasses import dataclass

import pandas as pd
from matplotlib.figure import Figure

# Columns that say which point or which scan is shown and what came out.
POINT = ("theta", "mu0", "eta", "dx0", "status", "message")
SCAN = ("theta", "mu0", "eta", "dx0", "status")
Plot = Callable[[pd.DataFrame], Figure]


@dataclass(frozen=True, kw_only=True)
class Kind:
    """A kind of figure: columns of the table that it reads, and the function that draws rows."""

    columns: tuple[str, ...]
    plot: Plot


# By the name that a study file has for it.
KINDS: dict[str, Kind] = {}


def kind(name: str, *, columns: tuple[str, ...]) -> Callable[[Plot], Plot]:
    """Register a function as a kind of figure; see `Kind`."""

    def register(plot: Plot) -> Plot:
        KINDS[name] = Kind(columns=columns, plot=plot)
        return plot

    return register
