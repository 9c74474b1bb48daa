"""Stability: whether an equilibrium is a minimum of the energy."""

from collections.abc import Sequence

import numpy as np

from vibrissa.mechanics.mounting import polynomial
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.spectral import gauss_rule

# Stiffness that stands for a rigid constraint: larger ones lose the digits of the margin.
RIGID = 1e8


def stability(states: RodStates, *, slides: bool = False) -> FloatArray:
    """How far each equilibrium is from losing stability with clamp and contact point held fixed.

    It is a minimum of the bending energy under its constraints if the second variation
    ∫ B·ψ'² ds + ∫ (fx·cos φ + fy·sin φ)·ψ² ds is positive for every ψ with ψ(0) = 0 that keeps the
    contact point: ∫ ψ·sin φ ds = ∫ ψ·cos φ ds = 0, and ψ(s_c) = 0 in line contact if κ0(s_c) = 0.

    A yielding clamp adds ψ(0)²/c. A rod that is curved away from the surface, κ0(s_c) < 0, touches
    with another point when it turns there: this adds fy·ψ(s_c)²/κ0(s_c) > 0.

    Parameters
    ----------
    slides : bool
        Whether the contact point is free to slide along the surface: only its height is held.

    Returns
    -------
    ndarray, shape (n,)
        Least second variation per elastic energy of ψ: at most 1, positive where the equilibrium
        is stable, zero where it stops being so.
    """
    rule = gauss_rule(states.nodes)
    density, compliance = states.densities(rule.nodes)
    # ψ from u, the square root of its bending energy density: ∫ B·ψ'² ds = Σ u². One more
    # variable is the turn of the clamp, in units of the root of its energy.
    root = np.sqrt(rule.weights * compliance)
    turn = np.sqrt(states.clamp_compliance)[:, None]
    slope = rule.from_start * (compliance / root)[:, None, :]
    clamp = np.broadcast_to(turn[:, None], (*slope.shape[:2], 1))
    slope, touch = np.concatenate([slope, clamp], axis=2), np.hstack([root, turn])
    load = rule.weights * density
    sin, cos = np.sin(states.phi), np.cos(states.phi)
    load_slope = load * (states.fx[:, None] * cos + states.fy[:, None] * sin)
    quadratic = np.swapaxes(slope, 1, 2) @ (load_slope[:, :, None] * slope)
    # At a tip nothing holds the slope. Where the rod lies down a turn costs energy, or is held.
    curvature = polynomial(states.curvature, states.s_c[:, None])[:, 0]
    yields = states.line & (curvature < 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        held = np.where(yields, np.clip(states.fy / curvature, 0.0, RIGID), 0.0)
    quadratic += held[:, None, None] * touch[:, :, None] * touch[:, None, :]
    constraints = [np.vecmat(load * cos, slope), touch * (states.line & ~yields)[:, None]]
    if not slides:
        constraints.append(np.vecmat(load * sin, slope))
    return 1.0 + smallest_eigenvalue(quadratic, constraints)


def smallest_eigenvalue(matrices: FloatArray, normals: Sequence[FloatArray]) -> FloatArray:
    """Smallest eigenvalues of symmetric operators in the spaces normal to some vectors, at most 0.

    `matrices` are overwritten; NaN where one is not finite.
    """
    known: list[FloatArray] = []
    for normal in normals:
        for other in known:
            normal = normal - np.vecdot(other, normal)[:, None] * other
        # A vector of zeros holds nothing.
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        normal = np.divide(normal, length, out=np.zeros_like(normal), where=length > 0.0)
        known.append(normal)
        moved = np.matvec(matrices, normal)
        moved -= 0.5 * np.vecdot(normal, moved)[:, None] * normal
        matrices -= normal[:, :, None] * moved[:, None]
        matrices -= moved[:, :, None] * normal[:, None]
    finite = np.isfinite(matrices).all(axis=(1, 2))
    found = np.full(len(matrices), np.nan)
    found[finite] = np.linalg.eigvalsh(matrices[finite])[:, 0]
    return found
