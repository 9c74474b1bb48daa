"""The rod as an initial value problem: paper equation (2), integrated from clamp to tip."""

import math
from collections.abc import Callable

import numpy as np

from vibrissa.mechanics.mounting import CLAMP_SLOPE, IDEAL, Mounting, tail
from vibrissa.mechanics.shape import Shape
from vibrissa.mechanics.taper import stiffness_factor
from vibrissa.numerics.arrays import FloatArray

SHAPE_TOLERANCE = 1e-12


def rod_equations(
    theta: float,
    f: float,
    alpha: float,
    x1: float,
    y1: float,
    mounting: Mounting = IDEAL,
) -> Callable[[float, FloatArray], list[float]]:
    """Make a function that evaluates the differential equations of the rod, paper equation (2).

    Parameters
    ----------
    x1, y1 : float
        Position of the contact point (L).
    mounting : Mounting
        Its natural curvature and the stiffness along the rod count.

    Returns
    -------
    callable
        Function that maps s and (x, y, φ) to their derivatives.
    """
    highest, *lower = reversed(mounting.coefficients)
    making, is_solid = mounting.making, mounting.is_solid
    cos_alpha, sin_alpha, power = math.cos(alpha), math.sin(alpha), theta**4

    def derivative(s: float, state: FloatArray) -> list[float]:
        x, y, phi = state.tolist()  # single numbers are faster in Python than in NumPy
        flexibility = power / (theta * s - theta - s) ** 4
        if not is_solid:
            flexibility /= float(stiffness_factor(s, theta, making))
        moment = f * (cos_alpha * (x - x1) + sin_alpha * (y - y1))
        natural = highest
        for coefficient in lower:
            natural = natural * s + coefficient
        # A plain list, in the order of the state: a tuple with names doubles the time of a shot.
        return [math.cos(phi), math.sin(phi), flexibility * moment + natural]

    return derivative


def deformed_shape(
    theta: float,
    f: float,
    alpha: float,
    x1: float,
    y1: float,
    s: FloatArray,
    s_c: float = 1.0,
    mounting: Mounting = IDEAL,
) -> Shape:
    """Shape of the rod under a known contact force, with the clamp at the origin.

    The force acts at the contact point (x1 − (1 − s_c), y1). The rod meets this point only if the
    force is that of an equilibrium.

    Parameters
    ----------
    x1, y1 : float
        Position that the tip would have, relative to the clamp, if the part beyond s_c were
        straight along the surface (L). If s_c = 1, it is the position of the tip.
    s : ndarray, shape (points,)
        Arc lengths between 0 and 1, increasing (L).
    s_c : float
        Arc length of the contact point (L); beyond it the rod has its natural shape.
    """
    from scipy.integrate import solve_ivp  # half a second to load

    free, x_c = s < s_c, x1 - (1.0 - s_c)
    moment = -f * (math.cos(alpha) * x_c + math.sin(alpha) * y1)
    slope = CLAMP_SLOPE + mounting.clamp_angle + mounting.clamp_compliance * moment
    result = solve_ivp(
        rod_equations(theta, f, alpha, x_c, y1, mounting),
        (0.0, s_c),
        (0.0, 0.0, slope),
        method="DOP853",
        t_eval=np.append(s[free], s_c),
        rtol=SHAPE_TOLERANCE,
        atol=SHAPE_TOLERANCE,
    )
    x, y, phi = np.asarray(result.y)
    beyond = s[None, ~free]
    coefficients = np.array([mounting.coefficients])
    along, up, turn = (one[0] for one in tail(coefficients, np.full_like(beyond, s_c), beyond))
    cos, sin = np.cos(phi[-1]), np.sin(phi[-1])
    return Shape(
        x=np.append(x[:-1], x[-1] + along * cos - up * sin),
        y=np.append(y[:-1], y[-1] + along * sin + up * cos),
        phi=np.append(phi[:-1], phi[-1] + turn),
    )
