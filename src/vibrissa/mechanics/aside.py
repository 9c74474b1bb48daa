"""Stability out of the plane: whether a rod with a round section stays in its plane.

The contact holds the rod as a ball joint does: it takes no moment out of the plane. In line contact
that is so, too, as the tail lies unloaded on the surface and turns freely in its plane.
"""

import numpy as np

from vibrissa.mechanics.equations import bending_moment
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.spectral import gauss_rule

# Bending over torsional stiffness of a round section is 1 + POISSON_RATIO.
POISSON_RATIO = 0.3


def stability_aside(states: RodStates) -> FloatArray:
    """How far each equilibrium is from leaving its plane, with clamp and contact point held fixed.

    A planar equilibrium is a minimum of the energy among shapes in space if the second variation
    (D1) of docs/aside.md is positive for every small rotation ω(s) about axes in the plane, with
    ω(0) = 0, that keeps the contact point in the plane.

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
    cos, sin = np.cos(states.phi), np.sin(states.phi)
    # ω' from u, the square root of its elastic energy density: Σ u² is the sum of torsion and
    # bending; each column belongs to the twist or to the bend at one node.
    root = np.sqrt(rule.weights * compliance)
    twist, bend = root * np.sqrt(1.0 + POISSON_RATIO), root
    slope_x = _side_by_side(twist * cos, -bend * sin)
    slope_y = _side_by_side(twist * sin, bend * cos)
    turn_x = rule.from_start @ (slope_x / rule.weights[:, None])
    turn_y = rule.from_start @ (slope_y / rule.weights[:, None])

    def form(left: FloatArray, values: FloatArray, right: FloatArray) -> FloatArray:
        return np.asarray(np.swapaxes(left, 1, 2) @ (values[:, :, None] * right))

    moment, load = bending_moment(states), rule.weights * density
    fx, fy = states.fx[:, None] * load, states.fy[:, None] * load
    half = (
        form(turn_y, moment, slope_x)
        - form(turn_x, moment, slope_y)
        + form(turn_x, fy * sin, turn_x)
        + form(turn_y, fx * cos, turn_y)
        - form(turn_x, fx * sin + fy * cos, turn_y)
    )
    quadratic = 0.5 * (half + np.swapaxes(half, 1, 2))
    held = np.vecmat(load * cos, turn_y) - np.vecmat(load * sin, turn_x)
    held /= np.linalg.norm(held, axis=1, keepdims=True)
    # Along `held` itself the projected form is zero, which no margin exceeds.
    across = np.eye(held.shape[1]) - held[:, :, None] * held[:, None, :]
    projected = across @ quadratic @ across
    found = np.isfinite(projected).all(axis=(1, 2))
    margin = np.full(len(states), np.nan)
    margin[found] = 1.0 + np.linalg.eigvalsh(projected[found])[:, 0]
    return margin


def _side_by_side(twist: FloatArray, bend: FloatArray) -> FloatArray:
    """Two diagonal matrices for each state, side by side."""
    eye = np.eye(twist.shape[1])
    return np.concatenate([twist[:, :, None] * eye, bend[:, :, None] * eye], axis=2)
