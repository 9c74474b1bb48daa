"""Cutting of paths into smooth parts, each with one continuation parameter that grows along it.

Where the displacement grows steadily, it is the parameter. Elsewhere the parameter is the
component of the path coordinates along a fixed direction (equation E3c).
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.equations import (
    FX,
    OFFSET,
    PHI1,
    ClosingCondition,
    coefficient_decay,
    largest_residual,
)
from vibrissa.mechanics.newton import solve
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.numerics.batch import Batch
from vibrissa.numerics.spectral import chebyshev_nodes
from vibrissa.sticking.solving.branches import Branches, end_quantities
from vibrissa.sticking.solving.following import Followed, Knots, hermite

# Smallest component of the displacement in the direction of a path where it is the parameter; the
# second value is for paths that turn back at their end.
STEADY, STEADY_BEFORE_TURN = 0.05, 0.4
# Smallest cosine of the angle between the path and the direction along which a parameter grows.
ALONG = 0.4
# Direction in which the displacement grows.
X0 = np.array([1.0, 0.0, 0.0, 0.0])

RESIDUAL_TOLERANCE = 1e-12
# On more nodes, rounding errors come near that tolerance, and a larger one holds.
MANY_NODES, ROUNDED_TOLERANCE = 100, 1e-11
# Bound on the last coefficients of series relative to the largest.
DECAY_TOLERANCE = 1e-12
NODES_ALONG_ROD = (24, 32, 40, 52, 72, 96, 128, 170, 224, 300)


class PathSection(NamedTuple):
    """A smooth part of a path, from the knot `first` to the knot `last`.

    Its parameter grows along the unit vector `direction` in path coordinates, shape (4,). `by_x0`
    tells whether the parameter is the displacement.
    """

    first: int
    last: int
    by_x0: bool
    direction: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Parts(Batch):
    """Smooth parts of paths, each with one continuation parameter; their states are not yet solved.

    Attributes
    ----------
    first, last : ndarray of int, shape (n,)
        Indices of the knots (`Followed.knots`) at both ends of each part.
    branch : ndarray of int, shape (n,)
        Index of the branch to which each part belongs.
    by_x0 : ndarray of bool, shape (n,)
        Whether the parameter is the displacement, as |x0|; otherwise it is that of E3c.
    line : ndarray of bool, shape (n,)
        Whether the states are in line contact.
    start, length : ndarray, shape (n,)
        First value of the parameter, and its increase along the part (in L if it is |x0|).
    closing : ClosingCondition
        Equations E2 (height of the contact point) and E3 (parameter) for the parameter value 0.
    """

    first: IntArray
    last: IntArray
    branch: IntArray
    rods: FloatArray
    by_x0: BoolArray
    line: BoolArray
    start: FloatArray
    length: FloatArray
    closing: ClosingCondition

    def closing_at(self, position: FloatArray) -> ClosingCondition:
        """Conditions E2 and E3 at fractions `position` of each part, one part after the other."""
        closing = self.closing.take(np.repeat(np.arange(len(self)), len(position)))
        closing.value[:] += (self.start[:, None] + self.length[:, None] * position).ravel()
        return closing


def _sections(followed: Followed, side: FloatArray) -> list[PathSection]:
    """Cut paths into sections that have one parameter each, in the order of the knots."""
    knots, sections = followed.knots, []
    begins = np.append(np.flatnonzero(knots.step == 0.0), len(knots))
    ends = knots.direction[followed.last, 0]
    for start, stop in pairwise(begins.tolist()):
        along, ahead = knots.direction[start:stop], side[knots.branch[start]]
        # The last knot of a whole path shows whether it turns back, also in a kink.
        turns = ends[knots.branch[start]] * ahead < STEADY
        steady = along[:, 0] * ahead >= (STEADY_BEFORE_TURN if turns else STEADY)
        by_x0 = steady[:-1] & steady[1:]
        cuts = np.flatnonzero(by_x0[1:] != by_x0[:-1]) + 1
        for low, high in pairwise([0, *cuts.tolist(), len(by_x0)]):
            if low == high:
                continue
            if by_x0[low]:
                sections.append(PathSection(start + low, start + high, True, ahead * X0))
                continue
            for i, j, direction in _straight(along, low, high):
                sections.append(PathSection(start + i, start + j, False, direction))
    return sections


def _straight(along: FloatArray, low: int, high: int) -> Iterator[tuple[int, int, FloatArray]]:
    """Halve a stretch of knots until all its directions are near the mean of those at its ends."""
    ends = [low, high]
    while len(ends) > 1:
        low, high = ends[:2]
        middle = along[low] + along[high]
        direction = middle / np.linalg.norm(middle)
        if high - low == 1 or (along[low : high + 1] @ direction).min() > ALONG:
            yield low, high, direction
            ends.pop(0)
        else:
            ends.insert(1, (low + high) // 2)


def residual_tolerance(nodes: int) -> float:
    """Residual below which a state on `nodes` nodes along the rod counts as solved."""
    return RESIDUAL_TOLERANCE if nodes <= MANY_NODES else ROUNDED_TOLERANCE


def resolved_states(
    guess: RodStates, closing: ClosingCondition
) -> Iterator[tuple[IntArray, RodStates, FloatArray]]:
    """Solve states, each on as many nodes along the rod as it needs.

    Yields, for each number of nodes, the rows of `guess` that were resolved on it, their states and
    the largest residual of each state.
    """
    rows = np.arange(len(guess))
    for nodes in NODES_ALONG_ROD:
        if not len(rows):
            break
        some = closing.take(rows)
        states = solve(guess.take(rows).on_nodes(nodes), some).states
        residual = largest_residual(states, some)
        good = residual < residual_tolerance(nodes)
        good &= coefficient_decay(states) < DECAY_TOLERANCE
        yield rows[good], states.take(good), residual[good]
        rows = rows[~good]


def exact_ends(guess: RodStates, closing: ClosingCondition) -> FloatArray:
    """Solve states and return their offset, fx, fy and s_c, shape (n, 4); NaN if not resolved."""
    found = np.full((len(guess), 4), np.nan)
    for rows, states, _ in resolved_states(guess, closing):
        found[rows] = end_quantities(states)
    return found


def cut(branches: Branches, followed: Followed, side: FloatArray) -> Parts:
    """Cut paths into smooth parts; a part has the length NaN if one of its ends is not resolved.

    The `x1_init` of the branches must be exact. `side` is explained in `follow`.
    """
    knots, sections = followed.knots, _sections(followed, side)
    first, last = (np.array([s[i] for s in sections], dtype=np.int64) for i in (0, 1))
    by_x0 = np.array([s.by_x0 for s in sections], dtype=bool)
    direction = np.array([s.direction for s in sections]).reshape(-1, 4)
    branch = knots.branch[first]
    some = branches.take(branch)
    along = some.along(direction, np.zeros(len(first)))
    # Where the displacement is the parameter, it is measured in L.
    ahead = side[branch] / some.cos
    in_lengths = np.zeros_like(along.weights)
    in_lengths[:, OFFSET] = -ahead
    closing = replace(
        along,
        weights=np.where(by_x0[:, None], in_lengths, along.weights),
        value=np.where(by_x0, -ahead * some.x1_init, along.value),
    )
    quantities = _exact_knots(branches, followed, first, last, by_x0)
    weights = closing.weights[:, :4]
    start, stop = (np.vecdot(weights, quantities[at]) - closing.value for at in (first, last))
    start[by_x0 & followed.first[first]] = 0.0
    return Parts(
        first=first,
        last=last,
        branch=branch,
        rods=some.rods,
        by_x0=by_x0,
        line=knots.states.line[first],
        start=start,
        length=stop - start,
        closing=closing,
    )


def _exact_knots(
    branches: Branches, followed: Followed, first: IntArray, last: IntArray, by_x0: BoolArray
) -> FloatArray:
    """Offset, fx, fy and s_c of all knots, exact where sections meet, shape (knots, 4)."""
    knots = followed.knots
    quantities = end_quantities(knots.states)
    # Two kinds of knots need no solution: the first, where x0 = 0, and the last, which are beyond
    # the ends of the paths.
    known = followed.first & np.isin(np.arange(len(knots)), first[by_x0])
    rows = np.union1d(first, last)
    rows = rows[~followed.last[rows] & ~known[rows]]
    some, chosen = branches.take(knots.branch[rows]), knots.take(rows)
    upright, switch = followed.first[rows], followed.kinks[rows]
    value = np.vecdot(chosen.direction, some.units * quantities[rows])
    closing = some.along(chosen.direction, value)
    for special, quantity in ((upright, FX), (switch, PHI1)):
        closing.weights[special] = np.eye(5)[quantity]
        closing.value[special] = 0.0
    chosen.states.line[switch] = False
    quantities[rows] = exact_ends(chosen.states, closing)
    return quantities


def guessed(parts: Parts, branches: Branches, knots: Knots, count: int) -> FloatArray:
    """Guess the states at `count` Chebyshev points of each part, by interpolation between knots.

    Returns their unknowns, shape (parts, count, nodes + 3).
    """
    guess = np.empty((len(parts), count, knots.states.unknowns.shape[1]))
    quantities, units = end_quantities(knots.states), branches.units[knots.branch]
    target = parts.start[:, None] + chebyshev_nodes(count) * parts.length[:, None]
    for row, (first, last) in enumerate(zip(parts.first, parts.last, strict=True)):
        some, weights = slice(first, last + 1), parts.closing.weights[row, :4]
        value = quantities[some] @ weights - parts.closing.value[row]
        slope = (knots.direction[some] / units[some]) @ weights
        low = np.clip(np.searchsorted(value, target[row]) - 1, 0, last - first - 1)
        high, step = low + 1, value[low + 1] - value[low]
        unknowns, change = knots.states.unknowns[some], knots.change[some] / slope[:, None]
        share = (target[row] - value[low]) / step
        guess[row] = hermite(share, step, unknowns[low], unknowns[high], change[low], change[high])
    return guess
