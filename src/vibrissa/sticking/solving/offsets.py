"""Single states with prescribed offsets x1 − x0, on the branches that begin at α = 0."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.admissibility import clearances
from vibrissa.mechanics.equations import ClosingCondition, ends
from vibrissa.mechanics.mounting import Mounting, rod_columns
from vibrissa.mechanics.stability import stability
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.outcomes import Contact, Status
from vibrissa.sticking.solving.beginning import NO_INITIAL_STATE, begin
from vibrissa.sticking.solving.branches import Branches
from vibrissa.sticking.solving.cutting import resolved_states
from vibrissa.sticking.solving.following import (
    CLOSENESS,
    Closeness,
    Knots,
    between,
    follow,
    hermite,
)
from vibrissa.sticking.solving.refinement import NOT_RESOLVED

# A state with a smaller margin of stability stands at a limit point.
FOLD_MARGIN = 1e-3
# Parts of a step at which the displacement is compared with the wanted one.
PARTS = np.linspace(0.0, 1.0, 65)
NOT_FOLLOWED = (
    "no state at this x1 was found on the branch that begins at alpha = 0; it may end before"
)
AT_FOLD = (
    "the branch turns back here: at its limit point no state can be resolved; try an x1 that is "
    "larger by 1e-9 or more"
)


class StateSolution(NamedTuple):
    """One state that was sought (a batch of one), or why it was not found."""

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
    """Solve states with prescribed offsets x1 − x0 (L) on the branches that begin at α = 0."""
    rods = rod_columns(theta, mountings)
    solutions = [StateSolution(None, np.nan, Status.FAILED, NO_INITIAL_STATE)] * len(offsets)
    pending = np.arange(len(offsets))
    for closeness in CLOSENESS:
        if not len(pending):
            break
        which, index = np.unique(of[pending], return_inverse=True)
        some = rods[which], eta[which], index, offsets[pending]
        for row, solution in zip(pending, _in_offsets(*some, closeness, model), strict=True):
            solutions[row] = solution
        pending = pending[[solutions[row].status is Status.FAILED for row in pending]]
    return solutions


def _in_offsets(
    rods: FloatArray,
    eta: FloatArray,
    of: IntArray,
    offsets: FloatArray,
    closeness: Closeness,
    model: Contact,
) -> list[StateSolution]:
    """Solve states with prescribed offsets on paths that are followed so closely."""
    begun = begin(rods, eta, np.zeros(len(eta)), closeness.nodes, model)
    place = np.full(len(rods), -1)
    place[begun.rows] = np.arange(len(begun.rows))
    solutions = [StateSolution(None, np.nan, Status.FAILED, NOT_FOLLOWED)] * len(offsets)
    for row in np.flatnonzero(place[of] < 0):
        status, message = begun.missing[int(of[row])]
        solutions[row] = solutions[row]._replace(status=status, message=message)
    rows = np.flatnonzero(place[of] >= 0)
    if not len(rows):
        return solutions
    branches, states = begun.branches.take(place[of[rows]]), begun.states.take(place[of[rows]])
    guess, found = _reached(branches, states, offsets[rows], model, closeness.longest)
    rows = rows[found]
    closing = ClosingCondition.at_offset(offsets[rows], branches.eta[found])
    for row, solution in zip(rows, _solved(guess, closing), strict=True):
        solutions[row] = solution
    return solutions


def _reached(
    branches: Branches, states: RodStates, offsets: FloatArray, model: Contact, longest: float
) -> tuple[RodStates, IntArray]:
    """Follow branches to offsets, one for each: guesses of the states, and which are reached."""
    side = np.where(branches.x1_init < offsets, -1.0, 1.0)

    def ahead(offset: FloatArray, branch: IntArray) -> FloatArray:
        """How far ahead of the wanted state the clamp is (L)."""
        return (offsets[branch] - offset) * side[branch]

    def ended(branches: Branches, knots: Knots) -> BoolArray:
        return ahead(ends(knots.states).offset, knots.branch) > 0.0

    followed = follow(branches, states, side, model, ended, longest)
    knots, high = followed.knots, np.flatnonzero(followed.knots.step > 0.0)
    # The displacement may turn back within a step.
    offset = ends(knots.states).offset[:, None]
    slope = (knots.direction[:, 0] / branches.units[knots.branch, 0])[:, None]
    step = np.broadcast_to(knots.step[high, None], (len(high), len(PARTS)))
    sides = [values[at][:, None] for values in (offset, slope) for at in (high - 1, high)]
    way = hermite(np.broadcast_to(PARTS, step.shape), step, *sides)[..., 0]
    beyond = ahead(way.T, knots.branch[high]).T >= 0.0
    reaches = np.flatnonzero(beyond.any(axis=1))
    found, first = np.unique(knots.branch[high[reaches]], return_index=True)
    chosen = reaches[first]
    share = PARTS[beyond[chosen].argmax(axis=1)]
    return between(knots.take(high[chosen] - 1), knots.take(high[chosen]), share), found


def _solved(guess: RodStates, closing: ClosingCondition) -> list[StateSolution]:
    """Solve states, each on as many nodes as it needs."""
    folds = stability(guess) < FOLD_MARGIN
    solutions = [
        StateSolution(None, np.nan, Status.FAILED, AT_FOLD if fold else NOT_RESOLVED)
        for fold in folds
    ]
    for rows, states, residual in resolved_states(guess, closing):
        shapes = clearances(states, closing.height[rows])
        for i, row in enumerate(rows.tolist()):
            solution = StateSolution(
                states.take(slice(i, i + 1)), float(residual[i]), Status.SOLVED, ""
            )
            if how := shapes.reasons(i):
                solution = solution._replace(state=None, status=Status.OUT_OF_REACH, message=how)
            solutions[row] = solution
    return solutions
