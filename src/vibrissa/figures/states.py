"""Figures of single equilibria."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibrissa.figures import shapes, style
from vibrissa.figures.kinds import kind
from vibrissa.figures.series import Series
from vibrissa.figures.style import COLORS, Look

# So many states have their numbers in the legend.
WITH_NUMBERS = 2
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
    """Shapes of single equilibria (paper Figure 8).

    Each has its name, two or one their numbers, too. Many have graded colours, which show the taper
    factor or, where all have the same, the place of the contact point.
    """
    solved = rows[rows["status"] == "solved"]
    figure, (panel,), is_narrow = shapes.panels([solved])
    shade, symbol = ("theta", r"\theta") if solved["theta"].nunique() > 1 else ("x1", "x_1")
    named = len(solved) <= len(COLORS)
    series = Series(range(len(solved)) if named else solved[shade], symbol)
    label = _numbers if len(solved) <= WITH_NUMBERS else _name
    for i, (_, row) in enumerate(solved.iterrows()):
        color = series.color(i if named else row[shade])
        _draw(panel, row, color, label=label(row) if named else None)
    if solved["penetrates"].any():
        hollow: Look = {
            "marker": "o",
            "color": "black",
            "markerfacecolor": "white",
            "linestyle": "none",
        }
        style.mean(panel, "passes through the surface", **hollow)
    for name in rows["state"][rows["status"] != "solved"]:
        style.mean(panel, f"no result: {name}", marker="x", color="black", linestyle="none")
    panel.plot(0, 0, "s", color="black", markersize=5)
    style.legend(figure, beside=is_narrow, **({} if is_narrow else {"ncols": 1}))
    if not named:
        series.colorbar(panel)
    return figure


def _draw(panel: Axes, row: pd.Series, color: str, label: str | None) -> None:
    """Draw a rod, with a mark where it touches the surface: hollow where it passes through."""
    panel.plot(row["shape_x"], row["shape_y"], color=color, label=label, solid_capstyle="round")
    # From here to the tip at x1 the rod lies straight along the surface.
    touches = row["x1"] - (1.0 - row["s_c"])
    face = "white" if row["penetrates"] else color
    panel.plot(touches, row["eta"], "o", color=color, markerfacecolor=face, zorder=3)


def _name(row: pd.Series) -> str:
    """Name of a state; the middle of a long one is left out, as series differ in their ends."""
    name, half = row["state"], SHOWN_NAME // 2
    return name if len(name) <= SHOWN_NAME else f"{name[:half]}…{name[1 - half :]}"


def _numbers(row: pd.Series) -> str:
    """Contact, force and angles of a state."""
    return (
        f"{row['contact']} contact\n"
        rf"$f = {row['f']:.3f}$, $\tan\alpha = {np.tan(row['alpha']):.3f}$"
        "\n"
        rf"$\varphi_1 = {row['phi1']:.3f}$ rad, $s_c = {row['s_c']:.3f}$"
    )
