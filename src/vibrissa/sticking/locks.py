"""Ends, locks and first touches of sticking curves, which are made of solved pieces."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from vibrissa.numerics.arrays import FloatArray, StrArray
from vibrissa.numerics.batch import Batch
from vibrissa.outcomes import End, RodSection, Status
from vibrissa.sticking.curve import SAME_X0, StickingCurve, failed_curve
from vibrissa.sticking.piece import AHEAD, ROUNDED_FORCE, Pieces

NO_MAXIMUM = (
    "the computed states end before -tan alpha reaches a maximum; try a larger eta or a theta "
    "closer to 1"
)
NEVER_PUSHED = "in this mounting the tip is never pushed forward: it slips back or lifts off"
NOT_IN_PLANE = (
    "the rod leaves its plane already at alpha = 0; try section: planar, a smaller eta, or a "
    "curvature that bends the rod less towards the surface"
)


@dataclass(frozen=True, eq=False, kw_only=True)
class ShapeLimits(Batch):
    """Places at which a curve may end because the shape of the rod is not possible there.

    A place is a value of the continuation parameter of a piece; NaN if the piece has no such place.

    Attributes
    ----------
    out_of_reach : ndarray, shape (pieces,)
        Places at which the shape becomes inadmissible.
    arches : ndarray, shape (pieces,)
        Places at which an arch rises through the surface where only the tip may touch it. They end
        no curve.
    swings_aside : ndarray, shape (pieces,)
        Places at which the rod buckles laterally in a non-ideal mounting.
    reason : ndarray of str, shape (pieces,)
        Why the shape is inadmissible.
    """

    out_of_reach: FloatArray
    arches: FloatArray
    swings_aside: FloatArray
    reason: StrArray


class _Extremes(NamedTuple):
    """Largest −tan α of each piece (`demand`), its x0 (`top`), and x0 of the first touch or NaN."""

    top: FloatArray
    demand: FloatArray
    touch: FloatArray

    def of(self, rows: slice) -> "_Extremes":
        """Return those of some pieces."""
        return _Extremes(top=self.top[rows], demand=self.demand[rows], touch=self.touch[rows])


def assembled_curves(
    followed: Sequence[StickingCurve], limits: Sequence[ShapeLimits]
) -> list[StickingCurve]:
    """Cut each curve off at its end, and find its lock and its first tangential touch.

    Parameters
    ----------
    followed : sequence of StickingCurve
        At least one curve. Its pieces begin at x0 = 0 and reach to where the solver stopped. If no
        end is found on the pieces, the curve keeps its `end`.
    limits : sequence of ShapeLimits
        For each curve the limits of its pieces.

    Returns
    -------
    list of StickingCurve
        Curves with their ends, locks and touches. The status is ``failed`` if −tan α has no
        maximum. It is ``out_of_reach`` if the rod leaves its plane at α = 0 already, or if the
        shape becomes inadmissible before the maximum; the curve then ends at this shape.
    """
    kept = _until_end(followed, ShapeLimits.concatenate(limits))
    # A curve keeps its first pieces; the last of them may have been cut off before its arch.
    arches = [one.arches[: len(curve.pieces)] for one, curve in zip(limits, kept, strict=True)]
    pieces = Pieces.concatenate([curve.pieces for curve in kept])
    extremes = _extremes(pieces, np.concatenate(arches))
    return [
        _with_lock(curve, extremes.of(rows)) for curve, rows in zip(kept, _rows(kept), strict=True)
    ]


def _rows(curves: Sequence[StickingCurve]) -> list[slice]:
    """Return for each curve the slice of its pieces in the joined pieces of all curves."""
    bounds = np.cumsum([0, *(len(curve.pieces) for curve in curves)]).tolist()
    return [slice(start, stop) for start, stop in pairwise(bounds)]


def _with_lock(curve: StickingCurve, extremes: _Extremes) -> StickingCurve:
    """Add the lock and the first touch to a curve that was cut off at its end."""
    message = "" if curve.end is End.NOT_FOLLOWED else curve.end_message
    if not curve.pieces:
        return _without_states(curve, message)
    lock = _lock(curve, extremes)
    within = 0.0 < lock.x0 < curve.x0_end - SAME_X0
    # Up to where it snaps or buckles, the rod sticks at every larger friction.
    held = curve.end is End.SWINGS_ASIDE or (curve.end is End.SNAPS and lock.x0 > 0.0)
    touch = _first_touch(curve, extremes)
    if within or held or lock.mu == np.inf:
        touched = touch if touch <= lock.x0 + SAME_X0 else np.nan
        return replace(
            curve,
            status=Status.SOLVED,
            message="",
            x0_lock=lock.x0,
            mu_lock=lock.mu,
            x0_touch=touched,
        )
    if curve.end is not End.OUT_OF_REACH:
        never_pushed = (curve.pieces.samples.reaction_fx > -ROUNDED_FORCE).all()
        return _without_states(curve, NEVER_PUSHED if never_pushed else message)
    return replace(
        curve,
        status=Status.OUT_OF_REACH,
        message=message,
        x0_lock=np.nan,
        mu_lock=np.nan,
        x0_touch=touch if touch <= curve.x0_end + SAME_X0 else np.nan,
    )


def _without_states(curve: StickingCurve, message: str) -> StickingCurve:
    """Return a curve without states: out of reach for the reason in `message`, or else failed."""
    status = Status.OUT_OF_REACH if message else Status.FAILED
    why = message or NO_MAXIMUM
    failed = failed_curve(curve.theta, curve.eta, why, status, curve.method)
    return replace(failed, section=curve.section, mounting=curve.mounting)


def _until_end(followed: Sequence[StickingCurve], limits: ShapeLimits) -> list[StickingCurve]:
    """Cut each curve off where the first of its possible ends occurs."""
    pieces = Pieces.concatenate([curve.pieces for curve in followed])
    rows = np.arange(len(pieces))
    found = {
        End.OUT_OF_REACH: limits.out_of_reach,
        End.SWINGS_ASIDE: np.fmin(limits.swings_aside, _passes_under(followed, pieces)),
        End.SNAPS: pieces.turning_points(),
        End.LIFTS_OFF: pieces.first_sum(rows, {"reaction_fy": 1.0}, np.zeros(len(rows))),
    }
    at = np.array([*found.values()])
    at[np.isnan(at)] = np.inf
    stop, ends = at.min(axis=0), np.array([*found], dtype=object)[at.argmin(axis=0)]
    begins = stop > pieces.start + SAME_X0
    cut = np.flatnonzero(begins & (stop < pieces.stop))
    shorter = pieces.with_rows(cut, pieces.take(cut).up_to(stop[cut]))
    kept = []
    for curve, own in zip(followed, _rows(followed), strict=True):
        end, reason, last = curve.end, curve.end_message, own.stop
        if np.isfinite(stop[own]).any():
            row = own.start + int(np.isfinite(stop[own]).argmax())
            end, last = ends[row], row + int(begins[row])
            reason = str(limits.reason[row]) if end is End.OUT_OF_REACH else ""
        if end is End.SWINGS_ASIDE and last == own.start:
            reason = NOT_IN_PLANE
        some = shorter.take(np.arange(own.start, last))
        kept.append(replace(curve, pieces=some, end=end, end_message=reason))
    return kept


def _passes_under(curves: Sequence[StickingCurve], pieces: Pieces) -> FloatArray:
    """Parameter values where the clamp passes under the contact point, x0 = x1_init − (1 − s_c).

    There a round rod in an ideal mounting buckles laterally; NaN for other rods and pieces.
    """
    passes = [c.section is RodSection.ROUND and c.mounting.is_ideal for c in curves]
    each = np.where(passes, [curve.x1_init for curve in curves], np.nan)
    x1_init = np.repeat(each, [len(curve.pieces) for curve in curves])
    # In point contact this is x0 = x1_init. A piece may end there, up to rounding.
    inside = (pieces.start <= x1_init) & (x1_init <= pieces.stop + SAME_X0)
    at = np.where(inside, np.minimum(x1_init, pieces.stop), np.nan)
    rows = np.flatnonzero(np.isfinite(x1_init) & (pieces.line | ~pieces.by_x0))
    at[rows] = pieces.first_sum(rows, {"x0": 1.0, "s_c": -1.0}, x1_init[rows] - 1.0)
    return at


def _extremes(pieces: Pieces, arches: FloatArray) -> _Extremes:
    """Find where −tan α is largest, and where rods touch the surface; `arches` as in the limits."""
    peaks = pieces.peaks(AHEAD)
    states = pieces.at(*peaks)
    held = np.where(states.reaction_fx <= 0.0, states.mobilised_friction, 0.0)
    top, demand = pieces.first_x0.copy(), np.zeros(len(pieces))
    # The highest peak of a piece comes last; of equal ones the first.
    order = np.lexsort((-np.arange(len(held)), held))
    top[peaks.piece[order]], demand[peaks.piece[order]] = states.x0[order], held[order]
    rows, tips = np.arange(len(pieces)), np.flatnonzero(~pieces.line)
    touch, none = pieces.first_x0.copy(), np.zeros(len(tips))
    at = pieces.first_sum(tips, {"phi1": -1.0}, none)
    arch = np.where(arches <= pieces.stop, arches, np.nan)
    touch[tips] = np.fmin(pieces.displacements(tips, at), pieces.displacements(rows, arch)[tips])
    return _Extremes(top=top, demand=demand, touch=touch)


class _Lock(NamedTuple):
    """Displacement at which −tan α is largest on a curve (L), and −tan α there."""

    x0: float
    mu: float


def _lock(curve: StickingCurve, extremes: _Extremes) -> _Lock:
    """Find the lock of a curve with states; its −tan α is infinite at lift-off."""
    pieces = curve.pieces
    if curve.end is End.LIFTS_OFF and pieces.states.reaction_fx[-1, -1] < 0.0:
        return _Lock(x0=curve.x0_end, mu=np.inf)
    row = int(np.argmax(extremes.demand))
    x0_lock = float(extremes.top[row])
    # A maximum in a kink belongs to two pieces: take the displacement at which the second begins.
    begins = pieces.first_x0[1:]
    kinks = begins[np.abs(begins - x0_lock) <= SAME_X0]
    return _Lock(x0=float(kinks[-1]) if len(kinks) else x0_lock, mu=float(extremes.demand[row]))


def _first_touch(curve: StickingCurve, extremes: _Extremes) -> float:
    """First displacement at which φ1 = 0 on a curve; NaN if there is none."""
    lying = curve.pieces.line
    # Where the rod lies down, it touches the surface for the first time.
    sought = extremes.touch[lying if lying.any() else np.isfinite(extremes.touch)]
    return float(sought[0]) if len(sought) else np.nan
