"""Continuation: paths of equilibria are followed from α = 0, by Keller's pseudo-arclength.

A path is a row of *knots*: states, each with the direction in which the path goes on. The next one
lies on the plane normal to that direction, a step ahead. Steps are as long as the guess by the
tangents allows. So a path is followed where the displacement or the force turns back, too.

With ``contact: point`` the tip alone touches the surface throughout. With ``contact: line`` each
state has the kind of contact that is possible: the tip touches where φ1 ≥ 0, and the rod lies along
the surface, s_c ≤ 1, where it would pass through it. Where one of them is violated both hold at
once, φ1 = 0 and s_c = 1: the path has a kink there, which is solved as a state of its own, and from
which it goes on to the other side.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from vibrissa.mechanics.equations import Closure, contact_position, ends, path_coordinates
from vibrissa.mechanics.newton import solve, tangent
from vibrissa.mechanics.states import UNKNOWNS, RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray, SingleArray
from vibrissa.numerics.batch import Batch
from vibrissa.outcomes import Contact
from vibrissa.sticking.solving.branches import Branches

# First and shortest step.
FIRST_STEP, SHORTEST_STEP = 0.05, 1e-6
# Difference of guess and state (rad) that a step aims at, and that it must not pass.
AIM, TOO_FAR = 0.04, 0.2
# Least cosine of the angle between the directions of two knots.
LEAST_COSINE = 0.5
# Share of the displacement in a direction that tells for certain that it turns back: a thin tip
# peels off the surface, or rolls onto it, at nearly the same displacement.
BACK = 1e-4
# A path that needs more steps is given up.
MOST_STEPS = 400
# Accuracy of the states: they are guesses for what is solved exactly.
TOLERANCE = 1e-5
# Corrections of a state that is guessed well.
FEW_ITERATIONS = 8
# Part of the way along a tangent by which the change of the offset is found.
A_LITTLE = 1e-4


@dataclass(frozen=True, eq=False, kw_only=True)
class Knots(Batch):
    """States on paths, with the directions in which these go on.

    Attributes
    ----------
    branch : ndarray of int, shape (n,)
        Which branch each belongs to.
    states : RodStates
    line : ndarray of bool, shape (n,)
        Whether each is in line contact.
    change : RodStates
        Derivatives of the unknowns along the path.
    direction : ndarray, shape (n, 4)
        The same of its coordinates (`Branches.coordinates`), of length 1.
    step : ndarray, shape (n,)
        Step from the knot before; 0 where a path begins, and behind a kink.
    inverse : ndarray, shape (n, k, k)
        What corrects states nearby.
    """

    branch: IntArray
    states: RodStates
    line: BoolArray
    change: RodStates
    direction: FloatArray
    step: FloatArray
    inverse: SingleArray


class Followed(NamedTuple):
    """Paths of a batch of branches.

    Attributes
    ----------
    knots : Knots
        Of all branches, one after the other, in the order of the displacement.
    origins, ends : ndarray of bool, shape (knots,)
        The knots at α = 0, and those up to which paths were followed.
    lost : ndarray of bool, shape (n,)
        Whether a path could not be followed to its end.
    turned : ndarray of bool, shape (n,)
        Whether it ends in a kink, as the displacement turns back there.
    """

    knots: Knots
    origins: BoolArray
    ends: BoolArray
    lost: BoolArray
    turned: BoolArray


# Maps branches, one for each knot, and their next knots to whether the paths end there.
Ended = Callable[[Branches, Knots], BoolArray]


def follow(
    branches: Branches,
    states: RodStates,
    line: BoolArray,
    side: FloatArray,
    model: Contact,
    ended: Ended,
    longest: float,
) -> Followed:
    """Follow paths from their α = 0 states until they end or the displacement turns back.

    Parameters
    ----------
    branches : Branches
    states : RodStates
        The first states.
    line : ndarray of bool, shape (n,)
        Whether these are in line contact.
    side : ndarray, shape (n,)
        1 where the clamp pushes the rod, -1 where it pulls.
    model : Contact
        POINT for contact with the tip alone, LINE for the kind that is possible.
    ended : callable
    longest : float
        Longest step.

    Returns
    -------
    Followed
    """
    count = len(line)
    none = np.zeros(count)
    # The offset falls while the displacement grows.
    last = _knots(branches, np.arange(count), states, line, branches.at_x0(none), none, -side)
    before, step = last, np.full(count, FIRST_STEP)
    lost, turned = np.zeros((2, count), dtype=bool)
    known = [last]
    for _ in range(MOST_STEPS):
        if not len(last):
            break
        step = np.minimum(step, longest)
        new, found, miss = _next(branches.take(last.branch), last, before, step)
        step = np.where(found, step * _growth(miss), step / 3.0)
        lost[last.branch[step < SHORTEST_STEP]] = True
        goes_on = step >= SHORTEST_STEP
        rows = np.flatnonzero(found & goes_on)
        new = new.take(rows)
        if len(rows):
            some = branches.take(new.branch)
            here, ahead, solved, kinks = _bent(some, last.take(rows), new, model)
            lost[new.branch[~solved]] = True
            known.append(here.take(solved))
            known.append(ahead.take(kinks & solved))
            back = ahead.direction[:, 0] * side[new.branch] < -BACK
            turned[new.branch[kinks & solved & back]] = True
            stop = back | ~solved | ended(some, here)
            before_new = last.take(rows)
            last, before = last.copy(), before.copy()
            last.put(rows, ahead)
            before.put(rows, before_new)
            step[rows] = np.where(kinks, np.minimum(step[rows], FIRST_STEP), step[rows])
            goes_on[rows] &= ~stop
        if not goes_on.all():
            last, before, step = last.take(goes_on), before.take(goes_on), step[goes_on]
    lost[last.branch] = True
    return Followed(*_in_order(Knots.concatenate(known), side), lost, turned)


def _in_order(knots: Knots, side: FloatArray) -> tuple[Knots, BoolArray, BoolArray]:
    """Put the knots of each path together, in the order of x0; which are origins, and ends."""
    order = np.argsort(knots.branch, kind="stable")
    knots, origins = knots.take(order), order < len(side)
    ends = np.append(origins[1:], True)
    backwards = np.flatnonzero(side[knots.branch] < 0.0)
    if len(backwards):
        knots, turning = _reversed(knots, backwards)
        origins, ends = origins[turning], ends[turning]
    return knots, origins, ends


def _reversed(knots: Knots, backwards: IntArray) -> tuple[Knots, IntArray]:
    """Turn paths round that were followed backwards, the last ones of the knots."""
    rows = backwards[np.lexsort((-backwards, knots.branch[backwards]))]
    turning = np.arange(len(knots))
    turning[backwards] = rows
    turned = knots.take(turning)
    # The step to a knot is the one from it now; none leads to the first of a path.
    step = turned.step.copy()
    step[backwards] = np.append(0.0, knots.step[rows[:-1]])
    first = np.append(True, np.diff(turned.branch[backwards]) != 0)
    step[backwards[first]] = 0.0
    sign = np.ones(len(knots))
    sign[backwards] = -1.0
    change = _moved(_nothing(turned.change), turned.change, sign)
    direction = turned.direction * sign[:, None]
    return replace(turned, step=step, change=change, direction=direction), turning


def _growth(miss: FloatArray) -> FloatArray:
    """Longer steps where the guess was good."""
    return np.clip(np.cbrt(AIM / (miss + 1e-12)), 0.5, 2.5)


def _next(
    branches: Branches, last: Knots, before: Knots, step: FloatArray
) -> tuple[Knots, BoolArray, FloatArray]:
    """Find the next knots; say which are found, and how far the guesses were from them (rad)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        bend = np.where(last.step > 0.0, 0.5 * step**2 / last.step, 0.0)
    guess = _moved(last.states, last.change, step + bend)
    guess = _moved(guess, before.change, -bend)
    value = np.vecdot(last.direction, branches.coordinates(last.states)) + step
    closure = branches.at_advance(value, last.direction)
    states, found = solve_kinds(guess, branches.height, closure, last.line, last.inverse)
    miss = np.abs(states.phi - guess.phi).max(axis=1)
    found = found & (miss < TOO_FAR) & (states.s_c > 0.0)
    rows = np.flatnonzero(found)
    new = last.copy()
    if len(rows):
        some = branches.take(rows), last.branch[rows], states.take(rows), last.line[rows]
        new.put(rows, _knots(*some, closure.take(rows), step[rows]))
    found &= np.vecdot(new.direction, last.direction) > LEAST_COSINE
    return new, found, miss


def _moved(states: RodStates, change: RodStates, step: FloatArray) -> RodStates:
    """States a step along their changes."""
    return replace(
        states,
        phi=states.phi + step[:, None] * change.phi,
        fx=states.fx + step * change.fx,
        fy=states.fy + step * change.fy,
        s_c=states.s_c + step * change.s_c,
    )


def _knots(
    branches: Branches,
    branch: IntArray,
    states: RodStates,
    line: BoolArray,
    closure: Closure,
    step: FloatArray,
    side: FloatArray | float = 1.0,
) -> Knots:
    """Knots in given states: what the closure prescribes grows along the path, or falls."""
    change, inverse = _tangents(states, closure, line)
    # The offset alone is not linear in the unknowns.
    little = np.full(len(line), A_LITTLE)
    back, ahead = (contact_position(_moved(states, change, way))[0] for way in (-little, little))
    offset = (ahead - back) / (2.0 * A_LITTLE)
    direction = path_coordinates(offset, change, branches.scale, branches.force)
    scale = side / np.linalg.norm(direction, axis=1)
    return Knots(
        branch=branch,
        states=states,
        line=line,
        change=_moved(_nothing(change), change, scale),
        direction=direction * scale[:, None],
        step=step,
        inverse=inverse,
    )


def _nothing(states: RodStates) -> RodStates:
    """No change of states."""
    none: dict[str, Any] = {name: np.zeros_like(states.columns[name]) for name in UNKNOWNS}
    return replace(states, **none)


def _tangents(
    states: RodStates, closure: Closure, line: BoolArray
) -> tuple[RodStates, SingleArray]:
    """Tangents of a batch in which each state has its kind of contact."""
    parts = [
        (rows, *tangent(states.take(rows), replace(closure.take(rows), contact=contact)))
        for contact, rows in _kinds(line)
    ]
    if len(parts) == 1:
        return parts[0][1:]
    change = replace(states, mounting=None).copy()
    inverse = np.empty((len(line), *parts[0][2].shape[1:]), dtype=np.float32)
    for rows, changes, inverses in parts:
        change.put(rows, changes)
        inverse[rows] = inverses
    return change, inverse


def solve_kinds(
    guess: RodStates,
    eta: FloatArray,
    closure: Closure,
    line: BoolArray,
    inverse: SingleArray | None = None,
    iterations: int = FEW_ITERATIONS,
) -> tuple[RodStates, BoolArray]:
    """Solve a batch in which each state has its kind of contact.

    Parameters
    ----------
    guess : RodStates
    eta : ndarray, shape (n,)
        Heights of the surface (L).
    closure : Closure
        What is prescribed; its kind of contact does not matter.
    line : ndarray of bool, shape (n,)
        Which are in line contact.
    inverse : ndarray, shape (n, k, k), optional
        What corrects them, where it is known.
    iterations : int
        Most corrections of each.

    Returns
    -------
    states : RodStates
        NaN where none was found.
    found : ndarray of bool, shape (n,)
    """
    states, found = guess.unsolved(), np.zeros(len(guess), dtype=bool)
    for contact, rows in _kinds(line):
        solution = solve(
            guess.take(rows),
            eta[rows],
            replace(closure.take(rows), contact=contact),
            None if inverse is None else inverse[rows],
            tolerance=TOLERANCE,
            iterations=iterations,
        )
        found[rows] = solution.converged
        states.put(rows, solution.states)
    return states, found


def _kinds(line: BoolArray) -> list[tuple[Contact, IntArray]]:
    """Rows of each kind of contact, as far as there are any."""
    kinds = (Contact.POINT, np.flatnonzero(~line)), (Contact.LINE, np.flatnonzero(line))
    return [(contact, rows) for contact, rows in kinds if len(rows)]


class _Bent(NamedTuple):
    """The next knots of paths, where a kink may lie before them.

    Attributes
    ----------
    here, ahead : Knots
        The last ones before a kink, and the first ones behind it; the same where there is none.
    solved : ndarray of bool, shape (n,)
        Whether they were found.
    kinks : ndarray of bool, shape (n,)
        Where there is one.
    """

    here: Knots
    ahead: Knots
    solved: BoolArray
    kinks: BoolArray


def _bent(branches: Branches, last: Knots, new: Knots, model: Contact) -> _Bent:
    """Put kinks where the next knots have a kind of contact that is not possible."""
    solved, kinks = np.ones(len(new), dtype=bool), np.zeros(len(new), dtype=bool)
    if model is Contact.LINE:
        before, after = _violation(last), _violation(new)
        kinks = after > 0.0
    rows = np.flatnonzero(kinks)
    if not len(rows):
        return _Bent(new, new, solved, kinks)
    step = new.step[rows]
    share = np.clip(before[rows] / (before[rows] - after[rows]), 0.0, 1.0)
    both = Knots.concatenate([last.take(rows), new.take(rows)])
    ends = step[:, None] * np.array([0.0, 1.0])
    pairs = np.arange(len(rows))[:, None] + np.array([0, len(rows)])
    guess = between(both, pairs, share * step, ends, np.ones_like(ends))
    states, solved[rows] = switch_states(guess, branches.take(rows))
    here, ahead = new.copy(), new.copy()
    found = solved[rows]
    if found.any():
        some = branches.take(rows[found]), last.take(rows[found]), states.take(found)
        for knots, kink in zip((here, ahead), _kink(*some), strict=True):
            knots.put(rows[found], kink)
    return _Bent(here, ahead, solved, kinks)


def _violation(knots: Knots) -> FloatArray:
    """How far states are beyond what their kind of contact allows; negative where they are not."""
    return np.where(knots.line, knots.states.s_c - 1.0, -ends(knots.states).phi1)


def _kink(branches: Branches, last: Knots, states: RodStates) -> tuple[Knots, Knots]:
    """Both sides of states in which the contact changes its kind."""
    none = np.zeros(len(last))
    way = branches.coordinates(states) - branches.coordinates(last.states)
    step = np.vecdot(last.direction, way)
    here = branches.at_advance(none, last.direction)
    # Behind it s_c falls from 1, or the slope of the tip rises from 0.
    lies = ~last.line
    ahead = branches.tilted(Closure.at_switch(len(last)))
    ahead = replace(ahead, of_phi1=np.where(lies, 0.0, 1.0), of_s_c=np.where(lies, -1.0, 0.0))
    return (
        _knots(branches, last.branch, states, last.line, here, step),
        _knots(branches, last.branch, states, lies, ahead, none),
    )


def switch_states(guess: RodStates, branches: Branches) -> tuple[RodStates, BoolArray]:
    """Solve the states in which the contact changes its kind: s_c = 1 and φ1 = 0.

    Parameters
    ----------
    guess : RodStates
        States near the change.
    branches : Branches

    Returns
    -------
    states : RodStates
        NaN where none was found.
    found : ndarray of bool, shape (n,)
    """
    solution = solve(guess, branches.height, branches.tilted(Closure.at_switch(len(guess))))
    return solution.states, solution.converged


def between(
    knots: Knots, pairs: IntArray, target: FloatArray, value: FloatArray, slope: FloatArray
) -> RodStates:
    """Guess states between two knots each, by cubics through both and along their tangents.

    Parameters
    ----------
    knots : Knots
    pairs : ndarray of int, shape (..., 2)
        Both knots of each.
    target : ndarray, shape (...)
        Where the states are wanted, as values of some parameter.
    value, slope : ndarray, shape (..., 2)
        The parameter in both knots, and its derivative along the path.

    Returns
    -------
    RodStates
    """
    low, high = pairs[..., 0], pairs[..., 1]
    length = value[..., 1] - value[..., 0]
    t = (target - value[..., 0]) / length
    s = 1.0 - t
    weights = (
        s * s * (1.0 + 2.0 * t),
        t * t * (1.0 + 2.0 * s),
        length * t * s * s / slope[..., 0],
        -length * t * t * s / slope[..., 1],
    )

    def combined(name: str) -> FloatArray:
        column, change = knots.states.columns[name], knots.change.columns[name]
        terms = column[low], column[high], change[low], change[high]
        shape = *low.shape, *[1] * (column.ndim - 1)
        return np.sum([w.reshape(shape) * term for w, term in zip(weights, terms, strict=True)], 0)

    guess: dict[str, Any] = {name: combined(name) for name in UNKNOWNS}
    return replace(knots.states.take(low), **guess)
