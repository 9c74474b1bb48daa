"""One rod at many heights: its branch at any η of a range, from the branches at a few.

Each smooth stretch of the branch, between the same two landmarks (where pulling ends, α = 0, a
kink, the lock, the end), is interpolated over η by the polynomial through Chebyshev points.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from scipy.interpolate import CubicSpline, PPoly

from vibrissa.arrays import FloatArray
from vibrissa.sensor.response import Branch, NoResponse, Response, respond
from vibrissa.spectral import chebyshev_nodes, chebyshev_transform
from vibrissa.status import Contact

# Heights at which the rod is solved, and displacements on each stretch.
NODES = 9
POINTS = 257
# How far from the given height it is looked for (L), and at most as a part of the distance from
# there to 1, where a rod stands upright and the forces have a singularity.
REACH = 0.05
REACH_PART = 1.0 / 3.0
# Error allowed between the nodes, of the largest reaction.
TOLERANCE = 1e-5


@dataclass(frozen=True, eq=False)
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
        ValueError
            If it lies outside.
        """
        position = (2.0 * eta - self.low - self.high) / (self.high - self.low)
        if not abs(position) <= 1.0 + 1e-12:
            raise ValueError(f"eta must lie in [{self.low:.6g}, {self.high:.6g}], got {eta!r}")
        row = chebvander(np.array([position]), len(self.branches) - 1)[0]
        marks, values = row @ self._series[0], np.tensordot(row, self._series[1], axes=1)
        bounds, x1_init = marks[:-1], float(marks[-1])
        parts = [CubicSpline(x, y) for x, y in zip(_displacements(bounds), values, strict=True)]
        joined = PPoly(
            np.concatenate([part.c for part in parts], axis=1),
            np.concatenate([part.x[:-1] for part in parts] + [parts[-1].x[-1:]]),
            extrapolate=False,
        )
        return Branch(joined, float(bounds[self._lock]), x1_init, bounds)


def _displacements(bounds: FloatArray) -> FloatArray:
    """Points on each stretch, shape (stretches, POINTS); crowded where the branch turns back."""
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

    Returns
    -------
    Heights
        From η − `REACH` to η + `REACH`, or less near 1.

    Raises
    ------
    NoResponse
        If one of the branches is not solved, or they differ in more than their measures.
    ValueError
        If an argument is out of range.
    """
    if not 0.0 < eta < 1.0:
        raise ValueError(f"eta must lie between 0 and 1, got {eta!r}")
    reach = min(REACH, REACH_PART * (1.0 - eta), 0.5 * eta)
    nodes = eta - reach + 2.0 * reach * chebyshev_nodes(NODES)
    solved: list[Response] = []
    for node in nodes:
        solved.append(respond(theta, float(node), contact, pull))
        progress(len(solved))
    found = Heights(eta - reach, eta + reach, tuple(solved))
    alike = {
        (len(branch.bounds), int(np.argmin(np.abs(branch.bounds - branch.x0_lock))))
        for branch in solved
    }
    where = f"for heights from {eta - reach:.6g} to {eta + reach:.6g} (in units of L)"
    if len(alike) > 1 or len({branch.curve.end for branch in solved}) > 1:
        raise NoResponse(f"the rod changes its kind of contact or end {where}: give the height")
    # Between the nodes the interpolation must agree with a branch that it has not seen.
    between = float(nodes[NODES // 2 : NODES // 2 + 2].mean())
    check = respond(theta, between, contact, pull)
    x = np.linspace(check.x0_pull, check.x0_lock, POINTS)[1:-1]
    error = np.abs(found.at(between)(np.clip(x, *found.at(between).bounds[[0, -1]])) - check(x))
    progress(NODES + 1)
    if not error.max() <= TOLERANCE * np.abs(check(x)).max():
        raise NoResponse(f"the rod's response is not resolved {where}: give the height")
    return found
