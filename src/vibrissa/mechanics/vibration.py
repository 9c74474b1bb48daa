"""Small vibrations of the rod about a state, and their natural frequencies.

A change ψ(s)·cos ωt of the slope moves the points of the rod by x = −∫₀ˢ ψ·sin φ du and
y = ∫₀ˢ ψ·cos φ du. With the mass w(s) per length, which is d² in a solid rod, ω² are the stationary
values of

    (second variation of the energy) / ∫ w·(x² + y²) ds                                  (V1)

in units of E·I0/(ρA0·L⁴). The second variation and the conditions at the contact point are those of
`vibrissa.mechanics.stability`.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.mounting import BORE, POWERS, Mounting, polynomial, rod_columns
from vibrissa.mechanics.stability import RIGID
from vibrissa.mechanics.states import SCALARS, RodStates
from vibrissa.mechanics.taper import (
    Making,
    arc_length,
    densities,
    diameter,
    mass_per_length,
    stiffness,
    stiffness_factor,
)
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.spectral import gauss_rule
from vibrissa.outcomes import TipMotion

# Fewest nodes along the rod, and further nodes for each frequency and for each unit of taper.
FEWEST_NODES, NODES_EACH, NODES_TAPER = 24, 4, 1
# The eigenvalues computed are 1/(ω² + SHIFT), which are finite at the limit of stability. Where ω²
# is below −SHIFT, the shift is multiplied by SHIFT_GROWTH.
SHIFT, SHIFT_GROWTH = 1.0, 16.0
# A condition at the contact point that is smaller is rounding: the height of an upright rod does
# not change.
ROUNDED_CONDITION = 1e-12


def natural_frequencies(
    states: RodStates, count: int, tip: TipMotion = TipMotion.STICKS
) -> FloatArray:
    """Compute the lowest natural frequencies ω (rad per unit of time) about n states.

    Returns
    -------
    ndarray, shape (n, count)
        Increasing frequencies in units of √(E·I0/(ρA0·L⁴)); NaN where ω² ≤ 0: an unstable state
        does not vibrate.
    """
    squares = squared_frequencies(states, count, tip)
    return np.asarray(np.sqrt(np.where(squares > 0.0, squares, np.nan)))


def squared_frequencies(
    states: RodStates, count: int, tip: TipMotion = TipMotion.STICKS
) -> FloatArray:
    """Compute the least ω² about n states: the least stationary values of (V1).

    Parameters
    ----------
    states : RodStates
        Equilibria. If the tip is free, only their rods count (`unloaded_states`).
    count : int
        Number of frequencies.
    tip : TipMotion
        If the tip sticks or slides, a straight rod in line contact has ψ(s_c) = 0, and its flat
        part rests, or slides without deformation. A rod that curves away from the surface rolls
        over its contact point, and the part beyond this point vibrates, too.

    Returns
    -------
    ndarray, shape (n, count)
        Increasing values in units of E·I0/(ρA0·L⁴): negative in unstable states, NaN where a state
        is NaN.
    """
    fine = states.on_nodes(
        max(states.nodes, needed_nodes(float(states.theta.max(initial=1.0)), count))
    )
    squares = np.full((len(states), count), np.nan)
    for row in np.flatnonzero(np.isfinite(fine.unknowns).all(axis=1)):
        squares[row] = _least_squares(_forms(fine.take(slice(row, row + 1)), tip), count)
    return squares


def needed_nodes(theta: float, count: int) -> int:
    """Choose the number of nodes that resolves `count` modes of a rod with this taper."""
    return FEWEST_NODES + NODES_EACH * count + round(NODES_TAPER * theta)


def unloaded_states(
    theta: FloatArray, mountings: Sequence[Mounting], nodes: int = FEWEST_NODES
) -> RodStates:
    """States of n rods before contact."""
    unknowns = np.zeros((len(theta), nodes + SCALARS))
    unknowns[:, -1] = 1.0
    line = np.zeros(len(theta), dtype=bool)
    rods = RodStates(rods=rod_columns(theta, mountings), unknowns=unknowns, line=line)
    slopes = np.broadcast_to(rods.natural_slope(gauss_rule(nodes).nodes), (len(theta), nodes))
    return rods.with_unknowns(np.concatenate([slopes, unknowns[:, nodes:]], axis=1))


class _Forms(NamedTuple):
    """Quadratic and linear forms of the unknowns of one state.

    Attributes
    ----------
    stiff, mass : ndarray, shape (size, size)
        Numerator and denominator of (V1).
    held : ndarray, shape (conditions, size)
        Linear forms that must vanish: the conditions at the contact point.
    """

    stiff: FloatArray
    mass: FloatArray
    held: FloatArray


class _Motion(NamedTuple):
    """Displacements at the nodes of a part of the rod and at its end, for unit unknowns.

    Attributes
    ----------
    x, y : ndarray, shape (nodes, size)
        Displacements at the nodes (L).
    x_end, y_end : ndarray, shape (size,)
        Displacements at the end (L).
    """

    x: FloatArray
    y: FloatArray
    x_end: FloatArray
    y_end: FloatArray


def _motion(psi: FloatArray, phi: FloatArray, density: FloatArray) -> _Motion:
    """Integrate changes ψ of the slope φ along a part of the rod, from its beginning."""
    rule = gauss_rule(len(phi))
    along = -(density * np.sin(phi))[:, None] * psi
    up = (density * np.cos(phi))[:, None] * psi
    return _Motion(
        x=rule.from_start @ along,
        y=rule.from_start @ up,
        x_end=rule.weights @ along,
        y_end=rule.weights @ up,
    )


def _forms(states: RodStates, tip: TipMotion) -> _Forms:
    """Evaluate the forms of a batch of one state.

    The unknowns are the moments at the nodes and the rotation of the clamp, scaled so that the
    elastic part of the second variation is the sum of their squares. If the part beyond the contact
    point vibrates, the moments at its own nodes follow.
    """
    rule, nodes, s_c = gauss_rule(states.nodes), states.nodes, float(states.s_c[0])
    theta, (fx,), (fy,) = float(states.theta[0]), states.fx, states.fy
    density, compliance = (values[0] for values in states.densities(rule.nodes))
    making = Making(bore=states.rods[0, BORE], powers=tuple(states.rods[0, POWERS]))
    integral = rule.from_start / rule.weights
    rolls, resistance = _rolling(states, tip)
    size = 2 * nodes + 1 if rolls else nodes + 1

    # From the clamp to the contact point.
    touch = np.zeros(size)
    touch[:nodes] = np.sqrt(rule.weights * compliance)
    touch[nodes] = np.sqrt(states.clamp_compliance[0])
    psi = np.zeros((nodes, size))
    psi[:, :nodes] = integral * touch[:nodes]
    psi[:, nodes] = touch[nodes]
    phi = states.phi[0]
    free = _motion(psi, phi, density)
    masses = (
        rule.weights * density * mass_per_length(arc_length(rule.nodes, theta, s_c), theta, making)
    )

    # Beyond the contact point: a truncated cone of its own, which starts with the slope ψ(s_c).
    thick, rest = float(diameter(s_c, theta)), 1.0 - s_c
    tail_density, softness = densities(rule.nodes, thick * theta)
    s = s_c + rest * arc_length(rule.nodes, thick * theta, 1.0)
    tail_psi = np.zeros((nodes, size))
    if rolls:
        factor = stiffness(s_c, theta) * stiffness_factor(s, theta, making)
        bend = np.sqrt(rule.weights * softness * rest / factor)
        tail_psi[:] = touch
        tail_psi[:, nodes + 1 :] = integral * bend
    beyond = _motion(tail_psi, _natural_turn(states, s), rest * tail_density)
    tail_masses = rule.weights * rest * tail_density * mass_per_length(s, theta, making)

    load = rule.weights * density * (fx * np.cos(phi) + fy * np.sin(phi))
    stiff = np.eye(size) + psi.T @ (load[:, None] * psi) + resistance * np.outer(touch, touch)
    x = np.concatenate([free.x, free.x_end + beyond.x])
    y = np.concatenate([free.y, free.y_end + beyond.y])
    weights = np.concatenate([masses, tail_masses])[:, None]
    mass = x.T @ (weights * x) + y.T @ (weights * y)
    held = []
    if tip is not TipMotion.FREE:
        held.append(free.y_end)
        if tip is TipMotion.STICKS:
            held.append(free.x_end)
        if states.line[0] and not rolls:
            held.append(touch)
    return _Forms(stiff=stiff, mass=mass, held=np.reshape(held, (-1, size)))


def _rolling(states: RodStates, tip: TipMotion) -> tuple[bool, float]:
    """Whether a rod rolls over its contact point, and the resistance fy/κ0(s_c) to its rotation."""
    curvature = float(polynomial(states.curvature, states.s_c[:, None])[0, 0])
    if tip is TipMotion.FREE or not states.line[0] or not curvature < 0.0:
        return False, 0.0
    resistance = max(float(states.fy[0]) / curvature, 0.0)
    return (True, resistance) if resistance < RIGID else (False, 0.0)


def _natural_turn(states: RodStates, s: FloatArray) -> FloatArray:
    """Slope of the unloaded part at arc lengths beyond the contact point, where it is 0 (rad)."""
    integral = states.curvature / np.arange(1, states.curvature.shape[1] + 1)
    begin = float(states.s_c[0]) * polynomial(integral, states.s_c[:, None])[0]
    return np.asarray(s * polynomial(integral, s[None])[0] - begin)


def _least_squares(forms: _Forms, count: int) -> FloatArray:
    """Least stationary values of stiff/mass among the unknowns for which `held` vanishes."""
    held = forms.held[np.abs(forms.held).max(axis=1) > ROUNDED_CONDITION]
    basis = np.linalg.qr(held.T, mode="complete")[0][:, len(held) :]
    stiff, mass = (basis.T @ form @ basis for form in (forms.stiff, forms.mass))
    shift = SHIFT
    while True:
        try:
            lower = np.linalg.cholesky(stiff + shift * mass)
        except np.linalg.LinAlgError:
            shift *= SHIFT_GROWTH
            continue
        half = np.linalg.solve(lower, mass)
        inverse = np.linalg.eigvalsh(np.linalg.solve(lower, half.T))[::-1][:count]
        return np.asarray(1.0 / inverse - shift)
