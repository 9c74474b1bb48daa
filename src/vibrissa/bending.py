"""How much a rod is bent: curvature, energy, strain and turn of a known shape."""

from typing import NamedTuple

import numpy as np
from scipy.integrate import simpson

from vibrissa.arrays import FloatArray
from vibrissa.rod import deformed_shape
from vibrissa.taper import diameter, stiffness

# Equally spaced points of a shape: Simpson's rule then has the energy to about 1e-6.
POINTS = 51


class Bending(NamedTuple):
    """Measures of how much each of a number of rods is bent.

    Attributes
    ----------
    energy : ndarray, shape (n,)
        Bending energy ½·∫ m²/B ds, in units of E·I0/L.
    curvature : ndarray, shape (n,)
        Largest curvature |φ'|, in units of 1/L.
    strain : ndarray, shape (n,)
        Largest strain |φ'|·d/2 at the rod's surface, in units of d0/L.
    turn : ndarray, shape (n,)
        Angle π/2 − φ1 by which the tip has turned (rad).
    """

    energy: FloatArray
    curvature: FloatArray
    strain: FloatArray
    turn: FloatArray


def measure(
    theta: FloatArray,
    f: FloatArray,
    alpha: FloatArray,
    x1: FloatArray,
    y1: FloatArray,
    s: FloatArray,
    x: FloatArray,
    y: FloatArray,
    phi1: FloatArray,
) -> Bending:
    """Measure shapes of rods whose tips alone are loaded.

    Parameters
    ----------
    theta, f, alpha, x1, y1, phi1 : ndarray, shape (n,)
        Taper factor, contact force (E·I0/L²), its inclination (rad), contact point (L) and slope
        there (rad).
    s : ndarray, shape (points,)
        Equally spaced arc lengths (L).
    x, y : ndarray, shape (n, points)
        Shapes, in the frame of the contact points (L).

    Returns
    -------
    Bending
    """
    column = [np.asarray(value, dtype=float)[:, None] for value in (theta, f, alpha, x1, y1)]
    theta, f, alpha, x1, y1 = column
    moment = f * (np.cos(alpha) * (x - x1) + np.sin(alpha) * (y - y1))
    curvature = np.abs(moment / stiffness(s, theta))
    return Bending(
        0.5 * simpson(np.abs(moment) * curvature, x=s, axis=1),
        curvature.max(axis=1),
        (curvature * diameter(s, theta) / 2.0).max(axis=1),
        np.pi / 2 - np.asarray(phi1, dtype=float),
    )


def solve_and_measure(
    theta: FloatArray, f: FloatArray, alpha: FloatArray, x1: FloatArray, y1: FloatArray
) -> Bending:
    """Measure rods under known contact forces; see `measure` for the arguments.

    Parameters
    ----------
    theta, f, alpha, x1, y1 : ndarray, shape (n,)
        With the clamp at the origin.

    Returns
    -------
    Bending
    """
    s = np.linspace(0.0, 1.0, POINTS)
    rows = list(zip(theta, f, alpha, x1, y1, strict=True))
    x, y, phi = np.moveaxis(np.array([deformed_shape(*row, s) for row in rows]), 1, 0)
    return measure(theta, f, alpha, x1, y1, s, x, y, phi[:, -1])
