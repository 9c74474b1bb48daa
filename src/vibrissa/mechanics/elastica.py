"""The rod as an initial value problem: paper equation (2), integrated from clamp to tip."""

import math
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

from vibrissa.mechanics.equations import CLAMP_SLOPE
from vibrissa.numerics.arrays import FloatArray

SHAPE_TOLERANCE = 1e-12


def rod_equations(
    theta: float, f: float, alpha: float, x1: float, y1: float
) -> Callable[[float, FloatArray], tuple[float, float, float]]:
    """Right-hand side of paper equation (2) for (x, y, φ) over s.

    Parameters
    ----------
    theta : float
        Taper factor.
    f, alpha : float
        Contact force magnitude (E·I0/L²) and inclination (rad).
    x1, y1 : float
        Contact point, in units of L.

    Returns
    -------
    callable
        Maps s and (x, y, φ) to (x', y', φ').
    """
    cos_alpha, sin_alpha = math.cos(alpha), math.sin(alpha)

    def derivative(s: float, state: FloatArray) -> tuple[float, float, float]:
        x, y, phi = state.tolist()  # Python's numbers are faster than NumPy's, one by one
        flexibility = theta**4 / (theta * s - theta - s) ** 4
        moment = f * (cos_alpha * (x - x1) + sin_alpha * (y - y1))
        return math.cos(phi), math.sin(phi), flexibility * moment

    return derivative


def deformed_shape(
    theta: float,
    f: float,
    alpha: float,
    x1: float,
    y1: float,
    s: FloatArray,
    s_c: float = 1.0,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Shape of the rod under a known contact force, with the clamp at the origin.

    Parameters
    ----------
    theta : float
        Taper factor.
    f, alpha : float
        Contact force magnitude (E·I0/L²) and inclination (rad).
    x1, y1 : float
        Position of the tip relative to the clamp, in units of L.
    s : ndarray, shape (points,)
        Arc lengths from 0 to 1, increasing, in units of L.
    s_c : float
        Arc length of the contact point; what lies beyond it lies straight on the surface.

    Returns
    -------
    x, y, phi : ndarray, shape (points,)
        Position (L) and slope (rad).

    Notes
    -----
    The end of the shape meets (x1, y1) only if the force is the equilibrium one: their distance
    is an independent residual of whoever found the force.
    """
    free = s < s_c
    result = solve_ivp(
        rod_equations(theta, f, alpha, x1 - (1.0 - s_c), y1),
        (0.0, s_c),
        (0.0, 0.0, CLAMP_SLOPE),
        method="DOP853",
        t_eval=np.append(s[free], s_c),
        rtol=SHAPE_TOLERANCE,
        atol=SHAPE_TOLERANCE,
    )
    x, y, phi = np.asarray(result.y)
    lying = s[~free] - s_c
    return (
        np.append(x[:-1], x[-1] + lying * np.cos(phi[-1])),
        np.append(y[:-1], y[-1] + lying * np.sin(phi[-1])),
        np.append(phi[:-1], np.full_like(lying, phi[-1])),
    )
