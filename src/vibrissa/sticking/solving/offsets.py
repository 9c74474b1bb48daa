"""Single states with prescribed offsets x1 − x0, on the branches that begin at α = 0."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.admissibility import clearances
from vibrissa.mechanics.equations import Closure, largest_residual
from vibrissa.mechanics.mounting import Mounting
from vibrissa.mechanics.newton import solve
from vibrissa.mechanics.stability import stability
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.outcomes import Contact, Status
from vibrissa.sticking.solving.beginning import CLOSENESS, NO_INITIAL_STATE, Closeness, Rods, begin
from vibrissa.sticking.solving.branches import Branches
from vibrissa.sticking.solving.following import Knots, between, follow
from vibrissa.sticking.solving.refinement import NODES_ALONG_ROD, NOT_RESOLVED, is_resolved

# A state with a smaller margin of stability stands at a limit point.
FOLD_MARGIN = 1e-3
# Places in a step at which it is asked whether a displacement is reached.
PLACES = 65
NOT_FOLLOWED = (
    "no state at this x1 was found on the branch that begins at alpha = 0; it may end before"
)
AT_FOLD = (
    "the branch turns back here: at its limit point no state can be resolved; try an x1 that is "
    "larger by 1e-9 or more"
)


class StateSolution(NamedTuple):
    """One state that was sought, or why it was not found.

    Attributes
    ----------
    state : RodStates or None
        A batch of one, or None if none was resolved that is admissible.
    residual : float
        Its equilibrium residual.
    status : Status
        ``solved``, ``out_of_reach`` or ``failed``.
    message : str
        Empty, or what went wrong and what to try.
    """

    state: RodStates | None
    residual: float
    status: Status
    message: str


def solve_offsets(
    theta: FloatArray,
    eta: FloatArray,
    of: IntArray,
    offsets: FloatArray,
    model: Contact,
    mountings: Sequence[Mounting],
) -> list[StateSolution]:
    """Solve states with prescribed offsets x1 − x0 on the branches that begin at α = 0.

    Parameters
    ----------
    theta, eta : ndarray, shape (n,)
        Taper factors and heights of the surface (L).
    of : ndarray of int, shape (m,)
        Which of the rods each state belongs to.
    offsets : ndarray, shape (m,)
        Distances of the tip from the clamp along the surface (L).
    model : Contact
        POINT for contact with the tip alone, LINE for the kind of contact that is possible.
    mountings : sequence of Mounting, length n
        Their stages have no part in a single state.

    Returns
    -------
    list of StateSolution
    """
    mounted = [replace(one, stage_angle=0.0) for one in mountings]
    solutions = [StateSolution(None, np.nan, Status.FAILED, NO_INITIAL_STATE)] * len(offsets)
    pending = np.arange(len(offsets))
    for closeness in CLOSENESS:
        kinds = np.array([mounted[rod].is_ideal_rod for rod in of[pending]], dtype=bool)
        for ideal in np.unique(kinds):
            rows = pending[kinds == ideal]
            rods, which = np.unique(of[rows], return_inverse=True)
            some = Rods.of(theta[rods], eta[rods], [mounted[rod] for rod in rods])
            for row, solution in zip(
                rows, _in_offsets(some, which, offsets[rows], closeness, model), strict=True
            ):
                solutions[row] = solution
        pending = pending[[solutions[row].status is Status.FAILED for row in pending]]
    return solutions


def _in_offsets(
    rods: Rods, of: IntArray, offsets: FloatArray, closeness: Closeness, model: Contact
) -> list[StateSolution]:
    """Solve states with prescribed offsets on paths that are followed so closely."""
    begun = begin(rods, closeness.nodes, model)
    place = np.full(len(rods), -1)
    place[begun.rows] = np.arange(len(begun.rows))
    solutions = [StateSolution(None, np.nan, Status.FAILED, NOT_FOLLOWED)] * len(offsets)
    for row in np.flatnonzero(place[of] < 0):
        status, message = begun.missing[int(of[row])]
        solutions[row] = solutions[row]._replace(status=status, message=message)
    rows = np.flatnonzero(place[of] >= 0)
    if len(rows):
        some = place[of[rows]]
        first = begun.branches.take(some), begun.states.take(some), begun.line[some]
        found = _at_offsets(*first, offsets[rows], model, closeness.longest)
        for row, solution in zip(rows, found, strict=True):
            solutions[row] = solution
    return solutions


def _at_offsets(
    branches: Branches,
    states: RodStates,
    line: BoolArray,
    offsets: FloatArray,
    model: Contact,
    longest: float,
) -> list[StateSolution]:
    """Follow branches to offsets, one for each."""
    target = branches.x1_init - offsets
    side = np.where(target < 0.0, -1.0, 1.0)

    def ended(branches: Branches, knots: Knots) -> BoolArray:
        beyond = branches.x0(knots.states) - target[knots.branch]
        return beyond * side[knots.branch] > 0.0

    knots = follow(branches, states, line, side, model, ended, longest).knots
    low, share = _first_reached(branches, knots, target, side)
    rows, step = knots.branch[low], knots.step[low + 1]
    ends, pairs = step[:, None] * np.array([0.0, 1.0]), low[:, None] + np.array([0, 1])
    guess = between(knots, pairs, share * step, ends, np.ones_like(ends))
    solutions = [StateSolution(None, np.nan, Status.FAILED, NOT_FOLLOWED)] * len(offsets)
    for contact, kind in ((Contact.POINT, ~knots.line[low]), (Contact.LINE, knots.line[low])):
        chosen = np.flatnonzero(kind)
        if len(chosen):
            closure = Closure.at_offset(offsets[rows[chosen]], contact)
            found = _resolved_states(guess.take(chosen), branches.eta[rows[chosen]], closure)
            for row, solution in zip(rows[chosen], found, strict=True):
                solutions[row] = solution
    return solutions


def _first_reached(
    branches: Branches, knots: Knots, target: FloatArray, side: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Find behind which knots paths first reach displacements, and at which part of the steps.

    The displacement may turn back within a step.
    """
    some = branches.take(knots.branch)
    x0, slope = some.x0(knots.states), knots.direction[:, 0] * some.x0_unit
    low = np.flatnonzero(knots.step[1:] > 0.0)
    begin, change = slope[low] * knots.step[low + 1], x0[low + 1] - x0[low]
    end = slope[low + 1] * knots.step[low + 1]
    t = np.linspace(0.0, 1.0, PLACES)[:, None]
    # The cubic with these slopes.
    way = t * (begin + t * (3.0 * change - 2.0 * begin - end + t * (begin + end - 2.0 * change)))
    # On the way from α = 0: paths to the other side stand in the order of x0.
    back = side[knots.branch[low]] < 0.0
    way = np.where(back, way[::-1], way) + x0[low]
    beyond = (way - target[knots.branch[low]]) * side[knots.branch[low]] >= 0.0
    reached = np.flatnonzero(beyond.any(axis=0))
    order = reached[np.argsort((side[knots.branch[low]] * low)[reached])]
    _, first = np.unique(knots.branch[low[order]], return_index=True)
    chosen = order[first]
    share = t[beyond[:, chosen].argmax(axis=0), 0]
    return low[chosen], np.where(back[chosen], 1.0 - share, share)


def _resolved_states(guess: RodStates, eta: FloatArray, closure: Closure) -> list[StateSolution]:
    """Solve states of one kind of contact, each on as many nodes as it needs."""
    solutions: dict[int, StateSolution] = {}
    sought = np.arange(len(eta))
    for nodes in NODES_ALONG_ROD:
        height, closed = eta[sought], closure.take(sought)
        states = solve(guess.take(sought).on_nodes(nodes), height, closed).states
        residual = largest_residual(states, height, closed)
        resolved = is_resolved(states, height, closed)
        rows = np.flatnonzero(resolved)
        shapes = clearances(states.take(rows), height[rows], closed.contact)
        for i, row in enumerate(rows):
            solution = StateSolution(
                states.take(rows[[i]]), float(residual[row]), Status.SOLVED, ""
            )
            if how := shapes.reasons(i):
                solution = solution._replace(state=None, status=Status.OUT_OF_REACH, message=how)
            solutions[int(sought[row])] = solution
        sought = sought[~resolved]
        if not len(sought):
            break
    at_fold = stability(guess.take(sought), closure.contact) < FOLD_MARGIN
    for row, folds in zip(sought, at_fold, strict=True):
        why = AT_FOLD if folds else NOT_RESOLVED
        solutions[int(row)] = StateSolution(None, np.nan, Status.FAILED, why)
    return [solutions[row] for row in range(len(eta))]
