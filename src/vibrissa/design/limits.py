"""What limits a rod of given θ and η: power laws in d0 and L.

Strains grow with the size of the rod as d0/L, forces as E·d0⁴/L², moments as E·d0⁴/L. So every
limit is a straight line over the logarithms of d0 and L.
"""

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace

import numpy as np

from vibrissa.design.pairs import Pairs
from vibrissa.design.requirements import Range, Requirements
from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import Contact
from vibrissa.sensor.identification.periods import JUMP
from vibrissa.sensor.identification.recording import FORCES
from vibrissa.sensor.quantities import CHANNEL_KINDS, Kind
from vibrissa.sensor.transducer import CHANNELS

GRAVITY = 9.80665
# Powers of L with which forces and moments grow.
LENGTH_POWERS = {Kind.FORCE: -2, Kind.MOMENT: -1}
# Logarithms beyond this mean that something is zero or infinite.
HUGE = 100.0
# The shortest period must exceed the threshold of a slip by this factor: one slip in 1,000 is
# missed then, and one in two at a factor of 1.
CLEARLY = 1.5
# Error of the smallest eigenvalue: a rod with a smaller one does not count as stable.
STABLE = 1e-4


@dataclass(frozen=True, kw_only=True)
class Bound:
    """What is limited, and how far.

    Attributes
    ----------
    name, meaning : str
    kind : Kind
        What is measured.
    bound : float
    upper : bool
        Whether the bound is the largest value allowed, not the least.
    """

    name: str
    meaning: str
    kind: Kind = Kind.NUMBER
    bound: float
    upper: bool = True


@dataclass(frozen=True, kw_only=True)
class Check(Bound):
    """A limit of one rod: its value, and the part of the limit that is used; violated above 1."""

    value: float
    use: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Limit(Bound):
    """A limit to coefficient·d0^p·L^q, for n pairs (θ, η).

    Attributes
    ----------
    coefficient : ndarray, shape (n,)
    p, q : int
    size : bool
        Whether it is an end of the range of a size, which no rod violates.
    given : bool
        Whether that size is given, so that there is nothing to check.
    room : float
        Factor by which it is relaxed to see whether that would help; 1 if it cannot be relaxed.
    """

    coefficient: FloatArray
    p: int = 0
    q: int = 0
    size: bool = False
    given: bool = False
    room: float = 2.0

    @property
    def restricts(self) -> bool:
        """Whether any value violates it."""
        return self.bound != (np.inf if self.upper else 0.0)

    def relaxed(self, room: float) -> "Limit":
        """Widen it by a factor."""
        return replace(self, bound=self.bound * room if self.upper else self.bound / room)

    def value(self, diameter: FloatArray, length: FloatArray) -> FloatArray:
        """Compute what is limited, for rods of given sizes (m)."""
        return np.asarray(self.coefficient * diameter**self.p * length**self.q)

    def check(self, diameter: FloatArray, length: FloatArray) -> Check:
        """Compare the only pair (θ, η), with sizes of shape (1,), with the bound."""
        value = float(self.value(diameter, length)[0])
        use = value / self.bound
        if not self.upper:
            use = self.bound / value if value > 0.0 else np.inf
        shared = {x.name: getattr(self, x.name) for x in fields(Bound)}
        return Check(**shared, value=value, use=use)

    @property
    def line(self) -> "Line":
        """Logarithm of the part that is used, over ln d0 and ln L."""
        sign = 1 if self.upper else -1
        with np.errstate(divide="ignore"):
            use = sign * (np.log(self.coefficient) - np.log(self.bound))
        return Line(constant=np.clip(use, -HUGE, HUGE), p=sign * self.p, q=sign * self.q)


@dataclass(frozen=True, eq=False, kw_only=True)
class Line:
    """constant + p·ln d0 + q·ln L for n pairs (θ, η), which a limit wants below 0."""

    constant: FloatArray
    p: int
    q: int


def limits_of(requirements: Requirements, pairs: Pairs) -> list[Limit]:
    """Limits that the requirements set to rods of given (θ, η).

    Parameters
    ----------
    requirements : Requirements
    pairs : Pairs

    Returns
    -------
    list of Limit
        Without those that allow everything.
    """
    kinds = (_loads, _periods, _stability, _sizes, _model)
    limits = (limit for kind in kinds for limit in kind(requirements, pairs))
    relaxed = [limit.relaxed(requirements.room.get(limit.name, 1.0)) for limit in limits]
    return [limit for limit in relaxed if limit.restricts]


def _loads(r: Requirements, pairs: Pairs) -> Iterator[Limit]:
    """Limit what the material and the transducer bear."""
    yield Limit(
        name="strain",
        meaning="largest strain; allowed: the yield strain over the safety factor",
        coefficient=pairs.strain,
        p=1,
        q=-1,
        bound=r.yield_strain / r.safety,
    )
    for i, (name, kind) in enumerate(zip(CHANNELS, CHANNEL_KINDS, strict=True)):
        yield Limit(
            name=name,
            meaning=f"largest {kind}; allowed: the range of the transducer",
            coefficient=pairs.largest_reaction[:, i] * r.rigidity,
            p=4,
            q=LENGTH_POWERS[kind],
            bound=r.range[i],
            kind=kind,
        )


def _periods(r: Requirements, pairs: Pairs) -> Iterator[Limit]:
    """Limit periods of sticking to those that can be measured."""
    shortest = np.nan_to_num(pairs.x0_slip[:, 0], nan=0.0)
    yield Limit(
        name="lock",
        meaning="critical friction coefficient; allowed: the largest friction times its factor",
        coefficient=pairs.mu_lock,
        bound=r.lock_factor * r.mu0[1],
        upper=False,
        room=r.lock_factor,
    )
    yield Limit(
        name="steps",
        meaning="steps of the stage in the shortest period",
        coefficient=shortest / r.step,
        q=1,
        bound=r.steps,
        upper=False,
    )
    # The threshold of a slip: so many standard deviations of the difference of two positions.
    yield Limit(
        name="slips",
        meaning="shortest period over the threshold of a slip",
        coefficient=shortest * _resolution(r, pairs) / (np.sqrt(2.0) * JUMP),
        p=4,
        q=LENGTH_POWERS[Kind.FORCE],
        bound=CLEARLY,
        upper=False,
        room=1.0,
    )
    yield Limit(
        name="spacing",
        meaning="largest clamp travel between slips",
        coefficient=pairs.longest,
        q=1,
        bound=r.spacing,
        kind=Kind.LENGTH,
    )


def _resolution(r: Requirements, pairs: Pairs) -> FloatArray:
    """Inverse standard deviation of x0 from one reading of both forces, at d0 = L = 1.

    Where it is least; a slip shows in the forces.
    """
    slope = pairs.least_slope[:, FORCES] * r.rigidity / np.array(r.noise)[FORCES]
    return np.asarray(np.linalg.norm(slope, axis=1))


def _stability(_: Requirements, pairs: Pairs) -> Iterator[Limit]:
    """Limit equilibria to stable ones."""
    yield Limit(
        name="stability",
        meaning="smallest eigenvalue of the second variation",
        coefficient=np.maximum(pairs.stability, 0.0),
        bound=STABLE,
        upper=False,
        room=1.0,
    )


def _sizes(r: Requirements, pairs: Pairs) -> Iterator[Limit]:
    """Limit sizes to what can be made."""
    yield Limit(
        name="tip",
        meaning="diameter of the tip",
        coefficient=1.0 / pairs.theta,
        p=1,
        bound=r.tip,
        kind=Kind.LENGTH,
        upper=False,
    )
    one = np.ones(len(pairs))
    yield from _ends("diameter", r.diameter, "thinnest", "thickest", one, p=1)
    yield from _ends("length", r.length, "shortest", "longest", one, q=1)


def _ends(
    size: str, ends: Range, least: str, most: str, one: FloatArray, **power: int
) -> Iterator[Limit]:
    """Limit a size to its range."""
    low, high = ends
    for name, bound, upper in ((most, high, True), (least, low, False)):
        yield Limit(
            name=name,
            meaning=size,
            coefficient=one,
            bound=bound,
            kind=Kind.LENGTH,
            upper=upper,
            size=True,
            given=low == high,
            **power,
        )


def _model(r: Requirements, pairs: Pairs) -> Iterator[Limit]:
    """Limit rods to those of which the model holds: contact with the tip, no gravity."""
    if r.contact is Contact.POINT:
        yield Limit(
            name="touch",
            meaning="displacement at which more than the tip would touch, over the longest period",
            coefficient=pairs.x0_touch / pairs.longest,
            bound=1.0,
            upper=False,
            room=1.0,
        )
    if r.density is not None:
        # Volume of the rod over d0²·L.
        volume = np.pi / 12.0 * (1.0 + 1.0 / pairs.theta + 1.0 / pairs.theta**2)
        yield Limit(
            name="weight",
            meaning="weight over the least normal force",
            coefficient=r.density * GRAVITY * volume / (pairs.least_normal_force * r.rigidity),
            p=-2,
            q=3,
            bound=r.weight,
        )
