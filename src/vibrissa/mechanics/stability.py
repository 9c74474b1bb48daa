"""Stability: whether an equilibrium is a minimum of the energy."""

import numpy as np

from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.spectral import gauss_rule
from vibrissa.outcomes import Contact

# Stiffness that stands for a rigid constraint: larger ones lose the digits of the margin.
RIGID = 1e8


def stability(states: RodStates, contact: Contact, *, slides: bool = False) -> FloatArray:
    """How far each equilibrium is from losing stability with clamp and contact point held fixed.

    An equilibrium is a minimum of the bending energy under its constraints if the second
    variation ∫ B·ψ'² ds + ∫ (fx·cos φ + fy·sin φ)·ψ² ds is positive for every ψ with ψ(0) = 0 that
    keeps the contact point: ∫ ψ·sin φ ds = ∫ ψ·cos φ ds = 0, and ψ(s_c) = 0 where the rod lies
    tangentially on the surface.

    A yielding clamp turns by ψ(0), which adds ψ(0)²/c. A rod that is curved away from the surface,
    κ0(s_c) < 0, touches it with another point s_c when it turns there, which adds
    fy·ψ(s_c)²/κ0(s_c), a positive number; where κ0(s_c) = 0 it is infinite unless ψ(s_c) = 0.

    Parameters
    ----------
    states : RodStates
    contact : Contact
        Kind of contact of all states.
    slides : bool
        Whether the contact point is free to slide along the surface, as if without friction: only
        its height is held.

    Returns
    -------
    ndarray, shape (n,)
        Least second variation per elastic energy of ψ: at most 1, positive where the equilibrium
        is stable, zero where it stops being so.
    """
    rule = gauss_rule(states.nodes)
    density, compliance = states.densities(rule.nodes)
    # ψ from u, the square root of its bending energy density: ∫ B·ψ'² ds = Σ u²
    root = np.sqrt(rule.weights * compliance)
    slope = rule.from_start * (compliance / root)[:, None, :]
    load = rule.weights * density
    load_slope = load * (
        states.fx[:, None] * np.cos(states.phi) + states.fy[:, None] * np.sin(states.phi)
    )
    touch = root
    if states.mounting is not None:
        # One more variable is the turn of the clamp, in units of the root of its energy.
        turn = np.sqrt(states.mounting.clamp_compliance)[:, None]
        clamp = np.broadcast_to(turn[:, None], (*slope.shape[:2], 1))
        slope, touch = np.concatenate([slope, clamp], axis=2), np.hstack([root, turn])
    constraints = [] if slides else [np.vecmat(load * np.sin(states.phi), slope)]
    constraints.append(np.vecmat(load * np.cos(states.phi), slope))
    quadratic = np.swapaxes(slope, 1, 2) @ (load_slope[:, :, None] * slope)
    if contact is Contact.LINE:
        if states.mounting is None:
            constraints.append(touch)
        else:
            held = _held(states.fy, states.mounting.natural_curvature(states.s_c[:, None])[:, 0])
            quadratic += held[:, None, None] * touch[:, :, None] * touch[:, None, :]
    basis, _ = np.linalg.qr(np.stack(constraints, axis=-1), mode="complete")
    free = basis[:, :, len(constraints) :]
    projected = np.swapaxes(free, 1, 2) @ quadratic @ free
    found = np.isfinite(projected).all(axis=(1, 2))
    margin = np.full(len(states), np.nan)
    margin[found] = 1.0 + np.linalg.eigvalsh(projected[found])[:, 0]
    return margin


def _held(fy: FloatArray, curvature: FloatArray) -> FloatArray:
    """Stiffness fy/κ0(s_c) against a turn at the contact point; rigid where κ0 is not negative."""
    with np.errstate(divide="ignore"):
        return np.where(curvature < 0.0, np.clip(fy / curvature, 0.0, RIGID), RIGID)
