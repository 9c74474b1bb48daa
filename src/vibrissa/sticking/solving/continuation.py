"""Continuation: a branch of equilibria is followed, with the kind of contact that each state needs.

The branch begins at α = 0 and is followed in two segments. (Of a round rod it is followed from
there both ways in one, see `both_ways`.) The first goes in steps of x0 until −tan α has passed its
maximum. From there to the end neither x0 nor α increases all the way: both
turn back, the one shortly after the other. The second segment goes in steps of the *advance*, which
takes the growth of the force into account (equation E3c), until x0 has turned back.

With ``contact: point`` the tip alone touches the surface throughout. With ``contact: line`` each
state has the kind of contact that is possible: the tip touches where φ1 ≥ 0, and the rod lies along
the surface where it would pass through it. Both conditions cannot hold at once, so a state that
violates its own is solved again with the other.
"""

from dataclasses import replace

import numpy as np

from vibrissa.mechanics.aside import stability_aside
from vibrissa.mechanics.buckling import initial_states
from vibrissa.mechanics.equations import Closure, contact_position, ends
from vibrissa.mechanics.newton import MAX_ITERATIONS, extrapolated, solve
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.outcomes import Contact, Parameter, RodSection
from vibrissa.sticking.solving.segments import Branches, GoesOn, Segment, StepSizes

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
TOLERANCE_OF_SEGMENTS = 1e-5
# Margin out of the plane below which a round rod has left it for certain, though it is found on few
# nodes.
PAST_SWING, NODES_ASIDE = -0.02, 24
# States through which a quadratic is laid between the steps.
FEWEST_STATES = 3
# Most steps that are solved at once, and most states from which they are extrapolated.
LONGEST_BLOCK, MOST_KNOWN = 8, 6
# Corrections that such steps need where the guess is good.
FEW_ITERATIONS = 6


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


def to_the_end(segment: Segment, count: int) -> BoolArray:
    """Say that branches go on after each of the last `count` steps, shape (count, n)."""
    return np.full((count, len(segment.origin)), True)


def follow(
    segment: Segment,
    count: int,
    model: Contact,
    goes_on: GoesOn = to_the_end,
    before: RodStates | None = None,
    longest: int = LONGEST_BLOCK,
) -> Segment:
    """Follow branches in equal steps of the segment's parameter.

    Several steps are guessed and solved at once. A branch that this loses is followed again through
    them, one by one.

    Parameters
    ----------
    segment : Segment
        With at least its first states.
    count : int
        Largest number of steps.
    model : Contact
        POINT or LINE, as in `begin`.
    goes_on : callable, optional
        Asked after which steps branches are to be followed further.
    before : RodStates, optional
        States one step before the segment's first, or guesses of them.
    longest : int
        Most steps that are solved at once.

    Returns
    -------
    Segment
        With up to `count` steps.
    """
    active = np.arange(len(segment.origin))
    while len(active) and len(segment.steps) <= count:
        known = len(segment.steps)
        width = min(max(known - 1, 1), longest, count + 1 - known)
        segment = _with_steps(segment, active, width, model, before)
        found = np.isfinite(segment.forces[0][known:])
        good = found & goes_on(segment, width)
        # All steps up to the first that is not found, or after which a branch ends.
        wanted = np.ones_like(good)
        np.logical_and.accumulate(good[:-1], out=wanted[1:])
        for states, row in zip(segment.steps[known:], wanted, strict=True):
            states.forget(~row)
        going = wanted[-1] & good[-1]
        lost = active[(wanted & ~found)[:, active].max(axis=0)]
        if width > 1 and len(lost):
            segment, going[lost] = _step_by_step(segment, lost, known, model, goes_on, before)
        active = active[going[active]]
    return segment


def _step_by_step(
    segment: Segment,
    lost: IntArray,
    known: int,
    model: Contact,
    goes_on: GoesOn,
    before: RodStates | None,
) -> tuple[Segment, BoolArray]:
    """Follow some branches again from their first `known` states on; and which of them go on."""
    end = len(segment.steps) - 1
    start = replace(segment, steps=segment.steps[:known], line=segment.line[:known]).take(lost)
    earlier = None if before is None else before.take(lost)
    again = follow(start, end, model, goes_on, earlier, longest=1)
    going = again.last == end
    if going.any():
        going &= goes_on(again, 1)[0]
    return segment.with_branches(lost, again), going


def _with_steps(
    segment: Segment, active: IntArray, width: int, model: Contact, before: RodStates | None
) -> Segment:
    """Segment with some more steps of some branches, NaN where they are not found."""
    known = segment.steps if before is None else [before, *segment.steps]
    last, branches = known[-min(width + 2, MOST_KNOWN) :], segment.branches
    count, step = len(segment.origin), np.arange(width)[:, None]
    if len(active) < count:
        last, branches = [states.take(active) for states in last], branches.take(active)
    if width > 1:
        branches = branches.take(np.tile(np.arange(len(active)), width))
    value = segment.origin[active] + (len(segment.steps) + step) * segment.step[active]
    solution, kind, _ = with_active_contact(
        extrapolated(last, width),
        branches.height,
        branches.closure(segment.parameter, Contact.POINT, value.ravel()),
        np.tile(segment.line[-1][active], width),
        model,
        MAX_ITERATIONS if width == 1 else FEW_ITERATIONS,
    )
    states = segment.steps[0].take(np.tile(np.arange(count), width)).unsolved()
    states.put((active + step * count).ravel(), solution)
    line = np.tile(segment.line[-1], (width, 1))
    line[:, active] = kind.reshape(width, -1)
    return replace(
        segment,
        steps=[
            *segment.steps,
            *(states.take(slice(k, k + count)) for k in range(0, width * count, count)),
        ],
        line=np.vstack([segment.line, line]),
    )


def past_lock(segment: Segment, count: int) -> BoolArray:
    """Whether −tan α has fallen well below its maximum, or the surface would have to pull.

    After each of the last `count` steps, shape (count, n).
    """
    fx, fy = segment.forces
    with np.errstate(divide="ignore", invalid="ignore"):
        demand = fx / fy
    # Negative where the surface would have to pull.
    highest = np.maximum.accumulate(np.nan_to_num(demand, nan=0.0))
    past = demand < PAST_LOCK * highest
    past[: FEWEST_STATES - 1] = False
    return past[-count:]


def turns_back(segment: Segment, count: int) -> BoolArray:
    """Whether x0 decreased in each of the last `count` steps, shape (count, n)."""
    last = segment.steps[-count - 1 :]
    offsets = np.stack([contact_position(states)[0] for states in last])
    back = np.diff(offsets, axis=0) > 0.0
    back[: max(FEWEST_STATES - len(segment.steps) + count - 1, 0)] = False
    return back


def with_active_contact(
    guess: RodStates,
    eta: FloatArray,
    closure: Closure,
    line: BoolArray,
    model: Contact,
    iterations: int = MAX_ITERATIONS,
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
    iterations : int
        Most corrections of each.

    Returns
    -------
    states : RodStates
        NaN where none was found.
    line : ndarray of bool, shape (n,)
        Kind of contact of each.
    found : ndarray of bool, shape (n,)
    """
    states, found = _solve_kinds(guess, eta, closure, line, iterations)
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
            solution, again = _solve_kinds(
                start, eta[other], closure.take(other), line[other], iterations
            )
            states.put(other, solution)
            slope = ends(solution).phi1
            found[other] = again & np.where(line[other], solution.s_c <= 1.0, slope >= 0.0)
    # s_c runs away where the rod would lie down altogether
    found &= states.s_c > 0.0
    states.forget(~found)
    return states, line, found


def _solve_kinds(
    guess: RodStates,
    eta: FloatArray,
    closure: Closure,
    line: BoolArray,
    iterations: int,
) -> tuple[RodStates, BoolArray]:
    """Solve a batch in which each state has its kind of contact."""
    states, found = guess.unsolved(), np.zeros(len(guess), dtype=bool)
    for contact, kind in ((Contact.POINT, ~line), (Contact.LINE, line)):
        conditions = replace(closure, contact=contact)
        if kind.all():
            return solve(
                guess, eta, conditions, tolerance=TOLERANCE_OF_SEGMENTS, iterations=iterations
            )[:2]
        if kind.any():
            index = np.flatnonzero(kind)
            solution = solve(
                guess.take(index),
                eta[index],
                conditions.take(index),
                tolerance=TOLERANCE_OF_SEGMENTS,
                iterations=iterations,
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
    return follow(begun, count, model, lambda segment, count: ~past_lock(segment, count))


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
    straight = begun.branches.x1_init - np.sqrt(1.0 - begun.branches.eta**2)
    twice = begun.take(np.tile(np.arange(count), 2))
    twice = replace(twice, step=np.concatenate([begun.step, straight / PULL_STEPS]))

    def goes_on(segment: Segment, count: int) -> BoolArray:
        last = RodStates.concatenate(segment.steps[-count:])
        ahead = (ahead_of_clamp(last) > -BEHIND_CLAMP) & (last.fy < 0.0)
        needs_less = last.fx < -MOST_PULLED * last.fy
        step = len(segment.steps) - count + np.arange(count)
        return np.where(
            segment.step < 0.0,
            needs_less.reshape(count, -1) & (step < PULL_STEPS - 1)[:, None],
            ahead.reshape(count, -1),
        )

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

    def goes_on(segment: Segment, count: int) -> BoolArray:
        on = ~turns_back(segment, count)
        if section is RodSection.ROUND:
            last = RodStates.concatenate(segment.steps[-count:])
            on &= ~has_swung(last).reshape(count, -1)
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
