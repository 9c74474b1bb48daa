"""The result of a scan: states of the rod, a row for each step of the clamp."""

from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from typing import NamedTuple

import numpy as np

from vibrissa.errors import ArgumentError
from vibrissa.numerics.arrays import FloatArray, IntArray, StrArray
from vibrissa.numerics.batch import Batch
from vibrissa.outcomes import Status
from vibrissa.scanning.periods import PeriodEnd, Periods, periods_of
from vibrissa.scanning.response import mirrored_loads
from vibrissa.scanning.rods import distance_at
from vibrissa.scanning.stage import Stage
from vibrissa.sticking.onsets import mirrored
from vibrissa.sticking.piece import StickingState
from vibrissa.sticking.results import PENETRATES
from vibrissa.wording import counted

# Decimals of a difference of positions (L).
DECIMALS = 15


class TipPhase(StrEnum):
    """Phase of the tip at a step.

    Attributes
    ----------
    STICK
        The tip has not slipped since the previous step.
    LOCK
        The tip sticks at x0 > x0_lock, the displacement at which −tan α is largest: pushed
        further, it does not slip forward.
    SLIP
        The tip has just slipped and is at rest.
    SWING
        The rod has just buckled laterally. Its tip sticks, on the other side of the clamp.
    """

    STICK = "stick"
    LOCK = "lock"
    SLIP = "slip"
    SWING = "swing"


class TipSide(StrEnum):
    """Side of the clamp on which the tip is: ahead of it, as at the start, or behind it."""

    AHEAD = "ahead"
    BEHIND = "behind"


class Outcome(StrEnum):
    """How a scan ended.

    Attributes
    ----------
    COMPLETE
        The clamp reached the end of the path, or the tip slipped as often as it was to.
    LOCK
        The tip locked and was pushed until sticking ended; the motion after that is not computed.
    LOST
        A slip did not end within the computed states of the rod (`vibrissa.scanning.slide.Lost`).
        On a plane it then passed α = 0. Either the clamp had pushed the tip, and the tip lifted off
        the surface; or the clamp had pulled the tip, and the tip came to the last computed state in
        which the clamp pushes it.
    OUT_OF_REACH
        The rod has no states, the stage or the surface takes it to a distance at which it has none,
        or the tip leaves the known part of the surface.
    FAILED
        The states of the rod could not be computed.
    """

    COMPLETE = "complete"
    LOCK = "lock"
    LOST = "lost"
    OUT_OF_REACH = "out_of_reach"
    FAILED = "failed"


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Scan(Batch):
    """States of a scan, one row for each step of the clamp.

    Attributes
    ----------
    outcome : Outcome
    message : str
        Says where the rod first buckled laterally, and where and why the scan ended early.
    stage : Stage or None
        None in a scan without rows.
    clamp : ndarray, shape (n,)
        Position of the clamp along its stage (L).
    contact : ndarray, shape (n,)
        Position of the tip, which is the contact point in point contact (L).
    x0 : ndarray, shape (n,)
        Displacement of the clamp along the surface (L), from the α = 0 state with the same
        `contact`, the same `side`, and the same distance of the contact point from the clamp.
    mu0 : ndarray, shape (n,)
        Coefficient of static friction at the contact point.
    height, inclination : ndarray, shape (n,)
        Height h of the surface at the contact point (L), and its inclination γ = −atan h' (rad),
        positive where the surface falls along the scan; at a kink that of the face ahead.
    period : ndarray of int, shape (n,)
        Number of the period of sticking, from 1. The step of a slip is the first of a new period.
    phase, side : ndarray of str, shape (n,)
        `TipPhase` and `TipSide` at each step.
    ends : tuple of PeriodEnd
        Where each period of sticking ends, and how; `periods` has them as columns.
    """

    outcome: Outcome
    message: str
    stage: Stage | None
    clamp: FloatArray
    contact: FloatArray
    x0: FloatArray
    mu0: FloatArray
    height: FloatArray
    inclination: FloatArray
    period: IntArray
    phase: StrArray
    side: StrArray
    ends: tuple[PeriodEnd, ...] = ()

    @classmethod
    def without_rows(cls, outcome: Outcome, message: str) -> "Scan":
        """Make the scan of a rod that has no states."""
        numbers, texts = np.empty(0), np.empty(0, dtype=np.str_)
        return cls(
            outcome=outcome,
            message=message,
            stage=None,
            clamp=numbers,
            contact=numbers,
            x0=numbers,
            mu0=numbers,
            height=numbers,
            inclination=numbers,
            period=np.empty(0, dtype=np.int64),
            phase=texts,
            side=texts,
        )

    @property
    def status(self) -> Status:
        """``lock`` if the tip locks; ``slip`` if it slips, or could on a path that ends before.

        Else why the rod has no states.
        """
        locks = np.isin(self.phase, [TipPhase.LOCK, TipPhase.SWING]).any()
        if locks or self.outcome is Outcome.LOCK:
            return Status.LOCK
        if self.slips or self.outcome in (Outcome.COMPLETE, Outcome.LOST):
            return Status.SLIP
        return Status(self.outcome)

    @property
    def cycle(self) -> IntArray:
        """Number of the stick-slip cycle at each step, from 1; a cycle ends with its slip."""
        return np.asarray(self.period - ((self.phase == TipPhase.SLIP) & (self.period > 1)))

    @property
    def step(self) -> IntArray:
        """Number of steps of the clamp since the cycle began; 0 at the start of the scan."""
        rows = np.arange(len(self))
        begins = np.append(0, np.flatnonzero(self.phase == TipPhase.SLIP))
        return np.asarray(rows - begins[np.maximum(self.cycle - 1, 0)])

    @property
    def slips(self) -> int:
        """Number of slips."""
        return int((self.phase == TipPhase.SLIP).sum())

    @cached_property
    def periods(self) -> Periods:
        """Periods of sticking, from one slip to the next."""
        return periods_of(self.ends, self.clamp)

    @property
    def penetrates(self) -> bool:
        """Whether the rod passes through the surface in one of the steps, as no real rod does.

        On an oblique stage: whether x0 is so large that it does at one of the solved distances.
        """
        if self.stage is None:
            return False
        through = self.stage.response.x0_through
        return bool(through == 0.0 or (self._sign * self.x0 > through).any())

    @property
    def marks(self) -> list[str]:
        """What makes the scan no scan of a real rod."""
        return [PENETRATES] if self.penetrates else []

    def __repr__(self) -> str:
        """Return outcome, numbers of steps and slips, message and marks."""
        counts = f"{counted(len(self), 'row')}, {counted(self.slips, 'slip')}"
        lines = [f"{'outcome':<12} {self.outcome.value}: {counts}"]
        lines += [f"{'message':<12} {self.message}"] if self.message else []
        return "\n".join([*lines, *(f"{'warning':<12} {mark}" for mark in self.marks)])

    @property
    def _sign(self) -> IntArray:
        return np.where(self.side == TipSide.BEHIND, -1, 1)

    @cached_property
    def reactions(self) -> FloatArray:
        """Clamp reactions fx, fy (E·I0/L²) and m (E·I0/L), shape (n, 3)."""
        if self.stage is None:
            return np.empty((0, 3))
        states = self.stage.at(self.clamp, self.height)
        sign = self._sign
        return mirrored_loads(states.reactions(states.clip(sign * self.x0)), sign)

    @property
    def apparent_friction(self) -> FloatArray:
        """|fx/fy| at each step, shape (n,): friction and slope together at the onset of slip."""
        fx, fy, _ = self.reactions.T
        return np.abs(fx / fy)

    @cached_property
    def state(self) -> StickingState:
        """States of the rod; their x0 is the displacement `x0_along_stage`."""
        if self.stage is None:
            return StickingState.unknown(0)
        states, sign = self.stage.at(self.clamp, self.height), self._sign
        found = states.state(states.clip(sign * self.x0))
        behind = np.flatnonzero(sign < 0)
        loads = mirrored(found.take(behind), 0.0)
        columns = {
            name: _replaced(values, behind, getattr(loads, name))
            for name, values in found.columns.items()
        }
        return StickingState(**(columns | {"x0": self.x0_along_stage}))

    @cached_property
    def x0_along_stage(self) -> FloatArray:
        """Displacement of the clamp along its stage, since the α = 0 state of the period (L).

        It is x0 in the step in which the period began, and the travel of the clamp since then: the
        column `x0` of a study's table `scans`. On a level stage it is `x0`, up to rounding.
        """
        begin = np.flatnonzero(np.diff(self.period, prepend=0))
        first = np.repeat(begin, np.diff(begin, append=len(self)))
        # Positions are whole steps; without rounding errors their differences are, too.
        return self.x0[first] + np.round(self.clamp - self.clamp[first], DECIMALS)

    def shapes(self, points: int = 101) -> "ScannedShapes":
        """Deformed shapes of the rod at each step.

        Parameters
        ----------
        points : int
            Number of points of each shape, equally spaced in s, both ends included; at least 2.

        Raises
        ------
        ArgumentError
            If there are fewer than two points.
        """
        if not isinstance(points, int | np.integer) or points < 2:
            raise ArgumentError(f"points must be a whole number, at least 2, got {points!r}")
        s, sign = np.linspace(0.0, 1.0, points), self._sign
        if self.stage is None:
            none = np.empty((0, points))
            return ScannedShapes(s=s, x=none, y=none, phi=none, residual=np.empty(0))
        states, along = self.stage.at(self.clamp, self.height), self.stage.along(self.clamp)
        offset = self.contact - along
        distance = distance_at(self.clamp, self.stage.eta, self.stage.angle)
        x, y, phi = states.shapes(states.clip(sign * self.x0), sign * offset, s)
        x, phi = sign[:, None] * x, np.where(sign[:, None] < 0, np.pi - phi, phi)
        # In line contact only a straight tail ends at the point of the surface that `contact` is.
        residual = np.hypot(x[:, -1] - offset, y[:, -1] - (distance - self.height))
        return ScannedShapes(
            s=s,
            x=along[:, None] + x,
            y=self.stage.eta - distance[:, None] + y,
            phi=phi,
            residual=residual,
        )


class ScannedShapes(NamedTuple):
    """Shapes of the rod at the n steps of a scan, relative to the surface.

    Attributes
    ----------
    s : ndarray, shape (points,)
        Arc lengths (L).
    x, y, phi : ndarray, shape (n, points)
        Positions (L) and slopes (rad).
    residual : ndarray, shape (n,)
        Distance between the end of the shape and the point `contact` of the surface (L).
    """

    s: FloatArray
    x: FloatArray
    y: FloatArray
    phi: FloatArray
    residual: FloatArray


def _replaced(values: FloatArray, rows: IntArray, others: FloatArray) -> FloatArray:
    """Return a copy in which some rows have other values."""
    found = values.copy()
    found[rows] = others
    return found
