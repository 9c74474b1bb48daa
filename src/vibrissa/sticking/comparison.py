"""Comparison of tip contact and line contact at the same points."""

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.outcomes import Contact, Status
from vibrissa.sticking.solving.collocation import solve_curves
from vibrissa.sticking.stiction import read_curves


@dataclass(frozen=True, eq=False, kw_only=True)
class ModelResult:
    """Results of one contact model at some points.

    Attributes
    ----------
    x0_slip, f_slip, reaction_m_slip : ndarray, shape (n,)
        Exact onset (L), force (E·I0/L²) and clamp moment (E·I0/L) there; NaN where there is none.
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

    `penetrates`: the point-contact shape passes through the surface before the onset or the lock.
    """

    theta: FloatArray
    mu0: FloatArray
    eta: FloatArray
    penetrates: BoolArray
    point: ModelResult
    line: ModelResult


def compare(theta: Sequence[float], mu0: Sequence[float], eta: Sequence[float]) -> Comparison:
    """Solve all combinations of three axes in both contact models.

    Returns
    -------
    Comparison
        Ordered by η, then θ, then μ0.
    """
    pairs = np.array([(t, e) for e in eta for t in theta], dtype=float)
    friction = np.array(mu0, dtype=float)
    results, penetrates = [], []
    for model in Contact:
        curves = solve_curves(pairs[:, 0], pairs[:, 1], model)
        periods = read_curves(
            curves, [friction] * len(curves), [[Decimal(1)] * len(mu0)] * len(curves)
        )
        penetrates.append(periods.penetrates)
        results.append(
            ModelResult(
                status=periods.status,
                x0_slip=periods.x0_slip,
                f_slip=periods.slip.f,
                reaction_m_slip=periods.slip.reaction_m,
                mu_lock=np.repeat([curve.mu_lock for curve in curves], len(friction)),
                residual=np.repeat([curve.residual for curve in curves], len(friction)),
            )
        )
    return Comparison(
        theta=np.repeat(pairs[:, 0], len(friction)),
        mu0=np.tile(friction, len(pairs)),
        eta=np.repeat(pairs[:, 1], len(friction)),
        penetrates=penetrates[0],
        point=results[0],
        line=results[1],
    )
