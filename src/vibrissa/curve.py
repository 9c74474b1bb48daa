"""The sticking curve: every state between α = 0 and locking, for one (θ, η).

While the tip sticks, x1 and η are fixed and only the footpoint displacement x0 changes, so the
equilibria form one curve, parametrised by x0. Friction enters afterwards: μ0 decides where on the
curve sticking ends (the onset, −tan α = μ0) and a step Δx0 only samples it. The largest value of
−tan α on the curve is the locking friction μ_lock: above it the tip never slips backward. Where the
surface would have to pull before −tan α has a maximum, the tip lifts off: then −tan α grows without
limit and there is no locking. Where the
contact changes its kind the curve has a kink: it consists of smooth pieces.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike
from scipy.interpolate import make_interp_spline
from scipy.optimize import elementwise

from vibrissa.arrays import FloatArray, IntArray
from vibrissa.spectral import chebyshev_transform
from vibrissa.status import Contact, Status

# Samples of each piece between which crossings are bracketed before they are located exactly.
SCAN_POINTS = 257
# Displacements that are nearer to each other are one: where two pieces meet.
KINK_TOLERANCE = 1e-12
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
    """

    x0: FloatArray
    f: FloatArray
    alpha: FloatArray
    phi1: FloatArray
    s_c: FloatArray
    reaction_fx: FloatArray
    reaction_fy: FloatArray
    reaction_m: FloatArray


@dataclass(frozen=True, eq=False)
class Piece:
    """A smooth piece of a sticking curve, with one kind of contact.

    Attributes
    ----------
    contact : Contact
        Kind of contact of its states.
    x0 : ndarray, shape (k,)
        Footpoint displacements of the solved states (L), increasing.
    values : ndarray, shape (k, 5)
        fx, fy (E·I0/L²), m (E·I0/L), φ1 (rad) and s_c (L) of the states.
    stepped : bool
        Whether the states stand on a step grid; at Chebyshev points otherwise.
    """

    contact: Contact
    x0: FloatArray
    values: FloatArray
    stepped: bool = False

    def __post_init__(self) -> None:
        """Put the values in one order in memory: sums over them then round alike."""
        object.__setattr__(self, "values", np.ascontiguousarray(self.values))

    @cached_property
    def _series(self) -> tuple[Any, Any]:
        """Spline or Chebyshev coefficients of the values over x0, and of their derivatives."""
        if self.stepped:
            degree = min(SPLINE_DEGREE, len(self.x0) - 1)
            spline = make_interp_spline(self.x0, self.values, k=degree)
            return spline, spline.derivative()
        coefficients = chebyshev_transform(len(self.x0)) @ self.values
        length = self.x0[-1] - self.x0[0]
        return coefficients, chebyshev.chebder(coefficients, scl=2.0 / length)

    def _evaluated(self, series: Any, x0: FloatArray) -> FloatArray:
        if self.stepped:
            return np.asarray(series(x0))
        position = 2.0 * (x0 - self.x0[0]) / (self.x0[-1] - self.x0[0]) - 1.0
        return np.moveaxis(chebyshev.chebval(position, series), 0, -1)

    def evaluate(self, x0: FloatArray) -> FloatArray:
        """Values at displacements on the piece, shape x0.shape + (5,)."""
        values = self._evaluated(self._series[0], x0)
        # What the kind of contact prescribes is known exactly.
        if self.contact is Contact.POINT:
            values[..., 4] = 1.0
        else:
            values[..., 3] = 0.0
        return values

    def slope(self, x0: FloatArray) -> FloatArray:
        """Differentiate the values with respect to x0, shape x0.shape + (5,)."""
        return self._evaluated(self._series[1], x0)


@dataclass(frozen=True, eq=False)
class StickingCurve:
    """One period of sticking of one rod at one height, up to locking.

    Build one with `vibrissa.solve_curve`; `sticking_curve` builds one from solved states.

    Attributes
    ----------
    theta, eta : float
        Taper factor and height of the contact point (L).
    method : str
        ``collocation`` (states at Chebyshev points) or ``shooting`` (states on a step grid).
    status : Status
        ``solved`` or ``failed``.
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

    @property
    def x0_end(self) -> float:
        """Last displacement of the curve, slightly beyond locking (L)."""
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
            Displacements between 0 and the curve's end (slightly beyond locking), in units of L.

        Returns
        -------
        StickingState
            Arrays of the shape of `x0`.

        Raises
        ------
        ValueError
            If the curve was not solved or a displacement lies outside it.
        """
        if self.status is Status.FAILED:
            raise ValueError(f"no states on a curve with status {self.status}: {self.message}")
        x0 = np.asarray(x0, dtype=float)
        if np.any(~(x0 >= 0.0)) or np.any(~(x0 <= self.x0_end)):
            raise ValueError(
                f"x0 must lie on the curve, between 0 and {self.x0_end:.6g}; got {x0!r}"
            )
        values = np.empty((*x0.shape, 5))
        place = self._piece_of(x0)
        for index, piece in enumerate(self.pieces):
            on_piece = place == index
            if np.any(on_piece):
                values[on_piece] = piece.evaluate(x0[on_piece])
        fx, fy, m, phi1, s_c = np.moveaxis(values, -1, 0)
        return StickingState(x0, np.hypot(fx, fy), np.arctan2(fx, -fy), phi1, s_c, fx, fy, m)

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

    def _excess(self, x0: FloatArray, mu0: FloatArray) -> FloatArray:
        """μ0·fy − fx: has the sign of −tan α − μ0 as long as the surface pushes."""
        state = self.state(x0)
        return mu0 * state.reaction_fy - state.reaction_fx

    def samples(self, end: float) -> FloatArray:
        """Displacements from 0 to `end`, `SCAN_POINTS` on each piece, its ends included."""
        bounds = [0.0, *(x for piece in self.pieces[1:] if (x := piece.x0[0]) < end), end]
        return np.unique(
            np.concatenate([np.linspace(a, b, SCAN_POINTS) for a, b in pairwise(bounds)])
        )

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
        if self.status is Status.FAILED:
            raise ValueError(f"no onset on a curve with status {self.status}: {self.message}")
        x = self.samples(self.x0_lock)
        demand = self.friction_demand(x)
        demand[-1] = self.mu_lock
        slips = mu0 <= self.mu_lock
        # First sample that needs at least μ0: the running maximum makes the search monotone.
        after = np.searchsorted(np.maximum.accumulate(demand), mu0[slips])
        after = np.clip(after, 1, len(x) - 1)
        onset = np.full(mu0.shape, np.nan)
        onset[slips] = _bracketed_root(self._excess, x[after - 1], x[after], mu0[slips])
        return onset


def _bracketed_root(
    function: Callable[..., FloatArray], low: FloatArray, high: FloatArray, *args: FloatArray
) -> FloatArray:
    """Elementwise root of `function` in [low, high], to rounding error."""
    result = elementwise.find_root(function, (low, high), args=args)
    # An end of the bracket that is a root up to rounding may show no change of sign.
    at_low = np.abs(function(low, *args)) <= np.abs(function(high, *args))
    return np.where(result.success, result.x, np.where(at_low, low, high))


def sticking_curve(
    theta: float,
    eta: float,
    method: str,
    x1_init: float,
    pieces: Sequence[Piece],
    residual: float,
) -> StickingCurve:
    """Build a curve from solved pieces and locate its lock and its first contact along a line.

    Parameters
    ----------
    theta, eta : float
        Taper factor and height of the contact point (L).
    method : str
        ``collocation`` or ``shooting``.
    x1_init : float
        Contact point in the α = 0 state (L).
    pieces : sequence of Piece
        From displacement 0 to beyond the lock, each beginning where the one before ends.
    residual : float
        Largest equilibrium residual.

    Returns
    -------
    StickingCurve
        ``failed`` if −tan α has no maximum inside the given displacements.
    """
    tops = [_largest_demand(piece) for piece in pieces]
    # The first of equal ones: after lifting off nothing counts.
    x0_lock, mu_lock = max(tops, key=lambda top: top[1])
    # A maximum in a kink belongs to both pieces: put it where the second one begins.
    kink = min(
        (piece.x0[0] for piece in pieces[1:]), key=lambda x: abs(x - x0_lock), default=np.nan
    )
    if abs(kink - x0_lock) <= 1e-12:
        x0_lock = float(kink)
    if not 0.0 < x0_lock < pieces[-1].x0[-1]:
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
    )


def _largest_demand(piece: Piece) -> tuple[float, float]:
    """Where −tan α is largest on a piece, and its value there; infinity where the tip lifts off."""
    x = np.linspace(piece.x0[0], piece.x0[-1], SCAN_POINTS)
    fx, fy = piece.evaluate(x)[:, :2].T
    pulls = np.flatnonzero((fy >= 0.0) & (fx < 0.0))
    if len(pulls):
        bracket = x[[max(pulls[0] - 1, 0)]], x[[pulls[0]]]
        return float(_bracketed_root(lambda x: piece.evaluate(x)[..., 1], *bracket)[0]), np.inf

    def demand(x: FloatArray) -> FloatArray:
        values = piece.evaluate(x)
        return values[..., 0] / values[..., 1]

    def demand_slope(x: FloatArray) -> FloatArray:
        value, slope = piece.evaluate(x), piece.slope(x)
        return slope[..., 0] * value[..., 1] - value[..., 0] * slope[..., 1]

    top = int(np.argmax(demand(x)))
    at = x[top]
    # At an end it may still be inside by less than a sample.
    low, high = x[[max(top - 1, 0)]], x[[min(top + 1, SCAN_POINTS - 1)]]
    if demand_slope(low)[0] * demand_slope(high)[0] < 0.0:
        at = _bracketed_root(demand_slope, low, high)[0]
    return float(at), float(demand(np.array(at)))


def _first_touch(pieces: Sequence[Piece], end: float) -> float:
    """First displacement up to `end` at which φ1 = 0; NaN if there is none."""
    lying = [piece.x0[0] for piece in pieces if piece.contact is Contact.LINE]
    if lying:
        return float(lying[0]) if lying[0] <= end else float("nan")
    for piece in pieces:
        x = np.linspace(piece.x0[0], min(end, piece.x0[-1]), SCAN_POINTS)
        below = np.flatnonzero(piece.evaluate(x)[:, 3] < 0.0)
        if len(below) and below[0] == 0:
            return float(x[0])
        if len(below):
            bracket = x[[below[0] - 1]], x[[below[0]]]
            return float(_bracketed_root(lambda x, p=piece: p.evaluate(x)[..., 3], *bracket)[0])
    return float("nan")


def failed_curve(theta: float, eta: float, method: str, message: str) -> StickingCurve:
    """Curve that could not be solved; it carries the reason and no states.

    Parameters
    ----------
    theta, eta : float
        Taper factor and height of the contact point (L).
    method : str
        Solver that was used.
    message : str
        What went wrong and what to try.

    Returns
    -------
    StickingCurve
    """
    nan = float("nan")
    return StickingCurve(theta, eta, method, Status.FAILED, message, nan, (), *(nan,) * 4)
