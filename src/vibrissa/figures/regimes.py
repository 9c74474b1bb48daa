"""Figures of where a tip slips and where it locks."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from vibrissa.figures import style
from vibrissa.figures.kinds import POINT, kind
from vibrissa.figures.style import COLORS
from vibrissa.numerics.arrays import FloatArray

SLIPS = {"point": "slips in point contact", "line": "slips in line contact"}
LOCKS = {
    "slips_back": "locks, then slips back",
    "snaps": "locks, then snaps through",
    "out_of_reach": "locks, then out of reach",
    "not_followed": "locks, not followed further",
}
NO_RESULT = "no result"
REGIMES = (*SLIPS.values(), *LOCKS.values(), NO_RESULT)
REGIME_COLORS = ListedColormap(
    ["#0072b2", "#009e73", "#d55e00", "#e69f00", "#cc79a7", "#f0e442", "#ffffff"]
)
# Points next to the lock to which its law is fitted, and how far it is drawn, relative to mu_lock.
FITTED_POINTS = 16
NEAR_LOCK = 0.1


@kind("locking", columns=("theta", "eta", "status", "message", "mu_lock"))
def locking(rows: pd.DataFrame) -> Figure:
    """μ_lock over θ for each η."""
    figure, axes = style.axes(4.2)
    curves = rows.drop_duplicates(["theta", "eta"]).sort_values("theta").groupby("eta")
    for (eta, series), color in zip(curves, cycle(COLORS), strict=False):
        # Infinite where the tip lifts off instead: no point to draw.
        mu_lock = series["mu_lock"].replace(np.inf, np.nan)
        axes.plot(series["theta"], mu_lock, color=color, linewidth=1.2, label=rf"$\eta = {eta:g}$")
    axes.set_xlabel(style.TAPER)
    axes.set_ylabel(style.LOCKING_FRICTION)
    axes.set_ylim(bottom=0)
    axes.margins(x=0.03)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


@kind("regimes", columns=(*POINT, "contact", "ends_by", "mu_lock"))
def regimes(rows: pd.DataFrame) -> Figure:
    """Map over θ and μ0, a panel for each η: slips in point or in line contact, or locks."""
    # One step size stands for all: the regime does not depend on it.
    rows = rows.drop_duplicates(["theta", "mu0", "eta"])
    rows = rows.assign(regime=_regime_numbers(rows))
    heights = rows.groupby("eta")
    figure = style.page(0.6 + 2.6 * len(heights) / 2)
    panels = figure.subplots(-(-len(heights) // 2), 2, sharex=True, sharey=True, squeeze=False)
    for axes, (eta, points) in zip(panels.flat, heights, strict=False):
        _regime_map(axes, points)
        axes.set_title(rf"$\eta = {eta:g}$")
    for axes in panels.flat[len(heights) :]:
        axes.set_visible(False)
    for axes in panels[-1]:
        axes.set_xlabel(style.TAPER)
    for axes in panels[:, 0]:
        axes.set_ylabel(style.FRICTION)
    patches = [
        Patch(facecolor=REGIME_COLORS(i), edgecolor=style.SURFACE, label=REGIMES[i])
        for i in sorted(rows["regime"].unique())
    ]
    figure.legend(handles=patches, loc="outside lower center", ncols=2, fontsize=9)
    return figure


def _regime_numbers(rows: pd.DataFrame) -> Sequence[int]:
    """Place in `REGIMES` of what happens at each point."""
    slips, locks = rows["contact"].map(SLIPS), rows["ends_by"].map(LOCKS)
    names = slips.where(rows["status"] == "slip", locks).fillna(NO_RESULT)
    return [REGIMES.index(name) for name in names]


def _regime_map(axes: Axes, points: pd.DataFrame) -> None:
    """Colour the points of one η by regime, and draw the locking friction."""
    field = points.pivot(index="mu0", columns="theta", values="regime")
    axes.pcolormesh(
        field.columns,
        field.index,
        field,
        cmap=REGIME_COLORS,
        vmin=0,
        vmax=len(REGIMES) - 1,
        shading="nearest",
    )
    curves = points.drop_duplicates("theta").sort_values("theta")
    axes.plot(curves["theta"], curves["mu_lock"], color="black", linewidth=1.0)
    axes.set_ylim(field.index.min(), field.index.max())


@kind("law", columns=(*POINT, "x0_slip", "mu_lock", "x0_lock"))
def law(rows: pd.DataFrame) -> Figure:
    """x0_slip over μ0 up to the lock for each θ, and the power law near it."""
    figure = style.page(3.6)
    axes, near = figure.subplots(1, 2)
    slips = rows[rows["status"] == "slip"].sort_values("mu0")
    for (_, points), color in zip(slips.groupby("theta"), cycle(COLORS), strict=False):
        _approach_lock(axes, near, points, color)
    axes.plot([], [], color="black", linewidth=0.8, label="fitted power law")
    axes.set_xlabel(style.FRICTION)
    axes.set_ylabel(r"onset of slip $x_{0,\mathrm{slip}}$ / $L$")
    axes.set_title(rf"$\eta = {rows['eta'].iloc[0]:g}$")
    axes.legend(fontsize=8)
    near.set_xlabel(r"$\mu_\mathrm{lock} - \mu_0$")
    near.set_ylabel(r"$x_{0,\mathrm{lock}} - x_{0,\mathrm{slip}}$")
    near.set_title("distance from the critical state")
    near.legend(fontsize=8, loc="upper left")
    return figure


def _approach_lock(axes: Axes, near: Axes, points: pd.DataFrame, color: str) -> None:
    """Draw the onsets of one θ up to the lock in `axes`, and their distance from it in `near`."""
    mu_lock, x0_lock = points["mu_lock"].iloc[0], points["x0_lock"].iloc[0]
    gap = (mu_lock - points["mu0"]).to_numpy()
    distance = (x0_lock - points["x0_slip"]).to_numpy()
    fitted = _fitted_law(gap, distance)
    label = rf"$\theta = {points['theta'].iloc[0]:g}$"
    axes.plot(points["mu0"], points["x0_slip"], ".", markersize=2, color=color, label=label)
    axes.plot(mu_lock, x0_lock, "o", color=color)
    close = gap[gap < NEAR_LOCK * mu_lock]
    axes.plot(mu_lock - close, x0_lock - fitted(close), color="black", linewidth=0.8)
    near.loglog(gap, distance, ".", markersize=3, color=color)
    line = np.geomspace(gap.min(), NEAR_LOCK * mu_lock, 50)
    exponent = f"{label}: exponent {fitted.exponent:.3f}"
    near.loglog(line, fitted(line), color=color, linewidth=0.8, label=exponent)


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


def _fitted_law(gap: FloatArray, distance: FloatArray) -> PowerLaw:
    """Fit the law to the points nearest to the lock, by least squares of the logarithms."""
    nearest = np.argsort(gap)[:FITTED_POINTS]
    known = nearest[(gap[nearest] > 0.0) & (distance[nearest] > 0.0)]
    gap, distance = gap[known], distance[known]
    terms = np.stack([np.ones_like(gap), np.log(gap), np.log1p(np.sqrt(gap))], axis=-1)
    (constant, exponent, correction), *_ = np.linalg.lstsq(terms, np.log(distance), rcond=None)
    return PowerLaw(scale=np.exp(constant), exponent=exponent, correction=correction)
