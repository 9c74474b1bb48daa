"""A scan: the clamp moves in steps over a surface, and the tip sticks and slips behind it.

At the first step at which |tan α| > μ0 the tip slips while the clamp rests. A self-locking tip
sticks until the round rod buckles laterally; then the states are mirror images.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from enum import StrEnum
from functools import partial
from itertools import pairwise

import numpy as np

from vibrissa.decimals import exact
from vibrissa.errors import ArgumentError
from vibrissa.numerics.arrays import FloatArray, IntArray, StrArray
from vibrissa.numerics.batch import Batch
from vibrissa.numerics.steps import passes, step_position
from vibrissa.sensor.quantities import chosen
from vibrissa.sensor.response.branch import Response
from vibrissa.sensor.simulation.slips import SlipLaw, Slips
from vibrissa.sensor.simulation.tip import Exit, Tip
from vibrissa.sensor.stage import Stage
from vibrissa.sensor.surfaces import Surface

# More steps than these fill the memory.
MOST_STEPS = 10**8
# Lengths that are converted to L are rounded, by far less than this part of a step.
ROUNDED_AWAY = 1e-6
# Steps that are searched together for the end of a period.
BLOCK = 4096


class TipPhase(StrEnum):
    """Phase of the tip at a step.

    Attributes
    ----------
    STICK
        It sticks since the step before.
    LOCK
        It sticks past the critical state: pushing cannot make it slip.
    SLIP
        It has just slipped, and rests.
    SWING
        It sticks; the rod has just buckled laterally, to the other side of the clamp.
    """

    STICK = "stick"
    LOCK = "lock"
    SLIP = "slip"
    SWING = "swing"


class TipSide(StrEnum):
    """Where the tip is: ahead of the clamp, as at the beginning, or dragged behind it."""

    AHEAD = "ahead"
    BEHIND = "behind"


class Outcome(StrEnum):
    """How a scan ended.

    Attributes
    ----------
    COMPLETE
        At the end of the path.
    LOCK
        The tip locked and was pushed until sticking ended, other than by lateral buckling.
    LOST
        A slip left the computed states: it passed α = 0, and a pushed tip lifted off the
        surface, or a pulled tip reached the end of pushing.
    AWAY, NEAR
        An oblique stage took the clamp too far from the surface, or too near, for a response.
    """

    COMPLETE = "complete"
    LOCK = "lock"
    LOST = "lost"
    AWAY = "away"
    NEAR = "near"


@dataclass(frozen=True, eq=False, kw_only=True)
class SurfaceScan(Batch):
    """States of a scan, one row for each step of the clamp.

    Attributes
    ----------
    outcome : Outcome
    message : str
        Where the rod first buckled laterally; where and why the scan ended early.
    clamp : ndarray, shape (n,)
        Position of the clamp along its stage (L).
    contact : ndarray, shape (n,)
        Position of the tip, which is the contact point in point contact (L).
    x0 : ndarray, shape (n,)
        Displacement of the clamp, along the surface, from the α = 0 state of this contact point on
        this side, at the present height (L).
    reactions : ndarray, shape (n, 3)
        Clamp reactions fx, fy (E·I0/L²) and m (E·I0/L).
    mu0 : ndarray, shape (n,)
        Static friction at the contact point.
    period : ndarray of int, shape (n,)
        Number of the period of sticking, from 1. A period begins at the step of the slip before it.
    phase, side : ndarray of str, shape (n,)
        One `TipPhase` and one `TipSide` for each step.
    """

    outcome: Outcome
    message: str
    clamp: FloatArray
    contact: FloatArray
    x0: FloatArray
    reactions: FloatArray
    mu0: FloatArray
    period: IntArray
    phase: StrArray
    side: StrArray


def path(
    step: Decimal | float | str,
    turns: Sequence[Decimal | float | str],
    told: Callable[[float], str] = lambda length: f"{length:g}",
) -> FloatArray:
    """Positions of a stage that moves from 0 to each turning point in equal steps.

    Parameters
    ----------
    step : Decimal or float or str
        Step of the stage (L).
    turns : sequence of Decimal or float or str
        Where it turns, and at last stops (L); rounded to the step before.
    told : callable
        How a message writes a length (L).

    Returns
    -------
    ndarray
        Positions (L), the start included.

    Raises
    ------
    ArgumentError
        If the step is not positive or too small, or a part of the path is shorter than a step.
    """
    size = exact(step)
    if not size > 0:
        raise ArgumentError(f"step must be positive, got {step}")
    length = told(float(size))
    counts = [0, *(_steps_to(turn, size) for turn in turns)]
    total = sum(abs(end - begin) for begin, end in pairwise(counts))
    if total > MOST_STEPS:
        raise ArgumentError(
            f"a step of {length} is too small: {total:.3g} steps, at most {MOST_STEPS:,}"
        )
    parts = [np.zeros(1, dtype=np.int64)]
    for begin, end in pairwise(counts):
        if begin == end:
            raise ArgumentError(f"each part of the path must be at least one step of {length} long")
        sign = int(np.sign(end - begin))
        parts.append(np.arange(begin + sign, end + sign, sign))
    return step_position(np.concatenate(parts), size)


def _steps_to(turn: Decimal | float | str, size: Decimal) -> int:
    """Count the whole steps up to a turn, robust to the rounding of converted units."""
    quotient = exact(turn) / size
    nearest = round(quotient)
    return nearest if abs(quotient - nearest) < ROUNDED_AWAY else int(quotient)


@dataclass(frozen=True, kw_only=True)
class _Part:
    """Sticking of one tip on one side of the clamp, from the step `begin` to before the step `end`.

    It begins with a slip, or with lateral buckling. It ends with the clamp at `until` (L) by the
    event `exit`; None at the end of the path.
    """

    tip: Tip
    begin: int
    slipped: bool
    end: int
    until: float
    exit: Exit | None

    @property
    def locked(self) -> bool:
        """Whether the tip locked and was pushed until sticking ended."""
        states, x0 = self.tip.stage.states(self.until, self.tip.contact, self.tip.side)
        past = bool(x0 > states.x0_lock)
        return self.exit is Exit.END or (self.exit is Exit.BACKWARD and past)

    @property
    def swung_contact(self) -> float:
        """Position of the tip after lateral buckling (L)."""
        tip = self.tip
        states, x0 = tip.stage.states(self.until, tip.contact, tip.side)
        return float(tip.stage.along(self.until) + tip.side * (x0 - states.x1_init))


def simulate(
    rod: Response | Stage,
    surface: Surface,
    positions: FloatArray,
    law: SlipLaw | str = SlipLaw.FREE,
    kinetic_ratio: float = 0.8,
    progress: Callable[[int], None] = lambda done: None,
) -> SurfaceScan:
    """Move the clamp over a surface.

    Parameters
    ----------
    rod : Response or Stage
        The rod on its stage; a response alone is on a level one.
    surface : Surface
    positions : ndarray
        Clamp positions along the stage (L), as from `path`; the scan begins in the α = 0 state.
    law : SlipLaw or str
    kinetic_ratio : float
        Both as in `vibrissa.sensor.scan`.
    progress : callable
        Told after each period how many steps are done.

    Returns
    -------
    SurfaceScan
        Up to the end of sticking, or of the heights that were solved.

    Raises
    ------
    ArgumentError
        If an argument is out of range, the path goes backward although the response covers forward
        motion only, or the tip leaves the known part of the surface.
    """
    positions = np.asarray(positions, dtype=float)
    stage = Stage(rod=rod, eta=rod.curve.eta) if isinstance(rod, Response) else rod
    known, outcome, end = _known(stage, positions, surface.told)
    slips = partial(Slips, surface=surface, law=chosen(SlipLaw, law, "law"), ratio=kinetic_ratio)
    slips(response=stage.branch(0.0))  # refuses an impossible ratio
    parts: list[_Part] = []
    begin, at, slipped = 0, float(positions[0]), True
    tip = _tip(stage, surface, stage.x1_init + float(stage.along(at)), 1)
    while True:
        part = _part(tip, positions[:known], begin, at, slipped)
        parts.append(part)
        progress(part.end)
        if part.exit is None:
            break
        begin, slipped = part.end, not part.locked
        if slipped:
            at = float(positions[begin])
            contact = _slid(tip, at, slips(response=stage.branch(at)))
            if np.isnan(contact):
                outcome, end = Outcome.LOST, _lost(part, at, surface.told)
                break
            tip = _tip(stage, surface, contact, tip.side)
        elif part.exit is Exit.END and stage.swings:
            at = part.until
            tip = Tip(stage=stage, contact=part.swung_contact, mu0=tip.mu0, side=-tip.side)
        else:
            outcome = Outcome.LOCK
            end = _locked(part, float(positions[begin - 1]), surface.told)
            break
    message = "; ".join(filter(None, (_swings(parts, positions, surface.told), end)))
    return _assembled(stage, positions, parts, outcome, message)


def _known(
    stage: Stage, positions: FloatArray, told: Callable[[float], str]
) -> tuple[int, Outcome, str]:
    """Count the steps whose heights were solved, with the reason why the next one was not."""
    heights = stage.rod
    if isinstance(heights, Response):
        if heights.x0_pull == 0.0 and (np.diff(positions) < 0.0).any():
            raise ArgumentError(
                "the path goes backward, but the response covers forward motion only: "
                "solve it with pull=True"
            )
        return len(positions), Outcome.COMPLETE, ""
    height = stage.height(positions)
    for out, outcome, reason in (
        (passes(-height, -heights.low), Outcome.NEAR, heights.below),
        (passes(height, heights.high), Outcome.AWAY, heights.above),
    ):
        if out.any():
            first = int(np.argmax(out))
            message = (
                f"the stage takes the clamp at {told(float(positions[first]))} to the height "
                f"{told(float(height[first]))}: {reason}"
            )
            return first, outcome, message
    return len(positions), Outcome.COMPLETE, ""


def _tip(stage: Stage, surface: Surface, contact: float, side: int) -> Tip:
    """Rest a tip on the surface."""
    return Tip(stage=stage, contact=contact, mu0=float(surface(contact)), side=side)


def _slid(tip: Tip, clamp: float, slips: Slips) -> float:
    """Position of the tip after its slip (L); NaN if the slip leaves the computed states."""
    _, x0 = tip.stage.states(clamp, tip.contact, tip.side)
    along = float(tip.stage.along(clamp))
    return slips.response.contact(along, slips.rest(along, float(x0), tip.side), tip.side)


def _part(tip: Tip, positions: FloatArray, begin: int, clamp: float, slipped: bool) -> _Part:
    """Follow a sticking tip from the clamp position `clamp` to the end of sticking."""
    rest = positions[begin:]
    low, high = tip.interval(clamp, float(rest.min()), float(rest.max()))
    end, until = len(positions), np.nan
    # A tip that has just slipped rests; after lateral buckling it may have to slip at once.
    for first in range(begin + int(slipped), len(positions), BLOCK):
        some = positions[first : first + BLOCK]
        out = np.flatnonzero(passes(some, high) | passes(-some, -low))
        if len(out):
            end = first + int(out[0])
            until = high if positions[end] > high else low
            break
    return _Part(
        tip=tip,
        begin=begin,
        slipped=slipped,
        end=end,
        until=until,
        exit=None if np.isnan(until) else tip.exit(until),
    )


def _swings(parts: Sequence[_Part], positions: FloatArray, told: Callable[[float], str]) -> str:
    """Describe where the rod first buckles laterally; empty if it does not."""
    for part, after in pairwise(parts):
        if not after.slipped:
            return (
                f"{_locks(part, told)}; with the clamp at {told(float(positions[part.end]))} the "
                "rod buckles laterally, and its tip is dragged behind"
            )
    return ""


def _locks(part: _Part, told: Callable[[float], str]) -> str:
    tip = part.tip
    return (
        f"the tip locks at x = {told(tip.contact)}, where mu0 = {tip.mu0:.6g} and "
        f"mu_lock = {tip.stage.branch(part.until).mu_lock:.6g}"
    )


def _locked(part: _Part, clamp: float, told: Callable[[float], str]) -> str:
    return (
        f"{_locks(part, told)}; pushed further, it sticks until the clamp is at {told(clamp)}; the "
        "motion after that is not computed"
    )


def _lost(part: _Part, clamp: float, told: Callable[[float], str]) -> str:
    pulled = part.exit in (Exit.BACKWARD, Exit.PULL)
    where = "the rod is pushed through" if pulled else "the tip lifts off the surface"
    return (
        f"the slip from x = {told(part.tip.contact)}, with the clamp at {told(clamp)}, has so much "
        f"energy that {where}"
    )


def _assembled(
    stage: Stage,
    positions: FloatArray,
    parts: Sequence[_Part],
    outcome: Outcome,
    message: str,
) -> SurfaceScan:
    """Put the parts together, one row for each step."""
    begins = np.array([part.begin for part in parts])
    slipped = np.array([part.slipped for part in parts])
    counts = np.array([part.end for part in parts]) - begins
    clamp = positions[: counts.sum()]
    contact = np.repeat([part.tip.contact for part in parts], counts)
    side = np.repeat([part.tip.side for part in parts], counts)
    states, x0 = stage.states(clamp, contact, side)
    # A rod that buckles laterally and slips within one step leaves a part without rows.
    later = (begins > 0) & (counts > 0)
    slip, swing = np.zeros((2, len(clamp)), dtype=bool)
    slip[begins[later & slipped]] = True
    swing[begins[later & ~slipped]] = True
    return SurfaceScan(
        outcome=outcome,
        message=message,
        clamp=clamp,
        contact=contact,
        x0=side * x0 + 0.0,  # no −0
        reactions=states(states.clip(x0)) * np.stack([side, np.ones(len(side)), side], axis=1),
        mu0=np.repeat([part.tip.mu0 for part in parts], counts),
        period=np.repeat(np.cumsum(slipped), counts),
        phase=np.select(
            [slip, swing, x0 > states.x0_lock],
            [TipPhase.SLIP, TipPhase.SWING, TipPhase.LOCK],
            TipPhase.STICK,
        ),
        side=np.where(side == 1, TipSide.AHEAD, TipSide.BEHIND),
    )
