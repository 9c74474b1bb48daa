"""Functions for notebooks: solve one state, one equilibrium path or one onset of slip."""

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from decimal import Decimal
from functools import lru_cache
from numbers import Real
from typing import NamedTuple

import numpy as np

from vibrissa.decimals import exact
from vibrissa.errors import ArgumentError
from vibrissa.limits import check_bore
from vibrissa.mechanics.equations import ends
from vibrissa.mechanics.lateral import lateral_stability
from vibrissa.mechanics.mounting import IDEAL, Mounting
from vibrissa.mechanics.stability import stability
from vibrissa.mechanics.states import ContactState, RodStates
from vibrissa.mechanics.taper import MOST_TAPER
from vibrissa.outcomes import Contact, End, RodSection, Solver, Status, chosen
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.periods import Stiction, read_curve
from vibrissa.sticking.piece import AHEAD, BACK
from vibrissa.sticking.results import EquilibriumState, Onset
from vibrissa.sticking.solving import collocation
from vibrissa.sticking.solving.offsets import solve_offset

PULLED = "the tip has left the surface, which would have to pull it"
# Number of cached curves, some kilobytes each: calls that vary mu0 alone need the same curve.
KEPT_CURVES = 256


def _check_numbers(**values: object) -> None:
    for name, value in values.items():
        if isinstance(value, np.ndarray) and value.ndim == 0:
            value = value.item()
        if isinstance(value, bool) or not isinstance(value, Real | Decimal):
            raise ArgumentError(f"{name} must be one number, not a text or a list, got {value!r}")
        with suppress(OverflowError, ValueError):  # integers beyond floats, signalling NaN
            if math.isfinite(value):
                continue
        raise ArgumentError(f"{name} must be finite, got {value!r}")


def _check(
    theta: float,
    eta: float,
    method: str = Solver.COLLOCATION,
    contact: str = Contact.POINT,
    mounting: Mounting = IDEAL,
    section: str = RodSection.ROUND,
) -> None:
    _check_numbers(theta=theta, eta=eta)
    if not isinstance(mounting, Mounting):
        raise ArgumentError(f"mounting must be a Mounting, got {mounting!r}")
    if not 1.0 <= theta <= MOST_TAPER:
        raise ArgumentError(
            "theta is base over tip diameter and must lie between 1 and "
            f"{MOST_TAPER:g}, got {theta!r}"
        )
    check_bore(mounting.bore, theta)
    if not 0.0 < eta < 1.0:
        divide = ": divide the height by the length L" if eta > 1.0 else ""
        raise ArgumentError(f"eta must lie between 0 and 1 (in units of L), got {eta!r}{divide}")
    chosen(Solver, method, "method")
    chosen(Contact, contact, "contact")
    chosen(RodSection, section, "section")
    if method == Solver.SHOOTING and contact != Contact.POINT:
        raise ArgumentError(f"method {method!r} solves contact 'point' alone, got {contact!r}")
    if method == Solver.SHOOTING and mounting != IDEAL:
        raise ArgumentError(
            f"method {method!r} solves the ideal mounting of a solid rod alone, got {mounting!r}"
        )


def solve_state(
    theta: float, eta: float, x1: float, contact: str = Contact.POINT, mounting: Mounting = IDEAL
) -> EquilibriumState:
    """Solve one equilibrium with the tip at (x1, eta) relative to the clamp.

    Parameters
    ----------
    theta : float
        Taper factor, at least 1.
    eta : float
        Height of the contact point, 0 < eta < 1 (L).
    x1 : float
        Distance of the tip from the clamp along the surface (L).
    contact : str
        ``point``: the tip alone touches, as in the paper; ``line``: instead of passing through the
        surface, the rod lies along it.
    mounting : Mounting
        Clamp and natural curvature; the angle of the stage has no effect.

    Returns
    -------
    EquilibriumState
        State on the equilibrium path from α = 0. In tip contact and in the ideal mounting it is,
        for x1 > 0, the equilibrium with the smallest contact force. The status is ``out_of_reach``
        if the surface would have to pull the tip.

    Raises
    ------
    ArgumentError
        If an argument is out of range or the contact point is out of the rod's reach.

    Examples
    --------
    The paper's Figure 8:

    >>> state = solve_state(theta=1, eta=0.55, x1=0.15)
    >>> print(f"{state.f:.3f} {state.phi1:.3f} {state.penetrates}")
    22.983 -0.495 True
    """
    _check(theta, eta, contact=contact, mounting=mounting)
    _check_numbers(x1=x1)
    if not math.hypot(x1, eta) < 1.0:
        raise ArgumentError(
            f"the point (x1, eta) = ({x1!r}, {eta!r}) is out of reach of a rod of length 1"
        )
    place = float(theta), float(eta), mounting, float(x1)
    solution, residual, status, message = solve_offset(*place, Contact(contact))
    if solution is not None and solution.fy[0] >= 0.0:
        solution, residual, status, message = None, np.nan, Status.OUT_OF_REACH, PULLED
    kind = "" if solution is None else Contact.LINE if solution.line[0] else Contact.POINT
    return EquilibriumState(
        **_loads(solution),
        status=status,
        message=message,
        contact=kind,
        theta=theta,
        x1=x1,
        eta=eta,
        residual=residual,
        _solution=solution,
    )


def _loads(solution: RodStates | None) -> dict[str, float]:
    """Compute loads, contact and margins of stability of one state; NaN without a solution."""
    if solution is None:
        return dict.fromkeys(ContactState.names(), np.nan)
    end = ends(solution)
    return {
        "reaction_fx": float(solution.fx[0]),
        "reaction_fy": float(solution.fy[0]),
        "reaction_m": float(end.moment[0]),
        "phi1": 0.0 if solution.line[0] else float(end.phi1[0]),
        "s_c": float(solution.s_c[0]),
        "stability": float(stability(solution)[0]),
        "stability_aside": float(lateral_stability(solution)[0]),
    }


def solve_curves(
    theta: Sequence[float],
    eta: Sequence[float],
    contact: str,
    mountings: Sequence[Mounting],
    section: str,
    retract: bool = False,
    onsets: bool = False,
) -> list[StickingCurve]:
    """Solve the sticking curves of several rods together by collocation; see `solve_curve`.

    With `retract`, every curve has states at x0 < 0, where the clamp is pulled back, as far as they
    can be solved; otherwise only curves of round rods in an ideal mounting have them. With
    `onsets`, curves have what onsets and locks need, as in
    `vibrissa.sticking.solving.collocation.solve_curves`.
    """
    for taper, height, mounting in zip(theta, eta, mountings, strict=True):
        _check(taper, height, contact=contact, mounting=mounting, section=section)
    return collocation.solve_curves(
        np.array(theta, dtype=float),
        np.array(eta, dtype=float),
        Contact(contact),
        mountings,
        RodSection(section),
        retract,
        onsets,
    )


def solve_curve(
    theta: float,
    eta: float,
    method: str = Solver.COLLOCATION,
    dx0: float | None = None,
    contact: str = Contact.POINT,
    mounting: Mounting = IDEAL,
    section: str = RodSection.ROUND,
) -> StickingCurve:
    """Solve the equilibrium path of one rod at one height, from α = 0 to its end.

    Parameters
    ----------
    theta : float
        Taper factor, at least 1.
    eta : float
        Height of the contact point in the α = 0 state, 0 < eta < 1 (L).
    method : str
        ``collocation`` or ``shooting``.
    dx0 : float, optional
        Step of the clamp (L); only ``shooting`` needs it.
    contact : str
        ``point`` or ``line``, as in `solve_state`; ``shooting`` solves only ``point``.
    mounting : Mounting
        Mounting of the rod; ``shooting`` solves only the ideal one.
    section : str
        ``round``: the rod buckles laterally; ``planar``: a strip or a guided rod, which does not.

    Returns
    -------
    StickingCurve
        Curve with read-only arrays. If the rod has no state with α = 0, its status is
        ``out_of_reach``.

    Raises
    ------
    ArgumentError
        If an argument is out of range.

    Examples
    --------
    >>> curve = solve_curve(theta=2, eta=0.85)
    >>> print(f"{curve.mu_lock:.6f} {curve.end}")
    0.477571 swings_aside
    """
    _check(theta, eta, method, contact, mounting, section)
    if method == Solver.COLLOCATION:
        return _kept_curve(
            float(theta), float(eta), Contact(contact), mounting, RodSection(section)
        )
    if dx0 is not None:
        _check_numbers(dx0=dx0)
    if dx0 is None or not dx0 > 0.0:
        raise ArgumentError(f"shooting needs a positive step dx0, got {dx0!r}")
    # Imported here, as SciPy's integrators and optimisers take half a second to load.
    from vibrissa.sticking.solving import shooting

    return shooting.solve_curve(float(theta), float(eta), float(dx0), section=RodSection(section))


@lru_cache(KEPT_CURVES)
def _kept_curve(
    theta: float, eta: float, contact: Contact, mounting: Mounting, section: RodSection
) -> StickingCurve:
    """Solve a curve alone, and cache it."""
    (curve,) = collocation.solve_curves(
        np.array([theta]), np.array([eta]), contact, [mounting], section
    )
    for pieces in (curve.pieces, curve.retraction):
        for values in pieces.states.columns.values():
            values.flags.writeable = False
    return curve


def solve_onset(
    theta: float,
    mu0: float | Decimal,
    eta: float,
    dx0: float | Decimal | None = None,
    method: str = Solver.COLLOCATION,
    contact: str = Contact.POINT,
    mounting: Mounting = IDEAL,
    section: str = RodSection.ROUND,
) -> Onset:
    """Solve one period of sticking: exact onset of slip, and last step at which the tip sticks.

    Parameters
    ----------
    theta : float
        As in `solve_curve`.
    mu0 : float or Decimal
        Coefficient of static friction, positive.
    eta : float
        As in `solve_curve` (L).
    dx0 : float or Decimal, optional
        Step of the clamp (L). The paper's x0,max is the largest multiple of dx0 up to the onset of
        slip; without dx0 it is NaN. ``shooting`` needs a step.
    method, contact, mounting, section : optional
        As in `solve_curve`.

    Returns
    -------
    Onset

    Raises
    ------
    ArgumentError
        If an argument is out of range.

    Examples
    --------
    >>> onset = solve_onset(theta=2, mu0=0.4, eta=0.85, dx0=0.001)
    >>> print(f"{onset.x0_slip:.6f} {onset.x0_max}")
    0.052838 0.052

    The same rod in a clamp that leans back by two degrees:

    >>> tilted = Mounting(clamp_angle=np.radians(2))
    >>> onset = solve_onset(theta=2, mu0=0.4, eta=0.85, mounting=tilted)
    >>> print(f"{onset.x0_slip:.6f}")
    0.066904
    """
    check_friction_and_step(mu0, dx0)
    step = None if dx0 is None else float(dx0)
    return onset_on(solve_curve(theta, eta, method, step, contact, mounting, section), mu0, dx0)


class FrictionRange(NamedTuple):
    """Range of friction coefficients for which the tip slips in a given step.

    Attributes
    ----------
    low, high : float
        The tip slips in this step if low ≤ μ0 < high.
    """

    low: float
    high: float


def friction_from_travel(
    theta: float,
    eta: float,
    x0_max: float | Decimal,
    dx0: float | Decimal,
    contact: str = Contact.POINT,
    mounting: Mounting = IDEAL,
    section: str = RodSection.ROUND,
) -> FrictionRange:
    """Estimate the friction coefficient from the displacement x0,max of one period of sticking.

    The tip still sticks at x0,max and slips forward one step later: −tan α reaches μ0 in this step
    for the first time, and tan α has not reached it before.

    Parameters
    ----------
    theta, eta : float
        As in `solve_curve`.
    x0_max : float or Decimal
        Displacement of the clamp at the last step at which the tip sticks (L).
    dx0 : float or Decimal
        Step of the clamp (L).
    contact, mounting, section : optional
        As in `solve_curve`.

    Returns
    -------
    FrictionRange
        Range of μ0; `high` is μ_lock if the next step reaches x0_lock, where −tan α is largest.

    Raises
    ------
    ArgumentError
        If an argument is out of range, the curve has no lock, x0_max is not below x0_lock, or no
        friction lets the tip slip in the step after x0_max.

    Examples
    --------
    >>> found = friction_from_travel(theta=2, eta=0.85, x0_max=0.052, dx0=0.001)
    >>> print(f"{found.low:.4f} to {found.high:.4f}")
    0.3979 to 0.4004
    """
    _check_numbers(x0_max=x0_max, dx0=dx0)
    if not (x0_max >= 0.0 and dx0 > 0.0):
        raise ArgumentError(
            f"x0_max must not be negative and dx0 must be positive, got {x0_max} and {dx0}"
        )
    curve = solve_curve(theta, eta, contact=contact, mounting=mounting, section=section)
    if np.isnan(curve.x0_lock):
        raise ArgumentError(f"the lock of this rod is not known: {curve.message}")
    if not (travel := float(x0_max)) < curve.x0_lock:
        raise ArgumentError(
            f"x0_max must lie below {curve.x0_lock:.6g}, got {x0_max}: at any friction the tip of "
            "this rod slips at a smaller x0, or it does not slip forward"
        )
    until = min(travel + float(dx0), curve.x0_lock)
    # A tip with less friction than `held` has slipped forward or back before this step.
    held = max(curve.largest_friction(travel, AHEAD), curve.largest_friction(until, BACK))
    high = curve.mu_lock if until == curve.x0_lock else curve.largest_friction(until, AHEAD)
    if not high > held:
        raise ArgumentError(
            f"no friction lets the tip slip in the step after x0_max = {x0_max}: -tan alpha is "
            "not larger there than before, or the step is below rounding"
        )
    return FrictionRange(low=held, high=high)


def check_friction_and_step(mu0: float | Decimal, dx0: float | Decimal | None) -> None:
    """Refuse a friction coefficient or a step that is not positive and finite.

    Raises
    ------
    ArgumentError
    """
    _check_numbers(mu0=mu0, **({} if dx0 is None else {"dx0": dx0}))
    for name, value in {"mu0": mu0, "dx0": dx0}.items():
        if value is not None and not value > 0:
            raise ArgumentError(f"{name} must be positive, got {value!r}")


def onset_on(
    curve: StickingCurve,
    mu0: float | Decimal,
    dx0: float | Decimal | None = None,
    spell: Callable[[float], str] = lambda length: f"{length:.6g}",
) -> Onset:
    """Find the end of a period of sticking on a curve; see `solve_onset`.

    Parameters
    ----------
    spell : callable
        Formats a length (L) for the message.

    Raises
    ------
    ArgumentError
        If mu0 or dx0 is not positive.
    """
    check_friction_and_step(mu0, dx0)
    stiction = read_curve(curve, [exact(mu0)], [exact(1 if dx0 is None else dx0)])
    status = stiction.status[0]
    if status is Status.SLIP:
        message = f"the tip slips at x0 = {spell(float(stiction.x0_slip[0]))}"
    elif status is Status.LOCK:
        message = f"{_no_slip(curve, float(mu0))} {_end_of_lock(curve, stiction, spell)}"
    else:
        message = curve.message
    stepped = status is Status.SLIP and dx0 is not None
    return Onset(
        status=status,
        message=message,
        x0_slip=float(stiction.x0_slip[0]),
        n_steps=int(stiction.n_steps[0]) if stepped else None,
        x0_max=float(stiction.x0_max[0]) if stepped else float("nan"),
        mu_lock=curve.mu_lock,
        slip=stiction.slip.take(0),
        end=stiction.end[0],
        ended=stiction.ended.take(0),
        trail=stiction.trail.take(0),
        penetrates=bool(stiction.penetrates[0]),
        residual=curve.residual,
    )


def _no_slip(curve: StickingCurve, mu0: float) -> str:
    """Describe why a tip does not slip forward."""
    if mu0 > curve.mu_lock:
        return (
            f"the tip locks: it slips only for mu0 up to mu_lock = {curve.mu_lock:.6g}; "
            "choose a smaller mu0, a smaller eta or another theta. Past the lock"
        )
    return (
        "the tip locks: it slips back before -tan alpha reaches mu0; choose a smaller or a larger "
        "mu0. In this period"
    )


def _end_of_lock(curve: StickingCurve, stiction: Stiction, spell: Callable[[float], str]) -> str:
    """Describe how sticking of a locked tip ends."""
    x0, trail = spell(float(stiction.ended.x0[0])), float(stiction.trail.x0[0])
    then = f" and trails behind the clamp until it slips at x0 = {spell(trail)}"
    if not curve.mounting.is_ideal:
        then = "; in this mounting the motion beyond is not computed"
    elif np.isnan(trail):
        then = " and trails behind the clamp; its next slip was not found"
    return {
        End.SWINGS_ASIDE: f"the rod buckles laterally at x0 = {x0}{then}",
        End.SLIPS_BACK: f"the tip slips back at x0 = {x0}",
        End.SNAPS: f"the rod snaps through at x0 = {x0}",
        End.LIFTS_OFF: f"the tip slips or leaves the surface at x0 = {x0}",
        End.OUT_OF_REACH: f"{curve.end_message} from x0 = {x0} on",
        End.NOT_FOLLOWED: f"the motion was not followed: {curve.end_message}",
    }[End(stiction.end[0])]
