"""Newton's iteration for batches of states: residuals on all nodes, Jacobians on fewer nodes."""

from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.equations import (
    ClosingCondition,
    FreeParts,
    derivatives,
    jacobian,
    residuals,
)
from vibrissa.mechanics.states import SCALARS, RodStates, transfer
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.numerics.batch import slices

MAX_ITERATIONS = 25
# Share of the nodes that Jacobians use, and the fewest nodes that are useful.
COARSE_NODES, FEWEST_COARSE_NODES = 0.35, 12
# Number of states that are solved together; their matrices fit into the cache.
STATES_AT_ONCE = 256
# Ratio of a correction to the previous one above which the inverse Jacobian is computed anew.
GOOD_CONTRACTION = 0.3
# On many nodes, corrections below this may be rounding errors.
ROUNDED_CORRECTION = 1e-9


class Solution(NamedTuple):
    """Result of Newton's iteration.

    Attributes
    ----------
    states : RodStates
        Solved states; the unknowns are NaN in states that did not converge.
    converged : ndarray of bool, shape (n,)
        Whether each state converged.
    inverse : ndarray, shape (n, k + 3, k + 3)
        The inverse Jacobians of the last corrections, on few nodes (`coarse_inverse`).
    """

    states: RodStates
    converged: BoolArray
    inverse: FloatArray


def solve(
    guess: RodStates,
    closing: ClosingCondition,
    tolerance: float = 1e-12,
    iterations: int = MAX_ITERATIONS,
    inverse: FloatArray | None = None,
) -> Solution:
    """Solve the equations of n states by Newton's method, starting from a guess.

    Parameters
    ----------
    tolerance : float
        The iteration of a state ends when all its corrections are below `tolerance`. Corrections of
        slopes are in rad. Those of fx, fy and s_c are divided by 1 + |fx| + |fy|. The remaining
        error is at most about a hundredth of `tolerance`.
    iterations : int
        Largest number of corrections.
    inverse : ndarray, shape (n, k + 3, k + 3), optional
        Approximate inverse Jacobians to begin with, as `coarse_inverse` computes them. Where they
        converge too slowly they are computed anew.
    """
    if len(guess) <= STATES_AT_ONCE:
        return _iterated(guess, closing, tolerance, iterations, inverse)
    solved = [
        _iterated(
            guess.take(part),
            closing.take(part),
            tolerance,
            iterations,
            None if inverse is None else inverse[part],
        )
        for part in slices(len(guess), STATES_AT_ONCE)
    ]
    return Solution(
        states=RodStates.concatenate([part.states for part in solved]),
        converged=np.concatenate([part.converged for part in solved]),
        inverse=np.concatenate([part.inverse for part in solved]),
    )


# Numbers may overflow where the iteration diverges; `converged` is then False.
@np.errstate(over="ignore", invalid="ignore", divide="ignore")
def _iterated(
    guess: RodStates,
    closing: ClosingCondition,
    tolerance: float,
    iterations: int,
    inverse: FloatArray | None,
) -> Solution:
    """Iterate until every state has converged, or cannot; see `solve`."""
    unknowns = guess.unknowns.copy()
    unknowns[~guess.line, -1] = 1.0
    states = guess.with_unknowns(unknowns)
    inverse = coarse_inverse(states, closing) if inverse is None else inverse.copy()
    # In point contact s_c does not change.
    free = None if guess.line.any() else FreeParts.of(states)
    converged, previous = np.zeros(len(states), dtype=bool), np.ones(len(states))
    active = np.arange(len(states))
    for _ in range(iterations):
        whole = len(active) == len(states)
        every = slice(None) if whole else active
        if whole:
            change = _correction(states, closing, free, inverse)
        else:
            known = None if free is None else free.take(active)
            some = states.take(active), closing.take(active), known
            change = _correction(*some, inverse[active])
        unknowns[every] -= change
        states = guess.with_unknowns(unknowns)
        size = _size(unknowns[every], change)
        shrunk = size / previous[every]
        previous[every] = size
        # Near rounding error, corrections do not shrink any more.
        done = (size < tolerance) | ((size < ROUNDED_CORRECTION) & (shrunk > 0.5))
        converged[active[done]] = True
        goes_on = ~done & np.isfinite(size)
        slow = active[goes_on & ~(shrunk < GOOD_CONTRACTION)]
        active = active[goes_on]
        if not len(active):
            break
        if len(slow):
            inverse[slow] = coarse_inverse(states.take(slow), closing.take(slow))
    solved = np.where(converged[:, None], unknowns, np.nan)
    return Solution(
        states=guess.with_unknowns(solved), converged=converged, inverse=np.asarray(inverse)
    )


def _correction(
    states: RodStates, closing: ClosingCondition, free: FreeParts | None, inverse: FloatArray
) -> FloatArray:
    """Compute corrections from residuals on all nodes and inverse Jacobians on fewer nodes.

    Fewer nodes suffice, because the integral operator of E1 makes the difference between correction
    and residual smooth (K. E. Atkinson, The Numerical Solution of Integral Equations of the Second
    Kind, 1997, §6.2).
    """
    nodes, few = states.nodes, inverse.shape[1] - SCALARS
    values = residuals(states, closing, free)
    right = values @ transfer(nodes, few)
    update = np.matvec(inverse, right)
    update[:, :few] -= right[:, :few]
    change = update @ transfer(few, nodes)
    change[:, :nodes] += values[:, :nodes]
    return np.asarray(change)


def _size(unknowns: FloatArray, change: FloatArray) -> FloatArray:
    """Largest change of an unknown; changes of fx, fy and s_c are divided by 1 + |fx| + |fy|."""
    size = np.abs(change)
    force = 1.0 + np.abs(unknowns[:, -3]) + np.abs(unknowns[:, -2])
    size[:, -SCALARS:] /= force[:, None]
    return np.asarray(size.max(axis=1))


def coarse_nodes(nodes: int) -> int:
    """Choose the number of nodes on which the Jacobian of states with `nodes` nodes is computed."""
    return min(nodes, max(FEWEST_COARSE_NODES, round(COARSE_NODES * nodes)))


def coarse_inverse(states: RodStates, closing: ClosingCondition) -> FloatArray:
    """Compute the Jacobians of states on fewer nodes, and invert them.

    Returns
    -------
    ndarray, shape (n, k + 3, k + 3)
        Inverse Jacobians on k nodes, where `coarse_nodes` chooses k; NaN where singular.
    """
    few = states.on_nodes(coarse_nodes(states.nodes))
    inverse = np.empty((len(few), few.nodes + SCALARS, few.nodes + SCALARS))
    for part in slices(len(few), STATES_AT_ONCE):
        inverse[part] = _inverted(jacobian(few.take(part), closing.take(part)))
    return inverse


def _inverted(matrices: FloatArray) -> FloatArray:
    try:
        return np.asarray(np.linalg.inv(matrices))
    except np.linalg.LinAlgError:  # one exactly singular matrix spoils the whole stack
        regular = np.linalg.slogdet(matrices)[0] != 0.0
        inverse = np.full_like(matrices, np.nan)
        inverse[regular] = np.linalg.inv(matrices[regular])
        return inverse


class Tangent(NamedTuple):
    """Derivatives of states with respect to the value that the closing condition E3 prescribes.

    Attributes
    ----------
    change : ndarray, shape (n, nodes + 3)
        Derivatives of the unknowns, from a Jacobian on fewer nodes.
    ends : ndarray, shape (n, 5)
        Derivatives of offset, fx, fy, s_c and φ1.
    """

    change: FloatArray
    ends: FloatArray


def tangent(states: RodStates, closing: ClosingCondition) -> Tangent:
    """Differentiate states with respect to the value that the closing condition E3 prescribes."""
    few = states.on_nodes(coarse_nodes(states.nodes))
    changes = derivatives(few)
    column = _inverted(jacobian(few, closing, changes))[:, :, -2]
    by_ends = np.matvec(changes.ends, column)
    return Tangent(column @ transfer(few.nodes, states.nodes), by_ends)
