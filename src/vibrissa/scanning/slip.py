"""Where a slip of the tip ends.

While the tip slips, the clamp rests, and the tip moves along the surface. The kinetic energy is the
integral over its way of the tangential force less kinetic friction.
"""

from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise
from math import comb
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np
from numpy.polynomial.chebyshev import chebpts1

from vibrissa.errors import ArgumentError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.roots import first_fall, first_integral_fall
from vibrissa.outcomes import SlipLaw as SlipLaw
from vibrissa.outcomes import chosen
from vibrissa.scanning.stage import Held, Stage
from vibrissa.scanning.surfaces import Footing, Surface, nothing
from vibrissa.scanning.tip import ContactForces, contact_forces

if TYPE_CHECKING:
    from scipy.interpolate import BPoly

# Relative excess of |tan α| over μ0 at which a tip still sticks, for rounding.
FULL = 1e-9
# Largest number of slides in a slip: a tip that stops where it cannot stick slides back, less far.
REVERSALS = 100
# Ends of the parts of a slide in which its end is sought, one after the other (L): a slide is
# shorter than two rods.
SOUGHT = (0.0, 0.005, 0.01, 0.02, 0.03, 0.04, 0.06, 0.08, 0.12, 0.16, 0.25, 0.4, 0.6, 1.0, 2.0)
# Longer ones on a plane, where a long part takes hardly more time than a short one.
SOUGHT_ON_PLANE = (0.0, 0.03, 0.12, 0.4, 2.0)


class Lost(StrEnum):
    """Why a slip is not followed to its end.

    Attributes
    ----------
    LIFTS
        The tip lifts off the surface, and nowhere further on the surface would push it.
    BENT
        The tip comes to the last computed state of the rod.
    DEEP
        The surface leaves the distances from the clamp at which the rod is solved.
    """

    LIFTS = "lifts"
    BENT = "bent"
    DEEP = "deep"


class Flight(NamedTuple):
    """A part of a slip in which the tip does not touch: where it takes off and lands (L)."""

    takes_off: float
    lands: float


class SlipEnd(NamedTuple):
    """Where a slip ends.

    Attributes
    ----------
    contact, x0 : float
        Position of the tip, and displacement from the α = 0 state (L); if the slip is lost, those
        at which it is.
    released : float
        Elastic energy that the rod and its mounting lose: the work of the tangential force
        (E·I0/L). NaN if the slip is lost, or the tip flies in it.
    dissipated : float
        Work against kinetic friction (E·I0/L). NaN also under the law ``free``, which has no
        kinetic friction. What is released and not dissipated is the loss of the rod's vibration.
    lost : Lost or None
        None if the tip comes to rest.
    flights : tuple of Flight
        Parts in which the tip does not touch. A tip that lifts off is taken to land at the next
        place at which the surface pushes it, and to slip on from there without velocity.
    """

    contact: float
    x0: float
    released: float = np.nan
    dissipated: float = np.nan
    lost: Lost | None = None
    flights: tuple[Flight, ...] = ()


class _Slide(NamedTuple):
    """A slide in one direction: where it ends, its energies, and whether it is lost.

    `takes_off` is where the tip lifted off; then it landed at `contact`.
    """

    contact: float
    released: float = np.nan
    dissipated: float = np.nan
    takes_off: float | None = None
    lost: Lost | None = None


class _Forces(NamedTuple):
    """Forces along a part of a slide, times 1/cos γ, as functions of its distance (E·I0/L²).

    Attributes
    ----------
    breaks : ndarray, shape (cells + 1,)
        Distances that divide the part into cells (L).
    coefficients : ndarray, shape (3, n, cells)
        Bernstein coefficients of `driving`, `friction` and `normal` in each cell.
    """

    breaks: FloatArray
    coefficients: FloatArray

    @property
    def driving(self) -> "BPoly":
        """The tangential force in the direction of the slide."""
        return _polynomials(self.coefficients[0], self.breaks)

    @property
    def friction(self) -> "BPoly":
        """The kinetic friction that opposes the slide."""
        return _polynomials(self.coefficients[1], self.breaks)

    @property
    def normal(self) -> "BPoly":
        """The normal force."""
        return _polynomials(self.coefficients[2], self.breaks)

    def followed_by(self, others: "_Forces") -> "_Forces":
        """Append the forces along the next part of the slide."""
        return _Forces(
            breaks=np.append(self.breaks, others.breaks[1:]),
            coefficients=np.concatenate([self.coefficients, others.coefficients], axis=2),
        )


def _polynomials(coefficients: FloatArray, breaks: FloatArray) -> "BPoly":
    """Make polynomials between breaks from their Bernstein coefficients, a column for each."""
    from scipy.interpolate import BPoly  # takes longer to load than a scan on a plane

    # Without the constructor's checks, which take as long as the forces.
    return BPoly.construct_fast(coefficients, breaks)


class _Part(NamedTuple):
    """A part of a slide.

    `room` is the least distance of its states from the last computed states (L). `lost` is why the
    part ends before its end, or None.
    """

    forces: _Forces
    room: float
    lost: Lost | None = None


class Cell(NamedTuple):
    """How the force is computed in a cell of a slide.

    Attributes
    ----------
    longest : float
        Length of the longest cell (L).
    nodes : ndarray, shape (n,)
        Places in a cell, as parts of it, at which the force is computed: not its ends, where
        friction may jump.
    coefficients : ndarray, shape (n, n)
        Times the values there, they are the coefficients of Bernstein polynomials.
    """

    longest: float
    nodes: FloatArray
    coefficients: FloatArray

    @classmethod
    def of(cls, longest: float, degree: int) -> "Cell":
        """Cell in which the force is a polynomial of the given degree."""
        nodes = 0.5 + 0.5 * chebpts1(degree + 1)
        k, t = np.arange(degree + 1), nodes[:, None]
        binomials = np.array([comb(degree, one) for one in k], dtype=np.float64)
        powers = binomials * t**k * (1.0 - t) ** (degree - k)
        return cls(longest, nodes, np.asarray(np.linalg.inv(powers)))


# Number of places at which a state with α = 0 is sought before a free slip on a plane.
LOOKS = 257
# Cells for any force, and short ones for the many pieces of polynomials, by their degree.
CELL, SHORT_CELL, SHORTEST_CELL = Cell.of(1e-3, 6), Cell.of(2e-4, 3), Cell.of(5e-5, 2)


@dataclass(frozen=True, kw_only=True)
class SlipModel:
    """A slip law, with the values that it needs.

    Attributes
    ----------
    law : SlipLaw
    kinetic_ratio : float
        Kinetic over static friction μk/μ0, above 0 and at most 1; the law ``free`` has none.
    damping : float or None
        Damping ratio ζ of the rod, from 0: the law ``damped`` needs it, and no other law has it.

    Raises
    ------
    ArgumentError
        If a value is out of range, or the law lacks what it needs.
    """

    law: SlipLaw = SlipLaw.FREE
    kinetic_ratio: float = 0.8
    damping: float | None = None

    def __post_init__(self) -> None:
        """Check all values."""
        if not 0.0 < self.kinetic_ratio <= 1.0:
            raise ArgumentError(
                f"kinetic_ratio must be above 0 and at most 1, got {self.kinetic_ratio!r}"
            )
        if self.law is not SlipLaw.DAMPED:
            if self.damping is not None:
                raise ArgumentError(
                    f"the law '{self.law}' has no damping: remove damping, or take the law 'damped'"
                )
        elif self.damping is None:
            raise ArgumentError("the law 'damped' needs damping, the damping ratio of the rod")
        elif not 0.0 <= self.damping < np.inf:
            raise ArgumentError(f"damping must be a number from 0, got {self.damping!r}")

    @classmethod
    def of(
        cls, law: SlipLaw | str, kinetic_ratio: float = 0.8, damping: float | None = None
    ) -> Self:
        """Make the model of a law that is given by its name; see `SlipModel`."""
        return cls(law=chosen(SlipLaw, law, "law"), kinetic_ratio=kinetic_ratio, damping=damping)

    @property
    def loss(self) -> float:
        """Part of the largest kinetic energy that the rod's vibration loses by its damping.

        A damped vibration keeps the part e^(−2πζ) of its energy in half a wave. A slip that inertia
        plays no part in loses all of its kinetic energy, and one by the law ``energy`` nothing.
        """
        if self.damping is not None:
            return float(-np.expm1(-2.0 * np.pi * self.damping))
        return 0.0 if self.law is SlipLaw.ENERGY else 1.0


FREE_SLIP = SlipModel()


@dataclass(frozen=True, kw_only=True)
class Slip:
    """A slip of the tip, during which the clamp rests.

    Attributes
    ----------
    stage : Stage
    surface : Surface
    model : SlipModel
    clamp : float
        Position of the clamp along its stage (L).
    side : int
        1 for a tip ahead of the clamp, −1 for a tip behind it.
    """

    stage: Stage
    surface: Surface
    model: SlipModel
    clamp: float = 0.0
    side: int = 1

    def follow(self, contact: float) -> SlipEnd:
        """Follow a tip that begins to slip until it comes to rest, or is lost.

        Parameters
        ----------
        contact : float
            Position at which the tip has stuck (L).

        Raises
        ------
        ArgumentError
            If the tip reaches an unknown part of the surface, or slides to and fro for too long.
        """
        contact = self._within(contact)
        if self.model.law is SlipLaw.FREE and self._returns(contact):
            states, begin = self._held(contact)
            end = states.contact(float(self.stage.along(self.clamp)), 0.0, self.side)
            return SlipEnd(contact=end, x0=0.0, released=self._released(contact, float(begin)))
        released, dissipated = 0.0, 0.0
        flights: tuple[Flight, ...] = ()
        for _ in range(REVERSALS):
            slide = self._slide(contact, self._way(contact))
            contact, x0 = slide.contact, float(self._held(slide.contact).x0)
            if slide.lost is not None:
                return SlipEnd(contact=contact, x0=x0, lost=slide.lost, flights=flights)
            released, dissipated = released + slide.released, dissipated + slide.dissipated
            if slide.takes_off is not None:
                flights = (*flights, Flight(takes_off=slide.takes_off, lands=contact))
            if self._settled(contact, slide):
                if self.model.law is SlipLaw.FREE:
                    dissipated = np.nan
                return SlipEnd(
                    contact=contact,
                    x0=x0,
                    released=released,
                    dissipated=dissipated,
                    flights=flights,
                )
        place = f"the clamp at {self.surface.spell(self.clamp)}"
        raise ArgumentError(f"with {place} a slip has over {REVERSALS} slides: take another law")

    def _returns(self, contact: float) -> bool:
        """Whether a free slip on a plane ends in the state x0 = 0.

        A pushed tip that was pushed back before meets another state with α = 0 on its way.
        """
        if self.surface.texture is not None:
            return False
        states, x0 = self._held(contact)
        between = states.demand(np.linspace(0.0, float(x0), LOOKS)[1:])
        return not (x0 > 0.0 and between.min() < 0.0)

    def _released(self, contact: float, x0: float) -> float:
        """Elastic energy that is released on the way to the state x0 = 0 on a plane (E·I0/L)."""
        if x0 == 0.0:
            return 0.0
        way = 1 if x0 > 0.0 else -1
        breaks = np.unique(np.append(0.0, self._breaks(contact, way, 0.0, abs(x0))))
        forces = self._balance(contact, way, breaks).forces
        return float(forces.driving.integrate(0.0, abs(x0)))

    @property
    def _cell(self) -> Cell:
        texture = self.surface.texture
        if texture is None or texture.degree > 3:
            return CELL
        # Pieces that are longer have few nodes anyhow.
        return SHORT_CELL if texture.degree > 1 else SHORTEST_CELL

    def _held(self, contact: FloatArray | float) -> Held:
        """Return the states of the rod with the tip at given positions (L)."""
        height = 0.0 if self.surface.texture is None else self.surface.height(contact)
        return self.stage.states(self.clamp, contact, self.side, height)

    def _forces(
        self, contact: FloatArray | float, *slopes: FloatArray | float
    ) -> list[ContactForces]:
        """Resolve the forces on a tip at given positions (L), for each of several slopes."""
        loads = self._held(contact).reactions
        return [contact_forces(loads[..., 0], loads[..., 1], slope) for slope in slopes]

    def _within(self, contact: float) -> float:
        """Move a tip that a long step has taken out of the computed states to the last of them."""
        for _ in range(REVERSALS):
            states, x0 = self._held(contact)
            beyond = float(x0 - states.clip(x0))
            if beyond == 0.0:
                break
            contact += self.side * beyond
        return contact

    def _excesses(self, footing: Footing) -> tuple[float, float]:
        """By how much friction is exceeded forward and backward, up to rounding (E·I0/L²)."""
        ahead, behind = footing.ahead, footing.behind
        on_ahead, on_behind = self._forces(footing.contact, ahead.slope, behind.slope)
        forward = -on_ahead.tangential - ahead.mu0 * (1.0 + FULL) * on_ahead.normal
        backward = on_behind.tangential - behind.mu0 * (1.0 + FULL) * on_behind.normal
        return float(forward), float(backward)

    def _way(self, contact: float) -> int:
        """Direction in which the tip slides: 1 away from the clamp, as if pushed, or −1."""
        forward, backward = self._excesses(self.surface.footing(contact, self.side))
        return 1 if forward >= backward else -1

    def _settled(self, contact: float, slide: _Slide) -> bool:
        """Whether a tip at the end of a slide remains there."""
        if self.model.law is SlipLaw.FREE and slide.takes_off is None:
            return True
        footing = self.surface.footing(contact, self.side)
        if self.model.law is SlipLaw.FREE:
            # It rests after its flight in a corner, between two faces of which each pushes it back.
            slopes = footing.ahead.slope, footing.behind.slope
            ahead, behind = self._forces(contact, *slopes)
            return float(behind.tangential) <= 0.0 <= float(ahead.tangential)
        return max(self._excesses(footing)) <= 0.0

    def _slide(self, contact: float, way: int) -> _Slide:
        """Follow a slide in one direction to its end."""
        onward, forces = self.side * way, None
        for begin, end in pairwise(self._sought(contact, way)):
            part = self._followed(contact, way, begin, end)
            forces = part.forces if forces is None else forces.followed_by(part.forces)
            stop, takes_off = self._stopping_distance(forces), np.nan
            if self.surface.texture is not None:
                takes_off = first_fall(forces.normal)
            if np.isfinite(takes_off) and not stop <= takes_off:
                return self._landing(contact, way, takes_off)
            if np.isfinite(stop):
                return _Slide(
                    self._stopping_place(contact, onward, stop),
                    released=float(forces.driving.integrate(0.0, stop)),
                    dissipated=float(forces.friction.integrate(0.0, stop)),
                )
            if part.lost is not None:
                return _Slide(contact + onward * float(forces.breaks[-1]), lost=part.lost)
        # The surface is not known further on, or the rod has no further states.
        self.surface.check_known(contact + onward * self._longest(contact, way))
        return _Slide(contact + onward * end, lost=Lost.BENT)

    def _stopping_distance(self, forces: _Forces) -> float:
        """Distance at which the law ends a slide; NaN if it does not end it yet (L)."""
        if self.model.law is SlipLaw.FREE:
            return first_fall(forces.driving)
        # The integral of the driving force less friction is the kinetic energy.
        net_force = _polynomials(forces.coefficients[0] - forces.coefficients[1], forces.breaks)
        return first_integral_fall(net_force, part=self.model.loss)

    def _landing(self, contact: float, way: int, takes_off: float) -> _Slide:
        """Find the next place at which the surface pushes a tip that lifts off in a slide."""
        onward, begin = self.side * way, takes_off
        off = contact + onward * takes_off
        for end in self._sought(contact, way):
            if end <= begin:
                continue
            part = self._followed(contact, way, begin, end)
            breaks, coefficients = part.forces
            lands = first_fall(_polynomials(-coefficients[2], breaks))
            if np.isfinite(lands):
                return _Slide(self._stopping_place(contact, onward, lands), takes_off=off)
            if part.lost is not None:
                break
            begin = end
        return _Slide(off, lost=Lost.LIFTS)

    def _longest(self, contact: float, way: int) -> float:
        """Longest slide within the computed states on a plane (L)."""
        states, x0 = self._held(contact)
        return float(x0 - states.x0_pull if way > 0 else states.x0_end - x0)

    def _sought(self, contact: float, way: int) -> FloatArray:
        """Return the ends of the parts in which the end of a slide is sought in turn (L)."""
        end = self.surface.stop if self.side * way > 0 else self.surface.start
        known = max(abs(end - contact), nothing(contact))
        ends = np.array(SOUGHT)
        if self.surface.texture is None:
            known, ends = min(self._longest(contact, way), known), np.array(SOUGHT_ON_PLANE)
        return np.append(ends[ends < known], known) if known < ends[-1] else ends

    def _breaks(self, contact: float, way: int, begin: float, end: float) -> FloatArray:
        """Distances from a position that divide a part of a slide into cells (L)."""
        onward, surface = self.side * way, self.surface
        cell = min(self._cell.longest, surface.feature)
        if surface.texture is None:
            states, x0 = self._held(contact)
            kinks = way * (x0 - states.bounds)
        else:
            between = sorted((contact + onward * begin, contact + onward * end))
            kinks = onward * (surface.texture.breaks(*between) - contact)
        edges = onward * (surface.edges - contact)
        breaks = np.unique(np.concatenate([kinks, edges, [begin, end]]))
        return _divided(breaks[(breaks >= begin) & (breaks <= end)], cell)

    def _followed(self, contact: float, way: int, begin: float, end: float) -> _Part:
        """Compute the forces along a part of a slide, as far as the rod has computed states."""
        breaks = self._breaks(contact, way, begin, end)
        part = self._balance(contact, way, breaks)
        # The ends of cells are not further from the states in the cells than a cell is long.
        if self.surface.texture is None or part.room > self._cell.longest:
            return part
        breaks, lost = self._computed(contact, way, breaks)
        return self._balance(contact, way, breaks)._replace(lost=lost)

    def _computed(
        self, contact: float, way: int, breaks: FloatArray
    ) -> tuple[FloatArray, Lost | None]:
        """Cut a part of a slide where the rod has no computed states; say why, if it is cut."""
        from scipy.optimize import brentq  # a tenth of a second to load

        def rooms(distance: FloatArray | float) -> FloatArray:
            place = contact + self.side * way * np.asarray(distance)
            return self._rooms(self._held(place), self.surface.height(place), way)

        left = rooms(breaks)
        out = np.flatnonzero((left[:, 1:] <= 0.0).any(axis=0))
        if not len(out):
            return breaks, None
        last = int(out[0])
        row = int(np.argmin(left[:, last + 1]))
        if left[row, last] <= 0.0:
            end = float(breaks[last]) + nothing(contact)
        else:
            end = float(
                brentq(lambda distance: float(rooms(distance)[row]), *breaks[last : last + 2])
            )
        kept = breaks[: last + 1]
        return np.append(kept[kept < end], end), (Lost.BENT, Lost.DEEP)[row]

    def _rooms(self, held: Held, height: FloatArray, way: int) -> FloatArray:
        """How far states are from the last computed x0 and from the last distance (L)."""
        states, x0 = held
        room = x0 - states.x0_pull if way > 0 else states.x0_end - x0
        return np.array([room, self.stage.reach(self.clamp, height)])

    def _balance(self, contact: float, way: int, breaks: FloatArray) -> _Part:
        """Compute the forces along a part of a slide."""
        surface, cell = self.surface, self._cell
        place = breaks[:-1, None] + np.diff(breaks)[:, None] * cell.nodes
        place = contact + self.side * way * place
        plane = surface.texture is None
        height = 0.0 if plane else surface.height(place)
        held = self.stage.states(self.clamp, place, self.side, height)
        slope = 0.0 if plane else self.side * surface.slope(place)
        loads = held.reactions
        tangential, normal = contact_forces(loads[..., 0], loads[..., 1], slope)
        friction = self.model.kinetic_ratio * surface(place) * normal
        values = np.array([-way * tangential, friction, normal])
        forces = _Forces(breaks, cell.coefficients @ values.transpose(0, 2, 1))
        room = np.inf if plane else float(self._rooms(held, np.asarray(height), way).min())
        return _Part(forces=forces, room=room)

    def _stopping_place(self, contact: float, onward: int, distance: float) -> float:
        """Position of a tip that stops: in the corner where it does, or a little further on."""
        tiny, place = nothing(contact), contact + onward * distance
        if self.surface.texture is not None:
            corners = self.surface.texture.breaks(place - 2.0 * tiny, place + 2.0 * tiny)
            if len(corners):
                return float(corners[np.argmin(np.abs(corners - place))])
        # At the edge of a patch a tip stops on the rougher side.
        return float(place + onward * 2.0 * tiny)


def _divided(breaks: FloatArray, longest: float) -> FloatArray:
    """Divide the cells between increasing positions equally until none is too long (L)."""
    width = np.diff(breaks)
    if width.max(initial=0.0) * (1.0 - FULL) <= longest:
        return breaks
    counts = np.maximum(np.ceil(width / longest * (1.0 - FULL)), 1.0).astype(np.int64)
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.append(
        np.repeat(breaks[:-1], counts) + within * np.repeat(width / counts, counts), breaks[-1]
    )
