"""First states of branches: α = 0 states in any mounting, by a homotopy from the ideal one."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.buckling import buckled_unknowns
from vibrissa.mechanics.equations import FX, ClosingCondition, bending_moment, ends
from vibrissa.mechanics.mounting import (
    BORE,
    CLAMP_ANGLE,
    CLAMP_COMPLIANCE,
    CURVATURE,
    POWERS,
    THETA,
)
from vibrissa.mechanics.newton import solve
from vibrissa.mechanics.stability import stability
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.outcomes import Contact, Status
from vibrissa.sticking.solving.branches import Branches, violation

# Height (L) from which the surface is lowered, and the first step (share of the homotopy).
HIGHEST, FIRST_SHARE = 0.999, 0.1
# Divisor of a step that fails (one that succeeds is doubled), and shortest step (share of the
# homotopy).
DIVISION, SHORTEST_STEP = 4.0, 1e-4
# Largest difference between a state and its guess, relative to the range of slopes along the rod: a
# state further away is on another branch.
SAME_BRANCH = 0.3
# A branch that cannot be followed further ends in a limit point if its margin of stability is below
# this.
END_MARGIN = 0.1
# Accuracy of the states, which serve as guesses for exact solutions.
TOLERANCE = 1e-8

NO_INITIAL_STATE = (
    "no first-mode state with alpha = 0 found; try a larger eta or a theta closer to 1"
)
SPRINGS = (
    "no state with alpha = 0 is bent towards +x: at {share:.1%} of the way from the ideal mounting "
    "to this one the rod springs to the other side; try a smaller eta or a smaller clamp_angle or "
    "curvature"
)
LEAVES = (
    "the rod does not press on the surface: its tip leaves the surface before {share:.1%} of the "
    "way from the ideal mounting to this one; try a smaller eta"
)
LOST = (
    "the state with alpha = 0 was lost at {share:.1%} of the way from the ideal mounting to this "
    "one; try a slightly different eta, theta or mounting"
)


class Beginning(NamedTuple):
    """The α = 0 states in which branches begin.

    Attributes
    ----------
    branches, states : Branches, RodStates
        Branches of the rods that have an α = 0 state, and these states.
    rows : ndarray of int
        Indices of these rods among all rods.
    missing : dict
        Status and message of each rod without an α = 0 state, by its index.
    """

    branches: Branches
    states: RodStates
    rows: IntArray
    missing: dict[int, tuple[Status, str]]


def begin(
    rods: FloatArray, eta: FloatArray, stage_angle: FloatArray, nodes: int, model: Contact
) -> Beginning:
    """Solve the α = 0 states in which the branches of rods begin; `stage_angle` is δ (rad)."""
    upright = rods.copy()
    upright[:, [CLAMP_ANGLE, CLAMP_COMPLIANCE]] = upright[:, CURVATURE] = 0.0
    ideal, found = _ideal_states(upright, eta, nodes, model)
    missing = {int(row): (Status.FAILED, NO_INITIAL_STATE) for row in np.flatnonzero(~found)}
    states = ideal
    mounted = np.flatnonzero(found & (rods != upright).any(axis=1))
    if len(mounted):
        first, height = states.take(mounted), eta[mounted]
        solved, share = _homotopy(first, rods[mounted], height, height, model, 1.0)
        states = states.with_rows(mounted, solved)
        lost = np.flatnonzero((share < 1.0) | (solved.fy >= 0.0))
        found[mounted[lost]] = False
        for row, why in zip(lost, _reasons(solved.take(lost), share[lost]), strict=True):
            missing[int(mounted[row])] = why
    rows = np.flatnonzero(found)
    ideal, states = ideal.take(rows), replace(states.take(rows), rods=rods[rows])
    branches = Branches(
        rods=states.rods,
        eta=eta[rows],
        tilt=np.tan(stage_angle[rows]),
        x1_init=ends(states).offset,
        scale=ends(ideal).offset,
        force=-ideal.fy,
    )
    return Beginning(branches, states, rows, missing)


def _reasons(states: RodStates, share: FloatArray) -> list[tuple[Status, str]]:
    """Status and message of rods without an α = 0 state, from their last states in the homotopy."""
    springs = stability(states, slides=True) < END_MARGIN
    found = []
    for part, over, lifts in zip(share, springs, states.fy >= 0.0, strict=True):
        status, why = (Status.OUT_OF_REACH, SPRINGS) if over else (Status.FAILED, LOST)
        if lifts:
            status, why = Status.OUT_OF_REACH, LEAVES
        found.append((status, why.format(share=part)))
    return found


def _ideal_states(
    rods: FloatArray, eta: FloatArray, nodes: int, model: Contact
) -> tuple[RodStates, BoolArray]:
    """Solve α = 0 states in the ideal mounting, and mark those that were found."""
    solid = rods.copy()
    solid[:, BORE] = solid[:, POWERS] = 0.0
    states, found = _buckled_states(solid, eta, nodes)
    lies = found & (ends(states).phi1 < 0.0) & (model is Contact.LINE)
    rows = np.flatnonzero(~found | lies)
    if len(rows):
        # Lower the surface step by step.
        high = np.full(len(rows), HIGHEST)
        first, _ = _buckled_states(solid[rows], high, nodes)
        lowest, share = _homotopy(first, first.rods, high, eta[rows], model, FIRST_SHARE)
        states = states.with_rows(rows, lowest)
        found[rows] = share >= 1.0
    made = np.flatnonzero(found & (rods != solid).any(axis=1))
    if len(made):
        # Change the stiffness along the rods step by step.
        first, height = states.take(made), eta[made]
        stiffened, share = _homotopy(first, rods[made], height, height, model, 1.0)
        states = states.with_rows(made, stiffened)
        found[made] = share >= 1.0
    return replace(states, rods=rods), found


def _buckled_states(rods: FloatArray, eta: FloatArray, nodes: int) -> tuple[RodStates, BoolArray]:
    """Solve α = 0 states from the buckling mode; mark first-mode states bent towards +x."""
    guess = RodStates(
        rods=rods,
        unknowns=buckled_unknowns(rods[:, THETA], eta, nodes),
        line=np.zeros(len(rods), dtype=bool),
    )
    states, converged, _ = solve(guess, ClosingCondition.prescribing(eta, {FX: 1.0}))
    # x < x1 all along the rod, that is m < 0 with f > 0: excludes higher modes and the mirror image
    return states, converged & (bending_moment(states) < 0).all(axis=1) & (states.fy < 0)


def _homotopy(
    first: RodStates,
    rods: FloatArray,
    high: FloatArray,
    low: FloatArray,
    model: Contact,
    step: float,
) -> tuple[RodStates, FloatArray]:
    """Follow α = 0 states to other rods and from high to low surfaces, as far as they exist.

    Returns the last states and the shares of the homotopy that they have reached, 1 at its end.
    """
    # The deflection grows like the square root of 1 − η.
    high, low = np.sqrt(1.0 - high), np.sqrt(1.0 - low)
    count = len(first)
    states, before = first.copy(), first.unknowns.copy()
    last, share, steps = np.zeros(count), np.zeros(count), np.full(count, step)
    active = np.flatnonzero(np.isfinite(states.fx))
    while len(active):
        target = np.minimum(share[active] + steps[active], 1.0)
        between = first.rods[active] + target[:, None] * (rods - first.rods)[active]
        eta = 1.0 - (high[active] + target * (low - high)[active]) ** 2
        new, old, line = states.unknowns[active], before[active], states.line[active]
        way_before = share[active] - last[active]
        weight = np.divide(
            target - share[active], way_before, out=np.zeros(len(active)), where=way_before > 0.0
        )
        onward = new + weight[:, None] * (new - old)
        # After a change of contact, the extrapolated s_c may exceed 1.
        onward[:, -1] = np.minimum(onward[:, -1], 1.0)
        guess = RodStates(rods=between, unknowns=onward, line=line)
        upright = ClosingCondition.prescribing(eta, {FX: 1.0})
        solution, found = with_active_contact(guess, upright, model)
        good = found & _is_near(solution, guess) & (stability(solution, slides=True) > 0.0)
        steps[active] = np.where(good, 2.0 * steps[active], steps[active] / DIVISION)
        rows = active[good]
        before[rows] = states.unknowns[rows]
        states = states.with_rows(rows, solution.take(good))
        last[rows], share[rows] = share[rows], target[good]
        goes_on = (share < 1.0) & (states.fy < 0.0) & (steps >= SHORTEST_STEP)
        active = active[goes_on[active]]
    return states, share


def _is_near(states: RodStates, guess: RodStates) -> BoolArray:
    """Whether states are so close to their guesses that they are on the same branch."""
    bend = np.ptp(states.phi, axis=1)
    return np.asarray(np.abs(states.phi - guess.phi).max(axis=1) < SAME_BRANCH * bend)


def with_active_contact(
    guess: RodStates, closing: ClosingCondition, model: Contact
) -> tuple[RodStates, BoolArray]:
    """Solve states with the kind of contact that is possible.

    The kind of the guess is tried first. In the model LINE the other kind is tried where the first
    is not possible. Returns the states, and whether each was found; a state that was not found is
    NaN.
    """
    states, found, _ = solve(guess, closing, tolerance=TOLERANCE)
    if model is Contact.LINE:
        # A retracted rod that has peeled off up to its tip has no state in line contact.
        other = np.flatnonzero(~(violation(states) <= 0.0) & (found | states.line))
        if len(other):
            start = np.where(found[:, None], states.unknowns, guess.unknowns)[other]
            start[:, -1] = 1.0
            switched = RodStates(rods=guess.rods[other], unknowns=start, line=~guess.line[other])
            again, converged, _ = solve(switched, closing.take(other), tolerance=TOLERANCE)
            states = states.with_rows(other, again)
            found[other] = converged & (violation(again) <= 0.0)
    # Where the whole rod would lie down, s_c leaves its range
    found &= states.s_c > 0.0
    return states.with_unknowns(np.where(found[:, None], states.unknowns, np.nan)), found
