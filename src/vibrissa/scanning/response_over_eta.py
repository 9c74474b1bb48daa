"""The response of one rod at any clamp–surface distance η of a range, interpolated over η.

The range is divided into parts, and the rod is solved at a few distances in each. Landmarks (end of
pulling, kinks, α = 0, lock, end of pushing) divide x0 into smooth stretches. In each part of the
range, a quantity at a given fraction of a stretch is a polynomial in η, whose coefficients are
splines of the fraction.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.errors import NoResponseError
from vibrissa.mechanics.equations import OFFSET, ClosingCondition, shape
from vibrissa.mechanics.newton import solve
from vibrissa.mechanics.shape import Shape
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.numerics.spectral import (
    chebyshev_nodes,
    chebyshev_polynomials,
    chebyshev_transform,
)
from vibrissa.outcomes import RodSection
from vibrissa.scanning.response import LOADS, Response, States, responses
from vibrissa.scanning.rods import MountedRod
from vibrissa.sticking.piece import StickingState

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

# Number of distances at which the rod is solved in a part, and in a slim part.
NODES, FEW_NODES = 9, 5
# Number of knots on a stretch, and the knots as parts of it; the error of a spline is about 1e-9.
KNOTS = 641
FRACTIONS = np.linspace(0.0, 1.0, KNOTS)
# Largest error of interpolated reactions, as a part of the largest reaction, and the error of an
# end of sticking that follows from it (L).
INTERPOLATION_ERROR = 1e-8
# Largest width of a slim part, as a part of the gap to an upright rod.
SLIM_GAP = 0.05
# Width of the widest and of the narrowest part of a range, and of a slim one (L).
WIDEST_PART, NARROWEST_PART, SLIM_PART = 0.05, 2e-4, 0.004
# Least and largest clamp–surface distance at which a rod is solved (L).
NEAREST, FARTHEST = 0.02, 0.9999
# Number of parts of ranges of distances that are kept, a few megabytes each.
KEPT_PARTS = 32
# Number of distances at which the states of a rod are kept, some hundred kilobytes each.
KEPT_STATES = 32
# Columns of a state that are interpolated; x0 is known.
COLUMNS = tuple(name for name in StickingState.names() if name != "x0")


class Landmarks(NamedTuple):
    """Displacements and contact point at n distances (L); see `States`."""

    x0_pull: FloatArray
    x0_lock: FloatArray
    x0_end: FloatArray
    x1_init: FloatArray


class _Place(NamedTuple):
    """Stretches on which displacements lie, fractions of them, and widths of the stretches (L)."""

    stretch: IntArray
    fraction: FloatArray
    width: FloatArray
    last: BoolArray

    def growth(self, order: int) -> FloatArray:
        """Growth of the fraction with the displacement, to a power of 0 or 1, shape (n, 1)."""
        if order == 0:
            return np.ones((1, 1))
        growth = 1.0 / self.width
        graded = 2.0 * np.maximum(1.0 - self.fraction[self.last], np.finfo(float).eps)
        growth[self.last] /= graded
        return growth[:, None]


class _Within(NamedTuple):
    """Distances that lie in one part of a range: their rows, and what is known of each of them.

    Attributes
    ----------
    part : EtaPart
    rows : slice or ndarray of int, shape (n,)
    polynomials : ndarray, shape (n, nodes)
        Chebyshev polynomials.
    marks : ndarray, shape (n, stretches + 3)
        Bounds of the stretches, then x0_lock and x1_init (L).
    """

    part: "EtaPart"
    rows: slice | IntArray
    polynomials: FloatArray
    marks: FloatArray

    @property
    def bounds(self) -> FloatArray:
        """Bounds of the stretches (L), shape (n, stretches + 1)."""
        return self.marks[:, :-2]

    @property
    def landmarks(self) -> Landmarks:
        """Landmarks at each distance; pulling ends at the first bound, and pushing at the last."""
        return Landmarks(
            x0_pull=self.bounds[:, 0],
            x0_lock=self.marks[:, -2],
            x0_end=self.bounds[:, -1],
            x1_init=self.marks[:, -1],
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class EtaPart:
    """States of one rod at all distances in one part of a range.

    Attributes
    ----------
    low, high : float
        Least and largest distance of the part (L).
    branches : tuple of Response
        Responses at the Chebyshev points of the part.
    bounds : ndarray, shape (nodes, stretches + 1)
        Landmarks of each response, between which its states are smooth (L): the same kinds of
        landmarks in the same order.
    """

    low: float
    high: float
    branches: tuple[Response, ...]
    bounds: FloatArray

    @cached_property
    def _over_eta(self) -> FloatArray:
        """Chebyshev coefficients over η of the bounds, of the lock and of x1_init."""
        marks = [(branch.x0_lock, branch.x1_init) for branch in self.branches]
        return np.asarray(
            chebyshev_transform(len(marks)) @ np.concatenate([self.bounds, marks], axis=1)
        )

    @cached_property
    def _reactions(self) -> "list[CubicSpline]":
        """For each stretch, a spline of the Chebyshev coefficients of the reactions along it."""
        return self._splined(
            [
                branch.reactions(_knots(bounds))
                for branch, bounds in zip(self.branches, self.bounds, strict=True)
            ]
        )

    @cached_property
    def _tip_angles(self) -> "list[CubicSpline]":
        """For each stretch, a spline of the Chebyshev coefficients of φ1 along it."""
        return self._splined(
            [
                branch.tip_angle(_knots(bounds))[..., None]
                for branch, bounds in zip(self.branches, self.bounds, strict=True)
            ]
        )

    @cached_property
    def _states(self) -> "list[CubicSpline]":
        """For each stretch, a spline of the Chebyshev coefficients of all columns of the states."""
        tabulated = []
        for branch, bounds in zip(self.branches, self.bounds, strict=True):
            knots = _knots(bounds)
            states = branch.state(branch.clip(knots.ravel()))
            columns = np.stack([getattr(states, name) for name in COLUMNS], axis=-1)
            tabulated.append(np.nan_to_num(columns).reshape(*knots.shape, len(COLUMNS)))
        return self._splined(tabulated)

    def _splined(self, tabulated: Sequence[FloatArray]) -> "list[CubicSpline]":
        """Spline columns over each stretch; their shape at a distance is (stretches, KNOTS, c)."""
        from scipy.interpolate import CubicSpline  # takes longer to load than a scan on a plane

        transform = chebyshev_transform(len(self.branches))
        over_eta = np.tensordot(transform, np.array(tabulated), axes=1)
        return [
            CubicSpline(FRACTIONS, np.moveaxis(one, 1, 0)) for one in np.moveaxis(over_eta, 1, 0)
        ]

    @cached_property
    def _coefficients(self) -> FloatArray:
        """Cubic pieces of the reactions, shape (stretches, pieces, 4, 3, nodes)."""
        coefficients = np.array([spline.c for spline in self._reactions])
        return np.ascontiguousarray(coefficients.transpose(0, 2, 1, 4, 3))

    def _polynomials(self, eta: FloatArray) -> FloatArray:
        """Chebyshev polynomials at distances, shape (n, nodes)."""
        position = (2.0 * eta - self.low - self.high) / (self.high - self.low)
        return chebyshev_polynomials(position, len(self.branches)).T

    def within(self, eta: FloatArray, rows: slice | IntArray) -> _Within:
        """Return what is known of distances, shape (n,), which are in the given rows."""
        polynomials = self._polynomials(eta)
        marks = np.asarray(polynomials @ self._over_eta)
        return _Within(part=self, rows=rows, polynomials=polynomials, marks=marks)

    def reactions(self, x0: FloatArray, at: _Within, order: int) -> FloatArray:
        """Return fx, fy and m, or their derivatives with respect to x0, shape (n, 3).

        Parameters
        ----------
        x0 : ndarray, shape (n,)
            Displacement of each state (L).
        at : _Within
            Distance of each state.
        order : int
            0 for the reactions, 1 for their derivatives; the formula holds for no higher order.
        """
        place = _placed(at.bounds, x0)
        found = self._interpolated(self._reactions, place, at.polynomials, order)
        return np.asarray(found * place.growth(order))

    def tip_angle(self, x0: FloatArray, eta: FloatArray) -> FloatArray:
        """Return φ1 of states at displacements and distances (rad), shape (n,)."""
        polynomials = self._polynomials(eta)
        place = self._place(x0, polynomials)
        return self._interpolated(self._tip_angles, place, polynomials, 0)[:, 0]

    def states(self, x0: FloatArray, eta: FloatArray) -> FloatArray:
        """Return the columns `COLUMNS` of states at displacements and distances (L)."""
        polynomials = self._polynomials(eta)
        found = self._interpolated(self._states, self._place(x0, polynomials), polynomials, 0)
        if self.branches[0].curve.section is RodSection.PLANAR:
            found[:, COLUMNS.index("stability_aside")] = np.nan
        return found

    def shapes(self, x0: FloatArray, offset: FloatArray, eta: FloatArray, s: FloatArray) -> Shape:
        """Solve shapes at displacements and distances; NaN where a state is not found.

        The guesses are states at the nearest distance at which the rod was solved.

        Parameters
        ----------
        offset : ndarray, shape (n,)
            Distance of the tip ahead of the clamp (L).
        s : ndarray, shape (points,)
            Arc lengths between 0 and 1, increasing (L).
        """
        place = self._place(x0, self._polynomials(eta))
        found = np.full((3, len(x0), len(s)), np.nan)
        nodes = np.array([branch.curve.eta for branch in self.branches])
        nearest = np.abs(eta[:, None] - nodes).argmin(axis=1)
        for number in np.unique(nearest):
            rows, branch = np.flatnonzero(nearest == number), self.branches[number]
            bounds = self.bounds[number]
            begin, fraction = bounds[place.stretch[rows]], place.fraction[rows]
            last = place.stretch[rows] == len(bounds) - 2
            fraction = np.where(last, 1.0 - (1.0 - fraction) ** 2, fraction)
            near = begin + fraction * (bounds[place.stretch[rows] + 1] - begin)
            for some in branch.curve.rod_states(branch.clip(near)):
                at = rows[some.rows]
                closing = ClosingCondition.prescribing(eta[at], {OFFSET: 1.0}, offset[at])
                solved = solve(some.states, closing)
                found[:, at] = np.where(solved.converged[:, None], shape(solved.states, s), np.nan)
        return Shape(*found)

    def pieces_at(self, eta: FloatArray) -> FloatArray:
        """Cubic pieces of the reactions at the distance eta[0], shape (stretches, pieces, 4, 3)."""
        pieces = self._coefficients
        # As one matrix: a product of many small ones takes thirty times as long.
        rows = pieces.reshape(-1, pieces.shape[-1])
        return np.asarray((rows @ self._polynomials(eta)[0]).reshape(pieces.shape[:-1]))

    def _place(self, x0: FloatArray, polynomials: FloatArray) -> _Place:
        return _placed(polynomials @ self._over_eta[:, :-2], x0)

    def _interpolated(
        self, splines: "Sequence[CubicSpline]", place: _Place, polynomials: FloatArray, order: int
    ) -> FloatArray:
        found = np.empty((len(polynomials), splines[0].c.shape[-1]))
        for number, spline in enumerate(splines):
            on = np.flatnonzero(place.stretch == number)
            if not len(on):
                continue
            coefficients = spline(place.fraction[on], order)
            found[on] = np.einsum("nk,nkc->nc", polynomials[on], coefficients)
        return found


def _placed(bounds: FloatArray, x0: FloatArray) -> _Place:
    """Place displacements between landmarks: the same for all, or a row of `bounds` for each."""
    if bounds.ndim == 1:
        stretch = np.searchsorted(bounds[1:-1], x0, side="right")
        begin, end = bounds[stretch], bounds[stretch + 1]
    else:
        rows = np.arange(len(x0))
        stretch = np.count_nonzero(x0[:, None] >= bounds[:, 1:-1], axis=1)
        begin, end = bounds[rows, stretch], bounds[rows, stretch + 1]
    width = end - begin
    fraction = np.clip((x0 - begin) / width, 0.0, 1.0)
    last = stretch == bounds.shape[-1] - 2
    # Near a limit point the last stretch is graded: see `_knots`.
    fraction[last] = 1.0 - np.sqrt(1.0 - fraction[last])
    return _Place(stretch=stretch, fraction=fraction, width=width, last=last)


def _knots(bounds: FloatArray) -> FloatArray:
    """Knots on each stretch (L), shape (stretches, KNOTS).

    On the last stretch they are close together near its end, which may be a limit point.
    """
    fractions = np.tile(FRACTIONS, (len(bounds) - 1, 1))
    fractions[-1] = 1.0 - (1.0 - FRACTIONS) ** 2
    x0 = bounds[:-1, None] + np.diff(bounds)[:, None] * fractions
    x0[:, -1] = bounds[1:]
    return np.asarray(x0)


@dataclass(frozen=True, eq=False, kw_only=True)
class ResponseOverEta:
    """States of one rod over a range of distances, which is divided into parts.

    Attributes
    ----------
    parts : tuple of EtaPart
        Parts from low to high; each begins where the part below it ends.
    """

    parts: tuple[EtaPart, ...]

    @property
    def swings(self) -> bool:
        """Whether the tip is dragged behind the clamp after lateral buckling; see `Response`."""
        return all(part.branches[0].swings for part in self.parts)

    @property
    def x0_touch(self) -> float:
        """Least x0 (L) with φ1 = 0 at one of the solved distances; infinite if there is none."""
        touches = [one.curve.x0_touch for part in self.parts for one in part.branches]
        return min(filter(np.isfinite, touches), default=np.inf)

    @property
    def x0_through(self) -> float:
        """Least `Response.x0_through` of the solved distances (L)."""
        return min(one.x0_through for part in self.parts for one in part.branches)

    def part_of(self, eta: ArrayLike) -> IntArray:
        """Find the number of the part in which each distance lies."""
        inner = [part.low for part in self.parts[1:]]
        return np.asarray(np.searchsorted(inner, eta, side="right"))

    def states(self, eta: ArrayLike) -> "StatesAtEta":
        """Return the rod's states at these distances; those outside the range are clipped to it."""
        if np.ndim(eta) == 0:
            return _states_at(self, float(np.asarray(eta)))
        return self._states(eta)

    def _states(self, eta: ArrayLike) -> "StatesAtEta":
        eta = np.clip(eta, self.parts[0].low, self.parts[-1].high)
        within = self.divided(eta.ravel())
        found = np.empty((len(Landmarks._fields), eta.size))
        for at in within:
            found[:, at.rows] = at.landmarks
        landmarks = Landmarks(*found.reshape(len(found), *eta.shape))
        return StatesAtEta(response=self, eta=eta, within=within, **landmarks._asdict())

    def divided(self, eta: FloatArray) -> tuple[_Within, ...]:
        """Divide distances, shape (n,), by the parts in which they lie."""
        if len(self.parts) == 1:
            return (self.parts[0].within(eta, slice(None)),)
        part_of = self.part_of(eta)
        rows = [np.flatnonzero(part_of == number) for number in range(len(self.parts))]
        return tuple(
            part.within(eta[on], on) for part, on in zip(self.parts, rows, strict=True) if len(on)
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class StatesAtEta(States):
    """Sticking states of a rod, with a distance for each displacement, or one distance for all.

    Attributes
    ----------
    eta : ndarray
        Distances (L).
    within : tuple
        The same distances, in one row, divided by the parts of the range.
    x0_pull, x0_lock, x0_end, x1_init : ndarray
        As in `States`, at these distances (L).
    """

    response: ResponseOverEta
    eta: FloatArray
    within: tuple[_Within, ...]
    x0_pull: FloatArray
    x0_lock: FloatArray
    x0_end: FloatArray
    x1_init: FloatArray
    accuracy: float = INTERPOLATION_ERROR

    @cached_property
    def bounds(self) -> FloatArray:
        """Landmarks (L) at the only distance in `eta`; the reactions are smooth between them."""
        return self.within[0].bounds[0]

    @cached_property
    def _pieces(self) -> FloatArray:
        """Cubic pieces of the reactions at the only distance, shape (stretches, pieces, 4, 3)."""
        return self.within[0].part.pieces_at(np.atleast_1d(self.eta))

    def _at_one_distance(self, x0: FloatArray, order: int) -> FloatArray:
        """Evaluate the reactions at the only distance, as `EtaPart.reactions` does, but faster."""
        place = _placed(self.bounds, x0)
        position = place.fraction * (KNOTS - 1)
        piece = np.minimum(position.astype(np.int64), KNOTS - 2)
        c = self._pieces[place.stretch, piece]
        t = ((position - piece) / (KNOTS - 1))[:, None]
        if order == 0:
            return ((c[:, 0] * t + c[:, 1]) * t + c[:, 2]) * t + c[:, 3]
        return np.asarray(((3.0 * c[:, 0] * t + 2.0 * c[:, 1]) * t + c[:, 2]) * place.growth(order))

    def derivative(self, x0: ArrayLike, order: int) -> FloatArray:
        """See `States`; `order` is 0 or 1."""
        x0 = np.asarray(x0, dtype=float)
        if self.eta.ndim == 0:
            return self._at_one_distance(x0.ravel(), order).reshape(*x0.shape, len(LOADS))
        within = self.within
        if x0.shape != self.eta.shape:
            x0, eta = np.broadcast_arrays(x0, self.eta)
            within = self.response.divided(eta.ravel())
        flat = x0.ravel()
        found = np.empty((len(flat), len(LOADS)))
        for at in within:
            found[at.rows] = at.part.reactions(flat[at.rows], at, order)
        return found.reshape(*x0.shape, len(LOADS))

    def tip_angle(self, x0: ArrayLike) -> FloatArray:
        """See `States`."""
        x0, eta = np.broadcast_arrays(np.asarray(x0, dtype=float), self.eta)
        flat, eta = x0.ravel(), eta.ravel()
        found, part_of = np.empty(len(flat)), self.response.part_of(eta)
        for number, part in enumerate(self.response.parts):
            on = part_of == number
            found[on] = part.tip_angle(flat[on], eta[on])
        return found.reshape(x0.shape)

    def shapes(self, x0: FloatArray, offset: FloatArray, s: FloatArray) -> Shape:
        """See `States`."""
        eta = np.broadcast_to(self.eta, x0.shape)
        found, part_of = np.empty((3, len(x0), len(s))), self.response.part_of(eta)
        for number, part in enumerate(self.response.parts):
            on = part_of == number
            if on.any():
                found[:, on] = part.shapes(x0[on], offset[on], eta[on], s)
        return Shape(*found)

    def state(self, x0: FloatArray) -> StickingState:
        """See `States`."""
        x0, eta = np.broadcast_arrays(x0, self.eta)
        found, part_of = np.empty((len(x0), len(COLUMNS))), self.response.part_of(eta)
        for number, part in enumerate(self.response.parts):
            on = part_of == number
            if on.any():
                found[on] = part.states(x0[on], eta[on])
        return StickingState(x0=x0, **dict(zip(COLUMNS, found.T, strict=True)))


@lru_cache(KEPT_STATES)
def _states_at(response: ResponseOverEta, eta: float) -> StatesAtEta:
    """Return the states at one distance, which are evaluated many times."""
    return response._states(eta)


def check_range(rod: MountedRod, low: float, high: float) -> None:
    """Check that the surface is not too near to the clamp, and the rod not almost upright.

    Raises
    ------
    NoResponseError
        If the distances from `low` to `high` (L) leave the range from `NEAREST` to `FARTHEST`.
    """
    if low < NEAREST or high > FARTHEST:
        least, most, nearest, farthest = map(rod.spell, (low, high, NEAREST, FARTHEST))
        raise NoResponseError(
            f"the stage takes the clamp to distances from {least} to {most}, but its distance to "
            f"the surface must lie between {nearest} and {farthest}: shorten the path, or check "
            "the positions of the clamp"
        )


def respond_over(rod: MountedRod, low: float, high: float) -> ResponseOverEta:
    """Solve a rod on a level stage at all distances of a range.

    Parameters
    ----------
    low, high : float
        Least and largest distance (L); the distance of the rod lies between them.

    Raises
    ------
    NoResponseError
        If the surface comes too near to the clamp, or the rod is almost upright, or has no response
        at one of the distances.
    """
    check_range(rod, low, high)
    _check_response(rod)
    edges = [low, high]
    if high - low > SLIM_PART:
        down, up = np.arange(rod.eta, low, -WIDEST_PART), np.arange(rod.eta, high, WIDEST_PART)
        edges = np.unique([low, *down, *up, high]).tolist()
    parts = [part for ends in pairwise(edges) for part in _parts(rod, *ends)]
    return ResponseOverEta(parts=tuple(parts))


@lru_cache(KEPT_PARTS)
def _check_response(rod: MountedRod) -> None:
    """Raise an error if a rod has no response at its own distance; see `responses`."""
    responses([rod])


def _parts(rod: MountedRod, low: float, high: float) -> list[EtaPart]:
    """Interpolate the responses of a rod; halve the range of distances until that is possible."""
    try:
        return [interpolated(rod, low, high)]
    except NoResponseError as error:
        middle = 0.5 * (low + high)
        if middle - low < NARROWEST_PART:
            least, most = map(rod.spell, (low, high))
            raise NoResponseError(
                f"the stage takes the clamp to distances from {least} to {most}, where the "
                f"response is not known: {error}; shorten the path, or take another eta or theta"
            ) from None
    return [*_parts(rod, low, middle), *_parts(rod, middle, high)]


@lru_cache(KEPT_PARTS)
def interpolated(rod: MountedRod, low: float, high: float) -> EtaPart:
    """Interpolate the responses of a rod between two distances, within `INTERPOLATION_ERROR`.

    Raises
    ------
    NoResponseError
        If a response is not solved, the landmarks are not the same at all distances, or the error
        is larger.
    """
    # Near an upright rod, at η = 1, forces are singular: there no part is slim.
    slim = min(SLIM_PART, SLIM_GAP * (1.0 - high))
    count = NODES if high - low > slim else FEW_NODES
    nodes = low + (high - low) * chebyshev_nodes(count)
    # The interpolation is compared with the response at a distance between the nodes.
    between = float(nodes[count // 2 : count // 2 + 2].mean())
    rods = [replace(rod, eta=eta) for eta in (*nodes.tolist(), between)]
    *solved, unseen = responses(rods)
    # The landmarks before the lock, the others, and the end must be the same.
    if len({(*(one.bounds < one.x0_lock), one.curve.end) for one in solved}) > 1:
        raise NoResponseError(
            "the type of contact (tip or line), or the way in which sticking ends, changes between "
            "them"
        )
    bounds = np.array([one.bounds for one in solved])
    found = EtaPart(low=low, high=high, branches=tuple(solved), bounds=bounds)
    if not agrees(ResponseOverEta(parts=(found,)).states(between), unseen, INTERPOLATION_ERROR):
        raise NoResponseError("the reactions cannot be interpolated accurately between them")
    return found


def agrees(found: States, solved: States, tolerance: float) -> bool:
    """Whether interpolated reactions agree with solved ones at all x0 up to the lock."""
    x0 = np.linspace(solved.x0_pull, solved.x0_lock, KNOTS)[1:-1]
    error = np.abs(found.reactions(found.clip(x0)) - solved.reactions(x0))
    return bool(error.max() <= tolerance * np.abs(solved.reactions(x0)).max())
