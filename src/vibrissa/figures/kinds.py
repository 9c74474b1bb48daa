"""Registration of functions as kinds of figures."""

from collections.abc import Callable
from dataclasses import dataclass

from matplotlib.figure import Figure

# Columns that identify a grid point or a scan, with its outcome.
POINT = ("theta", "mu0", "eta", "dx0", "status", "message")
SCAN = ("theta", "mu0", "eta", "dx0", "status")
Plot = Callable[..., Figure]


@dataclass(frozen=True, kw_only=True)
class Drawing:
    """A kind of figure: columns of the table that it reads, and the function that draws rows.

    If `is_scaled_by_all`, the function also takes all rows of the figure's scan or grid, so that
    figures of different rows of it have the same scale.
    The function also takes those of the `keys` of the study file that the figure has.
    """

    columns: tuple[str, ...]
    plot: Plot
    is_scaled_by_all: bool = False
    keys: tuple[str, ...] = ()


# Kinds of figures by their name in the study file.
KINDS: dict[str, Drawing] = {}


def kind(
    name: str,
    *,
    columns: tuple[str, ...],
    is_scaled_by_all: bool = False,
    keys: tuple[str, ...] = (),
) -> Callable[[Plot], Plot]:
    """Register a function as a kind of figure; see `Drawing`."""

    def register(plot: Plot) -> Plot:
        KINDS[name] = Drawing(
            columns=columns, plot=plot, is_scaled_by_all=is_scaled_by_all, keys=keys
        )
        return plot

    return register
