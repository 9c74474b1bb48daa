"""A rod, and the uncertainty of μ0 measured with it, by its sources."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from vibrissa.design.limits import Limit, limits_of
from vibrissa.design.pairs import Pair
from vibrissa.design.requirements import Requirements
from vibrissa.design.sensitivity import NODE_WEIGHTS, PARAMETERS, PART_WEIGHTS, PERIODS
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.identification.parameters import SLOPE, parameters_of
from vibrissa.sensor.identification.uncertainty import step_deviation
from vibrissa.sensor.setup import Setup
from vibrissa.sensor.tolerances import assumed_tolerances
from vibrissa.sensor.whisker import Whisker


class TolerancePart(NamedTuple):
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

    Deviations are at the k friction coefficients of the requirements, shape (k,); NaN where the tip
    locks.

    Attributes
    ----------
    requirements : Requirements
    pair : Pair
        The pair (θ, η) of the rod.
    diameter, length : float
        Its size (m).
    """

    requirements: Requirements
    pair: Pair
    diameter: float
    length: float

    @property
    def theta(self) -> float:
        """Taper."""
        return self.pair.curve.theta

    @property
    def eta(self) -> float:
        """Height of the surface (L)."""
        return self.pair.curve.eta

    @property
    def mu_lock(self) -> float:
        """Critical friction coefficient."""
        return self.pair.curve.mu_lock

    @property
    def x0_slip(self) -> FloatArray:
        """Clamp travel in a period of sticking (m), shape (k,)."""
        return self.pair.x0_slip * self.length

    @property
    def setup(self) -> Setup:
        """Set-up with this rod."""
        return self.requirements.rod_setup(self.theta, self.eta, self.diameter, self.length)

    @cached_property
    def whisker(self) -> Whisker:
        """The rod under the surface, with the tolerances that were stated."""
        return self.setup.whisker

    @cached_property
    def checks(self) -> list[Limit]:
        """Every constraint, the most used first."""
        found = limits_of(self.requirements, self.pair, self.diameter, self.length)
        return sorted(found, key=lambda check: -float(f"{check.use:.3g}"))

    @property
    def by_step(self) -> FloatArray:
        """Random part by the step of the stage, in which the onset is uniform."""
        return step_deviation(self.pair.demand_slope, self.requirements.step / self.length)

    @property
    def by_reading(self) -> FloatArray:
        """Random part by the noise of the readings."""
        with np.errstate(divide="ignore"):  # a period of no length tells nothing
            return np.asarray(np.abs(self.pair.demand_slope) / np.sqrt(self._known))

    @cached_property
    def by_tolerances(self) -> FloatArray:
        """Part common to all periods: tolerances after the fit of `identify`, and surface slope."""
        effect, covariance = self._errors
        common = np.einsum("kq,kqr,kr->k", effect, covariance, effect)
        return np.sqrt(common + self._of_slope**2)

    @cached_property
    def whole(self) -> FloatArray:
        """All three parts, added in quadrature."""
        return np.sqrt(self.by_step**2 + self.by_reading**2 + self.by_tolerances**2)

    @property
    def largest(self) -> float:
        """Whole uncertainty at the friction where it is largest."""
        return float(self.whole.max())

    @property
    def _noise(self) -> FloatArray:
        return self.requirements.noise / self.whisker.units.channels

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
        """Inverse variances of readings at the nodes of a period, shape (k, x, 3)."""
        readings = self.x0_slip / self.requirements.step
        return np.asarray(readings[:, None, None] * NODE_WEIGHTS[:, None] / self._noise**2)

    @cached_property
    def _known(self) -> FloatArray:
        """Inverse variance of the contact u of a period, (jᵀj), shape (k,)."""
        return np.asarray((self._weight * self.pair.sensitivity.contact**2).sum(axis=(1, 2)))

    def _sigma(self) -> FloatArray:
        """Tolerances of all parameters, shape (q,); crosstalk is a part of full scale."""
        full = np.array(self.requirements.largest) / self.whisker.units.channels
        full = np.where(np.isfinite(full), full, np.abs(self.pair.reactions).max(axis=0))
        parameters = parameters_of(self.tolerances, frozenset(), full)
        sigma = np.array([one.deviation for one in parameters])
        for k, one in enumerate(parameters):
            if one.of == "crosstalk" and one.effect is not None:
                # Of loads of 1 the other channel shows the ratio of the full scales.
                sigma[k] *= one.effect(np.ones(3), np.zeros(1), 1).max()
        return sigma

    @cached_property
    def _errors(self) -> tuple[FloatArray, FloatArray]:
        """Effect D, shape (k, q), and covariance C, shape (k, q, q), both in tolerances."""
        of, sigma, weight = self.pair.sensitivity, self._sigma(), self._weight
        setup = of.setup * sigma
        both = np.einsum("kxc,kpxcq->kpq", weight * of.contact, setup)
        with np.errstate(invalid="ignore"):
            moved = both / self._known[:, None, None]
        rows = setup * np.sqrt(PERIODS * PART_WEIGHTS[:, None, None] * weight[:, None])[..., None]
        rows = rows.reshape(len(both), -1, len(sigma))
        squares = rows.transpose(0, 2, 1) @ rows
        known = np.einsum("p,kpq,kpr->kqr", PERIODS * PART_WEIGHTS, both, moved)
        effect = of.friction * sigma - self.pair.demand_slope[:, None, None] * moved
        return (
            np.einsum("p,kpq->kq", PART_WEIGHTS, effect),
            np.linalg.inv(squares - known + np.eye(len(sigma))),
        )

    def parts(self) -> list[TolerancePart]:
        """List the effect of halving each tolerance, at the largest uncertainty, most first.

        Its quantities are measured once more with a third of their variance S: then D·C·Dᵀ falls by
        D·Cₖ·(S/3 + Cₖₖ)⁻¹·Cₖᵀ·Dᵀ, with their columns k in C.
        """
        if not np.isfinite(self.largest):
            return []
        worst = int(np.argmax(self.whole))
        effect, covariance = (one[worst] for one in self._errors)
        found = []
        for name, size in self.tolerances.items():
            own = np.flatnonzero([one.of == name for one in PARAMETERS])
            shared, remaining = covariance[own] @ effect, covariance[np.ix_(own, own)]
            falls = float(shared @ np.linalg.solve(np.eye(len(own)) / 3.0 + remaining, shared))
            if name == SLOPE:
                falls = 0.75 * float(self._of_slope[worst]) ** 2
            halved = 1.0 - float(np.sqrt(max(1.0 - falls / self.largest**2, 0.0)))
            found.append(TolerancePart(name, size, name in self.whisker.tolerances, halved))
        return sorted(found, key=lambda one: -one.halved)
