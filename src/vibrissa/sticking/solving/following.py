"""Continuation of paths of equilibria from α = 0, by Keller's pseudo-arclength method.

Where the kind of contact changes, φ1 = 0 and s_c = 1: the path has a kink. The state in the kink is
solved.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.equations import FX, PHI1, S_C, ClosingCondition
from vibrissa.mechanics.newton import solve, tangent
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.numerics.batch import Batch
from vibrissa.outcomes import Contact
from vibrissa.sticking.solving.branches import Branches, violation

# First and shortest step along a path.
FIRST_STEP, SHORTEST_STEP = 0.05, 1e-6
# Difference between guess and state (rad): target of the step control, and upper bound.
AIM, TOO_FAR = 0.04, 0.2
# Smallest cosine of the angle between the directions of two successive knots.
LEAST_COSINE = 0.5
# A path turns back if the displacement falls faster than this along it. While a thin tip peels off
# the surface or rolls onto it, the displacement is nearly constant.
TURNS_BACK = 1e-4
# A path that needs more steps is given up.
MOST_STEPS = 400
# Accuracy of the states, which serve as guesses for exact solutions.
TOLERANCE = 1e-5
# Most corrections of a state; a good guess needs no more.
FEW_ITERATIONS = 8


class Closeness(NamedTuple):
    """How closely paths are followed: number of nodes along the rod, longest step on the path."""

    nodes: int
    longest: float


# Tried in this order, until a path is found.
CLOSENESS = (Closeness(24, 0.6), Closeness(48, 0.15), Closeness(108, 0.04))


@dataclass(frozen=True, eq=False, kw_only=True)
class Knots(Batch):
    """Knots of paths: states, and the direction of the path at each of them.

    Attributes
    ----------
    branch : ndarray of int, shape (n,)
        Index of the branch whose path has the knot.
    change : ndarray, shape (n, nodes + 3)
        Derivatives of the state's unknowns with respect to the length of the path.
    direction : ndarray, shape (n, 4)
        Unit tangent of the path in path coordinates (`Branches.coordinates`).
    step : ndarray, shape (n,)
        Step along the path from the previous knot; 0 at the beginning of a path and after a kink.
    """

    branch: IntArray
    states: RodStates
    change: FloatArray
    direction: FloatArray
    step: FloatArray


class Followed(NamedTuple):
    """Paths that were followed, one for each branch.

    Attributes
    ----------
    knots : Knots
        Knots of all paths, one path after the other.
    turned : ndarray of bool, shape (branches,)
        Whether the path ends in a kink at which x0 turns back.
    """

    knots: Knots
    turned: BoolArray

    @property
    def first(self) -> BoolArray:
        """Whether each knot is the first of its path, at α = 0; shape (knots,)."""
        return np.append(True, np.diff(self.knots.branch) != 0)

    @property
    def last(self) -> BoolArray:
        """Whether each knot is the last of its path, shape (knots,)."""
        return np.append(np.diff(self.knots.branch) != 0, True)

    @property
    def kinks(self) -> BoolArray:
        """Whether each knot is on one of the two sides of a kink, shape (knots,)."""
        behind = (self.knots.step == 0.0) & ~self.first
        return behind | np.roll(behind, -1)


# Function of n branches and a new knot of each; returns whether their paths end in these knots.
Ended = Callable[[Branches, Knots], BoolArray]


def follow(
    branches: Branches,
    states: RodStates,
    side: FloatArray,
    model: Contact,
    ended: Ended,
    longest: float,
) -> Followed:
    """Follow paths from their α = 0 states until they end.

    Parameters
    ----------
    states : RodStates
        The α = 0 state of each branch.
    side : ndarray, shape (n,)
        Direction of each path: 1 where the clamp pushes the rod (x0 > 0), -1 where the clamp is
        pulled back (x0 < 0).
    ended : callable
        Function `Ended`: whether paths end in their new knots. They also end where x0 turns back.
    longest : float
        Longest step along a path.
    """
    count = len(side)
    upright = branches.prescribing({FX: 1.0})
    last = _knots(branches, np.arange(count), states, upright, np.zeros(count))
    # Orient the paths, now that the sign of the displacement along them is known.
    way = (np.sign(last.direction[:, 0]) * side)[:, None]
    last = replace(last, change=way * last.change, direction=way * last.direction)
    before, step, known = last, np.full(count, FIRST_STEP), [last]
    turned = np.zeros(count, dtype=bool)
    for _ in range(MOST_STEPS):
        step = np.minimum(step, longest)
        new, found, miss = _next(branches.take(last.branch), last, before, step)
        rows = np.flatnonzero(found)
        growth = np.clip(np.cbrt(AIM / (miss + 1e-12)), 0.5, 2.5)
        step = np.where(found, step * growth, step / 3.0)
        goes_on = step >= SHORTEST_STEP
        if len(rows):
            some, old = branches.take(new.branch), last.take(rows)
            here, ahead, solved, kinks = _with_kinks(some, old, new, model)
            known += [here.take(solved), ahead.take(kinks & solved)]
            back = ahead.direction[:, 0] * side[new.branch] < -TURNS_BACK
            turned[new.branch[kinks & solved & back]] = True
            last, before = last.with_rows(rows, ahead), before.with_rows(rows, old)
            step[rows] = np.where(kinks, np.minimum(step[rows], FIRST_STEP), step[rows])
            goes_on[rows] &= solved & ~back & ~ended(some, here)
        if not goes_on.all():
            last, before, step = last.take(goes_on), before.take(goes_on), step[goes_on]
        if not len(last):
            break
    knots = Knots.concatenate(known)
    return Followed(knots.take(np.argsort(knots.branch, kind="stable")), turned)


class _Step(NamedTuple):
    """Steps of n paths.

    Attributes
    ----------
    knots : Knots
        The next knots of those paths on which one was found, in the order of the paths.
    found : ndarray of bool, shape (n,)
        Whether each path has a next knot.
    miss : ndarray, shape (n,)
        Largest difference of a slope from its guess (rad).
    """

    knots: Knots
    found: BoolArray
    miss: FloatArray


def _next(branches: Branches, last: Knots, before: Knots, step: FloatArray) -> _Step:
    """Find the next knots of paths."""
    bend = np.divide(0.5 * step**2, last.step, out=np.zeros_like(step), where=last.step > 0.0)
    way = (step + bend)[:, None] * last.change - bend[:, None] * before.change
    guess = last.states.with_unknowns(last.states.unknowns + way)
    value = np.vecdot(last.direction, branches.coordinates(last.states)) + step
    closing = branches.along(last.direction, value)
    states, found, _ = solve(guess, closing, TOLERANCE, FEW_ITERATIONS)
    miss = np.abs(states.phi - guess.phi).max(axis=1)
    found &= (miss < TOO_FAR) & (states.s_c > 0.0)
    rows = np.flatnonzero(found)
    some = branches.take(rows), last.branch[rows], states.take(rows), closing.take(rows)
    knots = _knots(*some, step[rows])
    near = np.vecdot(knots.direction, last.direction[rows]) > LEAST_COSINE
    found[rows] = near
    return _Step(knots=knots.take(near), found=found, miss=miss)


def _knots(
    branches: Branches,
    branch: IntArray,
    states: RodStates,
    closing: ClosingCondition,
    step: FloatArray,
) -> Knots:
    """Make knots of states, directed so that the quantity prescribed by E3 grows along the path."""
    found = tangent(states, closing)
    direction = branches.units * found.ends[:, :4]
    length = np.linalg.norm(direction, axis=1, keepdims=True)
    return Knots(
        branch=branch,
        states=states,
        change=found.change / length,
        direction=direction / length,
        step=step,
    )


class _Kinks(NamedTuple):
    """Next knots of paths: `here` before and `ahead` after a kink, equal if there is no kink.

    `kinks` tells which paths have a kink, and `solved` is false where its state was not found.
    """

    here: Knots
    ahead: Knots
    solved: BoolArray
    kinks: BoolArray


def _with_kinks(branches: Branches, last: Knots, new: Knots, model: Contact) -> _Kinks:
    """Replace each knot of `new` whose kind of contact is not possible by the kink before it."""
    solved, kinks = np.ones(len(new), dtype=bool), np.zeros(len(new), dtype=bool)
    if model is Contact.LINE:
        before, after = violation(last.states), violation(new.states)
        kinks = after > 0.0
    rows = np.flatnonzero(kinks)
    if not len(rows):
        return _Kinks(new, new, solved, kinks)
    some, old = branches.take(rows), last.take(rows)
    share = np.clip(before[rows] / (before[rows] - after[rows]), 0.0, 1.0)
    guess = replace(between(old, new.take(rows), share), line=np.zeros(len(rows), dtype=bool))
    states, solved[rows], _ = solve(guess, some.prescribing({PHI1: 1.0}))
    here, ahead, found = new, new, np.flatnonzero(solved[rows])
    if len(found):
        old, states, some = old.take(found), states.take(found), some.take(found)
        way = np.vecdot(old.direction, some.coordinates(states) - some.coordinates(old.states))
        line = old.states.line
        sides = replace(states, line=line), replace(states, line=~line)
        onward = some.along(old.direction, way)
        here = new.with_rows(rows[found], _knots(some, old.branch, sides[0], onward, way))
        # After the kink s_c falls from 1, or the slope of the tip rises from 0.
        lies = line.astype(np.float64)
        growing = some.prescribing({PHI1: lies, S_C: lies - 1.0})
        ahead = new.with_rows(rows[found], _knots(some, old.branch, sides[1], growing, 0.0 * way))
    return _Kinks(here, ahead, solved, kinks)


def between(low: Knots, high: Knots, share: FloatArray) -> RodStates:
    """Guess states at fractions `share` of the steps from knots `low` to `high`, by cubics."""
    unknowns = low.states.unknowns, high.states.unknowns
    change = low.change, high.change
    return low.states.with_unknowns(hermite(share, high.step, *unknowns, *change))


def hermite(
    share: FloatArray,
    step: FloatArray,
    low: FloatArray,
    high: FloatArray,
    low_change: FloatArray,
    high_change: FloatArray,
) -> FloatArray:
    """Interpolate by cubics that have given values and derivatives at two places, `step` apart."""
    t, step = share[..., None], step[..., None]
    s = 1.0 - t
    value = s * s * (1.0 + 2.0 * t) * low + t * t * (1.0 + 2.0 * s) * high
    return np.asarray(value + step * t * s * (s * low_change - t * high_change))
