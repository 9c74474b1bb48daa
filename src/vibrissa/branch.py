"""Following a branch of equilibria along x0, with the kind of contact that each state needs.

The branch begins at α = 0. With ``contact: point`` the tip alone touches the surface throughout;
with ``contact: line`` each state has the kind of contact that is possible: the tip touches where
φ1 ≥ 0, and the rod lies along the surface where it would pass through it. Both conditions cannot
hold at once, so a state that violates its own is solved again with the other.
"""

from dataclasses import dataclass, replace

import numpy as np

from vibrissa.arrays import BoolArray, FloatArray, Index
from vibrissa.buckling import initial_states
from vibrissa.equilibrium import (
    Closure,
    ContactStates,
    contact_position,
    contact_slope,
    extrapolated,
    solve,
)
from vibrissa.status import Contact

# Height at which lowering the surface begins, and number of steps.
HIGHEST = 0.999
LOWERING_STEPS = 40


@dataclass(frozen=True, eq=False)
class Branch:
    """States along a batch of branches at equal steps of x0, NaN where a branch has ended.

    Attributes
    ----------
    steps : list of ContactStates
        One batch for each step, the first at α = 0.
    line : ndarray of bool, shape (steps, n)
        Whether a state is in line contact.
    x1_init : ndarray, shape (n,)
        Contact point in the first state, with the clamp at x = 0 (L).
    """

    steps: list[ContactStates]
    line: BoolArray
    x1_init: FloatArray


def begin(theta: FloatArray, eta: FloatArray, nodes: int, model: Contact) -> tuple[Branch, Index]:
    """Solve the states in which branches begin.

    Parameters
    ----------
    theta, eta : ndarray, shape (n,)
        Taper factors and heights of the surface (L).
    nodes : int
        Number of collocation nodes.
    model : Contact
        POINT for contact with the tip alone, LINE for the kind that is possible.

    Returns
    -------
    branch : Branch
        With one step, for those that were found.
    index : ndarray of int
        Which of the arguments they are.
    """
    states, found = initial_states(theta, eta, nodes)
    line = np.zeros(len(theta), dtype=bool)
    if model is Contact.LINE:
        line = found & (contact_slope(states) < 0.0)
        lying = np.flatnonzero(line)
        if len(lying):
            solution, found[lying] = _lowered(theta[lying], eta[lying], nodes)
            states.put(lying, solution)
    index = np.flatnonzero(found)
    states = states.take(index)
    x1_init, _ = contact_position(states)
    return Branch([states], line[None, index], x1_init), index


def _lowered(theta: FloatArray, eta: FloatArray, nodes: int) -> tuple[ContactStates, BoolArray]:
    """Solve α = 0 states in line contact by lowering the surface from where the tip alone touches.

    Straight from the point-contact state, Newton's iteration finds only those that differ little.
    """
    # The deflection grows like the square root of 1 − η: equal steps of it.
    root = np.linspace(np.sqrt(1.0 - HIGHEST), np.sqrt(1.0 - eta), LOWERING_STEPS)
    steps = [initial_states(theta, 1.0 - root[0] ** 2, nodes)[0]]
    line = np.zeros(len(theta), dtype=bool)
    for width in root[1:]:
        height = 1.0 - width**2
        guess = extrapolated(steps[-3:])
        # Where the kind just changed, the extrapolated s_c may have passed 1.
        guess = replace(guess, s_c=np.where(line, np.minimum(guess.s_c, 1.0), 1.0))
        states, found = _solve_kinds(guess, height, line, alpha=np.zeros(len(line)))
        other = np.flatnonzero(
            found & np.where(line, states.s_c > 1.0, contact_slope(states) < 0.0)
        )
        if len(other):
            line[other] = ~line[other]
            again = replace(guess.take(other), s_c=np.ones(len(other)))
            solution, found[other] = _solve_kinds(
                again, height[other], line[other], alpha=np.zeros(len(other))
            )
            states.put(other, solution)
        steps.append(states)
    return states, found & line & (states.s_c > 0.0) & (states.s_c < 1.0)


def follow(
    branch: Branch,
    eta: FloatArray,
    step: FloatArray,
    count: int,
    model: Contact,
    operator: FloatArray,
    stop_at_lock: bool,
) -> Branch:
    """Follow branches from where they begin in equal steps of x0.

    Parameters
    ----------
    branch : Branch
        As `begin` returns it.
    eta : ndarray, shape (n,)
        Heights of the surface (L).
    step : ndarray, shape (n,)
        Displacement per step (L).
    count : int
        Largest number of steps.
    model : Contact
        POINT or LINE, as in `begin`.
    operator : ndarray, shape (n, nodes, nodes)
        `integral_operator` of the rods in point contact.
    stop_at_lock : bool
        Whether a branch ends with the first state that needs less friction than the one before.

    Returns
    -------
    Branch
        With up to `count` more steps.
    """
    steps, line = list(branch.steps), list(branch.line)
    active = np.arange(len(branch.x1_init))
    while len(active) and len(steps) <= count:
        guess = extrapolated([states.take(active) for states in steps[-3:]])
        offset = branch.x1_init[active] - len(steps) * step[active]
        solution, kind, found = settle(
            guess, eta[active], offset, line[-1][active], model, operator[active]
        )
        first = steps[0]
        states = ContactStates(
            first.theta,
            *(np.full_like(a, np.nan) for a in (first.phi, first.fx, first.fy, first.s_c)),
        )
        states.put(active, solution)
        steps.append(states)
        line.append(line[-1].copy())
        line[-1][active] = kind
        goes_on = found
        if stop_at_lock:
            demand, before = (s.fx[active] / s.fy[active] for s in (steps[-1], steps[-2]))
            goes_on = found & ~(demand < before) & (steps[-1].fy[active] < 0.0)
        active = active[goes_on]
    return Branch(steps, np.stack(line), branch.x1_init)


def settle(
    guess: ContactStates,
    eta: FloatArray,
    offset: FloatArray,
    line: BoolArray,
    model: Contact,
    operator: FloatArray,
) -> tuple[ContactStates, BoolArray, BoolArray]:
    """Solve states at given offsets with the kind of contact that is possible.

    Parameters
    ----------
    guess : ContactStates
    eta, offset : ndarray, shape (n,)
        Heights of the surface and offsets x1 − x0 (L).
    line : ndarray of bool, shape (n,)
        Kind of contact to try first.
    model : Contact
        POINT or LINE, as in `begin`.
    operator : ndarray, shape (n, nodes, nodes)
        `integral_operator` of the rods in point contact.

    Returns
    -------
    states : ContactStates
        NaN where none was found.
    line : ndarray of bool, shape (n,)
        Kind of contact of each.
    found : ndarray of bool, shape (n,)
    """
    states, found = _solve_kinds(guess, eta, line, offset=offset, operator=operator)
    if model is Contact.LINE:
        impossible = found & np.where(line, states.s_c > 1.0, contact_slope(states) < 0.0)
        other = np.flatnonzero(impossible)
        if len(other):
            line = line.copy()
            line[other] = ~line[other]
            solution, again = _solve_kinds(
                states.take(other),
                eta[other],
                line[other],
                offset=offset[other],
                operator=operator[other],
            )
            states.put(other, solution)
            slope = contact_slope(solution)
            found[other] = again & np.where(line[other], solution.s_c <= 1.0, slope >= 0.0)
    # s_c runs away where the rod would lie down altogether
    return states, line, found & (states.s_c > 0.0)


def switch_states(guess: ContactStates, eta: FloatArray) -> tuple[ContactStates, FloatArray]:
    """Solve the states in which the contact changes its kind: s_c = 1 and φ1 = 0.

    Parameters
    ----------
    guess : ContactStates
        States near the change.
    eta : ndarray, shape (n,)
        Heights of the surface (L).

    Returns
    -------
    states : ContactStates
        NaN where none was found.
    offset : ndarray, shape (n,)
        Their offsets x1 − x0 (L).
    """
    states, _ = solve(guess, eta, Closure())
    return states, contact_position(states)[0]


def _solve_kinds(
    guess: ContactStates,
    eta: FloatArray,
    line: BoolArray,
    *,
    offset: FloatArray | None = None,
    alpha: FloatArray | None = None,
    operator: FloatArray | None = None,
) -> tuple[ContactStates, BoolArray]:
    """Solve a batch in which each state has its kind of contact."""
    columns = (guess.phi, guess.fx, guess.fy, guess.s_c)
    states = ContactStates(guess.theta, *(np.full_like(a, np.nan) for a in columns))
    found = np.zeros(len(guess), dtype=bool)
    for contact, index in (
        (Contact.POINT, np.flatnonzero(~line)),
        (Contact.LINE, np.flatnonzero(line)),
    ):
        if len(index):
            closure = Closure(contact, offset, alpha).take(index)
            matrix = operator[index] if contact is Contact.POINT and operator is not None else None
            solution, found[index] = solve(guess.take(index), eta[index], closure, matrix)
            states.put(index, solution)
    return states, found
