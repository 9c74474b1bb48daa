"""Finishing of resolved parts: states of pieces, lateral buckling, inadmissible shapes."""

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import chebyshev

from vibrissa.mechanics.admissibility import (
    ALL_CLEARANCES,
    CLEARANCE_TOLERANCE,
    LIMITING_CLEARANCES,
    Clearance,
    clearances,
)
from vibrissa.mechanics.lateral import lateral_stability
from vibrissa.mechanics.mounting import CURVATURE
from vibrissa.numerics.arrays import FloatArray, IntArray, ObjectArray
from vibrissa.numerics.batch import Batch
from vibrissa.numerics.spectral import (
    chebyshev_derivative,
    chebyshev_interpolation,
    chebyshev_nodes,
    chebyshev_roots,
    chebyshev_transform,
    interpolation,
)
from vibrissa.outcomes import Contact
from vibrissa.sticking.locks import ShapeLimits
from vibrissa.sticking.piece import (
    NO_PIECES,
    SAMPLES,
    STATES_PER_PIECE,
    PathState,
    Pieces,
    rounded_contact,
)
from vibrissa.sticking.shapes import ShapesAlongPiece, SolvedParts
from vibrissa.sticking.solving.branches import Branches
from vibrissa.sticking.solving.cutting import Parts
from vibrissa.sticking.solving.refinement import Resolved, StatesAlongParts

# Accuracy of the place where shapes become inadmissible, as a fraction of a part.
LIMIT_TOLERANCE = 1e-11
# A part with less clearance (L) is examined closely.
CLOSE_CLEARANCE = 0.1
# Number of states in each interval of such a part in which a limit may lie.
CLOSE_STATES = 17
# Number of states of a part that are examined first. Few suffice, because shapes stay inadmissible
# over a long range of x0, or until the tip is level.
STATES_LOOKED_AT = 17
# Slope of a tip (rad) above which no rod arches over the surface.
ARCHLESS_SLOPE = 0.01
# Intervals, as fractions of a part, over which the margin is taken as linear to find its zero.
BUCKLING_WIDTHS = (1e-4, 1e-7)


@dataclass(frozen=True, eq=False, kw_only=True)
class Finished(Batch):
    """Resolved parts as pieces of curves. Of a part that was halved, each half is a piece.

    Attributes
    ----------
    knot : ndarray of int, shape (n,)
        Index of the knot at which the part begins, which is the same for all its pieces.
    pieces : Pieces
        States and shapes.
    limits : ShapeLimits
        Where a curve may end on each piece because of the rod's shape.
    residual : ndarray, shape (n,)
        Largest residual between the states of each piece.
    """

    knot: IntArray
    pieces: Pieces
    limits: ShapeLimits
    residual: FloatArray


NONE_FINISHED = Finished(
    knot=np.empty(0, dtype=np.int64),
    pieces=NO_PIECES,
    limits=ShapeLimits.unknown(0),
    residual=np.empty(0),
)


def finished(
    found: Resolved,
    branches: Branches,
    side: FloatArray,
    model: Contact,
    *,
    round_rods: bool,
    ideal: bool,
) -> Finished:
    """Make pieces of resolved parts, with the limits of admissible shapes.

    With the `model` POINT, an arch that rises through the surface is located, too. `side` is
    explained in `follow`. `ideal` tells whether all mountings are ideal; lateral buckling of round
    rods is located here in other mountings only.
    """
    parts = found.path.parts
    solved = SolvedParts(
        rods=parts.rods, unknowns=found.path.unknowns, line=parts.line, round_rods=round_rods
    )
    pieces = _pieces(found, branches, side, _shapes(solved, parts, side))
    out_of_reach, arches = np.full((2, len(parts)), np.nan)
    reason = np.full(len(parts), "", dtype=object)
    position = chebyshev_nodes(STATES_LOOKED_AT)
    looked = _looked_at(found, position)
    nearest = looked.smallest.min(axis=1)
    for row in range(len(parts)):
        level = np.empty(0)
        if parts.rods.shape[1] > CURVATURE.start and not parts.line[row]:
            level = _level(found.loads[row, :, 4])
        if len(level) or nearest[row] < CLOSE_CLEARANCE:
            part, at = found.take([row]), np.union1d(position, level)
            seen = _looked_at(part, at).each(np.ravel) if len(level) else looked.take(row)
            share, how = _limit(part, at, seen, LIMITING_CLEARANCES[model])
            if model is Contact.POINT and (
                len(level) or looked.surface[row].min() < CLOSE_CLEARANCE
            ):
                arch, _ = _limit(part, at, seen, ("surface",))
                arches[row] = parts.start[row] + arch * parts.length[row]
            out_of_reach[row] = parts.start[row] + share * parts.length[row]
            reason[row] = how
    swings_aside = np.full(len(parts), np.nan)
    if round_rods and not ideal:
        swings_aside = _buckling(found.path, solved, pieces)
    limits = ShapeLimits(
        out_of_reach=out_of_reach,
        arches=arches,
        swings_aside=swings_aside,
        reason=reason,
    )
    # Reverse retracted parts, so that x0 increases; Chebyshev points are symmetric.
    back = np.flatnonzero(side[parts.branch] < 0.0)
    turned = pieces.take(back)
    backwards = turned.states.take((slice(None), slice(None, None, -1)))
    turned = replace(turned, start=-turned.stop, stop=-turned.start, states=backwards)
    pieces = pieces.with_rows(back, turned)
    return Finished(knot=parts.first, pieces=pieces, limits=limits, residual=found.residual)


def _pieces(found: Resolved, branches: Branches, side: FloatArray, shapes: ObjectArray) -> Pieces:
    """Pieces with the states of parts, in the direction in which the parts were followed."""
    parts, count, places = found.path.parts, found.path.count, chebyshev_nodes(STATES_PER_PIECE)
    loads = chebyshev_interpolation(count, STATES_PER_PIECE) @ found.loads
    offset, fx, fy, moment, phi1, s_c = np.moveaxis(loads, -1, 0)
    at = parts.start[:, None] + places * parts.length[:, None]
    way, x1_init, cos = (
        values[parts.branch, None] for values in (side, branches.x1_init, branches.cos)
    )
    states = PathState(
        x0=np.where(parts.by_x0[:, None], way * at, (x1_init - offset) / cos),
        reaction_fx=fx,
        reaction_fy=fy,
        reaction_m=moment,
        phi1=phi1,
        s_c=rounded_contact(s_c),
    )
    stop = parts.start + parts.length
    return Pieces(
        line=parts.line,
        by_x0=parts.by_x0,
        start=parts.start,
        stop=stop,
        states=states,
        shapes=shapes,
    )


def _shapes(solved: SolvedParts, parts: Parts, side: FloatArray) -> ObjectArray:
    """Shapes along each part; the parameter of a retracted part changes its sign."""
    shapes = np.empty(len(parts), dtype=object)
    for row, sign in enumerate(side[parts.branch]):
        shapes[row] = ShapesAlongPiece(
            parts=solved,
            row=row,
            first=float(sign * parts.start[row]),
            last=float(sign * (parts.start[row] + parts.length[row])),
        )
    return shapes


def _level(phi1: FloatArray) -> FloatArray:
    """Fractions of a part at which φ1 is zero or extreme; the rod may arch just before.

    Empty if the tip is far from level on the whole part.
    """
    series = chebyshev_transform(len(phi1)) @ phi1
    # No Chebyshev polynomial exceeds 1.
    if np.abs(series[0]) - np.abs(series[1:]).sum() > ARCHLESS_SLOPE:
        return np.empty(0)
    extremes = chebyshev_roots(chebyshev_derivative(len(phi1)) @ series)
    return np.union1d(chebyshev_roots(series), extremes)


def _buckling(path: StatesAlongParts, solved: SolvedParts, pieces: Pieces) -> FloatArray:
    """Parameter values at which rods buckle laterally; NaN if nowhere."""
    shares = np.linspace(0.0, 1.0, SAMPLES)
    sampled = chebyshev.chebval(2.0 * shares - 1.0, solved.lateral_margins.T)
    buckled = sampled <= 0.0
    after = buckled.argmax(axis=1)
    share = np.where(buckled.any(axis=1), shares[after], np.nan)
    rows = np.flatnonzero(after > 0)
    if len(rows):
        last = after[rows]
        behind, before = sampled[rows, last], sampled[rows, last - 1]
        share[rows] -= behind / (behind - before) * (shares[last] - shares[last - 1])
        some = path.take(rows)
        for width in BUCKLING_WIDTHS:
            sides = share[rows, None] + width * np.array([-1.0, 1.0])
            low, high = lateral_stability(some.at(sides).states).reshape(-1, 2).T
            share[rows] = sides[:, 0] + low / (low - high) * (sides[:, 1] - sides[:, 0])
    return pieces.start + share * (pieces.stop - pieces.start)


def _looked_at(
    found: Resolved, at: FloatArray, wanted: Collection[str] = ALL_CLEARANCES
) -> Clearance:
    """Clearances of the shapes at fractions `at` of each part; shape (parts, len(at))."""
    closing, offset = found.path.parts.closing, found.loads[:, :, 0]
    offset = offset @ interpolation(found.path.count, at).T
    height = closing.height[:, None] + closing.tilt[:, None] * offset
    clearance = clearances(found.path.at(at).states, height.ravel(), wanted)
    return clearance.each(lambda values: values.reshape(height.shape))


def _limit(
    found: Resolved, at: FloatArray, seen: Clearance, names: Collection[str]
) -> tuple[float, str]:
    """First fraction of one part at which a clearance is negative, and why; NaN if nowhere.

    Only the clearances `names` count; `seen` has those at the fractions `at`.
    """

    def look(at: FloatArray) -> Clearance:
        return _looked_at(found, at, names).each(np.ravel)

    looked = seen.only(names)
    while True:
        known = len(at)
        beyond = int(np.append(looked.smallest < -CLEARANCE_TOLERANCE, True).argmax())
        at = _with_dips(at, looked, beyond)
        if len(at) == known:
            break
        looked = look(at)
    if beyond == known:
        return np.nan, ""
    limit = _first_inadmissible(look, at[max(beyond - 1, 0)], at[beyond])
    # A clearance may jump where a tail begins to rise: then only states beyond show the reason.
    return limit, look(np.array([limit])).reasons(0) or looked.reasons(beyond)


def _with_dips(at: FloatArray, looked: Clearance, beyond: int) -> FloatArray:
    """Add fractions to `at`, before `at[beyond]`, where a clearance may dip below zero."""
    before, after = (
        np.maximum(np.arange(len(at)) - 1, 0),
        np.minimum(np.arange(len(at)) + 1, len(at) - 1),
    )
    places = [at]
    # Each clearance is smooth by itself; the smallest of them is not.
    for values in looked.columns.values():
        lowest = (values < CLOSE_CLEARANCE) & (values <= np.minimum(values[before], values[after]))
        # A rod that lies on the surface is at 0 up to rounding, or counts as far from it.
        far = np.isinf(np.maximum(values[before], values[after]))
        lowest &= ~(far & (np.abs(values) < CLEARANCE_TOLERANCE))
        for k in np.flatnonzero(lowest[:beyond]):
            rise = max(values[before[k]], values[after[k]]) - values[k]
            low, high = at[before[k]], at[after[k]]
            # Between equally spaced samples, even a kinked minimum is below the lowest sample by at
            # most the rise to the next one. The factor 4 allows for unequal spacing, and the
            # tolerance excludes minima that are rounding errors.
            if values[k] + CLEARANCE_TOLERANCE < 4.0 * rise and high - low > LIMIT_TOLERANCE:
                places.append(np.linspace(low, high, CLOSE_STATES))
    return np.unique(np.concatenate(places))


def _first_inadmissible(look: Callable[[FloatArray], Clearance], low: float, high: float) -> float:
    """Locate the first fraction with an inadmissible shape; the shape at `high` is inadmissible."""
    from scipy.optimize import brentq  # a tenth of a second to load

    def excess(at: float) -> float:
        # Large clearances are infinite.
        return (
            float(np.minimum(look(np.array([at])).smallest, CLOSE_CLEARANCE)[0])
            + CLEARANCE_TOLERANCE
        )

    if low == high or excess(low) <= 0.0:
        return low
    if excess(high) > 0.0:  # by rounding, as it was found together with other places
        return high
    # Just beyond the limit, so that the shape there shows the reason.
    return min(float(brentq(excess, low, high, xtol=LIMIT_TOLERANCE)) + LIMIT_TOLERANCE, high)
