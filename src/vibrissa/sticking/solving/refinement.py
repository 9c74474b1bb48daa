"""Refinement: pieces of curves are solved at Chebyshev points until they are resolved.

A piece has one kind of contact and is counted by one parameter, x0 or the advance. The number of
nodes along the rod and of states along the piece grow independently, until the decay of both series
and the residual half-way between the states are below the tolerance. A piece that needs many states
is halved.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from vibrissa.mechanics.equations import (
    Closure,
    coefficient_decay,
    ends,
    largest_residual,
)
from vibrissa.mechanics.states import UNKNOWNS, RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray, SingleArray
from vibrissa.numerics.spectral import (
    chebyshev_nodes,
    chebyshev_transform,
    halfway_interpolation,
)
from vibrissa.sticking.piece import MARGINS, StickingState, rounded_contact
from vibrissa.sticking.solving.finishing import Resolved, finished
from vibrissa.sticking.solving.paths import (
    Pieces,
    combined,
    flat,
    interpolated,
    of_pieces,
    solve_at,
)

RESIDUAL_TOLERANCE = 1e-12
# On more nodes than these rounding alone comes near that.
MANY_NODES, ROUNDED_TOLERANCE = 100, 1e-11
# Bound on the last coefficients of both series relative to the largest.
DECAY_TOLERANCE = 1e-12
NODES_ALONG_ROD = (24, 32, 40, 52, 72, 96, 128, 170, 224, 300)
# The first number of states tells how many are needed.
STATES_ALONG_PIECE = (17, 25, 33, 41, 49)
# Every so manyth of them is solved first, to tell how many nodes are needed.
PROBE_STRIDE = 8
NOT_RESOLVED = (
    f"residual or series decay above {RESIDUAL_TOLERANCE:g} with {NODES_ALONG_ROD[-1]} nodes along "
    f"the rod; try an eta between 0.1 and 0.9999"
)
# Columns that are judged by the size of the contact force.
FORCES = ("reaction_fx", "reaction_fy", "reaction_m")
# How often a piece is halved.
HALVINGS = 6


def residual_tolerance(nodes: int) -> float:
    """Largest residual of a state that counts as solved on a number of nodes."""
    return RESIDUAL_TOLERANCE if nodes <= MANY_NODES else ROUNDED_TOLERANCE


def is_resolved(states: RodStates, eta: FloatArray, closure: Closure) -> BoolArray:
    """Whether states satisfy the equations between their nodes, and have enough of these.

    Parameters
    ----------
    states : RodStates
    eta : ndarray, shape (n,)
        Height of the contact point (L).
    closure : Closure
        The conditions that each state must satisfy.

    Returns
    -------
    ndarray of bool, shape (n,)
    """
    accurate = largest_residual(states, eta, closure) < residual_tolerance(states.nodes)
    return accurate & (coefficient_decay(states) < DECAY_TOLERANCE)


def resolve(pieces: Pieces, guess: RodStates) -> Iterator[Resolved]:
    """Solve pieces at more and more nodes and states.

    Parameters
    ----------
    pieces : Pieces
    guess : RodStates
        Path of states at Chebyshev points to start from.

    Yields
    ------
    Resolved
        Those pieces, or parts of them, that could be resolved.
    """
    # A few states tell how many nodes along the rod all of them need, and the guess where to begin.
    every = slice(None, None, PROBE_STRIDE)
    probe = guess.take(every)
    position = chebyshev_nodes(len(probe))
    begin = _nodes_needed(_rod_decay(probe), probe.nodes)
    pending = np.zeros(len(pieces), dtype=bool)
    for nodes in NODES_ALONG_ROD:
        pending |= begin == nodes
        rows = np.flatnonzero(pending)
        if not len(rows):
            continue
        few, _ = solve_at(of_pieces(probe, rows).on_nodes(nodes), pieces.take(rows), position)
        good = np.flatnonzero(_rod_decay(few) < DECAY_TOLERANCE)
        if len(good):
            start = of_pieces(guess, rows[good]).on_nodes(nodes).copy()
            start.put(every, of_pieces(few, good))
            yield from _resolve(pieces.take(rows[good]), start)
        pending[rows[good]] = False


def _nodes_needed(decay: FloatArray, nodes: int) -> IntArray:
    """Lowest number of nodes with which series along the rod are expected to decay far enough.

    The coefficients fall like a geometric series, or faster.
    """
    with np.errstate(divide="ignore"):
        needed = nodes * np.log(DECAY_TOLERANCE) / np.log(np.minimum(decay, 0.5))
    ladder = np.array(NODES_ALONG_ROD)
    return ladder[np.searchsorted(ladder, np.minimum(needed, ladder[-1]))]


def _resolve(
    pieces: Pieces,
    guess: RodStates,
    inverse: SingleArray | None = None,
    halvings: int = HALVINGS,
) -> Iterator[Resolved]:
    """Solve pieces with the nodes and states of the guess, or with more of the ones that lack.

    `inverse` corrects the states, of shape (states, pieces, k, k).
    """
    count, nodes = len(guess), guess.nodes
    path, inverse = solve_at(guess, pieces, chebyshev_nodes(count), inverse)
    states = _sticking_states(path, pieces)
    rod, decay = _rod_decay(path) < DECAY_TOLERANCE, _curve_decay(states)
    residual = np.full(len(pieces), np.inf)
    smooth = np.flatnonzero(rod & (decay < DECAY_TOLERANCE))
    between = combined(halfway_interpolation(count), of_pieces(path, smooth))
    residual[smooth] = _largest_residual(between, pieces.take(smooth), _midpoints(count))
    resolved = residual < residual_tolerance(nodes)
    yield from finished(path, pieces, states, residual, np.flatnonzero(resolved))

    # More states help only where the rod itself is resolved.
    fine, doubtful = rod & ~resolved, smooth[~resolved[smooth]]
    at_states = _largest_residual(
        of_pieces(path, doubtful), pieces.take(doubtful), chebyshev_nodes(count)
    )
    fine[doubtful] = at_states < 0.5 * residual_tolerance(nodes)
    coarse = np.flatnonzero(~fine & ~resolved)
    finer = [n for n in NODES_ALONG_ROD if n > nodes]
    if finer and len(coarse):
        better = _updated(of_pieces(guess, coarse), of_pieces(path, coarse))
        yield from _resolve(pieces.take(coarse), better.on_nodes(finer[0]), None, halvings)
    wanted = _states_needed(decay, count)
    for more in np.unique(wanted[fine]):
        rows = np.flatnonzero(fine & (wanted == more))
        known = of_pieces(path, rows), inverse[:, rows]
        if np.isfinite(more):
            better_guess = interpolated(count, chebyshev_nodes(int(more)), *known)
            yield from _resolve(pieces.take(rows), *better_guess, halvings)
        elif halvings:
            for share, half in _halves(pieces.take(rows)):
                position = share + 0.5 * chebyshev_nodes(STATES_ALONG_PIECE[0])
                yield from _resolve(half, *interpolated(count, position, *known), halvings - 1)


def _halves(pieces: Pieces) -> Iterator[tuple[float, Pieces]]:
    """Both halves of pieces, each with the share of the length at which it begins."""
    for share in (0.0, 0.5):
        start = pieces.start + share * pieces.length
        yield share, replace(pieces, start=start, length=pieces.length / 2.0)


def _states_needed(decay: FloatArray, count: int) -> FloatArray:
    """As many states as let the series decay far enough; infinite if a piece is to be halved.

    The coefficients fall like a geometric series.
    """
    with np.errstate(divide="ignore"):
        needed = 1 + (count - 1) * np.log(0.1 * DECAY_TOLERANCE) / np.log(np.minimum(decay, 0.5))
    ladder = np.array([*(n for n in STATES_ALONG_PIECE if n > count), np.inf])
    return ladder[np.searchsorted(ladder, needed)]


def _updated(path: RodStates, other: RodStates) -> RodStates:
    """Take the states of another path where it has found them."""
    old, new = path.columns, other.columns
    better: dict[str, Any] = {n: np.where(np.isfinite(new[n]), new[n], old[n]) for n in UNKNOWNS}
    return replace(path, **better)


def _midpoints(count: int) -> FloatArray:
    """Points half-way between `count` Chebyshev points."""
    return chebyshev_nodes(2 * count - 1)[1::2]


def _rod_decay(path: RodStates) -> FloatArray:
    """Largest decay of the series along the rod of each piece's states; infinite if none."""
    decays = coefficient_decay(flat(path)).reshape(path.fx.shape).max(axis=0)
    return np.nan_to_num(decays, nan=np.inf)


def _largest_residual(path: RodStates, pieces: Pieces, position: FloatArray) -> FloatArray:
    """Largest residual of each piece's states at fractions of its length."""
    if not len(pieces):
        return np.empty(0)
    count = len(position)
    height = np.tile(pieces.height, count)
    residual = largest_residual(flat(path), height, pieces.closure_at(position))
    # NaN marks a state that was not found
    return np.nan_to_num(residual, nan=np.inf).reshape(count, -1).max(axis=0)


def _sticking_states(path: RodStates, pieces: Pieces) -> StickingState:
    """Evaluate a path, columns of shape (states, pieces), but for the stability."""
    offset, moment, phi1 = (values.reshape(path.fx.shape) for values in ends(flat(path)))
    return StickingState(
        x0=pieces.displacement(offset),
        reaction_fx=path.fx,
        reaction_fy=path.fy,
        reaction_m=moment,
        phi1=phi1,
        s_c=rounded_contact(path.s_c),
        stability=np.full(path.fx.shape, np.nan),
        stability_aside=np.full(path.fx.shape, np.nan),
    )


def _curve_decay(states: StickingState) -> FloatArray:
    """Size of the last Chebyshev coefficients along the pieces relative to the largest."""
    transform = chebyshev_transform(len(states))
    known = [name for name in StickingState.names() if name not in MARGINS]
    coefficients = {name: np.abs(transform @ getattr(states, name)) for name in known}
    force = coefficients["reaction_fy"].max(axis=0)
    decay = np.zeros(force.shape)
    for name, sizes in coefficients.items():
        # On a short piece a column may be nearly zero: fx and m are judged by the size of the
        # force, an angle or a length by its absolute size.
        unit = force if name in FORCES else np.ones_like(force)
        decay = np.maximum(decay, sizes[-2:].max(axis=0) / np.maximum(sizes.max(axis=0), unit))
    # NaN marks a state that was not found
    return np.nan_to_num(decay, nan=np.inf)
