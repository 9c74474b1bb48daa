"""Friction of each period from a fit of the model, with every source of uncertainty."""

from dataclasses import replace

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.sensor.identification.fit import Fit
from vibrissa.sensor.identification.periods import Periods, PeriodStatus, periods_of
from vibrissa.sensor.identification.slips import Slipped
from vibrissa.sensor.identification.uncertainty import HALF_WIDTH, common_deviation, summary_of


def read_periods(fit: Fit, slipped: Slipped) -> Periods:
    """Read the friction of the periods."""
    forward, opened = fit.forward, slipped.spans.opened
    states, x0 = forward.onset(fit.p, fit.u, fit.heights)
    slope = states.demand_slope(np.clip(x0, states.x0_pull, states.x0_lock))[:, 1]
    slope *= forward.ends.sign
    own = _own(fit, slipped.position)
    by_noise = np.abs(slope) * own
    effects = fit.friction + slope[:, None] * fit.moves
    by_height, left = _by_height(fit, effects[:, forward.number["eta"]])
    effects = effects[:, fit.free]
    common = common_deviation(effects, fit.covariance)
    along = forward.friction(fit.p, fit.u, fit.heights)
    # The tip cannot have slipped past the lock, or loaded against the motion.
    first, last = np.sort(x0, axis=1)[:, [0, -1]].T
    possible = last + HALF_WIDTH * own > states.x0_pull[:, 1]
    possible &= first - HALF_WIDTH * own < states.x0_lock[:, 1]
    possible &= along.max(axis=1) >= -HALF_WIDTH * by_noise
    along = np.where(possible[:, None], along + by_height[:, None], np.nan)
    found = summary_of(along, np.hypot(np.hypot(by_noise, left), common))
    least, past = _least(fit, own)
    least += by_height - HALF_WIDTH * common
    # Pulled back from past the lock a tip slips after all, but not pushed on.
    locked = slipped.swung | (past & (opened | (forward.ends.sign > 0.0)))
    # A tip that has stuck with more friction than that at which it slipped did not slip.
    more = ~locked & ~opened & (least > found.high)
    status = np.select(
        [np.isnan(least) | more, locked, opened, np.isnan(found.mean)],
        [PeriodStatus.BEYOND, PeriodStatus.LOCK, PeriodStatus.OPEN, PeriodStatus.BEYOND],
        PeriodStatus.SLIP,
    )
    periods = periods_of(slipped, status, found, least, common, effects)
    return replace(periods, contact=forward.contact(fit.p, fit.u, fit.heights))


def _own(fit: Fit, position: float) -> FloatArray:
    """Return the standard deviation of the last x0 of each period for a known set-up, (p,)."""
    # Behind a filter the beginning of a slip is hidden in noise, for up to its delay.
    late = fit.forward.delay * fit.forward.ends.speed / np.sqrt(12.0)
    return np.sqrt(1.0 / fit.known + position**2 / 2.0 + late**2)


def _by_height(fit: Fit, effect: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Change of μ0 by the height of each tip on the surface, and its standard deviation."""
    if not (fit.slope.deviation and fit.settled):
        return np.zeros(len(fit.u)), np.zeros(len(fit.u))
    height, variance = fit.heights_of_tips
    allowed = fit.slope.rise(np.ptp(fit.forward.ends.clamp))
    part = allowed / (allowed + variance)
    return effect * part * height, np.abs(effect) * np.sqrt(part * variance)


def _least(fit: Fit, own: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Least friction with which the tip can have stuck, and whether it stuck past the lock.

    NaN where a state is none of the rod.
    """
    blocks = fit.forward.blocks
    states, x0 = fit.forward.states(fit.p, fit.u, fit.heights)
    wide = HALF_WIDTH * own[blocks.period]
    none = (x0 - wide > states.x0_end) | (x0 + wide < states.x0_pull)
    # Pushed states need at least what those a little before them do.
    x0 = np.where(x0 > 0.0, np.maximum(x0 - wide, 0.0), np.minimum(x0 + wide, 0.0))
    needed = np.where(none, np.nan, np.abs(states.demand(states.clip(x0))))
    past = np.logical_or.reduceat(x0 >= states.x0_lock, blocks.starts)
    return np.maximum.reduceat(needed, blocks.starts), past
