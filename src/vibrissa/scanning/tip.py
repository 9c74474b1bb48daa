"""A tip that sticks at one place of the surface, and where sticking ends as the clamp moves."""

from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.roots import sampled_root
from vibrissa.scanning.stage import Held, Stage
from vibrissa.scanning.surfaces import Footing

# Number of clamp positions at which the margins are computed to bracket the end of a period.
BRACKETING_POSITIONS = 257
# Number of steps that are searched together for the end of a period.
STEPS_AT_ONCE = 4096


class Margin(IntEnum):
    """What a sticking tip may lose; its members are the rows of `Tip.margins`.

    Attributes
    ----------
    FORWARD, BACKWARD
        By how much the tangential force may change before the tip slips forward or backward
        (E·I0/L²).
    END, PULL
        Distances of x0 from the largest and the smallest x0 of the computed states (L).
    ROOM
        How far the clamp–surface distance is within the computed range (L).
    """

    FORWARD = 0
    BACKWARD = 1
    END = 2
    PULL = 3
    ROOM = 4


class ContactForces(NamedTuple):
    """Forces of a surface on a tip, along the surface and normal to it, both times 1/cos γ."""

    tangential: FloatArray
    normal: FloatArray


def contact_forces(fx: ArrayLike, fy: ArrayLike, slope: ArrayLike) -> ContactForces:
    """Resolve the contact force on a surface of the inclination γ, for a slope h' = −tan γ.

    The tangential force T = f·sin(α − γ) is negative while the tip is pushed; N = f·cos(α − γ) is
    positive while the surface pushes the tip. They are divided by cos γ: times a distance dx they
    give the work along the surface.

    Parameters
    ----------
    fx, fy : array_like
        Clamp reactions f·sin α and −f·cos α (E·I0/L²).
    """
    fx, fy, slope = np.asarray(fx), np.asarray(fy), np.asarray(slope)
    return ContactForces(tangential=fx - slope * fy, normal=-slope * fx - fy)


class EndOfSticking(NamedTuple):
    """Where a tip no longer sticks.

    Attributes
    ----------
    stop : int
        Index of the first step at which it does not stick, or the number of steps of the scan.
    until : float
        Clamp position at which sticking ends (L); NaN if the tip sticks to the end of the scan.
    """

    stop: int
    until: float


class Exit(NamedTuple):
    """How sticking ends: which margin is used up, and whether the tip has locked.

    On a plane a tip has locked if the clamp pushes it (x0 > 0) until it slips backward; on a slope
    a pushed tip may slip backward before, down the slope, until −tan α is largest (x0 > x0_lock).
    The phase `TipPhase.LOCK` of a step is another thing: it begins where x0 > x0_lock.
    """

    margin: Margin
    locked: bool


@dataclass(frozen=True, eq=False, kw_only=True)
class ClampPath:
    """Positions of the clamp at all steps of a scan, and how far it still goes from each step on.

    Attributes
    ----------
    positions, least, most : ndarray, shape (n,)
        Position of the clamp at each step, and the least and largest position from there on (L).
    """

    positions: FloatArray
    least: FloatArray
    most: FloatArray

    @classmethod
    def through(cls, positions: FloatArray) -> "ClampPath":
        """Path through given positions (L)."""
        backwards = positions[::-1]
        return cls(
            positions=positions,
            least=np.minimum.accumulate(backwards)[::-1],
            most=np.maximum.accumulate(backwards)[::-1],
        )

    def __len__(self) -> int:
        """Return the number of steps, the first position included."""
        return len(self.positions)


@dataclass(frozen=True, kw_only=True)
class Tip:
    """A tip that sticks at one place.

    Attributes
    ----------
    stage : Stage
        The rod on its stage.
    footing : Footing
        Place of the tip on the surface, with the friction there.
    side : int
        1 for a tip ahead of the clamp, −1 for a tip behind it.
    clamp : float
        Position of the clamp at which the tip begins to stick (L): that of a step or, after lateral
        buckling, between two steps.
    begin : int
        Index of the first step at which the tip sticks, if it still does.
    x0_rest : float
        Displacement x0 at which it came to rest (L); NaN if it has stuck since lateral buckling.
    slipped : bool
        True if the tip has stuck since a slip or since the start of the scan, False if it has stuck
        since the rod buckled laterally.
    """

    stage: Stage
    footing: Footing
    side: int = 1
    clamp: float = 0.0
    begin: int = 0
    x0_rest: float = 0.0
    slipped: bool = True

    @property
    def contact(self) -> float:
        """Position of the tip along the surface (L)."""
        return self.footing.contact

    @property
    def mu0(self) -> float:
        """Coefficient of static friction under the tip."""
        return self.footing.mu0

    def held(self, clamp: ArrayLike) -> Held:
        """Return the states of the rod at clamp positions, and the x0 of each (L)."""
        return self.stage.states(clamp, self.contact, self.side, self.footing.height)

    def margins(self, clamp: ArrayLike) -> FloatArray:
        """Compute the margins of sticking at each clamp position, shape (5, ...).

        The tip sticks while none is negative. `Margin` names the rows.
        """
        held = self.held(clamp)
        states, x0 = held
        loads = held.reactions
        ahead, behind = self.footing.ahead, self.footing.behind
        on_ahead, on_behind = (
            contact_forces(loads[..., 0], loads[..., 1], face.slope) for face in (ahead, behind)
        )
        return np.array(
            [
                on_ahead.tangential + ahead.mu0 * on_ahead.normal,
                behind.mu0 * on_behind.normal - on_behind.tangential,
                states.x0_end - x0,
                x0 - states.x0_pull,
                np.broadcast_to(self.stage.room(clamp, self.footing.height), x0.shape),
            ]
        )

    def exit(self, clamp: float) -> Exit:
        """Return how sticking ends at a clamp position, which is the first one that does not stick.

        There the margin that ends it is about 0 or negative, and the others are positive, so that
        forces and lengths can be compared.
        """
        states, x0 = self.held(clamp)
        least = Margin(int(np.argmin(self.margins(clamp))))
        past = states.x0_lock if self.footing.behind.slope else 0.0
        return Exit(margin=least, locked=bool(x0 > past))

    def sticks_until(self, clamp_path: ClampPath) -> EndOfSticking:
        """Find the first step at which the tip no longer sticks."""
        clamp = self.clamp
        # The tip sticks between these clamp positions; an end beyond the path is infinite.
        low = self._limit(clamp, min(clamp, float(clamp_path.least[self.begin])), -1.0)
        high = self._limit(clamp, max(clamp, float(clamp_path.most[self.begin])), 1.0)
        error = self.stage.at(clamp).accuracy
        # A tip sticks in the step of its slip; after lateral buckling it may slip at once.
        for first in range(self.begin + int(self.slipped), len(clamp_path), STEPS_AT_ONCE):
            positions = clamp_path.positions[first : first + STEPS_AT_ONCE]
            out = np.flatnonzero((positions > high + error) | (positions < low - error))
            if len(out):
                stop = first + int(out[0])
                return EndOfSticking(
                    stop=stop, until=high if clamp_path.positions[stop] > high else low
                )
        return EndOfSticking(stop=len(clamp_path), until=np.nan)

    def _limit(self, begin: float, end: float, direction: float) -> float:
        """Clamp position between `begin` and `end` at which sticking ends (L), else infinite."""
        if begin == end:
            return direction * np.inf
        states, _ = self.held(begin)
        stretch = direction * float(states.x0_end - states.x0_pull)
        while begin != end:
            until = begin + stretch if abs(stretch) < abs(end - begin) else end
            clamp, margin = self._with_minima(np.linspace(begin, until, BRACKETING_POSITIONS))
            out = np.flatnonzero(margin[1:] <= 0.0)
            if len(out):
                # The first position may be at the end of sticking, up to rounding.
                if margin[out[0]] <= 0.0:
                    return float(clamp[out[0]])
                return sampled_root(self._least_margin, clamp, margin, int(out[0]))
            begin = until
        return direction * np.inf

    def _with_minima(self, clamp: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Add clamp positions at minima of the least margin; return positions and that margin."""
        margin = self._least_margin(clamp)
        lowest = (margin[1:-1] < margin[:-2]) & (margin[1:-1] < margin[2:])
        # Sticking ends before what comes after the first position without a margin.
        ended = 1 + int(np.append(margin[1:] <= 0.0, True).argmax())
        for i in np.flatnonzero(lowest[: ended - 1]) + 1:
            from scipy.optimize import minimize_scalar  # half a second to load

            bounds = sorted((clamp[i - 1], clamp[i + 1]))
            found = minimize_scalar(self._least_margin, bounds=bounds, method="bounded")
            clamp, margin = np.append(clamp, found.x), np.append(margin, found.fun)
        order = np.argsort(np.abs(clamp - clamp[0]))
        return clamp[order], margin[order]

    def _least_margin(self, clamp: ArrayLike) -> FloatArray:
        """Return the least of the margins at clamp positions, which is negative after sticking."""
        return np.asarray(self.margins(clamp).min(axis=0))
