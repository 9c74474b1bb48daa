"""A whisker, solved as a recording needs it: exactly for what is read, quickly for what is tried.

The friction is read with a response that covers x0 < 0. To tell how readings change with the rod,
it is enough to know it where the recording is, and on an oblique stage at few heights.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from scipy.interpolate import CubicSpline

from vibrissa.errors import NoResponseError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.spectral import chebyshev_nodes, chebyshev_transform
from vibrissa.numerics.splines import joined
from vibrissa.sensor.identification.periods import Placed
from vibrissa.sensor.response.branch import Response, responses
from vibrissa.sensor.response.height_range import HIGHEST, LOWEST, HeightRange
from vibrissa.sensor.response.heights import Heights
from vibrissa.sensor.stage import ObliqueStage
from vibrissa.sensor.whisker import Progress, Whisker, quiet

# Heights per part of the range of an oblique stage, and the widest part, of the gap 1 − η (L).
FEW, WIDE = 4, 0.3
# How much farther it is known, as a part of that gap: for stages at heights beside it.
ROOM = 0.03
# How far a branch is continued to x0 < 0, from which part of it, and by a polynomial of which order
# (parts of the displacement at the lock): good to 2e-5.
BEYOND, WINDOW, ORDER = 0.05, 0.3, 8


@dataclass(frozen=True, kw_only=True)
class Solver:
    """Solves whiskers for one recording.

    Attributes
    ----------
    clamp : ndarray
        Positions of the clamp (L).
    backward : bool
        Whether it goes backward.
    pulled : bool
        Whether the recording has states in which the clamp pulls the tip.
    """

    clamp: FloatArray
    backward: bool
    pulled: bool

    def exact(self, whisker: Whisker, progress: Progress = quiet) -> Placed:
        """Solve a whisker for reading friction."""
        if whisker.mounting.stage_angle:
            return whisker.stage(self.clamp, self.backward, progress)
        return whisker.response(self.backward)

    def quick(self, *whiskers: Whisker) -> list[Placed]:
        """Solve whiskers for telling how readings change, all at once."""
        plans = [self._heights(whisker) for whisker in whiskers]
        wanted = [
            replace(whisker, eta=float(eta), mounting=replace(whisker.mounting, stage_angle=0.0))
            for whisker, heights in zip(whiskers, plans, strict=True)
            for eta in heights.ravel()
        ]
        solved = iter(self._solved(wanted))
        found: list[Placed] = []
        for whisker, heights in zip(whiskers, plans, strict=True):
            branches = [[next(solved) for _ in part] for part in heights]
            if not whisker.mounting.stage_angle:
                found.append(branches[0][0])
                continue
            parts = tuple(map(_few, branches, heights))
            angle = whisker.mounting.stage_angle
            of_heights = HeightRange(parts=parts, below="", above="")
            found.append(ObliqueStage(heights=of_heights, eta=whisker.eta, angle=angle))
        return found

    def _heights(self, whisker: Whisker) -> FloatArray:
        """Heights at which a whisker is solved, a row for each part of their range (L)."""
        angle = whisker.mounting.stage_angle
        if not angle:
            return np.array([[whisker.eta]])
        reached = whisker.eta - np.append(self.clamp, 0.0) * np.sin(angle)
        room = ROOM * (1.0 - float(reached.max()))
        low = max(float(reached.min()) - room, LOWEST)
        high = min(float(reached.max()) + room, HIGHEST)
        edges = np.linspace(
            low, high, max(1, int(np.ceil((high - low) / (WIDE * (1.0 - high))))) + 1
        )
        return np.asarray(edges[:-1, None] + np.diff(edges)[:, None] * chebyshev_nodes(FEW))

    def _solved(self, whiskers: Sequence[Whisker]) -> list[Response]:
        """Solve whiskers on level stages."""
        if not whiskers:
            return []
        one = whiskers[0]
        found = responses(
            [whisker.theta for whisker in whiskers],
            [whisker.eta for whisker in whiskers],
            one.contact,
            self.pulled,
            [whisker.mounting for whisker in whiskers],
            one.section,
        )
        return found if self.pulled else [_continued(response) for response in found]


def _continued(response: Response) -> Response:
    """Continue a branch a little to x0 < 0: readings at rest may lie there, by an error of the rod.

    The branch is smooth there; the polynomial through its states beside 0 goes on with it.
    """
    part, back = WINDOW * response.x0_lock, -BEYOND * response.x0_lock
    nodes = chebyshev_nodes(ORDER + 1)
    series = chebyshev_transform(ORDER + 1) @ response(part * nodes)
    x0 = np.linspace(back, 0.0, 2 * ORDER)
    before = CubicSpline(x0, chebvander(2.0 * x0 / part - 1.0, ORDER) @ series)
    return replace(
        response,
        reactions=joined([before, response.reactions]),
        bounds=np.append(back, response.bounds),
    )


def _few(branches: Sequence[Response], heights: FloatArray) -> Heights:
    """Interpolate the branch between few heights."""
    low, high = float(heights[0]), float(heights[-1])
    # What ends a branch, far past its lock, may change with the height: no derivative needs it.
    if len({len(branch.bounds) for branch in branches}) > 1:
        raise NoResponseError(
            f"for heights from {low:.6g} to {high:.6g} (in units of L) the kind of contact changes"
        )
    return Heights(low=low, high=high, branches=tuple(branches))
