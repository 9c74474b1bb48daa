"""Figures of friction read from recordings: errors, coverage, uncertainty, and what limits it."""

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from pandas.api.types import is_numeric_dtype

from vibrissa.figures import style
from vibrissa.figures.kinds import kind
from vibrissa.figures.maps import LABELS
from vibrissa.figures.periods import DrawnSeries, lines_of
from vibrissa.figures.series import Series
from vibrissa.tables import accuracy
from vibrissa.tables.accuracy import STATED

READ = (*accuracy.POINT, "message", *accuracy.COLUMNS)
ERROR = r"standard deviation of $\mu_0$"
NO_ESTIMATE = "no recording has an estimate"


def _of(series: Series, found: pd.DataFrame) -> Iterator[DrawnSeries]:
    """Split rows by the values of a series; of many values, a colourbar has the names."""
    for value in series.values:
        look: style.Look = {"color": series.color(value), "linestyle": series.dash(value)}
        rows = found[found[series.column] == value]
        yield DrawnSeries(name=series.label(value) or "", rows=rows, look=look)


class _Lines(list[DrawnSeries]):
    """Lines of a figure: one for each value of an axis, or of a name."""

    def __init__(self, found: pd.DataFrame, by: str) -> None:
        self.series = Series(found, by) if is_numeric_dtype(found[by]) else None
        super().__init__(lines_of(found, by) if self.series is None else _of(self.series, found))

    def explain(self, panels: Sequence[Axes]) -> None:
        """Add a legend and, for many values, a colourbar."""
        style.legend(panels[0].figure)
        if self.series is not None and not self.series.few:
            self.series.colorbar(panels)


@kind("accuracy", columns=READ, keys=("over", "by"))
def errors(rows: pd.DataFrame, over: str, by: str) -> Figure:
    """Draw the errors and the stated deviations of the means (left) and of single periods."""
    found = accuracy.accuracy(rows, list(dict.fromkeys((by, over))))
    if not found["estimates"].any():
        return style.message(NO_ESTIMATE)
    figure = style.page(2.7, style.PAGE)
    panels = figure.subplots(1, 2, sharex=True)
    lines = _Lines(found, by)
    for line in lines:
        points, color = line.rows.sort_values(over), line.look["color"]
        bars: style.Look = {"capsize": 2, "linestyle": "none", "marker": "o", "markersize": 3}
        panels[0].errorbar(points[over], points["rms"], points["rms_error"], color=color, **bars)
        panels[0].plot(points[over], points["stated"], label=line.name or None, **line.look)
        look: style.Look = {"color": color, "linestyle": "none", "marker": "o", "markersize": 3}
        panels[1].plot(points[over], points["period_error"], **look)
        panels[1].plot(points[over], points["period_stated"], **line.look)
        hollow: style.Look = look | {"marker": "D", "markerfacecolor": "none", "markersize": 5}
        panels[1].plot(points[over], points["predicted"], **hollow)
    style.mean(panels[0], "error (rms)", marker="o", markersize=3, color="black", ls="none")
    style.mean(panels[0], "stated", color="black", linewidth=0.8)
    if found["predicted"].notna().any():
        diamond: style.Look = {"marker": "D", "markerfacecolor": "none", "color": "black"}
        style.mean(panels[0], "predicted by a design", linestyle="none", **diamond)
    panels[0].set_title("mean of a recording", fontsize=8, loc="left", pad=2)
    panels[1].set_title("single period", fontsize=8, loc="left", pad=2)
    panels[0].set_ylabel(ERROR)
    for panel in panels:
        panel.set_xlabel(LABELS[over])
        style.from_zero(panel)
    lines.explain(list(panels))
    return figure


@kind("coverage", columns=READ, keys=("over", "by"))
def coverage(rows: pd.DataFrame, over: str, by: str) -> Figure:
    """Draw which part of the intervals contains the truth, with binomial errors."""
    found = accuracy.accuracy(rows, list(dict.fromkeys((by, over))))
    if not found["estimates"].any():
        return style.message(NO_ESTIMATE)
    figure, panel = style.axes(2.6)
    panel.axhline(100.0 * STATED, color="black", linewidth=0.6, linestyle=":")
    lines = _Lines(found, by)
    values = np.sort(found[over].unique())
    # Series stand beside each other, so that their error bars can be told apart.
    gap = 0.04 * float(np.ptp(values)) / max(len(lines), 1)
    for place, line in enumerate(lines):
        points = line.rows.sort_values(over)
        share, error = 100.0 * points["coverage"], 100.0 * points["coverage_error"]
        panel.errorbar(
            points[over] + gap * (place - 0.5 * (len(lines) - 1)),
            share,
            # A share is between none and all.
            [np.minimum(error, share), np.minimum(error, 100.0 - share)],
            color=line.look["color"],
            capsize=2,
            marker="o",
            markersize=3,
            linestyle="none",
        )
        # A bar of errors has no place in a legend of lines.
        if line.name:
            style.mean(panel, line.name, color=line.look["color"], marker="o", linestyle="none")
    panel.set(xlabel=LABELS[over], ylabel="95 % intervals with the truth / %")
    lines.explain([panel])
    return figure


@kind("uncertainty", columns=READ, keys=("over", "by"))
def uncertainty(rows: pd.DataFrame, over: str = "theta", by: str = "eta") -> Figure:
    """Draw the stated standard deviation of the mean over two axes; grey without an estimate."""
    found = accuracy.accuracy(rows, (by, over))
    table = found.pivot(index=by, columns=over, values="stated")
    figure, panel = style.axes(3.0)
    across, upward = style.cells(table.columns), style.cells(table.index)
    drawn = panel.pcolormesh(across, upward, table, cmap="viridis", rasterized=True)
    figure.colorbar(drawn, ax=panel, label=ERROR)
    panel.set_facecolor("#cccccc")
    panel.set(xlabel=LABELS[over], ylabel=LABELS[by])
    if table.isna().any(axis=None):
        style.mean(panel, "no estimate", marker="s", color="#cccccc", linestyle="none")
        style.legend(figure)
    return figure


@kind("limits", columns=(*READ, "limit_name", "limit_share"), keys=("over",))
def limits(rows: pd.DataFrame, over: str) -> Figure:
    """Draw by which part the variance would fall if each quantity alone were exact.

    The quantities that matter most have a line, as many as there are colours.
    """
    known = rows[rows["status"] == "read"]
    if known.empty:
        return style.message(NO_ESTIMATE)
    each = pd.concat(
        [
            pd.DataFrame({over: row[over], "name": row["limit_name"], "share": row["limit_share"]})
            for _, row in known.iterrows()
        ]
    )
    shares = each.groupby([over, "name"])["share"].mean().unstack()
    first = shares.mean().sort_values(ascending=False).index[: len(style.COLORS)]
    figure, panel = style.axes(3.0)
    for name, color, marker in zip(first, style.COLORS, style.MARKERS, strict=False):
        look: style.Look = {"color": color, "marker": marker, "markersize": 3}
        panel.plot(shares.index, 100.0 * shares[name], label=name.replace("_", " "), **look)
    panel.set(xlabel=LABELS[over], ylabel="fall of the variance if exact / %")
    style.from_zero(panel)
    style.legend(figure)
    return figure
