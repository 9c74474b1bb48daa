"""Where sticking begins: the buckled rod under a vertical force, α = 0.

The critical load and the first mode of the clamped cone are known in closed form; the mode,
scaled to the height η, starts Newton's iteration for the large deflection.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from vibrissa.mechanics.equations import Closure, bending_moment
from vibrissa.mechanics.mounting import CLAMP_SLOPE
from vibrissa.mechanics.newton import solve
from vibrissa.mechanics.states import UNKNOWNS, RodStates
from vibrissa.mechanics.taper import arc_density
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.numerics.roots import bracketed_root
from vibrissa.numerics.spectral import gauss_rule

# Heights through which a strongly deflected state is approached where the buckling mode is too
# far from it.
CONTINUATION_STEPS = 12
CONTINUATION_START = 0.98


def _wave_number(theta: FloatArray) -> FloatArray:
    """First root κ ∈ [π/2, π) of (θ − 1)·sin κ + κ·cos κ = 0."""

    def condition(kappa: FloatArray, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
        sin, cos = np.sin(kappa), np.cos(kappa)
        return (theta - 1.0) * sin + kappa * cos, theta * cos - kappa * sin

    low, high = np.full_like(theta, np.pi / 2), np.full_like(theta, np.pi)
    return bracketed_root(condition, low, high, theta)


def buckling_load(theta: FloatArray) -> FloatArray:
    """Critical vertical load of the clamped cone with a free tip.

    It is the limit of the contact force f as η → 1: the first root of
    tan(θ·√f) = −θ·√f/(θ − 1).

    Parameters
    ----------
    theta : ndarray, shape (n,)
        Taper factors.

    Returns
    -------
    ndarray, shape (n,)
        Load, in units of E·I0/L²; π²/4 at θ = 1.

    Examples
    --------
    >>> print(buckling_load([1.0, 2.0]).round(6))  # the first is (π/2)²
    [2.467401 1.028965]
    """
    theta = np.asarray(theta, dtype=float)
    return (_wave_number(theta) / theta) ** 2


def buckling_mode(tau: FloatArray, theta: FloatArray) -> FloatArray:
    """Slope ψ = φ − π/2 of the first buckling mode, scaled to ψ(1) = −1.

    With κ = θ·√f the moment is m ∝ d·sin(κ·(1 − τ)), which solves d⁴·m'' + f·m = 0, and
    ψ = −m'/f.

    Parameters
    ----------
    tau : ndarray, shape (points,)
        Bending coordinate.
    theta : ndarray, shape (n,)
        Taper factors.

    Returns
    -------
    ndarray, shape (n, points)
        Slope, in units of its magnitude at the tip.
    """
    theta = np.asarray(theta, dtype=float)[:, None]
    kappa = _wave_number(theta)
    phase = kappa * (1.0 - tau)
    mode = (theta - 1.0) * np.sin(phase) + kappa * (1.0 + (theta - 1.0) * tau) * np.cos(phase)
    return -mode / (kappa * theta)


def initial_states(theta: FloatArray, eta: FloatArray, nodes: int) -> tuple[RodStates, BoolArray]:
    """Solve the α = 0 states in which a period of sticking begins.

    Parameters
    ----------
    theta, eta : ndarray, shape (n,)
        Taper factors and heights.
    nodes : int
        Number of collocation nodes.

    Returns
    -------
    states : RodStates
        First-mode states bent towards +x; NaN where none was found.
    converged : ndarray of bool, shape (n,)
    """
    states, converged = _vertical_states(buckled_states(theta, eta, nodes), eta)
    missing = np.flatnonzero(~converged)
    if len(missing):
        # Far from buckling: lower the contact point step by step instead.
        heights = CONTINUATION_START + np.linspace(0.0, 1.0, CONTINUATION_STEPS)[:, None] * (
            eta[missing] - CONTINUATION_START
        )
        guess = solution = buckled_states(theta[missing], heights[0], nodes)
        for number, height in enumerate(heights):
            before, (solution, found) = solution, _vertical_states(guess, height)
            guess = _further(before, solution) if number else solution
        states.put(missing, solution)
        converged[missing] = found
    return states, converged


def _further(before: RodStates, states: RodStates) -> RodStates:
    """Guess states as far from some as these are from those before them."""
    old, new = before.columns, states.columns
    guess: dict[str, Any] = {name: 2.0 * new[name] - old[name] for name in UNKNOWNS}
    return replace(states, **guess)


def _vertical_states(guess: RodStates, eta: FloatArray) -> tuple[RodStates, BoolArray]:
    """Solve at α = 0 and keep only first-mode states bent towards +x."""
    states, converged, _ = solve(guess, eta, Closure.at_inclination(np.zeros(len(guess))))
    # x < x1 all along the rod, that is m < 0 with f > 0: excludes higher modes and the mirror image
    first_mode = (bending_moment(states) < 0).all(axis=1) & (states.fy < 0)
    return states, converged & first_mode


def buckled_states(theta: FloatArray, eta: FloatArray, nodes: int) -> RodStates:
    """Guess α = 0 states: the buckling mode, scaled to shorten the rod's height to about η.

    Parameters
    ----------
    theta, eta : ndarray, shape (n,)
        Taper factors and heights.
    nodes : int
        Number of collocation nodes.

    Returns
    -------
    RodStates
        The better the closer η is to 1.
    """
    rule = gauss_rule(nodes)
    mode = buckling_mode(rule.nodes, theta)
    weights = rule.weights * arc_density(rule.nodes, theta[:, None])
    # Above the rod there is no state; a search for the height may ask there.
    room = np.where(eta <= 1.0, 1.0 - eta, np.nan)
    amplitude = np.sqrt(2.0 * room / (weights * mode**2).sum(axis=1))
    return RodStates(
        theta=theta,
        phi=CLAMP_SLOPE + amplitude[:, None] * mode,
        fx=np.zeros_like(theta),
        fy=-buckling_load(theta),
        s_c=np.ones_like(theta),
    )
