"""Where branches begin: α = 0 states of rods in any mounting, followed there from the ideal one.

In the ideal mounting the first buckling mode starts Newton's iteration. In another one there is no
buckling: a rod that is inclined, curved or turned by a yielding clamp bends from the first touch,
and the state that is bent towards +x may not exist at all. It is followed from the ideal rod at the
same height, while all deviations grow together from nothing to the whole mounting. It exists as
long as it is a minimum of the energy for a tip that slides without friction, and presses on the
surface.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Self

import numpy as np

from vibrissa.mechanics.buckling import initial_states
from vibrissa.mechanics.equations import Closure, contact_position, ends
from vibrissa.mechanics.mounting import Mounting, Mountings
from vibrissa.mechanics.newton import MAX_ITERATIONS
from vibrissa.mechanics.stability import stability
from vibrissa.mechanics.states import UNKNOWNS, RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.numerics.batch import Batch
from vibrissa.outcomes import Contact, Status
from vibrissa.sticking.solving.branches import Branches
from vibrissa.sticking.solving.following import solve_kinds

# Height at which lowering the surface begins, and the first step (part of the way).
HIGHEST, FIRST_SHARE = 0.999, 0.1
# A step that succeeds is doubled, one that fails divided; the shortest step (parts of a mounting).
DIVISION, SHORTEST_STEP = 4.0, 1e-4
# Part of the rod's bend by which a state may differ from its guess: further away is another branch.
NEAR = 0.3
# Below this margin of stability a branch that cannot be followed has its end.
END_MARGIN = 0.1

NO_INITIAL_STATE = (
    "no first-mode state with alpha = 0 found; try a larger eta or a theta closer to 1"
)
SPRINGS = (
    "no state with alpha = 0 is bent towards +x: followed from the ideal mounting, it ends at "
    "{share:.1%} of this one, where the rod springs to the other side; try a smaller eta or a "
    "smaller clamp_angle or curvature"
)
LEAVES = (
    "the rod does not press on the surface: followed from the ideal mounting, its tip leaves the "
    "surface before {share:.1%} of this one; try a smaller eta"
)
LOST = (
    "the state with alpha = 0 was lost at {share:.1%} of the way from the ideal mounting to this "
    "one; try a slightly different eta, theta or mounting"
)


class Closeness(NamedTuple):
    """How closely paths are followed: number of nodes, and the longest step."""

    nodes: int
    longest: float


# More closely where that leads nowhere. The pieces have nodes and states of their own.
CLOSENESS = (Closeness(24, 0.6), Closeness(48, 0.15), Closeness(108, 0.04))


@dataclass(frozen=True, eq=False, kw_only=True)
class Rods(Batch):
    """Rods below a surface: what curves are solved for.

    Attributes
    ----------
    theta, eta : ndarray, shape (n,)
        Taper factors and heights of the surface (L).
    mounting : Mountings or None
        Clamps and natural shapes; None where all are ideal.
    stage_angle : ndarray, shape (n,), or None
        δ (rad); None where all stages move along the surface.
    """

    theta: FloatArray
    eta: FloatArray
    mounting: Mountings | None = None
    stage_angle: FloatArray | None = None

    @classmethod
    def of(cls, theta: FloatArray, eta: FloatArray, mountings: Sequence[Mounting]) -> Self:
        """Put rods of one kind together: all in ideal mountings or none, and stages likewise."""
        ideal, along = mountings[0].is_ideal_rod, mountings[0].stage_angle == 0.0
        return cls(
            theta=theta,
            eta=eta,
            mounting=None if ideal else Mountings.of(mountings),
            stage_angle=None if along else np.array([one.stage_angle for one in mountings]),
        )

    @property
    def are_ideal(self) -> bool:
        """Whether all are mounted as in the paper."""
        return self.mounting is None and self.stage_angle is None


class Beginning(NamedTuple):
    """First states of branches.

    Attributes
    ----------
    branches : Branches
    states : RodStates
        The α = 0 states of those that have one.
    line : ndarray of bool, shape (n,)
        Whether these are in line contact.
    rows : ndarray of int
        Which of the rods they are.
    missing : dict
        Status and message of the other rods.
    """

    branches: Branches
    states: RodStates
    line: BoolArray
    rows: IntArray
    missing: dict[int, tuple[Status, str]]


def begin(rods: Rods, nodes: int, model: Contact) -> Beginning:
    """Solve the states in which branches begin.

    Parameters
    ----------
    rods : Rods
    nodes : int
        Number of collocation nodes.
    model : Contact
        POINT for contact with the tip alone, LINE for the kind that is possible.

    Returns
    -------
    Beginning
    """
    states, line, found = _upright(rods.theta, rods.eta, nodes, model)
    rows = np.flatnonzero(found)
    missing = {int(row): (Status.FAILED, NO_INITIAL_STATE) for row in np.flatnonzero(~found)}
    states, line, eta = states.take(rows), line[rows], rods.eta[rows]
    scale, force = contact_position(states)[0], -states.fy
    if rods.mounting is not None and len(rows):
        states, line, why = _mounted(states, line, eta, rods.mounting.take(rows), model)
        missing |= {int(rows[row]): reason for row, reason in why.items()}
        here = np.setdiff1d(np.arange(len(rows)), list(why))
        rows, states, line, eta = rows[here], states.take(here), line[here], eta[here]
        scale, force = scale[here], force[here]
    branches = Branches(
        theta=states.theta,
        eta=eta,
        x1_init=contact_position(states)[0],
        scale=scale,
        force=force,
        stage_angle=None if rods.stage_angle is None else rods.stage_angle[rows],
    )
    return Beginning(branches, states, line, rows, missing)


def _upright(
    theta: FloatArray, eta: FloatArray, nodes: int, model: Contact
) -> tuple[RodStates, BoolArray, BoolArray]:
    """Solve α = 0 states in the ideal mounting: states, which are in line contact, which found."""
    states, found = initial_states(theta, eta, nodes)
    line = np.zeros(len(theta), dtype=bool)
    lies = found & (ends(states).phi1 < 0.0) & (model is Contact.LINE)
    rows = np.flatnonzero(~found | lies)
    if len(rows):
        # The surface is lowered. The deflection grows like the square root of 1 − η.
        high, low = np.sqrt(1.0 - HIGHEST), np.sqrt(1.0 - eta[rows])
        first, _ = initial_states(theta[rows], np.full(len(rows), HIGHEST), nodes)

        def lowered(row: IntArray, share: FloatArray) -> tuple[FloatArray, None]:
            return 1.0 - (high + share * (low[row] - high)) ** 2, None

        lowest, kind, share = _towards_the_end(first, line[rows], lowered, model, FIRST_SHARE)
        states.put(rows, lowest)
        line[rows], found[rows] = kind, share >= 1.0
    return states, line, found


# Maps some of the rods, and shares of the way for them, to the heights of the surface and the
# mountings there.
Way = Callable[[IntArray, FloatArray], tuple[FloatArray, Mountings | None]]


def _towards_the_end(
    first: RodStates, line: BoolArray, way: Way, model: Contact, step: float
) -> tuple[RodStates, BoolArray, FloatArray]:
    """Follow α = 0 states along a way, in steps that adapt, as far as they exist.

    Returns the last states, their kinds of contact and the shares of the way.
    """
    count = len(line)
    states, line = first.copy(), line.copy()
    before, last, share, steps = (
        states.copy(),
        np.zeros(count),
        np.zeros(count),
        np.full(count, step),
    )
    active = np.flatnonzero(np.isfinite(states.fx))
    while len(active):
        target = np.minimum(share[active] + steps[active], 1.0)
        eta, mounting = way(active, target)
        known = before.take(active), states.take(active), last[active], share[active]
        guess = replace(_extrapolated(*known, target), mounting=mounting)
        # Where the kind just changed, the extrapolated s_c may have passed 1.
        guess = replace(guess, s_c=np.where(line[active], np.minimum(guess.s_c, 1.0), 1.0))
        upright = Closure.at_inclination(np.zeros(len(active)))
        solution, kind, found = with_active_contact(guess, eta, upright, line[active], model)
        good = found & _is_near(solution, guess) & (_margin(solution, kind) > 0.0)
        steps[active] = np.where(good, 2.0 * steps[active], steps[active] / DIVISION)
        rows = active[good]
        before.put(rows, states.take(rows))
        states.put(rows, solution.take(good))
        line[rows], last[rows], share[rows] = kind[good], share[rows], target[good]
        goes_on = (share < 1.0) & (states.fy < 0.0) & (steps >= SHORTEST_STEP)
        active = active[goes_on[active]]
    return states, line, share


def with_active_contact(
    guess: RodStates,
    eta: FloatArray,
    closure: Closure,
    line: BoolArray,
    model: Contact,
) -> tuple[RodStates, BoolArray, BoolArray]:
    """Solve states with the kind of contact that is possible.

    Parameters
    ----------
    guess : RodStates
    eta : ndarray, shape (n,)
        Heights of the surface (L).
    closure : Closure
        What is prescribed; its kind of contact does not matter.
    line : ndarray of bool, shape (n,)
        Kind of contact to try first.
    model : Contact
        POINT for contact with the tip alone, LINE for the kind that is possible.

    Returns
    -------
    states : RodStates
        NaN where none was found.
    line : ndarray of bool, shape (n,)
        Kind of contact of each.
    found : ndarray of bool, shape (n,)
    """
    states, found = solve_kinds(guess, eta, closure, line, iterations=MAX_ITERATIONS)
    if model is Contact.LINE:
        impossible = found & np.where(line, states.s_c > 1.0, ends(states).phi1 < 0.0)
        # Where a pulled rod has peeled off up to its tip, no state lies along the surface.
        other = np.flatnonzero(impossible | (line & ~found))
        if len(other):
            line = line.copy()
            line[other] = ~line[other]
            start = guess.take(other)
            start.put(found[other], states.take(other[found[other]]))
            start = replace(start, s_c=np.ones(len(other)))
            some = eta[other], closure.take(other), line[other]
            solution, again = solve_kinds(start, *some, iterations=MAX_ITERATIONS)
            states.put(other, solution)
            slope = ends(solution).phi1
            found[other] = again & np.where(line[other], solution.s_c <= 1.0, slope >= 0.0)
    # s_c runs away where the rod would lie down altogether
    found &= states.s_c > 0.0
    states.forget(~found)
    return states, line, found


def _mounted(
    ideal: RodStates, line: BoolArray, eta: FloatArray, mounting: Mountings, model: Contact
) -> tuple[RodStates, BoolArray, dict[int, tuple[Status, str]]]:
    """Follow first states from the ideal mounting to the wanted ones."""

    def deviating(rows: IntArray, share: FloatArray) -> tuple[FloatArray, Mountings]:
        return eta[rows], mounting.take(rows).scaled(share)

    first = replace(ideal, mounting=mounting.scaled(np.zeros(len(eta))))
    states, line, share = _towards_the_end(first, line, deviating, model, 1.0)
    missing: dict[int, tuple[Status, str]] = {}
    rows = np.flatnonzero((share < 1.0) | (states.fy >= 0.0))
    springs = _margin(states.take(rows), line[rows]) < END_MARGIN
    for row, over in zip(rows, springs, strict=True):
        status, why = (Status.OUT_OF_REACH, SPRINGS) if over else (Status.FAILED, LOST)
        if states.fy[row] >= 0.0:
            status, why = Status.OUT_OF_REACH, LEAVES
        missing[int(row)] = status, why.format(share=share[row])
    return states, line, missing


def _extrapolated(
    before: RodStates, states: RodStates, last: FloatArray, share: FloatArray, target: FloatArray
) -> RodStates:
    """States on the way through two known ones; the second itself where there is only one."""
    with np.errstate(divide="ignore", invalid="ignore"):
        weight = np.nan_to_num((target - share) / (share - last), posinf=0.0)
    old, new = before.columns, states.columns
    guess: dict[str, Any] = {
        name: new[name] + (new[name] - old[name]) * weight.reshape(-1, *[1] * (old[name].ndim - 1))
        for name in UNKNOWNS
    }
    return replace(states, **guess)


def _is_near(states: RodStates, guess: RodStates) -> BoolArray:
    """Whether states are on the branch of their guesses."""
    bend = np.ptp(states.phi, axis=1)
    return np.asarray(np.abs(states.phi - guess.phi).max(axis=1) < NEAR * bend)


def _margin(states: RodStates, line: BoolArray) -> FloatArray:
    """Margin of stability of states whose tip slides without friction."""
    margin = np.full(len(states), np.nan)
    for contact, kind in ((Contact.POINT, ~line), (Contact.LINE, line)):
        rows = np.flatnonzero(kind)
        if len(rows):
            margin[rows] = stability(states.take(rows), contact, slides=True)
    return margin
