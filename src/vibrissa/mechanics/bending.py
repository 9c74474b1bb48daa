"""Measures of bending of a rod under a known contact force: energy, curvature, strain, turn."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vibrissa.mechanics.mounting import CLAMP_SLOPE, IDEAL, Mounting
from vibrissa.mechanics.taper import arc_density, arc_length, diameter, modulus, stiffness
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.batch import Batch

# Points along a rod, one Runge–Kutta step apart: the measures are then accurate to 1e-6 up to
# θ = 20, or θ = 4 if the rod passes through the surface. SciPy's integrators would take half a
# second to load.
POINTS = 201


@dataclass(frozen=True, eq=False, kw_only=True)
class Bending(Batch):
    """Measures of bending of n rods.

    Attributes
    ----------
    energy : ndarray, shape (n,)
        Bending energy ½·∫ m²/B ds (E·I0/L).
    curvature : ndarray, shape (n,)
        Largest change of curvature |φ' − κ0| (1/L).
    strain : ndarray, shape (n,)
        Largest strain |φ' − κ0|·d/2 at the rod's surface (d0/L).
    stress : ndarray, shape (n,)
        Largest stress E(s)·|φ' − κ0|·d/2 at the rod's surface (E(0)·d0/L).
    place : ndarray, shape (n,)
        Arc length at which the strain is largest (L), accurate to 0.005 L.
    turn : ndarray, shape (n,)
        Angle π/2 − φ1 between the normal of the surface and the rod at its contact point (rad).
    """

    energy: FloatArray
    curvature: FloatArray
    strain: FloatArray
    stress: FloatArray
    place: FloatArray
    turn: FloatArray


def measure(
    theta: FloatArray,
    f: FloatArray,
    alpha: FloatArray,
    x_c: FloatArray,
    y_c: FloatArray,
    s_c: FloatArray | float = 1.0,
    mounting: Mounting = IDEAL,
) -> Bending:
    """Measure the bending of n rods under known contact forces.

    Parameters
    ----------
    theta, f, alpha : ndarray, shape (n,)
        Taper factor, and magnitude (E·I0/L²) and inclination (rad) of the contact force.
    x_c, y_c, s_c : ndarray, shape (n,)
        Position of the contact point relative to the clamp, and its arc length (L).
    mounting : Mounting
        Mounting of all rods.

    Notes
    -----
    In a solid rod of one material the strain is |m|/(2·d³), as B = d⁴. It is largest at the clamp
    or where m'/m = 3·d'/d. If a small transverse force bends a rod with θ > 3/2, this is where d is
    3/2 of the tip diameter.

    The measures are unreliable if θ > 8 and the rod passes through the surface (φ1 < 0 in tip
    contact).
    """
    making, cos_alpha, sin_alpha = mounting.making, np.cos(alpha), np.sin(alpha)

    def moment(x: FloatArray | float, y: FloatArray | float) -> FloatArray:
        return f * (cos_alpha * (x - x_c) + sin_alpha * (y - y_c))

    def derivative(tau: float, state: FloatArray) -> FloatArray:
        x, y, phi, _ = state
        s = arc_length(tau, theta, s_c)
        m = moment(x, y)
        bent = m / stiffness(s, theta, making)
        natural = np.polynomial.polynomial.polyval(s, mounting.coefficients)
        per_length = [np.cos(phi), np.sin(phi), bent + natural, 0.5 * m * bent]
        return np.stack(per_length) * arc_density(tau, theta, s_c)

    begin = np.zeros((4, len(f)))
    begin[2] = CLAMP_SLOPE + mounting.clamp_angle + mounting.clamp_compliance * moment(0.0, 0.0)
    x, y, phi, energy = np.moveaxis(_integrated(derivative, begin, POINTS), 1, 0)
    s = arc_length(np.linspace(0.0, 1.0, POINTS)[:, None], theta, s_c)
    curvature = np.abs(moment(x, y)) / stiffness(s, theta, making)
    strain = 0.5 * curvature * diameter(s, theta)
    stress = modulus(s, making) * strain
    return Bending(
        energy=energy[-1],
        curvature=_peak(curvature),
        strain=_peak(strain),
        stress=_peak(stress),
        place=np.take_along_axis(s, strain.argmax(axis=0)[None], axis=0)[0],
        turn=CLAMP_SLOPE - phi[-1],
    )


def _integrated(
    derivative: Callable[[float, FloatArray], FloatArray], state: FloatArray, points: int
) -> FloatArray:
    """Integrate from 0 to 1 by the classical Runge–Kutta method; return states at all points."""
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
    """Maxima of n functions from equally spaced values, shape (points, n), refined by parabolas."""
    largest = values.argmax(axis=0)
    middle = np.clip(largest, 1, len(values) - 2)
    before, at, after = (values[middle + k, np.arange(values.shape[1])] for k in (-1, 0, 1))
    bend = 2.0 * at - before - after
    rise = np.divide((after - before) ** 2, 8.0 * bend, out=np.zeros_like(at), where=bend > 0.0)
    return np.asarray(np.where(largest == middle, at + rise, values.max(axis=0)))
