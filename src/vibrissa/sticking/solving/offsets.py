"""Single states with prescribed offsets x1 − x0, on the branches that begin at α = 0."""

from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.admissibility import LIMITING_CLEARANCES, clearances
from vibrissa.mechanics.equations import OFFSET, ClosingCondition, ends
from vibrissa.mechanics.mounting import Mounting, rod_columns
from vibrissa.mechanics.stability import stability
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import BoolArray
from vibrissa.outcomes import Contact, Status
from vibrissa.sticking.solving.beginning import Beginning, begin
from vibrissa.sticking.solving.branches import Branches
from vibrissa.sticking.solving.cutting import resolved_states
from vibrissa.sticking.solving.following import CLOSENESS, Knots, between, follow, hermite
from vibrissa.sticking.solving.refinement import NOT_RESOLVED

# A state with a smaller margin of stability is at a limit point.
FOLD_MARGIN = 1e-3
# Fractions of a step at which the offset is compared with the prescribed offset.
STEP_FRACTIONS = np.linspace(0.0, 1.0, 65)
NOT_FOLLOWED = (
    "no state at this x1 was found on the branch from alpha = 0; the branch may end before this x1"
)
AT_FOLD = (
    "the branch turns back here: at its limit point no state can be resolved; try an x1 that is "
    "larger by 1e-9 or more"
)


class StateSolution(NamedTuple):
    """Solution of one state; if there is none, `state` is None, and `message` gives the reason."""

    state: RodStates | None
    residual: float
    status: Status
    message: str


def solve_offset(
    theta: float, eta: float, mounting: Mounting, offset: float, model: Contact
) -> StateSolution:
    """Solve the state with a prescribed offset x1 − x0 (L) on the branch from α = 0."""
    rods = rod_columns(np.array([theta]), [mounting])
    for nodes, longest in CLOSENESS:
        begun = begin(rods, np.array([eta]), np.zeros(1), nodes, model)
        if begun.missing:
            solution = StateSolution(None, np.nan, *begun.missing[0])
        else:
            solution = _solved(begun, _reached(begun, offset, model, longest), offset, model)
        if solution.status is not Status.FAILED:
            break
    return solution


def _reached(begun: Beginning, offset: float, model: Contact, longest: float) -> RodStates | None:
    """Guess the state at an offset by following a branch; None if the branch ends before."""
    side = -1.0 if begun.branches.x1_init[0] < offset else 1.0

    def ended(_: Branches, knots: Knots) -> BoolArray:
        return np.asarray((offset - ends(knots.states).offset) * side > 0.0)

    way = begun.branches, begun.states, np.array([side])
    knots = follow(*way, model, ended, longest).knots
    slope = knots.direction[:, 0] / begun.branches.units[0, 0]
    reached = ends(knots.states).offset
    for high in np.flatnonzero(knots.step > 0.0):
        pair = np.array([high - 1, high])
        step = np.full(len(STEP_FRACTIONS), knots.step[high])
        # The displacement may turn back within a step.
        along = hermite(STEP_FRACTIONS, step, *reached[pair], *slope[pair])
        beyond = (offset - along) * side >= 0.0
        if beyond.any():
            share = STEP_FRACTIONS[[int(beyond.argmax())]]
            return between(knots.take(pair[:1]), knots.take(pair[1:]), share)
    return None


def _solved(
    begun: Beginning, guess: RodStates | None, offset: float, model: Contact
) -> StateSolution:
    """Solve a state on as many nodes as it needs."""
    if guess is None:
        return StateSolution(None, np.nan, Status.FAILED, NOT_FOLLOWED)
    closing = ClosingCondition.prescribing(begun.branches.eta, {OFFSET: 1.0}, offset)
    for _, state, residual in resolved_states(guess, closing):
        if len(state):
            if how := clearances(state, closing.height, LIMITING_CLEARANCES[model]).reasons(0):
                return StateSolution(None, np.nan, Status.OUT_OF_REACH, how)
            return StateSolution(state, float(residual[0]), Status.SOLVED, "")
    why = AT_FOLD if stability(guess)[0] < FOLD_MARGIN else NOT_RESOLVED
    return StateSolution(None, np.nan, Status.FAILED, why)
