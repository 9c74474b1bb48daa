"""One rod at many heights: the branch at any η of a range, interpolated from a few heights.

Each smooth stretch between landmarks (end of pulling, α = 0, kink, lock, end) is a polynomial in η.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from scipy.interpolate import CubicSpline

from vibrissa.errors import ArgumentError, NoResponseError
from vibrissa.mechanics.mounting import Mounting
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.spectral import chebyshev_nodes, chebyshev_transform
from vibrissa.numerics.splines import joined
from vibrissa.sensor.response.branch import KNOTS, Branch, Response, responses

# Heights at which the rod is solved, and knots on each stretch, as parts of it.
NODES = 9
PARTS = np.linspace(0.0, 1.0, KNOTS)


@dataclass(frozen=True, eq=False, kw_only=True)
class Heights:
    """Branches of one rod over a range of heights.

    Attributes
    ----------
    low, high : float
        Ends of the range (L).
    branches : tuple of Branch
        At Chebyshev points of the range, all with the same landmarks.
    """

    low: float
    high: float
    branches: tuple[Branch, ...]

    @cached_property
    def _series(self) -> tuple[FloatArray, FloatArray]:
        """Chebyshev series over η of the landmarks with x1_init, and of the reactions."""
        transform = chebyshev_transform(len(self.branches))
        marks = np.array([[*branch.bounds, branch.x1_init] for branch in self.branches])
        values = np.array([branch(_displacements(branch.bounds)) for branch in self.branches])
        return transform @ marks, np.tensordot(transform, values, axes=1)

    @property
    def finite(self) -> bool:
        """Whether the reactions are known at all these heights."""
        return bool(np.isfinite(self._series[1]).all())

    @cached_property
    def _stretches(self) -> list[CubicSpline]:
        """Spline over the part of each stretch: Chebyshev series over η of the reactions."""
        return [
            CubicSpline(PARTS, np.moveaxis(one, 1, 0)) for one in np.moveaxis(self._series[1], 1, 0)
        ]

    @cached_property
    def lock(self) -> int:
        """Number of the landmark at which the tip locks."""
        branch = self.branches[0]
        return int(np.argmin(np.abs(branch.bounds - branch.x0_lock)))

    def _row(self, eta: FloatArray) -> FloatArray:
        """Chebyshev polynomials at heights, shape (n, NODES)."""
        position = (2.0 * eta - self.low - self.high) / (self.high - self.low)
        return np.asarray(chebvander(position, len(self.branches) - 1))

    def landmarks(self, eta: FloatArray) -> FloatArray:
        """Landmarks and x1_init at heights of shape (n,), in columns (L)."""
        return np.asarray(self._row(eta) @ self._series[0])

    def reactions(self, x0: FloatArray, eta: FloatArray, order: int = 0) -> FloatArray:
        """Reactions, or derivatives over x0, at displacements and heights of shape (n,)."""
        row = self._row(eta)
        bounds = (row @ self._series[0])[:, :-1]
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

    def at(self, eta: float) -> Branch:
        """Interpolate the branch at a height.

        Raises
        ------
        ArgumentError
            If it lies outside.
        """
        position = (2.0 * eta - self.low - self.high) / (self.high - self.low)
        if not abs(position) <= 1.0 + 1e-12:
            raise ArgumentError(f"eta must lie in [{self.low:.6g}, {self.high:.6g}], got {eta!r}")
        row = self._row(np.array([eta]))[0]
        marks, values = row @ self._series[0], np.tensordot(row, self._series[1], axes=1)
        bounds, x1_init = marks[:-1], float(marks[-1])
        parts = [CubicSpline(x, y) for x, y in zip(_displacements(bounds), values, strict=True)]
        return Branch(
            reactions=joined(parts),
            x0_lock=float(bounds[self.lock]),
            x1_init=x1_init,
            bounds=bounds,
            swings=self.branches[0].swings,
        )


def _displacements(bounds: FloatArray) -> FloatArray:
    """Points on each stretch, shape (stretches, KNOTS), close together near a limit point."""
    parts = np.tile(PARTS, (len(bounds) - 1, 1))
    parts[-1] = 1.0 - (1.0 - PARTS) ** 2
    x = bounds[:-1, None] + np.diff(bounds)[:, None] * parts
    x[:, -1] = bounds[1:]
    return np.asarray(x)


# Solves a rod at some heights together.
Solve = Callable[[FloatArray], list[Response]]


def solver(theta: float, contact: str, pull: bool, mounting: Mounting, section: str) -> Solve:
    """Return a function that solves a rod at several heights together."""

    def solve(heights: FloatArray) -> list[Response]:
        eta = heights.tolist()
        return responses([theta] * len(eta), eta, contact, pull, [mounting] * len(eta), section)

    return solve


def interpolated(
    solve: Solve,
    low: float,
    high: float,
    tolerance: float,
) -> Heights:
    """Interpolate the branches of a rod between two heights.

    Parameters
    ----------
    low, high : float
        Range of heights (L).

    Raises
    ------
    NoResponseError
        If a branch is not solved, landmarks differ, or the tolerance is not met.
    """
    nodes = low + (high - low) * chebyshev_nodes(NODES)
    # Between the nodes the interpolation must agree with a branch that it has not seen.
    between = float(nodes[NODES // 2 : NODES // 2 + 2].mean())
    *solved, unseen = solve(np.append(nodes, between))
    found = Heights(low=low, high=high, branches=tuple(solved))
    where = f"for heights from {low:.6g} to {high:.6g} (in units of L)"
    landmarks = {
        (len(branch.bounds), int(np.argmin(np.abs(branch.bounds - branch.x0_lock))))
        for branch in solved
    }
    if len(landmarks) > 1 or len({branch.curve.end for branch in solved}) > 1:
        raise NoResponseError(f"{where} the kind of contact or the end of the curve changes")
    if not _agrees(found.at(between), unseen, tolerance):
        raise NoResponseError(f"{where} the rod's response is not resolved")
    return found


def _agrees(found: Branch, solved: Branch, tolerance: float) -> bool:
    """Whether an interpolated branch agrees with the solved one up to the lock."""
    x = np.linspace(solved.x0_pull, solved.x0_lock, KNOTS)[1:-1]
    error = np.abs(found(found.clip(x)) - solved(x))
    return bool(error.max() <= tolerance * np.abs(solved(x)).max())
