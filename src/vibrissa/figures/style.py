"""What all figures have in common: size, type, colours, labels, the surface, and files."""

from collections.abc import Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from vibrissa.files import write_atomically
from vibrissa.numerics.arrays import FloatArray

# Width of a figure (inch) and resolution of its pixels (1/inch).
WIDTH = 6.3
RESOLUTION = 200
# Colours that readers with any colour vision tell apart (Okabe and Ito), and the paper's markers.
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")
MARKERS = ("s", "D", "^", "o", "v", "P")
SURFACE, SHAPE, START, END = "#555555", "#6d9dc5", "#0072b2", "#d55e00"

TAPER = r"taper factor $\theta = d_0/d_1$"
FRICTION = r"coefficient of static friction $\mu_0$"
LOCKING_FRICTION = r"critical friction coefficient $\mu_\mathrm{lock}$"
DISPLACEMENT = r"clamp displacement $x_{0,\mathrm{max}}$ / $L$"

_SETTINGS: Any = {
    "font.size": 10,
    "axes.titlesize": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    # Identical files from identical tables
    "svg.hashsalt": "vibrissa",
}
_DATELESS: dict[str, dict[str, str | None]] = {
    ".pdf": {"CreationDate": None},
    ".svg": {"Date": None},
}


def applied() -> AbstractContextManager[None]:
    """Apply the settings of matplotlib under which every figure is made and written."""
    return matplotlib.rc_context(_SETTINGS)


def page(height: float) -> Figure:
    """Make an empty figure of a height (inch)."""
    return Figure(figsize=(WIDTH, height), layout="constrained")


def axes(height: float) -> tuple[Figure, Axes]:
    """Make a figure of a height (inch) with one pair of axes."""
    figure = page(height)
    return figure, figure.subplots()


def rod_of(rows: pd.DataFrame) -> str:
    """Say which rod on which surface is shown, the same in all rows."""
    row = rows.iloc[0]
    return rf"$\theta = {row['theta']:g}$, $\mu_0 = {row['mu0']:g}$, $\eta = {row['eta']:g}$"


def message(text: str) -> Figure:
    """Make a figure that says in words why there is nothing to show."""
    figure, panel = axes(2.0)
    say(panel, text)
    return figure


def say(panel: Axes, text: str) -> None:
    """Say in words why axes have nothing to show."""
    panel.set_axis_off()
    panel.text(0.5, 0.5, text, ha="center", va="center", wrap=True, transform=panel.transAxes)


def where_it_locks(locks: bool, not_drawn: pd.Series) -> str:
    """Say below a title why lines end, if a tip locks, and from which μ0 on there are none."""
    if not locks:
        return ""
    all_lock = (
        "" if not_drawn.empty else rf": for $\mu_0 \geq {not_drawn.min():.4g}$ at every $\theta$"
    )
    return f"\na line ends where the tip locks{all_lock}"


def from_zero(panel: Axes) -> None:
    """Let the ordinate begin at zero, with room above the data for the mark of a single point."""
    panel.update_datalim([(0.0, 0.0)], updatex=False)
    panel.autoscale_view()
    panel.set_ylim(bottom=0.0)


def shape_axes(rows: pd.DataFrame, beside: float = 0.0) -> tuple[Figure, Axes]:
    """Make axes of equal scale with the surface, on a page of the shapes' proportions.

    `rows` has the shapes, ``shape_x`` and ``shape_y`` (L), that are going to be drawn, and ``eta``;
    `beside` is the width that is left free to the right of them (L).
    """
    x, y = (np.concatenate(list(rows[name])) for name in ("shape_x", "shape_y"))
    eta = rows["eta"].iloc[0]
    height = max(y.max(), eta) + 0.1
    width = x.max() - x.min() + 0.1 + beside
    figure, panel = axes(min(6.0, max(1.6, 5.6 * height / width)) + 0.9)
    panel.set_aspect("equal")
    panel.axhline(eta, color=SURFACE, linewidth=1.2)
    panel.axhspan(eta, eta + 0.03, facecolor="none", edgecolor="#aaaaaa", hatch="////", linewidth=0)
    panel.set_xlim(x.min() - 0.05, x.max() + 0.05 + beside)
    panel.set_ylim(-0.05, height)
    panel.set_xlabel(r"$x$ / $L$")
    panel.set_ylabel(r"$y$ / $L$")
    return figure, panel


def cells(centres: pd.Index) -> FloatArray:
    """Bounds of the cells around the values of an axis; there may be a single one."""
    values = np.asarray(centres, dtype=float)
    if len(values) == 1:
        half = 0.1 * (abs(values[0]) or 1.0)
        return np.array([values[0] - half, values[0] + half])
    between = 0.5 * (values[1:] + values[:-1])
    first, last = 2.0 * values[0] - between[0], 2.0 * values[-1] - between[-1]
    return np.array([first, *between, last])


def alone(points: pd.DataFrame) -> str:
    """Marker of a line: one of a single point would not be seen."""
    return "o" if len(points) == 1 else ""


def level(points: pd.DataFrame) -> dict[str, Any]:
    """Look of a line that marks lie on: of a single point it is a dash, wider than the mark."""
    return {"marker": "_", "markersize": 14} if len(points) == 1 else {}


def save(figure: Figure, paths: Sequence[str | Path]) -> None:
    """Write a figure in the formats of the paths' endings, each file whole or not at all.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    paths : sequence of path
        Ending in ``.pdf``, ``.svg`` or ``.png``.
    """
    FigureCanvasAgg(figure)
    with applied():
        # Laid out once: the formats measure type differently.
        figure.draw_without_rendering()
        # Not "none", with which every format would be drawn twice.
        figure.set_layout_engine(None)
        for path in map(Path, paths):
            with write_atomically(path) as temporary:
                figure.savefig(
                    temporary,
                    format=path.suffix[1:],
                    dpi=RESOLUTION,
                    metadata=_DATELESS.get(path.suffix),
                )
