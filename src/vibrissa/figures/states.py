"""Figures of single equilibria."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibrissa.figures import shapes, style, symbols
from vibrissa.figures.kinds import kind
from vibrissa.figures.series import SYMBOLS, Series
from vibrissa.figures.style import COLORS, DASHES, INK, LOAD, WARNING, Look
from vibrissa.wording import figure_name

CONTACTS = {"point": "tip contact", "line": "line contact"}
# Largest number of states whose forces are drawn.
FORCES = 3


@kind(
    "state",
    columns=(
        "state",
        "theta",
        "eta",
        "x1",
        "status",
        "message",
        "contact",
        "f",
        "alpha",
        "phi1",
        "s_c",
        "penetrates",
        "shape_x",
        "shape_y",
    ),
)
def state(rows: pd.DataFrame) -> Figure:
    """Shapes of single equilibria (paper Figure 8), with contact points, forces and angles φ1.

    The names of several shapes are the values in which they differ. More than six shapes have
    graded colours in place of names: by θ, or by x1 if all have one θ.
    """
    solved = rows[rows["status"] == "solved"]
    room = shapes.room_of(solved)
    room = room._replace(top=max(room.top, float(solved["eta"].max()) + symbols.FORCE + 0.04))
    figure, (panel,) = shapes.panels([float(solved["eta"].iloc[0])], room, 1, 1)
    left, right = panel.get_xlim()
    spare = 0.5 * (right - room.right)
    panel.set_xlim(left - spare, right - spare)
    series = Series(solved, "theta" if solved["theta"].nunique() > 1 else "x1")
    are_named = len(solved) <= len(COLORS)
    names = _names(solved)
    for i, (_, row) in enumerate(solved.iterrows()):
        color = COLORS[i] if are_named else series.color(row[series.column])
        look: Look = {"color": color, "linestyle": DASHES[i] if are_named else "-"}
        _rod(panel, row, look)
        if are_named and len(solved) > 1:
            style.mean(panel, names[i], **look)
    if len(solved) <= FORCES:
        for _, row in solved.iterrows():
            _force(panel, row)
    if len(solved) == 1:
        _angle(panel, solved.iloc[0])
    symbols.clamp(panel, 0.0)
    for name in rows["state"][rows["status"] != "solved"]:
        style.no_result(panel, figure_name(name))
    shapes.legend(figure, columns=1)
    if not are_named:
        series.colorbar(panel)
    return figure


def _names(rows: pd.DataFrame) -> list[str]:
    """Name each state by the values in which the states differ, or else by its own name."""
    parts = [rows["contact"].map(CONTACTS)] if rows["contact"].nunique() > 1 else []
    for name in ("theta", "x1"):
        if rows[name].nunique() > 1:
            parts.append(rows[name].map(lambda value, name=name: f"${SYMBOLS[name]} = {value:g}$"))
    found = [", ".join(texts) for texts in zip(*parts, strict=True)] if parts else []
    own = [figure_name(name) for name in rows["state"]]
    return found if len(set(found)) == len(own) else own


def _rod(panel: Axes, row: pd.Series, line: Look) -> None:
    """Draw a rod; what of it lies beyond the surface has the colour of a warning."""
    x, y = np.asarray(row["shape_x"]), np.asarray(row["shape_y"])
    is_beyond = y > row["eta"] + 1e-9
    if row["penetrates"] and is_beyond.any():
        beyond = np.where(is_beyond, y, np.nan)
        panel.plot(x, beyond, color=WARNING, linewidth=3.0, alpha=0.5, solid_capstyle="butt")
        look: Look = {"ha": "right", "va": "bottom", "fontsize": 7, "color": WARNING}
        panel.text(x[is_beyond][0] - 0.02, row["eta"] + 0.05, "passes through\nthe surface", **look)
    panel.plot(x, y, **line)
    symbols.contact(panel, _touches(row), row["eta"], line["color"], is_real=not row["penetrates"])


def _touches(row: pd.Series) -> float:
    """Return the abscissa of the contact point; from it to the tip the rod lies on the surface."""
    return float(row["x1"] - (1.0 - row["s_c"]))


def _force(panel: Axes, row: pd.Series) -> None:
    """Draw the force of the surface on the rod, with its size."""
    tail = symbols.force(panel, (_touches(row), row["eta"]), row["alpha"])
    look: Look = {"color": LOAD, "fontsize": 7, "va": "center"}
    panel.text(tail[0] + 0.02, tail[1], f"$f = {row['f']:.1f}$", **look)


def _angle(panel: Axes, row: pd.Series) -> None:
    """Draw the slope angle φ1 at the contact point."""
    at, phi1 = (_touches(row), float(row["eta"])), float(row["phi1"])
    symbols.angle(panel, at, 0.14, (0.0, np.degrees(phi1)))
    stop = at[0] + 0.19 * np.cos(phi1), at[1] + 0.19 * np.sin(phi1)
    panel.plot(*zip(at, stop, strict=True), color=INK, linewidth=0.7)
    place = at[0] + 0.16 * np.cos(0.5 * phi1), at[1] + 0.16 * np.sin(0.5 * phi1)
    panel.text(*place, rf"$\varphi_1 = {phi1:.3f}$", fontsize=7, va="center")
