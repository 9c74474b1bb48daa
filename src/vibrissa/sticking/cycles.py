"""Stick-slip cycles: what a sensor sees while the clamp moves on and on.

The tip sticks until the first step of the footpoint at which −tan α > μ0. There it slips, in the
paper until α = 0 is reached again: the contact point has then moved by the clamp's own travel and
the next period is the same, translated. Other laws of slip are in `vibrissa.sensor.slips`.
"""

from dataclasses import dataclass
from decimal import Decimal
from enum import StrEnum

import numpy as np

from vibrissa.decimals import exact
from vibrissa.errors import ArgumentError
from vibrissa.mechanics.elastica import deformed_shape
from vibrissa.numerics.arrays import FloatArray, IntArray
from vibrissa.numerics.steps import last_step_within, step_position
from vibrissa.outcomes import Status
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.piece import StickingState


class Phase(StrEnum):
    """How the tip came to where it is at a footpoint position."""

    STICK = "stick"
    SLIP = "slip"


@dataclass(frozen=True, eq=False, kw_only=True)
class Scan:
    """States at every footpoint position of a scan.

    Attributes
    ----------
    status : Status
        ``slip``, or ``lock``: then the scan is one period of sticking, past the lock to where it
        ends (or to the lock, where it was not followed); without states as the curve.
    cycle : ndarray of int, shape (n,)
        Number of the stick-slip cycle, from 1; it ends with the slip.
    step : ndarray of int, shape (n,)
        Steps of the footpoint since the cycle began.
    phase : list of Phase
        ``slip`` for the state into which the tip has just slipped, ``stick`` otherwise.
    footpoint : ndarray, shape (n,)
        Position of the clamp (L).
    x1 : ndarray, shape (n,)
        Position of the tip (L), which is the contact point in point contact.
    state : StickingState
        Force, angles and clamp reactions; its x0 counts from the last α = 0 state.
    s : ndarray, shape (points,)
        Arc lengths of the shape points (L).
    x, y, phi : ndarray, shape (n, points)
        Shapes, x in the frame of the surface (L, rad).
    residual : ndarray, shape (n,)
        Distance between the integrated shape's end and the contact point (L): a check of the
        force that shares nothing with how it was found.
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


def stick_slip(
    curve: StickingCurve,
    mu0: Decimal | float,
    dx0: Decimal | float,
    cycles: int,
    shape_points: int = 101,
) -> Scan:
    """Move the clamp in steps of Δx0 through a number of stick-slip cycles.

    Parameters
    ----------
    curve : StickingCurve
    mu0 : Decimal or float
        Coefficient of static friction.
    dx0 : Decimal or float
        Footpoint displacement per step (L).
    cycles : int
        Number of cycles, at least 1.
    shape_points : int
        Number of points of each shape, equally spaced in s, both ends included.

    Returns
    -------
    Scan
        One row for each footpoint position: the α = 0 state, then for each cycle its sticking
        steps and the state into which it slips.

    Raises
    ------
    ArgumentError
        If the step or the number of cycles is not positive, a shape has fewer than two points, or
        the stage changes the height, so that each cycle has another curve, and there is more than
        one.
    """
    if cycles < 1:
        raise ArgumentError(f"cycles must be at least 1, got {cycles}")
    if cycles > 1 and curve.mounting.stage_angle:
        raise ArgumentError(
            f"with a stage_angle each cycle begins at another height and has its own curve: "
            f"cycles must be 1, got {cycles}"
        )
    if shape_points < 2:
        raise ArgumentError(f"shape_points must be at least 2, got {shape_points}")
    dx0 = exact(dx0)
    if not dx0 > 0:
        raise ArgumentError(f"dx0 must be positive, got {dx0}")
    s = np.linspace(0.0, 1.0, shape_points)
    status, last = _end_of_sticking(curve, float(mu0), dx0)
    if status not in (Status.SLIP, Status.LOCK):
        return _empty_scan(s, status)

    # One period, k = 0 ... last; every later one is the same, translated.
    period = curve.state(step_position(np.arange(last + 1), dx0))
    offset, height = curve.contact_point(period.x0)
    shapes = _shapes(curve, period, s)
    residual = np.hypot(shapes[:, 0, -1] - offset, shapes[:, 1, -1] - height)
    cycle, step = _numbered(last, 1 if status is Status.LOCK else cycles, status)
    # A slip ends at step last + 1, in the state that the period begins with.
    row = step % (last + 1)
    footpoint = step_position(np.arange(len(step)), dx0)
    along = footpoint * np.cos(curve.mounting.stage_angle)
    return Scan(
        status=status,
        cycle=cycle,
        step=step,
        phase=[Phase.SLIP if k > last else Phase.STICK for k in step],
        footpoint=footpoint,
        x1=along + offset[row],
        state=period.take(row),
        s=s,
        x=along[:, None] + shapes[row, 0],
        y=curve.eta - height[row, None] + shapes[row, 1],
        phi=shapes[row, 2],
        residual=residual[row],
    )


def _end_of_sticking(curve: StickingCurve, mu0: float, dx0: Decimal) -> tuple[Status, int]:
    """Whether the tip slips or locks, and the last step of the footpoint before its motion ends."""
    (until,), (status,) = curve.outcomes(np.array([mu0]))
    if status is Status.LOCK:
        end = float(curve.motion_end(mu0)[1].x0[0])
        until = end if np.isfinite(end) else curve.x0_lock
    return status, int(last_step_within(np.array(np.nan_to_num(until)), dx0))


def _shapes(curve: StickingCurve, states: StickingState, s: FloatArray) -> FloatArray:
    """Shapes in some states of a curve, shape (n, 3, points): x, y and φ."""
    rows = zip(states.f, states.alpha, *curve.contact_point(states.x0), states.s_c, strict=True)
    return np.stack(
        [
            deformed_shape(curve.theta, f, alpha, x1, y1, s, s_c, curve.mounting)
            for f, alpha, x1, y1, s_c in rows
        ]
    )


def _numbered(last: int, cycles: int, status: Status) -> tuple[IntArray, IntArray]:
    """Count the cycles, and the steps in each, for all footpoint positions.

    A cycle has the steps 1 ... last and the one in which the tip slips; the first begins with the
    α = 0 state. Where the tip locks there is no slip.
    """
    slips = status is not Status.LOCK
    position = np.arange(cycles * (last + slips) + 1)
    cycle = np.maximum(1, -(-position // max(last + slips, 1)))
    return cycle, position - (cycle - 1) * (last + slips)


def _empty_scan(s: FloatArray, status: Status) -> Scan:
    none, whole = np.empty(0), np.empty(0, dtype=np.int64)
    shapes = np.empty((0, len(s)))
    return Scan(
        status=status,
        cycle=whole,
        step=whole,
        phase=[],
        footpoint=none,
        x1=none,
        state=StickingState.unknown(0),
        s=s,
        x=shapes,
        y=shapes,
        phi=shapes,
        residual=none,
    )
