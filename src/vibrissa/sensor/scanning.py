"""A scan: the clamp moves in steps over a surface, and the tip sticks and slips behind it.

While the tip sticks, the state is the point of the rod's response at x0 = X − x_c + x1_init, with
the clamp at X and the contact point at x_c; μ0 is the friction at x_c. At the first step at which
|tan α| > μ0 the tip slips while the clamp rests. The slip law determines where the slip ends.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from enum import StrEnum
from itertools import pairwise

import numpy as np

from vibrissa.decimals import exact
from vibrissa.errors import ArgumentError
from vibrissa.numerics.arrays import FloatArray, IntArray, StrArray
from vibrissa.numerics.batch import Batch
from vibrissa.numerics.steps import passes, step_position
from vibrissa.sensor.quantities import chosen
from vibrissa.sensor.response import Response
from vibrissa.sensor.slips import SlipLaw, Slips
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
    """

    STICK = "stick"
    LOCK = "lock"
    SLIP = "slip"


class Outcome(StrEnum):
    """How a scan ended.

    Attributes
    ----------
    COMPLETE
        At the end of the path.
    LOCK
        The tip locked and was pushed on until it could not stick any more: the rod snaps through,
        slips back, or its shape is not admissible.
    LOST
        A slip left the states that are known here: it passed α = 0, and a pushed tip lifted off
        the surface, or a pulled tip reached the end of pushing.
    """

    COMPLETE = "complete"
    LOCK = "lock"
    LOST = "lost"


@dataclass(frozen=True, eq=False, kw_only=True)
class SurfaceScan(Batch):
    """States of a scan, one row for each step of the clamp.

    Attributes
    ----------
    outcome : Outcome
    message : str
        Empty, or where and why the scan ended before its path.
    clamp : ndarray, shape (n,)
        Position of the clamp (L).
    contact : ndarray, shape (n,)
        Position of the tip, which is the contact point in point contact (L).
    x0 : ndarray, shape (n,)
        Displacement of the clamp from the α = 0 state of this contact point (L).
    reactions : ndarray, shape (n, 3)
        Clamp reactions fx, fy (E·I0/L²) and m (E·I0/L).
    mu0 : ndarray, shape (n,)
        Static friction at the contact point.
    period : ndarray of int, shape (n,)
        Number of the period of sticking, from 1. A period begins at the step of the slip before it.
    phase : ndarray of str, shape (n,)
        One `TipPhase` for each step.
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


def path(step: Decimal | float | str, turns: Sequence[Decimal | float | str]) -> FloatArray:
    """Positions of a stage that moves from 0 to each of the turns in equal steps.

    Parameters
    ----------
    step : Decimal or float or str
        Step of the stage (L).
    turns : sequence of Decimal or float or str
        Where it turns, and at last stops (L); rounded to the step before.

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
    counts = [0, *(int(exact(turn) / size) for turn in turns)]
    total = sum(abs(end - begin) for begin, end in pairwise(counts))
    if total > MOST_STEPS:
        raise ArgumentError(f"step {step} is too small: the path has {total:.3g} steps")
    parts = [np.zeros(1, dtype=np.int64)]
    for begin, end in pairwise(counts):
        if begin == end:
            raise ArgumentError(f"each part of the path must be at least one step of {step} long")
        sign = 1 if end > begin else -1
        parts.append(np.arange(begin + sign, end + sign, sign))
    return step_position(np.concatenate(parts), size)


@dataclass(frozen=True, kw_only=True)
class _Period:
    """A period of sticking, from the step `begin` of the clamp to before the step `end`.

    The step `end` would bring x0 to `beyond`, out of its limits, if `below` then below the lower
    one: the tip was pulled. At the end of the path `beyond` is NaN. `rest` is x0 at the first step.
    """

    begin: int
    end: int
    contact: float
    mu0: float
    rest: float
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
    law, kinetic_ratio
        As in `vibrissa.sensor.scan`.
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
    periods, outcome, message = [], Outcome.COMPLETE, ""
    begin, rest = 0, 0.0
    while True:
        period = _period(response, surface, positions, begin, rest)
        periods.append(period)
        progress(period.end)
        if period.end == len(positions):
            break
        if period.locks and not period.below:
            outcome = Outcome.LOCK
            message = _locked(response, period, float(positions[period.end - 1]))
            break
        begin, rest = period.end, slips.rest(float(positions[period.end]), period.beyond)
        if np.isnan(rest):
            outcome, message = Outcome.LOST, _lost(period, float(positions[period.end]))
            break
    return _assembled(response, positions, periods, outcome, message)


def _locked(response: Response, period: _Period, clamp: float) -> str:
    return (
        f"the tip locks at x = {period.contact:.6g}, where mu0 = {period.mu0:.6g} is above "
        f"mu_lock = {response.curve.mu_lock:.6g}; pushed on, it cannot stick beyond the clamp at "
        f"{clamp:.6g} (in units of L)"
    )


def _lost(period: _Period, clamp: float) -> str:
    where = "the rod is pushed through" if period.below else "the tip lifts off the surface"
    return (
        f"the slip from x = {period.contact:.6g}, with the clamp at {clamp:.6g} (in units of L), "
        f"has so much energy that {where}"
    )


def _assembled(
    response: Response,
    positions: FloatArray,
    periods: Sequence[_Period],
    outcome: Outcome,
    message: str,
) -> SurfaceScan:
    """Put the periods together, one row for each step."""
    begins = np.array([period.begin for period in periods])
    counts = np.array([period.end for period in periods]) - begins
    clamp = positions[: counts.sum()]

    def spread(values: Sequence[float]) -> FloatArray:
        return np.repeat(np.array(values, dtype=float), counts)

    x0 = clamp - np.repeat(positions[begins], counts) + spread([p.rest for p in periods])
    slipped = np.zeros(len(clamp), dtype=bool)
    slipped[begins[1:]] = True
    return SurfaceScan(
        outcome=outcome,
        message=message,
        clamp=clamp,
        contact=spread([period.contact for period in periods]),
        x0=x0,
        reactions=response(x0),
        mu0=spread([period.mu0 for period in periods]),
        period=np.repeat(np.arange(1, len(periods) + 1), counts),
        phase=np.select(
            [slipped, x0 > response.x0_lock], [TipPhase.SLIP, TipPhase.LOCK], TipPhase.STICK
        ),
    )


def _period(
    response: Response, surface: Surface, positions: FloatArray, begin: int, rest: float
) -> _Period:
    """Follow the tip from the step `begin` until it leaves what it can stick to."""
    contact = float(positions[begin] - rest + response.x1_init)
    mu0 = float(surface(contact))
    low = response.pull_limit(mu0)
    high, locks = response.push_limit(mu0)
    end, beyond = len(positions), np.nan
    for first in range(begin + 1, len(positions), BLOCK):
        x0 = positions[first : first + BLOCK] - positions[begin] + rest
        out = np.flatnonzero(passes(x0, high) | passes(-x0, -low))
        if len(out):
            end, beyond = first + int(out[0]), float(x0[out[0]])
            break
    return _Period(
        begin=begin,
        end=end,
        contact=contact,
        mu0=mu0,
        rest=rest,
        beyond=beyond,
        below=beyond < low,
        locks=locks,
    )
