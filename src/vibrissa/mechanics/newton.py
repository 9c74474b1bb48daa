"""Newton's iteration for batches of states, corrected on few nodes and measured on all."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.equations import VALUES_TOGETHER, Closure, jacobian, residuals
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray, SingleArray
from vibrissa.numerics.batch import slices
from vibrissa.numerics.inverses import inverses
from vibrissa.numerics.spectral import refinement_matrix
from vibrissa.outcomes import Contact

MAX_ITERATIONS = 25
# Part of the nodes on which corrections are found, and tangents; and the fewest that make sense.
COARSE_NODES, TANGENT_NODES = 0.3, 0.6
FEWEST_COARSE_NODES = 10
# What follows E1 at the nodes: E2, E3 and E4.
EQUATIONS_OF_ENDS = 3
# Where a correction is not this much smaller than the one before, the inverse is computed anew.
GOOD_CONTRACTION = 0.1
# Corrections below this may be rounding, on many nodes.
ROUNDING = 1e-9


def coarse_inverse(states: RodStates, closure: Closure, few: int | None = None) -> SingleArray:
    """Inverse of the Jacobian on few nodes, which corrects states on all of them.

    Parameters
    ----------
    states : RodStates
    closure : Closure
    few : int, optional
        How many nodes; by default as many as corrections need.

    Returns
    -------
    ndarray of float32, shape (n, k + 3, k + 3)
        In single precision: a correction need not be more accurate. NaN where there is none.
    """
    few = coarse_nodes(states.nodes) if few is None else few
    matrices = jacobian(states.on_nodes(few), closure)
    try:
        return inverses(matrices, EQUATIONS_OF_ENDS)
    except np.linalg.LinAlgError:  # one exactly singular matrix spoils the whole stack
        return np.stack([_inverse_or_nan(matrix) for matrix in matrices])


def tangent(states: RodStates, closure: Closure) -> tuple[RodStates, SingleArray]:
    """Differentiate states by the value that E3 prescribes.

    Parameters
    ----------
    states : RodStates
    closure : Closure

    Returns
    -------
    change : RodStates
        Derivatives of the unknowns, as far as few nodes tell them.
    inverse : ndarray of float32, shape (n, k + 3, k + 3)
        `coarse_inverse` of the states.
    """
    inverse = coarse_inverse(states, closure, coarse_nodes(states.nodes, TANGENT_NODES))
    few = inverse.shape[1] - EQUATIONS_OF_ENDS
    column = inverse[:, :, few + 1].astype(np.float64)
    change = RodStates(
        theta=states.theta,
        phi=column[:, :few] @ _transfer(few, states.nodes),
        fx=column[:, few],
        fy=column[:, few + 1],
        s_c=column[:, few + 2],
    )
    return change, inverse


def _inverse_or_nan(matrix: SingleArray) -> SingleArray:
    try:
        return np.asarray(np.linalg.inv(matrix))
    except np.linalg.LinAlgError:
        return np.full_like(matrix, np.nan)


def coarse_nodes(nodes: int, share: float = COARSE_NODES) -> int:
    """Few nodes: those on which corrections of states on `nodes` nodes are found."""
    return min(nodes, max(FEWEST_COARSE_NODES, round(share * nodes)))


def corrected(
    states: RodStates, eta: FloatArray, closure: Closure, inverse: SingleArray
) -> tuple[RodStates, FloatArray]:
    """Correct states once, on two grids.

    The residual is that on all nodes, but the correction comes from few. What it has beyond the
    residual itself is integrated twice in equation E1, hence smooth (K. E. Atkinson, The Numerical
    Solution of Integral Equations of the Second Kind, 1997, §6.2).

    Parameters
    ----------
    states : RodStates
    eta : ndarray, shape (n,)
        Height of the contact point, in units of L.
    closure : Closure
    inverse : ndarray, shape (n, k + 3, k + 3)
        `coarse_inverse` of the states or of similar ones.

    Returns
    -------
    states : RodStates
    size : ndarray, shape (n,)
        Largest change, of the slope (rad), of a force relative to it or of s_c (L).
    """
    nodes, few = states.nodes, inverse.shape[1] - 3
    values = residuals(states, eta, closure)
    restriction, prolongation = _transfer(nodes, few), _transfer(few, nodes)
    right = np.concatenate([values[:, :nodes] @ restriction, values[:, nodes:]], axis=1)
    # Scaled, as small numbers would lose digits in single precision.
    scale = np.abs(right).max(axis=1, keepdims=True) + np.finfo(float).tiny
    update = np.matvec(inverse, (right / scale).astype(np.float32)) * scale
    change = values[:, :nodes] + (update[:, :few] - right[:, :few]) @ prolongation
    of_fx, of_fy, of_s_c = update[:, few:].T
    force = 1.0 + np.abs(states.fx) + np.abs(states.fy)
    size = np.maximum(np.abs(change).max(axis=1), np.abs(update[:, few:]).max(axis=1) / force)
    better = RodStates(
        theta=states.theta,
        phi=states.phi - change,
        fx=states.fx - of_fx,
        fy=states.fy - of_fy,
        s_c=states.s_c - of_s_c,
        mounting=states.mounting,
    )
    return better, size


@lru_cache
def _transfer(nodes: int, other: int) -> FloatArray:
    """Interpolation from some nodes to others, from the right."""
    matrix = np.eye(nodes) if nodes == other else refinement_matrix(nodes, other)[1:-1].T
    return np.ascontiguousarray(matrix)


class Solution(NamedTuple):
    """What Newton's iteration found.

    Attributes
    ----------
    states : RodStates
        NaN where the iteration did not converge.
    converged : ndarray of bool, shape (n,)
    inverse : ndarray, shape (n, k + 3, k + 3)
        `coarse_inverse` near each state.
    """

    states: RodStates
    converged: BoolArray
    inverse: SingleArray


# Where the iteration diverges numbers overflow; the result says so.
@np.errstate(over="ignore", invalid="ignore", divide="ignore")
def solve(
    guess: RodStates,
    eta: FloatArray,
    closure: Closure,
    inverse: SingleArray | None = None,
    tolerance: float = 1e-12,
    iterations: int = MAX_ITERATIONS,
) -> Solution:
    """Solve a batch of states at once, starting from a guess.

    Parameters
    ----------
    guess : RodStates
        Starting states; not modified.
    eta : ndarray, shape (n,)
        Height of the contact point, in units of L.
    closure : Closure
        The conditions that each state must satisfy.
    inverse : ndarray, shape (n, k + 3, k + 3), optional
        `coarse_inverse` near each state, where the caller has it already.
    tolerance : float
        Change at which the iteration ends; the error is then about a hundredth of it.
    iterations : int
        Most corrections.

    Returns
    -------
    Solution
    """
    states = guess.copy()
    if closure.contact is Contact.POINT:
        states.s_c[:] = 1.0
    inverse = coarse_inverse(states, closure) if inverse is None else inverse.copy()
    converged = np.zeros(len(states), dtype=bool)
    for part in slices(len(states), VALUES_TOGETHER // states.nodes):
        found = _iterated(
            states.take(part), eta[part], closure.take(part), inverse[part], tolerance, iterations
        )
        states.put(part, found.states)
        converged[part] = found.converged
    return Solution(states, converged, inverse)


def _iterated(
    states: RodStates,
    eta: FloatArray,
    closure: Closure,
    inverse: SingleArray,
    tolerance: float,
    iterations: int,
) -> Solution:
    """Correct states until they no longer change; `inverse` is renewed in place."""
    converged = np.zeros(len(states), dtype=bool)
    previous = np.ones(len(states))
    active = np.arange(len(states))
    for _ in range(iterations):
        if len(active) == len(states):
            states, size = corrected(states, eta, closure, inverse)
        else:
            better, size = corrected(
                states.take(active), eta[active], closure.take(active), inverse[active]
            )
            states.put(active, better)
        shrunk = size / previous[active]
        previous[active] = size
        # Near rounding nothing shrinks any more.
        done = (size < tolerance) | ((size < ROUNDING) & (shrunk > 0.5))
        converged[active[done]] = True
        goes_on = ~done & np.isfinite(size)
        slow = active[goes_on & ~(shrunk < GOOD_CONTRACTION)]
        active = active[goes_on]
        if not len(active):
            break
        if len(slow):
            few = inverse.shape[1] - EQUATIONS_OF_ENDS
            inverse[slow] = coarse_inverse(states.take(slow), closure.take(slow), few)
    if not converged.all():
        states.forget(~converged)
    return Solution(states, converged, inverse)
