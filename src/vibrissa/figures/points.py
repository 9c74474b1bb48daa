"""Figures of grid points along one axis: how far the clamp moves in one period of sticking."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import ConnectionPatch, Rectangle

from vibrissa.figures import labels, style
from vibrissa.figures.kinds import POINT, kind
from vibrissa.figures.series import Series
from vibrissa.figures.style import COLORS, HOLLOW, Look
from vibrissa.study.axes import FREQUENCIES

# The lowest SHOWN_LEVELS levels of the step grid are enlarged if there are MANY_LEVELS or more.
SHOWN_LEVELS, MANY_LEVELS = 7, 20
# A lock above this multiple of the largest μ0 stands in the legend alone.
NEAR = 1.5
# Colour of the frame of what is enlarged.
FRAME = "#7a7a7a"


@kind("taper", columns=(*POINT, "x0_slip", "x0_max", "penetrates"))
def taper(rows: pd.DataFrame) -> Figure:
    """x0,max, a multiple of Δx0, and the exact onset, over θ for each μ0 (paper Figure 6)."""
    series = Series(rows, "mu0")
    figure, panel = style.axes(3.0)
    series.lines(panel, rows, "theta", "x0_slip", label=None, linewidth=0.6)
    through = rows["penetrates"].fillna(False).astype(bool)
    series.lines(panel, rows[~through], "theta", "x0_max", size=3.5)
    series.lines(panel, rows[through], "theta", "x0_max", size=3.5, label=None, mfc="white")
    style.mean(panel, _step(rows), marker=".", color="black", linestyle="none")
    style.mean(panel, "exact onset of slip", color="black", linewidth=0.6)
    if through.any():
        style.mean(panel, "passes through the surface", **HOLLOW)
    series.gaps(panel, rows, "theta")
    panel.set(xlabel=style.TAPER, ylabel=style.DISPLACEMENT)
    style.from_zero(panel)
    labels.at_ends(panel)
    series.explain(panel)
    return figure


@kind("friction", columns=(*POINT, "x0_slip", "x0_max", "n_steps", "mu_lock"))
def friction(rows: pd.DataFrame) -> Figure:
    """x0,max, a multiple of Δx0, over μ0, with the exact onset and the lock (paper Figure 7)."""
    rows = rows.sort_values("mu0")
    slips = rows[rows["status"] == "slip"]
    levels = np.unique(slips["n_steps"])
    if len(levels) < MANY_LEVELS:
        figure, panel = style.axes(2.9)
    else:
        figure = style.page(2.6, style.PAGE)
        panel, enlarged = figure.subplots(1, 2, width_ratios=(1.4, 1.0))
        _levels(enlarged, slips[slips["n_steps"] <= levels[SHOWN_LEVELS - 1]], 2.5)
        enlarged.set_title("enlarged: levels of the step grid", fontsize=8)
        enlarged.set_yticks(levels[:SHOWN_LEVELS] * rows["dx0"].iloc[0])
        enlarged.yaxis.grid(True, linewidth=0.3, color="#cccccc")
        # Away from the lines between both panels, which would cross its label.
        enlarged.yaxis.tick_right()
        enlarged.yaxis.set_label_position("right")
        for side in ("top", "right"):
            enlarged.spines[side].set_visible(True)
        for spine in enlarged.spines.values():
            spine.set_color(FRAME)
        _frame(figure, panel, enlarged)
    _levels(panel, slips, 1.5)
    mu_lock = rows["mu_lock"].iloc[0]
    label = rf"locks above $\mu_\mathrm{{lock}} = {mu_lock:.4f}$"
    line: style.Look = {"color": style.SURFACE, "linewidth": 0.8, "linestyle": "--", "label": label}
    if mu_lock < NEAR * rows["mu0"].max():
        panel.axvspan(mu_lock, max(mu_lock, rows["mu0"].max()), color="#eeeeee", linewidth=0)
        panel.axvline(mu_lock, **line)
    elif np.isfinite(mu_lock):
        style.mean(panel, **line)
    Series(rows, "theta").gaps(panel, rows[rows["status"] != "lock"], "mu0")
    for each in figure.axes:
        each.set_ylabel(style.DISPLACEMENT)
    style.from_zero(panel)
    style.legend(figure)
    return figure


def _frame(figure: Figure, panel: Axes, enlarged: Axes) -> None:
    """Draw in a panel the frame of what another panel enlarges, and lines between both."""
    (left, right), (low, high) = enlarged.get_xlim(), enlarged.get_ylim()
    look: Look = {"color": FRAME, "linewidth": 0.7, "zorder": 4}
    panel.add_patch(Rectangle((left, low), right - left, high - low, fill=False, **look))
    for up, corner in ((0, low), (1, high)):
        places: Look = {"xyA": (right, corner), "coordsA": "data", "xyB": (0, up)}
        line = ConnectionPatch(
            **places, coordsB="axes fraction", axesA=panel, axesB=enlarged, linestyle=":", **look
        )
        # The line crosses both panels, and must not widen them.
        line.set_in_layout(False)
        figure.add_artist(line)


@kind("frequencies", columns=(*POINT, *FREQUENCIES))
def frequencies(rows: pd.DataFrame) -> Figure:
    """Natural frequencies at the onset of slip over θ for each μ0: the first, and the second."""
    series = Series(rows, "mu0")
    figure, panel = style.axes(3.0)
    for name, (which, look) in zip(FREQUENCIES, style.FREQUENCY_LOOKS.items(), strict=True):
        if rows[name].notna().any():
            series.lines(panel, rows, "theta", name, linestyle=look, label=None)
            style.mean(panel, which, linestyle=look, color="black")
    series.gaps(panel, rows, "theta")
    panel.set(xlabel=style.TAPER, ylabel=style.FREQUENCY)
    style.from_zero(panel)
    series.explain(panel)
    return figure


def _levels(panel: Axes, slips: pd.DataFrame, size: float) -> None:
    """Draw the exact onset over μ0, and a mark for the x0,max of each grid point that slips."""
    if len(slips):
        marks: style.Look = {"markersize": size, "color": COLORS[0], "label": _step(slips)}
        panel.plot(slips["mu0"], slips["x0_max"], "o", **marks)
        onset: style.Look = {"color": COLORS[1], "linewidth": 0.8, "label": "exact onset of slip"}
        panel.plot(slips["mu0"], slips["x0_slip"], zorder=3, **onset)
    panel.set_xlabel(style.FRICTION)


def _step(rows: pd.DataFrame) -> str:
    return rf"last sticking state, $\Delta x_0 = {rows['dx0'].iloc[0]:g}$"
