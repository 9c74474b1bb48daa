"""The uncertainty of μ0 that one rod reads, by its sources.

The equations are in `vibrissa.design.sensitivity`; here a rod of a pair (θ, η) has a size.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vibrissa.design.pairs import Pairs
from vibrissa.design.requirements import Requirements
from vibrissa.design.sensitivity import PARAMETERS, PART_WEIGHTS, PERIODS
from vibrissa.mechanics.rod import Rod
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.identification.parameters import SLOPE, parameters_of
from vibrissa.sensor.tolerances import assumed_tolerances, read_tolerances
from vibrissa.sensor.whisker import Whisker


@dataclass(frozen=True, kw_only=True)
class TolerancePart:
    """What one tolerance costs in the uncertainty of μ0.

    Attributes
    ----------
    name : str
    size : float
        Standard deviation, in units of the rod, rad, or relative.
    stated : bool
        Whether it was stated; otherwise it is the default.
    alone : float
        Standard deviation of μ0 by it, if nothing is fitted to the recording.
    halved : float
        By which part the uncertainty of μ0 falls if it is halved.
    """

    name: str
    size: float
    stated: bool
    alone: float
    halved: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Uncertainty:
    """Standard deviation of μ0 from one period of sticking, at k frictions, as `identify` gives it.

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
    def by_step(self) -> FloatArray:
        """Random, by the step of the stage, in which the onset is uniform."""
        step = self.requirements.step / self.length
        return np.asarray(np.abs(self.pair.sensitivity.slope[0]) * step / np.sqrt(12.0))

    @property
    def by_reading(self) -> FloatArray:
        """Random, by the noise of the readings."""
        with np.errstate(divide="ignore"):  # a period of no length tells nothing
            return np.asarray(np.abs(self.pair.sensitivity.slope[0]) / np.sqrt(self._contact))

    @cached_property
    def by_tolerances(self) -> FloatArray:
        """Common to all periods: by what the fit of `identify` leaves of the tolerances.

        No reading tells a local slope of the surface from friction.
        """
        effect, covariance = self._fit
        common = np.einsum("kq,kqr,kr->k", effect, covariance, effect)
        return np.sqrt(common + self._of_slope**2)

    @property
    def whole(self) -> FloatArray:
        """All of them, added in quadrature; NaN where the tip locks."""
        return np.sqrt(self.by_step**2 + self.by_reading**2 + self.by_tolerances**2)

    @property
    def largest(self) -> float:
        """Whole uncertainty at that friction where it is largest."""
        return float(self.whole.max())

    @cached_property
    def _whisker(self) -> Whisker:
        rod = Rod(self.requirements.modulus, self.diameter, self.length)
        return Whisker(theta=float(self.pair.theta[0]), eta=float(self.pair.eta[0]), rod=rod)

    @cached_property
    def _noise(self) -> FloatArray:
        return np.array(self.requirements.noise) / self._whisker.units.channels

    @cached_property
    def tolerances(self) -> dict[str, float]:
        """Tolerances, stated or by default, in units of the rod."""
        units = self._whisker.units
        assumed = assumed_tolerances(units, self._noise) if self.requirements.assume else {}
        return assumed | read_tolerances(units, self.requirements.tolerances, self._whisker)

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

    @cached_property
    def _sigma(self) -> FloatArray:
        """Tolerances of all parameters, shape (q,); crosstalk is a part of full scale."""
        full = np.array(self.requirements.range) / self._whisker.units.channels
        full = np.where(np.isfinite(full), full, self.pair.largest_reaction[0])
        found = parameters_of(self.tolerances, frozenset(), full)
        mixed = {k: one.mixing for k, one in enumerate(found) if one.of == "crosstalk"}
        sigma = np.array([one.deviation for one in found])
        for k, mixing in mixed.items():
            sigma[k] *= np.max(mixing) if mixing is not None else 1.0
        return sigma

    @cached_property
    def _fit(self) -> tuple[FloatArray, FloatArray]:
        """Effect D, shape (k, q), and covariance C, shape (k, q, q), both in tolerances."""
        of, sigma = self.pair.sensitivity.take(0), self._sigma
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
        """Tell what each tolerance costs where the uncertainty is largest, what to measure first.

        Notes
        -----
        The quantities of one tolerance have half of it if they are measured once more with a third
        of its variance S. By then the variance D·C·Dᵀ falls by D·Cₖ·(S/3 + Cₖₖ)⁻¹·Cₖᵀ·Dᵀ, with the
        columns k of these quantities in C. So correlations are kept.
        """
        worst = int(np.argmax(self.whole))
        effect, covariance = (one[worst] for one in self._fit)
        found = []
        for name, size in self.tolerances.items():
            own = np.flatnonzero([one.of == name for one in PARAMETERS])
            alone, shared = float(np.linalg.norm(effect[own])), covariance[own] @ effect
            measured = np.eye(len(own)) / 3.0 + covariance[np.ix_(own, own)]
            falls = float(shared @ np.linalg.solve(measured, shared))
            if name == SLOPE:
                alone = float(self._of_slope[worst])
                falls = 0.75 * alone**2
            left = 1.0 - falls / self.largest**2
            found.append(
                TolerancePart(
                    name=name,
                    size=size,
                    stated=name in self.requirements.tolerances,
                    alone=alone,
                    halved=1.0 - float(np.sqrt(max(left, 0.0))),
                )
            )
        return sorted(found, key=lambda one: -one.halved)
