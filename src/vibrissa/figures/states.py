"""Figures of single equilibria."""

from itertools import cycle

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibrissa.figures import style
from vibrissa.figures.kinds import kind
from vibrissa.figures.style import COLORS, END, START, SURFACE

# Room beside the shapes, for the numbers that belong to them (L).
ROOM_FOR_NUMBERS = 0.6
SHAPE_COLORS = (START, END, COLORS[2], COLORS[3])


@kind(
    "state",
    columns=(
        *("theta", "eta", "x1", "status", "message", "contact", "f", "alpha", "phi1", "s_c"),
        *("penetrates", "shape_x", "shape_y"),
    ),
)
def state(rows: pd.DataFrame) -> Figure:
    """Shapes of single equilibria (paper Figure 8)."""
    rows = rows[rows["status"] == "solved"]
    figure, axes = style.shape_axes(rows, beside=ROOM_FOR_NUMBERS)
    for i, ((_, row), color) in enumerate(zip(rows.iterrows(), cycle(SHAPE_COLORS), strict=False)):
        axes.plot(
            row["shape_x"], row["shape_y"], color=color, linewidth=1.8, solid_capstyle="round"
        )
        # From here to the tip at x1 the rod lies straight along the surface.
        touches = row["x1"] - (1.0 - row["s_c"])
        axes.plot(touches, row["eta"], "o", color=color, markersize=5, zorder=3)
        _write_numbers(axes, row, color, top=0.60 - 0.26 * i)
        if row["penetrates"]:
            _mark_penetration(axes, row, color)
    axes.plot(0, 0, "s", color="black", markersize=7)
    top = max(max(y) for y in rows["shape_y"])
    axes.set_ylim(top=max(top, rows["eta"].iloc[0]) + 0.12)
    left, right = min(map(min, rows["shape_x"])), max(map(max, rows["shape_x"]))
    axes.set_xlim(left - 0.08, right + 0.04 + ROOM_FOR_NUMBERS)
    row = rows.iloc[0]
    where = rf"$(x_1, y_1) = ({row['x1']:g}, {row['eta']:g})$"
    axes.set_title(rf"$\theta = {row['theta']:g}$, {where}")
    return figure


def _write_numbers(axes: Axes, row: pd.Series, color: str, top: float) -> None:
    """Write a state's contact, force and angles beside the shapes, below a height of the axes."""
    axes.text(
        0.98,
        top,
        f"{row['contact']} contact\n"
        rf"$f = {row['f']:.3f}$, $\tan\alpha = {np.tan(row['alpha']):.3f}$"
        "\n"
        rf"$\varphi_1 = {row['phi1']:.3f}$ rad, $s_c = {row['s_c']:.3f}$",
        transform=axes.transAxes,
        ha="right",
        va="top",
        color=color,
        fontsize=9,
    )


def _mark_penetration(axes: Axes, row: pd.Series, color: str) -> None:
    """Say at the highest point of a shape that it lies beyond the surface."""
    top = int(np.argmax(row["shape_y"]))
    axes.annotate(
        f"passes through the surface\n(up to y = {row['shape_y'][top]:.4f})",
        (row["shape_x"][top], row["shape_y"][top]),
        xytext=(14, 14),
        textcoords="offset points",
        color=color,
        arrowprops={"arrowstyle": "-", "color": SURFACE},
    )
