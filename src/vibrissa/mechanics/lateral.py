"""Lateral stability: whether a rod with a round section stays in its plane, or buckles out of it.

The contact transmits no moment out of the plane. A compliant clamp yields equally in the plane and
out of it, but not in torsion.
"""

import numpy as np

from vibrissa.mechanics.equations import bending_moment, ends
from vibrissa.mechanics.mounting import CLAMP_SLOPE
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.eigenvalues import smallest_eigenvalue
from vibrissa.numerics.spectral import gauss_rule

# Bending over torsional stiffness of a round section is 1 + POISSON_RATIO.
POISSON_RATIO = 0.3
# Share of every unknown in the start vector, so that no eigenvector is missed.
A_LITTLE = 0.03


def lateral_stability(states: RodStates) -> FloatArray:
    """Compute margins against lateral buckling, with clamp and contact point held.

    Let each cross-section turn by a small rotation ω(s) about an axis in the plane of bending. An
    equilibrium is a minimum of the energy in space if the second variation, (D1) of docs/lateral.md
    (which defines the symbols), is positive for every ω that keeps the contact point in the plane.
    A rigid clamp has ω(0) = 0. A compliant clamp turns too, and its energy (D9) is added to (D1).

    Returns
    -------
    ndarray, shape (n,)
        Smallest ratio of the second variation to its elastic part (bending, torsion and clamp,
        without the loads). It is at most 1, positive where the rod stays in its plane, and zero
        where the rod buckles.

    Notes
    -----
    The unknowns u are scaled so that the elastic part is Σ u². In the directions t and n, the terms
    −(F·ω)(ω·t) + (F·t)·|ω|² of (D1) are (F·t)·(ω·n)² − (F·n)·(ω·t)(ω·n), and the term −M·(ω×ω')_z
    is M·((ω·n)·(ω'·t) − (ω·t)·(ω'·n)).
    """
    nodes, rule = states.nodes, gauss_rule(states.nodes)
    # Each column is a state, so that one matrix product integrates along all rods.
    length, compliance = (np.ascontiguousarray(d.T) for d in states.densities(rule.nodes))
    length *= rule.weights[:, None]
    phi, moment = np.ascontiguousarray(states.phi.T), 0.5 * bending_moment(states).T
    cos, sin = np.cos(phi), np.sin(phi)
    # ω'·t and ω'·n at the nodes for u = 1, times their weights.
    bend = np.sqrt(rule.weights[:, None] * compliance)
    twist = np.sqrt(1.0 + POISSON_RATIO) * bend
    pull = length * (states.fx * cos + states.fy * sin)
    shear = 0.5 * length * (states.fy * cos - states.fx * sin)
    integral, clamp = rule.from_start / rule.weights, _clamp_turn(states)

    def transposed(
        along: FloatArray, across: FloatArray, twisted: FloatArray, bent: FloatArray
    ) -> FloatArray:
        """Convert derivatives with respect to ω·t, ω·n, ω'·t, ω'·n to those with respect to u."""
        x, y = cos * along - sin * across, sin * along + cos * across
        sum_x, sum_y = integral.T @ x, integral.T @ y
        return np.concatenate(
            [
                twist * (cos * sum_x + sin * sum_y + twisted),
                bend * (cos * sum_y - sin * sum_x + bent),
                (clamp[0] * x + clamp[1] * y).sum(axis=0, keepdims=True),
            ]
        )

    def load_variation(u: FloatArray) -> FloatArray:
        """Half the derivative of (D1) with respect to u, without the elastic part."""
        twisted, bent = twist * u[:nodes], bend * u[nodes:-1]
        x = integral @ (cos * twisted - sin * bent) + clamp[0] * u[-1]
        y = integral @ (sin * twisted + cos * bent) + clamp[1] * u[-1]
        along, across = cos * x + sin * y, cos * y - sin * x
        return transposed(
            -moment * bent - shear * across,
            moment * twisted + pull * across - shear * along,
            moment * across,
            -moment * along,
        )

    # (D2): the contact point stays in the plane.
    nothing = np.zeros_like(phi)
    held = transposed(nothing, length, nothing, nothing)
    # Start with the rotation (D4): a rod buckles in it as the clamp passes under the contact point.
    start = np.full_like(held, A_LITTLE)
    start[nodes:-1] += moment * bend / np.linalg.norm(moment * bend, axis=0)
    return 1.0 + smallest_eigenvalue(load_variation, start, [held])


def _clamp_turn(states: RodStates) -> FloatArray:
    """Rotation ω(0) of each compliant clamp about x and y for u = 1, by (D9); shape (2, n)."""
    axis = CLAMP_SLOPE + states.clamp_angle
    turn = states.clamp_compliance * ends(states).moment
    # np.sinc(x) is sin(πx)/(πx).
    across, along = np.sinc(turn / np.pi), 0.5 * turn * np.sinc(0.5 * turn / np.pi) ** 2
    q = np.sqrt(states.clamp_compliance / across)
    return np.array(
        [
            q * (-across * np.sin(axis) - along * np.cos(axis)),
            q * (across * np.cos(axis) - along * np.sin(axis)),
        ]
    )
