"""Stability: whether an equilibrium is a minimum of the energy."""

import numpy as np

from vibrissa.mechanics.mounting import polynomial
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.eigenvalues import smallest_eigenvalue
from vibrissa.numerics.spectral import gauss_rule

# Stiffness that stands for a rigid constraint: larger ones lose the digits of the margin.
RIGID = 1e8


def stability(states: RodStates, *, slides: bool = False) -> FloatArray:
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
    # Columns are states: an integral along the rod is one product of matrices for all of them.
    length, compliance = (np.ascontiguousarray(d.T) for d in states.densities(rule.nodes))
    length *= rule.weights[:, None]
    phi = np.ascontiguousarray(states.phi.T)
    sin, cos = length * np.sin(phi), length * np.cos(phi)
    load_slope = states.fx * cos + states.fy * sin
    # ψ from u, the square root of its bending energy density: ∫ B·ψ'² ds = Σ u². One more
    # variable is the turn of the clamp, in units of the root of its energy.
    root = np.sqrt(rule.weights[:, None] * compliance)
    turn = np.sqrt(states.clamp_compliance)
    integral, touch = rule.from_start / rule.weights, np.vstack([root, turn])
    # At a tip nothing holds the slope. Where the rod lies down a turn costs energy, or is held.
    curvature = polynomial(states.curvature, states.s_c[:, None])[:, 0]
    yields = states.line & (curvature < 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        held = np.where(yields, np.clip(states.fy / curvature, 0.0, RIGID), 0.0)

    def transposed(psi: FloatArray) -> FloatArray:
        """Differentiate by u what depends on ψ."""
        return np.vstack([root * (integral.T @ psi), turn * psi.sum(axis=0)])

    def load_variation(u: FloatArray) -> FloatArray:
        """Halve the derivative of the second variation without the elastic energy."""
        psi = integral @ (root * u[:-1]) + turn * u[-1]
        return transposed(load_slope * psi) + held * (touch * u).sum(axis=0) * touch

    constraints = [transposed(cos), touch * (states.line & ~yields)]
    if not slides:
        constraints.append(transposed(sin))
    return 1.0 + smallest_eigenvalue(load_variation, np.ones_like(touch), constraints)
