"""The buckled rod under a vertical force, α = 0, close to its critical load."""

import numpy as np

from vibrissa.mechanics.mounting import CLAMP_SLOPE
from vibrissa.mechanics.taper import arc_density
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.roots import bracketed_root
from vibrissa.numerics.spectral import gauss_rule


def _wave_number(theta: FloatArray) -> FloatArray:
    """First root κ ∈ [π/2, π) of (θ − 1)·sin κ + κ·cos κ = 0."""

    def condition(kappa: FloatArray, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
        sin, cos = np.sin(kappa), np.cos(kappa)
        return (theta - 1.0) * sin + kappa * cos, theta * cos - kappa * sin

    low, high = np.full_like(theta, np.pi / 2), np.full_like(theta, np.pi)
    return bracketed_root(condition, low, high, theta)


def buckling_load(theta: FloatArray) -> FloatArray:
    """Critical vertical load of the clamped cone with a free tip (E·I0/L²); π²/4 at θ = 1.

    It is the limit of the contact force f as η → 1: the first root of
    tan(θ·√f) = −θ·√f/(θ − 1).

    Examples
    --------
    >>> print(buckling_load([1.0, 2.0]).round(6))  # the first is (π/2)²
    [2.467401 1.028965]
    """
    theta = np.asarray(theta, dtype=float)
    return _load(theta, _wave_number(theta))


def _load(theta: FloatArray, kappa: FloatArray) -> FloatArray:
    return np.asarray((kappa / theta) ** 2)


def buckling_mode(tau: FloatArray, theta: FloatArray) -> FloatArray:
    """Slope ψ = φ − π/2 of the first buckling mode at `tau`, scaled to −1 at the tip.

    For the buckling load f and κ = θ·√f, the moment m ∝ d·sin(κ·(1 − τ)) solves
    d⁴·m'' + f·m = 0, and ψ = −m'/f. The result has the shape (n, len(tau)).
    """
    theta = np.asarray(theta, dtype=float)
    return _mode(tau, theta, _wave_number(theta))


def _mode(tau: FloatArray, theta: FloatArray, kappa: FloatArray) -> FloatArray:
    theta, kappa = theta[:, None], kappa[:, None]
    phase = kappa * (1.0 - tau)
    mode = (theta - 1.0) * np.sin(phase) + kappa * (1.0 + (theta - 1.0) * tau) * np.cos(phase)
    return -mode / (kappa * theta)


def buckled_unknowns(theta: FloatArray, eta: FloatArray, nodes: int) -> FloatArray:
    """Guess states with α = 0 in tip contact: buckling modes scaled to heights near `eta`.

    Returns
    -------
    ndarray, shape (n, nodes + 3)
        Unknowns of the states, as in `vibrissa.mechanics.states.RodStates`.
    """
    rule, kappa = gauss_rule(nodes), _wave_number(theta)
    mode = _mode(rule.nodes, theta, kappa)
    weights = rule.weights * arc_density(rule.nodes, theta[:, None])
    amplitude = np.sqrt(2.0 * (1.0 - eta) / (weights * mode**2).sum(axis=1))
    phi = CLAMP_SLOPE + amplitude[:, None] * mode
    fx, s_c = np.zeros_like(theta), np.ones_like(theta)
    return np.column_stack([phi, fx, -_load(theta, kappa), s_c])
