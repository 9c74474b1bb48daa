"""Resolved pieces get their margins of stability, and how far their shapes are admissible."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.admissibility import TOLERANCE, Clearance, clearances
from vibrissa.mechanics.aside import stability_aside
from vibrissa.mechanics.equations import contact_position
from vibrissa.mechanics.stability import stability
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import FloatArray, IntArray
from vibrissa.numerics.spectral import (
    chebyshev_derivative,
    chebyshev_nodes,
    chebyshev_roots,
    chebyshev_transform,
    interpolation,
)
from vibrissa.outcomes import Contact, Parameter, RodSection
from vibrissa.sticking.assembly import Limit
from vibrissa.sticking.piece import Piece, StickingState
from vibrissa.sticking.solving.paths import Pieces, combined, flat, of_pieces

# Accuracy with which the end of the admissible shapes is located, relative to a piece.
LIMIT_TOLERANCE = 1e-11
# A piece with less clearance than this (L) is looked at closely, at so many states in each interval
# in which a place is sought.
CLOSE, ZOOM = 0.1, 17
# The margin of stability is smooth and costs more than a state, and a shape that is inadmissible
# stays so for long, or until its tip is level: fewer states tell both.
STATES_LOOKED_AT = 17
# Slope of a tip (rad) above which no rod arches over the surface.
NEARLY_LEVEL = 0.01
# Part of the nodes that tells the margins as well as these states do, and the fewest for each.
STABILITY_NODES = 0.45
FEWEST_STABILITY_NODES, FEWEST_NODES_ASIDE = 16, 12
# Parts of a piece between whose ends the margin is taken as linear, to find where it vanishes.
SWING_WIDTHS = (1e-4, 1e-7)


class Resolved(NamedTuple):
    """A resolved piece.

    Attributes
    ----------
    part : int
        Which part of the paths it belongs to.
    piece : Piece
    residual : float
        Largest residual half-way between the states.
    limit : Limit
        How far its shapes are admissible.
    swing : float
        Where on it a round rod leaves its plane; NaN where it does not. In the ideal mounting that
        follows from where the contact point is, and is not sought.
    """

    part: int
    piece: Piece
    residual: float
    limit: Limit
    swing: float


def finished(
    path: RodStates, pieces: Pieces, states: StickingState, residual: FloatArray, rows: IntArray
) -> Iterator[Resolved]:
    """Add to resolved pieces their stability and how far their shapes are admissible.

    Parameters
    ----------
    path : RodStates
    pieces : Pieces
    states : StickingState
        Of the path, columns of shape (states, pieces).
    residual : ndarray, shape (pieces,)
        Largest residual half-way between the states.
    rows : ndarray of int
        Which of the pieces are resolved.

    Yields
    ------
    Resolved
    """
    if not len(rows):
        return
    path, pieces = of_pieces(path, rows), pieces.take(rows)
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
    looked = _looked_at(path, pieces.contact, position)
    nearest = looked.smallest
    for row in range(len(pieces)):
        start, length = float(pieces.start[row]), float(pieces.length[row])
        limit = Limit()
        level = np.empty(0)
        if path.mounting is not None and pieces.contact is Contact.POINT:
            level = _level(states.phi1[:, row])
        if len(level) or nearest[:, row].min() < CLOSE:
            only = of_pieces(path, np.array([row]))
            share, how = _limit(only, pieces.contact, np.union1d(position, level))
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
            swing = _swing(of_pieces(path, np.array([row])), piece)
        yield Resolved(int(pieces.part[row]), piece, float(residual[rows[row]]), limit, swing)


def _level(phi1: FloatArray) -> FloatArray:
    """Fractions of a piece where its tip lies level, or comes nearest to that.

    Just before, a rod that is curved towards the surface arches over it; beyond, its tip passes
    through the surface, and no arch counts.
    """
    series = chebyshev_transform(len(phi1)) @ phi1
    # No polynomial of Chebyshev exceeds 1.
    if np.abs(series[0]) - np.abs(series[1:]).sum() > NEARLY_LEVEL:
        return np.empty(0)
    extremes = chebyshev_roots(chebyshev_derivative(len(phi1)) @ series)
    return np.union1d(chebyshev_roots(series), extremes)


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


def _looked_at(path: RodStates, contact: Contact, at: FloatArray) -> Clearance:
    """Clearances at fractions of the pieces of a path, of shape (places, pieces)."""
    states = flat(combined(interpolation(len(path), at), path))
    found = clearances(states, contact_position(states)[1], contact)
    return found.each(lambda values: values.reshape(len(at), -1))


def _limit(path: RodStates, contact: Contact, at: FloatArray) -> tuple[float, str]:
    """First fraction of a piece at which its shape is inadmissible, and how; NaN if nowhere.

    Parameters
    ----------
    path : RodStates
        Of one piece.
    contact : Contact
    at : ndarray
        Increasing fractions at which clearances are looked at. The place is sought between.
    """

    def look(at: FloatArray) -> Clearance:
        return _looked_at(path, contact, at).each(np.ravel)

    def clearance(name: str) -> Callable[[FloatArray], FloatArray]:
        return lambda at: look(at).columns[name]

    looked = look(at)
    for k in range(len(at)):
        before, after = max(k - 1, 0), min(k + 1, len(at) - 1)
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
        if np.isinf(nearest[least]):
            return np.nan
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
