"""Stability in the plane: whether an equilibrium is a minimum of the energy."""

import numpy as np

from vibrissa.mechanics.mounting import polynomial
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.eigenvalues import smallest_eigenvalue
from vibrissa.numerics.spectral import gauss_rule

# Stiffness above which a rotation counts as prevented; the margin then differs by less than 1e-6.
RIGID = 1e5


def stability(states: RodStates, *, slides: bool = False) -> FloatArray:
    """Compute margins of stability in the plane, with clamp and contact point held.

    An equilibrium is a minimum of the energy if the second variation
    ∫ B·ψ'² ds + ∫ (fx·cos φ + fy·sin φ)·ψ² ds is positive for every admissible change ψ(s) of the
    slope. Such a change does not turn the clamp, ψ(0) = 0, and does not move the contact point,
    ∫ ψ·sin φ ds = ∫ ψ·cos φ ds = 0. In line contact of a rod with κ0(s_c) = 0, also ψ(s_c) = 0.

    A compliant clamp turns: ψ(0) is free, and ψ(0)²/c is added to the second variation. In line
    contact a rod that curves away from the surface, κ0(s_c) < 0, rolls over its contact point:
    ψ(s_c) is free, and fy·ψ(s_c)²/κ0(s_c) > 0 is added.

    Parameters
    ----------
    slides : bool
        Whether the contact point is free to slide along the surface, with only its height held.

    Returns
    -------
    ndarray, shape (n,)
        Smallest ratio of the second variation to its elastic part, ∫ B·ψ'² ds + ψ(0)²/c. It is at
        most 1, positive where the equilibrium is stable, and zero at the limit of stability.
    """
    rule = gauss_rule(states.nodes)
    # Each column is a state, so that one matrix product integrates along all rods.
    length, compliance = (np.ascontiguousarray(d.T) for d in states.densities(rule.nodes))
    length *= rule.weights[:, None]
    sin, cos = np.sin(states.phi).T, np.cos(states.phi).T
    load = length * (states.fx * cos + states.fy * sin)
    # The unknowns u are scaled so that the elastic part is Σ u²; the last one is the clamp's
    # rotation. At the contact point ψ = touch·u.
    bend, turn = np.sqrt(rule.weights[:, None] * compliance), np.sqrt(states.clamp_compliance)
    integral, touch = rule.from_start / rule.weights, np.concatenate([bend, turn[None]])
    # At the contact point the slope of a tip is free. In line contact its rotation costs energy, or
    # is prevented.
    curvature = polynomial(states.curvature, states.s_c[:, None])[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        stiffness = np.where(curvature < 0.0, np.maximum(states.fy / curvature, 0.0), np.inf)
    yields = states.line & (stiffness < RIGID)
    held = np.where(yields, stiffness, 0.0)

    def transposed(along: FloatArray) -> FloatArray:
        """Convert derivatives with respect to ψ at the nodes to those with respect to u."""
        return np.concatenate([bend * (integral.T @ along), turn * along.sum(axis=0)[None]])

    def load_variation(u: FloatArray) -> FloatArray:
        """Return the derivative of half the second variation by u, without the elastic part."""
        psi = integral @ (bend * u[:-1]) + turn * u[-1]
        return transposed(load * psi) + held * touch * (touch * u).sum(axis=0)

    normals = [transposed(length * cos), touch * (states.line & ~yields)]
    if not slides:
        normals.append(transposed(length * sin))
    return 1.0 + smallest_eigenvalue(load_variation, np.ones_like(touch), normals)
