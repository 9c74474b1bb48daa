"""Following a branch of equilibria, with the kind of contact that each state needs.

The branch begins at α = 0 and is followed in two legs. The first goes in steps of x0 until −tan α
has passed its maximum. From there to the end neither x0 nor α counts the states: both turn back,
the one shortly after the other. The second leg goes in steps of the *advance*, which takes the
growth of the force into account (equation E3c), until x0 has turned back.

With ``contact: point`` the tip alone touches the surface throughout; with ``contact: line`` each
state has the kind of contact that is possible: the tip touches where φ1 ≥ 0, and the rod lies along
the surface where it would pass through it. Both conditions cannot hold at once, so a state that
violates its own is solved again with the other.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from vibrissa.arrays import BoolArray, FloatArray, Index, IntArray
from vibrissa.buckling import initial_states
from vibrissa.equilibrium import (
    Closure,
    ContactStates,
    advance,
    contact_position,
    contact_slope,
    extrapolated,
    solve,
)
from vibrissa.status import Contact, Parameter

# Height at which lowering the surface begins, and numbers of steps to try.
HIGHEST = 0.999
LOWERING_STEPS = (12, 40)
# Limit of the first leg relative to x1_init: at 1 the clamp stands under the contact.
LIMIT_OF_X0 = 2.0
# The first leg ends where −tan α has fallen below this part of its maximum.
PAST_LOCK = 0.6
# Where the second leg ends at the latest.
LIMIT_OF_ADVANCE = 50.0
# Accuracy of the states of a leg: they show the way and are guesses for what is solved exactly.
TOLERANCE_OF_LEGS = 1e-6
# States through which a quadratic is laid between the steps.
FEWEST_STATES = 3


@dataclass(frozen=True, eq=False)
class Leg:
    """States at equal steps of one parameter along a batch of branches, NaN where one has ended.

    Attributes
    ----------
    parameter : Parameter
        What the steps are steps of.
    origin, step : ndarray, shape (n,)
        Parameter of the first state and its increment (x0 in L).
    x1_init : ndarray, shape (n,)
        Contact point in the α = 0 state, with the clamp at x = 0 (L).
    force : ndarray, shape (n,)
        Contact force in the α = 0 state (E·I0/L²).
    steps : list of ContactStates
        One batch for each step.
    line : ndarray of bool, shape (steps, n)
        Whether a state is in line contact.
    """

    parameter: Parameter
    origin: FloatArray
    step: FloatArray
    x1_init: FloatArray
    force: FloatArray
    steps: list[ContactStates]
    line: BoolArray

    def take(self, index: Index) -> "Leg":
        """Select branches."""
        return Leg(
            self.parameter,
            self.origin[index],
            self.step[index],
            self.x1_init[index],
            self.force[index],
            [states.take(index) for states in self.steps],
            self.line[:, index],
        )

    @property
    def forces(self) -> tuple[FloatArray, FloatArray]:
        """Contact forces fx and fy, each of shape (steps, n)."""
        return np.stack([s.fx for s in self.steps]), np.stack([s.fy for s in self.steps])

    @property
    def last(self) -> IntArray:
        """Index of the last state of each branch, -1 where there is none."""
        return np.isfinite(self.forces[0]).sum(axis=0) - 1

    def at(self, k: IntArray) -> tuple[ContactStates, BoolArray]:
        """State `k[i]` of each branch i, and whether it is in line contact."""
        states = self.steps[0].take(np.arange(len(k)))
        states = replace(states, **{name: values.copy() for name, values in _columns(states)})
        for number in np.unique(k):
            chosen = np.flatnonzero(k == number)
            states.put(chosen, self.steps[number].take(chosen))
        return states, self.line[k, np.arange(len(k))]


def _columns(states: ContactStates) -> list[tuple[str, FloatArray]]:
    return [(name, getattr(states, name)) for name in ("phi", "fx", "fy", "s_c")]


def closure_at(
    parameter: Parameter,
    contact: Contact,
    value: FloatArray,
    x1_init: FloatArray,
    force: FloatArray,
) -> Closure:
    """Conditions that hold at given values of a leg's parameter."""
    if parameter is Parameter.X0:
        return Closure(contact, offset=x1_init - value)
    return Closure(contact, advance=value, x1_init=x1_init, force=force)


def parameter_of(
    parameter: Parameter, states: ContactStates, x1_init: FloatArray, force: FloatArray
) -> FloatArray:
    """Value of a leg's parameter in given states."""
    if parameter is Parameter.X0:
        return x1_init - contact_position(states)[0]
    return advance(states, x1_init, force)


class Pace(NamedTuple):
    """How closely branches are followed.

    Attributes
    ----------
    nodes : int
        Number of collocation nodes.
    x0 : float
        Step of the first leg, relative to x1_init.
    advance : float
        Step of the second leg.
    """

    nodes: int
    x0: float
    advance: float


def begin(theta: FloatArray, eta: FloatArray, pace: Pace, model: Contact) -> tuple[Leg, Index]:
    """Solve the states in which branches begin.

    Parameters
    ----------
    theta, eta : ndarray, shape (n,)
        Taper factors and heights of the surface (L).
    pace : Pace
    model : Contact
        POINT for contact with the tip alone, LINE for the kind that is possible.

    Returns
    -------
    leg : Leg
        The first leg with its first state, for those branches of which it was found.
    index : ndarray of int
        Which of the arguments they are.
    """
    states, found = initial_states(theta, eta, pace.nodes)
    line = np.zeros(len(theta), dtype=bool)
    if model is Contact.LINE:
        line = found & (contact_slope(states) < 0.0)
        for steps in LOWERING_STEPS:
            lying = np.flatnonzero(line & ~(found & (states.s_c < 1.0)))
            if len(lying):
                solution, found[lying] = _lowered(theta[lying], eta[lying], pace.nodes, steps)
                states.put(lying, solution)
    index = np.flatnonzero(found)
    states = states.take(index)
    x1_init, _ = contact_position(states)
    origin, step = np.zeros(len(index)), pace.x0 * x1_init
    return Leg(Parameter.X0, origin, step, x1_init, -states.fy, [states], line[None, index]), index


def _lowered(
    theta: FloatArray, eta: FloatArray, nodes: int, count: int
) -> tuple[ContactStates, BoolArray]:
    """Solve α = 0 states in line contact by lowering the surface from where the tip alone touches.

    Straight from the point-contact state, Newton's iteration finds only those that differ little.
    """
    # The deflection grows like the square root of 1 − η: equal steps of it.
    root = np.linspace(np.sqrt(1.0 - HIGHEST), np.sqrt(1.0 - eta), count)
    steps = [initial_states(theta, 1.0 - root[0] ** 2, nodes)[0]]
    line = np.zeros(len(theta), dtype=bool)
    vertical = Closure(alpha=np.zeros(len(theta)))
    for width in root[1:]:
        guess = extrapolated(steps[-3:])
        # Where the kind just changed, the extrapolated s_c may have passed 1.
        guess = replace(guess, s_c=np.where(line, np.minimum(guess.s_c, 1.0), 1.0))
        height = 1.0 - width**2
        states, line, found = settle(guess, height, vertical, line, Contact.LINE)
        steps.append(states)
    return states, found & line & (states.s_c < 1.0)


def follow(
    leg: Leg,
    eta: FloatArray,
    count: int,
    model: Contact,
    goes_on: Callable[[Leg], BoolArray] | None = None,
    before: ContactStates | None = None,
) -> Leg:
    """Follow branches in equal steps of the leg's parameter.

    Parameters
    ----------
    leg : Leg
        With at least its first states.
    eta : ndarray, shape (n,)
        Heights of the surface (L).
    count : int
        Largest number of steps.
    model : Contact
        POINT or LINE, as in `begin`.
    goes_on : callable, optional
        Asked after each step which branches are to be followed further.
    before : ContactStates, optional
        States one step before the leg's first, or guesses of them.

    Returns
    -------
    Leg
        With up to `count` steps.
    """
    active = np.arange(len(leg.x1_init))
    while len(active) and len(leg.steps) <= count:
        known = leg.steps if before is None else [before, *leg.steps]
        guess = extrapolated([states.take(active) for states in known[-3:]])
        value = leg.origin[active] + len(leg.steps) * leg.step[active]
        conditions = leg.x1_init[active], leg.force[active]
        closure = closure_at(leg.parameter, Contact.POINT, value, *conditions)
        solution, kind, found = settle(guess, eta[active], closure, leg.line[-1][active], model)
        first = leg.steps[0]
        states = replace(first, **{name: np.full_like(a, np.nan) for name, a in _columns(first)})
        states.put(active, solution)
        line = leg.line[-1].copy()
        line[active] = kind
        leg = replace(leg, steps=[*leg.steps, states], line=np.vstack([leg.line, line]))
        active = active[found & (goes_on is None or goes_on(leg)[active])]
    return leg


def past_lock(leg: Leg) -> BoolArray:
    """Whether −tan α has fallen well below its maximum, or the surface would have to pull."""
    fx, fy = leg.forces
    with np.errstate(divide="ignore", invalid="ignore"):
        demand = fx / fy
    pulls = (fy[-1] >= 0.0) & (fx[-1] < 0.0)
    fallen = demand[-1] < PAST_LOCK * np.nan_to_num(demand, nan=0.0).max(axis=0)
    return (fallen | pulls) & (len(leg.steps) >= FEWEST_STATES)


def turns_back(leg: Leg) -> BoolArray:
    """Whether x0 decreased in the last step."""
    if len(leg.steps) < FEWEST_STATES:
        return np.zeros(len(leg.x1_init), dtype=bool)
    before, after = (contact_position(states)[0] for states in leg.steps[-2:])
    return after > before


def settle(
    guess: ContactStates,
    eta: FloatArray,
    closure: Closure,
    line: BoolArray,
    model: Contact,
) -> tuple[ContactStates, BoolArray, BoolArray]:
    """Solve states with the kind of contact that is possible.

    Parameters
    ----------
    guess : ContactStates
    eta : ndarray, shape (n,)
        Heights of the surface (L).
    closure : Closure
        Their offsets or inclinations; its kind of contact does not matter.
    line : ndarray of bool, shape (n,)
        Kind of contact to try first.
    model : Contact
        POINT or LINE, as in `begin`.

    Returns
    -------
    states : ContactStates
        NaN where none was found.
    line : ndarray of bool, shape (n,)
        Kind of contact of each.
    found : ndarray of bool, shape (n,)
    """
    states, found = _solve_kinds(guess, eta, closure, line)
    if model is Contact.LINE:
        impossible = found & np.where(line, states.s_c > 1.0, contact_slope(states) < 0.0)
        other = np.flatnonzero(impossible)
        if len(other):
            line = line.copy()
            line[other] = ~line[other]
            start = replace(states.take(other), s_c=np.ones(len(other)))
            solution, again = _solve_kinds(start, eta[other], closure.take(other), line[other])
            states.put(other, solution)
            slope = contact_slope(solution)
            found[other] = again & np.where(line[other], solution.s_c <= 1.0, slope >= 0.0)
    # s_c runs away where the rod would lie down altogether
    return states, line, found & (states.s_c > 0.0)


def _solve_kinds(
    guess: ContactStates,
    eta: FloatArray,
    closure: Closure,
    line: BoolArray,
) -> tuple[ContactStates, BoolArray]:
    """Solve a batch in which each state has its kind of contact."""
    states = replace(guess, **{name: np.full_like(a, np.nan) for name, a in _columns(guess)})
    found = np.zeros(len(guess), dtype=bool)
    for contact, index in (
        (Contact.POINT, np.flatnonzero(~line)),
        (Contact.LINE, np.flatnonzero(line)),
    ):
        if len(index):
            conditions = replace(closure.take(index), contact=contact)
            solution, found[index], _ = solve(
                guess.take(index), eta[index], conditions, tolerance=TOLERANCE_OF_LEGS
            )
            states.put(index, solution)
    return states, found


def first_leg(theta: FloatArray, eta: FloatArray, pace: Pace, model: Contact) -> tuple[Leg, Index]:
    """Follow branches from α = 0 until −tan α has passed its maximum or the tip lifts off.

    Parameters
    ----------
    theta, eta, pace, model
        As in `begin`.

    Returns
    -------
    leg : Leg
    index : ndarray of int
        Which of the arguments the branches are.
    """
    leg, index = begin(theta, eta, pace, model)
    count = round(LIMIT_OF_X0 / pace.x0)
    return follow(leg, eta[index], count, model, lambda leg: ~past_lock(leg)), index


def second_leg(first: Leg, eta: FloatArray, model: Contact, pace: Pace) -> Leg:
    """Follow branches on from the last state of the first leg until they turn back in x0.

    Parameters
    ----------
    first : Leg
    eta : ndarray, shape (n,)
        Heights of the surface (L).
    model : Contact
        POINT or LINE, as in `begin`.
    pace : Pace

    Returns
    -------
    Leg
    """
    states, line = first.at(first.last)
    origin = parameter_of(Parameter.ADVANCE, states, first.x1_init, first.force)
    leg = Leg(
        Parameter.ADVANCE,
        origin,
        np.full_like(origin, pace.advance),
        first.x1_init,
        first.force,
        [states],
        line[None],
    )
    # Go back by a step along the way that the first leg came.
    earlier, _ = first.at(first.last - 1)
    came = origin - parameter_of(Parameter.ADVANCE, earlier, first.x1_init, first.force)
    before = _along(states, earlier, pace.advance / came)
    count = int(np.ceil((LIMIT_OF_ADVANCE - origin.min(initial=0.0)) / pace.advance))
    return follow(leg, eta, count, model, lambda leg: ~turns_back(leg), before)


def _along(start: ContactStates, stop: ContactStates, share: FloatArray) -> ContactStates:
    """Part of the way from some states to others."""
    return replace(
        start,
        phi=start.phi + share[:, None] * (stop.phi - start.phi),
        fx=start.fx + share * (stop.fx - start.fx),
        fy=start.fy + share * (stop.fy - start.fy),
        s_c=start.s_c + share * (stop.s_c - start.s_c),
    )


def switch_states(guess: ContactStates, eta: FloatArray) -> ContactStates:
    """Solve the states in which the contact changes its kind: s_c = 1 and φ1 = 0.

    Parameters
    ----------
    guess : ContactStates
        States near the change.
    eta : ndarray, shape (n,)
        Heights of the surface (L).

    Returns
    -------
    ContactStates
        NaN where none was found.
    """
    return solve(guess, eta, Closure())[0]
