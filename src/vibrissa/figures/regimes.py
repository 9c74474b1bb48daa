"""Figures of the ranges in which a tip slips or locks."""

import math

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator

from vibrissa.figures import labels, style
from vibrissa.figures.kinds import POINT, kind
from vibrissa.figures.series import Series
from vibrissa.figures.style import THIN, Look

SLIPS = {"point": "slips in point contact", "line": "slips in line contact"}
LOCKS = {
    "slips_back": "locks, then slips back",
    "snaps": "locks, then snaps through",
    "out_of_reach": "locks, then out of reach",
    "not_followed": "locks, not followed further",
    "swings_aside": "locks, then buckles laterally",
}
NO_RESULT = "no result"
REGIMES = (*SLIPS.values(), *LOCKS.values(), NO_RESULT)
# Regimes that meet differ in lightness, so that they differ in grey, too.
REGIME_COLORS = ListedColormap(
    ["#0072b2", "#66c2a5", "#d55e00", "#e69f00", "#cc79a7", "#f0e442", "#d6e6f2", "#ffffff"]
)
# Exponents of the approach to the lock: 1/2 at a smooth maximum of −tan α, 1 at a kink.
POWERS = {0.5: (r"$\frac{1}{2}$", "--"), 1.0: ("1", ":")}
# With more points, the dots are pixels in PDF and SVG.
MANY = 300
# By largest number of maps: maps in a row, height of a map (inch), and font size (points).
PANELS = {6: (3, 2.0, 7.0), 20: (4, 1.6, 7.0), math.inf: (8, 0.95, 5.0)}


@kind("locking", columns=("theta", "eta", "status", "message", "mu_lock"))
def locking(rows: pd.DataFrame) -> Figure:
    """μ_lock over θ for each η."""
    # μ_lock is infinite where the tip lifts off instead, and null where no lock was found.
    rods = rows.drop_duplicates(["theta", "eta"])
    lifts = set(rods["eta"][np.isinf(rods["mu_lock"])])
    rods = rods.replace(np.inf, np.nan)
    known = rods["mu_lock"].notna().groupby(rods["eta"]).transform("any")
    if not known.any():
        return style.message("no tip locks")
    figure, panel = style.axes(3.0)
    for eta in sorted(set(rods["eta"][~known])):
        if eta in lifts:
            style.mean(panel, rf"no lock: $\eta = {eta:g}$", linestyle="none")
        else:
            style.no_result(panel, rf"$\eta = {eta:g}$")
    # Series without points would use up colours.
    series = Series(rods[known], "eta")
    series.lines(panel, rods[known], "theta", "mu_lock")
    panel.set(xlabel=style.TAPER, ylabel=style.LOCKING_FRICTION)
    style.from_zero(panel)
    labels.at_ends(panel)
    series.explain(panel)
    return figure


@kind("regimes", columns=(*POINT, "contact", "ends_by", "mu_lock"))
def regimes(rows: pd.DataFrame) -> Figure:
    """Map of the outcome over θ and μ0, for each η: slip in point or line contact, or lock."""
    # One Δx0 is enough: the regime does not depend on it.
    rows = rows.drop_duplicates(["theta", "mu0", "eta"])
    slips, locks = rows["contact"].map(SLIPS), rows["ends_by"].map(LOCKS)
    names = slips.where(rows["status"] == "slip", locks).fillna(NO_RESULT)
    rows = rows.assign(regime=names.map(REGIMES.index))
    heights = rows.groupby("eta")
    columns, height, size = next(PANELS[most] for most in PANELS if len(heights) <= most)
    columns = min(columns, len(heights))
    lines = -(-len(heights) // columns)
    figure = style.page(0.7 + height * lines, style.COLUMN if columns == 1 else style.PAGE)
    # The panels have equal axes anyway; sharing them by matplotlib takes much longer.
    panels = figure.subplots(lines, columns, squeeze=False)
    for i, (panel, (eta, points)) in enumerate(zip(panels.flat, heights, strict=False)):
        _regime_map(panel, points)
        panel.set_title(rf"$\eta = {eta:g}$", fontsize=size)
        panel.locator_params(nbins=int(size) // 2 + 1)
        left, bottom = i % columns == 0, i + columns >= len(heights)
        panel.tick_params(labelsize=size, labelleft=left, labelbottom=bottom)
    for panel in panels.flat[len(heights) :]:
        panel.set_visible(False)
    figure.supxlabel(style.TAPER, fontsize=8)
    figure.supylabel(style.FRICTION, fontsize=8)
    patches = [
        Patch(facecolor=REGIME_COLORS(i), edgecolor=style.SURFACE, label=REGIMES[i])
        for i in sorted(rows["regime"].unique())
    ]
    # Below the panels, the legend would cover the label of the axis.
    figure.legend(handles=patches, loc="outside upper center", ncols=1 if columns == 1 else 4)
    return figure


def _regime_map(panel: Axes, points: pd.DataFrame) -> None:
    """Colour the points of one η by regime, and draw μ_lock over θ."""
    field = points.pivot(index="mu0", columns="theta", values="regime")
    thetas, mu0 = style.cells(field.columns), style.cells(field.index)
    look: Look = {"cmap": REGIME_COLORS, "vmin": 0, "vmax": len(REGIMES) - 1}
    panel.pcolormesh(thetas, mu0, field, rasterized=True, **look)
    curves = points.drop_duplicates("theta").sort_values("theta")
    panel.plot(curves["theta"], curves["mu_lock"], color="black", **style.alone(curves["mu_lock"]))
    panel.set_ylim(mu0[0], mu0[-1])


@kind("law", columns=(*POINT, "x0_slip", "mu_lock", "x0_lock"))
def law(rows: pd.DataFrame) -> Figure:
    """x0_slip over μ0, and x0_lock − x0_slip over μ_lock − μ0 beside power laws, for each θ."""
    rows = rows.assign(gap=rows["mu_lock"] - rows["mu0"], far=rows["x0_lock"] - rows["x0_slip"])
    every = rows[rows["status"] == "slip"]
    slips = every[(every["gap"] > 0.0) & np.isfinite(every["gap"])]
    if slips.empty:
        return style.message("no tip locks" if len(every) else "no point of the grid slips")
    figure = style.page(3.0, style.PAGE)
    panel, near = figure.subplots(1, 2)
    series = Series(every, "theta")
    dots: Look = {"marker": ".", "label": None, "rasterized": len(slips) > MANY}
    series.lines(panel, every, "mu0", "x0_slip", 1.5, **dots)
    series.lines(near, slips, "gap", "far", 1.5, **dots)
    series.lines(panel, slips.drop_duplicates("theta"), "mu_lock", "x0_lock", 3.5, marker="o")
    # Power laws through the farthest onset, for comparison with the series.
    ends = np.array([slips["gap"].min(), slips["gap"].max()])
    for power, (name, line) in POWERS.items():
        far = slips["far"].max() * (ends / ends[1]) ** power
        near.plot(ends, far, label=f"power {name}", linestyle=line, **THIN)
    panel.set(xlabel=style.FRICTION, ylabel=r"onset of slip $x_{0,\mathrm{slip}}$ / $L$")
    near.set(xscale="log", yscale="log", ylim=(0.5 * slips["far"].min(), None))
    near.set_xlabel(r"distance from the lock $\mu_\mathrm{lock} - \mu_0$")
    near.set_ylabel(r"$(x_{0,\mathrm{lock}} - x_{0,\mathrm{slip}})$ / $L$")
    # Within one decade, matplotlib's labels of minor ticks would overlap.
    near.xaxis.set_minor_locator(LogLocator(subs=(3,)))
    series.explain(near)
    return figure
