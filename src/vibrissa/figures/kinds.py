"""Registration of functions as kinds of figures."""

from collections.abc import Callable
from dataclasses import dataclass

import pandas as pd
from matplotlib.figure import Figure

# Columns that identify a grid point or a scan, with its outcome.
POINT = ("theta", "mu0", "eta", "dx0", "status", "message")
SCAN = ("theta", "mu0", "eta", "dx0", "status")
Plot = Callable[[pd.DataFrame], Figure]


@dataclass(frozen=True, kw_only=True)
class Kind:
    """A kind of figure: columns of the table that it reads, and the function that draws rows."""

    columns: tuple[str, ...]
    plot: Plot


# Kinds of figures by their name in the study file.
KINDS: dict[str, Kind] = {}


def kind(name: str, *, columns: tuple[str, ...]) -> Callable[[Plot], Plot]:
    """Register a function as a kind of figure; see `Kind`."""

    def register(plot: Plot) -> Plot:
        KINDS[name] = Kind(columns=columns, plot=plot)
        return plot

    return register
