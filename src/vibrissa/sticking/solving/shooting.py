"""The paper's own procedure, as a check: Runge–Kutta in a Nelder–Mead search, in steps of Δx0."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vibrissa.mechanics.admissibility import CLEARANCE_TOLERANCE, LIMITING_CLEARANCES, clearances
from vibrissa.mechanics.buckling import buckled_unknowns
from vibrissa.mechanics.elastica import deformed_shape, rod_equations
from vibrissa.mechanics.equations import ends
from vibrissa.mechanics.mounting import IDEAL, rod_columns
from vibrissa.mechanics.states import RodStates
from vibrissa.mechanics.taper import arc_density
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.spectral import chebyshev_nodes, gauss_rule
from vibrissa.outcomes import Contact, RodSection, Solver, Status
from vibrissa.sticking.curve import StickingCurve, failed_curve
from vibrissa.sticking.locks import ShapeLimits, assembled_curves
from vibrissa.sticking.piece import STATES_PER_PIECE, PathState, Pieces

METHOD = Solver.SHOOTING
# Largest step between states that are interpolated, in units of x1_init; a larger Δx0 is divided
# evenly.
LARGEST_STEP = 0.01
# Number of heights, and the first of them, through which the α = 0 state is approached, beginning
# near the buckling load.
CONTINUATION_STEPS, CONTINUATION_START = 12, 0.98
# Number of states past the maximum of −tan α, so that it lies inside the interpolation.
STEPS_BEYOND_LOCK = 4
# Largest displacement of the walk, in units of x1_init.
WALK_LIMIT = 1.5
NO_END = "shooting ends at the lock; use method: collocation to follow the motion past it"
# Number of points at which a shape is examined.
NODES = 48
# Order of the spline through states on the step grid.
SPLINE_DEGREE = 5


@dataclass(frozen=True, kw_only=True)
class Tolerances:
    """Tolerances of the Runge–Kutta integration and of the Nelder–Mead search.

    Attributes
    ----------
    rtol, atol : float
        Relative and absolute tolerance of the error in each step of the integration.
    simplex : float
        A search ends when the size of the simplex, and the differences between the distances of tip
        and contact point at its corners, are below this.
    miss : float
        Distance between tip and contact point (L) above which a search has failed.
    restarts : int
        Largest number of further searches after one that has failed.
    """

    rtol: float = 1e-10
    atol: float = 1e-12
    simplex: float = 1e-11
    miss: float = 1e-9
    restarts: int = 6


PRECISE = Tolerances()
# MATLAB's defaults, as used in the paper. A miss well above the tolerance of the search means a
# false minimum.
PAPER = Tolerances(rtol=1e-3, atol=1e-6, simplex=1e-4, miss=2e-4)


@dataclass(frozen=True, kw_only=True)
class ShotState:
    """Result of one search: f (E·I0/L²), α and φ1 (rad), x1 and `miss` (L).

    `miss` is the distance that remains between the tip and the contact point.
    """

    f: float
    alpha: float
    x1: float
    phi1: float
    miss: float


class _Tip(NamedTuple):
    """Position (L) and slope (rad) of the tip at the end of a shot."""

    x: float
    y: float
    phi: float


class _Shot(NamedTuple):
    """Force, its inclination (rad) and the contact point (L) with which a shot begins."""

    f: float
    alpha: float
    x1: float


def shoot(
    theta: float, f: float, alpha: float, x1: float, y1: float, tolerances: Tolerances = PRECISE
) -> _Tip:
    """Integrate paper equation (2) by Runge–Kutta 4(5) from the clamp to the tip."""
    return _gun(theta, y1, tolerances)(_Shot(f=f, alpha=alpha, x1=x1))


def _gun(theta: float, y1: float, tolerances: Tolerances) -> Callable[[_Shot], _Tip]:
    """Make a function that shoots, with one integrator for all its shots."""
    from scipy.integrate import ode  # half a second to load

    solver = ode(lambda s, state, derivative: derivative(s, state))
    solver.set_integrator("dopri5", rtol=tolerances.rtol, atol=tolerances.atol, nsteps=10_000)

    def tip(shot: _Shot) -> _Tip:
        solver.set_f_params(rod_equations(theta, *shot, y1))
        solver.set_initial_value((0.0, 0.0, math.pi / 2), 0.0)
        return _Tip(*solver.integrate(1.0))

    return tip


def _search(
    theta: float,
    y1: float,
    start: tuple[float, float],
    spread: tuple[float, float],
    tolerances: Tolerances,
    *,
    alpha: float | None = None,
    x1: float | None = None,
) -> ShotState:
    """Search for f and α, or f and x1, by Nelder–Mead until the tip meets the contact point."""

    def shot(unknowns: FloatArray) -> _Shot:
        f, other = map(float, unknowns)
        return _Shot(f=f, alpha=other if alpha is None else alpha, x1=other if x1 is None else x1)

    tip_of = _gun(theta, y1, tolerances)

    def miss(unknowns: FloatArray) -> float:
        tried = shot(unknowns)
        tip = tip_of(tried)
        return math.hypot(tip.x - tried.x1, tip.y - y1)

    from scipy.optimize import minimize  # a tenth of a second to load

    best, size = np.asarray(start, dtype=float), np.asarray(spread, dtype=float)
    options = {"xatol": tolerances.simplex, "fatol": tolerances.simplex, "maxiter": 400}
    for _ in range(1 + tolerances.restarts):
        simplex = best + np.array([[0.0, 0.0], [size[0], 0.0], [0.0, size[1]]])
        more = {"initial_simplex": simplex, "maxfev": 800}
        result = minimize(miss, best, method="Nelder-Mead", options=options | more)
        best = result.x
        if result.fun <= tolerances.miss:
            break
        # A collapsed simplex cannot leave its point: open a reversed one, of the size of the miss.
        size = -np.sign(size) * np.maximum(np.abs(size), 10.0 * result.fun)
    found = shot(best)
    return ShotState(**found._asdict(), phi1=tip_of(found).phi, miss=float(result.fun))


def initial_state(theta: float, eta: float, tolerances: Tolerances = PRECISE) -> ShotState:
    """Find the α = 0 state by a search for f and x1."""
    # A cold start far from the branch ends in the mirror image or a higher mode: come down from
    # near the buckling load, where the mode is known.
    top = max(eta, CONTINUATION_START)
    one = np.array([theta], dtype=float)
    buckled = RodStates(
        rods=rod_columns(one, [IDEAL]),
        unknowns=buckled_unknowns(one, np.array([top]), NODES),
        line=np.array([False]),
    )
    guess = (-float(buckled.fy[0]), float(ends(buckled).offset[0]))
    heights = [top]
    if eta < top:
        heights = list(np.linspace(top, eta, CONTINUATION_STEPS))
    states: list[ShotState] = []
    for height in heights:
        spread = (0.02 * guess[0], 0.02 * guess[1])
        states.append(_search(theta, height, guess, spread, tolerances, alpha=0.0))
        guess = (states[-1].f, states[-1].x1)
        if len(states) > 1:
            guess = (2 * guess[0] - states[-2].f, 2 * guess[1] - states[-2].x1)
    return states[-1]


def walk(
    theta: float,
    eta: float,
    dx0: float,
    mu0: float | None = None,
    tolerances: Tolerances = PRECISE,
    start: ShotState | None = None,
) -> list[ShotState]:
    """Walk along a period of sticking in steps of Δx0; each search starts from the previous state.

    Parameters
    ----------
    mu0 : float, optional
        Coefficient of static friction: the walk stops at the first state with −tan α > μ0, as in
        the paper. Without μ0, or if the tip locks, it stops a few states past the maximum of
        −tan α.
    start : ShotState, optional
        The α = 0 state, if it is already known.

    Returns
    -------
    list of ShotState
        States at x0 = 0, Δx0, 2·Δx0, ...; the last has a large `miss` if its search failed.
    """
    states = [start or initial_state(theta, eta, tolerances)]
    x1_init = states[0].x1
    beyond = 0
    while states[-1].miss <= tolerances.miss and len(states) * dx0 < WALK_LIMIT * x1_init:
        last = states[-1]
        # The simplex of fminsearch: 5 % of each coordinate, 0.00025 where it is zero.
        guess, spread = (last.f, last.alpha), (0.05 * last.f, 0.05 * last.alpha or 0.00025)
        x1 = x1_init - len(states) * dx0
        states.append(_search(theta, eta, guess, spread, tolerances, x1=x1))
        demand, previous = (-math.tan(state.alpha) for state in states[-1:-3:-1])
        if mu0 is not None and demand > mu0:
            break
        beyond = beyond + 1 if demand < previous else 0
        if beyond == STEPS_BEYOND_LOCK:
            break
    return states


def until_slip(states: list[ShotState], mu0: float) -> list[ShotState]:
    """Keep the states of a walk with a larger μ0 (or none) that a walk with `mu0` has."""
    for number, state in enumerate(states, start=1):
        if -math.tan(state.alpha) > mu0:
            return states[:number]
    return states


def solve_curve(
    theta: float,
    eta: float,
    dx0: float,
    tolerances: Tolerances = PRECISE,
    section: RodSection = RodSection.ROUND,
) -> StickingCurve:
    """Solve a sticking curve by the paper's procedure, up to a few steps past the lock.

    Returns
    -------
    StickingCurve
        Its status is ``failed`` if a search missed the contact point or −tan α has no maximum, and
        ``out_of_reach`` if the shape becomes inadmissible before the lock.
    """
    start = initial_state(theta, eta, tolerances)
    step = dx0 / math.ceil(dx0 / (LARGEST_STEP * start.x1))
    states = walk(theta, eta, step, tolerances=tolerances, start=start)
    worst = max(state.miss for state in states)
    if not worst <= tolerances.miss:
        why = (
            f"the search missed the contact point by {worst:.1e} at x0 = "
            f"{step * (len(states) - 1):.6g}; use a smaller dx0 or method: collocation"
        )
        return failed_curve(theta, eta, why, method=METHOD)
    known = _stepped(states, step, eta)
    followed = StickingCurve(
        theta=theta,
        eta=eta,
        method=METHOD,
        status=Status.SOLVED,
        x1_init=start.x1,
        pieces=_smooth_piece(known),
        residual=worst,
        section=section,
        end_message=NO_END,
    )
    return assembled_curves([followed], [_limit(theta, eta, known, start.x1)])[0]


def _stepped(states: list[ShotState], step: float, eta: float) -> PathState:
    """Convert the states of a walk to columns."""
    f, alpha, x1, phi1 = np.array([(s.f, s.alpha, s.x1, s.phi1) for s in states]).T
    return PathState(
        x0=step * np.arange(len(states), dtype=np.float64),
        reaction_fx=f * np.sin(alpha),
        reaction_fy=-f * np.cos(alpha),
        reaction_m=-f * (np.cos(alpha) * x1 + np.sin(alpha) * eta),
        phi1=phi1,
        s_c=np.ones_like(f),
    )


def _smooth_piece(known: PathState) -> Pieces:
    """Make a piece, with states at Chebyshev points, from a spline through states of a walk."""
    from scipy.interpolate import make_interp_spline  # half a second to load

    stop, degree = known.x0[-1:], min(SPLINE_DEGREE, len(known) - 1)
    columns = np.stack([*known.columns.values()], axis=-1)
    spline = make_interp_spline(known.x0, columns, k=degree)
    return Pieces(
        line=np.array([False]),
        by_x0=np.array([True]),
        start=np.zeros(1),
        stop=stop,
        states=PathState.from_matrix(spline(stop * chebyshev_nodes(STATES_PER_PIECE))[None]),
        shapes=np.full(1, None),
    )


def _limit(theta: float, eta: float, states: PathState, x1_init: float) -> ShapeLimits:
    """Shape limits: displacement of the first state with an inadmissible shape; NaN if none."""
    rule = gauss_rule(NODES)
    s = rule.from_start @ arc_density(rule.nodes, theta)
    rows = zip(states.f, states.alpha, x1_init - states.x0, strict=True)
    phi = np.stack([deformed_shape(theta, f, alpha, x1, eta, s)[2] for f, alpha, x1 in rows])
    shapes = RodStates(
        rods=rod_columns(np.full(len(states), theta), [IDEAL] * len(states)),
        unknowns=np.column_stack([phi, states.reaction_fx, states.reaction_fy, states.s_c]),
        line=np.zeros(len(states), dtype=bool),
    )
    clearance = clearances(shapes, np.full(len(states), eta), LIMITING_CLEARANCES[Contact.POINT])
    beyond = clearance.smallest < -CLEARANCE_TOLERANCE
    first, unknown = int(beyond.argmax()), np.full(1, np.nan)
    return ShapeLimits(
        out_of_reach=np.where(beyond.any(), states.x0[[first]], np.nan),
        arches=unknown,
        swings_aside=unknown,
        reason=np.array([clearance.reasons(first)], dtype=object),
    )
