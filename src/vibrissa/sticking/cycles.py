"""Stick-slip cycles: states of the rod while the clamp moves through many periods.

The tip sticks until the first step of the clamp at which −tan α > μ0. It then slips until
α = 0, as in the paper; `vibrissa.sensor.simulation.tip` has other laws of slip.
"""

from dataclasses import dataclass, replace
from decimal import Decimal
from enum import StrEnum
from functools import cache

import numpy as np

from vibrissa.decimals import exact
from vibrissa.errors import ArgumentError
from vibrissa.mechanics.elastica import deformed_shape
from vibrissa.numerics.arrays import FloatArray, IntArray
from vibrissa.numerics.batch import Batch
from vibrissa.numerics.steps import last_step_within, step_position
from vibrissa.outcomes import Contact, Status
from vibrissa.sticking.api import check_surface
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.piece import StickingState
from vibrissa.sticking.reading import mirrored
from vibrissa.sticking.solving.collocation import solve_curves
from vibrissa.sticking.stiction import read_curve


class Phase(StrEnum):
    """Phase of the tip at a step of the clamp: it sticks, or has just slipped."""

    STICK = "stick"
    SLIP = "slip"


@dataclass(frozen=True, eq=False, kw_only=True)
class Scan:
    """States of a stick-slip scan, one for each step of the clamp.

    Attributes
    ----------
    status : Status
        ``slip`` if the tip slips forward, ``lock`` if it locks. A locked tip is dragged behind the
        clamp if the rod buckles laterally; else the scan ends with the first period. A scan without
        states has the status of the curve.
    cycle : ndarray of int, shape (n,)
        Number of the stick-slip cycle, from 1; a cycle ends with its slip.
    step : ndarray of int, shape (n,)
        Number of steps of the clamp since the cycle began.
    phase : list of Phase
        ``slip`` for the state into which the tip has just slipped, ``stick`` otherwise.
    footpoint : ndarray, shape (n,)
        Position of the clamp (L).
    x1 : ndarray, shape (n,)
        Position of the tip (L), which is the contact point in point contact.
    state : StickingState
        States of the rod; x0 counts from the α = 0 state in which the period began.
    s : ndarray, shape (points,)
        Arc lengths of the shape points (L).
    x, y, phi : ndarray, shape (n, points)
        Positions (L) and slopes (rad) of the shapes; x is relative to the surface. They are
        integrated from the clamp, and lose accuracy for θ above about 20: see `residual`.
    residual : ndarray, shape (n,)
        Distance between the end of the integrated shape and the point `x1` of the surface (L).
    message : str
        Why there are fewer cycles than requested; else empty.
    """

    status: Status
    cycle: IntArray
    step: IntArray
    phase: list[Phase]
    footpoint: FloatArray
    x1: FloatArray
    state: StickingState
    s: FloatArray
    x: FloatArray
    y: FloatArray
    phi: FloatArray
    residual: FloatArray
    message: str = ""


def stick_slip(
    curve: StickingCurve,
    mu0: Decimal | float,
    dx0: Decimal | float,
    cycles: int,
    shape_points: int = 101,
    contact: str = Contact.POINT,
) -> Scan:
    """Move the clamp in steps of Δx0 (L) through a number of stick-slip cycles.

    Parameters
    ----------
    curve : StickingCurve
        Sticking curve of the rod.
    mu0, dx0 : Decimal or float
        Coefficient of static friction, and step of the clamp (L).
    cycles : int
        Number of stick-slip cycles.
    shape_points : int
        Number of points of each shape, equally spaced in s, both ends included.
    contact : str
        Contact model; not used on a level stage. On an oblique stage each cycle has its own height:
        `curve` belongs to the first cycle, and the curves of later cycles are solved here.

    Returns
    -------
    Scan
        One row for each step of the clamp: the α = 0 state, then for each cycle its sticking states
        and the state after its slip.

    Raises
    ------
    ArgumentError
        If an argument is not positive, a shape has fewer than two points, or the contact model is
        not that of the curve.

    Examples
    --------
    >>> from vibrissa import solve_curve
    >>> scan = stick_slip(solve_curve(theta=2, eta=0.85), mu0=0.3, dx0=0.01, cycles=2)
    >>> print(scan.footpoint)
    [0.   0.01 0.02 0.03 0.04 0.05 0.06]
    >>> print(scan.x1.round(4))
    [0.4173 0.4173 0.4173 0.4473 0.4473 0.4473 0.4773]
    """
    for name, number, least in (("cycles", cycles, 1), ("shape_points", shape_points, 2)):
        if not isinstance(number, int | np.integer) or number < least:
            raise ArgumentError(f"{name} must be a whole number, at least {least}, got {number!r}")
    check_surface(mu0, dx0)
    dx0 = exact(dx0)
    if curve.mounting.stage_angle and curve.pieces.line.any() and contact != Contact.LINE:
        raise ArgumentError("the curve was solved in line contact: give contact='line'")
    s = np.linspace(0.0, 1.0, shape_points)

    @cache  # on a level stage all later periods are the same
    def period(curve: StickingCurve, last: int, start: float, drags: bool) -> _Period:
        return _period(curve, start + step_position(np.arange(1 + last), dx0), s, drags=drags)

    periods, one, message = [_no_period(s)], curve, ""
    outcome, _, _ = _end_of_sticking(curve, float(mu0))
    for number in range(1 + cycles):
        status, until, slips = _end_of_sticking(one, float(mu0), later=number > 0)
        if status in (Status.SLIP, Status.LOCK):
            # After a slip on a later rise of −tan α the tip rests at the foot of this rise.
            start = one.rest(until) if number > 0 and status is Status.SLIP else 0.0
            # The last cycle ends with the state into which the tip slips.
            last = int(last_step_within(np.array(until - start), dx0)) if number < cycles else 0
            drags = number > 0 and slips and status is Status.LOCK
            periods.append(period(one, last, start, drags))
        if number == cycles or not slips:
            if number < cycles or status not in (Status.SLIP, Status.LOCK):
                message = f"at the height {one.eta:.6g} (in units of L): {one.message or status}"
            break
        if curve.mounting.stage_angle:
            # After the slip the rod is in the α = 0 state for the clamp's present height.
            footpoint = step_position(np.array(sum(map(len, periods))), dx0)
            eta = curve.contact_point(footpoint)[1].item()
            if not 0.0 < eta < 1.0:
                message = f"the stage takes the clamp to the height {eta:.6g} (in units of L)"
                break
            rod = np.array([curve.theta]), np.array([eta])
            (one,) = solve_curves(*rod, Contact(contact), [curve.mounting], curve.section)
    return _scan(curve, outcome, periods, dx0, s, message)


@dataclass(frozen=True, eq=False, kw_only=True)
class _Period(Batch):
    """States of a period, with positions of the tip and shapes relative to the clamp (L)."""

    state: StickingState
    offset: FloatArray
    height: FloatArray
    x: FloatArray
    y: FloatArray
    phi: FloatArray


def _no_period(s: FloatArray) -> _Period:
    none, shapes = np.empty(0), np.empty((0, len(s)))
    state = StickingState.unknown(0)
    return _Period(state=state, offset=none, height=none, x=shapes, y=shapes, phi=shapes)


def _end_of_sticking(
    curve: StickingCurve, mu0: float, *, later: bool = False
) -> tuple[Status, float, bool]:
    """Status, displacement since α = 0 at which sticking ends (L), and whether the tip slips."""
    read = read_curve(curve, [exact(mu0)], [Decimal(1)])
    (status,), trail, end = read.status, float(read.trail.x0[0]), float(read.ended.x0[0])
    if status is not Status.LOCK:
        return status, float(read.x0_slip[0]), status is Status.SLIP
    if np.isfinite(trail):
        # In a later period the tip is behind the clamp from the start.
        return status, trail - 2.0 * curve.x0_end * later, True
    return status, end if np.isfinite(end) else curve.x0_lock, False


def _period(
    curve: StickingCurve, displacement: FloatArray, s: FloatArray, *, drags: bool
) -> _Period:
    """States at displacements since α = 0; mirrored where the rod trails behind its clamp."""
    behind = drags | (displacement > curve.x0_end)
    x0 = np.where(behind, (0.0 if drags else 2.0 * curve.x0_end) - displacement, displacement)
    state, (offset, height) = curve.state(x0), curve.contact_point(x0)
    rows = zip(state.f, state.alpha, offset, height, state.s_c, strict=True)
    shapes = [deformed_shape(curve.theta, *row[:4], s, row[4], curve.mounting) for row in rows]
    x, y, phi = np.moveaxis(np.array(shapes), 1, 0)
    state.put(behind, mirrored(state.take(behind), curve.x0_end))
    sign = np.where(behind, -1.0, 1.0)
    return _Period(
        state=replace(state, x0=displacement),
        offset=sign * offset,
        height=height,
        x=sign[:, None] * x,
        y=y,
        phi=np.where(behind[:, None], np.pi - phi, phi),
    )


def _scan(
    curve: StickingCurve,
    status: Status,
    periods: list[_Period],
    dx0: Decimal,
    s: FloatArray,
    message: str,
) -> Scan:
    """Join the states of periods to a scan, with positions relative to the surface."""
    counts = [len(period.offset) for period in periods]
    cycle = np.repeat(np.arange(len(counts)), counts)
    step = np.concatenate([np.arange(count) for count in counts])
    # The first state of a later period is the slip that ends the cycle before.
    slips = (step == 0) & (cycle > 1)
    step[slips], cycle[slips] = counts[1:-1], cycle[slips] - 1
    found, footpoint = _Period.concatenate(periods), step_position(np.arange(len(step)), dx0)
    along = footpoint * np.cos(curve.mounting.stage_angle)
    return Scan(
        status=status,
        cycle=cycle,
        step=step,
        phase=[Phase.SLIP if slipped else Phase.STICK for slipped in slips],
        footpoint=footpoint,
        x1=along + found.offset,
        state=found.state,
        s=s,
        x=along[:, None] + found.x,
        y=curve.eta - found.height[:, None] + found.y,
        phi=found.phi,
        residual=np.hypot(found.x[:, -1] - found.offset, found.y[:, -1] - found.height),
        message=message,
    )
