"""Both contact models side by side: what point contact gets wrong where the rod would lie down."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.outcomes import Contact, Status
from vibrissa.sticking.curve import CURVES_AT_ONCE, StickingCurve, beside
from vibrissa.sticking.piece import StickingState
from vibrissa.sticking.solving.collocation import solve_curves


@dataclass(frozen=True, eq=False, kw_only=True)
class ModelResult:
    """What one contact model answers for a list of points.

    Attributes
    ----------
    status : list of Status
        ``slip``, ``lock``, or what the curve has instead of states.
    x0_slip, f_slip, reaction_m_slip : ndarray, shape (n,)
        Exact onset (L), force (E·I0/L²) and clamp moment (E·I0/L) there; NaN where there is none.
    mu_lock, residual : ndarray, shape (n,)
        Of the curve.
    """

    status: list[Status]
    x0_slip: FloatArray
    f_slip: FloatArray
    reaction_m_slip: FloatArray
    mu_lock: FloatArray
    residual: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Comparison:
    """Points in both contact models.

    Attributes
    ----------
    theta, mu0, eta : ndarray, shape (n,)
        The points.
    penetrates : ndarray of bool, shape (n,)
        Whether the point-contact shape passes through the surface up to the onset (up to the lock
        where it locks).
    point, line : ModelResult
    """

    theta: FloatArray
    mu0: FloatArray
    eta: FloatArray
    penetrates: BoolArray
    point: ModelResult
    line: ModelResult


def compare(theta: Sequence[float], mu0: Sequence[float], eta: Sequence[float]) -> Comparison:
    """Solve all combinations of three axes in both contact models.

    Parameters
    ----------
    theta, mu0, eta : sequence of float
        Taper factors, friction coefficients and heights (L).

    Returns
    -------
    Comparison
        Ordered by η, then θ, then μ0.
    """
    pairs = np.array([(t, e) for e in eta for t in theta], dtype=float)
    friction = np.array(mu0, dtype=float)
    point, line = (solve_curves(pairs[:, 0], pairs[:, 1], model) for model in Contact)
    results = [_read(curves, friction) for curves in (point, line)]
    onset = results[0].x0_slip.reshape(len(pairs), -1)
    lock, touch = (np.array([getattr(c, n) for c in point]) for n in ("x0_lock", "x0_touch"))
    until = np.where(np.isfinite(onset), onset, lock[:, None])
    return Comparison(
        theta=np.repeat(pairs[:, 0], len(friction)),
        mu0=np.tile(friction, len(pairs)),
        eta=np.repeat(pairs[:, 1], len(friction)),
        penetrates=(touch[:, None] < until).ravel(),
        point=results[0],
        line=results[1],
    )


def _read(curves: Sequence[StickingCurve], friction: FloatArray) -> ModelResult:
    """Read all friction coefficients off all curves."""
    status, slips = [], []
    for start in range(0, len(curves), CURVES_AT_ONCE):
        some = curves[start : start + CURVES_AT_ONCE]
        together, of = beside(some), np.repeat(np.arange(len(some)), len(friction))
        x0_slip, outcomes = together.outcomes(of, np.tile(friction, len(some)))
        status += outcomes
        slips.append(together.states(of, x0_slip))
    slip = StickingState.concatenate(slips)
    return ModelResult(
        status=status,
        x0_slip=slip.x0,
        f_slip=slip.f,
        reaction_m_slip=slip.reaction_m,
        mu_lock=np.repeat([curve.mu_lock for curve in curves], len(friction)),
        residual=np.repeat([curve.residual for curve in curves], len(friction)),
    )
