"""Both contact models side by side: what point contact gets wrong where the rod would lie down."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vibrissa.arrays import BoolArray, FloatArray
from vibrissa.collocation import solve_curves
from vibrissa.curve import StickingCurve
from vibrissa.status import Contact, Status


@dataclass(frozen=True, eq=False)
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


@dataclass(frozen=True, eq=False)
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
    solved = (solve_curves(pairs[:, 0], pairs[:, 1], model) for model in Contact)
    point, line = solved
    results = [_read(curves, friction) for curves in (point, line)]
    onset = results[0].x0_slip.reshape(len(pairs), -1)
    lock, touch = (np.array([getattr(c, n) for c in point]) for n in ("x0_lock", "x0_touch"))
    until = np.where(np.isfinite(onset), onset, lock[:, None])
    return Comparison(
        np.repeat(pairs[:, 0], len(friction)),
        np.tile(friction, len(pairs)),
        np.repeat(pairs[:, 1], len(friction)),
        (touch[:, None] < until).ravel(),
        *results,
    )


def _read(curves: Sequence[StickingCurve], friction: FloatArray) -> ModelResult:
    """Read all friction coefficients off all curves."""
    status: list[Status] = []
    columns: list[list[FloatArray]] = [[], [], []]
    for curve in curves:
        values = np.full((3, len(friction)), np.nan)
        if curve.status is Status.SOLVED:
            values[0] = curve.onset(friction)
            slips = np.isfinite(values[0])
            if slips.any():
                state = curve.state(values[0, slips])
                values[1, slips], values[2, slips] = state.f, state.reaction_m
            status += [Status.SLIP if slip else Status.LOCK for slip in slips]
        else:
            status += [curve.status] * len(friction)
        for column, value in zip(columns, values, strict=True):
            column.append(value)
    return ModelResult(
        status,
        *(np.concatenate(column) for column in columns),
        *(
            np.repeat([getattr(curve, name) for curve in curves], len(friction))
            for name in ("mu_lock", "residual")
        ),
    )
