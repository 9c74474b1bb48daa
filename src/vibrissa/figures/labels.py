"""Names of lines, written at the lines."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from vibrissa.figures.style import INK, NAMED, Look

# Least distance of two names (points), and share of a figure's height that its panels take.
APART, PANELS = 8.5, 0.8
# Distance of names from the end of the longest line, as a share of the panel's width.
BESIDE = 0.03
# From the left edge of a name. To cut a line at the frame of the name would take longer.
LEADER: Look = {"arrowstyle": "-", "linewidth": 0.5, "shrinkA": 3.0, "shrinkB": 0.0}
LEADER |= {"relpos": (0.0, 0.5), "patchA": None}


def beside(panel: Axes, text: str, at: tuple[float, float], x: float, color: str = INK) -> None:
    """Write a name at the abscissa `x`, with a line that leads from it to the point `at`."""
    look: Look = {"va": "center", "fontsize": 7, "color": color}
    panel.annotate(text, at, (x, at[1]), arrowprops=LEADER | {"color": color}, **look)


def at_ends(panel: Axes) -> None:
    """Write the labels of the lines of a panel in a column to the right of the lines.

    Names that would overlap are moved apart, and a thin line leads to the last point of the line in
    view. Called again, as after a change of the limits, this replaces the names. Lines whose label
    begins with an underscore have no name.
    """
    for text in [text for text in panel.texts if text.get_gid() == NAMED]:
        text.remove()
    # Matplotlib computes the limits when they are asked for.
    panel.get_xlim(), panel.get_ylim()
    named = [line for line in panel.lines if not str(line.get_label()).startswith("_")]
    last = {line: _last_in_view(panel, line) for line in named}
    ends = {line: end for line, end in last.items() if end}
    if not ends:
        return
    lines = sorted(ends, key=lambda line: ends[line][1])
    column = max(across for across, _ in ends.values()) + BESIDE
    own = np.array([ends[line][1] for line in lines])
    apart = APART / _height(panel) * np.arange(len(lines))
    places = own
    if (np.diff(own - apart) < 0.0).any():
        from scipy.optimize import isotonic_regression  # half a second to load

        places = isotonic_regression(own - apart).x + apart
    for line, place in zip(lines, places, strict=True):
        line.set_gid(NAMED)
        color = line.get_color()
        text = panel.annotate(
            str(line.get_label()),
            ends[line],
            (column, place),
            xycoords="axes fraction",
            textcoords="axes fraction",
            arrowprops=LEADER | {"color": color},
            color=color,
            fontsize=7,
            va="center",
        )
        text.set_gid(NAMED)


def _last_in_view(panel: Axes, line: Line2D) -> tuple[float, float] | None:
    """Return the last point of a line in its panel, as fractions of the panel's size."""
    points = np.column_stack([np.asarray(values, dtype=float) for values in line.get_data()])
    across, up = (panel.transScale + panel.transLimits).transform(points).T
    seen = np.flatnonzero((np.abs(across - 0.5) <= 0.501) & (np.abs(up - 0.5) <= 0.501))
    if not seen.size:
        return None
    last = seen[np.argmax(across[seen])]
    return float(across[last]), float(up[last])


def _height(panel: Axes) -> float:
    """Estimate the height of a panel (points)."""
    height, place = float(panel.figure.bbox.height) / panel.figure.dpi, panel.get_subplotspec()
    panels_above_each_other = place.get_gridspec().nrows if place else 1
    return PANELS * 72.0 * height / panels_above_each_other
