"""Stability out of the plane: whether a rod with a round section stays in its plane.

The contact takes no moment out of the plane; a clamp yields alike in and out of it, not in torsion.
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
# Part of every unknown in the vector from which an eigenvector is sought.
A_LITTLE = 0.03


def stability_aside(states: RodStates) -> FloatArray:
    """How far each equilibrium is from lateral buckling, with clamp and contact point held fixed.

    The equilibrium is a minimum of the energy in space if the second variation (D1) of
    docs/lateral.md is positive for every small rotation ω(s) about axes in the plane, the contact
    point kept in it. A rigid clamp has ω(0) = 0; a yielding one adds (sin γ/γ)·q²/c (D9).

    Returns
    -------
    ndarray, shape (n,)
        Least second variation per elastic energy of ω: at most 1, positive where the rod stays in
        its plane, zero where it stops doing so.

    Notes
    -----
    The unknowns are the roots u of the elastic energy, which is Σ u². In (D1)
    −(F·ω)(ω·t) + (F·t)·|ω|² is (F·t)·(ω·n)² − (F·n)·(ω·t)(ω·n), and −M·(ω×ω')_z is
    M·((ω·n)·(ω'·t) − (ω·t)·(ω'·n)).
    """
    nodes, rule = states.nodes, gauss_rule(states.nodes)
    # Columns are states: an integral along the rod is one product of matrices for all of them.
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
        """Turn derivatives by ω·t, ω·n, ω'·t and ω'·n into derivatives by u."""
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
        """Half the derivative of (D1) by u, without the elastic energy."""
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
    # Begin with the rotation of (D4), which is the mode where the clamp passes under the contact.
    start = np.full_like(held, A_LITTLE)
    start[nodes:-1] += moment * bend / np.linalg.norm(moment * bend, axis=0)
    return 1.0 + smallest_eigenvalue(load_variation, start, [held])


def _clamp_turn(states: RodStates) -> FloatArray:
    """Rotation ω(0) that adds 1/2 to the energy of a yielding clamp (D9), shape (2, n)."""
    axis = CLAMP_SLOPE + states.clamp_angle
    turn = states.clamp_compliance * ends(states).moment
    # np.sinc has π in it.
    across, along = np.sinc(turn / np.pi), 0.5 * turn * np.sinc(0.5 * turn / np.pi) ** 2
    q = np.sqrt(states.clamp_compliance / across)
    return np.array(
        [
            q * (-across * np.sin(axis) - along * np.cos(axis)),
            q * (across * np.cos(axis) - along * np.sin(axis)),
        ]
    )
