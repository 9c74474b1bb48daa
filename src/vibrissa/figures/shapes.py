"""Panels of equal scale in which shapes of rods are drawn."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from vibrissa.figures import style

# Largest number of panels in a row.
IN_A_ROW = 3
# Room beside the shapes and above the surface (L).
BESIDE, ABOVE = 0.04, 0.08
# Largest scale (inch for a length L); room for labels and for a legend (inch).
LARGEST_SCALE, LABELS, LEGEND = 2.5, 0.5, 0.85
# A single panel that is wider than this (L) takes the whole page.
WIDEST = 2.0
# With more shapes, lines are pixels in PDF and SVG, to keep files small.
MOST_LINES = 150


def panels(parts: Sequence[pd.DataFrame]) -> tuple[Figure, list[Axes], bool]:
    """Make a figure with a panel for each table of shapes, all panels to the same scale.

    Each table has the columns ``shape_x``, ``shape_y`` and ``eta`` (L). Its panel has room for the
    shapes, and shows the surface. Returns the figure, its panels, and whether a legend has room
    beside them.
    """
    x = [_range(rows["shape_x"]) for rows in parts]
    y = [_range(rows["shape_y"]) for rows in parts]
    bottom = min(low for low, _ in y) - BESIDE
    top = max(*(high for _, high in y), *(rows["eta"].max() for rows in parts)) + ABOVE
    columns = min(len(parts), IN_A_ROW)
    lines = -(-len(parts) // columns)
    spans = [high - low + 2.0 * BESIDE for low, high in x]
    widths = [max(spans[column::columns]) for column in range(columns)]
    is_column = columns == 1 and widths[0] < WIDEST
    width = style.COLUMN if is_column else style.PAGE
    room = width - LABELS - 0.15 * (columns - 1)
    scale = min(room / sum(widths), LARGEST_SCALE)
    figure = style.page(lines * (scale * (top - bottom) + LABELS) + LEGEND - LABELS, width)
    grid = figure.subplots(lines, columns, sharey=True, squeeze=False, width_ratios=widths)
    for i, panel in enumerate(grid.flat):
        if i >= len(parts):
            panel.set_visible(False)
            continue
        panel.set_aspect("equal")
        style.surface(panel, parts[i]["eta"].iloc[0])
        panel.set_xlim(x[i][0] - BESIDE, x[i][0] - BESIDE + widths[i % columns])
        panel.set_xlabel(r"$x$ / $L$")
    grid[0, 0].set_ylim(bottom, top)
    for panel in grid[:, 0]:
        panel.set_ylabel(r"$y$ / $L$")
    return figure, list(grid.flat[: len(parts)]), sum(widths) * scale < 0.75 * room


def _range(arrays: pd.Series) -> tuple[float, float]:
    values = np.concatenate(list(arrays))
    return float(values.min()), float(values.max())


def draw(panel: Axes, rows: pd.DataFrame, **look: Any) -> None:
    """Draw the shape in each row."""
    lines = [np.column_stack(pair) for pair in zip(rows["shape_x"], rows["shape_y"], strict=True)]
    look |= {"capstyle": "round", "rasterized": len(lines) > MOST_LINES}
    panel.add_collection(LineCollection(lines, **look), autolim=False)
