"""Natural frequencies of the states of an equilibrium path."""

import numpy as np

from vibrissa.errors import ArgumentError
from vibrissa.limits import check_bore
from vibrissa.mechanics.equations import ends
from vibrissa.mechanics.mounting import IDEAL, Mounting, rod_columns
from vibrissa.mechanics.states import SCALARS, ContactState, RodStates
from vibrissa.mechanics.taper import MOST_TAPER
from vibrissa.mechanics.vibration import natural_frequencies, needed_nodes, unloaded_states
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.numerics.spectral import gauss_rule
from vibrissa.outcomes import TipMotion

# Motions of a tip in contact.
MOTIONS_IN_CONTACT = (TipMotion.STICKS, TipMotion.SLIDES)
# Largest number of frequencies.
MOST_FREQUENCIES = 20
# Corrections of slopes below which an iteration ends (rad), and the largest number of corrections.
CONVERGED_CORRECTION, MOST_CORRECTIONS = 1e-11, 40
# Error of the moment at the clamp, relative to 1 + f, up to which a shape is accepted; otherwise
# the nodes are doubled, at most DOUBLINGS times.
ACCEPTED_ERROR, DOUBLINGS = 1e-9, 3


def check_vibration(count: object, tip: object) -> TipMotion:
    """Refuse a number of frequencies or a motion of the tip that is not allowed; return the motion.

    Raises
    ------
    ArgumentError
    """
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= MOST_FREQUENCIES:
        raise ArgumentError(
            f"count must be a whole number from 1 to {MOST_FREQUENCIES}, got {count!r}"
        )
    if not isinstance(tip, str) or tip not in MOTIONS_IN_CONTACT:
        raise ArgumentError(
            f"tip must be one of {', '.join(MOTIONS_IN_CONTACT)}, got {tip!r}; free_frequencies "
            "has the frequencies of a rod before contact"
        )
    return TipMotion(tip)


def free_frequencies(theta: float, count: int = 2, mounting: Mounting = IDEAL) -> FloatArray:
    """Lowest natural frequencies ω of a rod before contact.

    Parameters
    ----------
    theta : float
        Taper factor, from 1 to 50.
    count : int
        Number of frequencies.
    mounting : Mounting
        Its compliance, the natural curvature and the stiffness along the rod count.

    Returns
    -------
    ndarray, shape (count,)
        Increasing frequencies in rad·√(E·I0/(ρA0·L⁴)).

    Raises
    ------
    ArgumentError
        If an argument is out of range.

    Examples
    --------
    >>> print(free_frequencies(1).round(6), free_frequencies(2).round(6))
    [ 3.516015 22.034492] [ 4.62515  19.547613]
    """
    check_vibration(count, TipMotion.STICKS)
    if not 1.0 <= theta <= MOST_TAPER:
        raise ArgumentError(f"theta must lie between 1 and {MOST_TAPER:g}, got {theta!r}")
    check_bore(mounting.bore, theta)
    rod = unloaded_states(np.array([theta], dtype=float), [mounting], needed_nodes(theta, count))
    return np.asarray(natural_frequencies(rod, count, TipMotion.FREE)[0])


def state_frequencies(
    theta: float,
    mounting: Mounting,
    states: ContactState,
    line: BoolArray,
    count: int,
    tip: TipMotion,
) -> FloatArray:
    """Compute natural frequencies about n states of one rod, of which loads and contact are known.

    Parameters
    ----------
    states : ContactState
        Columns of shape (n,).
    line : ndarray of bool, shape (n,)
        Whether a state is in line contact.

    Returns
    -------
    ndarray, shape (n, count)
        Frequencies as of `vibrissa.mechanics.vibration.natural_frequencies`; NaN also where a state
        is NaN or its shape is not resolved.
    """
    found = np.full((len(line), count), np.nan)
    left = np.flatnonzero(np.isfinite(states.reaction_fx))
    nodes = needed_nodes(theta, count)
    for _ in range(DOUBLINGS + 1):
        some = states.take(left)
        shapes = shapes_under(theta, mounting, some, line[left], nodes)
        error = np.abs(ends(shapes).moment - some.reaction_m) / (1.0 + some.f)
        accepted = error < ACCEPTED_ERROR
        found[left[accepted]] = natural_frequencies(shapes.take(accepted), count, tip)
        left, nodes = left[~accepted], 2 * nodes
        if not len(left):
            break
    return found


def shapes_under(
    theta: float, mounting: Mounting, states: ContactState, line: BoolArray, nodes: int
) -> RodStates:
    """Compute the shapes of n states of one rod whose loads and contact are known.

    From the contact point, where φ = φ1 and m = 0, the equations are those of an initial value
    problem, whose solution is unique also at the limits of stability:

        φ = φ1 − ∫_τ¹ (m/B + κ0) ds ,   m = −∫_τ¹ (fx·sin φ − fy·cos φ) ds .

    Newton's iteration solves them at the nodes. The shapes are NaN if it does not converge.
    """
    rule, count = gauss_rule(nodes), len(line)
    scalars = np.stack([states.reaction_fx, states.reaction_fy, states.s_c], axis=1)
    rods = RodStates(
        rods=rod_columns(np.full(count, theta), [mounting] * count),
        unknowns=np.concatenate([np.zeros((count, nodes)), scalars], axis=1),
        line=line,
    )
    length, compliance = rods.densities(rule.nodes)
    bent = rods.natural_slope(rule.nodes) - rods.natural_slope(np.ones(1))
    unloaded = states.phi1[:, None] + bent
    fx, fy = rods.fx[:, None], rods.fy[:, None]
    phi = np.broadcast_to(unloaded, (count, nodes))
    size = np.full(count, np.inf)
    for _ in range(MOST_CORRECTIONS):
        sin, cos = length * np.sin(phi), length * np.cos(phi)
        moment = -(fx * sin - fy * cos) @ rule.to_end.T
        residual = phi - unloaded + (compliance * moment) @ rule.to_end.T
        by_moment = rule.to_end * compliance[:, None, :]
        by_slope = rule.to_end * (fx * cos + fy * sin)[:, None, :]
        change = np.linalg.solve(np.eye(nodes) - by_moment @ by_slope, residual[..., None])[..., 0]
        phi = phi - change
        size = np.abs(change).max(axis=1, initial=0.0)
        if not (size > CONVERGED_CORRECTION).any():
            break
    phi = np.where((size > CONVERGED_CORRECTION)[:, None], np.nan, phi)
    return rods.with_unknowns(np.concatenate([phi, rods.unknowns[:, -SCALARS:]], axis=1))
