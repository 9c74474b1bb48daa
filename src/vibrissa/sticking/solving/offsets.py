"""Single states with prescribed offsets x1 − x0, on the branches that begin at α = 0."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.admissibility import clearances
from vibrissa.mechanics.equations import OFFSET, ClosingCondition, ends
from vibrissa.mechanics.mounting import Mounting, rod_columns
from vibrissa.mechanics.stability import stability
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.outcomes import Contact, Status
from vibrissa.sticking.solving.beginning import Beginning, begin
from vibrissa.sticking.solving.branches import Branches
from vibrissa.sticking.solving.cutting import resolved_states
from vibrissa.sticking.solving.following import (
    CLOSENESS,
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
    theta: float, eta: float, mounting: Mounting, offsets: FloatArray, model: Contact
) -> list[StateSolution]:
    """Solve states of a rod with prescribed offsets x1 − x0 (L) on the branch from α = 0."""
    rods = rod_columns(np.array([theta]), [mounting])
    solutions = [StateSolution(None, np.nan, Status.FAILED, NOT_FOLLOWED)] * len(offsets)
    pending = np.arange(len(offsets))
    for closeness in CLOSENESS:
        if not len(pending):
            break
        begun = begin(rods, np.array([eta]), np.zeros(1), closeness.nodes, model)
        for row, solution in _followed(begun, offsets[pending], model, closeness.longest):
            solutions[pending[row]] = solution
        pending = pending[[solutions[row].status is Status.FAILED for row in pending]]
    return solutions


def _followed(
    begun: Beginning, offsets: FloatArray, model: Contact, longest: float
) -> Iterator[tuple[int, StateSolution]]:
    """Solve the states that are reached by steps of a length, on as many nodes as each needs."""
    if begun.missing:
        yield from enumerate([StateSolution(None, np.nan, *begun.missing[0])] * len(offsets))
        return
    which = np.zeros(len(offsets), dtype=np.int64)
    branches, states = begun.branches.take(which), begun.states.take(which)
    guess, reached = _reached(branches, states, offsets, model, longest)
    closing = ClosingCondition.prescribing(branches.eta[reached], {OFFSET: 1.0}, offsets[reached])
    for row, fold in zip(reached.tolist(), stability(guess) < FOLD_MARGIN, strict=True):
        yield row, StateSolution(None, np.nan, Status.FAILED, AT_FOLD if fold else NOT_RESOLVED)
    for rows, solved, residual in resolved_states(guess, closing):
        shapes = clearances(solved, closing.height[rows])
        for i, row in enumerate(reached[rows].tolist()):
            if how := shapes.reasons(i):
                yield row, StateSolution(None, np.nan, Status.OUT_OF_REACH, how)
            else:
                state = solved.take(slice(i, i + 1))
                yield row, StateSolution(state, float(residual[i]), Status.SOLVED, "")


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
