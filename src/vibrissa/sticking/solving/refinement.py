"""Refinement: smooth parts of paths are solved at Chebyshev points until they are resolved.

The numbers of nodes along the rod and of states along the part grow until two conditions hold. The
last coefficients of the series along the rod and along the part are below their tolerance. The
residual between the states is below its tolerance.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from vibrissa.mechanics.equations import coefficient_decay, ends, largest_residual
from vibrissa.mechanics.newton import coarse_inverse, solve
from vibrissa.mechanics.states import SCALARS, RodStates, transfer
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.batch import Batch
from vibrissa.numerics.spectral import (
    chebyshev_interpolation,
    chebyshev_nodes,
    chebyshev_transform,
    interpolation,
)
from vibrissa.sticking.solving.cutting import (
    DECAY_TOLERANCE,
    NODES_ALONG_ROD,
    Parts,
    residual_tolerance,
)

# Numbers of states along a part. A solution with the first one shows which is needed.
STATES_ALONG_PART = (17, 25, 33, 41, 49)
NOT_RESOLVED = (
    "the residual or the last coefficients of the series stay above 1e-12 with "
    f"{NODES_ALONG_ROD[-1]} nodes along the rod; try a larger eta or a theta closer to 1"
)
# Most successive halvings of a part.
HALVINGS = 6


@dataclass(frozen=True, eq=False, kw_only=True)
class StatesAlongParts(Batch):
    """States of smooth parts of paths, guessed or solved, at Chebyshev points of their parameters.

    Attributes
    ----------
    unknowns : ndarray, shape (n, states, nodes + 3)
        Unknowns of the states of each part, as in `vibrissa.mechanics.states.RodStates`.
    inverse : ndarray, shape (n, states, k + 3, k + 3), or None
        Inverse Jacobians of the states on few nodes (`vibrissa.mechanics.newton.coarse_inverse`);
        None if they are not known.
    """

    parts: Parts
    unknowns: FloatArray
    inverse: FloatArray | None = None

    @property
    def count(self) -> int:
        """Number of states along each part."""
        return self.unknowns.shape[1]

    @property
    def nodes(self) -> int:
        """Number of nodes along the rod."""
        return self.unknowns.shape[2] - SCALARS

    @property
    def states(self) -> RodStates:
        """States of all parts in one batch, one part after the other."""
        each = np.repeat(np.arange(len(self)), self.count)
        return RodStates(
            rods=self.parts.rods[each],
            unknowns=self.unknowns.reshape(-1, self.unknowns.shape[2]),
            line=self.parts.line[each],
        )

    def on_nodes(self, nodes: int) -> Self:
        """Interpolate states to another number of nodes along the rod."""
        return replace(self, unknowns=self.unknowns @ transfer(self.nodes, nodes), inverse=None)

    def at(self, position: FloatArray) -> Self:
        """Interpolate the states of each part at the fractions `position` of its length.

        The shape of `position` is (k,) if the fractions are common to all parts, else (n, k).
        """
        rows = interpolation(self.count, position.ravel()).reshape(*position.shape, self.count)
        return replace(self, unknowns=rows @ self.unknowns, inverse=None)

    def with_states(self, count: int) -> Self:
        """Interpolate the states and their inverse Jacobians to `count` Chebyshev points."""
        unknowns = chebyshev_interpolation(self.count, count) @ self.unknowns
        inverse = None if self.inverse is None else _interpolated(self.inverse, count)
        return replace(self, unknowns=unknowns, inverse=inverse)

    def _inverses(self) -> FloatArray:
        """Inverse Jacobians of the states, interpolated from those of every second state."""
        few = (self.count + 1) // 2
        closing = self.parts.closing_at(chebyshev_nodes(few))
        found = coarse_inverse(self.with_states(few).states, closing)
        return _interpolated(found.reshape(len(self), few, *found.shape[1:]), self.count)

    def solved(self) -> Self:
        """Solve the states, which are at the Chebyshev points; NaN if the iteration diverges."""
        inverse = self._inverses() if self.inverse is None else self.inverse
        inverse = inverse.reshape(-1, *inverse.shape[2:])
        closing = self.parts.closing_at(chebyshev_nodes(self.count))
        solution = solve(self.states, closing, inverse=inverse)
        matrices = solution.inverse
        return replace(
            self,
            unknowns=solution.states.unknowns.reshape(self.unknowns.shape),
            inverse=matrices.reshape(len(self), self.count, *matrices.shape[1:]),
        )

    def residual(self, position: FloatArray) -> FloatArray:
        """Largest residual at fractions `position` of each part; infinite if a state is NaN."""
        closing = self.parts.closing_at(position)
        residual = largest_residual(self.at(position).states, closing)
        return np.nan_to_num(residual, nan=np.inf).reshape(-1, len(position)).max(axis=1)


@dataclass(frozen=True, eq=False, kw_only=True)
class Resolved(Batch):
    """Resolved parts; all have the same number of states, on the same number of nodes.

    Attributes
    ----------
    path : StatesAlongParts
        The parts with their solved states.
    loads : ndarray, shape (n, states, 6)
        Offset, fx, fy, m(0), φ1 and s_c of each state.
    residual : ndarray, shape (n,)
        Largest residual of each part, half-way between its states.
    """

    path: StatesAlongParts
    loads: FloatArray
    residual: FloatArray


def resolve(guess: StatesAlongParts) -> Iterator[Resolved]:
    """Solve the states of parts, with more and more nodes and states, until they are resolved.

    A part for which no number of states is enough is halved. Yields batches of resolved parts and
    halves; what cannot be resolved is left out.
    """
    # The guesses show how many nodes along the rod the states need.
    needed = _needed(NODES_ALONG_ROD, guess.nodes, _rod_decay(guess), DECAY_TOLERANCE)
    tasks = [
        (guess.take(np.flatnonzero(needed == nodes)).on_nodes(int(nodes)), HALVINGS)
        for nodes in np.unique(needed)
    ]
    while tasks:
        task, halvings = tasks.pop()
        count, nodes = task.count, task.nodes
        position = chebyshev_nodes(count)
        path = task.solved()
        loads = _loads(path)
        rod, decay = _rod_decay(path) < DECAY_TOLERANCE, _decay_along(loads)
        smooth = np.flatnonzero(rod & (decay < DECAY_TOLERANCE))
        residual = np.full(len(path), np.inf)
        if len(smooth):
            residual[smooth] = path.take(smooth).residual(chebyshev_nodes(2 * count - 1)[1::2])
        resolved = residual < residual_tolerance(nodes)
        if resolved.any():
            known = replace(path, inverse=None)
            yield Resolved(path=known, loads=loads, residual=residual).take(resolved)
        if resolved.all():
            continue
        # More states help only where the rod itself is resolved.
        fine, doubtful = rod & ~resolved, smooth[~resolved[smooth]]
        if len(doubtful):
            exact = path.take(doubtful).residual(position) < 0.5 * residual_tolerance(nodes)
            fine[doubtful] = exact
        coarse = np.flatnonzero(~fine & ~resolved)
        finer = [n for n in NODES_ALONG_ROD if n > nodes]
        solved = np.isfinite(path.unknowns)
        better = replace(path, unknowns=np.where(solved, path.unknowns, task.unknowns))
        if finer and len(coarse):
            tasks.append((better.take(coarse).on_nodes(finer[0]), halvings))
        # Degrees of series; where no number of states is enough, a part is halved.
        degrees = [*(n - 1 for n in STATES_ALONG_PART if n > count), np.inf]
        wanted = 1 + _needed(degrees, count - 1, decay, 0.1 * DECAY_TOLERANCE)
        for more in np.unique(wanted[fine]):
            some = better.take(np.flatnonzero(fine & (wanted == more)))
            if np.isfinite(more):
                tasks.append((some.with_states(int(more)), halvings))
            elif halvings:
                tasks += ((half, halvings - 1) for half in _halves(some))


def _interpolated(matrices: FloatArray, count: int) -> FloatArray:
    """Interpolate matrices along parts, shape (n, states, k, k), to `count` Chebyshev points."""
    number, states, *shape = matrices.shape
    rows = chebyshev_interpolation(states, count) @ matrices.reshape(number, states, -1)
    return rows.reshape(number, count, *shape)


def _halves(path: StatesAlongParts) -> Iterator[StatesAlongParts]:
    """Yield the first halves of the parts, then the second halves, with interpolated states."""
    for share in (0.0, 0.5):
        start = path.parts.start + share * path.parts.length
        half = replace(path.parts, start=start, length=path.parts.length / 2.0)
        position = share + 0.5 * chebyshev_nodes(STATES_ALONG_PART[0])
        yield replace(path.at(position), parts=half)


def _needed(ladder: Sequence[float], number: int, decay: FloatArray, target: float) -> FloatArray:
    """Predict from the decay of series with `number` terms how many terms reach `target`.

    The prediction is rounded up to the next entry of `ladder`. A prediction beyond the last entry
    becomes the last entry.
    """
    with np.errstate(divide="ignore"):
        needed = number * np.log(target) / np.log(np.minimum(decay, 0.5))
    return np.array(ladder)[np.searchsorted(ladder, np.minimum(needed, ladder[-1]))]


def _rod_decay(path: StatesAlongParts) -> FloatArray:
    """Largest `coefficient_decay` among the states of each part; infinite if a state is NaN."""
    decays = coefficient_decay(path.states).reshape(-1, path.count).max(axis=1)
    return np.nan_to_num(decays, nan=np.inf)


def _loads(path: StatesAlongParts) -> FloatArray:
    """Offset, fx, fy, m(0), φ1 and s_c of the states, shape (parts, states, 6)."""
    states = path.states
    end = ends(states)
    columns = (end.offset, states.fx, states.fy, end.moment, end.phi1, states.s_c)
    return np.stack(columns, axis=-1).reshape(-1, path.count, 6)


def _decay_along(loads: FloatArray) -> FloatArray:
    """Size of the last Chebyshev coefficients along the parts relative to the largest."""
    sizes = np.abs(chebyshev_transform(loads.shape[1]) @ loads)
    largest = sizes.max(axis=1)
    # On a short part a column may be nearly zero: fx and m are judged by the size of the force, an
    # angle or a length by its absolute size.
    unit = np.ones(largest.shape)
    unit[:, 1:4] = largest[:, [2]]
    decay = (sizes[:, -2:].max(axis=1) / np.maximum(largest, unit)).max(axis=1)
    # NaN marks a state that was not found
    return np.nan_to_num(decay, nan=np.inf)
