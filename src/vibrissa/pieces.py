"""Resolving smooth pieces of curves: states at Chebyshev points, refined until they are resolved.

A piece has one kind of contact and is counted by one parameter, x0 or the advance. The number of
nodes along the rod and of states along the piece grow independently, until the decay of both series
and the residual half-way between the states are below the tolerance; a piece that needs many states
is halved.
"""

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import NamedTuple, Self

import numpy as np

from vibrissa.arrays import BoolArray, FloatArray, Index, IntArray, SingleArray
from vibrissa.branch import Leg, closure_at
from vibrissa.equilibrium import (
    Closure,
    ContactStates,
    coefficient_decay,
    readings,
    residual,
    solve,
    stability,
)
from vibrissa.reach import violations
from vibrissa.spectral import (
    chebyshev_nodes,
    chebyshev_transform,
    halfway_interpolation,
    interpolation,
)
from vibrissa.status import Contact, Parameter

RESIDUAL_TOLERANCE = 1e-12
# On more nodes than these rounding alone comes near that.
MANY_NODES, ROUNDED_TOLERANCE = 100, 1e-11
# Bound on the last coefficients of both series relative to the largest.
DECAY_TOLERANCE = 1e-12
NODES_ALONG_ROD = (24, 32, 40, 52, 72, 96, 128, 170, 224, 300)
# The first number of states tells how many are needed.
STATES_ALONG_PIECE = (17, 25, 33, 41, 49)
# Nodes are tried from this part of the number on that seems to be needed.
CAUTION = 0.85
# Every so manyth of them is solved first, to tell how many nodes are needed.
PROBE_STRIDE = 8
# Accuracy with which the end of the model's reach is located, relative to a piece.
REACH_TOLERANCE = 1e-11
# How often a piece is halved.
HALVINGS = 6
# The margin of stability is smooth and costs more than a state, and a shape that has left the
# model's reach stays outside for long: fewer states tell both.
STATES_LOOKED_AT = 17
# Part of the nodes that tells the margin as well as these states do, and the fewest.
STABILITY_NODES = 0.45
FEWEST_STABILITY_NODES = 16


@dataclass(frozen=True, eq=False)
class Pieces:
    """Smooth pieces of a batch of curves, all with the same kind of contact and parameter.

    Attributes
    ----------
    contact : Contact
    parameter : Parameter
    curve : ndarray of int, shape (n,)
        Which curve of the batch a piece belongs to.
    theta, eta, x1_init, force : ndarray, shape (n,)
        Of that curve; see `vibrissa.branch.Leg`.
    start, length : ndarray, shape (n,)
        First value of the parameter and how far the piece goes (x0 in L).
    """

    contact: Contact
    parameter: Parameter
    curve: IntArray
    theta: FloatArray
    eta: FloatArray
    x1_init: FloatArray
    force: FloatArray
    start: FloatArray
    length: FloatArray

    def __len__(self) -> int:
        """Return the number of pieces."""
        return len(self.curve)

    def take(self, index: Index) -> Self:
        """Select pieces."""
        columns = (getattr(self, f.name)[index] for f in fields(self)[2:])
        return type(self)(self.contact, self.parameter, *columns)

    def value(self, position: FloatArray) -> FloatArray:
        """Parameter at fractions of the pieces' length, shape (positions, n)."""
        return self.start + position[:, None] * self.length

    def closure(self, position: FloatArray) -> Closure:
        """Conditions at fractions of the pieces' length, as one batch."""
        value = self.value(position)
        x1_init, force = (np.tile(a, len(position)) for a in (self.x1_init, self.force))
        return closure_at(self.parameter, self.contact, value.ravel(), x1_init, force)


@dataclass(frozen=True, eq=False)
class Path:
    """States along a batch of pieces: the first axis counts states, the second pieces."""

    theta: FloatArray
    phi: FloatArray
    fx: FloatArray
    fy: FloatArray
    s_c: FloatArray

    @classmethod
    def stacked(cls, states: list[ContactStates]) -> Self:
        """Path through batches that each hold one state of every piece."""
        names = ("phi", "fx", "fy", "s_c")
        return cls(states[0].theta, *(np.stack([getattr(s, n) for s in states]) for n in names))

    @property
    def _columns(self) -> tuple[FloatArray, ...]:
        return self.phi, self.fx, self.fy, self.s_c

    def flat(self) -> ContactStates:
        """All states of all pieces as one batch."""
        count = len(self.fx)
        return ContactStates(
            np.tile(self.theta, count),
            self.phi.reshape(-1, self.phi.shape[-1]),
            self.fx.ravel(),
            self.fy.ravel(),
            self.s_c.ravel(),
        )

    @classmethod
    def unflattened(cls, states: ContactStates, count: int) -> Self:
        """Inverse of `flat` for `count` states along each piece."""
        pieces = len(states) // count
        return cls(
            states.theta[:pieces],
            states.phi.reshape(count, pieces, -1),
            states.fx.reshape(count, pieces),
            states.fy.reshape(count, pieces),
            states.s_c.reshape(count, pieces),
        )

    def take(self, index: Index) -> Self:
        """Select pieces."""
        return type(self)(self.theta[index], *(values[:, index] for values in self._columns))

    def updated(self, other: Self) -> Self:
        """Take the states of another path where it has found them."""
        both = zip(self._columns, other._columns, strict=True)
        return type(self)(self.theta, *(np.where(np.isfinite(b), b, a) for a, b in both))

    def overwritten(self, other: Self, index: BoolArray | slice) -> Self:
        """Put the states of another path in the place of some."""
        columns = [values.copy() for values in self._columns]
        for values, new in zip(columns, other._columns, strict=True):
            values[index] = new
        return type(self)(self.theta, *columns)

    def states(self, index: BoolArray | slice) -> Self:
        """Select states of all pieces."""
        return type(self)(self.theta, *(values[index] for values in self._columns))

    def on_nodes(self, nodes: int) -> Self:
        """Interpolate the slopes to another number of nodes along the rod."""
        return self.unflattened(self.flat().on_nodes(nodes), len(self.fx))

    def combined(self, matrix: FloatArray) -> Self:
        """Linear combinations of the states; `matrix` is (new, old) or (pieces, new, old)."""
        if matrix.ndim == 2:
            matrix = np.broadcast_to(matrix, (len(self.theta), *matrix.shape))
        return type(self)(
            self.theta,
            np.einsum("cab,bcn->acn", matrix, self.phi, optimize=True),
            *(np.einsum("cab,bc->ac", matrix, v) for v in self._columns[1:]),
        )


class Resolved(NamedTuple):
    """A resolved piece.

    Attributes
    ----------
    curve : int
        Which curve of the batch it belongs to.
    contact : Contact
    parameter : Parameter
    start, stop : float
        Range of the parameter (x0 in L).
    values : ndarray, shape (k, 7)
        x0, fx, fy, m, φ1, s_c and the margin of stability at Chebyshev points of the range.
    residual : float
        Largest residual half-way between the states.
    reach : float
        First value of the parameter at which the shape leaves the model's reach; NaN if nowhere.
    violated : ndarray of bool, shape (3,)
        How it does so, in the order of `vibrissa.reach.REASONS`.
    """

    curve: int
    contact: Contact
    parameter: Parameter
    start: float
    stop: float
    values: FloatArray
    residual: float
    reach: float
    violated: BoolArray


def residual_tolerance(nodes: int) -> float:
    """Largest residual of a state that counts as solved on a number of nodes."""
    return RESIDUAL_TOLERANCE if nodes <= MANY_NODES else ROUNDED_TOLERANCE


def guess_from(leg: Leg, pieces: Pieces) -> Path:
    """Guess states at Chebyshev points by quadratics through the three nearest steps of a leg."""
    position = chebyshev_nodes(STATES_ALONG_PIECE[0])
    march = Path.stacked(leg.steps).take(pieces.curve)
    origin, step = leg.origin[pieces.curve], leg.step[pieces.curve]
    place = ((pieces.value(position) - origin) / step).T
    last = leg.last[pieces.curve]
    first = np.clip(np.round(place).astype(int) - 1, 0, last[:, None] - 2)
    t = place - first
    weights = np.stack([0.5 * (t - 1) * (t - 2), -t * (t - 2), 0.5 * t * (t - 1)], axis=-1)
    matrix = np.zeros((*place.shape, len(march.fx)))
    np.put_along_axis(matrix, first[..., None] + np.arange(3), weights, axis=-1)
    # NaN times a weight of zero would spoil the sums
    columns = (march.phi, march.fx, march.fy, march.s_c)
    return Path(march.theta, *(np.nan_to_num(a) for a in columns)).combined(matrix)


def resolve(pieces: Pieces, guess: Path) -> Iterator[Resolved]:
    """Solve pieces at more and more nodes and states.

    Parameters
    ----------
    pieces : Pieces
    guess : Path
        States at Chebyshev points to start from.

    Yields
    ------
    Resolved
        Those pieces, or parts of them, that could be resolved.
    """
    # A few states tell how many nodes along the rod all of them need, and the guess where to begin.
    every = slice(None, None, PROBE_STRIDE)
    probe = guess.states(every)
    position = chebyshev_nodes(len(probe.fx))
    begin = _nodes_needed(_rod_decay(probe), probe.phi.shape[2])
    pending = np.zeros(len(pieces), dtype=bool)
    for nodes in NODES_ALONG_ROD:
        pending |= begin == nodes
        rows = np.flatnonzero(pending)
        if not len(rows):
            continue
        few, _ = _solve_at(probe.take(rows).on_nodes(nodes), pieces.take(rows), position)
        good = _rod_decay(few) < DECAY_TOLERANCE
        if good.any():
            start = guess.take(rows[good]).on_nodes(nodes).overwritten(few.take(good), every)
            yield from _resolve(pieces.take(rows[good]), start)
        pending[rows[good]] = False


def _nodes_needed(decay: FloatArray, nodes: int) -> IntArray:
    """Lowest number of nodes with which series along the rod might decay far enough.

    The coefficients fall like a geometric series, or faster.
    """
    with np.errstate(divide="ignore"):
        needed = nodes * np.log(DECAY_TOLERANCE) / np.log(np.minimum(decay, 0.5))
    ladder = np.array(NODES_ALONG_ROD)
    return ladder[np.searchsorted(ladder, np.minimum(CAUTION * needed, ladder[-1]))]


def _resolve(
    pieces: Pieces,
    guess: Path,
    inverse: SingleArray | None = None,
    halvings: int = HALVINGS,
) -> Iterator[Resolved]:
    """Solve pieces with the nodes and states of the guess, or with more of the ones that lack.

    `inverse` corrects the states, of shape (states, pieces, k, k).
    """
    count, nodes = guess.phi.shape[0], guess.phi.shape[2]
    path, inverse = _solve_at(guess, pieces, chebyshev_nodes(count), inverse)
    values = _values(path, pieces)
    rod, decay = _rod_decay(path) < DECAY_TOLERANCE, _curve_decay(values)
    misfit = np.full(len(pieces), np.inf)
    smooth = np.flatnonzero(rod & (decay < DECAY_TOLERANCE))
    between = path.take(smooth).combined(halfway_interpolation(count))
    misfit[smooth] = _largest_residual(between, pieces.take(smooth), _midpoints(count))
    resolved = misfit < residual_tolerance(nodes)
    yield from _finished(path, pieces, values, misfit, np.flatnonzero(resolved))

    # More states help only where the rod itself is resolved.
    fine, doubtful = rod & ~resolved, smooth[~resolved[smooth]]
    at_states = _largest_residual(
        path.take(doubtful), pieces.take(doubtful), chebyshev_nodes(count)
    )
    fine[doubtful] = at_states < 0.5 * residual_tolerance(nodes)
    coarse = np.flatnonzero(~fine & ~resolved)
    finer = [n for n in NODES_ALONG_ROD if n > nodes]
    if finer and len(coarse):
        better = guess.take(coarse).updated(path.take(coarse)).on_nodes(finer[0])
        yield from _resolve(pieces.take(coarse), better, None, halvings)
    wanted = _states_needed(decay, count)
    for more in np.unique(wanted[fine]):
        rows = np.flatnonzero(fine & (wanted == more))
        some, parts = path.take(rows), pieces.take(rows)
        if more <= STATES_ALONG_PIECE[-1]:
            matrix = interpolation(count, chebyshev_nodes(more))
            yield from _resolve(
                parts, some.combined(matrix), _combined(matrix, inverse[:, rows]), halvings
            )
        elif halvings:
            half = replace(parts, length=parts.length / 2.0)
            for share in (0.0, 0.5):
                part = replace(half, start=parts.start + share * parts.length)
                position = share + 0.5 * chebyshev_nodes(STATES_ALONG_PIECE[0])
                matrix = interpolation(count, position)
                yield from _resolve(
                    part, some.combined(matrix), _combined(matrix, inverse[:, rows]), halvings - 1
                )


def _states_needed(decay: FloatArray, count: int) -> IntArray:
    """As many states as let the series decay far enough; more than allowed if to be halved.

    The coefficients fall like a geometric series.
    """
    with np.errstate(divide="ignore"):
        needed = 1 + (count - 1) * np.log(0.1 * DECAY_TOLERANCE) / np.log(np.minimum(decay, 0.5))
    ladder = np.array([n for n in STATES_ALONG_PIECE if n > count] + [2 * STATES_ALONG_PIECE[-1]])
    return ladder[np.minimum(np.searchsorted(ladder, needed), len(ladder) - 1)]


def _combined(matrix: FloatArray, inverse: SingleArray) -> SingleArray:
    """Linear combinations of matrices given at the states."""
    flat = inverse.reshape(len(inverse), -1)
    return (matrix.astype(np.float32) @ flat).reshape(-1, *inverse.shape[1:])


def _solve_at(
    guess: Path, pieces: Pieces, position: FloatArray, inverse: SingleArray | None = None
) -> tuple[Path, SingleArray]:
    """Solve states at fractions of the pieces' length; see `vibrissa.equilibrium.solve`."""
    count = len(position)
    known = None if inverse is None else inverse.reshape(-1, *inverse.shape[2:])
    eta = np.tile(pieces.eta, count)
    states, _, used = solve(guess.flat(), eta, pieces.closure(position), known)
    return Path.unflattened(states, count), used.reshape(count, len(pieces), *used.shape[1:])


def _midpoints(count: int) -> FloatArray:
    """Points half-way between `count` Chebyshev points."""
    return chebyshev_nodes(2 * count - 1)[1::2]


def _rod_decay(path: Path) -> FloatArray:
    """Largest decay of the series along the rod of each piece's states; infinite if none."""
    decays = coefficient_decay(path.flat()).reshape(path.fx.shape).max(axis=0)
    return np.nan_to_num(decays, nan=np.inf)


def _largest_residual(path: Path, pieces: Pieces, position: FloatArray) -> FloatArray:
    """Largest residual of each piece's states at fractions of its length."""
    count = len(position)
    misfit = residual(path.flat(), np.tile(pieces.eta, count), pieces.closure(position))
    # NaN marks a state that was not found
    return np.nan_to_num(misfit, nan=np.inf).reshape(count, -1).max(axis=0)


def _values(path: Path, pieces: Pieces) -> FloatArray:
    """x0, fx, fy, m, φ1 and s_c at the states, shape (states, pieces, 6)."""
    states = path.flat()
    offset, moment, phi1 = readings(states)
    x0 = np.tile(pieces.x1_init, len(path.fx)) - offset
    values = [x0, states.fx, states.fy, moment, phi1, states.s_c]
    return np.stack(values, axis=-1).reshape(*path.fx.shape, 6)


def _curve_decay(values: FloatArray) -> FloatArray:
    """Size of the last Chebyshev coefficients along the pieces relative to the largest."""
    transform = chebyshev_transform(len(values))
    coefficients = np.abs(np.einsum("ab,bcv->acv", transform, values))
    # On a short piece a column may be nearly zero: fx and m are judged by the size of the force,
    # an angle or a length by its absolute size.
    largest = coefficients.max(axis=0)
    force, unit = largest[:, [2]], np.ones((len(largest), 1))
    scale = np.maximum(largest, np.hstack([unit, force, force, force, unit, unit]))
    # NaN marks a state that was not found
    return np.nan_to_num((coefficients[-2:].max(axis=0) / scale).max(axis=-1), nan=np.inf)


def _finished(
    path: Path, pieces: Pieces, values: FloatArray, misfit: FloatArray, rows: IntArray
) -> Iterator[Resolved]:
    """Add to resolved pieces their stability and where they leave the model's reach."""
    if not len(rows):
        return
    path, pieces, values = path.take(rows), pieces.take(rows), values[:, rows]
    count = len(path.fx)
    few = path.combined(interpolation(count, chebyshev_nodes(STATES_LOOKED_AT)))
    nodes = max(FEWEST_STABILITY_NODES, round(STABILITY_NODES * path.phi.shape[2]))
    margin = stability(few.on_nodes(nodes).flat(), pieces.contact)
    to_states = interpolation(STATES_LOOKED_AT, chebyshev_nodes(count))
    margin = to_states @ margin.reshape(STATES_LOOKED_AT, -1)
    values = np.concatenate([values, margin[..., None]], axis=-1)
    if pieces.parameter is Parameter.X0:
        values[..., 0] = pieces.value(chebyshev_nodes(count))
    seen = violations(few.flat(), np.tile(pieces.eta, STATES_LOOKED_AT), pieces.contact)
    leaves = seen.any(axis=1).reshape(STATES_LOOKED_AT, -1)
    for row in range(len(pieces)):
        start, length = float(pieces.start[row]), float(pieces.length[row])
        reach, violated = np.nan, np.zeros(seen.shape[1], dtype=bool)
        if leaves[:, row].any():
            part, violated = _reach_limit(
                path.take(np.array([row])), float(pieces.eta[row]), pieces.contact, leaves[:, row]
            )
            reach = start + part * length
        yield Resolved(
            int(pieces.curve[row]),
            pieces.contact,
            pieces.parameter,
            start,
            start + length,
            values[:, row],
            float(misfit[rows[row]]),
            reach,
            violated,
        )


def _reach_limit(
    path: Path, eta: float, contact: Contact, leaves: BoolArray
) -> tuple[float, BoolArray]:
    """First fraction of a piece at which its shape leaves the model's reach, by bisection."""
    position = chebyshev_nodes(STATES_LOOKED_AT)
    first = int(np.argmax(leaves))
    low, high = position[max(first - 1, 0)], position[first]

    def look(at: float) -> BoolArray:
        states = path.combined(interpolation(len(path.fx), np.array([at]))).flat()
        return violations(states, np.array([eta]), contact)[0]

    while high - low > REACH_TOLERANCE:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if look(middle).any() else (middle, high)
    return float(high), look(float(high))
