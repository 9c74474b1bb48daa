"""Our values of published quantities; the files in validation/sources name these functions.

The record shows the docstring of each function: the published quantity, and how we compute it.
"""

from collections.abc import Callable
from decimal import Decimal
from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, root

from vibrissa import Rod, StickingState, free_frequencies, solve_curve, solve_state
from vibrissa.mechanics.buckling import buckling_load
from vibrissa.mechanics.equations import FX, ClosingCondition, ends
from vibrissa.mechanics.mounting import IDEAL, rod_columns
from vibrissa.mechanics.newton import solve
from vibrissa.mechanics.states import RodStates
from vibrissa.outcomes import Contact
from vibrissa.sticking.solving.beginning import begin
from vibrissa.sticking.solving.offsets import solve_offset

# Step in which the load on a rod is raised (E·I0/L²).
LOAD_STEP = Decimal("0.5")
# Collocation nodes.
NODES = 64
# Heights between which a cylinder under α = 0 is sought; the published tips turn by 20° to 120°.
HEIGHTS = (0.1, 0.9999)
# Loads (E·I0/L²) and shortenings (L) from which a limit at zero is extrapolated.
SMALL_LOAD, SMALL_SHORTENING = Decimal("0.04"), 0.001


def conical_column(ratio: Decimal) -> float:
    """Critical load P·L²/(E·I_base) as a function of I_tip/I_base.

    Our force at α = 0 tends to this load as η → 1 (`buckling_load`). I is proportional to the
    fourth power of the diameter, so that θ = (I_tip/I_base)^(−1/4).
    """
    return float(buckling_load(np.array([float(ratio) ** -0.25]))[0])


def hinged_bar(half_length: Decimal) -> float:
    """Critical load of a bar hinged at both ends (lb) as a function of half its length (in).

    E = 3·10⁷ psi, 0.5 in × 0.5 in. By symmetry each half is a column clamped at one end and free at
    the other: our critical load at θ = 1, for L = half the length.
    """
    stiffness = 3e7 * 0.5**4 / 12.0
    return conical_column(Decimal(1)) * stiffness / float(half_length) ** 2


def double_tapered_first(taper: Decimal) -> float:
    """First natural frequency of a cantilever as a function of its taper 1 − h_tip/h_base.

    In units of √(E·I0/(ρA0·L⁴)). Height and breadth have the same taper: A is proportional to d²
    and I to d⁴, as of a truncated cone with θ = 1/(1 − taper). Ours: `free_frequencies`.
    """
    return _free_frequency(1.0 / (1.0 - float(taper)), 1)


def double_tapered_second(taper: Decimal) -> float:
    """Second natural frequency of a cantilever as a function of its taper 1 − h_tip/h_base.

    As `double_tapered_first`.
    """
    return _free_frequency(1.0 / (1.0 - float(taper)), 2)


def double_tapered_third(taper: Decimal) -> float:
    """Third natural frequency of a cantilever as a function of its taper 1 − h_tip/h_base.

    As `double_tapered_first`.
    """
    return _free_frequency(1.0 / (1.0 - float(taper)), 3)


def double_tapered_by_tip(mode: Decimal) -> float:
    """Natural frequencies of a cantilever with h_base/h_tip = b_base/b_tip = 4, by number.

    In units of √(E·I_tip/(ρ·A_tip·L⁴)), which are a quarter of ours.
    """
    return 4.0 * _free_frequency(4.0, int(mode))


def _free_frequency(theta: float, mode: int) -> float:
    return float(free_frequencies(theta, mode)[-1])


def post_buckled_load(tip_angle: Decimal) -> float:
    """Ratio of load to critical load, F/F_cr, as a function of the tip's rotation (degrees).

    Our α = 0 states at θ = 1: the force is vertical and free to move with the tip. The clamp holds
    φ = 90°, so that the tip has turned by 90° − φ1. F_cr = π²/4.
    """
    return float(_turned_by(tip_angle).state.f) / conical_column(Decimal(1))


def post_buckled_deflection(tip_angle: Decimal) -> float:
    """Sideways displacement of the tip as a function of its rotation (degrees), for L = 100 in.

    Our x1, in the same state.
    """
    return 100.0 * _turned_by(tip_angle).x1


def post_buckled_shortening(tip_angle: Decimal) -> float:
    """Displacement of the tip along the bar as a function of its rotation (degrees), L = 100 in.

    Our 1 − η, in the same state.
    """
    return 100.0 * (1.0 - _turned_by(tip_angle).eta)


def post_buckled_deflection_under(load_ratio: Decimal) -> float:
    """Sideways displacement of the tip as a function of F/F_cr, for L = 0.5 m.

    Our x1 in the α = 0 state at θ = 1 whose force is F.
    """
    return 0.5 * _loaded_by(load_ratio).x1


def post_buckled_shortening_under(load_ratio: Decimal) -> float:
    """Displacement of the tip along the bar as a function of F/F_cr, for L = 0.5 m.

    Our 1 − η, in the same state.
    """
    return 0.5 * (1.0 - _loaded_by(load_ratio).eta)


def cantilever_deflection(load: Decimal) -> float:
    """Displacement of the tip along the force, w/L, as a function of P·L²/(E·I).

    A dead force at right angles to the unloaded rod is our force at α = 90°, which points to +x.
    The state is the one with fx = P and fy = 0; w is its x1.
    """
    return dead_load(1.0, load, 90.0).x1


def cantilever_shortening(load: Decimal) -> float:
    """Displacement of the tip along the unloaded rod, u/L, as a function of P·L²/(E·I).

    Our 1 − η, in the same state.
    """
    return 1.0 - dead_load(1.0, load, 90.0).eta


def cantilever_rotation(load: Decimal) -> float:
    """Rotation of the tip (rad) as a function of P·L²/(E·I).

    Our π/2 − φ1, in the same state.
    """
    return _turn(dead_load(1.0, load, 90.0))


def pulled_frame_height(load: Decimal) -> float:
    """Displacement v/L of each loaded corner along its force, as a function of P·L²/(E·I).

    Four rods of length L form a square that stands on a corner. The upper and the lower corner are
    hinges and are pulled apart by 2P; the two others are rigid. By symmetry a rigid corner moves
    without turning, so that each rod is our clamped rod, with the force P at its tip, at 45° to the
    unloaded rod and away from the clamp: α = 135°. Across and along the unloaded rod the tip moves
    by x1 = (v + h)/√2 and η − 1 = (v − h)/√2; h is the inward displacement of the rigid corner.
    """
    tip = dead_load(1.0, load, 135.0)
    return (tip.x1 - (1.0 - tip.eta)) / np.sqrt(2.0)


def pulled_frame_width(load: Decimal) -> float:
    """Inward displacement h/L of each rigid corner as a function of P·L²/(E·I).

    From the same two equations.
    """
    tip = dead_load(1.0, load, 135.0)
    return (tip.x1 + (1.0 - tip.eta)) / np.sqrt(2.0)


def pulled_frame_slope(load: Decimal) -> float:
    """Slope of the rods at the hinges against the horizontal (rad), as a function of P·L²/(E·I).

    π/4 without load; the force turns the tip upright, by our π/2 − φ1.
    """
    return np.pi / 4.0 + _turn(dead_load(1.0, load, 135.0))


def pressed_frame_height(load: Decimal) -> float:
    """Displacement v/L of each loaded corner along its force, as a function of P·L²/(E·I).

    The same frame, pressed together: the force at the tip is at 45° to the unloaded rod and towards
    the clamp, α = 45°. Now x1 = (v + h)/√2 and 1 − η = (v − h)/√2; h is the outward displacement.
    """
    tip = dead_load(1.0, load, 45.0)
    return (tip.x1 + (1.0 - tip.eta)) / np.sqrt(2.0)


def pressed_frame_width(load: Decimal) -> float:
    """Outward displacement h/L of each rigid corner as a function of P·L²/(E·I).

    From the same two equations.
    """
    tip = dead_load(1.0, load, 45.0)
    return (tip.x1 - (1.0 - tip.eta)) / np.sqrt(2.0)


def pressed_frame_slope(load: Decimal) -> float:
    """Slope of the rods at the hinges against the horizontal (rad), as a function of P·L²/(E·I).

    π/4 without load; the force turns the tip down, by our π/2 − φ1.
    """
    return np.pi / 4.0 - _turn(dead_load(1.0, load, 45.0))


def console_deflection(force: Decimal) -> float:
    """Displacement of the tip along the force (m) as a function of the force (tf).

    L = 10 m, E·I = 100 tf·m²: the unit of force is 1 tf. Our x1 at α = 90°.
    """
    return 10.0 * cantilever_deflection(force)


def console_shortening(force: Decimal) -> float:
    """Displacement of the tip along the unloaded rod (m) as a function of the force (tf).

    Our 1 − η, in the same state.
    """
    return 10.0 * cantilever_shortening(force)


def console_moment(force: Decimal) -> float:
    """Moment at the clamp (tf·m) as a function of the force (tf).

    The unit of moment is 10 tf·m. The size of our m(0), in the same state.
    """
    return 10.0 * abs(dead_load(1.0, force, 90.0).reaction_m)


def console_stability(length: Decimal) -> float:
    """Critical load (tf) as a function of the length (m).

    E·I = 100 tf·m²; one end clamped, the other free. Our critical load at θ = 1.
    """
    return conical_column(Decimal(1)) * 100.0 / float(length) ** 2


def small_deflection(force: Decimal) -> float:
    """Displacement of the tip (m) as a function of the force (N).

    E = 2·10¹¹ Pa, L = 1 m, radius from 0.1 m to 0.05 m: θ = 2. Linear theory is the limit of small
    forces at α = 90°: our x1/f is extrapolated to f = 0.
    """
    return _per_small_load(lambda state: state.x1) * float(force) / _tapered().force_unit


def small_rotation(force: Decimal) -> float:
    """Rotation of the tip (rad) as a function of the force (N).

    Our (π/2 − φ1)/f, extrapolated to f = 0.
    """
    return _per_small_load(_turn) * float(force) / _tapered().force_unit


def small_stress(force: Decimal) -> float:
    """Largest stress at the clamp (Pa) as a function of the force (N).

    E times the strain at the rod's surface, |φ'(0)|·d0/2; our |φ'(0)|/f is extrapolated to f = 0.
    """
    rod = _tapered()
    curvature = _per_small_load(lambda state: abs(state.reaction_m)) / rod.length
    strain = curvature * rod.base_diameter / 2.0 * float(force) / rod.force_unit
    return rod.youngs_modulus * strain


def clamped_hinged_column(length: Decimal) -> float:
    """Critical load P_cr (E·I) as a function of the length.

    A tip that sticks straight above its clamp, x1 = 0, is a hinge that can move along the rod. Our
    −fy in this state, extrapolated to η = 1.
    """
    # −fy is linear in 1 − η close to it.
    once, twice = (
        -solve_state(1.0, 1.0 - shortening, 0.0).reaction_fy
        for shortening in (SMALL_SHORTENING, 2.0 * SMALL_SHORTENING)
    )
    return (2.0 * once - twice) / float(length) ** 2


# --- Equilibrium states. ---


class Loaded(NamedTuple):
    """A rod with a force at its tip, in any direction: position of the tip (L), force, state."""

    x1: float
    eta: float
    fx: float
    fy: float
    reaction_m: float
    phi1: float


@cache
def dead_load(theta: float, load: Decimal, direction: float) -> Loaded:
    """Solve for a rod under a given force at its tip, of fixed direction.

    Parameters
    ----------
    theta : float
        Taper factor.
    load : Decimal
        Force (E·I0/L²).
    direction : float
        Inclination α of the force in degrees, between 0 and 180.

    Returns
    -------
    Loaded

    Raises
    ------
    ArithmeticError
        If the state was not found.
    """
    alpha = np.radians(direction)
    force = float(load) * np.array([np.sin(alpha), -np.cos(alpha)])

    # Unknowns: x1, and (1 − η)/x1², which hardly changes while the rod bends little.
    def state(tip: np.ndarray) -> Loaded:
        x1, eta = float(tip[0]), float(1.0 - tip[1] * tip[0] ** 2)
        # `solve_state` refuses a force that pulls.
        found = solve_offset(theta, eta, IDEAL, x1, Contact.POINT).state
        if found is None:
            return Loaded(x1, eta, *[np.nan] * 4)
        loads = found.fx, found.fy, ends(found).moment, ends(found).phi1
        return Loaded(x1, eta, *(float(one[0]) for one in loads))

    def excess(tip: np.ndarray) -> np.ndarray:
        solved = state(tip)
        return np.array([solved.fx, solved.fy]) - force

    if load > LOAD_STEP:
        less = dead_load(theta, load - LOAD_STEP, direction)
        start = (less.x1, (1.0 - less.eta) / less.x1**2)
    else:
        # Linear theory: x1 = θ·fx/3; a cylinder's tip sinks by 3/5·x1².
        start = (theta * force[0] / 3.0, 0.6)
    found = root(excess, start, tol=1e-13)
    if not np.abs(found.fun).max() < 1e-9:
        raise ArithmeticError(f"θ = {theta}, load {load} at {direction}°: {found.message}")
    return state(found.x)


class Upright(NamedTuple):
    """A cylinder under a vertical force: position of its tip (L), and its state."""

    x1: float
    eta: float
    state: StickingState


def _upright(eta: float) -> Upright:
    curve = solve_curve(1.0, eta)
    return Upright(curve.x1_init, eta, curve.state(0.0))


@cache
def _turned_by(tip_angle: Decimal) -> Upright:
    phi1 = np.pi / 2.0 - np.radians(float(tip_angle))
    return _upright(brentq(lambda eta: phi1 - ends(_first(eta)).phi1[0], *HEIGHTS, xtol=1e-11))


@cache
def _loaded_by(load_ratio: Decimal) -> Upright:
    load = float(load_ratio) * conical_column(Decimal(1))
    return _upright(brentq(lambda eta: -_first(eta).fy[0] - load, *HEIGHTS, xtol=1e-11))


def _first(eta: float) -> RodStates:
    """Solve only the α = 0 state at a height, which is faster than following the whole path."""
    height, zero = np.array([eta]), np.zeros(1)
    begun = begin(rod_columns(np.ones(1), [IDEAL]), height, zero, NODES, Contact.POINT)
    return solve(begun.states, ClosingCondition.prescribing(height, {FX: 1.0})).states


def _turn(state: Loaded | StickingState) -> float:
    return float(np.pi / 2.0 - state.phi1)


def _tapered() -> Rod:
    return Rod(youngs_modulus=2e11, base_diameter=0.2, length=1.0)


def _per_small_load(measure: Callable[[Loaded], float]) -> float:
    """Extrapolate measure/force, which is an even function of the force, to zero force.

    Three forces eliminate the second and the fourth power; smaller forces add rounding errors.
    """
    quarter, half, whole = (
        measure(dead_load(2.0, SMALL_LOAD / part, 90.0)) * part / float(SMALL_LOAD)
        for part in (4, 2, 1)
    )
    return (64.0 * quarter - 20.0 * half + whole) / 45.0
