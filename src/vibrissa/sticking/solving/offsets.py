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
from vibrissa.numerics.arrays import FloatArray, IntArray
from vibrissa.outcomes import Contact, Status
from vibrissa.sticking.solving.beginning import NO_INITIAL_STATE, Rods, begin_mounted
from vibrissa.sticking.solving.continuation import follow
from vibrissa.sticking.solving.refinement import NODES_ALONG_ROD, NOT_RESOLVED, is_resolved
from vibrissa.sticking.solving.segments import STEP_SIZES, Segment, StepSizes

# A state with a smaller margin of stability stands at a limit point.
FOLD_MARGIN = 1e-3
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
    for sizes in STEP_SIZES:
        kinds = np.array([mounted[rod].is_ideal_rod for rod in of[pending]], dtype=bool)
        for ideal in np.unique(kinds):
            rows = pending[kinds == ideal]
            rods, which = np.unique(of[rows], return_inverse=True)
            some = Rods.of(theta[rods], eta[rods], [mounted[rod] for rod in rods])
            for row, solution in zip(
                rows, _in_offsets(some, which, offsets[rows], sizes, model), strict=True
            ):
                solutions[row] = solution
        pending = pending[[solutions[row].status is Status.FAILED for row in pending]]
    return solutions


def _in_offsets(
    rods: Rods, of: IntArray, offsets: FloatArray, sizes: StepSizes, model: Contact
) -> list[StateSolution]:
    """Solve states with prescribed offsets in steps of given sizes."""
    begun, index, missing = begin_mounted(rods, sizes, model)
    place = np.full(len(rods), -1)
    place[index] = np.arange(len(index))
    solutions = [StateSolution(None, np.nan, Status.FAILED, NOT_FOLLOWED)] * len(offsets)
    for row in np.flatnonzero(place[of] < 0):
        status, message = missing[int(of[row])]
        solutions[row] = solutions[row]._replace(status=status, message=message)
    rows = np.flatnonzero(place[of] >= 0)
    if len(rows):
        found = _at_offsets(begun.take(place[of[rows]]), offsets[rows], sizes, model)
        for row, solution in zip(rows, found, strict=True):
            solutions[row] = solution
    return solutions


def _at_offsets(
    begun: Segment, offsets: FloatArray, sizes: StepSizes, model: Contact
) -> list[StateSolution]:
    """Follow branches to offsets, one for each."""
    # From α = 0 in steps no longer than those of the first segment.
    way = begun.branches.x1_init - offsets
    count = max(1, int(np.ceil((np.abs(way) / (sizes.x0 * begun.branches.scale)).max())))
    segment = follow(replace(begun, step=way / count), count, model)
    solutions = [StateSolution(None, np.nan, Status.FAILED, NOT_FOLLOWED)] * len(offsets)
    followed, line = segment.last >= count, segment.line[-1]
    for contact, kind in ((Contact.POINT, ~line), (Contact.LINE, line)):
        rows = np.flatnonzero(followed & kind)
        if len(rows):
            closure = Closure.at_offset(offsets[rows], contact)
            eta = segment.branches.eta[rows]
            found = _resolved_states(segment.steps[-1].take(rows), eta, closure)
            for row, solution in zip(rows, found, strict=True):
                solutions[row] = solution
    return solutions


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
