"""The sticking curve: every state between α = 0 and locking, for one (θ, η).

While the tip sticks, x1 and η are fixed and only the footpoint displacement x0 changes, so the
equilibria form one curve, parametrised by x0. Friction enters afterwards: μ0 decides where on the
curve sticking ends (the onset, −tan α = μ0) and a step Δx0 only samples it. The largest value of
−tan α on the curve is the locking friction μ_lock: above it the tip never slips backward.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike
from scipy.interpolate import make_interp_spline
from scipy.optimize import elementwise

from vibrissa.arrays import FloatArray
from vibrissa.spectral import chebyshev_transform
from vibrissa.status import Status

# Samples between which crossings of the curve are bracketed before they are located exactly.
SCAN_POINTS = 257
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


@dataclass(frozen=True)
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
    x0 : ndarray, shape (k,)
        Footpoint displacements of the solved states (L).
    reaction_fx, reaction_fy, reaction_m, phi1 : ndarray, shape (k,)
        Solved states; see `StickingState`.
    residual : float
        Largest equilibrium residual of the states, between the solved ones included.
    x0_lock, mu_lock : float
        Where −tan α is largest, and its value there.
    x0_touch : float
        First displacement at which φ1 = 0, where the beam comes to lie along the surface; NaN if
        this does not happen before locking, 0 if it lies on it from the start.
    """

    theta: float
    eta: float
    method: str
    status: Status
    message: str
    x1_init: float
    x0: FloatArray
    reaction_fx: FloatArray
    reaction_fy: FloatArray
    reaction_m: FloatArray
    phi1: FloatArray
    residual: float
    x0_lock: float
    mu_lock: float
    x0_touch: float
    _interpolant: "_Interpolant | None" = field(default=None, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Prepare the interpolation of a solved curve."""
        if self.status is Status.SOLVED and self._interpolant is None:
            object.__setattr__(self, "_interpolant", _interpolant(self))

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
        if self._interpolant is None:
            raise ValueError(f"no states on a curve with status {self.status}: {self.message}")
        x0 = np.asarray(x0, dtype=float)
        if np.any(~(x0 >= 0.0)) or np.any(~(x0 <= self.x0[-1])):
            raise ValueError(
                f"x0 must lie on the curve, between 0 and {self.x0[-1]:.6g}; got {x0!r}"
            )
        fx, fy, m, phi1 = np.moveaxis(self._interpolant(x0), -1, 0)
        return StickingState(
            x0, np.hypot(fx, fy), np.arctan2(fx, -fy), phi1, np.ones_like(phi1), fx, fy, m
        )

    def friction_demand(self, x0: ArrayLike) -> FloatArray:
        """Friction coefficient −tan α that sticking needs at the given displacements.

        Parameters
        ----------
        x0 : array_like
            Displacements on the curve, in units of L.

        Returns
        -------
        ndarray
        """
        state = self.state(x0)
        return state.reaction_fx / state.reaction_fy

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
        x = np.linspace(0.0, self.x0_lock, SCAN_POINTS)
        demand = self.friction_demand(x)
        demand[-1] = self.mu_lock
        slips = mu0 <= self.mu_lock
        # First sample that needs at least μ0: the running maximum makes the search monotone.
        after = np.searchsorted(np.maximum.accumulate(demand), mu0[slips])
        after = np.clip(after, 1, SCAN_POINTS - 1)
        onset = np.full(mu0.shape, np.nan)
        onset[slips] = _bracketed_root(
            lambda x, mu: self.friction_demand(x) - mu, x[after - 1], x[after], mu0[slips]
        )
        return onset


class _Interpolant(NamedTuple):
    """Interpolation of (fx, fy, m, phi1) in x0, channels last, and its derivative."""

    value: Callable[[FloatArray], FloatArray]
    derivative: Callable[[FloatArray], FloatArray]

    def __call__(self, x0: FloatArray) -> FloatArray:
        return self.value(x0)


def _interpolant(curve: StickingCurve) -> _Interpolant:
    values = np.stack([curve.reaction_fx, curve.reaction_fy, curve.reaction_m, curve.phi1], axis=-1)
    if curve.method == "collocation":
        end = curve.x0[-1]
        coefficients = chebyshev_transform(len(curve.x0)) @ values
        slopes = chebyshev.chebder(coefficients, scl=2.0 / end)
        return _Interpolant(
            lambda x: np.moveaxis(chebyshev.chebval(2.0 * x / end - 1.0, coefficients), 0, -1),
            lambda x: np.moveaxis(chebyshev.chebval(2.0 * x / end - 1.0, slopes), 0, -1),
        )
    spline = make_interp_spline(curve.x0, values, k=min(SPLINE_DEGREE, len(curve.x0) - 1))
    return _Interpolant(spline, spline.derivative())


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
    x0: FloatArray,
    values: FloatArray,
    residual: float,
) -> StickingCurve:
    """Build a curve from solved states and locate its lock and its first contact along a line.

    Parameters
    ----------
    theta, eta : float
        Taper factor and height of the contact point (L).
    method : str
        ``collocation`` or ``shooting``; decides how the states are interpolated.
    x1_init : float
        Contact point in the α = 0 state (L).
    x0 : ndarray, shape (k,)
        Displacements of the states, from 0 to beyond the lock (L).
    values : ndarray, shape (k, 4)
        fx, fy, m and φ1 of the states.
    residual : float
        Largest equilibrium residual.

    Returns
    -------
    StickingCurve
        ``failed`` if −tan α has no maximum inside the given displacements.
    """
    fx, fy, m, phi1 = values.T
    curve = StickingCurve(
        theta,
        eta,
        method,
        Status.SOLVED,
        "",
        x1_init,
        x0,
        fx,
        fy,
        m,
        phi1,
        residual,
        *(np.nan, np.nan, np.nan),
    )
    samples = np.linspace(0.0, x0[-1], SCAN_POINTS)
    top = int(np.argmax(curve.friction_demand(samples)))
    if top in (0, SCAN_POINTS - 1):
        return failed_curve(theta, eta, method, "the curve has no locking maximum where sought")
    interpolant = curve._interpolant
    assert interpolant is not None

    def demand_slope(x: FloatArray) -> FloatArray:
        value, slope = interpolant(x), interpolant.derivative(x)
        return slope[..., 0] * value[..., 1] - value[..., 0] * slope[..., 1]

    x0_lock = float(_bracketed_root(demand_slope, samples[[top - 1]], samples[[top + 1]])[0])
    mu_lock = float(curve.friction_demand(x0_lock))

    samples = np.linspace(0.0, x0_lock, SCAN_POINTS)
    below = np.flatnonzero(interpolant(samples)[..., 3] < 0.0)
    if not len(below):
        x0_touch = np.nan
    elif below[0] == 0:
        x0_touch = 0.0
    else:
        bracket = samples[[below[0] - 1]], samples[[below[0]]]
        x0_touch = float(_bracketed_root(lambda x: interpolant(x)[..., 3], *bracket)[0])
    return StickingCurve(
        theta,
        eta,
        method,
        Status.SOLVED,
        "",
        x1_init,
        x0,
        fx,
        fy,
        m,
        phi1,
        residual,
        x0_lock,
        mu_lock,
        x0_touch,
    )


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
    empty = np.empty(0)
    nan = float("nan")
    return StickingCurve(
        theta,
        eta,
        method,
        Status.FAILED,
        message,
        nan,
        *(empty,) * 5,
        *(nan,) * 4,
    )
