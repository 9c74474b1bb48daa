"""What a fit says: the errors of the set-up that remain, and how well each period fits."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import chdtrc

from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.sensor.identification.bounded import mean_within
from vibrissa.sensor.identification.fit import Fit
from vibrissa.sensor.identification.linearisation import HeightsOfTips, Linearisation
from vibrissa.sensor.identification.task import Task
from vibrissa.sensor.identification.unevenness import Unevenness, unevenness_of

# A period does not fit by itself if its residuals have a lower probability than this.
UNLIKELY_PERIOD = 1e-9
# Largest number of tips whose heights are compared.
MOST_HEIGHTS = 500


@dataclass(frozen=True, eq=False, kw_only=True)
class FittedSetUp:
    """A fitted set-up beside the recording; see `Fit` for the shapes.

    Attributes
    ----------
    line : Linearisation
        Linearisation at the fit, or at a fit before a last, small step.
    settled : bool
        Whether the fit has converged; otherwise the set-up is as given.
    """

    fit: Fit
    line: Linearisation
    settled: bool

    @property
    def task(self) -> Task:
        """Recording, noise and tolerances."""
        return self.fit.task

    @property
    def adjusted(self) -> bool:
        """Whether the set-up was fitted: the fit has converged, and not all of it is exact."""
        return self.settled and bool(self.task.free.any())

    @cached_property
    def misses(self) -> FloatArray:
        """Residuals that the height of no tip explains, shape (n, c)."""
        return self.line.misses(self.fit)

    @cached_property
    def remaining(self) -> FloatArray:
        """Covariance of the errors of p/σ that remain after the fit, shape (f, f)."""
        if not self.adjusted:
            return np.eye(int(self.task.free.sum()))
        return np.asarray(np.linalg.inv(self.line.normal))

    @property
    def covariance(self) -> FloatArray:
        """Covariance of the errors of p that remain after the fit, shape (f, f)."""
        sigma = self.task.sigma[self.task.free]
        return np.asarray(self.remaining * np.outer(sigma, sigma))

    @cached_property
    def unexpected(self) -> FloatArray:
        """Expected p less the fitted p, of the parameters that are not exact, shape (f,).

        The fit is the likeliest set-up. It is not the expected one where a bound cuts off likely
        values: the compliance of a clamp is likeliest 0, and certainly not less.
        """
        fit = self.fit
        if not self.adjusted:
            return np.zeros(len(fit.scores))
        # The minimum without bounds.
        least = fit.scores - self.remaining @ self.line.gradient(fit)
        expected = mean_within(least, self.remaining, *fit.bounds)
        return np.asarray((expected - fit.scores) * self.task.sigma[self.task.free])

    @cached_property
    def heights(self) -> HeightsOfTips:
        """Heights of the surface at the tips."""
        return self.line.heights(self.fit)

    @cached_property
    def misfits(self) -> FloatArray:
        """Squared residuals of each period that the height of its tip leaves, shape (p,)."""
        squares = self.task.blocks.sums((self.fit.residuals**2).sum(axis=1))
        if not self.task.slope.deviation:
            return squares
        return np.asarray(squares - self.heights.height**2 / self.heights.variance)

    @property
    def per_period(self) -> int:
        """Number of quantities fitted in each period: the contact point, and perhaps its height."""
        return 2 if self.task.slope.deviation else 1

    @property
    def degrees(self) -> int:
        """Degrees of freedom of the `misfits` of the fitted periods."""
        of_periods = self.per_period * int(self.fit.kept.sum())
        return int(self.fit.rows.sum()) * len(self.task.used) - of_periods

    @cached_property
    def unevenness(self) -> Unevenness:
        """Test the surface's heights at the contact points of fitted periods.

        If there are more than `MOST_HEIGHTS`, evenly spaced ones are selected.
        """
        if not self.task.slope.deviation:
            return Unevenness(chi2=0.0, number=0, chance=1.0)
        kept = np.flatnonzero(self.fit.kept)
        sample = kept[:: -(-len(kept) // MOST_HEIGHTS)]
        # The set-up moves all heights together.
        moves = self.line.moves_of_heights[sample][:, self.task.free]
        error = np.diag(self.heights.variance[sample]) + moves @ self.covariance @ moves.T
        surface = self.task.slope.heights(self.task.ends.clamp[sample])
        return unevenness_of(self.heights.height[sample], surface, error)

    @property
    def misfit(self) -> float:
        """Sum of `misfits` of the fitted periods, χ² of the surface's heights, and Σ (p/σ)²."""
        periods = self.misfits[self.fit.kept].sum()
        return float(periods + self.unevenness.chi2 + (self.fit.scores**2).sum())

    @cached_property
    def fits_alone(self) -> BoolArray:
        """Whether the readings of each period fit a tip that sticks at one place, shape (p,)."""
        blocks = np.bincount(self.task.blocks.period)
        degrees = len(self.task.used) * blocks - self.per_period
        chance = chdtrc(np.maximum(degrees, 1), self.misfits)
        return np.asarray(chance >= UNLIKELY_PERIOD)
