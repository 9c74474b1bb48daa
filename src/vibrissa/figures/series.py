"""Series of a figure: what tells them apart, whether there are two or a hundred."""

from collections.abc import Iterable, Sequence
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, ListedColormap, to_hex

from vibrissa.figures import style
from vibrissa.figures.style import COLORS, MARKERS

# The dark part of the colour map: its yellow end cannot be seen on white.
GRADED, DARK = "viridis", 0.93
# Values at a colourbar: all of so many, or so many of more.
ALL_TICKS, SOME_TICKS = 20, 11


def told_apart(values: Sequence[float], digits: int) -> list[str]:
    """Spell different values with so many digits, or with more where two would be the same.

    Examples
    --------
    >>> told_apart([0.2, 0.3], 4), told_apart([0.99991, 0.99992], 4)
    (['0.2', '0.3'], ['0.99991', '0.99992'])
    """
    texts = [f"{value:.{digits}g}" for value in values]
    return texts if len(set(texts)) == len(texts) else told_apart(values, digits + 1)


class Series:
    """Looks of the series of a quantity's values.

    Few series have the colours and markers of the paper's figures, and a legend. More have colours
    that go from dark to light with the rank of the value, and a colourbar.

    Parameters
    ----------
    values : iterable of float
        One for each series, or several that are equal.
    symbol : str
        Of the quantity, in TeX.

    Attributes
    ----------
    values : tuple of float
        Each once, increasing.
    few : bool
        Whether a legend names each series.
    """

    def __init__(self, values: Iterable[float], symbol: str) -> None:
        self.values = tuple(sorted(set(values)))
        self.symbol = symbol
        self.few = len(self.values) <= len(COLORS)
        if self.few:
            self._colors: tuple[str, ...] = COLORS
        else:
            shades = matplotlib.colormaps[GRADED](np.linspace(0.0, DARK, len(self.values)))
            self._colors = tuple(map(to_hex, shades))

    def place(self, value: float) -> int:
        """Return the rank of the series of a value, from 0."""
        return self.values.index(value)

    def color(self, value: float) -> str:
        """Colour of the series of a value."""
        return self._colors[self.place(value)]

    def marker(self, value: float) -> str:
        """Marker of the series of a value; of many series all have the same."""
        return MARKERS[self.place(value)] if self.few else "o"

    def marker_size(self, few: float) -> float:
        """Size of markers, from the one that they have where there are few series (points)."""
        return few if self.few else 0.5 * few

    def label(self, value: float) -> str | None:
        """Label of a series in a legend; none where a colourbar tells the values."""
        if not self.few:
            return None
        return rf"${self.symbol} = {told_apart(self.values, 6)[self.place(value)]}$"

    def line(self, panel: Axes, value: float, x: pd.Series, y: pd.Series, **look: Any) -> None:
        """Draw the line of a series; of a single point a mark."""
        look = {"marker": style.alone(x), "label": self.label(value)} | look
        panel.plot(x, y, color=self.color(value), **look)

    def explain(self, panels: Axes | Sequence[Axes], **look: Any) -> None:
        """Put a legend below the axes of the figure, and a colourbar beside some of them."""
        first = panels if isinstance(panels, Axes) else panels[0]
        style.legend(first.figure, **look)
        self.colorbar(panels)

    def colorbar(self, panels: Axes | Sequence[Axes]) -> None:
        """Put a colourbar beside axes, if a legend cannot name all the series."""
        if self.few:
            return
        figure = (panels if isinstance(panels, Axes) else panels[0]).figure
        count = len(self.values)
        shown = np.linspace(0, count - 1, count if count <= ALL_TICKS else SOME_TICKS).round()
        colors = ScalarMappable(
            BoundaryNorm(np.arange(count + 1) - 0.5, count), ListedColormap(self._colors)
        )
        bar = figure.colorbar(colors, ax=panels, ticks=shown, aspect=30, label=f"${self.symbol}$")
        bar.ax.set_yticklabels(told_apart([self.values[int(place)] for place in shown], 4))
        bar.ax.tick_params(length=2)
        bar.ax.minorticks_off()
        bar.outline.set_visible(False)
