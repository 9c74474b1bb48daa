"""Assembly of curves from solved parts: critical states, first line contacts, ends."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import Contact, End, RodSection, Status
from vibrissa.sticking.curve import SAME, StickingCurve, failed_curve
from vibrissa.sticking.piece import PieceArray

NO_MAXIMUM = (
    "the path could not be followed up to a maximum of -tan alpha; try a larger eta or a theta "
    "closer to 1"
)
NOT_IN_PLANE = (
    "the rod leaves its plane with alpha = 0 already; try section: planar, a smaller eta, or a "
    "curvature that is less towards the surface"
)
_FORCE = ("reaction_fx", "reaction_fy")


class Event(NamedTuple):
    """End of a path: the value of the parameter of its piece, the kind of end, the reason."""

    at: float
    end: End
    reason: str = ""


def _demand_slope(
    force: FloatArray, slope: FloatArray, curvature: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Differentiate fx/fy, times fy², and that product once more."""
    (fx, fy), (dfx, dfy), (ddfx, ddfy) = force, slope, curvature
    return dfx * fy - fx * dfy, ddfx * fy - fx * ddfy


class _Extremes(NamedTuple):
    """Displacements (L) of the largest −tan α (`top`) and of the first tangential touch, or NaN."""

    top: FloatArray
    demand: FloatArray
    touch: FloatArray


def assembled_curves(
    followed: Sequence[StickingCurve], events: Sequence[Sequence[Sequence[Event]]]
) -> list[StickingCurve]:
    """Cut curves off where they end, and locate their locks and first contacts along a line.

    Parameters
    ----------
    followed : sequence of StickingCurve
        At least one; the pieces of each join from displacement 0 to beyond its end, those
        without x0 as parameter last. Their `end` holds where no event comes before.
    events : sequence of sequences of sequences of Event
        For each piece of each curve.

    Returns
    -------
    list of StickingCurve
        ``failed`` if −tan α has no maximum inside the given displacements, ``out_of_reach`` and up
        to there if the shape becomes inadmissible before.
    """
    kept = _until_end(followed, events)
    extremes = _extremes(PieceArray(pieces=tuple(piece for one in kept for piece in one.pieces)))
    return [
        _with_lock(curve, _Extremes(*(values[rows] for values in extremes)))
        for curve, rows in zip(kept, _rows(kept), strict=True)
    ]


def _rows(curves: Iterable[StickingCurve]) -> Iterator[slice]:
    """Slices of the pieces of each curve in the joined array of pieces."""
    start = 0
    for curve in curves:
        yield slice(start, start + len(curve.pieces))
        start += len(curve.pieces)


def _with_lock(curve: StickingCurve, extremes: _Extremes) -> StickingCurve:
    """Add the lock and the first line contact to a curve that is cut off."""
    message = "" if curve.end is End.NOT_FOLLOWED else curve.end_message
    x0_lock, mu_lock = _lock(curve, extremes)
    within = 0.0 < x0_lock < curve.x0_end - SAME
    if not curve.pieces or not (within or mu_lock == np.inf or curve.end is End.SWINGS_ASIDE):
        if curve.end is not End.OUT_OF_REACH or not curve.pieces:
            return failed_curve(
                theta=curve.theta,
                eta=curve.eta,
                method=curve.method,
                message=message or NO_MAXIMUM,
                status=Status.OUT_OF_REACH if message else Status.FAILED,
            )
        x0_lock = mu_lock = np.nan
    locks = not np.isnan(mu_lock)
    touch, last = _first_touch(curve, extremes), x0_lock if locks else curve.x0_end
    return replace(
        curve,
        status=Status.SOLVED if locks else Status.OUT_OF_REACH,
        message="" if locks else message,
        x0_lock=x0_lock,
        mu_lock=mu_lock,
        x0_touch=touch if touch <= last + SAME else np.nan,
    )


def _until_end(
    followed: Sequence[StickingCurve], events: Sequence[Sequence[Sequence[Event]]]
) -> list[StickingCurve]:
    """Cut curves off at the first event that ends them."""
    pieces = PieceArray(pieces=tuple(piece for one in followed for piece in one.pieces))
    found = {
        End.SWINGS_ASIDE: _passes_under(followed, pieces),
        End.SNAPS: pieces.turning_points(),
        End.LIFTS_OFF: _lifts(pieces),
    }
    ends, cuts = [], {}
    for curve, some, rows in zip(followed, events, _rows(followed), strict=True):
        kept: list[int] = []
        first = Event(np.inf, curve.end, curve.end_message)
        for row, shown in zip(range(rows.start, rows.stop), some, strict=True):
            known = [*shown, *(Event(at[row], end) for end, at in found.items())]
            known = [event for event in known if np.isfinite(event.at)]
            stop = min((event.at for event in known), default=np.inf)
            if stop > pieces.start[row] + SAME:
                kept.append(row)
                if stop < pieces.stop[row]:
                    cuts[row] = stop
            if known:
                first = min(known, key=lambda event: event.at)
                break
        if first.end is End.SWINGS_ASIDE and not kept:
            first = first._replace(reason=NOT_IN_PLANE)
        ends.append((kept, first))
    shorter = pieces.restricted(np.array([*cuts], dtype=np.int64), np.array([*cuts.values()]))
    cut = dict(zip(cuts, shorter, strict=True))
    return [
        replace(
            curve,
            pieces=tuple(cut.get(row, pieces.pieces[row]) for row in kept),
            end=first.end,
            end_message=first.reason,
        )
        for curve, (kept, first) in zip(followed, ends, strict=True)
    ]


def _lifts(pieces: PieceArray) -> FloatArray:
    """Where on each piece the surface would have to pull from there on; NaN where nowhere."""
    lifts = np.full(len(pieces.pieces), np.nan)
    rows = np.flatnonzero(pieces.samples.reaction_fy.max(axis=1, initial=-np.inf) >= 0.0)
    fy = pieces.samples.reaction_fy
    lifts[rows] = pieces.first(rows, fy, np.zeros(len(rows)), {"reaction_fy": 1.0})
    return lifts


def _passes_under(curves: Sequence[StickingCurve], pieces: PieceArray) -> FloatArray:
    """Where ideal round rods buckle: x0 = x1_init − (1 − s_c), under the contact point; or NaN."""
    passes = [c.section is RodSection.ROUND and c.mounting.is_ideal for c in curves]
    each = np.where(passes, [curve.x1_init for curve in curves], np.nan)
    x1_init = np.repeat(each, [len(curve.pieces) for curve in curves])
    # In tip contact that is x1_init itself. A piece may end there, up to rounding.
    inside = (pieces.start <= x1_init) & (x1_init <= pieces.stop + SAME)
    at = np.where(inside, np.minimum(x1_init, pieces.stop), np.nan)
    rows = np.flatnonzero(np.isfinite(x1_init) & (pieces.line | ~pieces.by_x0))
    level, way = x1_init[rows] - 1.0, pieces.samples.x0 - pieces.samples.s_c
    at[rows] = pieces.first(rows, way, level, {"x0": 1.0, "s_c": -1.0}, level)
    return at


def _extremes(pieces: PieceArray) -> _Extremes:
    """Find where −tan α is largest, and where rods touch the surface."""
    top, demand, touch = np.full((3, len(pieces.pieces)), np.nan)
    rows = np.arange(len(pieces.pieces))
    if len(rows):
        # Where fy vanishes with fx > 0 the tip slips back before it lifts off.
        ahead = pieces.samples.reaction_fx <= 0.0
        sampled = np.where(ahead, pieces.samples.mobilised_friction, -np.inf)
        states = pieces.at(rows, pieces.largest(rows, sampled, _FORCE, _demand_slope))
        top, demand = states.x0, np.where(states.reaction_fx <= 0.0, states.mobilised_friction, 0.0)
    rows = np.flatnonzero(~pieces.line)
    at = pieces.first(rows, -pieces.samples.phi1, np.zeros(len(rows)), {"phi1": 1.0})
    rows, at = rows[np.isfinite(at)], at[np.isfinite(at)]
    if len(rows):
        touch[rows] = pieces.at(rows, at).x0
    touch[pieces.line] = pieces.first_x0[pieces.line]
    return _Extremes(top=top, demand=demand, touch=touch)


def _lock(curve: StickingCurve, extremes: _Extremes) -> tuple[float, float]:
    """Locate where −tan α is largest on a curve, and its value there; infinite at lift-off."""
    pieces = curve.pieces
    if not pieces:
        return np.nan, -np.inf
    if curve.end is End.LIFTS_OFF and pieces[-1].states.reaction_fx[-1] < 0.0:
        return curve.x0_end, np.inf
    row = int(np.argmax(extremes.demand))
    x0_lock = float(extremes.top[row])
    # A maximum in a kink belongs to both pieces: put it where the second one begins.
    for piece in pieces[1:]:
        if abs(piece.first_x0 - x0_lock) <= SAME:
            x0_lock = piece.first_x0
    return x0_lock, float(extremes.demand[row])


def _first_touch(curve: StickingCurve, extremes: _Extremes) -> float:
    """First displacement at which φ1 = 0 on a curve; NaN if there is none."""
    lying = [piece.contact is Contact.LINE for piece in curve.pieces]
    # Where the rod lies down, it touches the surface for the first time.
    sought = extremes.touch[lying if any(lying) else np.isfinite(extremes.touch)]
    return float(sought[0]) if len(sought) else np.nan
