"""Figures of grid points along one axis: how far the clamp moves in one period of sticking."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from vibrissa.figures import style
from vibrissa.figures.kinds import POINT, kind
from vibrissa.figures.series import Series
from vibrissa.figures.style import COLORS

# The inset shows the lowest levels of the step grid, where there are many.
SHOWN_LEVELS, MANY_LEVELS = 7, 20


@kind("taper", columns=(*POINT, "x0_slip", "x0_max", "penetrates"))
def taper(rows: pd.DataFrame) -> Figure:
    """x0,max over θ for each μ0: the step grid's marks and the exact onset (paper Figure 6)."""
    locks = rows["status"] == "lock"
    if locks.all():
        return style.message("the tip locks at every point")
    # Series of which nothing can be drawn would take the colours from the others.
    never_slip = locks.groupby(rows["mu0"]).transform("all")
    locking = style.where_it_locks(bool(locks.any()), rows["mu0"][never_slip])
    rows = rows[~never_slip]
    figure, axes = style.axes(4.2)
    series = Series(rows["mu0"], r"\mu_0")
    for mu0, points in rows.sort_values("theta").groupby("mu0"):
        color = series.color(mu0)
        axes.plot(
            points["theta"], points["x0_slip"], color=color, linewidth=0.8, **style.level(points)
        )
        through = points["penetrates"].fillna(False).astype(bool)
        marks: dict[str, Any] = {
            "linestyle": "none",
            "marker": series.marker(mu0),
            "markersize": series.marker_size(5),
        }
        inside, passing = points[~through], points[through]
        axes.plot(inside["theta"], inside["x0_max"], color=color, label=series.label(mu0), **marks)
        axes.plot(
            passing["theta"], passing["x0_max"], color=color, markerfacecolor="white", **marks
        )
    axes.plot([], [], color="black", linewidth=0.8, label="exact onset of slip")
    if rows["penetrates"].fillna(False).any():
        label = "hollow: the rod passes through the surface"
        axes.plot([], [], "o", color="black", markerfacecolor="white", label=label)
    first = rows.iloc[0]
    marked = rf"marks: last sticking state, $\Delta x_0 = {first['dx0']:g}$"
    axes.set_title(rf"$\eta = {first['eta']:g}$; {marked}{locking}")
    axes.set_xlabel(style.TAPER)
    axes.set_ylabel(style.DISPLACEMENT)
    style.from_zero(axes)
    axes.margins(x=0.03)
    series.explain(axes)
    return figure


@kind("friction", columns=(*POINT, "x0_slip", "x0_max", "n_steps", "mu_lock"))
def friction(rows: pd.DataFrame) -> Figure:
    """x0,max over μ0: levels of the step grid, exact onset and locking (paper Figure 7)."""
    figure, axes = style.axes(4.6)
    rows = rows.sort_values("mu0")
    first, slips = rows.iloc[0], rows[rows["status"] == "slip"]
    _onset_and_marks(axes, slips, first["dx0"], marker_size=2.2)
    _mark_lock(axes, first["mu_lock"], rows["mu0"].max())
    axes.set_title(rf"$\theta = {first['theta']:g}$, $\eta = {first['eta']:g}$")
    axes.set_xlabel(style.FRICTION)
    axes.set_ylabel(style.DISPLACEMENT)
    style.from_zero(axes)
    axes.margins(x=0.03)
    levels = np.unique(slips["n_steps"])
    enlarged = len(levels) >= MANY_LEVELS
    axes.legend(loc="upper left" if enlarged else "best")
    if enlarged:
        _enlarge_levels(axes, slips, levels[:SHOWN_LEVELS], first["dx0"])
    return figure


def _onset_and_marks(axes: Axes, slips: pd.DataFrame, dx0: float, marker_size: float) -> None:
    """Draw the exact onset, and a mark for each point on the step grid."""
    axes.plot(
        slips["mu0"],
        slips["x0_slip"],
        color=COLORS[1],
        linewidth=0.9,
        label="exact onset of slip",
        **style.level(slips),
    )
    axes.plot(
        slips["mu0"],
        slips["x0_max"],
        linestyle="none",
        marker="o",
        markersize=marker_size,
        color=COLORS[0],
        label=rf"last sticking state, $\Delta x_0 = {dx0:g}$",
    )


def _mark_lock(axes: Axes, mu_lock: float, largest_mu0: float) -> None:
    """Draw the locking friction, and shade what lies above it."""
    if largest_mu0 > mu_lock:
        axes.axvspan(mu_lock, largest_mu0, color="#eeeeee", linewidth=0)
    axes.axvline(mu_lock, color=style.SURFACE, linewidth=0.9, linestyle="--")
    axes.annotate(
        rf"the tip locks above $\mu_\mathrm{{lock}} = {mu_lock:.4f}$",
        (mu_lock, 0.03),
        xycoords=("data", "axes fraction"),
        xytext=(4, 0),
        textcoords="offset points",
        rotation=90,
        ha="left",
        va="bottom",
        color=style.SURFACE,
    )


def _enlarge_levels(axes: Axes, slips: pd.DataFrame, levels: NDArray[np.int64], dx0: float) -> None:
    """Show some levels of the step grid, numbers of steps, in an inset."""
    window = slips[slips["n_steps"] <= levels[-1]]
    inset = axes.inset_axes((0.09, 0.40, 0.42, 0.38))
    _onset_and_marks(inset, slips, dx0, marker_size=3.5)
    inset.set_xlim(window["mu0"].min() - 0.002, window["mu0"].max() + 0.002)
    inset.set_ylim((levels[0] - 0.6) * dx0, (levels[-1] + 1.4) * dx0)
    inset.set_yticks(levels * dx0)
    inset.yaxis.grid(True, linewidth=0.4, color="#cccccc")
    inset.tick_params(labelsize=7)
    for spine in inset.spines.values():
        spine.set_visible(True)
        spine.set_color("#999999")
    inset.set_title("levels of the step grid", fontsize=8)
    axes.indicate_inset_zoom(inset, edgecolor="#999999")
