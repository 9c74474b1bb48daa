"""Paths are cut into smooth parts, each with one continuation parameter that grows along it.

The parameter is the displacement while it grows steadily, otherwise that of E3c.
"""

from collections.abc import Iterator
from dataclasses import dataclass
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

# Least share of the displacement in the direction of a path that it is the parameter of; more where
# the path turns back in the end.
STEADY, STEADY_BEFORE_TURN = 0.05, 0.4
# Least share of a direction in those of a part that has its parameter along it.
ALONG = 0.4
# The displacement as a direction.
X0 = np.array([1.0, 0.0, 0.0, 0.0])

RESIDUAL_TOLERANCE = 1e-12
# On more nodes than these rounding alone comes near that.
MANY_NODES, ROUNDED_TOLERANCE = 100, 1e-11
# Bound on the last coefficients of series relative to the largest.
DECAY_TOLERANCE = 1e-12
NODES_ALONG_ROD = (24, 32, 40, 52, 72, 96, 128, 170, 224, 300)


class Section(NamedTuple):
    """Knots at the ends of a smooth part, and the direction in which its parameter grows."""

    first: int
    last: int
    by_x0: bool
    direction: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Parts(Batch):
    """Smooth parts of paths, to be resolved.

    Attributes
    ----------
    start, length : ndarray, shape (n,)
        First value of the parameter, and length of the part (x0 in L).
    weights, shift : ndarray, shape (n, 5) and (n,)
        The parameter is weights·(offset, fx, fy, s_c, φ1) + shift.
    height, tilt : ndarray, shape (n,)
        Of E2.
    """

    section: IntArray
    branch: IntArray
    by_x0: BoolArray
    line: BoolArray
    start: FloatArray
    length: FloatArray
    weights: FloatArray
    shift: FloatArray
    height: FloatArray
    tilt: FloatArray

    def closing_at(self, position: FloatArray) -> ClosingCondition:
        """Return the conditions at fractions of the parts, ordered by place, then by part."""
        value = self.start - self.shift + position[:, None] * self.length
        count = len(position)
        return ClosingCondition(
            height=np.tile(self.height, count),
            tilt=np.tile(self.tilt, count),
            weights=np.tile(self.weights, (count, 1)),
            value=value.ravel(),
        )


def sections_of(followed: Followed, side: FloatArray) -> list[Section]:
    """Cut paths into sections that have one parameter each, in the order of the knots."""
    knots, sections = followed.knots, []
    begins = np.append(np.flatnonzero(knots.step == 0.0), len(knots))
    ends = knots.direction[followed.last, 0]
    for start, stop in pairwise(begins.tolist()):
        along, ahead = knots.direction[start:stop], side[knots.branch[start]]
        # Also in a kink: the last knot of the whole path shows it.
        turns = ends[knots.branch[start]] * ahead < STEADY
        steady = along[:, 0] * ahead >= (STEADY_BEFORE_TURN if turns else STEADY)
        by_x0 = steady[:-1] & steady[1:]
        cuts = np.flatnonzero(by_x0[1:] != by_x0[:-1]) + 1
        for low, high in pairwise([0, *cuts.tolist(), len(by_x0)]):
            if low == high:
                continue
            if by_x0[low]:
                sections.append(Section(start + low, start + high, True, ahead * X0))
                continue
            for i, j, direction in _straight(along, low, high):
                sections.append(Section(start + i, start + j, False, direction))
    return sections


def _straight(along: FloatArray, low: int, high: int) -> Iterator[tuple[int, int, FloatArray]]:
    """Cut where the directions of a path differ too much from that of its ends."""
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
    """Largest residual of a state that counts as solved on a number of nodes."""
    return RESIDUAL_TOLERANCE if nodes <= MANY_NODES else ROUNDED_TOLERANCE


def resolved_states(
    guess: RodStates, closing: ClosingCondition
) -> Iterator[tuple[IntArray, RodStates, FloatArray]]:
    """Solve states on as many nodes as each needs: rows, states and largest residuals."""
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
    """Offset, fx, fy and s_c of states, shape (n, 4); NaN where not resolved."""
    found = np.full((len(guess), 4), np.nan)
    for rows, states, _ in resolved_states(guess, closing):
        found[rows] = end_quantities(states)
    return found


def cut(branches: Branches, followed: Followed, side: FloatArray, sections: list[Section]) -> Parts:
    """Cut paths, with exact `x1_init`, into smooth parts; NaN where an end is not resolved."""
    knots = followed.knots
    first, last = (np.array([s[i] for s in sections], dtype=np.int64) for i in (0, 1))
    by_x0 = np.array([s.by_x0 for s in sections], dtype=bool)
    direction = np.array([s.direction for s in sections]).reshape(-1, 4)
    quantities = _exact_knots(branches, followed, sections)
    branch = knots.branch[first]
    some = branches.take(branch)
    weights, shift = some.weights(direction), np.zeros(len(sections))
    # The displacement itself, not the way along it.
    weights[by_x0] = 0.0
    weights[by_x0, OFFSET] = -(side[branch] / some.cos)[by_x0]
    shift[by_x0] = (side[branch] * some.x1_init / some.cos)[by_x0]
    start, stop = (np.vecdot(weights[:, :4], quantities[at]) + shift for at in (first, last))
    start[by_x0 & followed.first[first]] = 0.0
    return Parts(
        section=np.arange(len(sections)),
        branch=branch,
        by_x0=by_x0,
        line=knots.states.line[first],
        start=start,
        length=stop - start,
        weights=weights,
        shift=shift,
        height=some.closing(weights, shift).height,
        tilt=some.tilt,
    )


def _exact_knots(branches: Branches, followed: Followed, sections: list[Section]) -> FloatArray:
    """Offset, fx, fy and s_c of all knots, exact where sections meet, shape (knots, 4)."""
    knots = followed.knots
    quantities = end_quantities(knots.states)
    # The displacement begins with 0, and the last knots lie beyond the ends of the paths.
    known = followed.first & np.isin(np.arange(len(knots)), [s.first for s in sections if s.by_x0])
    rows = np.unique([at for s in sections for at in (s.first, s.last)]).astype(np.int64)
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


def guessed(
    parts: Parts, sections: list[Section], branches: Branches, knots: Knots, count: int
) -> FloatArray:
    """Guess unknowns at Chebyshev points of parts, shape (count, n, nodes + 3)."""
    position = chebyshev_nodes(count)
    guess = np.empty((count, len(parts), knots.states.unknowns.shape[1]))
    quantities = end_quantities(knots.states)
    units = branches.units
    for k, number in enumerate(parts.section.tolist()):
        i, j = sections[number][:2]
        weights, branch = parts.weights[k, :4], parts.branch[k]
        value = quantities[i : j + 1] @ weights + parts.shift[k]
        slope = (knots.direction[i : j + 1] / units[branch]) @ weights
        target = parts.start[k] + position * parts.length[k]
        low = np.clip(np.searchsorted(value, target) - 1, 0, j - i - 1)
        high, step = low + 1, value[low + 1] - value[low]
        unknowns = knots.states.unknowns[i : j + 1]
        change = knots.change[i : j + 1] / slope[:, None]
        share = (target - value[low]) / step
        guess[:, k] = hermite(share, step, unknowns[low], unknowns[high], change[low], change[high])
    return guess
