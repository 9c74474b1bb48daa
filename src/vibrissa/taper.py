"""Geometry of the tapered rod: a truncated cone, clamped at its thick end.

Lengths are in units of the rod's length L, diameters in units of the base diameter d0 and
bending stiffness in units of E·I0 with I0 = π·d0⁴/64.

Besides the arc length s the module knows one other coordinate along the rod, the *bending
coordinate* ``tau`` ∈ [0, 1], defined by ds/dτ = θ·d(s)². It is the phase of the bending waves of
a cone (their wavelength is proportional to d²), so that a deflected shape is about equally
smooth everywhere in τ however strong the taper is; polynomials in τ need far fewer terms than
polynomials in s. At θ = 1 the two coordinates are the same.
"""

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.arrays import FloatArray


def diameter(s: ArrayLike, theta: ArrayLike) -> FloatArray:
    """Diameter d(s)/d0 = 1 − (1 − 1/θ)·s of the rod.

    Parameters
    ----------
    s : array_like
        Arc length from the clamp, in units of L.
    theta : array_like
        Taper factor θ = d0/d1, broadcast against `s`.

    Returns
    -------
    ndarray
        Diameter in units of d0.

    Notes
    -----
    Equation (1) of the paper prints d1/θ where d1 = d0/θ must stand; its equation (2) uses the
    taper given here.
    """
    s, theta = np.asarray(s, dtype=float), np.asarray(theta, dtype=float)
    return 1.0 - (1.0 - 1.0 / theta) * s


def stiffness(s: ArrayLike, theta: ArrayLike) -> FloatArray:
    """Bending stiffness B(s) = (d(s)/d0)⁴ of the rod, paper equation (2).

    Parameters
    ----------
    s : array_like
        Arc length from the clamp, in units of L.
    theta : array_like
        Taper factor, broadcast against `s`.

    Returns
    -------
    ndarray
        Stiffness in units of E·I0.
    """
    return diameter(s, theta) ** 4


def arc_length(tau: ArrayLike, theta: ArrayLike) -> FloatArray:
    """Arc length s(τ) = θ·τ / (1 + (θ − 1)·τ).

    Parameters
    ----------
    tau : array_like
        Bending coordinate in [0, 1].
    theta : array_like
        Taper factor, broadcast against `tau`.

    Returns
    -------
    ndarray
        Arc length from the clamp, in units of L.
    """
    tau, theta = np.asarray(tau, dtype=float), np.asarray(theta, dtype=float)
    return theta * tau / (1.0 + (theta - 1.0) * tau)


def arc_density(tau: ArrayLike, theta: ArrayLike) -> FloatArray:
    """Arc length per bending coordinate, ds/dτ = θ / (1 + (θ − 1)·τ)² = θ·d².

    Parameters
    ----------
    tau : array_like
        Bending coordinate in [0, 1].
    theta : array_like
        Taper factor, broadcast against `tau`.

    Returns
    -------
    ndarray
        ds/dτ in units of L.
    """
    tau, theta = np.asarray(tau, dtype=float), np.asarray(theta, dtype=float)
    return theta / (1.0 + (theta - 1.0) * tau) ** 2


def compliance_density(tau: ArrayLike, theta: ArrayLike) -> FloatArray:
    """Bending compliance per bending coordinate, B⁻¹·ds/dτ = θ·(1 + (θ − 1)·τ)².

    Parameters
    ----------
    tau : array_like
        Bending coordinate in [0, 1].
    theta : array_like
        Taper factor, broadcast against `tau`.

    Returns
    -------
    ndarray
        Slope gained per moment and bending coordinate, in units of L/(E·I0).
    """
    tau, theta = np.asarray(tau, dtype=float), np.asarray(theta, dtype=float)
    return theta * (1.0 + (theta - 1.0) * tau) ** 2
