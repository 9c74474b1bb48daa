"""Stick-slip cycles: what a sensor sees while the clamp moves on and on.

The tip sticks until the first step of the footpoint at which −tan α > μ0 and then slips, in the
paper until α = 0; `vibrissa.sensor.simulation.slips` has other laws of slip.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from vibrissa.decimals import exact
from vibrissa.errors import ArgumentError
from vibrissa.mechanics.elastica import deformed_shape
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.numerics.steps import last_step_within, step_position
from vibrissa.outcomes import Contact, Status
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.piece import StickingState
from vibrissa.sticking.reading import CurveArray
from vibrissa.sticking.solving.collocation import solve_curves


class Phase(StrEnum):
    """Phase of the tip at a footpoint position: it sticks, or has just slipped."""

    STICK = "stick"
    SLIP = "slip"


@dataclass(frozen=True, eq=False, kw_only=True)
class Scan:
    """States of a stick-slip scan, one for each step of the clamp.

    Attributes
    ----------
    status : Status
        ``slip``, or ``lock``: a rod that buckles laterally is then dragged; other scans end with
        their first period. Without states as the curve.
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
        Its x0 counts from the α = 0 state in which the period began.
    s : ndarray, shape (points,)
        Arc lengths of the shape points (L).
    x, y, phi : ndarray, shape (n, points)
        Shapes, x in the frame of the surface (L, rad).
    residual : ndarray, shape (n,)
        Distance between the integrated shape's end and the contact point (L).
    message : str
        Why it has fewer cycles than requested; empty otherwise.
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
    mu0, dx0 : Decimal or float
    cycles : int
    shape_points : int
        Number of points of each shape, equally spaced in s, both ends included.
    contact : str
        Contact by which the later cycles of an oblique stage are solved.

    Returns
    -------
    Scan
        One row for each footpoint position: the α = 0 state, then for each cycle its sticking
        steps and the state into which it slips.

    Raises
    ------
    ArgumentError
        If the step or the number of cycles is not positive, or a shape has fewer than two points.

    Examples
    --------
    >>> from vibrissa import solve_curve
    >>> scan = stick_slip(solve_curve(theta=2, eta=0.85), mu0=0.3, dx0=0.01, cycles=2)
    >>> print(scan.footpoint)
    [0.   0.01 0.02 0.03 0.04 0.05 0.06]
    >>> print(scan.x1.round(4))
    [0.4173 0.4173 0.4173 0.4473 0.4473 0.4473 0.4773]
    """
    if cycles < 1:
        raise ArgumentError(f"cycles must be at least 1, got {cycles}")
    if shape_points < 2:
        raise ArgumentError(f"shape_points must be at least 2, got {shape_points}")
    dx0 = exact(dx0)
    if not dx0 > 0:
        raise ArgumentError(f"dx0 must be positive, got {dx0}")
    s = np.linspace(0.0, 1.0, shape_points)
    status, until = _end_of_sticking(curve, float(mu0))
    if status not in (Status.SLIP, Status.LOCK):
        return _empty_scan(s, status)
    if curve.mounting.stage_angle and status is Status.SLIP:
        return _oblique(curve, float(mu0), dx0, cycles, s, contact)

    # The first period and one of the later ones, which are all the same, translated.
    first = _first_period(curve, step_position(np.arange(1 + until.first(dx0)), dx0), s)
    later = first
    if status is Status.LOCK:
        later = _dragged_period(curve, step_position(np.arange(1 + until.later(dx0)), dx0), s)
    # The last cycle ends with the state into which the tip slips.
    periods = [first, *[later] * (cycles - 1), later.take(np.zeros(1, dtype=np.int64))]
    if not until.slips:
        periods = [first]
    at = _Numbers.of([len(period.offset) for period in periods])
    return _scan(curve, status, _joined(periods), at, dx0, s)


def _oblique(
    curve: StickingCurve, mu0: float, dx0: Decimal, cycles: int, s: FloatArray, contact: str
) -> Scan:
    """Cycles on an oblique stage: the tip slips to the α = 0 state at the height of the clamp."""
    periods: list[_Period] = []
    message, one, eta, steps = "", curve, curve.eta, 0
    while True:
        # A period begins with the state into which the tip has slipped.
        status, until = _end_of_sticking(one, mu0)
        if status in (Status.SLIP, Status.LOCK):
            last = until.first(dx0) if len(periods) < cycles else 0
            displacement = step_position(np.arange(1 + last), dx0)
            periods.append(_first_period(one, displacement, s))
            steps += 1 + last
        if len(periods) > cycles:
            break
        if status is not Status.SLIP:
            message = f"at the height {eta:.6g} (in units of L): {one.message or status}"
            break
        eta = curve.contact_point(step_position(np.array(steps), dx0))[1].item()
        if not 0.0 < eta < 1.0:
            message = f"the stage takes the clamp to the height {eta:.6g} (in units of L)"
            break
        rod = np.array([curve.theta]), np.array([eta])
        (one,) = solve_curves(*rod, Contact(contact), [curve.mounting], curve.section)
    at = _Numbers.of([len(period.offset) for period in periods])
    return _scan(curve, Status.SLIP, _joined(periods), at, dx0, s, message)


class _Numbers(NamedTuple):
    """Numbers of cycle and step of each state of a scan, and whether the tip has just slipped."""

    cycle: IntArray
    step: IntArray
    slips: BoolArray

    @classmethod
    def of(cls, counts: Sequence[int]) -> "_Numbers":
        """Count the states of periods; the first of each later one ends the cycle before."""
        cycle = np.repeat(np.arange(1, 1 + len(counts)), counts)
        step = np.concatenate([np.arange(count) for count in counts])
        slips = (step == 0) & (cycle > 1)
        step[slips], cycle[slips] = counts[:-1], cycle[slips] - 1
        return cls(cycle, step, slips)


def _scan(
    curve: StickingCurve,
    status: Status,
    period: "_Period",
    at: _Numbers,
    dx0: Decimal,
    s: FloatArray,
    message: str = "",
) -> Scan:
    """Place the states of a scan on the surface, one for each footpoint position."""
    footpoint = step_position(np.arange(len(at.step)), dx0)
    along = footpoint * np.cos(curve.mounting.stage_angle)
    offset, height, (x, y, phi) = period.offset, period.height, period.shapes
    return Scan(
        status=status,
        cycle=at.cycle,
        step=at.step,
        phase=[Phase.SLIP if slips else Phase.STICK for slips in at.slips],
        footpoint=footpoint,
        x1=along + offset,
        state=period.states,
        s=s,
        x=along[:, None] + x,
        y=curve.eta - height[:, None] + y,
        phi=phi,
        residual=np.hypot(x[:, -1] - offset, y[:, -1] - height),
        message=message,
    )


class _Until(NamedTuple):
    """Displacements since α = 0 at which the first and the later periods end; NaN without later."""

    end: float
    later_end: float

    @property
    def slips(self) -> bool:
        """Whether the first period ends with a slip."""
        return not np.isnan(self.later_end)

    def first(self, dx0: Decimal) -> int:
        """Last step of the footpoint in the first period."""
        return int(last_step_within(np.array(self.end), dx0))

    def later(self, dx0: Decimal) -> int:
        """Last step of the footpoint in a later period; 0 without any."""
        return int(last_step_within(np.array(np.nan_to_num(self.later_end)), dx0))


def _end_of_sticking(curve: StickingCurve, mu0: float) -> tuple[Status, _Until]:
    """Whether the tip slips or locks, and where its periods end."""
    only = np.zeros(1, dtype=np.int64)
    (until,), (status,) = CurveArray(curves=(curve,)).outcomes(only, np.array([mu0]))
    if status is not Status.LOCK:
        return status, _Until(float(until), float(until))
    trail = float(curve.trailing_end(mu0).x0[0])
    if np.isfinite(trail):
        return status, _Until(trail, trail - 2.0 * curve.x0_end)
    end = float(curve.motion_end(mu0)[1].x0[0])
    return status, _Until(end if np.isfinite(end) else curve.x0_lock, np.nan)


class _Period(NamedTuple):
    """States of a period, places of the tip from the clamp (L), and shapes x, y and φ."""

    states: StickingState
    offset: FloatArray
    height: FloatArray
    shapes: tuple[FloatArray, FloatArray, FloatArray]

    def take(self, row: IntArray) -> "_Period":
        """Select states."""
        x, y, phi = self.shapes
        shapes = (x[row], y[row], phi[row])
        return _Period(self.states.take(row), self.offset[row], self.height[row], shapes)


def _joined(periods: Sequence[_Period]) -> _Period:
    """Join the states of periods in order."""
    x, y, phi = (np.concatenate(parts) for parts in zip(*(p.shapes for p in periods), strict=True))
    return _Period(
        StickingState.concatenate([period.states for period in periods]),
        np.concatenate([period.offset for period in periods]),
        np.concatenate([period.height for period in periods]),
        (x, y, phi),
    )


def _first_period(curve: StickingCurve, displacement: FloatArray, s: FloatArray) -> _Period:
    """States at displacements since α = 0, also after the rod has buckled laterally."""
    behind = displacement > curve.x0_end
    x0 = np.where(behind, 2.0 * curve.x0_end - displacement, displacement)
    return _period(curve, x0, behind, displacement, s)


def _dragged_period(curve: StickingCurve, displacement: FloatArray, s: FloatArray) -> _Period:
    """States of a rod that trails behind its clamp, at displacements since α = 0."""
    behind = np.ones(len(displacement), dtype=bool)
    return _period(curve, -displacement, behind, displacement, s)


def _period(
    curve: StickingCurve,
    x0: FloatArray,
    behind: BoolArray,
    displacement: FloatArray,
    s: FloatArray,
) -> _Period:
    """States of the curve, mirrored where `behind` is true."""
    states, shapes = curve.state(x0), _shapes(curve, curve.state(x0), s)
    sign = np.where(behind, -1.0, 1.0)
    x, y, phi = np.moveaxis(shapes, 1, 0)
    mirrored = curve.mirrored(states.take(behind))
    states = replace(states, x0=displacement)
    states.put(behind, replace(mirrored, x0=displacement[behind]))
    turned = np.where(behind[:, None], np.pi - phi, phi)
    offset, height = curve.contact_point(x0)
    return _Period(states, sign * offset, height, (sign[:, None] * x, y, turned))


def _shapes(curve: StickingCurve, states: StickingState, s: FloatArray) -> FloatArray:
    """Shapes in some states of a curve, shape (n, 3, points): x, y and φ."""
    rows = zip(states.f, states.alpha, *curve.contact_point(states.x0), states.s_c, strict=True)
    return np.stack(
        [
            deformed_shape(curve.theta, f, alpha, x1, y1, s, s_c, curve.mounting)
            for f, alpha, x1, y1, s_c in rows
        ]
    )


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
