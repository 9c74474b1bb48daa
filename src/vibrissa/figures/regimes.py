"""Figures of where a tip slips and where it locks."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator

from vibrissa.figures import style
from vibrissa.figures.kinds import POINT, kind
from vibrissa.figures.series import Series, told_apart
from vibrissa.numerics.arrays import FloatArray

SLIPS = {"point": "slips in point contact", "line": "slips in line contact"}
LOCKS = {
    "slips_back": "locks, then slips back",
    "snaps": "locks, then snaps through",
    "out_of_reach": "locks, then out of reach",
    "not_followed": "locks, not followed further",
    "swings_aside": "locks, then swings aside",
}
NO_RESULT = "no result"
REGIMES = (*SLIPS.values(), *LOCKS.values(), NO_RESULT)
REGIME_COLORS = ListedColormap(
    ["#0072b2", "#009e73", "#d55e00", "#e69f00", "#cc79a7", "#f0e442", "#56b4e9", "#ffffff"]
)
# Points next to the lock to which its law is fitted, and how far it is drawn, relative to mu_lock.
FITTED_POINTS = 16
NEAR_LOCK = 0.1
# Heights without a lock that are named; of more the ends.
NAMED = 5
# Maps side by side, and the height of one and the size of its type (inch, points), by how many
# there are at most.
PANELS = {6: (2, 2.6, 10.0), 20: (4, 1.6, 8.0), math.inf: (8, 0.9, 6.0)}


@kind("locking", columns=("theta", "eta", "status", "message", "mu_lock"))
def locking(rows: pd.DataFrame) -> Figure:
    """μ_lock over θ for each η."""
    # Infinite where the tip lifts off instead, and unknown where no lock was found.
    curves = rows.drop_duplicates(["theta", "eta"]).replace({"mu_lock": {np.inf: np.nan}})
    known = curves["mu_lock"].notna().groupby(curves["eta"]).transform("any")
    if not known.any():
        return style.message("no tip locks")
    figure, axes = style.axes(4.2)
    # Series of which nothing can be drawn would take the colours from the others.
    if never := sorted(set(curves["eta"][~known])):
        axes.set_title(rf"without a lock: {_few(never)}")
    curves = curves[known].sort_values("theta")
    series = Series(curves["eta"], r"\eta")
    for eta, curve in curves.groupby("eta"):
        axes.plot(
            curve["theta"],
            curve["mu_lock"],
            color=series.color(eta),
            linewidth=1.2,
            marker=style.alone(curve),
            label=series.label(eta),
        )
    axes.set_xlabel(style.TAPER)
    axes.set_ylabel(style.LOCKING_FRICTION)
    style.from_zero(axes)
    axes.margins(x=0.03)
    if series.few:
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    series.colorbar(axes)
    return figure


def _few(heights: Sequence[float]) -> str:
    """Name heights, or the least and the largest of many."""
    if len(heights) > NAMED:
        return rf"{len(heights)} values of $\eta$ from {heights[0]:.4g} to {heights[-1]:.4g}"
    return rf"$\eta$ = {', '.join(f'{eta:.4g}' for eta in heights)}"


@kind("regimes", columns=(*POINT, "contact", "ends_by", "mu_lock"))
def regimes(rows: pd.DataFrame) -> Figure:
    """Map over θ and μ0, a panel for each η: slips in point or in line contact, or locks."""
    # One step size stands for all: the regime does not depend on it.
    rows = rows.drop_duplicates(["theta", "mu0", "eta"])
    rows = rows.assign(regime=_regime_numbers(rows))
    heights = rows.groupby("eta")
    columns, height, size = next(PANELS[most] for most in PANELS if len(heights) <= most)
    columns = min(columns, len(heights))
    lines = -(-len(heights) // columns)
    figure = style.page(0.6 + height * lines)
    # All have the same axes, as a grid is a product; axes that matplotlib shares take much longer.
    panels = figure.subplots(lines, columns, squeeze=False)
    names = told_apart(list(heights.groups), 6)
    for i, (axes, (_, points)) in enumerate(zip(panels.flat, heights, strict=False)):
        _regime_map(axes, points)
        axes.set_title(rf"$\eta = {names[i]}$", fontsize=size)
        axes.locator_params(nbins=int(size) // 2)
        axes.tick_params(
            labelsize=size, labelleft=i % columns == 0, labelbottom=i + columns >= len(heights)
        )
    for axes in panels.flat[len(heights) :]:
        axes.set_visible(False)
    figure.supxlabel(style.TAPER, fontsize=10)
    figure.supylabel(style.FRICTION, fontsize=10)
    patches = [
        Patch(facecolor=REGIME_COLORS(i), edgecolor=style.SURFACE, label=REGIMES[i])
        for i in sorted(rows["regime"].unique())
    ]
    figure.legend(handles=patches, loc="outside upper center", ncols=2, fontsize=9)
    return figure


def _regime_numbers(rows: pd.DataFrame) -> Sequence[int]:
    """Place in `REGIMES` of what happens at each point."""
    slips, locks = rows["contact"].map(SLIPS), rows["ends_by"].map(LOCKS)
    names = slips.where(rows["status"] == "slip", locks).fillna(NO_RESULT)
    return [REGIMES.index(name) for name in names]


def _regime_map(axes: Axes, points: pd.DataFrame) -> None:
    """Colour the points of one η by regime, and draw the locking friction."""
    field = points.pivot(index="mu0", columns="theta", values="regime")
    thetas, mu0 = style.cells(field.columns), style.cells(field.index)
    axes.pcolormesh(thetas, mu0, field, cmap=REGIME_COLORS, vmin=0, vmax=len(REGIMES) - 1)
    curves = points.drop_duplicates("theta").sort_values("theta")
    axes.plot(
        curves["theta"],
        curves["mu_lock"].replace(np.inf, np.nan),
        color="black",
        linewidth=1.0,
        marker=style.alone(curves),
    )
    axes.set_ylim(mu0[0], mu0[-1])


@kind("law", columns=(*POINT, "x0_slip", "mu_lock", "x0_lock"))
def law(rows: pd.DataFrame) -> Figure:
    """x0_slip over μ0 up to the lock for each θ, and the power law near it."""
    slips = rows[(rows["status"] == "slip") & np.isfinite(rows["mu_lock"])].sort_values("mu0")
    if slips.empty:
        return style.message("there is no onset of slip below a lock")
    figure = style.page(3.6)
    axes, near = figure.subplots(1, 2)
    series = Series(slips["theta"], r"\theta")
    laws = {
        theta: _approach_lock(axes, near, points, series)
        for theta, points in slips.groupby("theta")
    }
    near.plot([], [], color="black", linewidth=0.8, label="black: fitted power law")
    axes.set_xlabel(style.FRICTION)
    axes.set_ylabel(r"onset of slip $x_{0,\mathrm{slip}}$ / $L$")
    axes.set_title(rf"$\eta = {rows['eta'].iloc[0]:g}$")
    near.set_xlabel(r"$\mu_\mathrm{lock} - \mu_0$")
    near.set_ylabel(r"$x_{0,\mathrm{lock}} - x_{0,\mathrm{slip}}$")
    near.set_title("distance from the critical state")
    # Within a decade matplotlib would label each of the ticks between, one upon the other.
    near.xaxis.set_minor_locator(LogLocator(subs=(3,)))
    series.explain(near, below=True)
    if not series.few:
        _exponents(near, {theta: law.exponent for theta, law in laws.items()}, series)
    return figure


@dataclass(frozen=True, kw_only=True)
class PowerLaw:
    """The law distance = scale·gap^exponent·(1 + √gap)^correction near the lock.

    The last factor stands for the next term of the expansion; without it the exponent would depend
    on how far from the lock the fitted points lie.
    """

    scale: float
    exponent: float
    correction: float

    def __call__(self, gap: FloatArray) -> FloatArray:
        """Distance x0_lock − x0_slip (L) where μ0 is `gap` below the locking friction."""
        return self.scale * gap**self.exponent * (1.0 + np.sqrt(gap)) ** self.correction


def _exponents(near: Axes, exponents: dict[float, float], series: Series) -> None:
    """Show the exponents of many laws over θ, in an inset where the laws leave room."""
    inset = near.inset_axes((0.14, 0.66, 0.4, 0.22))
    colors = [series.color(theta) for theta in exponents]
    inset.scatter(list(exponents), list(exponents.values()), s=4, c=colors)
    inset.set_title(r"exponent over $\theta$", fontsize=8)
    inset.set_ylim(bottom=0.0)
    inset.tick_params(labelsize=7)


def _approach_lock(axes: Axes, near: Axes, points: pd.DataFrame, series: Series) -> PowerLaw:
    """Draw the onsets of one θ up to the lock in `axes`, and their distance from it in `near`."""
    mu_lock, x0_lock = points["mu_lock"].iloc[0], points["x0_lock"].iloc[0]
    theta = points["theta"].iloc[0]
    color, label = series.color(theta), series.label(theta)
    gap = (mu_lock - points["mu0"]).to_numpy()
    distance = (x0_lock - points["x0_slip"]).to_numpy()
    fitted = _fitted_law(gap, distance)
    axes.plot(points["mu0"], points["x0_slip"], ".", markersize=2, color=color, label=label)
    axes.plot(mu_lock, x0_lock, "o", markersize=series.marker_size(6), color=color)
    close = gap[gap < NEAR_LOCK * mu_lock]
    axes.plot(mu_lock - close, x0_lock - fitted(close), color="black", linewidth=0.8)
    near.loglog(gap, distance, ".", markersize=3, color=color)
    line = np.geomspace(gap.min(), NEAR_LOCK * mu_lock, 50)
    exponent = f"{label}: exponent {fitted.exponent:.3f}" if label else None
    near.loglog(line, fitted(line), color=color, linewidth=0.8, label=exponent)
    return fitted


def _fitted_law(gap: FloatArray, distance: FloatArray) -> PowerLaw:
    """Fit the law to the points nearest to the lock, by least squares of the logarithms."""
    nearest = np.argsort(gap)[:FITTED_POINTS]
    known = nearest[(gap[nearest] > 0.0) & (distance[nearest] > 0.0)]
    gap, distance = gap[known], distance[known]
    terms = np.stack([np.ones_like(gap), np.log(gap), np.log1p(np.sqrt(gap))], axis=-1)
    (constant, exponent, correction), *_ = np.linalg.lstsq(terms, np.log(distance), rcond=None)
    return PowerLaw(scale=np.exp(constant), exponent=exponent, correction=correction)
