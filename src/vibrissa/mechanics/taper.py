"""Geometry and stiffness of the tapered rod: a truncated cone, clamped at its thick end.

The *bending coordinate* ``tau`` runs from 0 at the clamp to 1 at the contact point, s = s_c, with
ds/dτ ∝ d(s)², so that shapes are equally smooth everywhere in τ. At θ = 1, τ = s/s_c.
"""

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

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


class Making(NamedTuple):
    """How rods are made, apart from their taper: solid and of one material by default.

    Attributes
    ----------
    bore : float or ndarray
        Diameter b of a bore, the same along the rod (d0).
    powers : sequence of float or ndarray
        Coefficients of s, s², … in the modulus E(s)/E(0) = 1 + c1·s + c2·s² + ….
    """

    bore: Floats = 0.0
    powers: Sequence[Floats] = ()


SOLID = Making()


def modulus(s: Floats, making: Making) -> Floats:
    """Young's modulus along the rod, E(s)/E(0) = 1 + c1·s + c2·s² + …."""
    rise: Floats = 0.0
    for power in reversed(making.powers):
        rise = (rise + power) * s
    return 1.0 + rise


def stiffness_factor(s: Floats, theta: Floats, making: Making) -> Floats:
    """Factor e(s) of the bending stiffness, B = (d/d0)⁴·e, with e(0) = 1.

    It is e = E(s)/E(0)·(1 − (b·d0/d)⁴)/(1 − b⁴), as the second moment of area is π·(d⁴ − b⁴·d0⁴)/64
    and I0 is that of the base.

    Examples
    --------
    >>> print(stiffness_factor(np.array([0.0, 1.0]), 2.0, Making(powers=[0.5])))
    [1.  1.5]
    """
    wall = 1.0 - (making.bore / diameter(s, theta)) ** 4
    return modulus(s, making) * (wall / (1.0 - making.bore**4))


def stiffness_growth(s: FloatArray, theta: Floats, making: Making) -> FloatArray:
    """Differentiate the logarithm of `stiffness_factor` with respect to s, in 1/L."""
    rise: Floats = 0.0
    for number, power in reversed(list(enumerate(making.powers, start=1))):
        rise = rise * s + number * power
    inverse = 1.0 / diameter(s, theta)
    hollow = (making.bore * inverse) ** 4
    thinning = (1.0 - 1.0 / theta) * inverse
    return np.asarray(rise / modulus(s, making) - 4.0 * hollow / (1.0 - hollow) * thinning)


def stiffness(s: ArrayLike, theta: ArrayLike, making: Making = SOLID) -> FloatArray:
    """Bending stiffness B(s) = (d(s)/d0)⁴·e(s) of the rod (E·I0); e = 1 in paper equation (2).

    Examples
    --------
    >>> print(stiffness([0.0, 1.0], theta=2.0))
    [1.     0.0625]
    """
    s, theta = np.asarray(s, dtype=float), np.asarray(theta, dtype=float)
    return np.asarray(diameter(s, theta) ** 4 * stiffness_factor(s, theta, making))


def mass_per_length(s: ArrayLike, theta: ArrayLike, making: Making = SOLID) -> FloatArray:
    """Mass per length (ρA0): (d² − b²·d0²)/(d0² − b²·d0²), the density being the same everywhere.

    Examples
    --------
    >>> print(mass_per_length([0.0, 1.0], theta=2.0))
    [1.   0.25]
    """
    bore = making.bore**2
    return np.asarray((diameter(s, theta) ** 2 - bore) / (1.0 - bore))


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
    """Return ds/dτ (L) and, of a solid rod of one material, B⁻¹·ds/dτ = θ·s_c·h²/g³ (L/(E·I0)).

    `arc_density` defines g and h.
    """
    shrinks, free = (theta - 1.0) * s_c, theta * s_c
    g = theta - shrinks
    square = np.asarray((g + shrinks * tau) ** 2)
    return free * g / square, free / g**3 * square


def density_growth(tau: Floats, theta: Floats, s_c: Floats) -> tuple[FloatArray, FloatArray]:
    """Return ∂/∂s_c of the logarithms of both `densities` at a fixed τ, in 1/L."""
    # The logarithms of g and h shrink at the rates `shrinking` and `falling`/h.
    falling = (theta - 1.0) * (1.0 - tau)
    shrinking = (theta - 1.0) / (theta - (theta - 1.0) * s_c)
    twice = np.asarray(2.0 * falling / (theta - s_c * falling))
    return 1.0 / s_c - shrinking + twice, 1.0 / s_c + 3.0 * shrinking - twice


def _inverse_diameter(tau: Floats, theta: Floats, s_c: Floats) -> FloatArray:
    """Return h = θ − (θ − 1)·s_c·(1 − τ), proportional to 1/d on the free part; h(0) = g."""
    return np.asarray(theta - (theta - 1.0) * s_c * (1.0 - tau))
