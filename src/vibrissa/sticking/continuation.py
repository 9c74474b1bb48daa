"""Continuation: a branch of equilibria is followed, with the kind of contact that each state needs.

The branch begins at α = 0 and is followed in two segments. (Of a round rod it is followed from
there both ways in one, see `vibrissa.sticking.collocation`.) The first goes in steps of x0 until
−tan α has passed its maximum. From there to the end neither x0 nor α increases all the way: both
turn back, the one shortly after the other. The second segment goes in steps of the *advance*, which
takes the growth of the force into account (equation E3c), until x0 has turned back.

With ``contact: point`` the tip alone touches the surface throughout. With ``contact: line`` each
state has the kind of contact that is possible: the tip touches where φ1 ≥ 0, and the rod lies along
the surface where it would pass through it. Both conditions cannot hold at once, so a state that
violates its own is solved again with the other.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.aside import stability_aside
from vibrissa.mechanics.buckling import initial_states
from vibrissa.mechanics.equations import Closure, advance, contact_position, ends
from vibrissa.mechanics.newton import extrapolated, solve
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.numerics.batch import Batch
from vibrissa.outcomes import Contact, Parameter, RodSection

# Height at which lowering the surface begins, and numbers of steps to try.
HIGHEST = 0.999
LOWERING_STEPS = (12, 40)
# Limit of the first segment relative to x1_init: at 1 the clamp stands under the contact.
LIMIT_OF_X0 = 2.0
# The first segment ends where −tan α has fallen below this part of its maximum.
PAST_LOCK = 0.6
# A round rod is followed until its contact point is this far behind the clamp (L).
BEHIND_CLAMP = 1e-6
# Steps in which a pulled rod would become straight, and the friction up to which it is followed:
# where the normal force vanishes, s_c runs so steeply that few paths would be resolved.
PULL_STEPS = 40
MOST_PULLED = 3.0
# Where the second segment ends at the latest.
LIMIT_OF_ADVANCE = 50.0
# Accuracy of the states of a segment: they are guesses for what is solved exactly.
TOLERANCE_OF_SEGMENTS = 1e-6
# Margin out of the plane below which a round rod has left it for certain, though it is found on few
# nodes.
PAST_SWING, NODES_ASIDE = -0.02, 24
# States through which a quadratic is laid between the steps.
FEWEST_STATES = 3


@dataclass(frozen=True, eq=False, kw_only=True)
class Branches(Batch):
    """A batch of branches: what they belong to and the α = 0 states in which they begin.

    Attributes
    ----------
    theta, eta : ndarray, shape (n,)
        Taper factors and heights of the surface (L).
    x1_init : ndarray, shape (n,)
        Contact point in the α = 0 state, with the clamp at x = 0 (L).
    scale, force : ndarray, shape (n,)
        Contact point (L) and contact force (E·I0/L²) in the α = 0 state of the same rod in the
        ideal mounting: the units of steps and of the advance.
    stage_angle : ndarray, shape (n,), or None
        Angle δ of the clamp's way to the surface (rad); None where it moves along the surface.
    """

    theta: FloatArray
    eta: FloatArray
    x1_init: FloatArray
    scale: FloatArray
    force: FloatArray
    stage_angle: FloatArray | None = None

    @property
    def height(self) -> FloatArray:
        """Right side of E2."""
        if self.stage_angle is None:
            return self.eta
        return self.eta - np.tan(self.stage_angle) * self.x1_init

    def closure(self, parameter: Parameter, contact: Contact, value: FloatArray) -> Closure:
        """Conditions that hold at given values of the parameter."""
        if parameter is Parameter.X0:
            return self.tilted(Closure.at_offset(self.offset(value), contact))
        return self.tilted(Closure.at_advance(value, self.x1_init, self.force, contact, self.scale))

    def tilted(self, closure: Closure) -> Closure:
        """Conditions with E2 for the way of the clamp."""
        if self.stage_angle is None:
            return closure
        return replace(closure, tilt=np.tan(self.stage_angle))

    def value_of(self, parameter: Parameter, states: RodStates) -> FloatArray:
        """Value of the parameter in given states."""
        if parameter is Parameter.X0:
            return self.displacement(contact_position(states)[0])
        return advance(states, self.x1_init, self.force, self.scale)

    def offset(self, x0: FloatArray) -> FloatArray:
        """Contact point from the clamp after displacements of the clamp (L)."""
        return self.x1_init - (x0 if self.stage_angle is None else x0 * np.cos(self.stage_angle))

    def displacement(self, offset: FloatArray) -> FloatArray:
        """Inverse of `offset`."""
        x0 = self.x1_init - offset
        return x0 if self.stage_angle is None else x0 / np.cos(self.stage_angle)


@dataclass(frozen=True, eq=False, kw_only=True)
class Segment:
    """States at equal steps of one parameter along a batch of branches, NaN where one has ended.

    Attributes
    ----------
    parameter : Parameter
        What the steps are steps of.
    branches : Branches
    origin, step : ndarray, shape (n,)
        Parameter of the first state and its increment (x0 in L).
    steps : list of RodStates
        One batch for each step.
    line : ndarray of bool, shape (steps, n)
        Whether a state is in line contact.
    """

    parameter: Parameter
    branches: Branches
    origin: FloatArray
    step: FloatArray
    steps: list[RodStates]
    line: BoolArray

    def take(self, index: IntArray) -> "Segment":
        """Select branches."""
        return replace(
            self,
            branches=self.branches.take(index),
            origin=self.origin[index],
            step=self.step[index],
            steps=[states.take(index) for states in self.steps],
            line=self.line[:, index],
        )

    @property
    def forces(self) -> tuple[FloatArray, FloatArray]:
        """Contact forces fx and fy, each of shape (steps, n)."""
        return np.stack([s.fx for s in self.steps]), np.stack([s.fy for s in self.steps])

    @property
    def last(self) -> IntArray:
        """Index of the last state of each branch, -1 where there is none."""
        return np.isfinite(self.forces[0]).sum(axis=0) - 1

    def at(self, k: IntArray) -> tuple[RodStates, BoolArray]:
        """State `k[i]` of each branch i, and whether it is in line contact."""
        states = self.steps[0].copy()
        for number in np.unique(k):
            chosen = np.flatnonzero(k == number)
            states.put(chosen, self.steps[number].take(chosen))
        return states, self.line[k, np.arange(len(k))]


class StepSizes(NamedTuple):
    """How closely branches are followed.

    Attributes
    ----------
    nodes : int
        Number of collocation nodes.
    x0 : float
        Step of the first segment, relative to x1_init.
    advance : float
        Step of the second segment.
    """

    nodes: int
    x0: float
    advance: float


def begin(
    theta: FloatArray, eta: FloatArray, sizes: StepSizes, model: Contact
) -> tuple[Segment, IntArray]:
    """Solve the states in which branches begin.

    Parameters
    ----------
    theta, eta : ndarray, shape (n,)
        Taper factors and heights of the surface (L).
    sizes : StepSizes
    model : Contact
        POINT for contact with the tip alone, LINE for the kind that is possible.

    Returns
    -------
    segment : Segment
        The first segment with its first state, for those branches of which it was found.
    index : ndarray of int
        Which of the arguments they are.
    """
    states, found = initial_states(theta, eta, sizes.nodes)
    line = np.zeros(len(theta), dtype=bool)
    if model is Contact.LINE:
        line = found & (ends(states).phi1 < 0.0)
        for count in LOWERING_STEPS:
            lying = np.flatnonzero(line & ~(found & (states.s_c < 1.0)))
            if len(lying):
                solution, found[lying] = _lowered(theta[lying], eta[lying], sizes.nodes, count)
                states.put(lying, solution)
    index = np.flatnonzero(found)
    states = states.take(index)
    x1_init, _ = contact_position(states)
    segment = Segment(
        parameter=Parameter.X0,
        branches=Branches(
            theta=states.theta,
            eta=eta[index],
            x1_init=x1_init,
            scale=x1_init,
            force=-states.fy,
        ),
        origin=np.zeros(len(index)),
        step=sizes.x0 * x1_init,
        steps=[states],
        line=line[None, index],
    )
    return segment, index


def _lowered(
    theta: FloatArray, eta: FloatArray, nodes: int, count: int
) -> tuple[RodStates, BoolArray]:
    """Solve α = 0 states in line contact by lowering the surface from where the tip alone touches.

    Straight from the point-contact state, Newton's iteration finds only those that differ little.
    """
    # The deflection grows like the square root of 1 − η: equal steps of it.
    root = np.linspace(np.sqrt(1.0 - HIGHEST), np.sqrt(1.0 - eta), count)
    steps = [initial_states(theta, 1.0 - root[0] ** 2, nodes)[0]]
    line = np.zeros(len(theta), dtype=bool)
    vertical = Closure.at_inclination(np.zeros(len(theta)))
    for width in root[1:]:
        guess = extrapolated(steps[-3:])
        # Where the kind just changed, the extrapolated s_c may have passed 1.
        guess = replace(guess, s_c=np.where(line, np.minimum(guess.s_c, 1.0), 1.0))
        states, line, found = with_active_contact(
            guess, 1.0 - width**2, vertical, line, Contact.LINE
        )
        steps.append(states)
    return states, found & line & (states.s_c < 1.0)


def follow(
    segment: Segment,
    count: int,
    model: Contact,
    goes_on: Callable[[Segment], BoolArray] | None = None,
    before: RodStates | None = None,
) -> Segment:
    """Follow branches in equal steps of the segment's parameter.

    Parameters
    ----------
    segment : Segment
        With at least its first states.
    count : int
        Largest number of steps.
    model : Contact
        POINT or LINE, as in `begin`.
    goes_on : callable, optional
        Asked after each step which branches are to be followed further.
    before : RodStates, optional
        States one step before the segment's first, or guesses of them.

    Returns
    -------
    Segment
        With up to `count` steps.
    """
    active, branches = np.arange(len(segment.origin)), segment.branches
    while len(active) and len(segment.steps) <= count:
        known = segment.steps if before is None else [before, *segment.steps]
        last = known[-3:]
        if len(active) < len(segment.origin):
            last, branches = [s.take(active) for s in last], segment.branches.take(active)
        value = segment.origin[active] + len(segment.steps) * segment.step[active]
        closure = branches.closure(segment.parameter, Contact.POINT, value)
        solution, kind, found = with_active_contact(
            extrapolated(last), branches.height, closure, segment.line[-1][active], model
        )
        states, line = segment.steps[0].unsolved(), segment.line[-1].copy()
        states.put(active, solution)
        line[active] = kind
        segment = replace(
            segment, steps=[*segment.steps, states], line=np.vstack([segment.line, line])
        )
        active = active[found & (goes_on is None or goes_on(segment)[active])]
    return segment


def past_lock(segment: Segment) -> BoolArray:
    """Whether −tan α has fallen well below its maximum, or the surface would have to pull."""
    fx, fy = segment.forces
    with np.errstate(divide="ignore", invalid="ignore"):
        demand = fx / fy
    pulls = (fy[-1] >= 0.0) & (fx[-1] < 0.0)
    fallen = demand[-1] < PAST_LOCK * np.nan_to_num(demand, nan=0.0).max(axis=0)
    return (fallen | pulls) & (len(segment.steps) >= FEWEST_STATES)


def turns_back(segment: Segment) -> BoolArray:
    """Whether x0 decreased in the last step."""
    if len(segment.steps) < FEWEST_STATES:
        return np.zeros(len(segment.origin), dtype=bool)
    before, after = (contact_position(states)[0] for states in segment.steps[-2:])
    return after > before


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
        POINT or LINE, as in `begin`.

    Returns
    -------
    states : RodStates
        NaN where none was found.
    line : ndarray of bool, shape (n,)
        Kind of contact of each.
    found : ndarray of bool, shape (n,)
    """
    states, found = _solve_kinds(guess, eta, closure, line)
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
            solution, again = _solve_kinds(start, eta[other], closure.take(other), line[other])
            states.put(other, solution)
            slope = ends(solution).phi1
            found[other] = again & np.where(line[other], solution.s_c <= 1.0, slope >= 0.0)
    # s_c runs away where the rod would lie down altogether
    found &= states.s_c > 0.0
    states.put(~found, states.unsolved().take(~found))
    return states, line, found


def _solve_kinds(
    guess: RodStates,
    eta: FloatArray,
    closure: Closure,
    line: BoolArray,
) -> tuple[RodStates, BoolArray]:
    """Solve a batch in which each state has its kind of contact."""
    states, found = guess.unsolved(), np.zeros(len(guess), dtype=bool)
    for contact, kind in ((Contact.POINT, ~line), (Contact.LINE, line)):
        conditions = replace(closure, contact=contact)
        if kind.all():
            return solve(guess, eta, conditions, tolerance=TOLERANCE_OF_SEGMENTS)[:2]
        if kind.any():
            index = np.flatnonzero(kind)
            solution = solve(
                guess.take(index),
                eta[index],
                conditions.take(index),
                tolerance=TOLERANCE_OF_SEGMENTS,
            )
            found[index] = solution.converged
            states.put(index, solution.states)
    return states, found


def first_segment(begun: Segment, sizes: StepSizes, model: Contact) -> Segment:
    """Follow branches from α = 0 until −tan α has passed its maximum or the tip lifts off.

    Parameters
    ----------
    begun : Segment
        With its first state.
    sizes, model
        As in `begin`.

    Returns
    -------
    Segment
    """
    count = round(LIMIT_OF_X0 / sizes.x0)
    return follow(begun, count, model, lambda segment: ~past_lock(segment))


def ahead_of_clamp(states: RodStates) -> FloatArray:
    """How far the contact point lies ahead of the clamp's axis, in units of L."""
    return contact_position(states)[0] - (1.0 - states.s_c)


def both_ways(begun: Segment, sizes: StepSizes, model: Contact) -> Segment:
    """Follow branches from α = 0 both ways: pushed and pulled by the clamp.

    Parameters
    ----------
    begun : Segment
        With the first states of `n` branches.
    sizes, model
        As in `begin`.

    Returns
    -------
    Segment
        Of 2·n branches. The first n are followed until the clamp has passed under the contact point
        or the tip lifts off; then come the same to x0 < 0, past `MOST_PULLED`.
    """
    count = len(begun.origin)
    pulled = np.repeat([False, True], count)
    straight = begun.branches.x1_init - np.sqrt(1.0 - begun.branches.eta**2)
    twice = begun.take(np.tile(np.arange(count), 2))
    twice = replace(twice, step=np.concatenate([begun.step, straight / PULL_STEPS]))

    def goes_on(segment: Segment) -> BoolArray:
        last = segment.steps[-1]
        ahead = (ahead_of_clamp(last) > -BEHIND_CLAMP) & (last.fy < 0.0)
        needs_less = (last.fx < -MOST_PULLED * last.fy) & (len(segment.steps) < PULL_STEPS)
        return np.where(pulled, needs_less, ahead)

    return follow(twice, round(LIMIT_OF_X0 / sizes.x0), model, goes_on)


def has_swung(states: RodStates) -> BoolArray:
    """Whether states in the plane lie beyond where a round rod leaves it."""
    nodes = min(states.nodes, NODES_ASIDE)
    return np.asarray(stability_aside(states.on_nodes(nodes)) < PAST_SWING)


def second_segment(
    first: Segment, sizes: StepSizes, model: Contact, section: RodSection
) -> Segment:
    """Follow branches on from the last state of the first segment until they turn back in x0.

    Those of round rods are followed until they have left their plane, if they do so before.

    Parameters
    ----------
    first : Segment
    sizes, model
        As in `begin`.

    Returns
    -------
    Segment
    """
    states, line = first.at(first.last)
    origin = first.branches.value_of(Parameter.ADVANCE, states)
    segment = Segment(
        parameter=Parameter.ADVANCE,
        branches=first.branches,
        origin=origin,
        step=np.full_like(origin, sizes.advance),
        steps=[states],
        line=line[None],
    )
    # Go back by a step along the way that the first segment came.
    earlier, _ = first.at(first.last - 1)
    came = origin - first.branches.value_of(Parameter.ADVANCE, earlier)
    before = _along(states, earlier, sizes.advance / came)
    count = int(np.ceil((LIMIT_OF_ADVANCE - origin.min(initial=0.0)) / sizes.advance))

    def goes_on(segment: Segment) -> BoolArray:
        on = ~turns_back(segment)
        if section is RodSection.ROUND:
            on &= ~has_swung(segment.steps[-1])
        return on

    return follow(segment, count, model, goes_on, before)


def _along(start: RodStates, stop: RodStates, share: FloatArray) -> RodStates:
    """Part of the way from some states to others."""
    return replace(
        start,
        phi=start.phi + share[:, None] * (stop.phi - start.phi),
        fx=start.fx + share * (stop.fx - start.fx),
        fy=start.fy + share * (stop.fy - start.fy),
        s_c=start.s_c + share * (stop.s_c - start.s_c),
    )


def switch_states(guess: RodStates, branches: Branches) -> RodStates:
    """Solve the states in which the contact changes its kind: s_c = 1 and φ1 = 0.

    Parameters
    ----------
    guess : RodStates
        States near the change.
    branches : Branches

    Returns
    -------
    RodStates
        NaN where none was found.
    """
    closure = branches.tilted(Closure.at_switch(len(guess)))
    return solve(guess, branches.height, closure).states
