"""Figures of single equilibria."""

import pandas as pd
from matplotlib.figure import Figure

from vibrissa.figures import shapes, style
from vibrissa.figures.kinds import kind
from vibrissa.figures.series import Series
from vibrissa.figures.style import COLORS, HOLLOW


@kind(
    "state",
    columns=(
        *("state", "theta", "eta", "x1", "status", "message", "s_c", "penetrates"),
        *("shape_x", "shape_y"),
    ),
)
def state(rows: pd.DataFrame) -> Figure:
    """Shapes of single equilibria (paper Figure 8), each with its name.

    More than six shapes have graded colours in place of names: by θ, or by x1 if all have one θ.
    """
    solved = rows[rows["status"] == "solved"]
    figure, (panel,), is_narrow = shapes.panels([solved])
    series = Series(solved, "theta" if solved["theta"].nunique() > 1 else "x1")
    are_named = len(solved) <= len(COLORS)
    colors = COLORS if are_named else solved[series.column].map(series.color)
    for (_, row), color in zip(solved.iterrows(), colors, strict=False):
        look = {"color": color, "label": row["state"] if are_named else None}
        panel.plot(row["shape_x"], row["shape_y"], solid_capstyle="round", **look)
        # From here to the tip at x1 the rod lies straight along the surface.
        touches = row["x1"] - (1.0 - row["s_c"])
        face = "white" if row["penetrates"] else color
        panel.plot(touches, row["eta"], "o", color=color, markerfacecolor=face, zorder=3)
    if solved["penetrates"].any():
        style.mean(panel, "passes through the surface", **HOLLOW)
    for name in rows["state"][rows["status"] != "solved"]:
        style.no_result(panel, name)
    panel.plot(0, 0, "s", color="black", markersize=5)
    style.legend(figure, beside=is_narrow, **({} if is_narrow else {"ncols": 1}))
    if not are_named:
        series.colorbar(panel)
    return figure
