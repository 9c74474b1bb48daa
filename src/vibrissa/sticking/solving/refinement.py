"""Refinement: pieces of curves are solved at Chebyshev points until they are resolved.

A piece has one kind of contact and is counted by one parameter, x0 or the advance. The number of
nodes along the rod and of states along the piece grow independently, until the decay of both series
and the residual half-way between the states are below the tolerance. A piece that needs many states
is halved.

A *path* is a batch of states with two leading axes: the first counts states along the pieces, the
second pieces.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from vibrissa.mechanics.admissibility import TOLERANCE, Clearance, clearances
from vibrissa.mechanics.aside import stability_aside
from vibrissa.mechanics.equations import (
    Closure,
    coefficient_decay,
    contact_position,
    ends,
    largest_residual,
)
from vibrissa.mechanics.newton import solve
from vibrissa.mechanics.stability import stability
from vibrissa.mechanics.states import UNKNOWNS, RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray, SingleArray
from vibrissa.numerics.spectral import (
    chebyshev_nodes,
    chebyshev_transform,
    halfway_interpolation,
    interpolation,
    step_weights,
)
from vibrissa.outcomes import Contact, Parameter, RodSection
from vibrissa.sticking.assembly import Limit
from vibrissa.sticking.piece import MARGINS, Piece, StickingState
from vibrissa.sticking.solving.segments import Branches, Segment

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
# Accuracy with which the end of the admissible shapes is located, relative to a piece.
LIMIT_TOLERANCE = 1e-11
# A piece with less clearance than this (L) is looked at closely, at so many states in each interval
# in which a place is sought.
CLOSE, ZOOM = 0.1, 17
# Steps of a branch through which a polynomial is laid to guess a state.
NEAREST_STEPS = 6
NOT_RESOLVED = (
    f"residual or series decay above {RESIDUAL_TOLERANCE:g} with {NODES_ALONG_ROD[-1]} nodes along "
    f"the rod; try an eta between 0.3 and 0.9999 and a theta up to 20"
)
# Columns that are judged by the size of the contact force.
FORCES = ("reaction_fx", "reaction_fy", "reaction_m")
# How often a piece is halved.
HALVINGS = 6
# The margin of stability is smooth and costs more than a state, and a shape that is inadmissible
# stays so for long: fewer states tell both.
STATES_LOOKED_AT = 17
# Part of the nodes that tells the margins as well as these states do, and the fewest for each.
STABILITY_NODES = 0.45
FEWEST_STABILITY_NODES, FEWEST_NODES_ASIDE = 16, 12
# Parts of a piece between whose ends the margin is taken as linear, to find where it vanishes.
SWING_WIDTHS = (1e-4, 1e-7)


@dataclass(frozen=True, eq=False, kw_only=True)
class Pieces(Branches):
    """Smooth pieces of a batch of branches, all with the same kind of contact and parameter.

    Attributes
    ----------
    contact : Contact
    parameter : Parameter
    curve : ndarray of int, shape (n,)
        Which curve of the batch a piece belongs to.
    start, length : ndarray, shape (n,)
        First value of the parameter and how far the piece goes (x0 in L).
    section : RodSection
        A round rod has a margin out of the plane, too.
    """

    contact: Contact
    parameter: Parameter
    curve: IntArray
    start: FloatArray
    length: FloatArray
    section: RodSection = RodSection.PLANAR

    def value(self, position: FloatArray) -> FloatArray:
        """Parameter at fractions of the pieces' length, shape (positions, n)."""
        return self.start + position[:, None] * self.length

    def repeated(self, count: int) -> "Pieces":
        """All pieces, again and again."""
        return self.take(np.tile(np.arange(len(self)), count))

    def closure_at(self, position: FloatArray) -> Closure:
        """Conditions at fractions of the pieces' length, as one batch."""
        branches = self.repeated(len(position))
        return branches.closure(self.parameter, self.contact, self.value(position).ravel())


class Resolved(NamedTuple):
    """A resolved piece.

    Attributes
    ----------
    curve : int
        Which curve of the batch it belongs to.
    piece : Piece
    residual : float
        Largest residual half-way between the states.
    limit : Limit
        How far its shapes are admissible.
    swing : float
        Where on it a round rod leaves its plane; NaN where it does not. In the ideal mounting that
        follows from where the contact point is, and is not sought.
    """

    curve: int
    piece: Piece
    residual: float
    limit: Limit
    swing: float


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


def guess_from(segment: Segment, pieces: Pieces) -> RodStates:
    """Guess states at Chebyshev points by polynomials through the nearest steps."""
    position = chebyshev_nodes(STATES_ALONG_PIECE[0])
    march = _of_pieces(RodStates.stack(segment.steps), pieces.curve)
    origin, step = segment.origin[pieces.curve], segment.step[pieces.curve]
    place = ((pieces.value(position) - origin) / step).T
    known = np.minimum(segment.last[pieces.curve] + 1, NEAREST_STEPS)
    room = segment.last[pieces.curve] + 1 - known
    first = np.round(place - 0.5 * (known - 1)[:, None]).astype(int)
    first = np.clip(first, 0, room[:, None])
    weights = step_weights(place - first, known, NEAREST_STEPS)
    matrix = np.zeros((*place.shape, len(march) + NEAREST_STEPS))
    nearest = first[..., None] + np.arange(NEAREST_STEPS)
    np.put_along_axis(matrix, nearest, weights, axis=-1)
    # NaN times a weight of zero would spoil the sums
    return combined(matrix[..., : len(march)], march.each(np.nan_to_num))


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
        few, _ = solve_at(_of_pieces(probe, rows).on_nodes(nodes), pieces.take(rows), position)
        good = np.flatnonzero(_rod_decay(few) < DECAY_TOLERANCE)
        if len(good):
            start = _of_pieces(guess, rows[good]).on_nodes(nodes).copy()
            start.put(every, _of_pieces(few, good))
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
    between = combined(halfway_interpolation(count), _of_pieces(path, smooth))
    residual[smooth] = _largest_residual(between, pieces.take(smooth), _midpoints(count))
    resolved = residual < residual_tolerance(nodes)
    yield from _finished(path, pieces, states, residual, np.flatnonzero(resolved))

    # More states help only where the rod itself is resolved.
    fine, doubtful = rod & ~resolved, smooth[~resolved[smooth]]
    at_states = _largest_residual(
        _of_pieces(path, doubtful), pieces.take(doubtful), chebyshev_nodes(count)
    )
    fine[doubtful] = at_states < 0.5 * residual_tolerance(nodes)
    coarse = np.flatnonzero(~fine & ~resolved)
    finer = [n for n in NODES_ALONG_ROD if n > nodes]
    if finer and len(coarse):
        better = _updated(_of_pieces(guess, coarse), _of_pieces(path, coarse))
        yield from _resolve(pieces.take(coarse), better.on_nodes(finer[0]), None, halvings)
    wanted = _states_needed(decay, count)
    for more in np.unique(wanted[fine]):
        rows = np.flatnonzero(fine & (wanted == more))
        known = _of_pieces(path, rows), inverse[:, rows]
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


def interpolated(
    count: int, position: FloatArray, path: RodStates, inverse: SingleArray
) -> tuple[RodStates, SingleArray]:
    """Interpolate states, and what corrects them, from Chebyshev points to other places.

    Parameters
    ----------
    count : int
        Number of Chebyshev points.
    position : ndarray, shape (places,)
        Fractions of the pieces' length.
    path : RodStates
        With `count` states along each piece.
    inverse : ndarray, shape (count, pieces, k, k)
        What corrects them.

    Returns
    -------
    path : RodStates
    inverse : ndarray, shape (places, pieces, k, k)
    """
    matrix = interpolation(count, position)
    flat = matrix.astype(np.float32) @ inverse.reshape(len(inverse), -1)
    return combined(matrix, path), flat.reshape(-1, *inverse.shape[1:])


def _states_needed(decay: FloatArray, count: int) -> FloatArray:
    """As many states as let the series decay far enough; infinite if a piece is to be halved.

    The coefficients fall like a geometric series.
    """
    with np.errstate(divide="ignore"):
        needed = 1 + (count - 1) * np.log(0.1 * DECAY_TOLERANCE) / np.log(np.minimum(decay, 0.5))
    ladder = np.array([*(n for n in STATES_ALONG_PIECE if n > count), np.inf])
    return ladder[np.searchsorted(ladder, needed)]


def _of_pieces(path: RodStates, rows: IntArray) -> RodStates:
    """Part of a path that belongs to some pieces."""
    return path.take((slice(None), rows))


def _updated(path: RodStates, other: RodStates) -> RodStates:
    """Take the states of another path where it has found them."""
    old, new = path.columns, other.columns
    better: dict[str, Any] = {n: np.where(np.isfinite(new[n]), new[n], old[n]) for n in UNKNOWNS}
    return replace(path, **better)


def flat(path: RodStates) -> RodStates:
    """All states of a path as one batch."""
    return path.each(lambda values: values.reshape(-1, *values.shape[2:]))


def folded(states: RodStates, count: int) -> RodStates:
    """Inverse of `flat` for `count` states along each piece."""
    return states.each(lambda values: values.reshape(count, -1, *values.shape[1:]))


def combined(matrix: FloatArray, path: RodStates) -> RodStates:
    """Combine the states along each piece linearly.

    Parameters
    ----------
    matrix : ndarray, shape (new, old) or (pieces, new, old)
        Weights, which add up to 1; of all pieces, or of each.
    path : RodStates
        With `old` states along each piece.

    Returns
    -------
    RodStates
    """

    def along(values: FloatArray) -> FloatArray:
        if matrix.ndim == 2:
            return np.tensordot(matrix, values, 1)
        return np.einsum("cab,bc...->ac...", matrix, values, optimize=True)

    def same(values: FloatArray) -> FloatArray:
        return np.broadcast_to(values[0], (matrix.shape[-2], *values.shape[1:])).copy()

    # A sum with weights is the same theta up to rounding alone.
    mounting = None if path.mounting is None else path.mounting.each(same)
    return replace(path.each(along), theta=same(path.theta), mounting=mounting)


def solve_at(
    guess: RodStates, pieces: Pieces, position: FloatArray, inverse: SingleArray | None = None
) -> tuple[RodStates, SingleArray]:
    """Solve states at fractions of the pieces' length, all together.

    Parameters
    ----------
    guess : RodStates
        Path with a state at each place.
    pieces : Pieces
    position : ndarray, shape (places,)
        The fractions.
    inverse : ndarray, shape (places, pieces, k, k), optional
        What corrects the states (`coarse_inverse`), where it is known.

    Returns
    -------
    path : RodStates
        NaN where a state was not found.
    inverse : ndarray, shape (places, pieces, k, k)
    """
    count = len(position)
    known = None if inverse is None else inverse.reshape(-1, *inverse.shape[2:])
    height = np.tile(pieces.height, count)
    states, _, used = solve(flat(guess), height, pieces.closure_at(position), known)
    return folded(states, count), used.reshape(count, len(pieces), *used.shape[1:])


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
        # Where the contact changes its kind, 1 up to rounding.
        s_c=np.where(path.s_c > 1.0 + ROUNDED_TOLERANCE, path.s_c, np.minimum(path.s_c, 1.0)),
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


def _finished(
    path: RodStates, pieces: Pieces, states: StickingState, residual: FloatArray, rows: IntArray
) -> Iterator[Resolved]:
    """Add to resolved pieces their stability and how far their shapes are admissible."""
    if not len(rows):
        return
    path, pieces = _of_pieces(path, rows), pieces.take(rows)
    count, position = len(path), chebyshev_nodes(STATES_LOOKED_AT)
    few = combined(interpolation(count, position), path)
    margins = _margins(few, pieces)
    to_states = interpolation(STATES_LOOKED_AT, chebyshev_nodes(count))
    states = replace(
        states.take((slice(None), rows)),
        **{name: to_states @ values for name, values in margins.items()},
    )
    if pieces.parameter is Parameter.X0:
        states = replace(states, x0=pieces.value(chebyshev_nodes(count)))
    looked = _clearances(few, pieces.contact).each(
        lambda values: values.reshape(STATES_LOOKED_AT, -1)
    )
    nearest = looked.smallest
    for row in range(len(pieces)):
        start, length = float(pieces.start[row]), float(pieces.length[row])
        limit = Limit()
        if nearest[:, row].min() < CLOSE:
            only = np.array([row])
            share, how = _limit(
                _of_pieces(path, only), looked.take((slice(None), row)), pieces.take(only)
            )
            limit = Limit(start + share * length, how)
        piece = Piece(
            contact=pieces.contact,
            parameter=pieces.parameter,
            start=start,
            stop=start + length,
            states=states.take((slice(None), row)).copy(),
        )
        swing = np.nan
        if pieces.section is RodSection.ROUND and (
            path.mounting is not None or pieces.stage_angle is not None
        ):
            swing = _swing(_of_pieces(path, np.array([row])), piece)
        yield Resolved(int(pieces.curve[row]), piece, float(residual[rows[row]]), limit, swing)


def _margins(path: RodStates, pieces: Pieces) -> dict[str, FloatArray]:
    """Margins of stability of the states of a path, each of shape (states, pieces)."""
    nodes = round(STABILITY_NODES * path.nodes)
    states = flat(path.on_nodes(max(nodes, FEWEST_STABILITY_NODES)))
    margins = {"stability": stability(states, pieces.contact)}
    if pieces.section is RodSection.ROUND:
        fewer = flat(path.on_nodes(max(nodes, FEWEST_NODES_ASIDE)))
        margins["stability_aside"] = stability_aside(fewer)
    return {name: values.reshape(path.fx.shape) for name, values in margins.items()}


def _swing(path: RodStates, piece: Piece) -> float:
    """Where a rod leaves its plane, as a value of the piece's parameter; NaN if nowhere.

    The margin of a few states on few nodes tells the place, and exact ones next to it the digits.
    """
    sampled, only = -piece.alone.samples.stability_aside, np.zeros(1, dtype=np.int64)
    at = float(piece.alone.first(only, sampled, np.zeros(1), _margin_aside)[0])
    if np.isnan(at) or sampled[0, 0] >= 0.0:
        return at
    length = piece.stop - piece.start
    for width in SWING_WIDTHS:
        places = at + width * length * np.array([-1.0, 1.0])
        matrix = interpolation(len(path), (places - piece.start) / length)
        before, after = stability_aside(flat(combined(matrix, path)))
        at = float(places[0] + before / (before - after) * (places[1] - places[0]))
    return at


def _margin_aside(level: FloatArray) -> Mapping[str, float]:
    return {"stability_aside": 1.0}


def _clearances(path: RodStates, contact: Contact) -> Clearance:
    """Clearances of the states of a path, as one batch."""
    states = flat(path)
    return clearances(states, contact_position(states)[1], contact)


def _limit(path: RodStates, looked: Clearance, piece: Pieces) -> tuple[float, str]:
    """First fraction of a piece at which its shape is inadmissible, and how; NaN if nowhere.

    The clearances are known at `STATES_LOOKED_AT` Chebyshev points; the place is sought between.
    """

    def look(at: FloatArray) -> Clearance:
        return _clearances(combined(interpolation(len(path), at), path), piece.contact)

    def clearance(name: str) -> Callable[[FloatArray], FloatArray]:
        return lambda at: look(at).columns[name]

    at = chebyshev_nodes(STATES_LOOKED_AT)
    for k in range(STATES_LOOKED_AT):
        before, after = max(k - 1, 0), min(k + 1, STATES_LOOKED_AT - 1)
        beyond = float(at[k]) if looked.smallest[k] < -TOLERANCE else np.nan
        # Each is smooth by itself; the smallest of them is not.
        for name, values in looked.columns.items():
            around = values[[before, after]]
            lowest = values[k] < CLOSE and values[k] <= around.min()
            # As in `_dip`; the points' distances differ by up to three times.
            may_dip = lowest and values[k] < 4.0 * (around.max() - values[k])
            if np.isnan(beyond) and may_dip:
                beyond = _dip(clearance(name), at[before], at[after])
        if np.isfinite(beyond):
            limit = _first_inadmissible(look, at[before], beyond)
            # What jumps, as a tail that begins to rise, may be known behind the limit alone.
            return limit, look(np.array([limit])).reasons(0) or look(np.array([beyond])).reasons(0)
    return np.nan, ""


def _dip(clearance: Callable[[FloatArray], FloatArray], low: float, high: float) -> float:
    """Fraction between two at which a clearance is negative; NaN if it is nowhere, as it seems."""
    while high - low > LIMIT_TOLERANCE:
        at = np.linspace(low, high, ZOOM)
        nearest = clearance(at)
        least = int(np.argmin(nearest))
        if nearest[least] < -TOLERANCE:
            return float(at[least])
        around = [max(least - 1, 0), min(least + 1, ZOOM - 1)]
        # Between two looks a dip, be it a kink, falls by no more than it rises to the next one.
        if nearest[least] > nearest[around].max() - nearest[least]:
            return np.nan
        low, high = at[around]
    return np.nan


def _first_inadmissible(look: Callable[[FloatArray], Clearance], low: float, high: float) -> float:
    """First fraction from `low` on at which a shape is inadmissible, as it is at `high`."""
    while high - low > LIMIT_TOLERANCE:
        at = np.linspace(low, high, ZOOM)
        first = int(np.argmax(look(at).smallest < -TOLERANCE))
        low, high = at[max(first - 1, 0)], at[first]
    return float(high)
