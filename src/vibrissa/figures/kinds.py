"""Registration of functions as kinds of figures."""

from collections.abc import Callable
from dataclasses import dataclass

from matplotlib.figure import Figure

# Columns that identify a grid point or a scan, with its outcome.
POINT = ("theta", "mu0", "eta", "dx0", "status", "message")
SCAN = ("theta", "mu0", "eta", "dx0", "status")
Plot = Callable[..., Figure]


@dataclass(frozen=True, kw_only=True)
class Kind:
    """A kind of figure: columns of the table that it reads, and the function that draws rows.

    The function also takes those of the `keys` of the study file that the figure has.
    """

    columns: tuple[str, ...]
    plot: Plot
    keys: tuple[str, ...] = ()


# Kinds of figures by their name in the study file.
KINDS: dict[str, Kind] = {}


def kind(
    name: str, *, columns: tuple[str, ...], keys: tuple[str, ...] = ()
) -> Callable[[Plot], Plot]:
    """Register a function as a kind of figure; see `Kind`."""

    def register(plot: Plot) -> Plot:
        KINDS[name] = Kind(columns=columns, plot=plot, keys=keys)
        return plot

    return register
