"""The sticking curve: every state between α = 0 and locking, for one (θ, η).

While the tip sticks, x1 and η are fixed and only the footpoint displacement x0 changes, so the
equilibria form one curve, parametrised by x0. Friction enters afterwards: μ0 decides where on the
curve sticking ends (the onset, −tan α = μ0) and a step Δx0 only samples it. The largest value of
−tan α on the curve is the locking friction μ_lock: above it the tip never slips forward. Where the
surface would have to pull before −tan α has a maximum, the tip lifts off: then −tan α grows without
limit and there is no locking. Where the contact changes its kind the curve has a kink: it consists
of smooth pieces.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.errors import ArgumentError
from vibrissa.mechanics.mounting import IDEAL, Mounting
from vibrissa.numerics.arrays import FloatArray, IntArray
from vibrissa.outcomes import Contact, End, RodSection, Status
from vibrissa.sticking.piece import Piece, PieceArray, StickingState
from vibrissa.sticking.reading import CurveArray, mirrored

# Displacements that are nearer to each other are one: where two pieces meet, and at the end. A
# shorter piece is none.
SAME = 1e-12
# Curves that should be put beside each other at most: their samples take some 10 MB.
CURVES_AT_ONCE = 256
NO_MAXIMUM = "the curve has no locking maximum where sought"
NOT_IN_PLANE = (
    "the rod leaves its plane with alpha = 0 already; try section: planar, a smaller eta, or a "
    "curvature that is less towards the surface"
)


class Limit(NamedTuple):
    """How far along a piece the shapes are admissible.

    Attributes
    ----------
    at : float
        Value of the piece's parameter at which they stop being so; NaN if nowhere.
    reason : str
        In what way.
    """

    at: float = np.nan
    reason: str = ""


@dataclass(frozen=True, eq=False, kw_only=True)
class StickingCurve:
    """One period of sticking of one rod at one height, and on past the lock.

    Build one with `vibrissa.solve_curve`; `assembled_curves` builds some from solved states.

    Attributes
    ----------
    theta, eta : float
        Taper factor and height of the contact point in the α = 0 state (L).
    mounting : Mounting
        How the rod is mounted.
    method : str
        ``collocation`` (states at Chebyshev points) or ``shooting`` (states on a step grid).
    status : Status
        ``solved``, ``failed``, or ``out_of_reach`` if the shape becomes inadmissible before the
        tip could lock; then the curve has states up to there, if there are any.
    message : str
        Empty, or what went wrong and what to try.
    x1_init : float
        Contact point in the α = 0 state, with the clamp at x = 0 (L).
    pieces : tuple of Piece
        Smooth pieces of the curve, in order.
    pulled : tuple of Piece
        Smooth pieces at x0 < 0, where the clamp pulls the tip, in the order of x0; empty where the
        section is planar, the mounting not ideal, or they were not solved.
    section : RodSection
    residual : float
        Largest equilibrium residual of the states, between the solved ones included.
    x0_lock, mu_lock : float
        Where −tan α is largest, and its value there; where the tip lifts off (fy = 0), and
        infinity, if it does so before.
    x0_touch : float
        First displacement at which φ1 = 0, where the rod comes to lie along the surface; NaN if
        this does not happen before locking, 0 if it lies on it from the start.
    end : End
        Why the curve ends: a round rod ``swings_aside`` where the clamp passes under the contact
        point (in another mounting than the ideal one: where the margin out of the plane vanishes),
        a planar one ``snaps`` where the branch turns back in x0, the shape goes
        ``out_of_reach``, the tip ``lifts_off`` instead of locking, or it was ``not_followed``.
    end_message : str
        More about it, where there is more to say.
    """

    theta: float
    eta: float
    method: str
    status: Status
    message: str = ""
    x1_init: float = np.nan
    pieces: tuple[Piece, ...] = field(default=(), repr=False)
    pulled: tuple[Piece, ...] = field(default=(), repr=False)
    section: RodSection = RodSection.ROUND
    residual: float = np.nan
    x0_lock: float = np.nan
    mu_lock: float = np.nan
    x0_touch: float = np.nan
    end: End = End.NOT_FOLLOWED
    end_message: str = ""
    mounting: Mounting = IDEAL

    def contact_point(self, x0: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Position of the tip, seen from the clamp, after displacements of the clamp.

        In line contact it is where the tip would be if the rod beyond the contact point were laid
        along the surface.

        Parameters
        ----------
        x0 : array_like
            Displacements (L).

        Returns
        -------
        x, y : ndarray
            Position (L), of the shape of `x0`.
        """
        x0, stage_angle = np.asarray(x0, dtype=float), self.mounting.stage_angle
        return self.x1_init - x0 * np.cos(stage_angle), self.eta - x0 * np.sin(stage_angle)

    @property
    def x0_end(self) -> float:
        """Last displacement of the curve (L); NaN where it has no states."""
        return self.pieces[-1].last_x0 if self.pieces else np.nan

    def _need_states(self, what: str) -> None:
        if not self.pieces:
            raise ArgumentError(f"no {what} a curve with status {self.status}: {self.message}")

    @property
    def x0_pull(self) -> float:
        """First displacement of the curve (L), not above 0: down to it pulled states are known."""
        return self.pulled[0].first_x0 if self.pulled else 0.0

    @cached_property
    def _alone(self) -> CurveArray:
        """The curve as an array of one."""
        return beside([self])

    def contact(self, x0: ArrayLike) -> list[str]:
        """Kind of contact at given displacements on the curve; empty at NaN."""
        x0 = np.atleast_1d(np.asarray(x0, dtype=float))
        if not self.pieces:
            return [""] * len(x0)
        return self._alone.contact(_first(x0), x0)

    def state(self, x0: ArrayLike) -> StickingState:
        """Sticking state at the given footpoint displacements.

        Parameters
        ----------
        x0 : array_like
            Displacements between `x0_pull` and the curve's end, in units of L.

        Returns
        -------
        StickingState
            Arrays of the shape of `x0`.

        Raises
        ------
        ArgumentError
            If the curve was not solved or a displacement lies outside it.

        Examples
        --------
        >>> from vibrissa import solve_curve
        >>> state = solve_curve(theta=2, eta=0.85).state(0.05)
        >>> print(f"{state.reaction_fx:.4f} {state.reaction_fy:.4f} {state.reaction_m:.4f}")
        -0.8806 -2.2418 -0.0750
        """
        self._need_states("states on")
        x0 = np.asarray(x0, dtype=float)
        if np.any(~(x0 >= self.x0_pull)) or np.any(~(x0 <= self.x0_end + SAME)):
            raise ArgumentError(
                f"x0 must lie on the curve, between {self.x0_pull:.6g} and {self.x0_end:.6g}; got "
                f"{x0!r}"
            )
        states = self._alone.states(_first(x0.ravel()), x0.ravel())
        return states.each(lambda values: values.reshape(x0.shape))

    def friction_demand(self, x0: ArrayLike) -> FloatArray:
        """Friction coefficient −tan α that sticking needs at the given displacements.

        Parameters
        ----------
        x0 : array_like
            Displacements on the curve, in units of L.

        Returns
        -------
        ndarray
            Infinite where the tip lifts off.
        """
        return self.state(x0).friction_demand

    def onset(self, mu0: ArrayLike) -> FloatArray:
        """Exact onset of slip: the first displacement at which −tan α = μ0.

        Parameters
        ----------
        mu0 : array_like
            Coefficients of static friction, positive.

        Returns
        -------
        ndarray
            Displacements x0_slip in units of L; NaN where μ0 > μ_lock, as the tip locks, or where
            the curve ends before.

        Raises
        ------
        ArgumentError
            If the curve was not solved or a coefficient is not positive.

        Examples
        --------
        >>> from vibrissa import solve_curve
        >>> print(solve_curve(theta=2, eta=0.85).onset([0.2, 0.4, 0.5]).round(6))
        [0.013232 0.052838      nan]
        """
        mu0 = np.asarray(mu0, dtype=float)
        if np.any(~(mu0 > 0.0)):
            raise ArgumentError(f"mu0 must be positive, got {mu0!r}")
        self._need_states("onset on")
        return self._alone.onset(_first(mu0.ravel()), mu0.ravel()).reshape(mu0.shape)

    def motion_end(self, mu0: ArrayLike) -> tuple[list[End], StickingState]:
        """How and where sticking ends that goes on past the lock.

        Parameters
        ----------
        mu0 : array_like
            Coefficients of static friction, larger than μ_lock.

        Returns
        -------
        ends : list of End
            ``slips_back`` where tan α reaches +μ0 on the curve, the curve's own end otherwise.
        states : StickingState
            The states there; NaN where the curve was not followed.

        Raises
        ------
        ArgumentError
            If the curve was not solved or a coefficient is not larger than μ_lock.
        """
        self._need_states("end of")
        if self.status is not Status.SOLVED:
            raise ArgumentError(f"the curve does not lock: {self.message}")
        mu0 = np.atleast_1d(np.asarray(mu0, dtype=float))
        if np.any(~(mu0 > self.mu_lock)):
            raise ArgumentError(f"past the lock mu0 is larger than {self.mu_lock:.6g}, got {mu0!r}")
        return self._alone.motion_end(_first(mu0), mu0)

    def trailing_end(self, mu0: ArrayLike) -> StickingState:
        """Last sticking state of a rod that has swung aside and trails behind its clamp.

        It goes back through its own states, mirrored, until the pulled tip slips.

        Parameters
        ----------
        mu0 : array_like
            Coefficients of static friction, larger than μ_lock.

        Returns
        -------
        StickingState
            With the displacement of the clamp since α = 0 before the swing; NaN where the rod does
            not swing aside or the pulled states are not known.
        """
        mu0 = np.atleast_1d(np.asarray(mu0, dtype=float))
        return self._alone.trailing_end(_first(mu0), mu0)

    def mirrored(self, states: StickingState) -> StickingState:
        """States after the rod has swung aside that were, or could be, passed before.

        Parameters
        ----------
        states : StickingState
            States at x0 up to that of the swing, negative where the clamp pulls.

        Returns
        -------
        StickingState
            Their mirror images, with the displacement of the clamp at which they come.
        """
        return mirrored(states, self.x0_end)


def beside(curves: Sequence[StickingCurve]) -> CurveArray:
    """Put curves side by side, so that places on all of them are asked together."""
    pulled = np.array([len(curve.pulled) for curve in curves], dtype=np.int64)
    count = pulled + np.array([len(curve.pieces) for curve in curves], dtype=np.int64)
    stop = np.cumsum(count)
    return CurveArray(
        pieces=PieceArray(
            pieces=tuple(piece for curve in curves for piece in (*curve.pulled, *curve.pieces))
        ),
        begin=stop - count,
        pushed=stop - count + pulled,
        stop=stop,
        x0_lock=np.array([curve.x0_lock for curve in curves]),
        mu_lock=np.array([curve.mu_lock for curve in curves]),
        end=[curve.end for curve in curves],
        status=[curve.status for curve in curves],
    )


def _first(rows: FloatArray) -> IntArray:
    """Return the number of the only curve, for each row."""
    return np.zeros(len(rows), dtype=np.int64)


_FORCE = ("reaction_fx", "reaction_fy")
# Linear forms of states, see `vibrissa.sticking.piece.Form`.


def _over_clamp(level: FloatArray) -> Mapping[str, float]:
    return {"x0": 1.0, "s_c": -1.0}


def _normal_force(level: FloatArray) -> Mapping[str, float]:
    return {"reaction_fy": 1.0}


def _contact_slope(level: FloatArray) -> Mapping[str, float]:
    return {"phi1": 1.0}


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
    limits : sequence of Limit
        For each piece, how far its shapes are admissible; without any, all are.
    pulled : sequence of Piece
        Pieces at x0 < 0, in the order of x0.
    section : RodSection
    swings : sequence of float, optional
        For each piece, where on it a round rod leaves its plane, NaN where it does not; without
        them it does so where the clamp passes under the contact point, as in the ideal mounting.
    no_end : str
        What to say if the pieces do not lead to an end.
    """

    theta: float
    eta: float
    method: str
    x1_init: float
    pieces: Sequence[Piece]
    residual: float
    limits: Sequence[Limit] = ()
    pulled: Sequence[Piece] = ()
    section: RodSection = RodSection.ROUND
    swings: Sequence[float] | None = None
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
    lift : ndarray, shape (pieces,)
        Where the tip lifts off.
    top, demand : ndarray, shape (pieces,)
        Where −tan α is largest, and its value there.
    touch : ndarray, shape (pieces,)
        Where the rod first touches the surface tangentially.
    """

    lift: FloatArray
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
    x0_lock, mu_lock, pieces = _lock(pieces, extremes)
    if mu_lock == np.inf:
        end, message = End.LIFTS_OFF, ""
    elif not pieces or not (0.0 < x0_lock < pieces[-1].last_x0 or end is End.SWINGS_ASIDE):
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
    """Cut pieces off where rods swing aside, turn back in x0 or become inadmissible."""
    pieces = PieceArray(pieces=tuple(piece for one in solved for piece in one.pieces))
    swings, turns = _swings(solved, pieces), np.full(len(pieces.pieces), np.nan)
    advances = np.flatnonzero(~pieces.by_x0)
    turns[advances] = pieces.turning_points(advances)
    ends, cuts = [], {}
    for one, rows in zip(solved, _rows([one.pieces for one in solved]), strict=True):
        end, message = End.NOT_FOLLOWED, ""
        kept: list[int] = []
        limits = one.limits or [Limit()] * len(one.pieces)
        for row, limit in zip(range(rows.start, rows.stop), limits, strict=True):
            piece, over = pieces.pieces[row], float(swings[row])
            stop = float(np.nanmin([limit.at, turns[row], over, np.inf]))
            if stop > piece.start + SAME:
                kept.append(row)
                if stop < piece.stop:
                    cuts[row] = stop
            if stop == limit.at:
                end, message = End.OUT_OF_REACH, limit.reason
            elif stop == over:
                end, message = End.SWINGS_ASIDE, "" if kept else NOT_IN_PLANE
            elif not np.isinf(stop):
                end = End.SNAPS
            if end is not End.NOT_FOLLOWED:
                break
        ends.append((kept, end, message))
    shorter = pieces.restricted(np.array([*cuts], dtype=np.int64), np.array([*cuts.values()]))
    cut = dict(zip(cuts, shorter, strict=True))
    return [
        _Kept([cut.get(row, pieces.pieces[row]) for row in kept], end, message)
        for kept, end, message in ends
    ]


def _swings(solved: Sequence[Solved], pieces: PieceArray) -> FloatArray:
    """Where round rods leave their plane on each piece; NaN where they do not."""
    swings = np.full(len(pieces.pieces), np.nan)
    x1_init = np.full(len(pieces.pieces), np.nan)
    for one, rows in zip(solved, _rows([one.pieces for one in solved]), strict=True):
        if one.section is RodSection.ROUND and one.swings is None:
            x1_init[rows] = one.x1_init
        elif one.section is RodSection.ROUND:
            swings[rows] = one.swings
    sought = np.flatnonzero(np.isfinite(x1_init))
    swings[sought] = _passes_under(pieces, sought, x1_init[sought])
    return swings


def _passes_under(pieces: PieceArray, of: IntArray, x1_init: FloatArray) -> FloatArray:
    """Where clamps pass under the contact point, x0 = x1_init − (1 − s_c); NaN if nowhere."""
    # In tip contact that is x1_init itself. A piece may end there, up to rounding.
    start, stop = pieces.start[of], pieces.stop[of]
    inside = (start <= x1_init) & (x1_init <= stop + SAME)
    at = np.where(inside, np.minimum(x1_init, stop), np.nan)
    sought = np.flatnonzero(pieces.line[of] | ~pieces.by_x0[of])
    if len(sought):
        level, way = x1_init[sought] - 1.0, pieces.samples.x0 - pieces.samples.s_c
        at[sought] = pieces.first(of[sought], way, level, _over_clamp, value=level)
    return at


def _extremes(pieces: PieceArray) -> _Extremes:
    """Find where tips lift off, where −tan α is largest, and where rods touch the surface."""
    lift, top, demand, touch = np.full((4, len(pieces.pieces)), np.nan)
    # In the α = 0 state, where fx = 0, the surface pushes.
    pulled = np.where(pieces.samples.reaction_fx < 0.0, pieces.samples.reaction_fy, -np.inf)
    lifts = pieces.by_x0 & (pulled.max(axis=1, initial=-np.inf) >= 0.0)
    rows = np.flatnonzero(lifts)
    lift[rows] = pieces.first(rows, pulled, np.zeros(len(rows)), _normal_force)
    rows = np.flatnonzero(pieces.by_x0 & ~lifts)
    if len(rows):
        sampled = pieces.samples.friction_demand[rows]
        top[rows] = pieces.largest(rows, sampled, _FORCE, _demand_slope)
        demand[rows] = pieces.at(rows, top[rows]).friction_demand
    rows = np.flatnonzero(~pieces.line)
    at = pieces.first(rows, -pieces.samples.phi1, np.zeros(len(rows)), _contact_slope)
    rows, at = rows[np.isfinite(at)], at[np.isfinite(at)]
    if len(rows):
        touch[rows] = pieces.at(rows, at).x0
    touch[pieces.line] = pieces.first_x0[pieces.line]
    return _Extremes(lift=lift, top=top, demand=demand, touch=touch)


def _lock(pieces: Sequence[Piece], extremes: _Extremes) -> tuple[float, float, Sequence[Piece]]:
    """Locate where −tan α is largest on a curve, and its value there.

    Where the tip lifts off −tan α is infinite, and nothing counts after that. The pieces up to
    there are returned.
    """
    x0_lock, mu_lock = np.nan, -np.inf
    for row, (lift, top, demand, _) in enumerate(zip(*extremes, strict=True)):
        if np.isfinite(lift):
            (last,) = pieces[row].alone.restricted(np.zeros(1, dtype=np.int64), np.array([lift]))
            return float(lift), np.inf, [*pieces[:row], last]
        if demand > mu_lock:
            x0_lock, mu_lock = float(top), float(demand)
    # A maximum in a kink belongs to both pieces: put it where the second one begins.
    for piece in pieces[1:]:
        if abs(piece.first_x0 - x0_lock) <= SAME:
            x0_lock = piece.first_x0
    return x0_lock, mu_lock, pieces


def _first_touch(pieces: Sequence[Piece], extremes: _Extremes) -> float:
    """First displacement at which φ1 = 0 on a curve; NaN if there is none."""
    lying = [piece.contact is Contact.LINE for piece in pieces]
    touches = extremes.touch[: len(pieces)]
    # Where the rod lies down, it touches the surface for the first time.
    sought = touches[lying] if any(lying) else touches[np.isfinite(touches)]
    return float(sought[0]) if len(sought) else np.nan


def failed_curve(
    *, theta: float, eta: float, method: str, message: str, status: Status = Status.FAILED
) -> StickingCurve:
    """Curve without states; it carries the reason.

    Parameters
    ----------
    theta, eta : float
        Taper factor and height of the contact point (L).
    method : str
        Solver that was used.
    message : str
        What went wrong and what to try.
    status : Status
        ``failed`` or ``out_of_reach``.

    Returns
    -------
    StickingCurve
    """
    return StickingCurve(
        theta=theta, eta=eta, method=method, status=status, message=message, end_message=message
    )
