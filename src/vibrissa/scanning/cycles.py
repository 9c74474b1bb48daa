"""Scans along a path, or until the tip has slipped a number of times.

Commands and notebooks scan by `move`, studies by `move_as_far_as_possible`; both by `Motion.scan`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from itertools import pairwise
from math import ceil
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.decimals import exact
from vibrissa.errors import ArgumentError, EndedScanError, NoResponseError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.steps import step_position
from vibrissa.outcomes import SlipLaw
from vibrissa.scanning.response import Response
from vibrissa.scanning.rods import MountedRod
from vibrissa.scanning.scan import Outcome, Scan
from vibrissa.scanning.simulation import simulate
from vibrissa.scanning.slip import Slip
from vibrissa.scanning.slip_model import FREE_SLIP, SlipModel
from vibrissa.scanning.stage import MOST_STEPS, Stage, path, stage_of
from vibrissa.scanning.surfaces import Surface, constant
from vibrissa.scanning.textures import Texture
from vibrissa.sticking.api import check_friction_and_step
from vibrissa.sticking.curve import StickingCurve

# Steps of a path, over those that are expected to suffice.
SPARE_STEPS = 1.25


class StageMaker(Protocol):
    """Makes the stage of a rod for positions of the clamp (L) and heights of a surface."""

    def __call__(self, positions: FloatArray, texture: Texture | None) -> Stage:
        """Return the stage."""
        ...


def stick_slip(
    curve: StickingCurve,
    mu0: Decimal | float,
    dx0: Decimal | float,
    cycles: int,
    law: SlipLaw | str = SlipLaw.FREE,
    kinetic_ratio: float = 0.8,
    damping: float | None = None,
) -> Scan:
    """Move the clamp in steps of Δx0 (L) until the tip has slipped a number of times.

    Parameters
    ----------
    curve : StickingCurve
        Sticking curve of the rod at its first distance.
    mu0, dx0 : Decimal or float
        Coefficient of static friction, and step of the clamp (L).
    cycles : int
        Number of stick-slip cycles.
    law : SlipLaw or str
        Where a slip ends.
    kinetic_ratio : float
        μk/μ0, for all laws but ``free``.
    damping : float, optional
        Damping ratio ζ of the rod, from 0, which the law ``damped`` needs.

    Returns
    -------
    Scan
        One row for each step of the clamp: the α = 0 state, then for each cycle its sticking states
        and the state after its slip. Without rows if the curve has no states.

    Raises
    ------
    ArgumentError
        If an argument is out of range.

    Examples
    --------
    >>> from vibrissa import solve_curve
    >>> scan = stick_slip(solve_curve(theta=2, eta=0.85), mu0=0.3, dx0=0.01, cycles=2)
    >>> print(scan.clamp)
    [0.   0.01 0.02 0.03 0.04 0.05 0.06]
    >>> print(scan.contact.round(4))
    [0.4173 0.4173 0.4173 0.4473 0.4473 0.4473 0.4773]
    """
    if not isinstance(cycles, int | np.integer) or cycles < 1:
        raise ArgumentError(f"cycles must be a whole number, at least 1, got {cycles!r}")
    check_friction_and_step(mu0, dx0)
    if not curve.pieces:
        return Scan.without_rows(Outcome(curve.status), curve.message)
    return move(
        stage_maker(curve),
        constant(float(mu0)),
        exact(dx0),
        cycles=cycles,
        model=SlipModel.of(law, kinetic_ratio, damping),
    )


def stage_maker(curve: StickingCurve) -> StageMaker:
    """Return a function that makes the stage of a rod.

    Parameters
    ----------
    curve : StickingCurve
        A curve with states; on an oblique stage, that of the rod's first distance.
    """
    rod = MountedRod.of(curve)
    level = Stage(response=Response(curve=curve), eta=curve.eta)

    def make_stage(positions: FloatArray, texture: Texture | None) -> Stage:
        if texture is None and not rod.mounting.stage_angle:
            return level
        return stage_of(rod, positions, texture=texture)

    return make_stage


def move(
    make_stage: StageMaker,
    surface: Surface,
    step: Decimal | float | str,
    *,
    to: Sequence[Decimal | float | str] | None = None,
    cycles: int | None = None,
    model: SlipModel = FREE_SLIP,
    tip_radius: float = 0.0,
) -> Scan:
    """Move the clamp in equal steps, through turning points or until the tip has slipped.

    Parameters
    ----------
    make_stage : callable
        Makes the stage for given clamp positions (L) and heights, as `stage_maker` returns it.
    surface : Surface
    step : Decimal or float or str
        Step of the clamp (L).
    to : sequence, optional
        Turning points of the clamp (L), as in `vibrissa.scanning.path`.
    cycles : int, optional
        Number of slips after which the scan ends; either `to` or `cycles` is needed.
    model : SlipModel
        Where a slip ends.
    tip_radius : float
        Radius of a ball at the tip, which traces the heights of the surface (L).

    Raises
    ------
    ArgumentError
        If an argument is out of range, or the tip leaves the known part of the surface.
    NoResponseError
        If the turning points take the rod to distances at which its states are not known.
    """
    motion = Motion(make_stage=make_stage, surface=surface, model=model, tip_radius=tip_radius)
    _check_end(to, cycles)
    if cycles is not None:
        return until_slips(motion, exact(step), cycles)
    return motion.scan(path(step, to or ()))


def move_as_far_as_possible(
    motion: "Motion",
    step: Decimal | float | str,
    *,
    to: Sequence[Decimal | float | str] | None = None,
    cycles: int | None = None,
) -> Scan:
    """Move the clamp as `move` does, but return a scan that cannot go on, up to there.

    It ends where the rod comes to a distance without states, or the tip to an unknown part of the
    surface.

    Raises
    ------
    ArgumentError
        If an argument is out of range.
    NoResponseError
        If the first step takes the rod to a distance at which its states are not known.
    """
    _check_end(to, cycles)
    try:
        if cycles is not None:
            return until_slips(motion, exact(step), cycles)
        return longest_scan(lambda turns: motion.scan(path(step, turns)), step, to or ())
    except EndedScanError as error:
        found: Scan = error.scan
        return found


def _check_end(to: Sequence[Decimal | float | str] | None, cycles: int | None) -> None:
    if (to is None) == (cycles is None):
        raise ArgumentError("a scan needs either 'to' or 'cycles'")


@dataclass(frozen=True, eq=False, kw_only=True)
class Motion:
    """All inputs of a scan but the positions of its clamp; see `move`."""

    make_stage: StageMaker
    surface: Surface
    model: SlipModel = FREE_SLIP
    tip_radius: float = 0.0

    def scan(self, positions: FloatArray, slips: int | None = None) -> Scan:
        """Simulate a scan through positions of the clamp (L), or its first slips."""
        traced = self.surface.traced(self.tip_radius, positions)
        stage = self.make_stage(positions, traced.texture)
        return simulate(stage, traced, positions, self.model, slips)


def until_slips(motion: Motion, dx0: Decimal, slips: int) -> Scan:
    """Move the clamp forward in steps of Δx0 (L) until the tip has slipped a number of times.

    How many steps that takes is not known before: the scan is simulated again over a longer path
    until it suffices. If the stage then takes the rod to distances at which its states are not
    known, the longest path without such distances is found by bisection.
    """
    scan, reason = Scan.without_rows(Outcome.OUT_OF_REACH, ""), ""
    # Steps of the longest path with known states so far, and of the shortest one without.
    known, unknown = 0, None
    while unknown is None or unknown > known + 1:
        steps = _more_steps(scan, known, slips) if unknown is None else (known + unknown) // 2
        try:
            scan = motion.scan(step_position(np.arange(steps + 1), dx0), slips)
        except NoResponseError as error:
            unknown, reason = steps, str(error)
            continue
        ended_early = len(scan) <= steps
        if ended_early or scan.slips == slips:
            return scan
        known = steps
        if known > MOST_STEPS:
            raise ArgumentError(f"dx0 is too small: a scan has {MOST_STEPS:,} steps at most")
    return replace(scan, outcome=Outcome.OUT_OF_REACH, message=reason)


def _more_steps(scan: Scan, steps: int, slips: int) -> int:
    """Estimate the steps that suffice for a number of slips, from a scan of fewer `steps`."""
    least = max(2 * steps, slips)
    # On an oblique stage a longer path takes the rod to more distances, which must be solved.
    if scan.stage is None or scan.stage.angle or not scan.slips:
        return least
    return max(least, ceil(SPARE_STEPS * steps * slips / scan.slips))


def longest_scan(
    scan: Callable[[Sequence[Decimal]], Scan],
    step: Decimal | float | str,
    to: Sequence[Decimal | float | str],
) -> Scan:
    """Scan a path, or as many of its first steps as take the rod to distances with known states.

    Parameters
    ----------
    scan : callable
        Scans through turning points (L).
    step : Decimal or float or str
        Step of the path (L).
    to : sequence
        Its turning points (L).

    Raises
    ------
    NoResponseError
        If the rod has no states after one step already.
    """
    size, turns = exact(step), [exact(turn) for turn in to]
    try:
        return scan(turns)
    except NoResponseError as error:
        reason = error
    ways = [abs(end - begin) for begin, end in pairwise([exact(0), *turns])]
    known, unknown = 0, sum(int(way / size) for way in ways)
    found: Scan | None = None
    while unknown - known > 1:
        steps = (known + unknown) // 2
        try:
            found, known = scan(_first_turns(turns, steps * size)), steps
        except NoResponseError:
            unknown = steps
    if found is None:
        raise reason
    if found.outcome is not Outcome.COMPLETE:
        return found
    return replace(found, outcome=Outcome.OUT_OF_REACH, message=str(reason))


def _first_turns(turns: Sequence[Decimal], length: Decimal) -> list[Decimal]:
    """Return the turning points of the first part of a path, of a given length (L)."""
    found, at = list[Decimal](), exact(0)
    for turn in turns:
        part = abs(turn - at)
        if length <= part:
            return [*found, at + (length if turn > at else -length)]
        found.append(turn)
        at, length = turn, length - part
    return found


def steady_travel(response: Response, mu0: ArrayLike, model: SlipModel) -> FloatArray:
    """Travel of the clamp in a period of sticking on a plane, in the limit of small steps (L).

    It is the travel in each period after the first: from where a slip ends that begins at the exact
    onset, to the next onset. Its inverse is the number of slips in a length.

    Parameters
    ----------
    response : Response
        States of the rod, at one distance.
    mu0 : array_like
        Coefficients of static friction.
    model : SlipModel
        Where a slip ends.

    Returns
    -------
    ndarray, shape of mu0
        NaN where the tip is lost in its slip, so that there is no next onset.

    Raises
    ------
    ArgumentError
        If the tip is self-locking, so that it does not slip.

    Examples
    --------
    >>> from vibrissa.scanning.response import responses
    >>> (response,) = responses([MountedRod(theta=2.0, eta=0.85)])
    >>> for law in ("free", "kinetic", "energy"):
    ...     print(law, f"{steady_travel(response, 0.3, SlipModel.of(law, 0.7)):.6f}")
    free 0.026336
    kinetic 0.012092
    energy 0.023405
    >>> print(f"{steady_travel(response, 0.3, SlipModel.of('damped', 0.7, damping=0.1)):.6f}")
    0.020431
    """
    friction = np.asarray(mu0, dtype=float)
    onset = response.curve.onset(friction)
    if (locks := np.isnan(onset)).any():
        first = float(friction[locks][0])
        raise ArgumentError(f"the tip does not slip at mu0 = {first!r}: it is self-locking")
    stage = Stage(response=response, eta=response.curve.eta)
    travel = np.full(friction.shape, np.nan)
    for place, begin in np.ndenumerate(onset):
        slip = Slip(stage=stage, surface=constant(float(friction[place])), model=model)
        end = slip.follow(response.contact(0.0, float(begin), 1))
        if end.lost is None:
            travel[place] = begin - end.x0
    return travel
