"""Events on resolved parts that need their shapes: lateral buckling, inadmissible shapes."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.admissibility import TOLERANCE, Clearance, clearances
from vibrissa.mechanics.aside import stability_aside
from vibrissa.mechanics.stability import stability
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.spectral import (
    chebyshev_derivative,
    chebyshev_nodes,
    chebyshev_roots,
    chebyshev_transform,
    interpolation,
)
from vibrissa.outcomes import Contact, End
from vibrissa.sticking.assembly import Event
from vibrissa.sticking.piece import Piece, StickingState, rounded_contact
from vibrissa.sticking.solving.branches import Branches
from vibrissa.sticking.solving.refinement import Resolved, along

# Accuracy with which the end of the admissible shapes is located, relative to a part.
LIMIT_TOLERANCE = 1e-11
# A part with less clearance than this (L) is looked at closely, at so many states in each interval
# in which a place is sought.
CLOSE, ZOOM = 0.1, 17
# A shape that is inadmissible stays so for long, or until its tip is level: few states show it.
STATES_LOOKED_AT = 17
# Slope of a tip (rad) above which no rod arches over the surface.
NEARLY_LEVEL = 0.01
# Part of the nodes that gives the margins as well as these states do, and the fewest.
STABILITY_NODES, FEWEST_STABILITY_NODES = 0.45, 14
# Parts of a part between whose ends the margin is taken as linear, to find where it vanishes.
BUCKLING_WIDTHS = (1e-4, 1e-7)


class Finished(NamedTuple):
    """A resolved part of a section, and where its shapes become inadmissible or it buckles."""

    section: int
    piece: Piece
    residual: float
    events: list[Event]


def finished(
    found: Resolved, branches: Branches, side: FloatArray, *, round_rods: bool, ideal: bool
) -> Iterator[Finished]:
    """Add to resolved parts their stability and how far their shapes are admissible."""
    parts, count = found.parts, found.count
    some = branches.take(parts.branch)
    position, every_second = chebyshev_nodes(STATES_LOOKED_AT), (count + 1) // 2
    margins = _margins(found.at(chebyshev_nodes(every_second)), len(parts), round_rods)
    to_states = interpolation(every_second, chebyshev_nodes(count))
    offset, fx, fy, moment, phi1, s_c = np.moveaxis(found.loads, -1, 0)
    states = StickingState(
        x0=some.displacement(offset),
        reaction_fx=fx,
        reaction_fy=fy,
        reaction_m=moment,
        phi1=phi1,
        s_c=rounded_contact(s_c),
        **{name: to_states @ values for name, values in margins.items()},
    )
    places = parts.start + chebyshev_nodes(count)[:, None] * parts.length
    states.x0[:, parts.by_x0] = (side[parts.branch] * places)[:, parts.by_x0]
    nearest = _looked_at(found, position).smallest
    for row in range(len(parts)):
        start, length = float(parts.start[row]), float(parts.length[row])
        piece = Piece(
            contact=Contact.LINE if parts.line[row] else Contact.POINT,
            by_x0=bool(parts.by_x0[row]),
            start=start,
            stop=start + length,
            states=states.take((slice(None), row)).copy(),
        )
        events, level = [], np.empty(0)
        if found.path.curvature.shape[1] and not parts.line[row]:
            level = _level(states.phi1[:, row])
        if len(level) or nearest[:, row].min() < CLOSE:
            share, how = _limit(found.take(np.array([row])), np.union1d(position, level))
            events.append(Event(start + share * length, End.OUT_OF_REACH, how))
        if round_rods and not ideal:
            events.append(Event(_buckling(found.take(np.array([row])), piece), End.SWINGS_ASIDE))
        if side[parts.branch[row]] < 0.0:
            # In the order of x0: Chebyshev points are so, too, from the other end.
            backwards = piece.states.take(slice(None, None, -1))
            piece = replace(piece, start=-piece.stop, stop=-start, states=backwards)
        yield Finished(int(parts.section[row]), piece, float(found.residual[row]), events)


def _level(phi1: FloatArray) -> FloatArray:
    """Fractions of a part where its tip is level or nearly: just before, a rod may arch over it."""
    series = chebyshev_transform(len(phi1)) @ phi1
    # No polynomial of Chebyshev exceeds 1.
    if np.abs(series[0]) - np.abs(series[1:]).sum() > NEARLY_LEVEL:
        return np.empty(0)
    extremes = chebyshev_roots(chebyshev_derivative(len(phi1)) @ series)
    return np.union1d(chebyshev_roots(series), extremes)


def _margins(states: RodStates, number: int, round_rods: bool) -> dict[str, FloatArray]:
    """Margins of stability of states along parts, each of shape (places, parts)."""
    few = states.on_nodes(max(round(STABILITY_NODES * states.nodes), FEWEST_STABILITY_NODES))
    aside = stability_aside(few) if round_rods else np.full(len(few), np.nan)
    margins = {"stability": stability(few), "stability_aside": aside}
    return {name: values.reshape(-1, number) for name, values in margins.items()}


def _buckling(found: Resolved, piece: Piece) -> float:
    """Where a rod buckles laterally, as a value of the parameter; NaN if nowhere."""
    sampled, only = -piece.alone.samples.stability_aside, np.zeros(1, dtype=np.int64)
    at = float(piece.alone.first(only, sampled, np.zeros(1), {"stability_aside": 1.0})[0])
    if np.isnan(at) or sampled[0, 0] >= 0.0:
        return at
    length = piece.stop - piece.start
    for width in BUCKLING_WIDTHS:
        places = at + width * length * np.array([-1.0, 1.0])
        before, after = stability_aside(found.at((places - piece.start) / length))
        at = float(places[0] + before / (before - after) * (places[1] - places[0]))
    return at


def _looked_at(found: Resolved, at: FloatArray) -> Clearance:
    """Clearances at fractions of parts, of shape (places, parts)."""
    to_places, parts = interpolation(found.count, at), found.parts
    height = parts.height + parts.tilt * (to_places @ found.loads[:, :, 0])
    clearance = clearances(along(to_places, found.path), height.ravel())
    return clearance.each(lambda values: values.reshape(len(at), -1))


def _limit(found: Resolved, at: FloatArray) -> tuple[float, str]:
    """First fraction of one part at which its shape is inadmissible, and how; NaN if nowhere."""

    def look(at: FloatArray) -> Clearance:
        return _looked_at(found, at).each(np.ravel)

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
    from scipy.optimize import brentq  # a tenth of a second to load

    def excess(at: float) -> float:
        # What is far from a limit has an infinite clearance.
        return float(np.minimum(look(np.array([at])).smallest, CLOSE)[0]) + TOLERANCE

    if low == high or excess(low) <= 0.0:
        return low
    # Behind the limit, so that the shape tells how.
    return min(float(brentq(excess, low, high, xtol=LIMIT_TOLERANCE)) + LIMIT_TOLERANCE, high)
