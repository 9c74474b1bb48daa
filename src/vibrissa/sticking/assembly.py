"""Curves are put together from what was solved: their locks, first contacts along a line, ends."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import Contact, End, RodSection, Status
from vibrissa.sticking.curve import SAME, StickingCurve, failed_curve
from vibrissa.sticking.piece import Piece, PieceArray

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
    """What ends a path: where on a piece, as a value of its parameter, how, and in what way."""

    at: float
    end: End
    reason: str = ""


def _demand_slope(
    force: FloatArray, slope: FloatArray, curvature: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Slope of fx/fy, times fy², and its own slope, by the derivatives of both."""
    (fx, fy), (dfx, dfy), (ddfx, ddfy) = force, slope, curvature
    return dfx * fy - fx * dfy, ddfx * fy - fx * ddfy


@dataclass(frozen=True, eq=False, kw_only=True)
class Solved:
    """What was solved of one curve, to be put together by `assembled_curves`.

    Attributes
    ----------
    theta, eta : float
        Taper factor and height of the contact point (L).
    method : str
        ``collocation`` or ``shooting``.
    x1_init : float
        Contact point in the α = 0 state (L).
    pieces : sequence of Piece
        From displacement 0 to beyond the lock, each beginning where the one before ends; then
        those counted by the advance, to beyond where x0 turns back. At least one.
    residual : float
        Largest equilibrium residual.
    events : sequence of sequences of Event
        For each piece, those that its shapes show: where they are inadmissible, and where a mounted
        rod buckles laterally.
    pulled : sequence of Piece
        Pieces at x0 < 0, in the order of x0.
    section : RodSection
    passes_under : bool
        Whether the rod buckles laterally where the clamp passes under the contact point, as a round
        one does in the ideal mounting.
    turned : bool
        Whether x0 turns back where the last piece ends, in a kink.
    no_end : str
        What to say if the pieces do not lead to an end.
    """

    theta: float
    eta: float
    method: str
    x1_init: float
    pieces: Sequence[Piece]
    residual: float
    events: Sequence[Sequence[Event]] = ()
    pulled: Sequence[Piece] = ()
    section: RodSection = RodSection.ROUND
    passes_under: bool = False
    turned: bool = False
    no_end: str = ""


class _Kept(NamedTuple):
    """Pieces of a curve up to where it ends, why it ends there, and more about it."""

    pieces: Sequence[Piece]
    end: End
    message: str


class _Extremes(NamedTuple):
    """What is sought on each piece, as displacements (L); NaN where it is not there.

    Attributes
    ----------
    top, demand : ndarray, shape (pieces,)
        Where −tan α is largest, and its value there.
    touch : ndarray, shape (pieces,)
        Where the rod first touches the surface tangentially.
    """

    top: FloatArray
    demand: FloatArray
    touch: FloatArray


def assembled_curves(solved: Sequence[Solved]) -> list[StickingCurve]:
    """Build curves from solved pieces: locate their locks, first contacts along a line, ends.

    Parameters
    ----------
    solved : sequence of Solved

    Returns
    -------
    list of StickingCurve
        ``failed`` if −tan α has no maximum inside the given displacements, ``out_of_reach`` and up
        to there if the shape becomes inadmissible before.
    """
    kept = _until_end(solved)
    pieces = PieceArray(pieces=tuple(piece for one in kept for piece in one.pieces))
    extremes = _extremes(pieces)
    return [
        _assembled_curve(one, up_to, _Extremes(*(values[rows] for values in extremes)))
        for one, up_to, rows in zip(
            solved, kept, _rows([up_to.pieces for up_to in kept]), strict=True
        )
    ]


def _rows(parts: Iterable[Sequence[Piece]]) -> Iterator[slice]:
    """Rows of each part where all stand below each other."""
    start = 0
    for part in parts:
        yield slice(start, start + len(part))
        start += len(part)


def _assembled_curve(solved: Solved, kept: _Kept, extremes: _Extremes) -> StickingCurve:
    """Build a curve of which all is known; see `assembled_curves`."""
    pieces, end, message = kept
    x0_lock, mu_lock = _lock(kept, extremes)
    within = bool(pieces) and 0.0 < x0_lock < pieces[-1].last_x0 - SAME
    if not pieces or not (within or mu_lock == np.inf or end is End.SWINGS_ASIDE):
        if end is not End.OUT_OF_REACH or not pieces:
            status = Status.OUT_OF_REACH if message else Status.FAILED
            return failed_curve(
                theta=solved.theta,
                eta=solved.eta,
                method=solved.method,
                message=message or NO_MAXIMUM,
                status=status,
            )
        x0_lock = mu_lock = np.nan
    locks = not np.isnan(mu_lock)
    touch = _first_touch(pieces, extremes)
    return StickingCurve(
        theta=solved.theta,
        eta=solved.eta,
        method=solved.method,
        status=Status.SOLVED if locks else Status.OUT_OF_REACH,
        message="" if locks else message,
        x1_init=solved.x1_init,
        pieces=tuple(pieces),
        pulled=tuple(solved.pulled),
        section=solved.section,
        residual=solved.residual,
        x0_lock=x0_lock,
        mu_lock=mu_lock,
        x0_touch=touch if touch <= (x0_lock if locks else pieces[-1].last_x0) else np.nan,
        end=end,
        end_message=solved.no_end if end is End.NOT_FOLLOWED else message,
    )


def _until_end(solved: Sequence[Solved]) -> list[_Kept]:
    """Cut pieces off at the first event that ends their curve."""
    pieces = PieceArray(pieces=tuple(piece for one in solved for piece in one.pieces))
    found = {
        End.SWINGS_ASIDE: _passes_under(solved, pieces),
        End.SNAPS: pieces.turning_points(),
        End.LIFTS_OFF: _lifts(pieces),
    }
    ends, cuts = [], {}
    for one, rows in zip(solved, _rows([one.pieces for one in solved]), strict=True):
        kept: list[int] = []
        first = Event(np.inf, End.SNAPS if one.turned else End.NOT_FOLLOWED)
        shown = one.events or [()] * len(one.pieces)
        for row, some in zip(range(rows.start, rows.stop), shown, strict=True):
            events = [*some, *(Event(at[row], end) for end, at in found.items())]
            known = [event for event in events if np.isfinite(event.at)]
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
        _Kept([cut.get(row, pieces.pieces[row]) for row in kept], first.end, first.reason)
        for kept, first in ends
    ]


def _lifts(pieces: PieceArray) -> FloatArray:
    """Where on each piece the surface would have to pull from there on; NaN where nowhere."""
    lifts = np.full(len(pieces.pieces), np.nan)
    rows = np.flatnonzero(pieces.samples.reaction_fy.max(axis=1, initial=-np.inf) >= 0.0)
    fy = pieces.samples.reaction_fy
    lifts[rows] = pieces.first(rows, fy, np.zeros(len(rows)), {"reaction_fy": 1.0})
    return lifts


def _passes_under(solved: Sequence[Solved], pieces: PieceArray) -> FloatArray:
    """Where clamps pass under the contact point, x0 = x1_init − (1 − s_c); NaN if nowhere."""
    x1_init = np.array(
        [one.x1_init if one.passes_under else np.nan for one in solved for _ in one.pieces]
    )
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
        sampled = np.where(ahead, pieces.samples.friction_demand, -np.inf)
        states = pieces.at(rows, pieces.largest(rows, sampled, _FORCE, _demand_slope))
        top, demand = states.x0, np.where(states.reaction_fx <= 0.0, states.friction_demand, 0.0)
    rows = np.flatnonzero(~pieces.line)
    at = pieces.first(rows, -pieces.samples.phi1, np.zeros(len(rows)), {"phi1": 1.0})
    rows, at = rows[np.isfinite(at)], at[np.isfinite(at)]
    if len(rows):
        touch[rows] = pieces.at(rows, at).x0
    touch[pieces.line] = pieces.first_x0[pieces.line]
    return _Extremes(top=top, demand=demand, touch=touch)


def _lock(kept: _Kept, extremes: _Extremes) -> tuple[float, float]:
    """Locate where −tan α is largest on a curve, and its value there.

    Where the tip lifts off while it is pulled back, −tan α is infinite.
    """
    pieces, end, _ = kept
    if not pieces:
        return np.nan, -np.inf
    if end is End.LIFTS_OFF and pieces[-1].states.reaction_fx[-1] < 0.0:
        return pieces[-1].last_x0, np.inf
    row = int(np.argmax(extremes.demand))
    x0_lock = float(extremes.top[row])
    # A maximum in a kink belongs to both pieces: put it where the second one begins.
    for piece in pieces[1:]:
        if abs(piece.first_x0 - x0_lock) <= SAME:
            x0_lock = piece.first_x0
    return x0_lock, float(extremes.demand[row])


def _first_touch(pieces: Sequence[Piece], extremes: _Extremes) -> float:
    """First displacement at which φ1 = 0 on a curve; NaN if there is none."""
    lying = [piece.contact is Contact.LINE for piece in pieces]
    touches = extremes.touch[: len(pieces)]
    # Where the rod lies down, it touches the surface for the first time.
    sought = touches[lying] if any(lying) else touches[np.isfinite(touches)]
    return float(sought[0]) if len(sought) else np.nan
