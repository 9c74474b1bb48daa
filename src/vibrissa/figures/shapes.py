"""Panels of equal scale in which shapes of rods are drawn."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from vibrissa.figures import style, symbols
from vibrissa.numerics.arrays import FloatArray

# Largest number of panels in a row.
IN_A_ROW = 3
# Room beside the shapes, below the clamp and above the surface (L).
BESIDE, BELOW, ABOVE = 0.04, 0.19, 0.12
# Largest scale (inch for a length L); room for the axis beside and below a panel (inch).
LARGEST_SCALE, LABELS = 2.5, 0.5
# Height of the title of a panel, and distance of two panels above each other (inch).
TITLE, BETWEEN = 0.15, 0.14
# Height of a line of a legend (inch).
LEGEND_LINE = 0.17
# A single panel that is wider than this (L) takes the whole page.
WIDEST = 2.0
# Number of shapes of a period that bound the strips of its band, and of points of each.
STRIPS, POINTS = 9, 34
# Between two shapes of a band, no point moves by more than this multiple of the clamp's motion.
CONTINUOUS = 25.0


class Room(NamedTuple):
    """Limits of shapes (L): those that all figures of the same data have in common."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def width(self) -> float:
        """Width of a panel (L)."""
        return self.right - self.left


def room_of(rows: pd.DataFrame) -> Room:
    """Return the limits of shapes, with room beside them."""
    left, right = _range(rows["shape_x"])
    bottom, top = _range(rows["shape_y"])
    top = max(top, float(rows["eta"].max())) + ABOVE
    return Room(left - BESIDE, right + BESIDE, bottom - BELOW, top)


def _range(arrays: pd.Series) -> tuple[float, float]:
    values = np.concatenate(list(arrays))
    return float(values.min()), float(values.max())


def panels(
    etas: Sequence[float], room: Room, columns: int, usual: int
) -> tuple[Figure, list[Axes]]:
    """Make a figure with a panel for each surface, all to the same scale.

    The scale is that of a page with `usual` panels in a row, so that it does not depend on the
    number of panels. A single panel has the width of a column.
    """
    page = style.PAGE - LABELS - 0.15 * (usual - 1)
    scale = min(page / (usual * room.width), LARGEST_SCALE)
    is_column = columns == 1 and room.width < WIDEST
    width = style.COLUMN if is_column else style.PAGE
    inside = width - LABELS - 0.15 * (columns - 1)
    # What is left of the width is room for labels beside the shapes.
    spare = max(inside / (columns * scale) - room.width, 0.0) if columns == 1 else 0.0
    lines = -(-len(etas) // columns)
    titles = TITLE if len(etas) > 1 else 0.0
    height = lines * (scale * (room.top - room.bottom) + titles) + LABELS + (lines - 1) * BETWEEN
    figure = style.page(height, width)
    grid = figure.subplots(lines, columns, sharex=True, sharey=True, squeeze=False)
    for i, panel in enumerate(grid.flat):
        if i >= len(etas):
            panel.set_visible(False)
            continue
        panel.set_aspect("equal")
        symbols.surface(panel, etas[i])
        panel.set(xlim=(room.left, room.right + spare), ylim=(room.bottom, room.top))
        is_last = i + columns >= len(etas)
        panel.tick_params(labelbottom=is_last)
        if is_last:
            panel.set_xlabel(r"$x$ / $L$")
    for panel in grid[:, 0]:
        panel.set_ylabel(r"$y$ / $L$")
    return figure, list(grid.flat[: len(etas)])


def legend(figure: Figure, columns: int) -> None:
    """Put a legend below the panels, and make room for it, so that their scale stays."""
    style.legend(figure, ncols=columns)
    for each in figure.legends:
        lines = -(-len(each.get_texts()) // columns)
        figure.set_figheight(figure.get_figheight() + LEGEND_LINE * (lines + 0.5))


def draw(panel: Axes, rows: pd.DataFrame, **look: Any) -> None:
    """Draw the shape in each row as a line."""
    lines = [np.column_stack(pair) for pair in zip(rows["shape_x"], rows["shape_y"], strict=True)]
    panel.add_collection(LineCollection(lines, **{"capstyle": "round", **look}), autolim=False)


def bands(panel: Axes, periods: Iterable[pd.DataFrame], color: str) -> None:
    """Fill what the rod passes over in the steps of each period, in the order of its rows."""
    strips = list(chain.from_iterable(map(_strips, periods)))
    # An edge of the same colour closes the seams between the strips.
    look: style.Look = {"facecolor": color, "edgecolor": color, "linewidth": 0.3}
    panel.add_collection(PolyCollection(strips, **look), autolim=False)


def _strips(rows: pd.DataFrame) -> Iterator[FloatArray]:
    """Yield the outlines of the strips between the shapes of one period."""
    x, y = (np.stack(list(rows[name])) for name in ("shape_x", "shape_y"))
    points = np.unique(np.linspace(0, x.shape[1] - 1, POINTS).astype(int))
    x, y = x[:, points], y[:, points]
    moved = np.hypot(np.diff(x, axis=0), np.diff(y, axis=0)).max(axis=1)
    # The rod is not drawn between two shapes if it snaps or swings from one to the other.
    jumps = np.flatnonzero(moved > CONTINUOUS * np.abs(np.diff(rows["footpoint"]))) + 1
    for part in np.split(np.arange(len(x)), jumps):
        kept = np.unique(np.linspace(0, len(part) - 1, STRIPS).astype(int))
        for near, far in zip(part[kept[:-1]], part[kept[1:]], strict=True):
            ends = np.append(x[near], x[far][::-1]), np.append(y[near], y[far][::-1])
            yield np.column_stack(ends)
