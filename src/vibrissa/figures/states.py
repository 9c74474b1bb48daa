"""Figures of single equilibria."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibrissa.figures import style
from vibrissa.figures.kinds import kind
from vibrissa.figures.series import Series
from vibrissa.figures.style import COLORS, END, START, SURFACE

# Room beside the shapes, for the numbers that belong to them (L).
ROOM_FOR_NUMBERS = 0.6
SHAPE_COLORS = (START, END)
# So many states have their numbers beside them.
WITH_NUMBERS = len(SHAPE_COLORS)
# Characters of a name in the legend.
SHOWN_NAME = 30


@kind(
    "state",
    columns=(
        *("state", "theta", "eta", "x1", "status", "message", "contact", "f", "alpha", "phi1"),
        *("s_c", "penetrates", "shape_x", "shape_y"),
    ),
)
def state(rows: pd.DataFrame) -> Figure:
    """Shapes of single equilibria (paper Figure 8)."""
    solved = rows["status"] == "solved"
    lost = list(rows["state"][~solved])
    rows = rows[solved]
    with_numbers = len(rows) <= WITH_NUMBERS
    beside = ROOM_FOR_NUMBERS if with_numbers else 0.0
    figure, axes = style.shape_axes(rows, beside=beside)
    if with_numbers:
        _draw_with_numbers(axes, rows)
    else:
        _draw_many(figure, axes, rows)
    axes.plot(0, 0, "s", color="black", markersize=7)
    top = max(max(y) for y in rows["shape_y"])
    axes.set_ylim(top=max(top, rows["eta"].iloc[0]) + 0.12)
    left, right = min(map(min, rows["shape_x"])), max(map(max, rows["shape_x"]))
    axes.set_xlim(left - 0.08, right + 0.04 + beside)
    axes.set_title(_title(rows) + _without(lost))
    return figure


def _title(rows: pd.DataFrame) -> str:
    """Say what the states have in common."""
    row = rows.iloc[0]
    known = [rf"$\theta = {row['theta']:g}$"] if rows["theta"].nunique() == 1 else []
    one_place = rows["x1"].nunique() == 1
    where = rf"$(x_1, y_1) = ({row['x1']:g}, {row['eta']:g})$"
    return ", ".join([*known, where if one_place else rf"$y_1 = {row['eta']:g}$"])


def _without(lost: list[str]) -> str:
    """Say in a line below a title which state has no result, or how many have none."""
    if not lost:
        return ""
    return f"\nwithout a result: {_shortened(lost[0]) if len(lost) == 1 else f'{len(lost)} states'}"


def _draw_with_numbers(axes: Axes, rows: pd.DataFrame) -> None:
    """Draw a state or two with their numbers."""
    for i, ((_, row), color) in enumerate(zip(rows.iterrows(), SHAPE_COLORS, strict=False)):
        _draw_shape(axes, row, color, linewidth=1.8, face=color)
        _write_numbers(axes, row, color, top=0.60 - 0.26 * i)
        if row["penetrates"]:
            _mark_penetration(axes, row, color)


def _draw_many(figure: Figure, axes: Axes, rows: pd.DataFrame) -> None:
    """Draw several states, each with its name, or many of graded colour.

    The colour shows the taper factor, or, where all have the same, the place of the contact point.
    """
    shade, symbol = ("theta", r"\theta") if rows["theta"].nunique() > 1 else ("x1", "x_1")
    named = len(rows) <= len(COLORS)
    series = Series(range(len(rows)) if named else rows[shade], symbol)
    for i, (_, row) in enumerate(rows.iterrows()):
        color = series.color(i if named else row[shade])
        face = "white" if row["penetrates"] else color
        line = _draw_shape(axes, row, color, linewidth=1.8 if named else 0.8, face=face)
        if named:
            line.set_label(_shortened(row["state"]))
    if rows["penetrates"].any():
        label = "hollow: passes through the surface"
        axes.plot([], [], "o", color="black", markerfacecolor="white", label=label)
    if named or rows["penetrates"].any():
        figure.legend(loc="outside lower center", ncols=2, fontsize=8)
    if not named:
        series.colorbar(axes)


def _draw_shape(axes: Axes, row: pd.Series, color: str, *, linewidth: float, face: str) -> Line2D:
    """Draw a rod, and with a face of a colour the place where it touches the surface."""
    (line,) = axes.plot(
        row["shape_x"], row["shape_y"], color=color, linewidth=linewidth, solid_capstyle="round"
    )
    # From here to the tip at x1 the rod lies straight along the surface.
    touches = row["x1"] - (1.0 - row["s_c"])
    axes.plot(touches, row["eta"], "o", color=color, markerfacecolor=face, markersize=5, zorder=3)
    return line


def _shortened(name: str) -> str:
    """Leave out the middle of a long name: names of a series differ in their ends."""
    half = SHOWN_NAME // 2
    return name if len(name) <= SHOWN_NAME else f"{name[:half]}…{name[1 - half :]}"


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
