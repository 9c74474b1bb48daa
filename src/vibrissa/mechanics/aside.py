"""Stability out of the plane: whether a rod with a round section stays in its plane.

The contact holds the rod as a ball joint does: it takes no moment out of the plane. In line contact
that is so, too, as the tail lies unloaded on the surface and turns freely in its plane. A yielding
clamp yields as much out of the plane as in it, and not about its axis.
"""

import numpy as np

from vibrissa.mechanics.equations import bending_moment, ends
from vibrissa.mechanics.mounting import CLAMP_SLOPE
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.spectral import gauss_rule

# Bending over torsional stiffness of a round section is 1 + POISSON_RATIO.
POISSON_RATIO = 0.3


def stability_aside(states: RodStates) -> FloatArray:
    """How far each equilibrium is from leaving its plane, with clamp and contact point held fixed.

    A planar equilibrium is a minimum of the energy among shapes in space if the second variation
    (D1) of docs/aside.md is positive for every small rotation ω(s) about axes in the plane that
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
    """
    rule = gauss_rule(states.nodes)
    density, compliance = states.densities(rule.nodes)
    cos, sin = np.cos(states.phi)[:, :, None], np.sin(states.phi)[:, :, None]
    # ω' from u, the square root of its elastic energy density: Σ u² is the sum of torsion and
    # bending. The variables are the twists at all nodes, ω' = twist·t, then the bends, bend·n.
    root = np.sqrt(rule.weights * compliance)[:, :, None]
    twist, bend = root * np.sqrt(1.0 + POISSON_RATIO), root
    integral = rule.from_start / rule.weights
    turn_x = np.concatenate([integral * _row(twist * cos), -integral * _row(bend * sin)], axis=2)
    turn_y = np.concatenate([integral * _row(twist * sin), integral * _row(bend * cos)], axis=2)
    if states.mounting is not None:
        # One more variable is the turn of the clamp, in units of the root of its energy.
        clamp_x, clamp_y = _clamp_turn(states)
        turn_x, turn_y = _with_column(turn_x, clamp_x), _with_column(turn_y, clamp_y)
    along, across = cos * turn_x + sin * turn_y, cos * turn_y - sin * turn_x

    # In (D1) −(F·ω)(ω·t) + (F·t)·|ω|² is (ω·n)·(fx·ωy − fy·ωx), and −M·(ω×ω')_z is
    # M·((ω·n)·(ω'·t) − (ω·t)·(ω'·n)), with ω' at a node from the variables there alone.
    load = (rule.weights * density)[:, :, None]
    lever = states.fx[:, None, None] * turn_y - states.fy[:, None, None] * turn_x
    moment = bending_moment(states)[:, :, None]
    half = np.swapaxes(across, 1, 2) @ (load * lever)
    half[:, :, : states.nodes] += np.swapaxes(moment * twist * across, 1, 2)
    half[:, :, states.nodes : 2 * states.nodes] -= np.swapaxes(moment * bend * along, 1, 2)

    held = (load * across).sum(axis=1)
    held /= np.linalg.norm(held, axis=1, keepdims=True)
    # Along `held` itself the projected form is zero, which no margin exceeds.
    image = np.matvec(half, held) + np.vecmat(held, half)
    image -= 0.5 * np.vecdot(held, image)[:, None] * held
    half -= image[:, :, None] * held[:, None]
    found = np.isfinite(image).all(axis=1)
    margin = np.full(len(states), np.nan)
    projected = half[found]
    projected += np.swapaxes(half[found], 1, 2)
    margin[found] = 1.0 + 0.5 * np.linalg.eigvalsh(projected)[:, 0]
    return margin


def _row(column: FloatArray) -> FloatArray:
    """Values at the nodes as a row of each state's matrix."""
    return np.swapaxes(column, 1, 2)


def _with_column(matrix: FloatArray, values: FloatArray) -> FloatArray:
    """Matrix of each state with one more column, which holds a single value."""
    column = np.broadcast_to(values[:, None, None], (*matrix.shape[:2], 1))
    return np.concatenate([matrix, column], axis=2)


def _clamp_turn(states: RodStates) -> tuple[FloatArray, FloatArray]:
    """Rotation ω(0) of a yielding clamp whose energy grows by 1/2, as (D9) has it."""
    mounting = states.mounting
    if mounting is None:
        return np.zeros(len(states)), np.zeros(len(states))
    axis = CLAMP_SLOPE + mounting.clamp_angle
    turn = mounting.clamp_compliance * ends(states).moment
    # np.sinc has π in it.
    across, along = np.sinc(turn / np.pi), 0.5 * turn * np.sinc(0.5 * turn / np.pi) ** 2
    q = np.sqrt(mounting.clamp_compliance / across)
    return (
        q * (-across * np.sin(axis) - along * np.cos(axis)),
        q * (across * np.cos(axis) - along * np.sin(axis)),
    )
