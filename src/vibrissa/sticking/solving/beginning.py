"""Where branches begin: α = 0 states of rods in any mounting, followed there from the ideal one.

In the ideal mounting the first buckling mode starts Newton's iteration. In another one there is no
buckling: a rod that is inclined, curved or turned by a yielding clamp bends from the first touch,
and the state that is bent towards +x may not exist at all. It is followed from the ideal rod at the
same height, while all deviations grow together from nothing to the whole mounting. It exists as
long as it is a minimum of the energy for a tip that slides without friction, and presses on the
surface.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Self

import numpy as np

from vibrissa.mechanics.equations import Closure, contact_position
from vibrissa.mechanics.mounting import Mounting, Mountings
from vibrissa.mechanics.stability import stability
from vibrissa.mechanics.states import UNKNOWNS, RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.numerics.batch import Batch
from vibrissa.outcomes import Contact, Status
from vibrissa.sticking.solving.continuation import begin, with_active_contact
from vibrissa.sticking.solving.segments import Segment, StepSizes

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
    segment : Segment
        The first segment with its first state, for those branches of which it was found.
    rows : ndarray of int
        Which of the rods they are.
    missing : dict
        Status and message of the other rods.
    """

    segment: Segment
    rows: IntArray
    missing: dict[int, tuple[Status, str]]


def begin_mounted(rods: Rods, sizes: StepSizes, model: Contact) -> Beginning:
    """Solve the states in which branches begin.

    Parameters
    ----------
    rods : Rods
    sizes : StepSizes
    model : Contact
        POINT for contact with the tip alone, LINE for the kind that is possible.

    Returns
    -------
    Beginning
    """
    segment, index = begin(rods.theta, rods.eta, sizes, model)
    missing = {
        int(row): (Status.FAILED, NO_INITIAL_STATE)
        for row in np.setdiff1d(np.arange(len(rods)), index)
    }
    if rods.mounting is not None and len(index):
        segment, why = _mounted(segment, rods.mounting.take(index), model)
        missing |= {int(index[row]): reason for row, reason in why.items()}
        found = np.setdiff1d(np.arange(len(index)), list(why))
        segment, index = segment.take(found), index[found]
    if rods.stage_angle is not None:
        branches = replace(segment.branches, stage_angle=rods.stage_angle[index])
        segment = replace(segment, branches=branches)
    return Beginning(segment, index, missing)


def _mounted(
    ideal: Segment, mounting: Mountings, model: Contact
) -> tuple[Segment, dict[int, tuple[Status, str]]]:
    """Follow first states from the ideal mounting to the wanted ones."""
    eta = ideal.branches.eta
    share, step = np.zeros(len(eta)), np.ones(len(eta))
    states = replace(ideal.steps[0], mounting=mounting.scaled(share))
    before, line, last = states.copy(), ideal.line[0].copy(), share.copy()
    missing: dict[int, tuple[Status, str]] = {}
    active = np.arange(len(eta))
    while len(active):
        target = np.minimum(share[active] + step[active], 1.0)
        guess = _towards(
            before.take(active), states.take(active), last[active], share[active], target
        )
        guess = replace(guess, mounting=mounting.take(active).scaled(target))
        vertical = Closure.at_inclination(np.zeros(len(active)))
        solution, kind, found = with_active_contact(
            guess, eta[active], vertical, line[active], model
        )
        good = found & _is_near(solution, guess) & (_margin(solution, kind) > 0.0)
        step[active] = np.where(good, 2.0 * step[active], step[active] / DIVISION)
        rows = active[good]
        before.put(rows, states.take(rows))
        states.put(rows, solution.take(good))
        line[rows], last[rows], share[rows] = kind[good], share[rows], target[good]
        for row in rows[states.fy[rows] >= 0.0]:
            missing[int(row)] = Status.OUT_OF_REACH, LEAVES.format(share=share[row])
        lost = active[~good & (step[active] < SHORTEST_STEP)]
        ends = _margin(states.take(lost), line[lost]) < END_MARGIN
        for row, springs in zip(lost, ends, strict=True):
            status, why = (Status.OUT_OF_REACH, SPRINGS) if springs else (Status.FAILED, LOST)
            missing[int(row)] = status, why.format(share=share[row])
        active = np.setdiff1d(active[share[active] < 1.0], list(missing))
    x1_init, _ = contact_position(states)
    branches = replace(ideal.branches, x1_init=x1_init)
    return replace(ideal, branches=branches, steps=[states], line=line[None]), missing


def _towards(
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
