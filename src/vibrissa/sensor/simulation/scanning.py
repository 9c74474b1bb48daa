"""A scan: the clamp moves in steps over a surface, and the tip sticks and slips behind it.

While the tip sticks, the state is the point of the rod's response at x0 = X − x_c + x1_init, with
the clamp at X and the contact point at x_c; μ0 is the friction at x_c. At the first step at which
|tan α| > μ0 the tip slips while the clamp rests. The slip law determines where the slip ends.

A self-locking tip sticks until a round rod swings aside. Then the tip is behind the clamp, and the
states are mirror images: that at x0 has the reactions of the response at −x0, fx and m with the
opposite sign.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from enum import StrEnum
from itertools import pairwise

import numpy as np

from vibrissa.decimals import exact
from vibrissa.errors import ArgumentError
from vibrissa.mechanics.mounting import IDEAL
from vibrissa.numerics.arrays import FloatArray, IntArray, StrArray
from vibrissa.numerics.batch import Batch
from vibrissa.numerics.steps import passes, step_position
from vibrissa.outcomes import End
from vibrissa.sensor.quantities import chosen
from vibrissa.sensor.response.branch import Response
from vibrissa.sensor.simulation.slips import SlipLaw, Slips
from vibrissa.sensor.surfaces import Surface

# More steps than these fill the memory.
MOST_STEPS = 10**8
# Steps that are searched together for the end of a period.
BLOCK = 4096


class TipPhase(StrEnum):
    """What the tip does at a step.

    Attributes
    ----------
    STICK
        It has stuck since the step before.
    LOCK
        It sticks past the lock: it does not slip while it is pushed on.
    SLIP
        It has just slipped, and rests.
    SWING
        It sticks, and the rod has just swung aside, round to the other side of the clamp.
    """

    STICK = "stick"
    LOCK = "lock"
    SLIP = "slip"
    SWING = "swing"


class TipSide(StrEnum):
    """Where the tip is, seen from the clamp along the surface.

    Attributes
    ----------
    AHEAD
        On the side on which it began: a clamp that moves forward pushes it.
    BEHIND
        On the other: a clamp that moves forward drags it.
    """

    AHEAD = "ahead"
    BEHIND = "behind"


class Outcome(StrEnum):
    """How a scan ended.

    Attributes
    ----------
    COMPLETE
        At the end of the path.
    LOCK
        The tip locked and was pushed on until it could not stick any more: the rod snaps through,
        slips back, or its shape is not admissible. A rod that swings aside goes on.
    LOST
        A slip left the states that are known here: it passed α = 0, and a pushed tip lifted off
        the surface, or a pulled tip reached the end of pushing.
    AWAY, NEAR
        An oblique stage took the clamp so far from the surface, or so near, that the rod has no
        response there.
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
        Where the rod swung aside first, and where and why the scan ended before its path, if so.
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
    phase : ndarray of str, shape (n,)
        One `TipPhase` for each step.
    side : ndarray of str, shape (n,)
        One `TipSide` for each step.
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
    """Positions of a stage that moves from 0 to each of the turns in equal steps.

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
    counts = [0, *(int(exact(turn) / size) for turn in turns)]
    total = sum(abs(end - begin) for begin, end in pairwise(counts))
    if total > MOST_STEPS:
        raise ArgumentError(f"a step of {length} is too small: the path has {total:.3g} steps")
    parts = [np.zeros(1, dtype=np.int64)]
    for begin, end in pairwise(counts):
        if begin == end:
            raise ArgumentError(f"each part of the path must be at least one step of {length} long")
        sign = int(np.sign(end - begin))
        parts.append(np.arange(begin + sign, end + sign, sign))
    return step_position(np.concatenate(parts), size)


@dataclass(frozen=True, kw_only=True)
class _Start:
    """How a part of a scan begins: at the step `begin`, on one side of the clamp, at `rest`.

    On the side −1, behind the clamp, displacements are those of the mirror image. Without a slip
    the tip goes on sticking, with the friction `mu0`.
    """

    begin: int = 0
    side: int = 1
    rest: float = 0.0
    slipped: bool = True
    mu0: float = np.nan


@dataclass(frozen=True, kw_only=True)
class _Part:
    """Sticking on one side of the clamp, from the step `start.begin` to before the step `end`.

    The step `end` would bring x0 to `beyond`, out of its limits, if `below` then below the lower
    one: the tip was pulled. At the end of the path `beyond` is NaN.
    """

    start: _Start
    end: int
    contact: float
    mu0: float
    beyond: float
    below: bool
    locks: bool


def simulate(
    response: Response,
    surface: Surface,
    positions: FloatArray,
    law: SlipLaw | str = SlipLaw.FREE,
    kinetic_ratio: float = 0.8,
    progress: Callable[[int], None] = lambda done: None,
) -> SurfaceScan:
    """Move the clamp over a surface.

    Parameters
    ----------
    response : Response
    surface : Surface
    positions : ndarray
        Clamp positions (L), as from `path`; the scan begins in the α = 0 state.
    law : SlipLaw or str
    kinetic_ratio : float
        Both as in `vibrissa.sensor.scan`.
    progress : callable
        Told after each period how many steps are done.

    Returns
    -------
    SurfaceScan

    Raises
    ------
    ArgumentError
        If an argument is out of range, the path goes backward beyond what the response covers, or
        the tip comes to where the surface is not known.
    """
    positions = np.asarray(positions, dtype=float)
    if response.x0_pull == 0.0 and (np.diff(positions) < 0.0).any():
        raise ArgumentError(
            "this path goes backward, but the response was solved for forward motion only"
        )
    slips = Slips(
        response=response, surface=surface, law=chosen(SlipLaw, law, "law"), ratio=kinetic_ratio
    )
    parts: list[_Part] = []
    start, outcome, end = _Start(), Outcome.COMPLETE, ""
    while True:
        part = _part(response, surface, positions, start)
        parts.append(part)
        progress(part.end)
        if part.end == len(positions):
            break
        clamp = float(positions[part.end])
        if part.locks and not part.below:
            if not response.swings:
                outcome = Outcome.LOCK
                end = _locked(response, part, float(positions[part.end - 1]), surface.told)
                break
            start = _swung(response, part)
            continue
        rest = slips.rest(clamp, part.beyond, part.start.side)
        if np.isnan(rest):
            outcome, end = Outcome.LOST, _lost(part, clamp, surface.told)
            break
        start = _Start(begin=part.end, side=part.start.side, rest=rest)
    said = (_swings(response, parts, positions, surface.told), end)
    return _assembled(response, positions, parts, outcome, "; ".join(filter(None, said)))


def _swung(response: Response, part: _Part) -> _Start:
    """Go on with the same contact on the other side of the clamp."""
    return _Start(
        begin=part.end,
        side=-part.start.side,
        rest=2.0 * response.x0_end - part.beyond,
        slipped=False,
        mu0=part.mu0,
    )


def _swings(
    response: Response,
    parts: Sequence[_Part],
    positions: FloatArray,
    told: Callable[[float], str],
) -> str:
    """Say where the rod swings aside first; empty if it does not."""
    for part, after in pairwise(parts):
        if not after.start.slipped:
            return (
                f"the tip locks at x = {told(part.contact)}, where mu0 = {part.mu0:.6g} is above "
                f"mu_lock = {response.curve.mu_lock:.6g}; with the clamp at "
                f"{told(float(positions[part.end]))} the rod swings aside, and its tip is dragged "
                "behind"
            )
    return ""


def _locked(response: Response, part: _Part, clamp: float, told: Callable[[float], str]) -> str:
    if response.curve.end is not End.SWINGS_ASIDE:
        then = "pushed on, it cannot stick further"
    elif response.curve.mounting == IDEAL:
        then = "the rod swings aside there; what follows is not known, nor where its tip is pulled"
    else:
        then = "the rod swings aside there; what follows is computed in the ideal mounting alone"
    return (
        f"the tip locks at x = {told(part.contact)}, where mu0 = {part.mu0:.6g} is above "
        f"mu_lock = {response.curve.mu_lock:.6g}; it sticks up to the clamp at {told(clamp)}: "
        f"{then}"
    )


def _lost(part: _Part, clamp: float, told: Callable[[float], str]) -> str:
    where = "the rod is pushed through" if part.below else "the tip lifts off the surface"
    return (
        f"the slip from x = {told(part.contact)}, with the clamp at {told(clamp)}, "
        f"has so much energy that {where}"
    )


def _assembled(
    response: Response,
    positions: FloatArray,
    parts: Sequence[_Part],
    outcome: Outcome,
    message: str,
) -> SurfaceScan:
    """Put the parts together, one row for each step."""
    starts = [part.start for part in parts]
    begins = np.array([start.begin for start in starts])
    slipped = np.array([start.slipped for start in starts])
    counts = np.array([part.end for part in parts]) - begins
    clamp = positions[: counts.sum()]

    def spread(values: Sequence[float]) -> FloatArray:
        return np.repeat(np.array(values, dtype=float), counts)

    side = spread([start.side for start in starts])
    moved = clamp - np.repeat(positions[begins], counts)
    x0 = side * moved + spread([start.rest for start in starts])
    # A rod that swings aside and slips within one step leaves a part without rows.
    later = (begins > 0) & (counts > 0)
    slip, swing = np.zeros((2, len(clamp)), dtype=bool)
    slip[begins[later & slipped]] = True
    swing[begins[later & ~slipped]] = True
    return SurfaceScan(
        outcome=outcome,
        message=message,
        clamp=clamp,
        contact=spread([part.contact for part in parts]),
        x0=side * x0 + 0.0,  # no −0
        reactions=response(x0) * np.stack([side, np.ones(len(side)), side], axis=1),
        mu0=spread([part.mu0 for part in parts]),
        period=np.repeat(np.cumsum(slipped), counts),
        phase=np.select(
            [slip, swing, x0 > response.x0_lock],
            [TipPhase.SLIP, TipPhase.SWING, TipPhase.LOCK],
            TipPhase.STICK,
        ),
        side=np.where(side == 1.0, TipSide.AHEAD, TipSide.BEHIND),
    )


def _part(response: Response, surface: Surface, positions: FloatArray, start: _Start) -> _Part:
    """Follow the tip until it leaves what it can stick to on this side."""
    begin, side = start.begin, start.side
    contact = float(response.contact(positions[begin], start.rest, side))
    mu0 = float(surface(contact)) if start.slipped else start.mu0
    low = response.pull_limit(mu0)
    high, locks = response.push_limit(mu0)
    end, beyond = len(positions), np.nan
    # A tip that has just slipped rests; one whose rod has swung aside may have to slip at once.
    for first in range(begin + int(start.slipped), len(positions), BLOCK):
        x0 = side * (positions[first : first + BLOCK] - positions[begin]) + start.rest
        out = np.flatnonzero(passes(x0, high) | passes(-x0, -low))
        if len(out):
            end, beyond = first + int(out[0]), float(x0[out[0]])
            break
    return _Part(
        start=start,
        end=end,
        contact=contact,
        mu0=mu0,
        beyond=beyond,
        below=beyond < low,
        locks=locks,
    )
