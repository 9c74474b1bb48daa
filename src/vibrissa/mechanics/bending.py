"""Measures of bending of a known shape: curvature, energy, strain, rotation of the tip."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vibrissa.mechanics.elastica import deformed_shape
from vibrissa.mechanics.mounting import CLAMP_SLOPE, IDEAL, Mounting
from vibrissa.mechanics.taper import arc_density, arc_length, diameter, stiffness
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.batch import Batch

# Equally spaced points of a shape: Simpson's rule then has the energy to about 1e-6.
POINTS = 51
# Points along a rod at which its strain is computed, in steps of Runge and Kutta's method: it is
# good to 1e-6, up to θ = 20. SciPy's methods take half a second to load.
STRAIN_POINTS = 201


@dataclass(frozen=True, eq=False, kw_only=True)
class Bending(Batch):
    """Measures of bending of n rods.

    Attributes
    ----------
    energy : ndarray, shape (n,)
        Bending energy ½·∫ m²/B ds (E·I0/L).
    curvature : ndarray, shape (n,)
        Largest curvature |φ'| (1/L).
    strain : ndarray, shape (n,)
        Largest strain |φ'|·d/2 at the rod's surface (d0/L).
    turn : ndarray, shape (n,)
        Angle π/2 − φ1 by which the tip has turned (rad).
    """

    energy: FloatArray
    curvature: FloatArray
    strain: FloatArray
    turn: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Strains(Batch):
    """Largest strains |φ' − κ0|·d/2 of n rods at their surface (d0/L).

    Attributes
    ----------
    place : ndarray, shape (n,)
        Arc length of the largest strain from the clamp (L), to half a per cent of the rod.
    """

    largest: FloatArray
    place: FloatArray


def measure(
    *,
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
    """Measure shapes of rods whose tips alone are loaded, in the frame of the contact points (L).

    Parameters
    ----------
    f, alpha, x1, y1, phi1 : ndarray, shape (n,)
        Contact force (E·I0/L²), its inclination (rad), contact point (L) and slope there (rad).
    s : ndarray, shape (points,)
        Equally spaced arc lengths (L).
    """
    from scipy.integrate import simpson  # half a second to load

    column = [np.asarray(value, dtype=float)[:, None] for value in (theta, f, alpha, x1, y1)]
    theta, f, alpha, x1, y1 = column
    moment = _moment(f, alpha, x - x1, y - y1)
    curvature = np.abs(moment / stiffness(s, theta))
    return Bending(
        energy=0.5 * simpson(np.abs(moment) * curvature, x=s, axis=1),
        curvature=curvature.max(axis=1),
        strain=(curvature * diameter(s, theta) / 2.0).max(axis=1),
        turn=CLAMP_SLOPE - np.asarray(phi1, dtype=float),
    )


def _moment(f: FloatArray, alpha: FloatArray, dx: FloatArray, dy: FloatArray) -> FloatArray:
    """Bending moment at places (dx, dy) from the contact point (E·I0/L)."""
    return f * (np.cos(alpha) * dx + np.sin(alpha) * dy)


def solve_and_measure(
    theta: FloatArray, f: FloatArray, alpha: FloatArray, x1: FloatArray, y1: FloatArray
) -> Bending:
    """Measure rods under known contact forces, with the clamp at the origin; see `measure`."""
    s = np.linspace(0.0, 1.0, POINTS)
    rows = list(zip(theta, f, alpha, x1, y1, strict=True))
    x, y, phi = np.moveaxis(np.array([deformed_shape(*row, s) for row in rows]), 1, 0)
    return measure(theta=theta, f=f, alpha=alpha, x1=x1, y1=y1, s=s, x=x, y=y, phi1=phi[:, -1])


def strains(
    theta: FloatArray,
    f: FloatArray,
    alpha: FloatArray,
    x_c: FloatArray,
    y_c: FloatArray,
    s_c: FloatArray,
    mounting: Mounting = IDEAL,
) -> Strains:
    """Largest strain |φ' − κ0|·d/2 of many rods under known contact forces, integrated together.

    Forces have the unit E·I0/L², contact points and their arc lengths L.

    Notes
    -----
    The strain is |m|/(2·d³), as B = d⁴. It is largest at the clamp, or where m'/m = 3·d'/d: in a
    hardly bent rod where the diameter is 3/2 of the tip's, if θ > 3/2.
    """

    def derivative(tau: float, state: FloatArray) -> FloatArray:
        x, y, phi = state
        s = arc_length(tau, theta, s_c)
        bent = _moment(f, alpha, x - x_c, y - y_c) / stiffness(s, theta)
        bent = bent + np.polynomial.polynomial.polyval(s, mounting.coefficients)
        return np.stack([np.cos(phi), np.sin(phi), bent]) * arc_density(tau, theta, s_c)

    turn = mounting.clamp_compliance * _moment(f, alpha, -x_c, -y_c)
    slope = CLAMP_SLOPE + mounting.clamp_angle + turn
    begin = np.stack([np.zeros(len(f)), np.zeros(len(f)), slope])
    x, y, _ = np.moveaxis(_integrated(derivative, begin, STRAIN_POINTS), 1, 0)
    s = arc_length(np.linspace(0.0, 1.0, STRAIN_POINTS)[:, None], theta, s_c)
    moment = np.abs(_moment(f, alpha, x - x_c, y - y_c))
    along = 0.5 * moment / diameter(s, theta) ** 3
    place = np.take_along_axis(s, along.argmax(axis=0)[None], axis=0)[0]
    return Strains(largest=_peak(along), place=place)


def _integrated(
    derivative: Callable[[float, FloatArray], FloatArray], state: FloatArray, points: int
) -> FloatArray:
    """Integrate from 0 to 1 by Runge and Kutta's method of fourth order: states at all points."""
    step, states = 1.0 / (points - 1), [state]
    for t in np.linspace(0.0, 1.0 - step, points - 1):
        k1 = derivative(t, state)
        k2 = derivative(t + 0.5 * step, state + 0.5 * step * k1)
        k3 = derivative(t + 0.5 * step, state + 0.5 * step * k2)
        k4 = derivative(t + step, state + step * k3)
        state = state + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        states.append(state)
    return np.stack(states)


def _peak(values: FloatArray) -> FloatArray:
    """Largest values over equally spaced points, shape (points, n), refined by a parabola."""
    largest = values.argmax(axis=0)
    middle = np.clip(largest, 1, len(values) - 2)
    before, at, after = (values[middle + k, np.arange(values.shape[1])] for k in (-1, 0, 1))
    bend = 2.0 * at - before - after
    rise = np.divide((after - before) ** 2, 8.0 * bend, out=np.zeros_like(at), where=bend > 0.0)
    return np.asarray(np.where(largest == middle, at + rise, values.max(axis=0)))
