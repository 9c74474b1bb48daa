"""Comparison of point contact and line contact for the same θ, μ0 and η."""

from collections.abc import Sequence
from decimal import Decimal
from typing import Any

import numpy as np

from vibrissa.outcomes import Contact
from vibrissa.sticking.periods import read_curves
from vibrissa.sticking.solving.collocation import solve_curves


def compare(theta: Sequence[float], mu0: Sequence[float], eta: Sequence[float]) -> dict[str, Any]:
    """Solve all combinations of θ, μ0 and η in both contact models.

    Returns
    -------
    dict
        Columns of `vibrissa.tables.schemas.COMPARISONS`. Rows are ordered by η, then θ, then μ0.
        The name of a column of results ends with the contact model, as in `mu_lock_line`.
        `penetrates` is true where the point-contact shape passes through the surface before the
        onset or the lock.
    """
    pairs = np.array([(t, e) for e in eta for t in theta], dtype=float)
    count, friction = len(mu0), np.array(mu0, dtype=float)
    columns: dict[str, Any] = {
        "theta": np.repeat(pairs[:, 0], count),
        "mu0": np.tile(friction, len(pairs)),
        "eta": np.repeat(pairs[:, 1], count),
    }
    for model in Contact:
        curves = solve_curves(pairs[:, 0], pairs[:, 1], model)
        steps = [Decimal(1)] * count
        periods = read_curves(curves, [friction] * len(curves), [steps] * len(curves))
        result = {
            "status": periods.status,
            "x0_slip": periods.x0_slip,
            "f_slip": periods.slip.f,
            "reaction_m_slip": periods.slip.reaction_m,
            "mu_lock": np.repeat([curve.mu_lock for curve in curves], count),
            "residual": np.repeat([curve.residual for curve in curves], count),
        }
        columns |= {f"{name}_{model}": values for name, values in result.items()}
        if model is Contact.POINT:
            columns["penetrates"] = periods.penetrates
    return columns
