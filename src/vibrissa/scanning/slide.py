"""A slide of the tip in one direction: the forces along it, and where it ends.

The kinetic energy of the tip is the integral over its slide of the tangential force less kinetic
friction.
"""

from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise
from math import comb
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np
from numpy.polynomial.chebyshev import chebpts1

from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.roots import first_fall, first_integral_fall
from vibrissa.outcomes import SlipLaw
from vibrissa.scanning.slip_model import SlipModel
from vibrissa.scanning.stage import Held, Stage
from vibrissa.scanning.surfaces import Surface, rounding_at
from vibrissa.scanning.tip import ContactForces, contact_forces

if TYPE_CHECKING:
    from scipy.interpolate import BPoly

Distance = TypeVar("Distance", float, FloatArray)

# Relative error of a length by rounding.
ROUNDED_PART = 1e-9
# Cells in the first part of a slide in which its end is sought; the next ones end twice as far.
FIRST_CELLS = 20
# No slide is longer (L).
LONGEST_SLIDE = 2.0


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


class SlideEnd(NamedTuple):
    """Where a slide ends.

    Attributes
    ----------
    contact : float
        Position of the tip there (L).
    released, dissipated : float
        Elastic energy that the rod and its mounting lose, and work against kinetic friction
        (E·I0/L); NaN if the tip lifts off, or is lost.
    takes_off : float or None
        Position at which the tip lifts off (L), if it does; then it lands at `contact`.
    lost : Lost or None
        Why the slide is not followed to its end.
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

    @property
    def net(self) -> "BPoly":
        """The driving force less friction, whose integral is the kinetic energy."""
        return _polynomials(self.coefficients[0] - self.coefficients[1], self.breaks)

    @property
    def pull(self) -> "BPoly":
        """The force with which a surface would have to pull the tip: less the normal force."""
        return _polynomials(-self.coefficients[2], self.breaks)

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


class Driven(NamedTuple):
    """Tangential force in the direction of a part of a slide.

    Attributes
    ----------
    least : float
        The smallest force at the beginning of a cell (E·I0/L²).
    work : float
        Its integral over the part (E·I0/L).
    """

    least: float
    work: float


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


# Cells for any force, and short ones for the many pieces of polynomials, by their degree.
CELL, SHORT_CELL, SHORTEST_CELL = Cell.of(1e-3, 6), Cell.of(2e-4, 3), Cell.of(5e-5, 2)


@dataclass(frozen=True, kw_only=True)
class RestingClamp:
    """A rod over a surface, with its clamp at rest: its states over the position of its tip.

    Attributes
    ----------
    stage : Stage
    surface : Surface
    clamp : float
        Position of the clamp along its stage (L).
    side : int
        1 for a tip ahead of the clamp, −1 for a tip behind it.
    """

    stage: Stage
    surface: Surface
    clamp: float = 0.0
    side: int = 1

    def held(self, contact: FloatArray | float) -> Held:
        """Return the states of the rod with the tip at given positions (L)."""
        return self.stage.states(self.clamp, contact, self.side, self.height(contact))

    def height(self, contact: FloatArray | float) -> FloatArray | float:
        """Return the height of the surface at given positions (L), which is 0 on a plane."""
        return 0.0 if self.surface.texture is None else self.surface.height(contact)

    def forces(
        self, contact: FloatArray | float, *slopes: FloatArray | float
    ) -> list[ContactForces]:
        """Resolve the forces on a tip at given positions (L), for each of several slopes."""
        loads = self.held(contact).reactions
        return [contact_forces(loads[..., 0], loads[..., 1], slope) for slope in slopes]


@dataclass(frozen=True, kw_only=True)
class Slide(RestingClamp):
    """A slide of the tip in one direction, while the clamp rests.

    A distance of the slide is measured from its beginning, in its direction.

    Attributes
    ----------
    model : SlipModel
    begin : float
        Position of the tip at which it begins to slide (L).
    direction : int
        1 away from the clamp, as if pushed, or −1 towards it.
    """

    model: SlipModel
    begin: float
    direction: int

    def end(self) -> SlideEnd:
        """Follow the slide to its end.

        Raises
        ------
        ArgumentError
            If the tip reaches an unknown part of the surface.
        """
        forces = None
        for begin, end in pairwise(self._part_ends()):
            part = self._forces_up_to_unknown(begin, end)
            forces = part.forces if forces is None else forces.followed_by(part.forces)
            stop, takes_off = self._stopping_distance(forces), np.nan
            if self.surface.texture is not None:
                takes_off = first_fall(forces.normal)
            if np.isfinite(takes_off) and not stop <= takes_off:
                return self._landing(takes_off)
            if np.isfinite(stop):
                return SlideEnd(
                    self._stopping_place(stop),
                    released=float(forces.driving.integrate(0.0, stop)),
                    dissipated=float(forces.friction.integrate(0.0, stop)),
                )
            if part.lost is not None:
                return SlideEnd(self._place(float(forces.breaks[-1])), lost=part.lost)
        # The surface is not known further on, or the rod has no further states. On heights the
        # parts say where the rod has none.
        plane = self.surface.texture is None
        self.surface.check_known(self._place(self._longest() if plane else LONGEST_SLIDE))
        return SlideEnd(self._place(end), lost=Lost.BENT)

    def driven(self, distance: float) -> Driven:
        """Tangential force in the direction of a slide on a plane, over its first part.

        Parameters
        ----------
        distance : float
            Length of the part, positive (L).
        """
        forces = self._forces_between(self._breaks(0.0, distance)).forces
        # The first coefficient of a Bernstein polynomial is its value at the beginning of its cell,
        # and their mean is the mean of the polynomial.
        driving = forces.coefficients[0]
        work = np.diff(forces.breaks) @ driving.mean(axis=0)
        return Driven(least=float(driving[0].min()), work=float(work))

    @property
    def _onward(self) -> int:
        """Direction along the surface: 1 towards larger positions."""
        return self.side * self.direction

    def _place(self, distance: Distance) -> Distance:
        """Position of the tip after a distance (L)."""
        return self.begin + self._onward * distance

    @property
    def _cell(self) -> Cell:
        texture = self.surface.texture
        if texture is None or texture.degree > 3:
            return CELL
        # Pieces that are longer have few nodes anyhow.
        return SHORT_CELL if texture.degree > 1 else SHORTEST_CELL

    def _stopping_distance(self, forces: _Forces) -> float:
        """Distance at which the law ends the slide; NaN if it does not end it yet (L)."""
        if self.model.law is SlipLaw.FREE:
            return first_fall(forces.driving)
        return first_integral_fall(forces.net, part=self.model.loss)

    def _landing(self, takes_off: float) -> SlideEnd:
        """Find the next place at which the surface pushes a tip that lifts off at a distance."""
        begin, off = takes_off, self._place(takes_off)
        for end in self._part_ends():
            if end <= begin:
                continue
            part = self._forces_up_to_unknown(begin, end)
            lands = first_fall(part.forces.pull)
            if np.isfinite(lands):
                return SlideEnd(self._stopping_place(lands), takes_off=off)
            if part.lost is not None:
                break
            begin = end
        return SlideEnd(off, lost=Lost.LIFTS)

    def _longest(self) -> float:
        """Longest slide within the computed states on a plane (L)."""
        return float(self._bending_left(self.held(self.begin)))

    def _part_ends(self) -> FloatArray:
        """Return the ends of the parts in which the end of the slide is sought in turn (L)."""
        end = self.surface.stop if self._onward > 0 else self.surface.start
        known = max(abs(end - self.begin), rounding_at(self.begin))
        if self.surface.texture is None:
            known = min(self._longest(), known)
        first, longest = FIRST_CELLS * self._cell.longest, min(known, LONGEST_SLIDE)
        ends = first * 2.0 ** np.arange(np.ceil(np.log2(LONGEST_SLIDE / first)))
        return np.concatenate([[0.0], ends[ends < longest], [longest]])

    def _breaks(self, begin: float, end: float) -> FloatArray:
        """Distances that divide a part of the slide into cells (L)."""
        onward, surface = self._onward, self.surface
        cell = min(self._cell.longest, surface.feature)
        if surface.texture is None:
            states, x0 = self.held(self.begin)
            kinks = self.direction * (x0 - states.bounds)
        else:
            between = sorted((self._place(begin), self._place(end)))
            kinks = onward * (surface.texture.breaks(*between) - self.begin)
        edges = onward * (surface.edges - self.begin)
        breaks = np.unique(np.concatenate([kinks, edges, [begin, end]]))
        return _divided(breaks[(breaks >= begin) & (breaks <= end)], cell)

    def _forces_up_to_unknown(self, begin: float, end: float) -> _Part:
        """Compute the forces along a part of the slide, as far as the rod has computed states."""
        breaks = self._breaks(begin, end)
        part = self._forces_between(breaks)
        # The ends of cells are not further from the states in the cells than a cell is long.
        if self.surface.texture is None or part.room > self._cell.longest:
            return part
        breaks, lost = self._cut_at_unknown(breaks)
        return self._forces_between(breaks)._replace(lost=lost)

    def _cut_at_unknown(self, breaks: FloatArray) -> tuple[FloatArray, Lost | None]:
        """Cut a part of the slide where the rod has no computed states; say why, if it is cut."""
        from scipy.optimize import brentq  # a tenth of a second to load

        def rooms(distance: FloatArray | float) -> FloatArray:
            return self._rooms(self._place(np.asarray(distance)))

        left = rooms(breaks)
        out = np.flatnonzero((left[:, 1:] <= 0.0).any(axis=0))
        if not len(out):
            return breaks, None
        last = int(out[0])
        row = int(np.argmin(left[:, last + 1]))
        if left[row, last] <= 0.0:
            end = float(breaks[last]) + rounding_at(self.begin)
        else:
            end = float(
                brentq(lambda distance: float(rooms(distance)[row]), *breaks[last : last + 2])
            )
        kept = breaks[: last + 1]
        return np.append(kept[kept < end], end), (Lost.BENT, Lost.DEEP)[row]

    def _rooms(self, place: FloatArray) -> FloatArray:
        """How far states are from the last computed x0 and from the last distance (L)."""
        left = self._bending_left(self.held(place))
        return np.array([left, self.stage.room(self.clamp, self.height(place))])

    def _bending_left(self, held: Held) -> FloatArray:
        """How far states are from the last computed x0 in the direction of the slide (L)."""
        states, x0 = held
        return np.asarray(x0 - states.x0_pull if self.direction > 0 else states.x0_end - x0)

    def _forces_between(self, breaks: FloatArray) -> _Part:
        """Compute the forces along a part of the slide."""
        cell, plane = self._cell, self.surface.texture is None
        place = self._place(breaks[:-1, None] + np.diff(breaks)[:, None] * cell.nodes)
        slope = 0.0 if plane else self.side * self.surface.slope(place)
        (on_surface,) = self.forces(place, slope)
        friction = self.model.kinetic_ratio * self.surface(place) * on_surface.normal
        driving = -self.direction * on_surface.tangential
        values = np.array([driving, friction, on_surface.normal])
        forces = _Forces(breaks, cell.coefficients @ values.transpose(0, 2, 1))
        return _Part(forces=forces, room=np.inf if plane else float(self._rooms(place).min()))

    def _stopping_place(self, distance: float) -> float:
        """Position of a tip that stops: in the corner where it does, or a little further on."""
        tiny, place = rounding_at(self.begin), self._place(distance)
        if self.surface.texture is not None:
            corners = self.surface.texture.breaks(place - 2.0 * tiny, place + 2.0 * tiny)
            if len(corners):
                return float(corners[np.argmin(np.abs(corners - place))])
        # At the edge of a patch a tip stops on the rougher side.
        return float(place + self._onward * 2.0 * tiny)


def _divided(breaks: FloatArray, longest: float) -> FloatArray:
    """Divide the cells between increasing positions equally until none is too long (L)."""
    width = np.diff(breaks)
    if width.max(initial=0.0) * (1.0 - ROUNDED_PART) <= longest:
        return breaks
    counts = np.maximum(np.ceil(width / longest * (1.0 - ROUNDED_PART)), 1.0).astype(np.int64)
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.append(
        np.repeat(breaks[:-1], counts) + within * np.repeat(width / counts, counts), breaks[-1]
    )
