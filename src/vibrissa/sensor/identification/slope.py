"""Local slope of the surface: its effect on friction, on the mean friction, and on the height.

The slope is a Gaussian process along the surface. Slopes at two places with the distance d have the
covariance σ²·exp(−d²/(2ℓ²)).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import erf

from vibrissa.numerics.arrays import FloatArray

# Periods whose covariances are computed together, to save memory.
PERIODS_AT_ONCE = 512


@dataclass(frozen=True, kw_only=True)
class Slope:
    """Tolerance of the local slope of the surface.

    Attributes
    ----------
    deviation : float
        Standard deviation σ of the slope (rad); 0 on a plane.
    length : float
        Correlation length ℓ of the slope along the surface (L).
    """

    deviation: float = 0.0
    length: float = np.inf

    def errors(self, mu0: FloatArray) -> FloatArray:
        """Return the standard deviation of each friction coefficient due to the slope, shape (p,).

        A surface that is inclined by δ where the tip slips turns the normal there: the ratio of
        the forces is tan(arctan μ0 + δ), so that μ0 has the error (1 + μ0²)·δ.
        """
        return np.asarray((1.0 + np.nan_to_num(mu0) ** 2) * self.deviation)

    def variance_of_mean(self, weights: FloatArray, mu0: FloatArray, place: FloatArray) -> float:
        """Return the variance of the mean friction coefficient due to the slope.

        Periods at neighbouring places have correlated errors.

        Parameters
        ----------
        weights, mu0 : ndarray, shape (p,)
            Weight in the mean, and friction coefficient, of each period.
        place : ndarray, shape (p,)
            Position of the clamp at the end of each period (L).
        """
        part = weights * self.errors(mu0)
        total = 0.0
        for start in range(0, len(part), PERIODS_AT_ONCE):
            here = slice(start, start + PERIODS_AT_ONCE)
            apart = (place[here, None] - place) / self.length
            total += float(part[here] @ (np.exp(-0.5 * apart**2) @ part))
        return total

    def heights(self, place: FloatArray) -> FloatArray:
        """Return the covariance of the heights of the surface at p places (L²), shape (p, p).

        The height at the first place is uncertain, too: it has the variance of the rise between
        the two places that are farthest apart.
        """
        at = self.rise(place - place[0])
        whole = self.rise(np.ptp(place))
        apart = self.rise(place[:, None] - place)
        return np.asarray(0.5 * (at[:, None] + at - apart) + whole)

    def rise(self, way: ArrayLike) -> FloatArray:
        """Return the variance of the surface's rise over a distance d, which is `way` (L).

        It is the integral 2·∫ (d − s)·σ²·exp(−s²/(2ℓ²)) ds from 0 to d.
        """
        part = np.abs(way) / self.length
        size = np.sqrt(np.pi / 2.0) * part * erf(part / np.sqrt(2.0)) + np.expm1(-0.5 * part**2)
        return np.asarray(2.0 * (self.deviation * self.length) ** 2 * size)
