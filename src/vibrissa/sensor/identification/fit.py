"""One fit of set-up and contact points to all recorded channels, with tolerances as priors.

The parameters p minimise χ²(p) + Σ (p/σ)², where σ are the tolerances. For each p every period has
its best u(p), where u is x0 in the last sample of the period (variable projection: Golub and
Pereyra, 1973). The errors of p that remain have the covariance C = (JᵀJ + 1/σ²)⁻¹ with
J = ∂(residuals)/∂p, by Bayes' theorem for normal errors.

On an uneven surface each tip has a height of its own, with the variance a that the tolerance of the
slope allows. With the derivative g of a period's residuals r by this height, r has the covariance
1 + a·ggᵀ. Residuals and J are multiplied by its inverse root, so that a height that differs from
place to place is not explained by p.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.optimize import lsq_linear
from scipy.special import chdtrc

from vibrissa.errors import NoResponseError
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.sensor.identification.forward import SetUp, set_ups
from vibrissa.sensor.identification.task import Task
from vibrissa.sensor.whisker import Whisker

# Number of Gauss-Newton steps by which u is fitted: at first, and from a similar set-up.
FIRST_STEPS, STEPS = 8, 3
# Relative fall of the sum at which the fit ends; largest numbers of steps, and of halvings of one.
SETTLED, MOST_STEPS, HALVINGS = 1e-5, 20, 6
# Least inverse variance.
TINY = 1e-300
# A period does not fit by itself if its residuals have a lower probability than UNLIKELY. If less
# than the part MOST_ALONE of the periods does not fit, these are left out of the fit.
UNLIKELY, MOST_ALONE = 1e-9, 0.5

# Largest number of tips whose heights are compared.
MOST_HEIGHTS = 500


class Unevenness(NamedTuple):
    """Test of the heights of the surface against the tolerance of its slope.

    Attributes
    ----------
    chi2 : float
        χ² of the heights, for the allowed slope.
    number : int
        Number of heights.
    chance : float
        Probability of heights that rise and fall as much, or more, if the slope is as allowed.
    """

    chi2: float
    number: int
    chance: float


def unevenness_of(height: FloatArray, surface: FloatArray, error: FloatArray) -> Unevenness:
    """Test n heights h, with the covariance K due to the surface, and V due to errors.

    With W = K + V the locally most powerful test of a larger K is that of hᵀ·W⁻¹·K·W⁻¹·h. It is a
    sum of squares of normal numbers with weights, whose distribution is taken as that of a multiple
    of χ² with the same mean and variance (Satterthwaite, 1946). Heights that scatter from place to
    place are found by χ² of h for the covariance W. The smaller of both chances counts, twice.

    Parameters
    ----------
    height : ndarray, shape (n,)
    surface : ndarray, shape (n, n)
        K (L²).
    error : ndarray, shape (n, n)
        V (L²).
    """
    if not surface.any():
        # A single height, or exact ones, tell nothing of an uneven surface.
        return Unevenness(chi2=0.0, number=len(height), chance=1.0)
    root = np.linalg.cholesky(surface + error)
    scaled = np.linalg.solve(root, height)
    part = np.linalg.solve(root, np.linalg.solve(root, surface).T)
    mean, square = float(np.trace(part)), float((part**2).sum())
    rise = float(scaled @ part @ scaled)
    smooth = float(chdtrc(mean**2 / square, rise * mean / square))
    rough = float(chdtrc(len(height), scaled @ scaled))
    chance = min(1.0, 2.0 * min(smooth, rough))
    return Unevenness(chi2=float(scaled @ scaled), number=len(height), chance=chance)


class Changes(NamedTuple):
    """Derivatives of readings, u and μ0 with respect to k parameters of the set-up.

    The readings are those of n blocks in c channels; u is x0 in the last sample of each of p
    periods.

    Attributes
    ----------
    readings : ndarray, shape (k, n, c)
        Derivatives of the readings, divided by the standard deviations of the readings. u is
        fitted anew for each change of a parameter.
    u : ndarray, shape (p, k)
        Derivatives of the fitted u.
    friction : ndarray, shape (p, k)
        Derivatives of μ0 at constant u.
    """

    readings: FloatArray
    u: FloatArray
    friction: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Fit:
    """Fit of a set-up, and of x0 in each period's last sample, to the readings of a recording.

    Attributes
    ----------
    u : ndarray, shape (p,)
        x0 in the last sample of each period (L).
    kept : ndarray of bool, shape (p,)
        Periods to which the set-up was fitted.
    settled : bool
        Whether the fit has converged; otherwise the set-up is as given.
    """

    set_up: SetUp
    u: FloatArray
    kept: BoolArray
    settled: bool = True

    @property
    def task(self) -> Task:
        """Recording, noise and tolerances."""
        return self.set_up.task

    @property
    def p(self) -> FloatArray:
        """Deviations of the k parameters from the given set-up, shape (k,)."""
        return self.set_up.p

    def _weighted(self, values: FloatArray, slope: FloatArray) -> FloatArray:
        """Divide values (..., n, 3) of n blocks by the noise; return c channels, (..., n, c)."""
        position = self.task.recording.position
        scaled = self.task.weighted(values) * np.sqrt(self.task.blocks.count)[:, None]
        if not position:
            return scaled
        # Noise of the clamp position acts as noise of the readings in the direction of their slope.
        along = self.task.weighted(slope)
        square = np.maximum((along**2).sum(axis=1), TINY)
        less = (1.0 / np.sqrt(1.0 + position**2 * square) - 1.0) / square
        part = (scaled * along).sum(axis=-1) * less
        return np.asarray(scaled + part[..., None] * along)

    @cached_property
    def _slope(self) -> FloatArray:
        """Derivatives of the loads with respect to x0, shape (n, 3)."""
        return self.set_up.loads(*self.set_up.states(self.u), order=1)

    @cached_property
    def slope(self) -> FloatArray:
        """Derivatives of the readings with respect to x0, in standard deviations, shape (n, c)."""
        return self._weighted(self._slope, self._slope)

    @cached_property
    def residuals(self) -> FloatArray:
        """Residuals of the readings, in their standard deviations, shape (n, c)."""
        loads = self.set_up.loads(*self.set_up.states(self.u))
        miss = self.task.blocks.readings - self.set_up.readings(loads)
        return self._weighted(miss, self._slope)

    @cached_property
    def known(self) -> FloatArray:
        """Inverse variance of x0 in each period's last sample, for a known set-up, shape (p,)."""
        return np.maximum(self.task.blocks.sums((self.slope**2).sum(axis=1)), TINY)

    def contacts(self, steps: int) -> "Fit":
        """Fit x0 in the last sample of each period, for this set-up, by Gauss-Newton steps."""
        fit = self
        for _ in range(steps):
            step = fit.task.blocks.sums((fit.residuals * fit.slope).sum(axis=1)) / fit.known
            fit = replace(fit, u=fit.u + step)
        return fit

    @cached_property
    def by_setup(self) -> Changes:
        """Derivatives of readings, `u` and μ0 with respect to each parameter; see `Changes`."""
        blocks, slope = self.task.blocks, self.slope
        readings, friction = self.set_up.changes(self.u)
        found = self._weighted(readings, self._slope)
        moves = -np.stack([blocks.sums((one * slope).sum(axis=1)) for one in found], axis=1)
        moves /= self.known[:, None]
        for one, moved in zip(found, moves.T, strict=True):
            one += slope * moved[blocks.period][:, None]
        return Changes(readings=found, u=moves, friction=friction.T)

    @cached_property
    def rows(self) -> BoolArray:
        """Whether each block belongs to a period to which the set-up is fitted, shape (n,)."""
        return self.kept[self.task.blocks.period]

    @cached_property
    def sigma(self) -> FloatArray:
        """Tolerances of the parameters, shape (k,); 0 if exact."""
        return np.array([one.deviation for one in self.task.parameters])

    @cached_property
    def free(self) -> BoolArray:
        """Whether each parameter is fitted (true) or exact (false), shape (k,)."""
        return self.sigma > 0.0

    @property
    def scores(self) -> FloatArray:
        """Deviations p of the f fitted parameters, over their tolerances σ, shape (f,)."""
        return np.asarray(self.p[self.free] / self.sigma[self.free])

    @property
    def by_height(self) -> FloatArray:
        """Derivatives of the readings by the height of the tip; see `Changes.readings`, (n, c)."""
        return np.asarray(self.by_setup.readings[self.task.number["eta"]])

    @cached_property
    def allowed(self) -> float:
        """Variance of the height of a tip that the tolerance of the slope allows (L²)."""
        return float(self.task.slope.rise(np.ptp(self.task.ends.clamp)))

    def levelled(self, values: FloatArray) -> FloatArray:
        """Multiply values (n, c) of the blocks by the inverse root of 1 + a·ggᵀ; see this module.

        On a plane surface these are the values.
        """
        if not self.task.slope.deviation:
            return values
        blocks, along = self.task.blocks, self.by_height
        square = np.maximum(blocks.sums((along**2).sum(axis=1)), TINY)
        less = (1.0 / np.sqrt(1.0 + self.allowed * square) - 1.0) / square
        part = blocks.sums((along * values).sum(axis=1)) * less
        return np.asarray(values + along * part[blocks.period][:, None])

    @cached_property
    def misses(self) -> FloatArray:
        """The `residuals` that the height of no tip explains, `levelled`, shape (n, c)."""
        return self.levelled(self.residuals)

    @property
    def changes(self) -> FloatArray:
        """Derivatives of the readings by each parameter, `levelled`, shape (k, n, c)."""
        return np.stack([self.levelled(one) for one in self.by_setup.readings])

    @cached_property
    def jacobian(self) -> FloatArray:
        """Jᵀ: derivatives of m `misses` of fitted periods with respect to p/σ, shape (f, m)."""
        size, sigma = int(self.free.sum()), self.sigma[self.free]
        return -self.changes[self.free][:, self.rows].reshape(size, -1) * sigma[:, None]

    @cached_property
    def normal(self) -> FloatArray:
        """JᵀJ + 1: half the Gauss-Newton Hessian of `total` as a function of p/σ, shape (f, f)."""
        return np.asarray(self.jacobian @ self.jacobian.T + np.eye(len(self.jacobian)))

    @property
    def remaining(self) -> FloatArray:
        """Covariance of the errors of p/σ that remain after the fit, shape (f, f)."""
        if not (self.settled and self.free.any()):
            return np.eye(int(self.free.sum()))
        return np.asarray(np.linalg.inv(self.normal))

    @property
    def covariance(self) -> FloatArray:
        """Covariance of the errors of p that remain after the fit, shape (f, f)."""
        sigma = self.sigma[self.free]
        return np.asarray(self.remaining * np.outer(sigma, sigma))

    @property
    def total(self) -> float:
        """The minimised sum: χ² of the fitted periods plus Σ (p/σ)²."""
        return float((self.misses[self.rows] ** 2).sum() + (self.scores**2).sum())

    @property
    def degrees(self) -> int:
        """Degrees of freedom of the `misfits` of the fitted periods."""
        return int(self.rows.sum()) * len(self.task.used) - self.per_period * int(self.kept.sum())

    @property
    def per_period(self) -> int:
        """Number of quantities fitted in each period: the contact point, and its height if told."""
        return 2 if self.task.slope.deviation else 1

    @cached_property
    def squares(self) -> FloatArray:
        """Sum of the squared residuals of each period, shape (p,)."""
        return self.task.blocks.sums((self.residuals**2).sum(axis=1))

    @cached_property
    def heights_of_tips(self) -> tuple[FloatArray, FloatArray]:
        """Estimated height of the surface at each contact point (L); variance of the estimate.

        The height is counted from the plane surface of the set-up. Both have the shape (p,).
        """
        blocks, change = self.task.blocks, self.by_height
        known = np.maximum(blocks.sums((change**2).sum(axis=1)), 1.0)
        return blocks.sums((change * self.residuals).sum(axis=1)) / known, 1.0 / known

    @cached_property
    def moves_of_heights(self) -> FloatArray:
        """Derivatives of the estimated heights with respect to each parameter, shape (p, k)."""
        _, variance = self.heights_of_tips
        sums, along = self.task.blocks.sums, self.by_height
        each = [sums((one * along).sum(axis=1)) for one in self.by_setup.readings]
        return np.asarray(-np.stack(each, axis=1) * variance[:, None])

    @cached_property
    def misfits(self) -> FloatArray:
        """`squares`, less what the height of the surface in each period explains, shape (p,)."""
        if not self.task.slope.deviation:
            return self.squares
        height, variance = self.heights_of_tips
        return np.asarray(self.squares - height**2 / variance)

    @cached_property
    def unevenness(self) -> Unevenness:
        """Test the surface's heights at the contact points of fitted periods.

        If there are more than `MOST_HEIGHTS`, evenly spaced ones are selected.
        """
        if not self.task.slope.deviation:
            return Unevenness(chi2=0.0, number=0, chance=1.0)
        kept = np.flatnonzero(self.kept)
        some = kept[:: -(-len(kept) // MOST_HEIGHTS)]
        height, variance = (one[some] for one in self.heights_of_tips)
        # The set-up moves all heights together.
        moves = self.moves_of_heights[some][:, self.free]
        error = np.diag(variance) + moves @ self.covariance @ moves.T
        return unevenness_of(height, self.task.slope.heights(self.task.ends.clamp[some]), error)

    @property
    def misfit(self) -> float:
        """Sum of `misfits` of the fitted periods, χ² of the surface's heights, and Σ (p/σ)²."""
        heights = self.unevenness.chi2
        return float(self.misfits[self.kept].sum() + heights + (self.scores**2).sum())

    @cached_property
    def fits_alone(self) -> BoolArray:
        """Whether the readings of each period fit a tip that sticks at one place, shape (p,)."""
        blocks = np.bincount(self.task.blocks.period)
        degrees = len(self.task.used) * blocks - self.per_period
        chance = chdtrc(np.maximum(degrees, 1), self.misfits)
        return np.asarray(chance >= UNLIKELY)


def started(task: Task, given: Whisker, nearest: FloatArray) -> Fit:
    """Start the fit at the given set-up, with x0 from the states nearest to the readings."""
    (set_up,) = set_ups(task, given, np.zeros(len(task.parameters)))
    periods = len(task.spans)
    # With u = 0 the x0 of a block is its difference from the x0 of the last sample.
    _, before = set_up.states(np.zeros(periods))
    apart = np.split(nearest - before, task.blocks.starts[1:])
    u = np.array([np.median(of_one) for of_one in apart])
    return Fit(set_up=set_up, u=u, kept=np.ones(periods, dtype=bool)).contacts(FIRST_STEPS)


def fitted(start: Fit) -> Fit:
    """Fit the set-up; leave out periods that do not fit by themselves, if fewer than half."""
    found = searched(start)
    alone = ~found.fits_alone
    if not alone.any() or alone.mean() >= MOST_ALONE:
        return found
    return searched(replace(start, kept=~alone))


def searched(start: Fit) -> Fit:
    """Fit the set-up by Gauss-Newton steps; return the given set-up if they do not converge."""
    best, settled = start, not start.free.any()
    for _ in range(MOST_STEPS):
        better = None if settled else _better(best)
        if better is None:
            break
        settled = best.total - better.total < SETTLED * best.total
        best = better
    return replace(best if settled else start, settled=settled)


def _better(fit: Fit) -> Fit | None:
    """Take a Gauss-Newton step within the bounds, or a part of it, that does not raise `total`.

    Return None if there is no such step. (`scipy.optimize.least_squares` zigzags along bounds such
    as c ≥ 0.)
    """
    low, high = _bounds(fit)
    try:
        root = np.linalg.cholesky(fit.normal).T
        slope = fit.jacobian @ fit.misses[fit.rows].ravel() + fit.scores
        aim, within = -np.linalg.solve(root.T, slope), (low - fit.scores, high - fit.scores)
        step = lsq_linear(root, aim, within, method="bvls").x
    except NoResponseError:
        return None
    for part in 0.5 ** np.arange(HALVINGS):
        p = fit.p.copy()
        p[fit.free] = fit.sigma[fit.free] * np.clip(fit.scores + part * step, low, high)
        try:
            (set_up,) = set_ups(fit.task, fit.set_up.given, p)
            other = replace(fit, set_up=set_up).contacts(STEPS)
            if other.total <= fit.total * (1.0 + SETTLED):
                return other
        except NoResponseError:
            continue
    return None


def _bounds(fit: Fit) -> FloatArray:
    """Least and largest allowed p/σ, shape (2, f)."""
    low, high = np.array([(one.low, one.high) for one in fit.task.parameters]).T
    if fit.set_up.heights.x0_touch <= fit.u.max():
        # A rod that is curved towards the surface arches over it before its tip is level.
        curvature, given = fit.task.number["curvature"], fit.set_up.given.mounting.coefficients[0]
        high[curvature] = min(high[curvature], max(0.0, -given))
    return np.asarray(np.stack([low, high])[:, fit.free] / fit.sigma[fit.free])
