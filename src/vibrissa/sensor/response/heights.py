"""The response of one rod at any height η of a range, interpolated from a few heights.

The range is divided into parts. Landmarks (end of pulling, kinks, α = 0, lock, end of pushing)
divide x0 into smooth stretches. In each part of the range, the reactions at a given fraction of a
stretch are a polynomial in η.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from vibrissa.errors import NoResponseError
from vibrissa.numerics.arrays import FloatArray, IntArray
from vibrissa.numerics.spectral import chebyshev_nodes, chebyshev_transform
from vibrissa.quantities.units import Kind
from vibrissa.sensor.response.branch import KNOTS, Response, States, responses
from vibrissa.sensor.whisker import Whisker, height_at

# Number of heights at which the rod is solved in a part, and knots on a stretch, as parts of it.
NODES = 9
PARTS = np.linspace(0.0, 1.0, KNOTS)
# Largest error of interpolated reactions, as a part of the largest reaction.
EXACT = 1e-8
# Widest and narrowest part of a range, and the least and the largest height (L).
WIDEST, NARROWEST = 0.05, 2e-4
LOWEST, HIGHEST = 0.02, 0.9999


@dataclass(frozen=True, eq=False, kw_only=True)
class Heights:
    """Responses of one rod at all heights in one part of a range.

    Attributes
    ----------
    low, high : float
        Least and largest height of the part (L).
    branches : tuple of Response
        Responses at the Chebyshev points of the part; all have the same kinds of landmarks, in the
        same order.
    """

    low: float
    high: float
    branches: tuple[Response, ...]

    @cached_property
    def _series(self) -> tuple[FloatArray, FloatArray]:
        """Chebyshev coefficients over η of the landmarks, and of the reactions."""
        transform = chebyshev_transform(len(self.branches))
        marks = np.array([[*one.bounds, one.x0_lock, one.x1_init] for one in self.branches])
        values = np.array([branch(_displacements(branch.bounds)) for branch in self.branches])
        return transform @ marks, np.tensordot(transform, values, axes=1)

    @property
    def finite(self) -> bool:
        """Whether the reactions are known at all heights of the part."""
        return bool(np.isfinite(self._series[1]).all())

    @cached_property
    def _stretches(self) -> list[CubicSpline]:
        """For each stretch, a spline of the Chebyshev coefficients of the reactions along it."""
        return [
            CubicSpline(PARTS, np.moveaxis(one, 1, 0)) for one in np.moveaxis(self._series[1], 1, 0)
        ]

    def _row(self, eta: FloatArray) -> FloatArray:
        """Chebyshev polynomials at heights, shape (n, NODES)."""
        position = (2.0 * eta - self.low - self.high) / (self.high - self.low)
        return np.asarray(chebvander(position, len(self.branches) - 1))

    def landmarks(self, eta: FloatArray) -> FloatArray:
        """Return the landmarks, the lock again, and x1_init (L): a row for each height."""
        return np.asarray(self._row(eta) @ self._series[0])

    def reactions(self, x0: FloatArray, eta: FloatArray, order: int = 0) -> FloatArray:
        """Return fx, fy and m, or their derivatives with respect to x0, shape (n, 3).

        Parameters
        ----------
        x0, eta : ndarray, shape (n,)
            Displacement and height of each state (L).
        order : int
            0 for the reactions, 1 for their derivatives; the formula holds for no higher order.
        """
        row = self._row(eta)
        bounds = (row @ self._series[0])[:, :-2]
        stretch = (x0[:, None] >= bounds[:, 1:-1]).sum(axis=1)
        here = np.arange(len(x0))
        width = bounds[here, stretch + 1] - bounds[here, stretch]
        part = np.clip((x0 - bounds[here, stretch]) / width, 0.0, 1.0)
        last, steep = stretch == len(self._stretches) - 1, 1.0 / width
        # Near a limit point the last stretch is graded: see `_displacements`.
        part[last] = 1.0 - np.sqrt(1.0 - part[last])
        steep[last] /= 2.0 * np.maximum(1.0 - part[last], np.finfo(float).eps)
        found = np.empty((len(x0), 3))
        for number, spline in enumerate(self._stretches):
            on = stretch == number
            found[on] = np.einsum("nk,nkc->nc", row[on], spline(part[on], order))
        return found * steep[:, None] ** order


def _displacements(bounds: FloatArray) -> FloatArray:
    """Knots on each stretch (L), shape (stretches, KNOTS).

    On the last stretch they are close together near its end, which may be a limit point.
    """
    parts = np.tile(PARTS, (len(bounds) - 1, 1))
    parts[-1] = 1.0 - (1.0 - PARTS) ** 2
    x = bounds[:-1, None] + np.diff(bounds)[:, None] * parts
    x[:, -1] = bounds[1:]
    return np.asarray(x)


@dataclass(frozen=True, eq=False, kw_only=True)
class HeightRange:
    """Responses of one rod over a range of heights, which is divided into parts.

    Attributes
    ----------
    parts : tuple of Heights
        Parts from low to high; each begins where the part below it ends.
    """

    parts: tuple[Heights, ...]

    @property
    def swings(self) -> bool:
        """Whether the tip is dragged behind the clamp after lateral buckling; see `Response`."""
        return all(part.branches[0].swings for part in self.parts)

    @property
    def x0_touch(self) -> float:
        """Least x0 (L) with φ1 = 0 at one of the solved heights; infinite if there is none."""
        touches = [one.curve.x0_touch for part in self.parts for one in part.branches]
        return min(filter(np.isfinite, touches), default=np.inf)

    def part_of(self, eta: ArrayLike) -> IntArray:
        """Find the number of the part in which each height lies."""
        inner = [part.low for part in self.parts[1:]]
        return np.asarray(np.searchsorted(inner, eta, side="right"))

    def states(self, eta: ArrayLike) -> "HeightStates":
        """Return the rod's states at these heights; heights outside the range are clipped to it."""
        eta = np.clip(eta, self.parts[0].low, self.parts[-1].high)
        part_of, flat = self.part_of(eta).ravel(), eta.ravel()
        found = np.empty((4, len(flat)))
        for number, part in enumerate(self.parts):
            on = part_of == number
            found[:, on] = part.landmarks(flat[on])[:, [0, -3, -2, -1]].T
        pull, end, lock, x1_init = found.reshape(4, *eta.shape)
        return HeightStates(
            heights=self, eta=eta, x0_pull=pull, x0_lock=lock, x0_end=end, x1_init=x1_init
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class HeightStates(States):
    """Sticking states of a rod, with a height for each displacement, or one height for all.

    Attributes
    ----------
    eta : ndarray
        Heights (L).
    x0_pull, x0_lock, x0_end, x1_init : ndarray
        As in `States`, at these heights (L).
    """

    heights: HeightRange
    eta: FloatArray
    x0_pull: FloatArray
    x0_lock: FloatArray
    x0_end: FloatArray
    x1_init: FloatArray

    @property
    def bounds(self) -> FloatArray:  # type: ignore[override]
        """Landmarks (L) at the only height in `eta`; the reactions are smooth between them."""
        part = self.heights.parts[int(self.heights.part_of(self.eta))]
        return part.landmarks(np.atleast_1d(self.eta))[0, :-2]

    def derivative(self, x0: ArrayLike, order: int) -> FloatArray:
        """See `States`; `order` is 0 or 1."""
        x0, heights = np.broadcast_arrays(np.asarray(x0, dtype=float), self.eta)
        flat, eta = x0.ravel(), heights.ravel()
        found, part_of = np.empty((len(flat), 3)), self.heights.part_of(eta)
        for number, part in enumerate(self.heights.parts):
            on = part_of == number
            found[on] = part.reactions(flat[on], eta[on], order)
        return found.reshape(*x0.shape, 3)


@dataclass(frozen=True, eq=False, kw_only=True)
class Stage:
    """A rod on a stage that moves along the surface, or at an angle δ to it.

    With the clamp at X, the height h is that of `height_at`, and a tip at the position x_c has the
    displacement from the α = 0 state of that height

        x0(X) = x1_init(h) + side·(X·cos δ − x_c),

    where side is 1 for a tip ahead of the clamp, and −1 for a tip behind it (mirrored states).

    Attributes
    ----------
    rod : Response or HeightRange
        Response of the rod at the one height of a level stage, or its responses at all heights that
        an oblique stage reaches.
    eta : float
        Height with the clamp at 0 (L).
    angle : float
        δ (rad); positive: the clamp approaches the surface as it moves.
    """

    rod: Response | HeightRange
    eta: float
    angle: float = 0.0

    def along(self, clamp: ArrayLike) -> FloatArray:
        """Convert clamp positions along the stage to positions along the surface (L)."""
        return np.asarray(np.asarray(clamp) * np.cos(self.angle))

    def at(self, clamp: ArrayLike) -> Response | HeightStates:
        """Return the rod's states at the height that belongs to each clamp position."""
        if isinstance(self.rod, Response):
            return self.rod
        return self.rod.states(height_at(clamp, self.eta, self.angle))

    def states(
        self, clamp: ArrayLike, contact: ArrayLike, side: ArrayLike
    ) -> tuple[Response | HeightStates, FloatArray]:
        """Return the rod's states, and the displacement x0 of each (L).

        Parameters
        ----------
        clamp : array_like
            Positions of the clamp (L).
        contact : array_like
            Position of the tip along the surface (L).
        side : array_like
            1 for a tip ahead of the clamp, −1 for a tip behind it.
        """
        states, ahead = self.at(clamp), self.along(clamp) - np.asarray(contact)
        return states, np.asarray(states.x1_init + np.asarray(side) * ahead)


def check_range(whisker: Whisker, low: float, high: float) -> None:
    """Check that the surface is not too near to the clamp, and the rod not almost upright.

    Raises
    ------
    NoResponseError
        If the heights from `low` to `high` (L) leave the range from `LOWEST` to `HIGHEST`.
    """
    if low < LOWEST or high > HIGHEST:
        least, most, lowest, highest = (
            whisker.units.spelled(eta, Kind.LENGTH) for eta in (low, high, LOWEST, HIGHEST)
        )
        raise NoResponseError(
            f"the stage takes the rod to heights from {least} to {most}, but they must lie between "
            f"{lowest} and {highest}: shorten the path, or check the positions of the clamp"
        )


def respond_over(whisker: Whisker, low: float, high: float) -> HeightRange:
    """Solve a rod on a level stage at all heights of a range.

    Parameters
    ----------
    low, high : float
        Least and largest height (L); the height of the whisker lies between them.

    Raises
    ------
    NoResponseError
        If the surface comes too near to the clamp, or the rod is almost upright, or has no response
        at one of the heights.
    """
    check_range(whisker, low, high)
    responses([whisker])
    down, up = np.arange(whisker.eta, low, -WIDEST), np.arange(whisker.eta, high, WIDEST)
    edges = np.unique([low, *down, *up, high]).tolist()
    parts = [part for ends in pairwise(edges) for part in _parts(whisker, *ends)]
    return HeightRange(parts=tuple(parts))


def _parts(whisker: Whisker, low: float, high: float) -> list[Heights]:
    """Interpolate the responses of a rod; halve the range of heights until that is possible."""
    try:
        return [interpolated(whisker, low, high)]
    except NoResponseError as error:
        middle = 0.5 * (low + high)
        if middle - low < NARROWEST:
            least, most = (whisker.units.spelled(eta, Kind.LENGTH) for eta in (low, high))
            raise NoResponseError(
                f"the stage takes the rod to heights from {least} to {most}, where the response "
                f"is not known: {error}; shorten the path, or take another eta or theta"
            ) from None
    return [*_parts(whisker, low, middle), *_parts(whisker, middle, high)]


def interpolated(whisker: Whisker, low: float, high: float) -> Heights:
    """Interpolate the responses of a rod between two heights, with an error below `EXACT`.

    Raises
    ------
    NoResponseError
        If a response is not solved, the landmarks are not the same at all heights, or the error is
        larger.
    """
    nodes = low + (high - low) * chebyshev_nodes(NODES)
    # The interpolation is compared with the response at a height between the nodes.
    between = float(nodes[NODES // 2 : NODES // 2 + 2].mean())
    rods = [replace(whisker, eta=eta) for eta in (*nodes.tolist(), between)]
    *solved, unseen = responses(rods)
    found = Heights(low=low, high=high, branches=tuple(solved))
    # The landmarks before the lock, the others, and the end must be the same.
    if len({(*(one.bounds < one.x0_lock), one.curve.end) for one in solved}) > 1:
        raise NoResponseError(
            "the type of contact (tip or line), or the way in which sticking ends, changes between "
            "them"
        )
    if not _agrees(HeightRange(parts=(found,)).states(between), unseen, EXACT):
        raise NoResponseError("the reactions cannot be interpolated accurately between them")
    return found


def _agrees(found: States, solved: Response, tolerance: float) -> bool:
    """Whether interpolated reactions agree with solved ones at all x0 up to the lock."""
    x = np.linspace(solved.x0_pull, solved.x0_lock, KNOTS)[1:-1]
    error = np.abs(found(found.clip(x)) - solved(x))
    return bool(error.max() <= tolerance * np.abs(solved(x)).max())
