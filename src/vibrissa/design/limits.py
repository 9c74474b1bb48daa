"""Constraints on rods, each as a value and a bound, for many sizes of rods at once.

Strains grow with the size of the rod as d0/L, forces as E·d0⁴/L², moments as E·d0⁴/L.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.design.pairs import Pair
from vibrissa.design.requirements import Requirements
from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import Contact
from vibrissa.sensor.quantities import CHANNEL_KINDS, Kind
from vibrissa.sensor.transducer import CHANNELS

GRAVITY = 9.80665
# A slip shows where the forces jump by so many standard deviations of the difference of two
# readings. The shortest period must exceed that by the second factor: one slip in 1,000 is missed
# then, and one in two at a factor of 1.
JUMP, CLEARLY = 6.0, 1.5
# Least ratio of mu_lock to the largest friction, and largest one of the weight to the normal force:
# the model has no gravity.
LOCK_FACTOR, WEIGHT = 1.1, 0.1
# Within its default tolerance, 0.02/L, a natural curvature brings the touch nearer by up to 9 %.
BEFORE_TOUCH = 1.1


@dataclass(frozen=True, eq=False)
class Limit:
    """A constraint on one rod or on many, with an upper or a lower bound.

    ``strain``: largest strain of a period; ``lock``: μ_lock; ``tip``: diameter of the tip;
    ``weight``: weight over the least normal force; ``touch``: displacement at which more than the
    tip touches, over the longest period; a channel: its largest reaction; ``steps``: steps of the
    shortest period; ``slips``: shortest period over a noticed slip; ``spacing``: largest clamp
    travel between slips.
    """

    name: str
    value: FloatArray
    bound: float
    kind: Kind = Kind.NUMBER
    upper: bool = True

    @property
    def use(self) -> FloatArray:
        """Part of the limit that is used; violated above 1."""
        with np.errstate(divide="ignore"):
            value = np.asarray(self.value)
            return np.asarray(value / self.bound if self.upper else self.bound / value)


def limits_of(r: Requirements, pair: Pair, diameter: ArrayLike, length: ArrayLike) -> list[Limit]:
    """List the constraints on rods of a pair (θ, η) and of diameters and lengths (m).

    Constraints that allow everything are left out.
    """
    d, along = np.asarray(diameter), np.asarray(length)
    force = r.rigidity * d**4 / along**2
    found = [*_of_rod(r, pair, d, along, force), *_of_readings(r, pair, along, force)]
    return [limit for limit in found if limit.bound != (np.inf if limit.upper else 0.0)]


def _of_rod(
    r: Requirements, pair: Pair, d: FloatArray, length: FloatArray, force: FloatArray
) -> Iterator[Limit]:
    """Limits of the material and of the rod's shape; `force` is E·I0/L² (N)."""
    theta, curve = pair.curve.theta, pair.curve
    yield Limit("strain", pair.strain * d / length, r.material.yield_strain / r.safety)
    yield Limit("lock", np.asarray(curve.mu_lock), LOCK_FACTOR * r.mu0[-1], upper=False)
    yield Limit("tip", d / theta, r.tip, Kind.LENGTH, upper=False)
    if r.material.density is not None:
        volume = np.pi / 12.0 * (1.0 + 1.0 / theta + 1.0 / theta**2) * d**2 * length
        normal = np.abs(pair.reactions[:, 1]).min() * force
        yield Limit("weight", r.material.density * GRAVITY * volume / normal, WEIGHT)
    if r.setup.contact is Contact.POINT:
        touch = np.nan_to_num(curve.x0_touch, nan=np.inf) / pair.longest
        yield Limit("touch", touch, BEFORE_TOUCH, upper=False)


def _of_readings(
    r: Requirements, pair: Pair, length: FloatArray, force: FloatArray
) -> Iterator[Limit]:
    """Constraints by the range of the transducer and by its noise."""
    units = {Kind.FORCE: force, Kind.MOMENT: force * length}
    largest = np.abs(pair.reactions).max(axis=0)
    channels = zip(CHANNELS, CHANNEL_KINDS, largest, r.largest, strict=True)
    for name, kind, reaction, most in channels:
        yield Limit(name, reaction * units[kind], r.load * most, kind)
    shortest = np.nan_to_num(pair.x0_slip[0], nan=0.0)
    yield Limit("steps", shortest * length / r.step, r.steps, upper=False)
    resolved = np.linalg.norm(pair.least_slope / r.noise[:2])
    slips = shortest * resolved * force / (np.sqrt(2.0) * JUMP)
    yield Limit("slips", slips, CLEARLY, upper=False)
    yield Limit("spacing", pair.longest * length, r.spacing, Kind.LENGTH)
