"""The sticking curve: every state between α = 0 and locking, for one (θ, η).

While the tip sticks, x1 and η are fixed and only the footpoint displacement x0 changes, so the
equilibria form one curve, parametrised by x0. Friction enters afterwards: μ0 decides where on the
curve sticking ends (the onset, −tan α = μ0) and a step Δx0 only samples it. The largest value of
−tan α on the curve is the locking friction μ_lock: above it the tip never slips forward. Where the
surface would have to pull before −tan α has a maximum, the tip lifts off: then −tan α grows without
limit and there is no locking. Where the contact changes its kind the curve has a kink: it consists
of smooth pieces.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.errors import ArgumentError
from vibrissa.mechanics.mounting import IDEAL, Mounting
from vibrissa.numerics.arrays import FloatArray, IntArray
from vibrissa.outcomes import Contact, End, Parameter, RodSection, Status
from vibrissa.sticking.piece import Piece, StickingState

# Displacements that are nearer to each other are one: where two pieces meet, and at the end. A
# shorter piece is none.
SAME = 1e-12
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

    Build one with `vibrissa.solve_curve`; `sticking_curve` builds one from solved states.

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

    @property
    def _all(self) -> tuple[Piece, ...]:
        return (*self.pulled, *self.pieces)

    def _piece_of(self, x0: FloatArray) -> IntArray:
        """Which piece each displacement lies on."""
        inner = [piece.first_x0 for piece in self._all[1:]]
        return np.searchsorted(inner, x0, side="right")

    def contact(self, x0: ArrayLike) -> list[str]:
        """Kind of contact at given displacements on the curve; empty at NaN."""
        x0 = np.atleast_1d(np.asarray(x0, dtype=float))
        if not self.pieces:
            return [""] * len(x0)
        kinds = np.array([piece.contact.value for piece in self._all])
        return list(np.where(np.isnan(x0), "", kinds[self._piece_of(x0)]).tolist())

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
        place = self._piece_of(x0)
        found = np.unique(place)
        if x0.ndim == len(found) == 1:
            piece = self._all[found[0]]
            return replace(piece.at_x0(np.minimum(x0, piece.last_x0)), x0=x0)
        states = StickingState.unknown(x0.shape)
        for index in found:
            on_piece, piece = place == index, self._all[index]
            states.put(on_piece, piece.at_x0(np.minimum(x0[on_piece], piece.last_x0)))
        return replace(states, x0=x0)

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
        onset = np.full(mu0.shape, np.nan)
        for piece in self.pieces:
            # A curve without a lock ends before it.
            sought = ~(mu0 > self.mu_lock) & np.isnan(onset)
            if piece.first_x0 > self.x0_lock or not sought.any():
                break
            t, demand = self._demand_up_to_the_lock(piece)
            onset[sought] = piece.first(demand, mu0[sought], _slips_ahead, places=t)
        return onset

    def outcomes(self, mu0: FloatArray) -> tuple[FloatArray, list[Status]]:
        """Exact onset of slip, and what becomes of the tip, also on a curve without states.

        Parameters
        ----------
        mu0 : ndarray, shape (n,)
            Coefficients of static friction, positive.

        Returns
        -------
        x0_slip : ndarray, shape (n,)
            Displacements in units of L; NaN where there is no onset.
        status : list of Status
            ``slip``, ``lock``, or what the curve has instead of states.
        """
        x0_slip = self.onset(mu0) if self.pieces else np.full(mu0.shape, np.nan)
        otherwise = Status.LOCK if self.status is Status.SOLVED else self.status
        return x0_slip, [Status.SLIP if slips else otherwise for slips in np.isfinite(x0_slip)]

    def states_where_known(self, x0: FloatArray) -> StickingState:
        """States at the displacements that are not NaN; NaN elsewhere."""
        states, known = StickingState.unknown(x0.shape), np.isfinite(x0)
        if known.all():
            return self.state(x0)
        if known.any():
            states.put(known, self.state(x0[known]))
        return states

    def _demand_up_to_the_lock(self, piece: Piece) -> tuple[FloatArray, FloatArray]:
        """Sample −tan α on a piece; the last value is μ_lock where the tip locks on it."""
        t, demand = piece.sample_places, piece.samples.friction_demand
        before = int(np.searchsorted(piece.samples.x0, self.x0_lock))
        if before == len(t):
            return t, demand
        lock = piece.start + self.x0_lock - piece.first_x0
        return np.append(t[:before], lock), np.append(demand[:before], self.mu_lock)

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
        states = StickingState.unknown(len(mu0))
        if self.end is not End.NOT_FOLLOWED:
            last = self.pieces[-1].states.take(np.array([-1]))
            states.put(slice(None), last)
        slips_back = np.zeros(len(mu0), dtype=bool)
        for piece in self.pieces:
            # Before the lock tan α is negative.
            past = piece.samples.x0 >= self.x0_lock
            alpha = np.where(past, piece.samples.alpha, -np.pi)
            at = piece.first(alpha, np.arctan(mu0), _slips_back)
            slips = ~slips_back & np.isfinite(at)
            if slips.any():
                states.put(slips, piece.at(at[slips]))
            slips_back |= slips
        return [End.SLIPS_BACK if slips else self.end for slips in slips_back], states

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
        states = StickingState.unknown(len(mu0))
        if self.end is not End.SWINGS_ASIDE:
            return states
        # The part next to α = 0 comes first for the tip.
        for piece in reversed(self.pulled):
            at = piece.first(-piece.samples.alpha, -np.arctan(mu0), _slips_pulled)
            # Where not even the first sample demands more, an earlier part does.
            slips = (at > piece.start) & np.isnan(states.x0)
            states.put(slips, piece.at(at[slips]))
        return self.mirrored(states)

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
        return replace(
            states,
            x0=2.0 * self.x0_end - states.x0,
            reaction_fx=-states.reaction_fx,
            reaction_m=-states.reaction_m,
            phi1=np.pi - states.phi1,
        )


_FORCE = ("reaction_fx", "reaction_fy")
# Linear forms of states, see `Form`.


def _slips_ahead(mu0: FloatArray) -> Mapping[str, FloatArray | float]:
    # Has the sign of −tan α − μ0 as long as the surface pushes.
    return {"reaction_fy": mu0, "reaction_fx": -1.0}


def _slips_back(alpha: FloatArray) -> Mapping[str, FloatArray | float]:
    return {"reaction_fy": np.tan(alpha), "reaction_fx": 1.0}


def _slips_pulled(alpha: FloatArray) -> Mapping[str, FloatArray | float]:
    # As `_slips_back`, but for the level −α.
    return _slips_back(-alpha)


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


def assembled_curve(
    *,
    theta: float,
    eta: float,
    method: str,
    x1_init: float,
    pieces: Sequence[Piece],
    residual: float,
    limits: Sequence[Limit] = (),
    pulled: Sequence[Piece] = (),
    section: RodSection = RodSection.ROUND,
    swings: Sequence[float] | None = None,
    no_end: str = "",
) -> StickingCurve:
    """Build a curve from solved pieces: locate its lock, its first contact along a line, its end.

    Parameters
    ----------
    theta, eta : float
        Taper factor and height of the contact point (L).
    method : str
        ``collocation`` or ``shooting``.
    x1_init : float
        Contact point in the α = 0 state (L).
    pieces : sequence of Piece
        From displacement 0 to beyond the lock, each beginning where the one before ends; then
        those counted by the advance, to beyond where x0 turns back.
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

    Returns
    -------
    StickingCurve
        ``failed`` if −tan α has no maximum inside the given displacements, ``out_of_reach`` and up
        to there if the shape becomes inadmissible before.
    """
    if section is RodSection.PLANAR:
        swings = [np.nan] * len(pieces)
    elif swings is None:
        swings = [_passes_under(piece, x1_init) for piece in pieces]
    kept, end, message = _until_end(pieces, limits or [Limit()] * len(pieces), swings)
    x0_lock, mu_lock, kept = _lock(kept)
    if mu_lock == np.inf:
        end, message = End.LIFTS_OFF, ""
    elif not kept or not (0.0 < x0_lock < kept[-1].last_x0 or end is End.SWINGS_ASIDE):
        if end is not End.OUT_OF_REACH or not kept:
            status = Status.OUT_OF_REACH if message else Status.FAILED
            why = message or NO_MAXIMUM
            return failed_curve(theta=theta, eta=eta, method=method, message=why, status=status)
        x0_lock = mu_lock = np.nan
    locks = not np.isnan(mu_lock)
    return StickingCurve(
        theta=theta,
        eta=eta,
        method=method,
        status=Status.SOLVED if locks else Status.OUT_OF_REACH,
        message="" if locks else message,
        x1_init=x1_init,
        pieces=tuple(kept),
        pulled=tuple(pulled),
        section=section,
        residual=residual,
        x0_lock=x0_lock,
        mu_lock=mu_lock,
        x0_touch=_first_touch(kept, x0_lock if locks else kept[-1].last_x0),
        end=end,
        end_message=no_end if end is End.NOT_FOLLOWED else message,
    )


def _until_end(
    pieces: Sequence[Piece], limits: Sequence[Limit], swings: Sequence[float]
) -> tuple[list[Piece], End, str]:
    """Cut pieces off where the rod swings aside, turns back in x0 or becomes inadmissible."""
    kept: list[Piece] = []
    for piece, limit, over in zip(pieces, limits, swings, strict=True):
        turn = piece.turning_point() if piece.parameter is Parameter.ADVANCE else np.nan
        stop = float(np.nanmin([limit.at, turn, over, np.inf]))
        if np.isinf(stop):
            kept.append(piece)
            continue
        if stop > piece.start + SAME:
            kept.append(piece.restricted(stop) if stop < piece.stop else piece)
        if stop == limit.at:
            return kept, End.OUT_OF_REACH, limit.reason
        if stop == over:
            return kept, End.SWINGS_ASIDE, "" if kept else NOT_IN_PLANE
        return kept, End.SNAPS, ""
    return kept, End.NOT_FOLLOWED, ""


def _passes_under(piece: Piece, x1_init: float) -> float:
    """Where the clamp passes under the contact point, x0 = x1_init − (1 − s_c); NaN if nowhere."""
    if piece.contact is Contact.POINT and piece.parameter is Parameter.X0:
        # A piece may end there, up to rounding.
        inside = piece.start <= x1_init <= piece.stop + SAME
        return min(x1_init, piece.stop) if inside else np.nan
    level, way = np.array([x1_init - 1.0]), piece.samples.x0 - piece.samples.s_c
    return float(piece.first(way, level, _over_clamp, value=level)[0])


def _lock(pieces: Sequence[Piece]) -> tuple[float, float, list[Piece]]:
    """Locate where −tan α is largest, and its value there.

    Where the tip lifts off −tan α is infinite, and nothing counts after that. The pieces up to
    there are returned.
    """
    x0_lock, mu_lock = np.nan, -np.inf
    for index, piece in enumerate(pieces):
        if piece.parameter is not Parameter.X0:
            break
        # In the α = 0 state, where fx = 0, the surface pushes.
        pulled = np.where(piece.samples.reaction_fx < 0.0, piece.samples.reaction_fy, -np.inf)
        if pulled.max() >= 0.0:
            lift = float(piece.first(pulled, np.zeros(1), _normal_force)[0])
            return lift, np.inf, [*pieces[:index], piece.restricted(lift)]
        top = piece.largest(piece.samples.friction_demand, _FORCE, _demand_slope)
        demand = float(piece.at(np.array(top)).friction_demand)
        if demand > mu_lock:
            x0_lock, mu_lock = top, demand
    # A maximum in a kink belongs to both pieces: put it where the second one begins.
    for piece in pieces[1:]:
        if abs(piece.first_x0 - x0_lock) <= SAME:
            x0_lock = piece.first_x0
    return x0_lock, mu_lock, list(pieces)


def _first_touch(pieces: Sequence[Piece], end: float) -> float:
    """First displacement up to `end` at which φ1 = 0; NaN if there is none."""
    lying = [piece.first_x0 for piece in pieces if piece.contact is Contact.LINE]
    touch = lying[0] if lying else np.nan
    for piece in pieces if not lying else ():
        at = piece.first(-piece.samples.phi1, np.zeros(1), _contact_slope)
        if np.isfinite(at).all():
            touch = float(piece.at(at).x0[0])
            break
    return touch if touch <= end else np.nan


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
