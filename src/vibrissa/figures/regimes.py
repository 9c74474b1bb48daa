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
from scipy.stats import t as student

from vibrissa.figures import style
from vibrissa.figures.kinds import POINT, kind
from vibrissa.figures.series import Series, told_apart
from vibrissa.figures.style import Look
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
# A law is fitted to so many points next to the lock that are no further from it than this part of
# mu_lock; to fewer than the least none is.
FITTED_POINTS, LEAST_POINTS, NEAR_LOCK = 16, 5, 0.1
# Dots of more points are pixels in PDF and SVG.
MANY = 300
# An exponent that is known no better is not shown.
MOST_UNCERTAIN = 0.1
# Maps side by side, and the height of one and the size of its type (inch, points), by how many
# there are at most.
PANELS = {6: (3, 2.0, 7.0), 20: (4, 1.6, 7.0), math.inf: (8, 0.95, 5.0)}


@kind("locking", columns=("theta", "eta", "status", "message", "mu_lock"))
def locking(rows: pd.DataFrame) -> Figure:
    """μ_lock over θ for each η."""
    # Infinite where the tip lifts off instead, and unknown where no lock was found.
    curves = rows.drop_duplicates(["theta", "eta"]).replace({"mu_lock": {np.inf: np.nan}})
    known = curves["mu_lock"].notna().groupby(curves["eta"]).transform("any")
    if not known.any():
        return style.message("no tip locks")
    figure, panel = style.axes(3.0)
    for eta in sorted(set(curves["eta"][~known])):
        style.mean(panel, rf"no lock: $\eta = {eta:g}$", linestyle="none")
    # Series of which nothing can be drawn would take the colours from the others.
    curves = curves[known].sort_values("theta")
    series = Series(curves["eta"], r"\eta")
    for eta, curve in curves.groupby("eta"):
        series.line(panel, eta, curve["theta"], curve["mu_lock"])
    panel.set_xlabel(style.TAPER)
    panel.set_ylabel(style.LOCKING_FRICTION)
    style.from_zero(panel)
    series.explain(panel)
    return figure


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
    figure = style.page(0.7 + height * lines, style.COLUMN if columns == 1 else style.PAGE)
    # All have the same axes, as a grid is a product; axes that matplotlib shares take much longer.
    panels = figure.subplots(lines, columns, squeeze=False)
    names = told_apart(list(heights.groups), 6)
    for i, (panel, (_, points)) in enumerate(zip(panels.flat, heights, strict=False)):
        _regime_map(panel, points)
        panel.set_title(rf"$\eta = {names[i]}$", fontsize=size)
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
    # Below, it would cover the label of the abscissae.
    figure.legend(handles=patches, loc="outside upper center", ncols=1 if columns == 1 else 4)
    return figure


def _regime_numbers(rows: pd.DataFrame) -> Sequence[int]:
    """Place in `REGIMES` of what happens at each point."""
    slips, locks = rows["contact"].map(SLIPS), rows["ends_by"].map(LOCKS)
    names = slips.where(rows["status"] == "slip", locks).fillna(NO_RESULT)
    return [REGIMES.index(name) for name in names]


def _regime_map(panel: Axes, points: pd.DataFrame) -> None:
    """Colour the points of one η by regime, and draw the locking friction."""
    field = points.pivot(index="mu0", columns="theta", values="regime")
    thetas, mu0 = style.cells(field.columns), style.cells(field.index)
    look: Look = {"cmap": REGIME_COLORS, "vmin": 0, "vmax": len(REGIMES) - 1}
    panel.pcolormesh(thetas, mu0, field, rasterized=True, **look)
    curves = points.drop_duplicates("theta").sort_values("theta")
    mu_lock = curves["mu_lock"].replace(np.inf, np.nan)
    panel.plot(curves["theta"], mu_lock, color="black", marker=style.alone(curves))
    panel.set_ylim(mu0[0], mu0[-1])


@kind("law", columns=(*POINT, "x0_slip", "mu_lock", "x0_lock"))
def law(rows: pd.DataFrame) -> Figure:
    """x0_slip over μ0 up to the lock for each θ, and the power law near it."""
    slips = rows[(rows["status"] == "slip") & np.isfinite(rows["mu_lock"])].sort_values("mu0")
    if slips.empty:
        return style.message("there is no onset of slip below a lock")
    figure = style.page(3.0, style.PAGE)
    panel, near = figure.subplots(1, 2)
    series = Series(slips["theta"], r"\theta")
    for _, points in slips.groupby("theta"):
        _approach_lock(panel, near, points, series)
    style.mean(panel, "fitted power law", color="black", linewidth=0.8)
    panel.set_xlabel(style.FRICTION)
    panel.set_ylabel(r"onset of slip $x_{0,\mathrm{slip}}$ / $L$")
    near.set(xscale="log", yscale="log")
    near.set_xlabel(r"distance from the lock $\mu_\mathrm{lock} - \mu_0$")
    near.set_ylabel(r"$(x_{0,\mathrm{lock}} - x_{0,\mathrm{slip}})$ / $L$")
    # Within a decade matplotlib would label each of the ticks between, one upon the other.
    near.xaxis.set_minor_locator(LogLocator(subs=(3,)))
    series.explain(near)
    return figure


@dataclass(frozen=True, kw_only=True)
class PowerLaw:
    """The law distance = scale·gap^exponent·(1 + √gap)^correction near the lock.

    The last factor stands for the next term of the expansion; without it the exponent would depend
    on how far from the lock the fitted points lie. The uncertainty of the exponent is half of its
    95 % interval, and how far it moves if only the nearer half of the points is fitted.
    """

    scale: float
    exponent: float
    correction: float
    uncertainty: float

    def __call__(self, gap: FloatArray) -> FloatArray:
        """Distance x0_lock − x0_slip (L) where μ0 is `gap` below the locking friction."""
        return self.scale * gap**self.exponent * (1.0 + np.sqrt(gap)) ** self.correction

    @property
    def label(self) -> str:
        """The exponent with its uncertainty."""
        digits = min(max(1 - math.floor(math.log10(self.uncertainty)), 1), 4)
        return rf"exponent ${self.exponent:.{digits}f} \pm {self.uncertainty:.{digits}f}$"


def _approach_lock(panel: Axes, near: Axes, points: pd.DataFrame, series: Series) -> None:
    """Draw the onsets of one θ up to the lock in `panel`, and their distance from it in `near`."""
    mu_lock, x0_lock = points["mu_lock"].iloc[0], points["x0_lock"].iloc[0]
    theta = points["theta"].iloc[0]
    color, label = series.color(theta), series.label(theta)
    gap = (mu_lock - points["mu0"]).to_numpy()
    distance = (x0_lock - points["x0_slip"]).to_numpy()
    dots: Look = {"markersize": 1.5, "color": color, "rasterized": len(gap) > MANY}
    panel.plot(points["mu0"], points["x0_slip"], ".", **dots)
    panel.plot(mu_lock, x0_lock, "o", markersize=series.marker_size(3.5), color=color)
    near.plot(gap, distance, ".", **dots)
    if fitted := fitted_law(gap, distance, mu_lock):
        line = np.geomspace(gap[gap > 0.0].min(), NEAR_LOCK * mu_lock, 50)
        panel.plot(mu_lock - line, x0_lock - fitted(line), color="black", linewidth=0.8)
        near.plot(line, fitted(line), color="black", linewidth=0.5)
        label = f"{label}, {fitted.label}" if label else None
    style.mean(near, label or "_", marker="o", color=color, linestyle="none")


def fitted_law(gap: FloatArray, distance: FloatArray, mu_lock: float) -> PowerLaw | None:
    """Fit the law to the points nearest to the lock, by least squares of the logarithms.

    Parameters
    ----------
    gap, distance : ndarray, shape (n,)
        Distance of μ0 from the lock, and of the onset from that at the lock (L).
    mu_lock : float

    Returns
    -------
    PowerLaw or None
        None if too few points are near, or they leave the exponent open.
    """
    nearest = np.argsort(gap)
    usable = (gap > 0.0) & (gap < NEAR_LOCK * mu_lock) & (distance > 0.0)
    kept = nearest[usable[nearest]][:FITTED_POINTS]
    if len(kept) < LEAST_POINTS:
        return None
    found, scatter = _least_squares(gap[kept], distance[kept])
    half = kept[: max(LEAST_POINTS, len(kept) // 2)]
    nearer, _ = _least_squares(gap[half], distance[half])
    # What the next terms of the expansion change shows where fewer points are fitted. Rounding
    # gives a law that fits exactly an uncertainty, too.
    uncertainty = scatter + abs(found[1] - nearer[1]) + 1e-9
    if uncertainty > MOST_UNCERTAIN:
        return None
    return PowerLaw(
        scale=float(np.exp(found[0])),
        exponent=float(found[1]),
        correction=float(found[2]),
        uncertainty=uncertainty,
    )


def _least_squares(gap: FloatArray, distance: FloatArray) -> tuple[FloatArray, float]:
    """Fit the logarithm of the law; return it and half the exponent's 95 % interval."""
    terms = np.stack([np.ones_like(gap), np.log(gap), np.log1p(np.sqrt(gap))], axis=-1)
    found, *_ = np.linalg.lstsq(terms, np.log(distance), rcond=None)
    free = len(gap) - len(found)
    variance = np.sum((np.log(distance) - terms @ found) ** 2) / free
    # The pseudo-inverse is of terms that many orders of magnitude part.
    deviation = np.sqrt(variance * np.linalg.pinv(terms.T @ terms)[1, 1])
    return found, float(student.ppf(0.975, free) * deviation)
