"""Stability: whether an equilibrium is a minimum of the energy."""

import numpy as np

from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.spectral import gauss_rule
from vibrissa.outcomes import Contact


def stability(states: RodStates, contact: Contact) -> FloatArray:
    """How far each equilibrium is from losing stability with clamp and contact point held fixed.

    An equilibrium is a minimum of the bending energy under its constraints if the second
    variation ∫ B·ψ'² ds + ∫ (fx·cos φ + fy·sin φ)·ψ² ds is positive for every ψ with ψ(0) = 0 that
    keeps the contact point: ∫ ψ·sin φ ds = ∫ ψ·cos φ ds = 0, and ψ(s_c) = 0 where the rod lies
    tangentially on the surface.

    Parameters
    ----------
    states : RodStates
    contact : Contact
        Kind of contact of all states.

    Returns
    -------
    ndarray, shape (n,)
        Least second variation per bending energy of ψ: at most 1, positive where the equilibrium
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
    quadratic = np.swapaxes(slope, 1, 2) @ (load_slope[:, :, None] * slope)
    constraints = [
        np.vecmat(load * np.sin(states.phi), slope),
        np.vecmat(load * np.cos(states.phi), slope),
    ]
    if contact is Contact.LINE:
        constraints.append(root)
    basis, _ = np.linalg.qr(np.stack(constraints, axis=-1), mode="complete")
    free = basis[:, :, len(constraints) :]
    projected = np.swapaxes(free, 1, 2) @ quadratic @ free
    found = np.isfinite(projected).all(axis=(1, 2))
    margin = np.full(len(states), np.nan)
    margin[found] = 1.0 + np.linalg.eigvalsh(projected[found])[:, 0]
    return margin
