"""Stability out of the plane: whether a rod with a round section stays in its plane.

The contact holds the rod as a ball joint does: it takes no moment out of the plane. In line contact
that is so, too, as the tail lies unloaded on the surface and turns freely in its plane. A yielding
clamp yields as much out of the plane as in it, and not about its axis.
"""

import numpy as np

from vibrissa.mechanics.equations import bending_moment, ends
from vibrissa.mechanics.mounting import CLAMP_SLOPE
from vibrissa.mechanics.stability import smallest_eigenvalue
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.spectral import gauss_rule

# Bending over torsional stiffness of a round section is 1 + POISSON_RATIO.
POISSON_RATIO = 0.3


def stability_aside(states: RodStates) -> FloatArray:
    """How far each equilibrium is from lateral buckling, with clamp and contact point held fixed.

    A planar equilibrium is a minimum of the energy among shapes in space if the second variation
    (D1) of docs/lateral.md is positive for every small rotation ω(s) about axes in the plane that
    keeps the contact point in the plane. At a rigid clamp ω(0) = 0. A yielding one turns out of the
    plane by q, which adds (sin γ/γ)·q²/c, where γ is its turn in the plane (D9).

    Parameters
    ----------
    states : RodStates

    Returns
    -------
    ndarray, shape (n,)
        Least second variation per elastic energy of ω: at most 1, positive where the rod stays in
        its plane, zero where it stops doing so.

    Notes
    -----
    The unknowns are the roots u of the elastic energy, which is Σ u²: the twists at all nodes, the
    bends, and the turn of the clamp. In (D1) −(F·ω)(ω·t) + (F·t)·|ω|² is
    (F·t)·(ω·n)² − (F·n)·(ω·t)(ω·n), and −M·(ω×ω')_z is M·((ω·n)·(ω'·t) − (ω·t)·(ω'·n)).
    """
    nodes, rule = states.nodes, gauss_rule(states.nodes)
    density, compliance = states.densities(rule.nodes)
    cos, sin = np.cos(states.phi), np.sin(states.phi)
    # ω'·t and ω'·n at the nodes for u = 1, times their weights.
    bend = np.sqrt(rule.weights * compliance)
    twist = np.sqrt(1.0 + POISSON_RATIO) * bend
    # ω in the directions of the surface, and along the rod and across it, by u.
    integral, clamp = rule.from_start / rule.weights, _clamp_turn(states)[:, :, None, None]
    x, y = (
        np.concatenate([integral * one[:, None], integral * other[:, None], turn], axis=2)
        for one, other, turn in (
            (cos * twist, -sin * bend, np.broadcast_to(clamp[0], (len(states), nodes, 1))),
            (sin * twist, cos * bend, np.broadcast_to(clamp[1], (len(states), nodes, 1))),
        )
    )
    along = cos[:, :, None] * x + sin[:, :, None] * y
    across = cos[:, :, None] * y - sin[:, :, None] * x
    length, moment = rule.weights * density, 0.5 * bending_moment(states)
    fx, fy = 0.5 * states.fx[:, None], 0.5 * states.fy[:, None]
    pull, shear = length * (fx * cos + fy * sin), length * (fy * cos - fx * sin)
    transposed = np.swapaxes(across, 1, 2)
    half = transposed @ (pull[:, :, None] * across - shear[:, :, None] * along)
    half[:, :, :nodes] += transposed * (moment * twist)[:, None]
    half[:, nodes : 2 * nodes] -= (moment * bend)[:, :, None] * along
    # (D2): the contact point stays in the plane.
    held = np.vecmat(length, across)
    return 1.0 + smallest_eigenvalue(half + np.swapaxes(half, 1, 2), [held])


def _clamp_turn(states: RodStates) -> FloatArray:
    """Rotation ω(0) of a yielding clamp whose energy grows by 1/2, as (D9) has it, shape (2, n)."""
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
