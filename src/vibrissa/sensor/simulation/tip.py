"""A tip that sticks at one place: where sticking ends, and where the slip after it ends.

While the tip slips, the clamp rests; x0 falls if the tip was pushed, and rises if it was pulled.
The kinetic energy is the integral over x0 of the tangential force less kinetic friction.
"""

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.polynomial.chebyshev import chebpts1
from numpy.typing import ArrayLike
from scipy.interpolate import BPoly
from scipy.optimize import brentq, minimize_scalar
from scipy.special import comb

from vibrissa.errors import ArgumentError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.roots import first_fall
from vibrissa.sensor.response.branch import States
from vibrissa.sensor.response.heights import Stage
from vibrissa.sensor.surfaces import Surface

# Rows of `Tip.margins`: margins against slip forward and backward, and distances of x0 from the
# last computed states in pushing and in pulling.
FORWARD, BACKWARD, END, PULL = range(4)
# Number of clamp positions at which the margins are computed to bracket the end of a period.
LOOKS = 257
# Number of steps that are searched together for the end of a period.
BLOCK = 4096
# Relative excess of |tan α| over μ0 at which a tip still sticks, for rounding.
FULL = 1e-9
# Error of the end of sticking, as reactions are tabulated (L): a step up to there sticks.
TABULATED = 1e-8
# Largest number of slides in a slip: a tip that stops where it cannot stick slides back, less far.
REVERSALS = 100
# Parts of the longest possible slide, within which its end is sought, one part after the other.
PARTS = (0.05, 0.25, 1.0)
# Longest cell of a slide (L), and degree of the polynomial of the force in a cell.
CELL, DEGREE = 1e-4, 6
# Largest distance that counts as 0, in roundings of a position.
ROUNDINGS = 8.0


class SlipLaw(StrEnum):
    """Where a slip ends.

    Attributes
    ----------
    FREE
        At α = 0, where no friction is needed (the paper's assumption).
    KINETIC
        Where |tan α| = μk: the tip slides so slowly that inertia plays no part.
    ENERGY
        Where kinetic friction has dissipated the released bending energy, at zero velocity.
    """

    FREE = "free"
    KINETIC = "kinetic"
    ENERGY = "energy"


# Places in a cell, as parts of it, at which the force is computed: not its ends, where friction may
# jump. `COEFFICIENTS` times the values there are the coefficients of Bernstein polynomials.
NODES = 0.5 + 0.5 * chebpts1(DEGREE + 1)
_K, _T = np.arange(DEGREE + 1), NODES[:, None]
COEFFICIENTS = np.linalg.inv(comb(DEGREE, _K) * _T**_K * (1.0 - _T) ** (DEGREE - _K))


@dataclass(frozen=True, kw_only=True)
class Slip:
    """A slip of the tip, during which the clamp rests.

    Attributes
    ----------
    response : States
        States of the rod over x0, at the present height of the surface above the clamp.
    ratio : float
        Kinetic over static friction, μk/μ0.
    clamp : float
        Position of the clamp along the surface (L).
    side : int
        1 for a tip ahead of the clamp, −1 for a tip behind it.
    """

    response: States
    surface: Surface
    law: SlipLaw
    ratio: float
    clamp: float = 0.0
    side: int = 1

    def end(self, x0: float) -> float:
        """Find where a tip that begins to slip at x0 comes to rest.

        Returns
        -------
        float
            Displacement x0 at rest (L); NaN if x0 leaves the range of the computed states.

        Raises
        ------
        ArgumentError
            If the tip reaches an unknown part of the surface, or slides to and fro for too long.
        """
        x0 = float(self.response.clip(x0))
        if self.law is SlipLaw.FREE:
            # Where a pushed tip was pushed back before, it meets a state with α = 0 there.
            between = self.response.demand(np.linspace(0.0, x0, LOOKS)[1:])
            if x0 > 0.0 and between.min() < 0.0:
                return replace(self, law=SlipLaw.KINETIC, ratio=0.0)._slide(x0)
            return 0.0
        for _ in range(REVERSALS):
            x0 = self._slide(x0)
            if np.isnan(x0):
                return x0
            holds = float(self.surface(self.response.contact(self.clamp, x0, self.side)))
            if abs(float(self.response.demand(x0))) <= holds * (1.0 + FULL):
                return x0
        place = f"the clamp at {self.surface.told(self.clamp)}"
        raise ArgumentError(f"with {place} a slip has over {REVERSALS} slides: take another law")

    def _slide(self, x0: float) -> float:
        """Find x0 where a slide in one direction ends (L); NaN if it leaves the computed states."""
        response, surface = self.response, self.surface
        # A pushed tip slides to lower x0, a pulled one to higher.
        ahead = -1.0 if x0 > 0.0 else 1.0
        contact, onward = response.contact(self.clamp, x0, self.side), -self.side * ahead
        nothing = ROUNDINGS * float(np.spacing(1.0 + abs(contact)))
        kinks = np.append(ahead * (response.bounds - x0), onward * (surface.edges - contact))

        def excess_force(end: float) -> BPoly:
            """Tangential force minus kinetic friction (E·I0/L²), as a function of the distance."""
            breaks = np.concatenate([kinks, np.arange(0.0, end, CELL), [0.0, end]])
            breaks = np.unique(breaks[(breaks >= 0.0) & (breaks <= end)])
            way = breaks[:-1, None] + np.diff(breaks)[:, None] * NODES
            fx, fy, _ = np.moveaxis(response(x0 + ahead * way), -1, 0)
            force = ahead * fx + self.ratio * surface(contact + onward * way) * fy
            return BPoly(COEFFICIENTS @ force.T, breaks)

        longest = abs(float(response.clip(ahead * np.inf)) - x0)
        surface_end = surface.stop if onward > 0.0 else surface.start
        known = min(longest, max(onward * (surface_end - contact), nothing))
        for part in PARTS:
            left = excess_force(part * known)
            stop = first_fall(left.antiderivative() if self.law is SlipLaw.ENERGY else left)
            if np.isfinite(stop):
                # At the edge of a patch a tip stops on the rougher side.
                return x0 + ahead * (stop + 2.0 * nothing)
        surface(contact + onward * longest)  # raises where the surface is not known
        return np.nan


@dataclass(frozen=True, kw_only=True)
class Tip:
    """A tip that sticks at one place.

    Attributes
    ----------
    contact, mu0 : float
        Position of the tip on the surface (L), and coefficient of static friction there.
    side : int
        1 for a tip ahead of the clamp, −1 for a tip behind it.
    begin : int
        Index of the step at which the tip begins to stick.
    slipped : bool
        True if the tip has stuck since a slip or since the start of the scan, False if it has stuck
        since the rod buckled laterally.
    """

    stage: Stage
    contact: float
    mu0: float
    side: int = 1
    begin: int = 0
    slipped: bool = True

    def margins(self, clamp: ArrayLike) -> FloatArray:
        """Compute the four margins of sticking at each clamp position, shape (4, ...).

        The tip sticks while none is negative. Rows `FORWARD` and `BACKWARD`: by how much the
        tangential force may change before the tip slips forward or backward (E·I0/L²). Rows `END`
        and `PULL`: distances of x0 from the largest and the smallest x0 of the computed states (L).
        """
        states, x0 = self.stage.states(clamp, self.contact, self.side)
        fx, fy, _ = np.moveaxis(states(states.clip(x0)), -1, 0)
        forward, backward = fx - self.mu0 * fy, -fx - self.mu0 * fy
        return np.array([forward, backward, states.x0_end - x0, x0 - states.x0_pull])

    def exit(self, clamp: float) -> tuple[int, bool]:
        """Return the row of the least of the `margins`, and whether x0 > 0: the tip is pushed."""
        _, x0 = self.stage.states(clamp, self.contact, self.side)
        return int(np.argmin(self.margins(clamp))), bool(x0 > 0.0)

    def slid(self, clamp: float, surface: Surface, law: SlipLaw, ratio: float) -> float:
        """Position of the tip after a slip (L); NaN if the slip leaves the computed states."""
        states, x0 = self.stage.states(clamp, self.contact, self.side)
        along = float(self.stage.along(clamp))
        slip = Slip(
            response=states, surface=surface, law=law, ratio=ratio, clamp=along, side=self.side
        )
        return states.contact(along, slip.end(float(x0)), self.side)

    def end(self, positions: FloatArray, clamp: float) -> tuple[int, float]:
        """Find the first step at which the tip no longer sticks.

        Parameters
        ----------
        positions : ndarray
            Clamp positions at all steps of the scan (L).
        clamp : float
            Clamp position at which the tip begins to stick (L).

        Returns
        -------
        step : int
            Index of this step in `positions`, or their number if the tip sticks to the end.
        until : float
            Clamp position at which sticking ends (L); NaN if the tip sticks to the end.
        """
        rest = positions[self.begin :]
        # The tip sticks between these clamp positions; an end beyond the path is infinite.
        low = self._limit(clamp, min(clamp, float(rest.min())), -1.0)
        high = self._limit(clamp, max(clamp, float(rest.max())), 1.0)
        # A tip sticks in the step of its slip; after lateral buckling it may slip at once.
        for first in range(self.begin + int(self.slipped), len(positions), BLOCK):
            some = positions[first : first + BLOCK]
            out = np.flatnonzero((some > high + TABULATED) | (some < low - TABULATED))
            if len(out):
                step = first + int(out[0])
                return step, high if positions[step] > high else low
        return len(positions), np.nan

    def _limit(self, begin: float, end: float, way: float) -> float:
        """Clamp position between `begin` and `end` at which sticking ends (L), else infinite."""
        states, _ = self.stage.states(begin, self.contact, self.side)
        stretch = way * float(states.x0_end - states.x0_pull)
        while begin != end:
            until = begin + stretch if abs(stretch) < abs(end - begin) else end
            clamp, left = self._looked(np.linspace(begin, until, LOOKS))
            out = np.flatnonzero(left[1:] <= 0.0)
            if len(out):
                before, after = clamp[out[0]], clamp[out[0] + 1]
                # The first position may be at the end of sticking, up to rounding.
                if left[out[0]] <= 0.0:
                    return float(before)
                return float(brentq(self._least, before, after, xtol=1e-14))
            begin = until
        return way * np.inf

    def _looked(self, clamp: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Add clamp positions at minima of the least margin; return positions and that margin."""
        left = self._least(clamp)
        lowest = (left[1:-1] < left[:-2]) & (left[1:-1] < left[2:])
        for i in np.flatnonzero(lowest) + 1:
            bounds = sorted((clamp[i - 1], clamp[i + 1]))
            found = minimize_scalar(self._least, bounds=bounds, method="bounded")
            clamp, left = np.append(clamp, found.x), np.append(left, found.fun)
        order = np.argsort(np.abs(clamp - clamp[0]))
        return clamp[order], left[order]

    def _least(self, clamp: ArrayLike) -> FloatArray:
        return np.asarray(self.margins(clamp).min(axis=0))
