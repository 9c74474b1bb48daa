"""Stability: whether an equilibrium is a minimum of the energy."""

import numpy as np

from vibrissa.mechanics.mounting import polynomial
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.eigenvalues import smallest_eigenvalue
from vibrissa.numerics.spectral import gauss_rule

# Stiffness from which on a turn is held: the margin differs by less than 1e-6.
RIGID = 1e5


def stability(states: RodStates, *, slides: bool = False) -> FloatArray:
    """How far each equilibrium is from losing stability with clamp and contact point held fixed.

    The equilibrium is a minimum of the bending energy if the second variation
    ∫ B·ψ'² ds + ∫ (fx·cos φ + fy·sin φ)·ψ² ds is positive for every ψ with ψ(0) = 0 that keeps the
    contact point: ∫ ψ·sin φ ds = ∫ ψ·cos φ ds = 0, and ψ(s_c) = 0 in line contact if κ0(s_c) = 0.

    A yielding clamp frees ψ(0) and adds ψ(0)²/c. A rod curved away from the surface, κ0(s_c) < 0,
    rolls over its contact point: this frees ψ(s_c) and adds fy·ψ(s_c)²/κ0(s_c) > 0.

    Parameters
    ----------
    slides : bool
        Whether the contact point is free to slide along the surface: only its height is held.

    Returns
    -------
    ndarray, shape (n,)
        Least second variation per elastic energy of ψ: at most 1, positive where the equilibrium
        is stable, zero at the limit.
    """
    rule = gauss_rule(states.nodes)
    # Columns are states: an integral along the rod is one product of matrices for all of them.
    length, compliance = (np.ascontiguousarray(d.T) for d in states.densities(rule.nodes))
    length *= rule.weights[:, None]
    sin, cos = np.sin(states.phi).T, np.cos(states.phi).T
    load = length * (states.fx * cos + states.fy * sin)
    # ψ from u, the root of its bending energy density: ∫ B·ψ'² ds = Σ u². One more variable is the
    # turn of the clamp, in units of the root of its energy. At the contact point ψ is touch·u.
    bend, turn = np.sqrt(rule.weights[:, None] * compliance), np.sqrt(states.clamp_compliance)
    integral, touch = rule.from_start / rule.weights, np.concatenate([bend, turn[None]])
    # At a tip nothing holds the slope. Where the rod lies down a turn costs energy, or is held.
    curvature = polynomial(states.curvature, states.s_c[:, None])[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        stiffness = np.where(curvature < 0.0, np.maximum(states.fy / curvature, 0.0), np.inf)
    yields = states.line & (stiffness < RIGID)
    held = np.where(yields, stiffness, 0.0)

    def transposed(along: FloatArray) -> FloatArray:
        """Turn derivatives by ψ at the nodes into derivatives by u."""
        return np.concatenate([bend * (integral.T @ along), turn * along.sum(axis=0)[None]])

    def load_variation(u: FloatArray) -> FloatArray:
        """Half the derivative of the second variation by u, without the elastic energy."""
        psi = integral @ (bend * u[:-1]) + turn * u[-1]
        return transposed(load * psi) + held * touch * (touch * u).sum(axis=0)

    normals = [transposed(length * cos), touch * (states.line & ~yields)]
    if not slides:
        normals.append(transposed(length * sin))
    return 1.0 + smallest_eigenvalue(load_variation, np.ones_like(touch), normals)
