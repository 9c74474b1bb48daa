"""Colours and marks of the series of a figure, few or many."""

from collections.abc import Sequence
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, ListedColormap, to_hex

from vibrissa.figures import style
from vibrissa.figures.style import COLORS, DASHES, MARKERS, WITHOUT_ONSET, Look

SYMBOLS = {"theta": r"\theta", "mu0": r"\mu_0", "eta": r"\eta", "x1": "x_1"} | {
    "turn": r"b\ /\ \mathrm{degree}"
}
# Label of quantities of the onset.
QUANTITIES = {
    "mu_lock": r"lock $\mu_\mathrm{lock}$",
    "x0_slip": r"onset of slip $x_{0,\mathrm{slip}}$ / $L$",
    "reaction_fx_slip": r"$f_x$ at the onset / $E I_0/L^2$",
    "reaction_fy_slip": r"$f_y$ at the onset / $E I_0/L^2$",
    "reaction_m_slip": r"$m(0)$ at the onset / $E I_0/L$",
}
# The dark part of the colour map: its yellow end cannot be seen on white.
GRADED, DARK = "viridis", 0.8
# A colourbar labels all of up to ALL_TICKS values; of more values, it labels SOME_TICKS.
ALL_TICKS, SOME_TICKS = 20, 11


class Series:
    """Colours, markers and labels of series: one for each value of a column, in increasing order.

    Up to six series have distinct colours and dashes, the paper's markers, and names at the lines
    or a legend; more series have graded colours and a colourbar.
    """

    def __init__(self, rows: pd.DataFrame, column: str) -> None:
        self.column, self.symbol = column, SYMBOLS.get(column, column.replace("_", r"\ "))
        self.values = sorted(set(rows[column]))
        self.few = len(self.values) <= len(COLORS)
        parts = np.linspace(0.0, DARK, len(self.values))
        graded = [to_hex(color) for color in matplotlib.colormaps[GRADED](parts)]
        self._colors = list(COLORS) if self.few else graded

    def place(self, value: float) -> int:
        """Return the index of the series that has this value."""
        return self.values.index(value)

    def color(self, value: float) -> str:
        """Return the colour of the series that has this value."""
        return self._colors[self.place(value)]

    def dash(self, value: float) -> Any:
        """Return the dashes of the series that has this value; many series have solid lines."""
        return DASHES[self.place(value)] if self.few else "-"

    def label(self, value: float) -> str | None:
        """Return the legend's label of a series; None if a colourbar shows the values."""
        return f"${self.symbol} = {value:g}$" if self.few else None

    def lines(
        self, panel: Axes, rows: pd.DataFrame, x: str, y: str, size: float = 0.0, **look: Any
    ) -> None:
        """Draw column `y` over `x`: a line for each series, or markers of a `size` (points)."""
        for value, points in rows.sort_values(x).groupby(self.column):
            known: Look = {"color": self.color(value), "label": self.label(value)}
            if not size:
                known |= style.alone(points[y])
                known["linestyle"] = self.dash(value)
            else:
                marker, share = (MARKERS[self.place(value)], 1.0) if self.few else ("o", 0.5)
                known |= {"marker": marker, "linestyle": "none", "markersize": share * size}
            panel.plot(points[x], points[y], **known | look)

    def gaps(self, panel: Axes, rows: pd.DataFrame, x: str) -> None:
        """Mark points without an onset in a strip above a panel, with one row for each series."""
        rows = rows[rows["status"].isin(WITHOUT_ONSET)]
        if rows.empty:
            return
        count = rows[self.column].nunique()
        rows = rows.assign(place=rows[self.column].map(self.place))
        strip = panel.inset_axes((0.0, 1.02, 1.0, 0.06 * min(count, 8)), sharex=panel)
        for status, points in rows.groupby("status"):
            marker, label = WITHOUT_ONSET[status]
            self.lines(strip, points, x, "place", size=4, marker=marker, label=None)
            style.mean(panel, label, marker=marker, color="black", linestyle="none")
        strip.set_ylabel("no onset", rotation=0, ha="right", va="center")
        strip.tick_params(left=False, labelleft=False, bottom=False, labelbottom=False)
        strip.margins(y=0.5 / count)

    def explain(self, panels: Axes | Sequence[Axes], **look: Any) -> None:
        """Add a legend to the figure, and a colourbar for more than six series."""
        first = panels if isinstance(panels, Axes) else panels[0]
        told = {name for one in first.figure.axes for name in one.get_legend_handles_labels()[1]}
        for value in self.values:
            # A series of which nothing is drawn, or only marks that have another meaning.
            if self.few and told.isdisjoint([self.label(value)]):
                style.mean(first, str(self.label(value)), color=self.color(value))
        style.legend(first.figure, **look)
        if not self.few:
            self.colorbar(panels)

    def colorbar(self, panels: Axes | Sequence[Axes]) -> None:
        """Put a colourbar beside the panels."""
        figure = (panels if isinstance(panels, Axes) else panels[0]).figure
        count = len(self.values)
        shown = np.linspace(0, count - 1, count if count <= ALL_TICKS else SOME_TICKS).round()
        colors = ScalarMappable(
            BoundaryNorm(np.arange(count + 1) - 0.5, count), ListedColormap(self._colors)
        )
        label = f"${self.symbol}$"
        bar = figure.colorbar(colors, ax=panels, ticks=shown, aspect=30, label=label)
        bar.ax.set_yticklabels([f"{self.values[int(place)]:.4g}" for place in shown])
        bar.ax.tick_params(length=2)
        bar.ax.minorticks_off()
        bar.outline.set_visible(False)
