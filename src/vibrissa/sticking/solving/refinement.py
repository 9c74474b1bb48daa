"""Refinement: smooth parts of paths are solved at Chebyshev points until they are resolved.

Nodes along the rod and states along the part grow until both series and the residual between the
states are below the tolerance.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.equations import coefficient_decay, ends, largest_residual
from vibrissa.mechanics.newton import solve
from vibrissa.mechanics.states import SCALARS, RodStates, transfer
from vibrissa.numerics.arrays import FloatArray, IntArray
from vibrissa.numerics.spectral import (
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

# The first number of states tells how many are needed.
STATES_ALONG_PART = (17, 25, 33, 41, 49)
NOT_RESOLVED = (
    f"residual or series decay above 1e-12 with {NODES_ALONG_ROD[-1]} nodes along the rod; "
    "try a larger eta or a theta closer to 1"
)
# How often a part is halved.
HALVINGS = 6


@dataclass(frozen=True, eq=False, kw_only=True)
class Resolved:
    """A batch of resolved parts with equally many states and nodes.

    Attributes
    ----------
    path : RodStates
        States at Chebyshev points, all parts at the first one first.
    loads : ndarray, shape (states, n, 6)
        Offset, fx, fy, m, φ1 and s_c.
    residual : ndarray, shape (n,)
        Largest residual half-way between the states.
    """

    parts: Parts
    path: RodStates
    loads: FloatArray
    residual: FloatArray

    @property
    def count(self) -> int:
        """Number of states along each part."""
        return len(self.loads)

    def at(self, position: FloatArray) -> RodStates:
        """States at fractions of the parts' length, ordered by place, then by part."""
        return along(interpolation(self.count, position), self.path)

    def take(self, rows: IntArray) -> "Resolved":
        """Select parts."""
        flat = (np.arange(self.count)[:, None] * len(self.parts) + rows).ravel()
        return Resolved(
            parts=self.parts.take(rows),
            path=self.path.take(flat),
            loads=self.loads[:, rows],
            residual=self.residual[rows],
        )


class _Task(NamedTuple):
    """Parts to be resolved, and guesses of their unknowns, shape (states, n, nodes + 3)."""

    parts: Parts
    unknowns: FloatArray
    halvings: int

    def take(self, rows: IntArray) -> "_Task":
        """Select parts."""
        return self._replace(parts=self.parts.take(rows), unknowns=self.unknowns[:, rows])

    def on_nodes(self, nodes: int) -> "_Task":
        """Interpolate states to another number of nodes along the rod."""
        before = self.unknowns.shape[2] - SCALARS
        return self._replace(unknowns=self.unknowns @ transfer(before, nodes))

    def at(self, position: FloatArray) -> "_Task":
        """Interpolate states to fractions of the parts' length."""
        matrix = interpolation(len(self.unknowns), position)
        return self._replace(unknowns=np.tensordot(matrix, self.unknowns, 1))


def along(matrix: FloatArray, path: RodStates) -> RodStates:
    """Combine the states along each part linearly, by weights of shape (places, states)."""
    places, count = matrix.shape
    unknowns = matrix @ path.unknowns.reshape(count, -1)
    each = np.tile(np.arange(len(path) // count), places)
    return replace(path.take(each), unknowns=unknowns.reshape(len(each), -1))


def resolve(parts: Parts, rods: FloatArray, guess: FloatArray) -> Iterator[Resolved]:
    """Solve parts on more and more nodes; yields those, or their halves, that could be resolved."""
    if not len(parts):
        return
    # The knots show how many nodes along the rod the states need.
    needed = _nodes_needed(
        _rod_decay(_states(parts, rods, guess), len(parts)), guess.shape[2] - SCALARS
    )
    tasks = []
    for nodes in np.unique(needed):
        rows = np.flatnonzero(needed == nodes)
        tasks.append(_Task(parts, guess, HALVINGS).take(rows).on_nodes(int(nodes)))
    while tasks:
        task = tasks.pop()
        count, nodes, number = len(task.unknowns), task.unknowns.shape[2] - SCALARS, len(task.parts)
        position = chebyshev_nodes(count)
        near = _states(task.parts, rods, task.unknowns)
        path = solve(near, task.parts.closing_at(position)).states
        loads = _loads(path, count)
        rod, decay = _rod_decay(path, number) < DECAY_TOLERANCE, _decay_along(loads)
        smooth = np.flatnonzero(rod & (decay < DECAY_TOLERANCE))
        found = Resolved(parts=task.parts, path=path, loads=loads, residual=np.full(number, np.inf))
        middle = chebyshev_nodes(2 * count - 1)[1::2]
        found.residual[smooth] = _residuals(found, smooth, middle)
        resolved = found.residual < residual_tolerance(nodes)
        if resolved.any():
            yield found.take(np.flatnonzero(resolved))
        # More states help only where the rod itself is resolved.
        fine = rod & ~resolved
        doubtful = smooth[~resolved[smooth]]
        fine[doubtful] = _residuals(found, doubtful, position) < 0.5 * residual_tolerance(nodes)
        coarse = np.flatnonzero(~fine & ~resolved)
        finer = [n for n in NODES_ALONG_ROD if n > nodes]
        solved = path.unknowns.reshape(task.unknowns.shape)
        better = np.where(np.isfinite(solved), solved, task.unknowns)
        next_task = _Task(task.parts, better, task.halvings)
        if finer and len(coarse):
            tasks.append(next_task.take(coarse).on_nodes(finer[0]))
        wanted = _states_needed(decay, count)
        for more in np.unique(wanted[fine]):
            rows = np.flatnonzero(fine & (wanted == more))
            if np.isfinite(more):
                tasks.append(next_task.take(rows).at(chebyshev_nodes(int(more))))
            elif task.halvings:
                tasks += _halves(next_task.take(rows))


def _states(parts: Parts, rods: FloatArray, unknowns: FloatArray) -> RodStates:
    """States of a path as one batch."""
    count = len(unknowns)
    return RodStates(
        rods=np.tile(rods[parts.branch], (count, 1)),
        unknowns=unknowns.reshape(-1, unknowns.shape[2]),
        line=np.tile(parts.line, count),
    )


def _halves(task: _Task) -> Iterator[_Task]:
    """Both halves of parts."""
    for share in (0.0, 0.5):
        start = task.parts.start + share * task.parts.length
        half = replace(task.parts, start=start, length=task.parts.length / 2.0)
        position = share + 0.5 * chebyshev_nodes(STATES_ALONG_PART[0])
        yield task.at(position)._replace(parts=half, halvings=task.halvings - 1)


def _nodes_needed(decay: FloatArray, nodes: int) -> IntArray:
    """Lowest number of nodes with which geometric series along the rod decay far enough."""
    with np.errstate(divide="ignore"):
        needed = nodes * np.log(DECAY_TOLERANCE) / np.log(np.minimum(decay, 0.5))
    ladder = np.array(NODES_ALONG_ROD)
    return ladder[np.searchsorted(ladder, np.minimum(needed, ladder[-1]))]


def _states_needed(decay: FloatArray, count: int) -> FloatArray:
    """How many states let geometric series decay far enough; infinite if a part is to be halved."""
    with np.errstate(divide="ignore"):
        needed = 1 + (count - 1) * np.log(0.1 * DECAY_TOLERANCE) / np.log(np.minimum(decay, 0.5))
    ladder = np.array([*(n for n in STATES_ALONG_PART if n > count), np.inf])
    return ladder[np.searchsorted(ladder, needed)]


def _rod_decay(path: RodStates, number: int) -> FloatArray:
    """Largest decay of the series along the rod of each part's states; infinite if none."""
    decays = coefficient_decay(path).reshape(-1, number).max(axis=0)
    return np.nan_to_num(decays, nan=np.inf)


def _residuals(found: Resolved, rows: IntArray, position: FloatArray) -> FloatArray:
    """Largest residuals of some parts at fractions of their length."""
    if not len(rows):
        return np.empty(0)
    some = found.take(rows)
    residual = largest_residual(some.at(position), some.parts.closing_at(position))
    # NaN marks a state that was not found
    return np.nan_to_num(residual, nan=np.inf).reshape(len(position), -1).max(axis=0)


def _loads(path: RodStates, count: int) -> FloatArray:
    """Offset, fx, fy, m, φ1 and s_c of a path, shape (states, parts, 6)."""
    end = ends(path)
    columns = (end.offset, path.fx, path.fy, end.moment, end.phi1, path.s_c)
    return np.stack(columns, axis=-1).reshape(count, -1, 6)


def _decay_along(loads: FloatArray) -> FloatArray:
    """Size of the last Chebyshev coefficients along the parts relative to the largest."""
    sizes = np.abs(np.tensordot(chebyshev_transform(len(loads)), loads, 1))
    # On a short part a column may be nearly zero: fx and m are judged by the size of the force, an
    # angle or a length by its absolute size.
    force = sizes[:, :, 2].max(axis=0)
    unit = np.ones(sizes.shape[1:])
    unit[:, 1:4] = force[:, None]
    decay = (sizes[-2:].max(axis=0) / np.maximum(sizes.max(axis=0), unit)).max(axis=1)
    # NaN marks a state that was not found
    return np.nan_to_num(decay, nan=np.inf)
