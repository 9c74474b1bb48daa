"""Figures of grid points along one axis: how far the clamp moves in one period of sticking."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibrissa.figures import style
from vibrissa.figures.kinds import POINT, kind
from vibrissa.figures.series import Series
from vibrissa.figures.style import COLORS, WITHOUT_ONSET, Look

# The lowest levels of the step grid are enlarged where there are many.
SHOWN_LEVELS, MANY_LEVELS = 7, 20


@kind("taper", columns=(*POINT, "x0_slip", "x0_max", "penetrates"))
def taper(rows: pd.DataFrame) -> Figure:
    """x0,max over θ for each μ0: the step grid's marks and the exact onset (paper Figure 6)."""
    series = Series(rows["mu0"], r"\mu_0")
    figure, panel = axes_with_gaps(rows, series)
    for mu0, points in rows.sort_values("theta").groupby("mu0"):
        marks: Look = {
            "color": series.color(mu0),
            "linestyle": "none",
            "marker": series.marker(mu0),
            "markersize": series.marker_size(3.5),
        }
        panel.plot(points["theta"], points["x0_slip"], color=series.color(mu0), linewidth=0.6)
        through = points["penetrates"].fillna(False).astype(bool)
        whole, passing = points["x0_max"].mask(through), points["x0_max"].where(through)
        panel.plot(points["theta"], whole, label=series.label(mu0), **marks)
        panel.plot(points["theta"], passing, markerfacecolor="white", **marks)
    step = rf"last sticking state, $\Delta x_0 = {rows['dx0'].iloc[0]:g}$"
    style.mean(panel, step, marker=".", color="black", linestyle="none")
    style.mean(panel, "exact onset of slip", color="black", linewidth=0.6)
    if rows["penetrates"].fillna(False).any():
        hollow: Look = {
            "marker": "o",
            "color": "black",
            "markerfacecolor": "white",
            "linestyle": "none",
        }
        style.mean(panel, "passes through the surface", **hollow)
    panel.set_xlabel(style.TAPER)
    panel.set_ylabel(style.DISPLACEMENT)
    style.from_zero(panel)
    series.explain(panel)
    return figure


def axes_with_gaps(rows: pd.DataFrame, series: Series) -> tuple[Figure, Axes]:
    """Make axes over θ; above them a strip that marks the points without an onset, if any.

    Parameters
    ----------
    rows : DataFrame
        With ``theta``, ``mu0`` and ``status``.
    series : Series
        Of the values of μ0: each has a line in the strip.
    """
    gaps = rows[rows["status"].isin(WITHOUT_ONSET)]
    if gaps.empty:
        return style.axes(2.8)
    height = 0.15 * min(gaps["mu0"].nunique(), 8)
    figure = style.page(3.0 + height)
    strip, panel = figure.subplots(2, 1, sharex=True, height_ratios=(height, 2.6))
    for status, (marker, label) in WITHOUT_ONSET.items():
        points = gaps[gaps["status"] == status]
        colors, places = points["mu0"].map(series.color), points["mu0"].map(series.place)
        size = series.marker_size(16)
        strip.scatter(points["theta"], places, s=size, c=list(colors), marker=marker, linewidth=1)
        if len(points):
            style.mean(strip, label, marker=marker, color="black", linestyle="none")
    strip.set_ylabel("no onset", rotation=0, ha="right", va="center")
    strip.tick_params(left=False, labelleft=False, bottom=False, labelbottom=False)
    strip.margins(y=0.5 / gaps["mu0"].nunique())
    return figure, panel


@kind("friction", columns=(*POINT, "x0_slip", "x0_max", "n_steps", "mu_lock"))
def friction(rows: pd.DataFrame) -> Figure:
    """x0,max over μ0: levels of the step grid, exact onset and locking (paper Figure 7)."""
    rows = rows.sort_values("mu0")
    slips = rows[rows["status"] == "slip"]
    levels = np.unique(slips["n_steps"])
    if len(levels) < MANY_LEVELS:
        figure, panel = style.axes(2.9)
    else:
        figure = style.page(2.6, style.PAGE)
        panel, enlarged = figure.subplots(1, 2, width_ratios=(1.4, 1.0))
        _levels(enlarged, slips[slips["n_steps"] <= levels[SHOWN_LEVELS - 1]], 2.5)
        enlarged.set_ylabel("lowest levels of the step grid / $L$")
        steps = levels[:SHOWN_LEVELS] * rows["dx0"].iloc[0]
        enlarged.set_yticks(steps)
        enlarged.yaxis.grid(True, linewidth=0.3, color="#cccccc")
    _levels(panel, slips, 1.5)
    _mark_lock(panel, rows)
    failed = rows["mu0"][rows["status"] == "failed"]
    if len(failed):
        look: Look = {"transform": panel.get_xaxis_transform(), "color": "black"}
        panel.plot(failed, 0.02 + 0.0 * failed, "x", label="failed", **look)
    panel.set_ylabel(style.DISPLACEMENT)
    style.from_zero(panel)
    style.legend(figure)
    return figure


def _levels(panel: Axes, slips: pd.DataFrame, size: float) -> None:
    """Draw the exact onset over μ0, and a mark for each point on the step grid."""
    if len(slips):
        step = rf"last sticking state, $\Delta x_0 = {slips['dx0'].iloc[0]:g}$"
        panel.plot(slips["mu0"], slips["x0_max"], "o", label=step, markersize=size, color=COLORS[0])
        onset: Look = {"color": COLORS[1], "linewidth": 0.8, "label": "exact onset of slip"}
        panel.plot(slips["mu0"], slips["x0_slip"], zorder=3, **onset)
    panel.set_xlabel(style.FRICTION)


def _mark_lock(panel: Axes, rows: pd.DataFrame) -> None:
    """Draw the critical friction coefficient, and shade what lies above it."""
    mu_lock, largest = rows["mu_lock"].iloc[0], rows["mu0"].max()
    if not np.isfinite(mu_lock):
        return
    if largest > mu_lock:
        panel.axvspan(mu_lock, largest, color="#eeeeee", linewidth=0)
    label = rf"locks above $\mu_\mathrm{{lock}} = {mu_lock:.4f}$"
    panel.axvline(mu_lock, color=style.SURFACE, linewidth=0.8, linestyle="--", label=label)
