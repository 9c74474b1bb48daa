"""The sticking curve: every state between α = 0 and locking, for one (θ, η).

While the tip sticks, x1 and η are fixed and only the footpoint displacement x0 changes, so the
equilibria form one curve, parametrised by x0. Friction enters afterwards: μ0 decides where on the
curve sticking ends (the onset, −tan α = μ0) and a step Δx0 only samples it. The largest value of
−tan α on the curve is the locking friction μ_lock: above it the tip never slips forward. Where the
surface would have to pull before −tan α has a maximum, the tip lifts off: then −tan α grows without
limit and there is no locking. Where the
contact changes its kind the curve has a kink: it consists of smooth pieces.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.arrays import FloatArray, IntArray
from vibrissa.roots import bracketed_root
from vibrissa.spectral import (
    chebyshev_derivative,
    chebyshev_nodes,
    chebyshev_series,
    chebyshev_transform,
    even_interpolation,
)
from vibrissa.status import Contact, End, Parameter, Status

# Samples of each piece between which crossings are bracketed before they are located exactly.
SCAN_POINTS = 257
# Displacements that are nearer to each other are one: where two pieces meet.
KINK_TOLERANCE = 1e-12
# Columns of the values of a piece.
VALUES = 7
# Order of the spline through states on a step grid.
SPLINE_DEGREE = 5


class StickingState(NamedTuple):
    """What a sticking state shows, for one or many footpoint displacements.

    Attributes
    ----------
    x0 : ndarray
        Footpoint displacement since the α = 0 state, in units of L.
    f, alpha : ndarray
        Contact force magnitude (E·I0/L²) and inclination (rad).
    phi1 : ndarray
        Slope at the contact point, in rad.
    s_c : ndarray
        Arc length of the contact point, in units of L; 1 in point contact.
    reaction_fx, reaction_fy, reaction_m : ndarray
        Reading of a force-torque sensor under the clamp: f·sin α, −f·cos α (E·I0/L²) and
        φ'(0) (E·I0/L).
    stability : ndarray
        Least second variation of the energy per bending energy, clamp and contact point held:
        positive where the equilibrium is stable; NaN where the method does not tell.
    """

    x0: FloatArray
    f: FloatArray
    alpha: FloatArray
    phi1: FloatArray
    s_c: FloatArray
    reaction_fx: FloatArray
    reaction_fy: FloatArray
    reaction_m: FloatArray
    stability: FloatArray


def _state_of(values: FloatArray, x0: FloatArray) -> StickingState:
    """State from the values of a piece."""
    _, fx, fy, m, phi1, s_c, margin = np.moveaxis(values, -1, 0)
    return StickingState(x0, np.hypot(fx, fy), np.arctan2(fx, -fy), phi1, s_c, fx, fy, m, margin)


@dataclass(frozen=True, eq=False)
class Piece:
    """A smooth piece of a sticking curve, with one kind of contact.

    Attributes
    ----------
    contact : Contact
        Kind of contact of its states.
    parameter : Parameter
        What the states are counted by.
    start, stop : float
        First and last value of the parameter (x0 in L).
    values : ndarray, shape (k, 7)
        x0 (L), fx, fy (E·I0/L²), m (E·I0/L), φ1 (rad), s_c (L) and the margin of stability of the
        states; x0 increases.
    stepped : bool
        Whether the states stand on a step grid of x0; at Chebyshev points of the parameter
        otherwise.
    """

    contact: Contact
    parameter: Parameter
    start: float
    stop: float
    values: FloatArray
    stepped: bool = False

    def __post_init__(self) -> None:
        """Put the values in one order in memory: sums over them then round alike."""
        object.__setattr__(self, "values", np.ascontiguousarray(self.values))

    @property
    def x0(self) -> FloatArray:
        """Footpoint displacements of the states (L)."""
        return self.values[:, 0]

    @cached_property
    def _series(self) -> tuple[Any, Any, Any]:
        """Splines, or Chebyshev coefficients, of the values and up to two derivatives."""
        if self.stepped:
            # Not needed, and not waited for, where states are not stepped.
            from scipy.interpolate import make_interp_spline

            degree = min(SPLINE_DEGREE, len(self.values) - 1)
            # The margin of stability is not known on a step grid.
            spline = make_interp_spline(self.x0, np.nan_to_num(self.values), k=degree)
            return spline, spline.derivative(), spline.derivative(2)
        columns = [chebyshev_transform(len(self.values)) @ self.values]
        derivative = chebyshev_derivative(len(self.values)) * (2.0 / (self.stop - self.start))
        for _ in range(2):
            columns.append(np.hstack([columns[-1], derivative @ columns[-1][:, -VALUES:]]))
        return columns[0], columns[1], columns[2]

    def jet(self, t: FloatArray, order: int) -> FloatArray:
        """Values and derivatives at values of the parameter on the piece.

        Parameters
        ----------
        t : ndarray
            Values of the parameter.
        order : int
            Order of the highest derivative, up to 2.

        Returns
        -------
        ndarray, shape (order + 1,) + t.shape + (7,)
        """
        if self.stepped:
            jet = np.stack([series(t) for series in self._series[: order + 1]])
        else:
            position = 2.0 * (t - self.start) / (self.stop - self.start) - 1.0
            flat = chebyshev_series(self._series[order], position)
            jet = np.moveaxis(flat.reshape(*t.shape, order + 1, VALUES), -2, 0)
        # What is prescribed is known exactly.
        if self.parameter is Parameter.X0:
            jet[0, ..., 0] = t
        if self.contact is Contact.POINT:
            jet[0, ..., 5] = 1.0
        else:
            jet[0, ..., 4] = 0.0
        if self.stepped:
            jet[..., 6] = np.nan
        return np.asarray(jet)

    def at(self, t: FloatArray) -> FloatArray:
        """Values at values of the parameter on the piece, shape t.shape + (7,)."""
        return np.asarray(self.jet(t, 0)[0])

    def evaluate(self, x0: FloatArray) -> FloatArray:
        """Values at displacements on the piece, shape x0.shape + (7,)."""
        if self.parameter is Parameter.X0:
            return self.at(x0)
        t, values = self.scan
        after = np.clip(np.searchsorted(values[:, 0], x0), 1, len(t) - 1)

        def excess(t: FloatArray, x0: FloatArray) -> tuple[FloatArray, FloatArray]:
            value, slope = self.jet(t, 1)
            return value[..., 0] - x0, slope[..., 0]

        return self.at(bracketed_root(excess, t[after - 1], t[after], x0))

    @cached_property
    def scan(self) -> tuple[FloatArray, FloatArray]:
        """Equally spaced values of the parameter, and the values there, to bracket crossings."""
        t = np.linspace(self.start, self.stop, SCAN_POINTS)
        if self.stepped:
            return t, self.at(t)
        return t, even_interpolation(len(self.values), SCAN_POINTS) @ self.values

    def until(self, stop: float) -> "Piece":
        """Cut the piece off at a value of its parameter."""
        t = self.start + (stop - self.start) * chebyshev_nodes(len(self.values))
        return replace(self, stop=stop, values=self.at(t))


@dataclass(frozen=True, eq=False)
class StickingCurve:
    """One period of sticking of one rod at one height, and on past the lock.

    Build one with `vibrissa.solve_curve`; `sticking_curve` builds one from solved states.

    Attributes
    ----------
    theta, eta : float
        Taper factor and height of the contact point (L).
    method : str
        ``collocation`` (states at Chebyshev points) or ``shooting`` (states on a step grid).
    status : Status
        ``solved``, ``failed``, or ``out_of_reach`` if it ends before it could lock.
    message : str
        Empty, or what went wrong and what to try.
    x1_init : float
        Contact point in the α = 0 state, with the clamp at x = 0 (L).
    pieces : tuple of Piece
        Smooth pieces of the curve, in order.
    residual : float
        Largest equilibrium residual of the states, between the solved ones included.
    x0_lock, mu_lock : float
        Where −tan α is largest, and its value there; where the tip lifts off (fy = 0), and
        infinity, if it does so before.
    x0_touch : float
        First displacement at which φ1 = 0, where the rod comes to lie along the surface; NaN if
        this does not happen before locking, 0 if it lies on it from the start.
    end : End
        Why the curve ends: the rod ``snaps`` where the branch turns back in x0, the shape goes
        ``out_of_reach``, the tip ``lifts_off`` instead of locking, or it was ``not_followed``.
    end_message : str
        More about it, where there is more to say.
    """

    theta: float
    eta: float
    method: str
    status: Status
    message: str
    x1_init: float
    pieces: tuple[Piece, ...]
    residual: float
    x0_lock: float
    mu_lock: float
    x0_touch: float
    end: End
    end_message: str

    @property
    def x0_end(self) -> float:
        """Last displacement of the curve (L)."""
        return float(self.pieces[-1].x0[-1])

    def _piece_of(self, x0: FloatArray) -> IntArray:
        """Which piece each displacement lies on."""
        inner = [piece.x0[0] for piece in self.pieces[1:]]
        return np.searchsorted(inner, x0, side="right")

    def contact(self, x0: ArrayLike) -> list[str]:
        """Kind of contact at given displacements on the curve."""
        pieces = self._piece_of(np.atleast_1d(np.asarray(x0, dtype=float)))
        return [self.pieces[index].contact.value for index in pieces]

    def state(self, x0: ArrayLike) -> StickingState:
        """Sticking state at the given footpoint displacements.

        Parameters
        ----------
        x0 : array_like
            Displacements between 0 and the curve's end, in units of L.

        Returns
        -------
        StickingState
            Arrays of the shape of `x0`.

        Raises
        ------
        ValueError
            If the curve was not solved or a displacement lies outside it.
        """
        if self.status is not Status.SOLVED:
            raise ValueError(f"no states on a curve with status {self.status}: {self.message}")
        x0 = np.asarray(x0, dtype=float)
        if np.any(~(x0 >= 0.0)) or np.any(~(x0 <= self.x0_end)):
            raise ValueError(
                f"x0 must lie on the curve, between 0 and {self.x0_end:.6g}; got {x0!r}"
            )
        values = np.empty((*x0.shape, 7))
        place = self._piece_of(x0)
        for index, piece in enumerate(self.pieces):
            on_piece = place == index
            if np.any(on_piece):
                values[on_piece] = piece.evaluate(x0[on_piece])
        return _state_of(values, x0)

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
        state = self.state(x0)
        with np.errstate(divide="ignore"):
            return np.asarray(state.reaction_fx / state.reaction_fy)

    def onset(self, mu0: ArrayLike) -> FloatArray:
        """Exact onset of slip: the first displacement at which −tan α = μ0.

        Parameters
        ----------
        mu0 : array_like
            Coefficients of static friction, positive.

        Returns
        -------
        ndarray
            Displacements x0_slip in units of L; NaN where μ0 > μ_lock, as the tip locks.

        Raises
        ------
        ValueError
            If the curve was not solved or a coefficient is not positive.
        """
        mu0 = np.asarray(mu0, dtype=float)
        if np.any(~(mu0 > 0.0)):
            raise ValueError(f"mu0 must be positive, got {mu0!r}")
        if self.status is not Status.SOLVED:
            raise ValueError(f"no onset on a curve with status {self.status}: {self.message}")
        onset = np.full(mu0.shape, np.nan)
        open_ = mu0 <= self.mu_lock
        for piece in self.pieces:
            if piece.x0[0] > self.x0_lock or not open_.any():
                break
            t, values = piece.scan
            # The first sample that needs at least μ0: −tan α may fall again beyond.
            with np.errstate(divide="ignore", invalid="ignore"):
                demand = values[:, 1] / values[:, 2]
            up_to = int(np.searchsorted(values[:, 0], self.x0_lock))
            if up_to < len(t):
                t = np.append(t[:up_to], piece.start + self.x0_lock - piece.x0[0])
                demand = np.append(demand[:up_to], self.mu_lock)
            after = np.searchsorted(np.maximum.accumulate(demand), mu0)
            slips = open_ & (after < len(t))
            if slips.any():

                def excess(
                    t: FloatArray, mu0: FloatArray, piece: Piece = piece
                ) -> tuple[FloatArray, FloatArray]:
                    value, slope = piece.jet(t, 1)
                    # Has the sign of −tan α − μ0 as long as the surface pushes.
                    missing = mu0 * value[..., 2] - value[..., 1]
                    return missing, mu0 * slope[..., 2] - slope[..., 1]

                stop = np.maximum(after[slips], 1)
                low, high = t[stop - 1], t[stop]
                rise = demand[stop] - demand[stop - 1]
                with np.errstate(divide="ignore", invalid="ignore"):
                    share = np.clip((mu0[slips] - demand[stop - 1]) / rise, 0.0, 1.0)
                guess = low + np.nan_to_num(share) * (high - low)
                onset[slips] = bracketed_root(excess, low, high, mu0[slips], guess=guess)
                open_ &= ~slips
        return onset

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
        ValueError
            If the curve was not solved or a coefficient is not larger than μ_lock.
        """
        if self.status is not Status.SOLVED:
            raise ValueError(f"no end of a curve with status {self.status}: {self.message}")
        mu0 = np.atleast_1d(np.asarray(mu0, dtype=float))
        if np.any(~(mu0 > self.mu_lock)):
            raise ValueError(f"past the lock mu0 is larger than {self.mu_lock:.6g}, got {mu0!r}")
        values = np.full((len(mu0), 7), np.nan)
        if self.end is not End.NOT_FOLLOWED:
            values[:] = self.pieces[-1].values[-1]
        ends = [self.end] * len(mu0)
        open_ = np.ones(len(mu0), dtype=bool)
        for piece in self.pieces:
            t, known = piece.scan
            x0, fx, fy = known[:, :3].T
            # From the lock on: before it tan α is negative.
            inclination = np.where(x0 >= self.x0_lock, np.arctan2(fx, -fy), -np.pi)
            after = np.searchsorted(np.maximum.accumulate(inclination), np.arctan(mu0))
            slips = open_ & (after < len(t))
            if slips.any():
                after = np.maximum(after[slips], 1)

                def missing(
                    t: FloatArray, mu0: FloatArray, piece: Piece = piece
                ) -> tuple[FloatArray, FloatArray]:
                    value, slope = piece.jet(t, 1)
                    return (
                        value[..., 1] + mu0 * value[..., 2],
                        slope[..., 1] + mu0 * slope[..., 2],
                    )

                at = bracketed_root(missing, t[after - 1], t[after], mu0[slips])
                values[slips] = piece.at(at)
                ends = [End.SLIPS_BACK if s else e for s, e in zip(slips, ends, strict=True)]
                open_ &= ~slips
        return ends, _state_of(values, values[:, 0])


def sticking_curve(
    theta: float,
    eta: float,
    method: str,
    x1_init: float,
    pieces: Sequence[Piece],
    residual: float,
    reach: Sequence[tuple[float, str]] = (),
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
    reach : sequence of (float, str)
        For each piece the value of its parameter at which its shape leaves the model's reach, NaN
        if nowhere, and how.
    no_end : str
        What to say if the pieces do not lead to an end.

    Returns
    -------
    StickingCurve
        ``failed`` if −tan α has no maximum inside the given displacements, ``out_of_reach`` if the
        shape leaves the model's reach before.
    """
    pieces, end, message = _until_end(pieces, reach or [(np.nan, "")] * len(pieces))
    ahead = [piece for piece in pieces if piece.parameter is Parameter.X0]
    tops = [_largest_demand(piece) for piece in ahead]
    # The first of equal ones: after lifting off nothing counts.
    x0_lock, mu_lock = max(tops, key=lambda top: top[1], default=(np.nan, np.nan))
    if np.isinf(mu_lock):
        last = next(i for i, top in enumerate(tops) if np.isinf(top[1]))
        pieces = [*ahead[:last], ahead[last].until(x0_lock)]
        end, message = End.LIFTS_OFF, ""
    # A maximum in a kink belongs to both pieces: put it where the second one begins.
    kink = min(
        (piece.x0[0] for piece in pieces[1:]), key=lambda x: abs(x - x0_lock), default=np.nan
    )
    if abs(kink - x0_lock) <= KINK_TOLERANCE:
        x0_lock = float(kink)
    if end is not End.LIFTS_OFF and not (pieces and 0.0 < x0_lock < pieces[-1].x0[-1]):
        if end is End.OUT_OF_REACH:
            return failed_curve(theta, eta, method, message, Status.OUT_OF_REACH)
        return failed_curve(theta, eta, method, "the curve has no locking maximum where sought")
    return StickingCurve(
        theta,
        eta,
        method,
        Status.SOLVED,
        "",
        x1_init,
        tuple(pieces),
        residual,
        x0_lock,
        mu_lock,
        _first_touch(pieces, x0_lock),
        end,
        no_end if end is End.NOT_FOLLOWED else message,
    )


def _until_end(
    pieces: Sequence[Piece], reach: Sequence[tuple[float, str]]
) -> tuple[list[Piece], End, str]:
    """Cut pieces off where the branch turns back in x0 or the shape leaves the model's reach."""
    kept: list[Piece] = []
    for piece, (limit, how) in zip(pieces, reach, strict=True):
        turn = _turning_point(piece) if piece.parameter is Parameter.ADVANCE else np.nan
        stop = np.nanmin([limit, turn, np.inf])
        if np.isinf(stop):
            kept.append(piece)
            continue
        if stop > piece.start:
            kept.append(piece.until(float(stop)))
        if stop == limit:
            return kept, End.OUT_OF_REACH, how
        return kept, End.SNAPS, ""
    return kept, End.NOT_FOLLOWED, ""


def _turning_point(piece: Piece) -> float:
    """Where x0 stops increasing on a piece counted by the advance; NaN if nowhere."""
    t, values = piece.scan
    back = np.flatnonzero(np.diff(values[:, 0]) <= 0.0)
    if len(back):
        low, high = t[max(back[0] - 1, 0)], t[back[0] + 1]
    elif piece.jet(t[-1], 1)[1, 0] < 0.0:
        low, high = t[-2], t[-1]
    else:
        return float("nan")
    if piece.jet(low, 1)[1, 0] <= 0.0:
        return float(low)

    def slope(t: FloatArray) -> tuple[FloatArray, FloatArray]:
        _, slope, bend = piece.jet(t, 2)[..., 0]
        return slope, bend

    return _root(slope, low, high)


def _largest_demand(piece: Piece) -> tuple[float, float]:
    """Where −tan α is largest on a piece, and its value there; infinity where the tip lifts off."""
    x, values = piece.scan
    fx, fy = values[:, 1:3].T
    pulls = np.flatnonzero((fy >= 0.0) & (fx < 0.0))
    if len(pulls):
        return _crossing(piece, 2, x[max(pulls[0] - 1, 0)], x[pulls[0]]), np.inf

    def demand_slope(x: FloatArray) -> tuple[FloatArray, FloatArray]:
        (fx, fy), (fx_slope, fy_slope), (fx_bend, fy_bend) = (
            (values[..., 1], values[..., 2]) for values in piece.jet(x, 2)
        )
        return fx_slope * fy - fx * fy_slope, fx_bend * fy - fx * fy_bend

    top = int(np.argmax(fx / fy))
    at = float(x[top])
    # At an end it may still be inside by less than a sample.
    around = x[[max(top - 1, 0), min(top + 1, SCAN_POINTS - 1)]]
    before, after = demand_slope(around)[0]
    if before * after < 0.0:
        at = _root(demand_slope, *around)
    _, fx, fy, *_ = piece.at(np.array(at))
    return at, float(fx / fy)


def _crossing(piece: Piece, column: int, low: float, high: float) -> float:
    """Where a value changes its sign between two values of the parameter."""

    def value(t: FloatArray) -> tuple[FloatArray, FloatArray]:
        value, slope = piece.jet(t, 1)[..., column]
        return value, slope

    return _root(value, low, high)


def _root(
    function: Callable[[FloatArray], tuple[FloatArray, FloatArray]], low: float, high: float
) -> float:
    return float(bracketed_root(function, np.array([low]), np.array([high]))[0])


def _first_touch(pieces: Sequence[Piece], end: float) -> float:
    """First displacement up to `end` at which φ1 = 0; NaN if there is none."""
    lying = [piece.x0[0] for piece in pieces if piece.contact is Contact.LINE]
    if lying:
        return float(lying[0]) if lying[0] <= end else float("nan")
    for piece in pieces:
        if piece.x0[0] > end:
            break
        t, values = piece.scan
        below = np.flatnonzero(values[:, 4] < 0.0)
        if len(below):
            first = int(below[0])
            at = t[0] if first == 0 else _crossing(piece, 4, t[first - 1], t[first])
            x0 = float(piece.at(np.array(at))[0])
            return x0 if x0 <= end else float("nan")
    return float("nan")


def failed_curve(
    theta: float, eta: float, method: str, message: str, status: Status = Status.FAILED
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
    nan = float("nan")
    nothing = (nan, (), nan, nan, nan, nan)
    return StickingCurve(theta, eta, method, status, message, *nothing, End.NOT_FOLLOWED, message)
