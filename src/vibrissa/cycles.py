"""Stick-slip cycles: what a sensor sees while the clamp moves on and on.

The tip sticks until the first step of the footpoint at which −tan α > μ0. There it slips, in the
paper until α = 0 is reached again: the contact point has then moved by the clamp's own travel and
the next period is the same, translated.
"""

from dataclasses import dataclass
from decimal import Decimal
from enum import StrEnum

import numpy as np

from vibrissa.arrays import FloatArray, IntArray
from vibrissa.curve import StickingCurve, StickingState
from vibrissa.decimals import exact
from vibrissa.rod import deformed_shape
from vibrissa.status import Status
from vibrissa.steps import last_step_within, step_position


class Phase(StrEnum):
    """How the tip came to where it is at a footpoint position."""

    STICK = "stick"
    SLIP = "slip"


@dataclass(frozen=True, eq=False)
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
    ValueError
        If the step or the number of cycles is not positive or a shape has fewer than two points.
    """
    if cycles < 1:
        raise ValueError(f"cycles must be at least 1, got {cycles}")
    if shape_points < 2:
        raise ValueError(f"shape_points must be at least 2, got {shape_points}")
    dx0 = exact(dx0)
    if not dx0 > 0:
        raise ValueError(f"dx0 must be positive, got {dx0}")
    s = np.linspace(0.0, 1.0, shape_points)
    if curve.status is not Status.SOLVED:
        return _empty_scan(s, curve.status)
    until = float(curve.onset(float(mu0)))
    status = Status.SLIP if np.isfinite(until) else Status.LOCK
    if status is Status.LOCK:
        end = float(curve.motion_end(float(mu0))[1].x0[0])
        until = end if np.isfinite(end) else curve.x0_lock
    last = int(last_step_within(np.array(until), dx0))

    # One period, k = 0 ... last; every later one is the same, translated.
    period = curve.state(step_position(np.arange(last + 1), dx0))
    offset = curve.x1_init - period.x0
    shapes = np.stack(
        [
            deformed_shape(curve.theta, f, alpha, x1, curve.eta, s, s_c)
            for f, alpha, x1, s_c in zip(period.f, period.alpha, offset, period.s_c, strict=True)
        ]
    )
    residual = np.hypot(shapes[:, 0, -1] - offset, shapes[:, 1, -1] - curve.eta)

    if status is Status.LOCK:
        position = step = np.arange(last + 1)
        cycle = np.ones_like(position)
        row = step
    else:
        # The slip ends at step last + 1 in the state that the period begins with.
        length = last + 1
        position = np.arange(cycles * length + 1)
        cycle = np.maximum(1, -(-position // length))
        step = position - (cycle - 1) * length
        row = step % length
    footpoint = step_position(position, dx0)
    return Scan(
        status,
        cycle,
        step,
        [Phase.SLIP if k > last else Phase.STICK for k in step],
        footpoint,
        footpoint + offset[row],
        StickingState(*(column[row] for column in period)),
        s,
        footpoint[:, None] + shapes[row, 0],
        shapes[row, 1],
        shapes[row, 2],
        residual[row],
    )


def _empty_scan(s: FloatArray, status: Status) -> Scan:
    none, whole = np.empty(0), np.empty(0, dtype=np.int64)
    shapes = np.empty((0, len(s)))
    return Scan(
        status,
        whole,
        whole,
        [],
        none,
        none,
        StickingState(*(none,) * len(StickingState._fields)),
        s,
        *(shapes,) * 3,
        none,
    )
