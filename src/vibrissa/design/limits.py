"""What limits a rod: each constraint as a value and a bound, for many rods at once.

Strains grow with the size of the rod as d0/L, forces as E·d0⁴/L², moments as E·d0⁴/L.
"""

from dataclasses import dataclass, replace

import numpy as np

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
# Error of the smallest eigenvalue: a rod with a smaller one does not count as stable.
STABLE = 1e-4


@dataclass(frozen=True, eq=False)
class Limit:
    """A constraint on one rod or on many.

    Attributes
    ----------
    name, meaning : str
    value : ndarray
        What is limited.
    bound : float
    kind : Kind
        What is measured.
    upper : bool
        Whether the bound is the largest value allowed, not the least.
    """

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

    def at(self, rod: tuple[np.intp, ...], shape: tuple[int, ...]) -> "Limit":
        """Take the constraint on one rod of many."""
        return replace(self, value=np.broadcast_to(self.value, shape)[rod])


def limits_of(
    r: Requirements, pairs: Pairs, diameter: FloatArray, length: FloatArray
) -> list[Limit]:
    """Constraints on rods of n pairs (θ, η) with all sizes.

    Parameters
    ----------
    r : Requirements
    pairs : Pairs
    diameter, length : ndarray
        Sizes (m); shape (d,) and (l,).

    Returns
    -------
    list of Limit
        With values that broadcast to (n, d, l); without those that allow everything.
    """

    def of(values: FloatArray) -> FloatArray:
        return np.asarray(values[:, None, None])

    d, length = diameter[:, None], length[None, :]
    theta, shortest = of(pairs.theta), of(np.nan_to_num(pairs.x0_slip[:, 0], nan=0.0))
    force = r.rigidity * d**4 / length**2
    units = {Kind.FORCE: force, Kind.MOMENT: force * length}
    volume = np.pi / 12.0 * (1.0 + 1.0 / theta + 1.0 / theta**2) * d**2 * length
    weight = (r.density or 0.0) * GRAVITY * volume / (of(pairs.least_normal_force) * force)
    resolved = np.linalg.norm(pairs.least_slope / np.array(r.noise[:2]), axis=1)
    slips = shortest * of(resolved) * force / (np.sqrt(2.0) * JUMP)
    touch = of(pairs.x0_touch / pairs.longest)
    stable = of(np.maximum(pairs.stability, 0.0))
    steps = shortest * length / r.step
    spacing = of(pairs.longest) * length
    strain = of(pairs.strain) * d / length
    number, size = Kind.NUMBER, Kind.LENGTH
    channels = [
        Limit(name, f"largest {kind}", of(largest) * units[kind], r.load * most, kind)
        for name, kind, largest, most in zip(
            CHANNELS, CHANNEL_KINDS, pairs.largest_reaction.T, r.range, strict=True
        )
    ]
    found = [
        Limit("strain", "largest strain of a period", strain, r.yield_strain / r.safety),
        *channels,
        Limit("lock", "mu_lock", of(pairs.mu_lock), r.lock_factor * r.mu0[-1], number, False),
        Limit("steps", "steps of the shortest period", steps, r.steps, number, False),
        Limit("slips", "shortest period over a noticed slip", slips, CLEARLY, number, False),
        Limit("spacing", "largest clamp travel between slips", spacing, r.spacing, size),
        Limit("tip", "diameter of the tip", d / theta, r.tip, size, False),
        Limit("stability", "smallest eigenvalue of a period", stable, STABLE, number, False),
    ]
    if r.density is not None:
        found.append(Limit("weight", "weight over the least normal force", weight, r.weight))
    if r.contact is Contact.POINT:
        what = "displacement at which more than the tip touches, over the longest period"
        found.append(Limit("touch", what, touch, 1.0, number, False))
    return [limit for limit in found if limit.bound != (np.inf if limit.upper else 0.0)]
