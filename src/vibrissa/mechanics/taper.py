"""Geometry of the tapered rod: a truncated cone, clamped at its thick end.

The *bending coordinate* ``tau`` runs from 0 at the clamp to 1 at the contact point, s = s_c, with
ds/dτ ∝ d(s)², so that shapes are equally smooth everywhere in τ. At θ = 1, τ = s/s_c.
"""

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.numerics.arrays import FloatArray

Floats: TypeAlias = FloatArray | float
# Largest taper factor (1 mm at the clamp, 20 µm at the tip): few rods with a larger one are solved.
MOST_TAPER = 50.0


def diameter(s: ArrayLike, theta: ArrayLike) -> FloatArray:
    """Diameter d(s)/d0 = 1 − (1 − 1/θ)·s of the rod, in units of d0.

    Equation (1) of the paper has a misprint: d1/θ in place of d1, which is d0/θ.

    Examples
    --------
    >>> print(diameter([0.0, 0.5, 1.0], theta=2.0))
    [1.   0.75 0.5 ]
    """
    s, theta = np.asarray(s, dtype=float), np.asarray(theta, dtype=float)
    return 1.0 - (1.0 - 1.0 / theta) * s


def stiffness(s: ArrayLike, theta: ArrayLike) -> FloatArray:
    """Bending stiffness B(s) = (d(s)/d0)⁴ of the rod (E·I0), paper equation (2).

    Examples
    --------
    >>> print(stiffness([0.0, 1.0], theta=2.0))
    [1.     0.0625]
    """
    return diameter(s, theta) ** 4


def bending_coordinate(s: Floats, theta: Floats, s_c: Floats = 1.0) -> FloatArray:
    """Bending coordinate τ at the arc length s (L), from 0 at the clamp to 1 at s = s_c.

    It is the inverse of s(τ) = θ·s_c·τ/h. Here h = θ − (θ − 1)·s_c·(1 − τ), and h is
    proportional to 1/d(s(τ)).
    """
    return np.asarray(s * (theta - (theta - 1.0) * s_c) / (s_c * (theta - (theta - 1.0) * s)))


def arc_length(tau: Floats, theta: Floats, s_c: Floats) -> FloatArray:
    """Arc length s(τ) = θ·s_c·τ/h (L), with h as in `bending_coordinate`, the inverse function."""
    return np.asarray(theta * s_c * tau / _inverse_diameter(tau, theta, s_c))


def arc_length_growth(tau: Floats, theta: Floats, s_c: Floats) -> FloatArray:
    """Differentiate `arc_length` with respect to s_c at a fixed τ: θ²·τ/h²."""
    return np.asarray(theta**2 * tau / _inverse_diameter(tau, theta, s_c) ** 2)


def arc_density(tau: Floats, theta: Floats, s_c: Floats = 1.0) -> FloatArray:
    """Return the derivative ds/dτ of `arc_length`, in L; it is proportional to d².

    It is ds/dτ = θ·s_c·g/h² with g = θ − (θ − 1)·s_c, and h as in `bending_coordinate`.
    """
    return densities(tau, theta, s_c)[0]


def densities(tau: Floats, theta: Floats, s_c: Floats = 1.0) -> tuple[FloatArray, FloatArray]:
    """Return ds/dτ (L) and B⁻¹·ds/dτ = θ·s_c·h²/g³ (L/(E·I0)); `arc_density` defines g and h."""
    shrinks, free = (theta - 1.0) * s_c, theta * s_c
    g = theta - shrinks
    square = np.asarray((g + shrinks * tau) ** 2)
    return free * g / square, free / g**3 * square


def density_growth(tau: Floats, theta: Floats, s_c: Floats) -> tuple[FloatArray, FloatArray]:
    """Return ∂/∂s_c of the logarithms of both `densities` at a fixed τ, in 1/L."""
    h_growth = -(theta - 1.0) * (1.0 - tau) / _inverse_diameter(tau, theta, s_c)
    g_growth = -(theta - 1.0) / _inverse_diameter(0.0, theta, s_c)
    return 1.0 / s_c + g_growth - 2.0 * h_growth, 1.0 / s_c + 2.0 * h_growth - 3.0 * g_growth


def _inverse_diameter(tau: Floats, theta: Floats, s_c: Floats) -> FloatArray:
    """Return h = θ − (θ − 1)·s_c·(1 − τ), proportional to 1/d on the free part; h(0) = g."""
    return np.asarray(theta - (theta - 1.0) * s_c * (1.0 - tau))
