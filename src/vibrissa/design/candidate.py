"""A rod, and the uncertainty of μ0 measured with it, by its sources."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vibrissa.design.pairs import Pairs
from vibrissa.design.requirements import Requirements
from vibrissa.design.sensitivity import PARAMETERS, PART_WEIGHTS, PERIODS
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.identification.parameters import SLOPE, parameters_of
from vibrissa.sensor.identification.uncertainty import step_deviation
from vibrissa.sensor.setup import Setup
from vibrissa.sensor.tolerances import assumed_tolerances
from vibrissa.sensor.whisker import Whisker


@dataclass(frozen=True, kw_only=True)
class TolerancePart:
    """Part of one tolerance in the uncertainty of μ0.

    Attributes
    ----------
    size : float
        Standard deviation, in units of the rod, rad, or relative.
    halved : float
        Relative fall of the uncertainty if this tolerance is halved.
    """

    name: str
    size: float
    stated: bool
    halved: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Candidate:
    """One rod, and the standard deviation of μ0 from one of its periods.

    Deviations are at the k friction coefficients of the requirements, shape (k,).

    Attributes
    ----------
    requirements : Requirements
    pair : Pairs
        The pair (θ, η) of the rod, alone.
    diameter, length : float
        Its size (m).
    """

    requirements: Requirements
    pair: Pairs
    diameter: float
    length: float

    @property
    def theta(self) -> float:
        """Taper."""
        return float(self.pair.theta[0])

    @property
    def eta(self) -> float:
        """Height of the surface (L)."""
        return float(self.pair.eta[0])

    @property
    def mu_lock(self) -> float:
        """Critical friction coefficient."""
        return float(self.pair.mu_lock[0])

    @property
    def x0_slip(self) -> FloatArray:
        """Clamp travel in a period of sticking (m), shape (k,); NaN where the tip locks."""
        return self.pair.x0_slip[0] * self.length

    @property
    def setup(self) -> Setup:
        """Set-up with this rod."""
        return self.requirements.rod_setup(self.theta, self.eta, self.diameter, self.length)

    @cached_property
    def whisker(self) -> Whisker:
        """The rod under the surface, with the tolerances that were stated."""
        return self.setup.whisker

    @property
    def by_step(self) -> FloatArray:
        """Random part by the step of the stage, in which the onset is uniform."""
        slope = self.pair.sensitivity.slope[0]
        return step_deviation(slope, self.requirements.step / self.length)

    @property
    def by_reading(self) -> FloatArray:
        """Random part by the noise of the readings."""
        with np.errstate(divide="ignore"):  # a period of no length tells nothing
            return np.asarray(np.abs(self.pair.sensitivity.slope[0]) / np.sqrt(self._contact))

    @cached_property
    def by_tolerances(self) -> FloatArray:
        """Part common to all periods: tolerances after the fit of `identify`, and surface slope."""
        effect, covariance = self._fit()
        common = np.einsum("kq,kqr,kr->k", effect, covariance, effect)
        return np.sqrt(common + self._of_slope**2)

    @property
    def whole(self) -> FloatArray:
        """All three parts, added in quadrature; NaN where the tip locks."""
        return np.sqrt(self.by_step**2 + self.by_reading**2 + self.by_tolerances**2)

    @property
    def largest(self) -> float:
        """Whole uncertainty at the friction where it is largest."""
        return float(self.whole.max())

    @property
    def _noise(self) -> FloatArray:
        return np.array(self.requirements.noise) / self.whisker.units.channels

    @cached_property
    def tolerances(self) -> dict[str, float]:
        """Tolerances, stated or by default, in units of the rod."""
        assume = self.requirements.setup.assume
        assumed = assumed_tolerances(self.whisker.units, self._noise) if assume else {}
        return assumed | dict(self.whisker.tolerances)

    @property
    def _of_slope(self) -> FloatArray:
        return np.asarray(self.tolerances.get(SLOPE, 0.0) * (1.0 + self.requirements.frictions**2))

    @cached_property
    def _weight(self) -> FloatArray:
        """Inverse variances of all readings of a period, by friction and channel, shape (k, 3)."""
        readings = self.pair.x0_slip[0] * self.length / self.requirements.step
        return np.asarray(readings[:, None] / self._noise**2)

    @property
    def _contact(self) -> FloatArray:
        return np.asarray((self._weight * self.pair.sensitivity.of_contact[0]).sum(axis=-1))

    def _sigma(self) -> FloatArray:
        """Tolerances of all parameters, shape (q,); crosstalk is a part of full scale."""
        full = np.array(self.requirements.largest) / self.whisker.units.channels
        full = np.where(np.isfinite(full), full, self.pair.largest_reaction[0])
        return np.array(
            [
                one.deviation
                * (1.0 if one.mixing is None or one.of != "crosstalk" else one.mixing.max())
                for one in parameters_of(self.tolerances, frozenset(), full)
            ]
        )

    def _fit(self) -> tuple[FloatArray, FloatArray]:
        """Effect D, shape (k, q), and covariance C, shape (k, q, q), both in tolerances."""
        of, sigma = self.pair.sensitivity.take(0), self._sigma()
        both = np.einsum("kc,kcpq->kpq", self._weight, of.of_both) * sigma
        setup = np.einsum("kc,kcqr->kqr", self._weight, of.of_setup) * np.outer(sigma, sigma)
        with np.errstate(invalid="ignore"):
            moved = both / self._contact[:, None, None]
        known = np.einsum("p,kpq,kpr->kqr", PERIODS * PART_WEIGHTS, both, moved)
        effect = of.friction * sigma - of.slope[:, None, None] * moved
        return (
            np.einsum("p,kpq->kq", PART_WEIGHTS, effect),
            np.linalg.inv(setup - known + np.eye(len(sigma))),
        )

    def parts(self) -> list[TolerancePart]:
        """List the effect of halving each tolerance, at the largest uncertainty, most first.

        Its quantities are measured once more with a third of their variance S: then D·C·Dᵀ falls by
        D·Cₖ·(S/3 + Cₖₖ)⁻¹·Cₖᵀ·Dᵀ, with their columns k in C.
        """
        if not np.isfinite(self.largest):
            return []
        worst = int(np.argmax(self.whole))
        effect, covariance = (one[worst] for one in self._fit())
        found = []
        for name, size in self.tolerances.items():
            own = np.flatnonzero([one.of == name for one in PARAMETERS])
            shared, remaining = covariance[own] @ effect, covariance[np.ix_(own, own)]
            falls = float(shared @ np.linalg.solve(np.eye(len(own)) / 3.0 + remaining, shared))
            if name == SLOPE:
                falls = 0.75 * float(self._of_slope[worst]) ** 2
            halved = 1.0 - float(np.sqrt(max(1.0 - falls / self.largest**2, 0.0)))
            stated = name in self.whisker.tolerances
            found.append(TolerancePart(name=name, size=size, stated=stated, halved=halved))
        return sorted(found, key=lambda one: -one.halved)
