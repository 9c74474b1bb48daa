"""One candidate rod: its constraints, and the parts of the uncertainty of the μ0 that it measures.

Strains scale with d0/L, forces with E·d0⁴/L², moments with E·d0⁴/L.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.design.pairs import (
    NODE_WEIGHTS,
    PARAMETERS,
    PART_WEIGHTS,
    PERIODS,
    Pair,
    fitted_parameters,
)
from vibrissa.design.requirements import Requirements
from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import Contact
from vibrissa.quantities.units import CHANNEL_KINDS, Kind
from vibrissa.sensor.identification.parameters import SLOPE, Parameter, ScanRows
from vibrissa.sensor.identification.propagation import step_deviation
from vibrissa.sensor.identification.recording import FORCES, MOMENT
from vibrissa.sensor.identification.slips import SLIP_FALL
from vibrissa.sensor.setup import Setup
from vibrissa.sensor.tolerances import assumed_tolerances
from vibrissa.sensor.transducer import CHANNELS
from vibrissa.sensor.whisker import Whisker

GRAVITY = 9.80665
# Least fall of the load in the slip after the shortest period, in units of the fall that `identify`
# takes for a slip. One slip in 400 is missed then, and one in two if the factor were 1.
CLEARLY = 1.5
# Least ratio of mu_lock to the largest friction coefficient.
LOCK_FACTOR = 1.1
# Largest ratio of the weight to the normal force, as the model has no gravity.
WEIGHT = 0.1
# Least ratio of the displacement at which more than the tip touches to the longest period: a
# natural curvature within its default tolerance, 0.02/L, lowers that displacement by up to 9 %.
BEFORE_TOUCH = 1.1


@dataclass(frozen=True, eq=False)
class Limit:
    """A constraint on one rod or on many, with an upper or a lower bound.

    Attributes
    ----------
    name : str
        Name of the bounded quantity. ``strain``: largest strain. ``lock``: μ_lock. ``tip``:
        diameter of the tip. ``weight``: weight of the rod divided by the least normal force.
        ``touch``: x0 from which on the rod touches with more than its tip, divided by the x0 at
        the end of the longest period. ``force_x``, ``force_y`` or ``moment_z``: largest reading of
        this channel. ``steps``: number of steps in the shortest period. ``slips``: fall of the
        load in the slip after the shortest period, divided by the least fall that `identify` takes
        for a slip. ``ringing``: time for which the rod slips and rings, divided by that of the
        shortest period. ``diameter``: diameter at the clamp. ``spacing``: clamp travel in the
        longest period.
    value : ndarray
        Value for each rod, in SI units.
    bound : float
        Bound of the value, in SI units.
    upper : bool
        Whether the bound is an upper bound.
    """

    name: str
    value: FloatArray
    bound: float
    kind: Kind = Kind.NUMBER
    upper: bool = True

    @property
    def use(self) -> FloatArray:
        """Value divided by its upper bound, or lower bound by the value; violated above 1."""
        with np.errstate(divide="ignore"):
            value = np.asarray(self.value)
            return np.asarray(value / self.bound if self.upper else self.bound / value)


def limits_of(r: Requirements, pair: Pair, diameter: ArrayLike, length: ArrayLike) -> list[Limit]:
    """List the constraints on the rods of a pair (θ, η) with given diameters and lengths (m).

    A constraint whose upper bound is infinite, or whose lower bound is 0, is left out.
    """
    d0 = np.asarray(diameter)
    along = np.asarray(length)
    moment = np.pi / 64.0 * d0**4 * (1.0 - r.mounting.bore**4)  # I0 (m⁴)
    force = r.material.modulus * moment / along**2  # E·I0/L² (N)
    limits = _limits(r, pair, d0, along, {Kind.FORCE: force, Kind.MOMENT: force * along})
    return [limit for limit in limits if limit.bound != (np.inf if limit.upper else 0.0)]


def _limits(
    r: Requirements, pair: Pair, d: FloatArray, length: FloatArray, units: Mapping[Kind, FloatArray]
) -> Iterator[Limit]:
    curve = pair.curve
    theta = curve.theta
    force = units[Kind.FORCE]
    bore = r.mounting.bore
    # The yield strain is that of the material at the clamp: elsewhere the stress decides.
    yield Limit("strain", pair.stress * d / length, r.material.yield_strain / r.safety)
    yield Limit("lock", np.asarray(curve.mu_lock), LOCK_FACTOR * r.mu0[-1], upper=False)
    yield Limit("diameter", d, r.material.largest or np.inf, Kind.LENGTH)
    yield Limit("tip", d / theta, r.tip, Kind.LENGTH, upper=False)
    if r.material.density is not None:
        section = (1.0 + 1.0 / theta + 1.0 / theta**2) / 3.0 - bore**2
        volume = np.pi / 4.0 * section * d**2 * length
        normal = np.abs(pair.reactions[:, 1]).min() * force
        yield Limit("weight", r.material.density * GRAVITY * volume / normal, WEIGHT)
        if r.speed is not None:
            speed = np.sqrt(r.material.modulus / r.material.density * (1.0 + bore**2))
            wave = length**2 / d / speed
            rings = pair.ringing.lasts * 4.0 * wave * r.speed
            yield Limit("ringing", rings / (pair.shortest * length), 1.0)
    if r.setup.contact is Contact.POINT:
        touch = np.nan_to_num(curve.x0_touch, nan=np.inf) / pair.longest
        yield Limit("touch", touch, BEFORE_TOUCH, upper=False)
    largest = np.abs(pair.reactions).max(axis=0)
    channels = zip(CHANNELS, CHANNEL_KINDS, largest, r.largest, strict=True)
    for name, kind, reaction, most in channels:
        yield Limit(name, reaction * units[kind], r.load * most, kind)
    shortest = pair.shortest
    yield Limit("steps", shortest * length / r.step, r.steps, upper=False)
    # The two loads in which `identify` finds slips.
    fall = np.ptp(pair.response.reactions([0.0, shortest]), axis=0)
    seen = (FORCES[0], MOMENT)
    fx, m = (fall[i] * units[CHANNEL_KINDS[i]] / r.noise[i] for i in seen)
    yield Limit("slips", np.hypot(fx, m) / SLIP_FALL, CLEARLY, upper=False)
    yield Limit("spacing", pair.longest * length, r.spacing, Kind.LENGTH)


class TolerancePart(NamedTuple):
    """Contribution of one tolerance to the uncertainty of μ0.

    Attributes
    ----------
    name : str
        Name of the quantity with this tolerance.
    size : float
        Standard deviation of the quantity: in units of the rod, in rad, or relative to its value.
    stated : bool
        Whether the user stated the tolerance; otherwise it is the default.
    halved : float
        Relative decrease of the uncertainty of μ0 if this tolerance is halved.
    """

    name: str
    size: float
    stated: bool
    halved: float


class _Remaining(NamedTuple):
    """Errors of the set-up that remain after `identify`, for k friction coefficients.

    Attributes
    ----------
    effect : ndarray, shape (k, q)
        Effect D of q parameters p/σ on μ0.
    covariance : ndarray, shape (k, q, q)
        Covariance C of p/σ.
    """

    effect: FloatArray
    covariance: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Candidate:
    """One rod, and the standard deviation of μ0 measured in one period of sticking.

    Standard deviations have the shape (k,), for the k values in `Requirements.frictions`; NaN where
    the tip locks.

    Attributes
    ----------
    requirements : Requirements
    pair : Pair
        The pair (θ, η) of the rod.
    diameter, length : float
        Diameter at the clamp and length of the rod (m).
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
        """The set-up stated in the requirements, with the sizes of this rod."""
        return self.requirements.rod_setup(self.theta, self.eta, self.diameter, self.length)

    @cached_property
    def whisker(self) -> Whisker:
        """The rod and the height of the surface, with the stated tolerances."""
        return self.setup.whisker

    @cached_property
    def checks(self) -> list[Limit]:
        """All constraints, sorted by decreasing use (`Limit.use`, 1 at the bound)."""
        limits = limits_of(self.requirements, self.pair, self.diameter, self.length)
        return sorted(limits, key=lambda check: -float(f"{check.use:.3g}"))

    @property
    def by_step(self) -> FloatArray:
        """Uncertainty of μ0 due to the step of the stage."""
        return step_deviation(self.pair.demand_slope, self.requirements.step / self.length)

    @property
    def by_reading(self) -> FloatArray:
        """Uncertainty of μ0 due to the noise of the readings."""
        with np.errstate(divide="ignore"):  # infinite for a period of length 0, without readings
            return np.asarray(np.abs(self.pair.demand_slope) / np.sqrt(self._known))

    @cached_property
    def by_tolerances(self) -> FloatArray:
        """Uncertainty due to surface slope and to set-up errors that remain after `identify`."""
        effect, covariance = self._remaining
        common = np.einsum("kq,kqr,kr->k", effect, covariance, effect)
        return np.sqrt(common + self._of_slope**2)

    @cached_property
    def whole(self) -> FloatArray:
        """Standard deviation of μ0: its three parts added in quadrature."""
        return np.sqrt(self.by_step**2 + self.by_reading**2 + self.by_tolerances**2)

    @property
    def largest(self) -> float:
        """Largest standard deviation of μ0; NaN if the tip locks at one of the values of μ0."""
        return float(self.whole.max())

    @property
    def _noise(self) -> FloatArray:
        return self.requirements.noise / self.whisker.units.channels

    @cached_property
    def tolerances(self) -> dict[str, float]:
        """Tolerances by name, stated or default: in units of the rod, in rad, or relative."""
        assume = self.requirements.setup.assume
        assumed = assumed_tolerances(self.whisker.units, self._noise) if assume else {}
        return assumed | dict(self.whisker.tolerances)

    @property
    def _of_slope(self) -> FloatArray:
        return np.asarray(self.tolerances.get(SLOPE, 0.0) * (1.0 + self.requirements.frictions**2))

    @cached_property
    def _weight(self) -> FloatArray:
        """Number of readings for which each of x nodes stands, over their variance, (k, x, 3)."""
        readings = self.x0_slip / self.requirements.step
        return np.asarray(readings[:, None, None] * NODE_WEIGHTS[:, None] / self._noise**2)

    @cached_property
    def _known(self) -> FloatArray:
        """Inverse variance jᵀj of the last displacement u of a period, shape (k,)."""
        return np.asarray((self._weight * self.pair.sensitivity.contact**2).sum(axis=(1, 2)))

    def _sigma(self) -> FloatArray:
        """Return the standard deviations of q parameters; that of crosstalk as a ratio of loads."""

        def deviation_of(parameter: Parameter) -> float:
            if parameter.of != "crosstalk" or parameter.effect is None:
                return parameter.deviation
            # For loads of 1 the effect is the ratio of the full scales of the two channels.
            ratio = parameter.effect(np.ones(3), ScanRows(part=np.zeros(1), last=1)).max()
            return parameter.deviation * float(ratio)

        limit = self.requirements.largest / self.whisker.units.channels
        full_scale = np.where(np.isfinite(limit), limit, np.abs(self.pair.reactions).max(axis=0))
        return np.array(
            [
                deviation_of(parameter)
                for parameter in fitted_parameters(self.tolerances, full_scale)
            ]
        )

    @cached_property
    def _remaining(self) -> _Remaining:
        """Errors of the set-up that remain after `identify`; equations in `vibrissa.design.pairs`.

        Axes: k friction coefficients, p of the fitted periods, x displacements in a period,
        c channels, q and r parameters.
        """
        sensitivity = self.pair.sensitivity
        sigma = self._sigma()
        weight = self._weight
        periods = PERIODS * PART_WEIGHTS
        setup = sensitivity.setup * sigma
        # jᵀJ, and the change of u with p, jᵀJ/(jᵀj), in each period.
        crossed = np.einsum("kxc,kpxcq->kpq", weight * sensitivity.contact, setup)
        with np.errstate(invalid="ignore"):
            moves = crossed / self._known[:, None, None]
        # Σ JᵀJ as one product of matrices: its rows are the residuals of all periods.
        rows = setup * np.sqrt(periods[:, None, None] * weight[:, None])[..., None]
        rows = rows.reshape(len(crossed), -1, len(sigma))
        squares = rows.transpose(0, 2, 1) @ rows
        taken_by_contacts = np.einsum("p,kpq,kpr->kqr", periods, crossed, moves)
        effect = sensitivity.friction * sigma - self.pair.demand_slope[:, None, None] * moves
        return _Remaining(
            effect=np.einsum("p,kpq->kq", PART_WEIGHTS, effect),
            covariance=np.linalg.inv(squares - taken_by_contacts + np.eye(len(sigma))),
        )

    def parts(self) -> list[TolerancePart]:
        """List how much halving each tolerance alone lowers the largest uncertainty of μ0.

        C is the covariance of the fitted parameters, and D their effect on μ0
        (`vibrissa.design.pairs`). Let P be the parameters to which one tolerance applies, S their
        covariance before the fit, Cₚ the columns of C for P, and Cₚₚ the rows of Cₚ for P. Halving
        the tolerance is like one more measurement of P, with covariance S/3. It lowers the variance
        D·C·Dᵀ of μ0 by D·Cₚ·(S/3 + Cₚₚ)⁻¹·Cₚᵀ·Dᵀ.
        """
        if not np.isfinite(self.largest):
            return []
        worst = int(np.argmax(self.whole))
        effect = self._remaining.effect[worst]
        covariance = self._remaining.covariance[worst]
        parts = []
        for name, size in self.tolerances.items():
            own = np.flatnonzero([parameter.of == name for parameter in PARAMETERS])
            shared = covariance[own] @ effect
            remaining = covariance[np.ix_(own, own)]
            falls = float(shared @ np.linalg.solve(np.eye(len(own)) / 3.0 + remaining, shared))
            if name == SLOPE:
                falls = 0.75 * float(self._of_slope[worst]) ** 2
            halved = 1.0 - float(np.sqrt(max(1.0 - falls / self.largest**2, 0.0)))
            parts.append(TolerancePart(name, size, name in self.whisker.tolerances, halved))
        return sorted(parts, key=lambda part: -part.halved)
