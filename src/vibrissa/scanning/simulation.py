"""A scan: the clamp moves in steps over a surface, and the tip sticks and slips.

At the first step at which |tan(α − γ)| > μ0, for the inclination γ of the surface, the tip slips
while the clamp rests. `simulate` goes from period to period: it finds the end of each period
directly, not step by step. A self-locking tip sticks until the rod, if it is round, buckles
laterally. After that the clamp drags the tip: the states of the rod are mirror images of states in
which the tip is ahead of the clamp.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property
from typing import NamedTuple

import numpy as np

from vibrissa.errors import ArgumentError, EndedScanError
from vibrissa.numerics.arrays import FloatArray, IntArray, StrArray
from vibrissa.numerics.batch import Batch
from vibrissa.outcomes import Status
from vibrissa.scanning.periods import EndsBy, Period, Periods, periods_of
from vibrissa.scanning.response import Response
from vibrissa.scanning.rods import distance_at
from vibrissa.scanning.slip import FREE_SLIP, Flight, Lost, Rest, Slip, SlipModel
from vibrissa.scanning.stage import Stage
from vibrissa.scanning.surfaces import Surface
from vibrissa.scanning.tip import ClampPath, Margin, Tip
from vibrissa.sticking.api import PENETRATES
from vibrissa.sticking.onsets import mirrored
from vibrissa.sticking.piece import StickingState
from vibrissa.wording import counted

# Decimals of a difference of positions (L).
DECIMALS = 15
LOCKS = "the tip locks at x = {x}, where mu0 = {mu0:.6g}{slope} and mu_lock = {mu_lock:.6g}; "
SLOPE = " on a slope of {angle:.4g} deg"
SWINGS = (
    LOCKS + "with the clamp at {clamp} the rod buckles laterally, and its tip is dragged behind"
)
STAYS = LOCKS + (
    "pushed further, it sticks until the clamp is at {clamp}; the motion after that is not computed"
)
LOST = (
    "the slip from x = {x}, with the clamp at {clamp}, releases so much energy that the tip lifts "
    "off the surface, or the rod is bent beyond its computed states"
)
LOST_ON_TEXTURE = {
    Lost.LIFTS: (
        "in the slip from x = {x}, with the clamp at {clamp}, the tip lifts off the surface at "
        "x = {at}, and nowhere ahead does the surface push it"
    ),
    Lost.BENT: (
        "in the slip from x = {x}, with the clamp at {clamp}, the rod comes to the end of its "
        "computed states at x = {at}"
    ),
    Lost.DEEP: (
        "in the slip from x = {x}, with the clamp at {clamp}, the tip comes at x = {at} to a "
        "height that the rod does not reach"
    ),
}
LEAVES = (
    "with the clamp at {clamp}, the tip at x = {x} comes to a height that the rod does not reach"
)
FLIES = (
    "{times} in a slip the tip lifts off, first at x = {lifts}; the flight is not computed, and "
    "the tip is taken to land where the surface pushes it again, first at x = {lands}"
)


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
        A slip passed α = 0 and did not end within the computed states. Either the clamp had pushed
        the tip, and the tip lifted off the surface; or the clamp had pulled the tip, and the tip
        came to the last computed state in which the clamp pushes it.
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
    ends : tuple of Period
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
    ends: tuple[Period, ...] = ()

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
        """``slip`` if the tip slips, ``lock`` if it locks, or why the rod has no states."""
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
        mirror = np.stack([sign, np.ones(len(sign)), sign], axis=1)
        return np.asarray(states.reactions(states.clip(sign * self.x0)) * mirror)

    @property
    def apparent_friction(self) -> FloatArray:
        """|fx/fy| at each step, shape (n,): friction and slope together at the onset of slip."""
        fx, fy, _ = self.reactions.T
        return np.abs(fx / fy)

    @cached_property
    def state(self) -> StickingState:
        """States of the rod; their x0 is the clamp's displacement since α = 0, as in `since`."""
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
        return StickingState(**(columns | {"x0": self.since}))

    @cached_property
    def since(self) -> FloatArray:
        """Displacement of the clamp since the α = 0 state of its period, along the stage (L).

        It is x0 in the step in which the period began, and the travel of the clamp since then.
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


def simulate(
    stage: Response | Stage,
    surface: Surface,
    positions: FloatArray,
    model: SlipModel = FREE_SLIP,
    slips: int | None = None,
) -> Scan:
    """Simulate a scan: find the state of the rod at each step of the clamp over a surface.

    Parameters
    ----------
    stage : Response or Stage
        The rod on its stage; a `Response` is on a level stage.
    surface : Surface
    positions : ndarray
        Clamp positions along the stage (L), as from `path`; the scan begins in the α = 0 state.
    model : SlipModel
        Where a slip ends.
    slips : int, optional
        Number of slips after which the scan ends.

    Returns
    -------
    Scan
        A row for each step, up to the end of the path or of the computed motion.

    Raises
    ------
    ArgumentError
        If the tip leaves the known part of the surface, or if the path or the law may need states
        with x0 < 0 (the clamp pulled back) that were not solved.
    EndedScanError
        If this happens after the scan has begun; the error has the scan up to there.
    """
    positions = np.asarray(positions, dtype=float)
    if isinstance(stage, Response):
        stage = Stage(response=stage, eta=stage.curve.eta)
    _check_states(stage, surface, positions, model)
    at, spell = float(positions[0]), surface.spell
    path, outcome, message = ClampPath.through(positions), Outcome.COMPLETE, ""
    ended: ArgumentError | None = None
    slip = Slip(stage=stage, surface=surface, model=model, clamp=at)
    contact = stage.at(at).contact(float(stage.along(at)), 0.0, 1)
    # At first no tangential force acts, as after a slip that ends where no friction is needed.
    rest = replace(slip, model=FREE_SLIP).rest(contact)
    if rest.lost is not None:
        return Scan.without_rows(*_lost(rest, surface, contact, at))
    tip = Tip(stage=stage, footing=surface.footing(rest.contact, 1), rest=rest.x0)
    tips, ends, swing, flights = [tip], list[Period](), "", list(rest.flights)
    while True:
        step, until = tip.sticks_until(path, at)
        if step == len(path):
            ends.append(Period(tip, step, until, EndsBy.PATH))
            break
        margin, locked = tip.exit(until)
        swings = margin is Margin.END and stage.response.swings
        stop = None if swings else _stop(tip, margin, locked, until, positions[step - 1], spell)
        if swings:
            swing = swing or _message(SWINGS, tip, until, float(positions[step]), spell)
            at, tip = until, _swung(tip, surface, until, step)
        elif stop is not None:
            outcome, message = stop.outcome, stop.message
            ends.append(Period(tip, step, until, stop.ends_by))
            break
        else:
            at = float(positions[step])
            try:
                rest = replace(slip, clamp=at, side=tip.side).rest(tip.contact)
                place = tip.contact if rest.lost is not None else rest.contact
                footing = surface.footing(place, tip.side)
            except ArgumentError as error:
                outcome, message, ended = Outcome.OUT_OF_REACH, str(error), error
                ends.append(Period(tip, step, until, EndsBy.UNKNOWN, at))
                break
            flights += rest.flights
            if rest.lost is not None:
                outcome, message = _lost(rest, surface, tip.contact, at)
                ends.append(Period(tip, step, until, EndsBy.LOST, at))
                break
            ends.append(Period(tip, step, until, EndsBy.SLIP, at, footing, rest))
            tip = replace(tip, footing=footing, begin=step, rest=rest.x0, slipped=True)
        tips.append(tip)
        if sum(one.slipped for one in tips) - 1 == slips:
            step = tip.begin + 1
            break
    messages = (swing, _flown(flights, spell), message)
    text = "; ".join(filter(None, messages))
    found = _assembled(tips, tuple(ends), positions[:step], outcome, text)
    if ended is not None:
        raise EndedScanError(str(ended), found)
    return found


def _check_states(stage: Stage, surface: Surface, positions: FloatArray, model: SlipModel) -> None:
    """Refuse a scan that may need states of the rod that were not solved."""
    if surface.texture is not None and isinstance(stage.response, Response):
        raise ArgumentError(
            "on a surface with heights the rod must be solved over a range of distances: make its "
            "stage by stage_of(rod, positions, texture=...)"
        )
    retracts = model.law.overshoots or stage.angle < 0.0 or (np.diff(positions) < 0.0).any()
    if (retracts or surface.texture is not None) and stage.at(positions[0]).x0_pull == 0.0:
        raise ArgumentError(
            "states in which the clamp is pulled back (x0 < 0) could not be solved. The laws "
            "'energy' and 'damped' need them, and so does a path backward or away from the "
            "surface, and a surface with heights: choose another path or law"
        )


class _Stop(NamedTuple):
    """Why a scan ends with a period of sticking that does not end with a slip."""

    outcome: Outcome
    message: str
    ends_by: EndsBy


def _stop(
    tip: Tip,
    margin: Margin,
    locked: bool,
    until: float,
    last: float,
    spell: Callable[[float], str],
) -> _Stop | None:
    """Return why the motion after the clamp position `until` is not computed; None after a slip.

    Parameters
    ----------
    margin, locked : optional
        As in `Exit`.
    last : float
        Position of the clamp at the last step at which the tip sticks (L).
    """
    if margin is Margin.REACH:
        message = LEAVES.format(x=spell(tip.contact), clamp=spell(until))
        return _Stop(Outcome.OUT_OF_REACH, message, EndsBy.UNKNOWN)
    response = tip.stage.response
    if margin is Margin.END and isinstance(response, Response) and not response.whole:
        return _Stop(Outcome(response.curve.status), response.curve.message, EndsBy.UNKNOWN)
    if margin is Margin.END or (locked and margin is Margin.BACKWARD):
        message = _message(STAYS, tip, until, float(last), spell)
        return _Stop(Outcome.LOCK, message, EndsBy.LOCK)
    return None


def _swung(tip: Tip, surface: Surface, clamp: float, step: int) -> Tip:
    """Return the tip after lateral buckling at a position of the clamp (L), before a step.

    It is at its mirror image about the clamp: on a surface with heights, where the tip alone
    touches, at the same place.
    """
    contact = tip.contact
    if surface.texture is None:
        contact = 2.0 * float(tip.stage.along(clamp)) - tip.contact
    return Tip(
        stage=tip.stage,
        footing=surface.footing(contact, -tip.side),
        side=-tip.side,
        begin=step,
        rest=np.nan,
        slipped=False,
    )


def _lost(rest: Rest, surface: Surface, begin: float, clamp: float) -> tuple[Outcome, str]:
    """Return the outcome of a scan whose slip from the position `begin` (L) is lost, and why."""
    assert rest.lost is not None
    text = LOST if surface.texture is None else LOST_ON_TEXTURE[rest.lost]
    outcome = Outcome.OUT_OF_REACH if rest.lost is Lost.DEEP else Outcome.LOST
    places = {"x": begin, "clamp": clamp, "at": rest.contact}
    return outcome, text.format(**{name: surface.spell(one) for name, one in places.items()})


def _flown(flights: Sequence[Flight], spell: Callable[[float], str]) -> str:
    """Say how often the tip has lifted off in slips."""
    if not flights:
        return ""
    takes_off, lands = map(spell, flights[0])
    return FLIES.format(times=counted(len(flights), "time"), lifts=takes_off, lands=lands)


def _message(text: str, tip: Tip, until: float, clamp: float, spell: Callable[[float], str]) -> str:
    """Complete a message for a tip that sticks up to the clamp position `until`."""
    angle = np.degrees(np.arctan(tip.footing.ahead.slope))
    return text.format(
        x=spell(tip.contact),
        mu0=tip.mu0,
        slope=SLOPE.format(angle=angle) if angle else "",
        mu_lock=tip.held(until).states.mu_lock,
        clamp=spell(clamp),
    )


def _assembled(
    tips: Sequence[Tip],
    ends: tuple[Period, ...],
    clamp: FloatArray,
    outcome: Outcome,
    message: str,
) -> Scan:
    """Assemble a scan, with one row for each step, from the places at which the tip stuck."""
    stage = tips[0].stage
    begins = np.array([tip.begin for tip in tips])
    slipped = np.array([tip.slipped for tip in tips])
    counts = np.diff(begins, append=len(clamp))

    def in_rows(values: list[float] | list[int]) -> FloatArray:
        return np.repeat(values, counts)

    contact = in_rows([tip.contact for tip in tips])
    side = np.repeat([tip.side for tip in tips], counts)
    height = in_rows([tip.footing.height for tip in tips])
    slope = in_rows([tip.footing.ahead.slope for tip in tips])
    states, x0 = stage.states(clamp, contact, side, height)
    # In the step of a slip x0 is known without the rounding of positions.
    rest = np.full(len(clamp), np.nan)
    rest[begins[counts > 0]] = [tip.rest for tip, count in zip(tips, counts, strict=True) if count]
    x0 = np.where(np.isnan(rest), x0, rest)
    phase = np.where(x0 > states.x0_lock, TipPhase.LOCK, TipPhase.STICK)
    # If the rod buckles laterally and slips in the same step, the tip in between has no row.
    later = (begins > 0) & (counts > 0)
    phase[begins[later]] = np.where(slipped[later], TipPhase.SLIP, TipPhase.SWING)
    return Scan(
        outcome=outcome,
        message=message,
        stage=stage,
        clamp=clamp,
        contact=contact,
        x0=side * x0 + 0.0,  # no −0
        mu0=in_rows([tip.mu0 for tip in tips]),
        height=height,
        inclination=0.0 - side * np.arctan(slope),
        period=np.repeat(np.cumsum(slipped), counts),
        phase=phase,
        side=np.where(side == 1, TipSide.AHEAD, TipSide.BEHIND),
        ends=ends,
    )
