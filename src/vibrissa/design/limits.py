"""Constraints on rods, each as a value and a bound, for many rods at once.

Strains grow with the size of the rod as d0/L, forces as E·d0⁴/L², moments as E·d0⁴/L.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from vibrissa.design.choices import Choice
from vibrissa.design.pairs import Pairs
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
# Within its default tolerance, 0.02/L, a natural curvature brings the touch nearer by up to 9 %.
BEFORE_TOUCH = 1.1


@dataclass(frozen=True, eq=False)
class Limit:
    """A constraint on one rod or on many, with an upper or a lower bound."""

    name: str
    meaning: str
    value: FloatArray
    bound: float
    kind: Kind = Kind.NUMBER
    upper: bool = True

    @property
    def use(self) -> FloatArray:
        """Part of the limit that is used; violated above 1."""
        with np.errstate(divide="ignore"):
            return np.asarray(self.value / self.bound if self.upper else self.bound / self.value)


def limits_of(r: Requirements, pairs: Pairs, diameter: Choice, length: Choice) -> list[Limit]:
    """List the constraints on rods of n pairs (θ, η) with d diameters and l lengths (m).

    Values broadcast to (n, d, l); constraints that allow everything are left out.
    """
    d, along = np.array(diameter)[:, None], np.array(length)
    force = r.rigidity * d**4 / along**2
    found = [*_of_rod(r, pairs, d, along, force), *_of_readings(r, pairs, along, force)]
    return [limit for limit in found if limit.bound != (np.inf if limit.upper else 0.0)]


def _column(values: FloatArray) -> FloatArray:
    """Put values of pairs where they broadcast to all rods."""
    return np.asarray(values[:, None, None])


def _of_rod(
    r: Requirements, pairs: Pairs, d: FloatArray, length: FloatArray, force: FloatArray
) -> Iterator[Limit]:
    """Limits of the material and of the rod's shape; `force` is E·I0/L² (N)."""
    theta = _column(pairs.theta)
    strain = _column(pairs.strain) * d / length
    most = r.material.yield_strain / r.safety
    yield Limit("strain", "largest strain of a period", strain, most)
    lock = r.lock_factor * r.mu0[-1]
    yield Limit("lock", "mu_lock", _column(pairs.mu_lock), lock, upper=False)
    yield Limit("tip", "diameter of the tip", d / theta, r.tip, Kind.LENGTH, upper=False)
    if r.material.density is not None:
        volume = np.pi / 12.0 * (1.0 + 1.0 / theta + 1.0 / theta**2) * d**2 * length
        normal = _column(pairs.least_normal_force) * force
        weight = r.material.density * GRAVITY * volume / normal
        yield Limit("weight", "weight over the least normal force", weight, r.weight)
    if r.setup.contact is Contact.POINT:
        what = "displacement at which more than the tip touches, over the longest period"
        touch = _column(pairs.x0_touch / pairs.longest)
        yield Limit("touch", what, touch, BEFORE_TOUCH, upper=False)


def _of_readings(
    r: Requirements, pairs: Pairs, length: FloatArray, force: FloatArray
) -> Iterator[Limit]:
    """Constraints by the range of the transducer and by its noise."""
    units = {Kind.FORCE: force, Kind.MOMENT: force * length}
    channels = zip(CHANNELS, CHANNEL_KINDS, pairs.largest_reaction.T, r.largest, strict=True)
    for name, kind, reaction, most in channels:
        value = _column(reaction) * units[kind]
        yield Limit(name, f"largest {kind}", value, r.load * most, kind)
    shortest = _column(np.nan_to_num(pairs.x0_slip[:, 0], nan=0.0))
    steps = shortest * length / r.step
    yield Limit("steps", "steps of the shortest period", steps, r.steps, upper=False)
    resolved = np.linalg.norm(pairs.least_slope / np.array(r.noise[:2]), axis=1)
    slips = shortest * _column(resolved) * force / (np.sqrt(2.0) * JUMP)
    yield Limit("slips", "shortest period over a noticed slip", slips, CLEARLY, upper=False)
    spacing = _column(pairs.longest) * length
    what = "largest clamp travel between slips"
    yield Limit("spacing", what, spacing, r.spacing, Kind.LENGTH)
