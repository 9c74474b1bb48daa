"""Derivatives of a fit with respect to the parameters of the set-up, and what follows from them.

The errors of p that remain after the fit have the covariance C = (JᵀJ + 1/σ²)⁻¹ with
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

from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.sensor.identification.fit import LEAST_WEIGHT, Fit


class HeightsOfTips(NamedTuple):
    """Estimated heights of the surface at p contact points, above the plane of the set-up.

    Attributes
    ----------
    height, variance : ndarray, shape (p,)
        The heights (L), and the variance of their errors due to noise (L²).
    """

    height: FloatArray
    variance: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Linearisation:
    """Derivatives of readings, u and μ0 with respect to the k parameters of the set-up.

    It is made at one fit and used for all that are near to it. See `Fit` for the shapes.

    Attributes
    ----------
    at : Fit
        The fit at which the derivatives were taken.
    readings : ndarray, shape (k, n, c)
        Derivatives of the readings, divided by the standard deviations of the readings. u is
        fitted anew for each change of a parameter.
    u : ndarray, shape (p, k)
        Derivatives of the fitted u.
    friction : ndarray, shape (p, k)
        Derivatives of μ0 at constant u.
    """

    at: Fit
    readings: FloatArray
    u: FloatArray
    friction: FloatArray

    @classmethod
    def of(cls, fit: Fit) -> "Linearisation":
        """Differentiate a fit.

        Raises
        ------
        NoResponseError
            If a rod near to that of the fit has no response.
        """
        blocks = fit.task.blocks
        slope = fit.slope
        changes = fit.model.changes(fit.u)
        readings = fit.weighted(changes.readings)
        moves = -np.stack(
            [blocks.sums((change * slope).sum(axis=1)) for change in readings], axis=1
        )
        moves /= fit.known[:, None]
        refitted = [
            change + slope * moved[blocks.period][:, None]
            for change, moved in zip(readings, moves.T, strict=True)
        ]
        return cls(at=fit, readings=np.stack(refitted), u=moves, friction=changes.friction.T)

    def keeping(self, kept: BoolArray) -> "Linearisation":
        """Return a copy for a fit of the set-up to other periods."""
        return replace(self, at=replace(self.at, kept=kept))

    @property
    def by_height(self) -> FloatArray:
        """Derivatives of the readings by the height of the tip, shape (n, c)."""
        return np.asarray(self.readings[self.at.task.number["eta"]])

    @cached_property
    def height_information(self) -> FloatArray:
        """Inverse variance of the height of each tip, for a known set-up, shape (p,)."""
        sums = self.at.task.blocks.sums((self.by_height**2).sum(axis=1))
        return np.maximum(sums, LEAST_WEIGHT)

    @cached_property
    def allowed(self) -> float:
        """Variance of the height of a tip that the tolerance of the slope allows (L²)."""
        return float(self.at.task.slope.rise(np.ptp(self.at.task.ends.clamp)))

    def levelled(self, values: FloatArray) -> FloatArray:
        """Multiply values (n, c) of the blocks by the inverse root of 1 + a·ggᵀ; see this module.

        On a plane surface these are the values.
        """
        if not self.at.task.slope.deviation:
            return values
        blocks = self.at.task.blocks
        along = self.by_height
        less = (
            1.0 / np.sqrt(1.0 + self.allowed * self.height_information) - 1.0
        ) / self.height_information
        part = blocks.sums((along * values).sum(axis=1)) * less
        return np.asarray(values + along * part[blocks.period][:, None])

    @property
    def changes(self) -> FloatArray:
        """Derivatives of the readings by each parameter, `levelled`, shape (k, n, c)."""
        return np.stack([self.levelled(change) for change in self.readings])

    @cached_property
    def jacobian(self) -> FloatArray:
        """Jᵀ: derivatives of the m misses of fitted periods with respect to p/σ, shape (f, m)."""
        free = self.at.task.free
        sigma = self.at.task.sigma
        each = [self.levelled(change)[self.at.rows].ravel() for change in self.readings[free]]
        size = int(self.at.rows.sum()) * self.readings.shape[2]
        return -np.reshape(each, (len(each), size)) * sigma[free, None]

    @cached_property
    def normal(self) -> FloatArray:
        """JᵀJ + 1: half the Gauss-Newton Hessian of `total` as a function of p/σ, shape (f, f)."""
        return np.asarray(self.jacobian @ self.jacobian.T + np.eye(len(self.jacobian)))

    def misses(self, fit: Fit) -> FloatArray:
        """Residuals of a fit that the height of no tip explains, `levelled`, shape (n, c)."""
        return self.levelled(fit.residuals)

    def total(self, fit: Fit) -> float:
        """Return the minimised sum: χ² of the fitted periods plus Σ (p/σ)²."""
        return float((self.misses(fit)[fit.rows] ** 2).sum() + (fit.scores**2).sum())

    def gradient(self, fit: Fit) -> FloatArray:
        """Half the derivatives of `total` with respect to p/σ, shape (f,)."""
        return np.asarray(self.jacobian @ self.misses(fit)[fit.rows].ravel() + fit.scores)

    def heights(self, fit: Fit) -> HeightsOfTips:
        """Estimate the height of the surface at each tip of a fit."""
        sums = self.at.task.blocks.sums((self.by_height * fit.residuals).sum(axis=1))
        known = np.maximum(self.height_information, 1.0)
        return HeightsOfTips(height=sums / known, variance=1.0 / known)

    @cached_property
    def moves_of_heights(self) -> FloatArray:
        """Derivatives of the estimated heights with respect to each parameter, shape (p, k)."""
        sums = self.at.task.blocks.sums
        along = self.by_height
        each = [sums((change * along).sum(axis=1)) for change in self.readings]
        return np.asarray(
            -np.stack(each, axis=1) / np.maximum(self.height_information, 1.0)[:, None]
        )
