"""One rod at many heights: the branch at any η of a range, interpolated from a few heights.

Each smooth stretch of the branch lies between the same two landmarks (end of pulling, α = 0, kink,
lock, end). It is interpolated over η by the polynomial through Chebyshev points.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from scipy.interpolate import CubicSpline

from vibrissa.errors import ArgumentError, NoResponseError
from vibrissa.mechanics.mounting import IDEAL, Mounting
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.spectral import chebyshev_nodes, chebyshev_transform
from vibrissa.outcomes import Contact
from vibrissa.sensor.response import Branch, Response, joined, respond

# Heights at which the rod is solved, and displacements on each stretch.
NODES = 9
POINTS = 257
# The height is sought within this distance of the given one (L). The forces are singular at η = 1,
# where the rod stands upright: so the distance is at most this part of 1 − η.
REACH = 0.05
REACH_PART = 1.0 / 3.0
# Error allowed between the nodes, of the largest reaction.
TOLERANCE = 1e-5


@dataclass(frozen=True, eq=False, kw_only=True)
class Heights:
    """Branches of one rod over a range of heights.

    Build one with `respond_between`.

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

    @cached_property
    def _lock(self) -> int:
        branch = self.branches[0]
        return int(np.argmin(np.abs(branch.bounds - branch.x0_lock)))

    def at(self, eta: float) -> Branch:
        """Interpolate the branch at a height.

        Parameters
        ----------
        eta : float
            From `low` to `high` (L).

        Returns
        -------
        Branch

        Raises
        ------
        ArgumentError
            If it lies outside.
        """
        position = (2.0 * eta - self.low - self.high) / (self.high - self.low)
        if not abs(position) <= 1.0 + 1e-12:
            raise ArgumentError(f"eta must lie in [{self.low:.6g}, {self.high:.6g}], got {eta!r}")
        row = chebvander(np.array([position]), len(self.branches) - 1)[0]
        marks, values = row @ self._series[0], np.tensordot(row, self._series[1], axes=1)
        bounds, x1_init = marks[:-1], float(marks[-1])
        parts = [CubicSpline(x, y) for x, y in zip(_displacements(bounds), values, strict=True)]
        return Branch(
            reactions=joined(parts),
            x0_lock=float(bounds[self._lock]),
            x1_init=x1_init,
            bounds=bounds,
            swings=self.branches[0].swings,
        )


def _displacements(bounds: FloatArray) -> FloatArray:
    """Points on each stretch, shape (stretches, POINTS), close together near a limit point."""
    part = np.linspace(0.0, 1.0, POINTS)
    parts = np.tile(part, (len(bounds) - 1, 1))
    parts[-1] = 1.0 - (1.0 - part) ** 2
    x = bounds[:-1, None] + np.diff(bounds)[:, None] * parts
    x[:, -1] = bounds[1:]
    return np.asarray(x)


def respond_between(
    theta: float,
    eta: float,
    contact: str = Contact.POINT,
    pull: bool = True,
    progress: Callable[[int], None] = lambda done: None,
    mounting: Mounting = IDEAL,
) -> Heights:
    """Solve a rod at heights near a given one.

    Parameters
    ----------
    theta, eta : float
        Taper factor, and the height near which to solve (L).
    contact, pull
        As in `respond`.
    progress : callable
        Told after each height how many of the `NODES` + 1 are done.
    mounting : Mounting

    Returns
    -------
    Heights
        From η − `REACH` to η + `REACH`, or less near 1.

    Raises
    ------
    NoResponseError
        If one of the branches is not solved, or they do not have the same landmarks.
    ArgumentError
        If an argument is out of range.
    """
    if not 0.0 < eta < 1.0:
        raise ArgumentError(f"eta must lie between 0 and 1, got {eta!r}")
    reach = min(REACH, REACH_PART * (1.0 - eta), 0.5 * eta)
    nodes = eta - reach + 2.0 * reach * chebyshev_nodes(NODES)
    solved: list[Response] = []
    for node in nodes:
        solved.append(respond(theta, float(node), contact, pull, mounting))
        progress(len(solved))
    found = Heights(low=eta - reach, high=eta + reach, branches=tuple(solved))
    where = f"for heights from {found.low:.6g} to {found.high:.6g} (in units of L)"
    landmarks = {
        (len(branch.bounds), int(np.argmin(np.abs(branch.bounds - branch.x0_lock))))
        for branch in solved
    }
    if len(landmarks) > 1 or len({branch.curve.end for branch in solved}) > 1:
        raise NoResponseError(
            f"{where} the kind of contact or the end of the curve changes, so that the height "
            "cannot be estimated: give the height"
        )
    # Between the nodes the interpolation must agree with a branch that it has not seen.
    between = float(nodes[NODES // 2 : NODES // 2 + 2].mean())
    resolved = _agrees(found.at(between), respond(theta, between, contact, pull, mounting))
    progress(NODES + 1)
    if not resolved:
        raise NoResponseError(f"the rod's response is not resolved {where}: give the height")
    return found


def _agrees(found: Branch, solved: Branch) -> bool:
    """Whether an interpolated branch is, up to the lock, the one that was solved there."""
    x = np.linspace(solved.x0_pull, solved.x0_lock, POINTS)[1:-1]
    error = np.abs(found(np.clip(x, *found.bounds[[0, -1]])) - solved(x))
    return bool(error.max() <= TOLERANCE * np.abs(solved(x)).max())
