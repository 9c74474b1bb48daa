"""A scan: the clamp moves in steps over a surface, the tip sticks and slips after it.

While the tip sticks, the state is the point of the rod's response at x0 = X − x_c + x1_init, with
the clamp at X and the contact point at x_c; μ0 is the friction at x_c. At the first step at which
|tan α| > μ0 the tip slips, with the clamp at rest, to where the slip law says.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from enum import StrEnum
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from vibrissa.arrays import FloatArray, IntArray
from vibrissa.decimals import exact
from vibrissa.sensor.friction import Friction
from vibrissa.sensor.response import Response
from vibrissa.steps import step_position

# Displacements that differ by less are the same: a step that ends on the onset sticks.
ROUNDING = 1e-12
# To what a root is located (L).
ROOT = 1e-14
# Relative rounding of a demand that uses friction up.
FULL = 1e-9
# Steps looked at together for the end of a period.
BLOCK = 4096
# Where a slide is looked at before the first knot of the response, as parts of the way there.
FIRST_STEPS = np.geomspace(1e-6, 0.5, 20)
# A slip that comes to rest where it cannot stick goes on the other way, each time shorter.
REVERSALS = 100


class SlipLaw(StrEnum):
    """Where a slip ends.

    Attributes
    ----------
    FREE
        At α = 0, where no friction is needed (the paper's assumption).
    KINETIC
        Where |tan α| has fallen to the kinetic friction μk: the tip creeps, without inertia.
    ENERGY
        Where kinetic friction has consumed the bending energy that was released: the tip shoots
        past the state of the kinetic law and stops when its velocity is zero.
    """

    FREE = "free"
    KINETIC = "kinetic"
    ENERGY = "energy"


class Phase(StrEnum):
    """What the tip does at a step.

    Attributes
    ----------
    STICK
        It has stuck since the step before.
    LOCK
        It sticks past the lock: pushing on does not make it slip.
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
        The tip locked and was pushed to where no state of sticking follows: the rod snaps
        through, leaves the reach of the model or slips back.
    LOST
        A slip left the states known here: shooting past α = 0, a pushed tip lifted off the
        surface, or a pulled one went on to where pushing ends.
    """

    COMPLETE = "complete"
    LOCK = "lock"
    LOST = "lost"


@dataclass(frozen=True, eq=False)
class SurfaceScan:
    """Signals of a scan, one row for each step of the clamp.

    Attributes
    ----------
    outcome : Outcome
    message : str
        Empty, or where and why the scan ended before its path.
    footpoint : ndarray, shape (n,)
        Position of the clamp (L).
    contact : ndarray, shape (n,)
        Position of the tip, which is the contact point in point contact (L).
    x0 : ndarray, shape (n,)
        Displacement of the clamp from the α = 0 state of this contact point (L).
    fx, fy, m : ndarray, shape (n,)
        Clamp reactions (E·I0/L², E·I0/L).
    mu0 : ndarray, shape (n,)
        Static friction at the contact point.
    period : ndarray of int, shape (n,)
        Number of the period of sticking, from 1; it begins with the slip before it.
    phase : list of Phase
    """

    outcome: Outcome
    message: str
    footpoint: FloatArray
    contact: FloatArray
    x0: FloatArray
    fx: FloatArray
    fy: FloatArray
    m: FloatArray
    mu0: FloatArray
    period: IntArray
    phase: list[Phase]


def path(step: Decimal | float | str, turns: Sequence[Decimal | float | str]) -> FloatArray:
    """Positions of a stage that goes from 0 to each of the turns in equal steps.

    Parameters
    ----------
    step : Decimal or float or str
        Step of the stage (L).
    turns : sequence of Decimal or float or str
        Where it turns, the last one where it stops (L); taken to the step before.

    Returns
    -------
    ndarray
        Positions (L), the start included.

    Raises
    ------
    ValueError
        If the step is not positive or a leg is shorter than a step.
    """
    size = exact(step)
    if not size > 0:
        raise ValueError(f"step must be positive, got {step}")
    counts = [0, *(int(exact(turn) / size) for turn in turns)]
    legs = [np.zeros(1, dtype=np.int64)]
    for begin, end in pairwise(counts):
        if begin == end:
            raise ValueError(f"each leg of the path must be longer than a step of {step}")
        sign = 1 if end > begin else -1
        legs.append(np.arange(begin + sign, end + sign, sign))
    return step_position(np.concatenate(legs), size)


def scan(
    response: Response,
    friction: Friction,
    positions: FloatArray,
    law: SlipLaw | str = SlipLaw.FREE,
    kinetic_ratio: float = 0.8,
    progress: Callable[[int], None] = lambda done: None,
) -> SurfaceScan:
    """Move the clamp over a surface.

    Parameters
    ----------
    response : Response
    friction : Friction
    positions : ndarray
        Clamp positions (L), as from `path`; the scan begins in the α = 0 state.
    law : SlipLaw
    kinetic_ratio : float
        μk/μ0, the same everywhere, above 0 and up to 1; not used by the law ``free``.
    progress : callable
        Told after each period how many steps are done.

    Returns
    -------
    SurfaceScan

    Raises
    ------
    ValueError
        If an argument is out of range, the path goes backward beyond what the response covers, or
        the tip comes to where the surface is not known.
    """
    law = SlipLaw(law)
    if not 0.0 < kinetic_ratio <= 1.0:
        raise ValueError(f"kinetic_ratio must lie above 0 and up to 1, got {kinetic_ratio!r}")
    positions = np.asarray(positions, dtype=float)
    x1_init, lock = response.curve.x1_init, response.curve.x0_lock
    n = len(positions)
    x0, contact, mu0 = np.empty(n), np.empty(n), np.empty(n)
    period, slipped = np.empty(n, dtype=np.int64), np.zeros(n, dtype=bool)
    outcome, message = Outcome.COMPLETE, ""

    begin, rest, number = 0, 0.0, 1
    while begin < n:
        at = positions[begin] - rest + x1_init
        here = float(friction(at))
        high, locks = response.push_limit(here)
        end, low, beyond = _leaves(positions, begin, rest, response.pull_limit(here), high)
        rows = slice(begin, end)
        x0[rows] = positions[rows] - positions[begin] + rest
        contact[rows], mu0[rows], period[rows] = at, here, number
        progress(end)
        if end == n:
            break
        if locks and not low:
            outcome, n = Outcome.LOCK, end
            message = (
                f"the tip locks at x = {at:.6g}, where mu0 = {here:.6g} is above mu_lock = "
                f"{response.curve.mu_lock:.6g}; pushed on, it cannot stick beyond the clamp at "
                f"{positions[end - 1]:.6g} (in units of L)"
            )
            break
        rest = _rest(response, friction, law, kinetic_ratio, positions[end], beyond)
        if np.isnan(rest):
            outcome, n = Outcome.LOST, end
            message = (
                f"the slip from x = {at:.6g}, with the clamp at {positions[end]:.6g} (in units of "
                "L), has so much energy that "
                + ("the rod is pushed through" if low else "the tip lifts off the surface")
            )
            break
        slipped[end] = True
        begin, number = end, number + 1

    fx, fy, m = response(x0[:n]).T
    past = x0[:n] > lock
    return SurfaceScan(
        outcome,
        message,
        positions[:n],
        contact[:n],
        x0[:n],
        fx,
        fy,
        m,
        mu0[:n],
        period[:n],
        [
            Phase.SLIP if slip else Phase.LOCK if locked else Phase.STICK
            for slip, locked in zip(slipped[:n], past, strict=True)
        ],
    )


def _leaves(
    positions: FloatArray, begin: int, rest: float, low: float, high: float
) -> tuple[int, bool, float]:
    """First step after `begin` that leaves [low, high], whether below, and the x0 it came to."""
    if not np.isfinite(low) and np.any(np.diff(positions) < 0.0):
        raise ValueError("this path goes backward, which needs a response with pulling")
    for first in range(begin + 1, len(positions), BLOCK):
        x0 = positions[first : first + BLOCK] - positions[begin] + rest
        out = np.flatnonzero((x0 > high + ROUNDING) | (x0 < low - ROUNDING))
        if len(out):
            beyond = float(x0[out[0]])
            return first + int(out[0]), beyond < low, beyond
    return len(positions), False, np.nan


def _rest(
    response: Response,
    friction: Friction,
    law: SlipLaw,
    ratio: float,
    clamp: float,
    x0: float,
) -> float:
    """Displacement at which a tip that slips from x0 comes to rest; NaN if it does not."""
    if law is SlipLaw.FREE:
        return 0.0
    x0 = float(np.clip(x0, response.x0_pull, response.x0_end))
    for _ in range(REVERSALS):
        x0 = _slide(response, friction, law, ratio, clamp, x0)
        if np.isnan(x0):
            return x0
        holds = float(friction(clamp + response.curve.x1_init - x0))
        if abs(float(response.demand(x0))) <= holds * (1.0 + FULL):
            return x0
    raise ValueError(f"the slip with the clamp at {clamp:.6g} does not come to rest")


def _slide(
    response: Response,
    friction: Friction,
    law: SlipLaw,
    ratio: float,
    clamp: float,
    x0: float,
) -> float:
    """Where one slide in one direction ends, from knot to knot and in between; NaN if nowhere."""
    knots = response.reactions.x
    # A pushed tip slides to lower x0, a pulled one to higher.
    pushed = x0 > 0.0
    ahead = knots[knots < x0][::-1] if pushed else knots[knots > x0]
    if law is SlipLaw.KINETIC:
        ahead = np.append(ahead[ahead * x0 > 0.0], 0.0)
    # Closer together at the beginning, where the energy released is small.
    nearest = ahead[0] - x0 if len(ahead) else 0.0
    x = np.concatenate([[x0], x0 + nearest * FIRST_STEPS, ahead])
    surface = clamp + response.curve.x1_init

    def excess(x: FloatArray) -> FloatArray:
        """Say what is left to move the tip along a slide: force (kinetic law) or energy."""
        if law is SlipLaw.KINETIC:
            fx, fy, _ = np.moveaxis(response(x), -1, 0)
            return np.asarray(np.abs(fx) - np.abs(fy) * ratio * friction(surface - x))
        # Friction is taken at the middle between points, the normal force is integrated.
        middle = ratio * friction(surface - 0.5 * (x[1:] + x[:-1]))
        lost = middle * np.abs(np.diff(response.normal_path(x)))
        left = response.energy(x[0]) - response.energy(x)
        left[1:] -= np.cumsum(lost)
        return np.asarray(left)

    left = excess(x)
    stops = np.flatnonzero(left[1:] <= 0.0)
    if not len(stops):
        return np.nan
    after = int(stops[0]) + 1
    if left[after - 1] <= 0.0:
        return float(x[after])

    def at(stop: float) -> float:
        return float(excess(np.append(x[:after], stop))[-1])

    stop = float(brentq(at, x[after - 1], x[after], xtol=ROOT))
    # On the side where it stops: at the edge of a patch that is the rougher one.
    return stop + np.sign(x[after] - x0) * 2.0 * ROOT if at(stop) > 0.0 else stop
