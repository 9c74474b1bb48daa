"""Friction by the model of the rod: one fit of the set-up and all contacts to all channels."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vibrissa.errors import NoResponseError, WrongRodError
from vibrissa.numerics.arrays import BoolArray, FloatArray, StrArray
from vibrissa.scanning.response import States
from vibrissa.sensor.identification.factors import likely_factor
from vibrissa.sensor.identification.fit import Fit, started
from vibrissa.sensor.identification.fitted_set_up import FittedSetUp
from vibrissa.sensor.identification.goodness import (
    NAMED_CAUSES,
    Cause,
    Goodness,
    causes_of,
    estimates_of,
)
from vibrissa.sensor.identification.linearisation import Linearisation
from vibrissa.sensor.identification.mixing import MISFIT, StateTable
from vibrissa.sensor.identification.periods import Check, Grade, Periods, PeriodStatus, periods_of
from vibrissa.sensor.identification.propagation import HALF_WIDTH, common_deviation
from vibrissa.sensor.identification.result import Identification, Residuals
from vibrissa.sensor.identification.screw import pitch_error_of
from vibrissa.sensor.identification.search import fit_set_up
from vibrissa.sensor.identification.slips import check_slips
from vibrissa.sensor.identification.task import Task
from vibrissa.sensor.transducer import CHANNELS
from vibrissa.sensor.whisker import Whisker

# A sample is no state of the rod if its residual exceeds this part of its readings, and the noise.
MOST_MISFIT = 0.1
# A recording is refused if more than this part of its samples are no states of the rod, and their
# residuals exceed this many standard deviations of what the tolerances allow.
MOST_OFF = 0.2
TOLERATED_DEVIATIONS = 4.0
# Number of standard deviations by which a contact must move forward in a slip.
CERTAIN_DEVIATIONS = 6.0


def read_model(task: Task, whisker: Whisker, table: StateTable) -> Identification:
    """Estimate the friction of the periods of a recording by the model of the rod.

    Raises
    ------
    WrongRodError
        If more than 20 % of the samples fit no state of the rod.
    NoResponseError
        If the rod has no response.
    """
    check_slips(task.recording, task.spans, task.noise)
    start = started(task, whisker, table.nearest(task.blocks.readings).x0)
    _check_states(start, table)
    fitted = fit_set_up(start)
    goodness = Goodness.of(fitted)
    fitted_parameters = [task.parameters[k] for k in np.flatnonzero(task.free)]
    estimates = estimates_of(fitted_parameters, fitted.fit.p[task.free], fitted.covariance)
    doubted = not (goodness.fits and fitted.settled) or any(estimate.far for estimate in estimates)
    periods = read_periods(fitted)
    channels = tuple(CHANNELS[number] for number in task.used)
    residuals = fitted.fit.residuals
    identification = Identification(
        recording=task.recording,
        periods=periods.doubted(*_checks(fitted, periods)),
        units=task.units,
        by_model=True,
        estimates=estimates,
        covariance=fitted.covariance,
        slope=task.slope,
        goodness=goodness,
        causes=_causes(fitted, goodness.fits) if doubted else (),
        residuals=Residuals(clamp=task.blocks.clamp, values=residuals, channels=channels),
    )
    if not (goodness.fits or periods.coarse):
        identification = identification.noted(*task.noisier())
    if doubted:
        return identification.doubted(unfitted(identification, fitted.settled))
    return identification


def _causes(fitted: FittedSetUp, fits: bool) -> tuple[Cause, ...]:
    """Find likely causes of a misfit, a repeated error of the positions included."""
    repeated = None if fits else pitch_error_of(fitted)
    causes = (*causes_of(fitted, fits), *([] if repeated is None else [repeated]))
    return tuple(sorted(causes, key=lambda cause: -cause.explained)[:NAMED_CAUSES])


def unfitted(identification: Identification, settled: bool = True) -> Check:
    """Return the reason to doubt all periods: the recording does not fit the given set-up."""
    if not settled:
        why = "the recording is too far from the given set-up to be fitted"
    elif identification.fits:
        why = "a stated value is off by far more than its tolerance"
    elif identification.goodness is not None and identification.goodness.only_uneven:
        why = "the surface is uneven: mu0 is the apparent friction, with the slopes in it"
    else:
        why = "the recording does not fit the set-up"
    # The summary has this sentence, too, with candidates or the size of the misfit.
    summed = settled and (bool(identification.causes) or not identification.fits)
    return Check(Grade.DOUBTFUL, np.full(len(identification.periods), True), why, summed=summed)


def _check_states(fit: Fit, table: StateTable) -> None:
    """Refuse a recording in which more than 20 % of the samples fit no state of the rod.

    The message names a likely cause, if a single factor makes the recording fit.
    """
    blocks = fit.task.blocks
    off = _no_states(fit)
    part = float(blocks.count[off].sum() / blocks.count.sum())
    if part > MOST_OFF:
        first = fit.task.recording.line[int(blocks.row[off][0])]
        cause = likely_factor(fit.task, table) or (
            "check rod, height, columns, units, zero offsets, noise, and the --moment-origin of "
            "vibrissa import"
        )
        raise WrongRodError(
            f"{part:.0%} of the samples fit no state of this rod, first in line {first}: {cause}"
        )


def _no_states(fit: Fit) -> BoolArray:
    """Find the blocks of samples that are no states of the rod, shape (n,).

    If there are many, only those count that no rod within the tolerances explains, to first order.
    """
    blocks = fit.task.blocks
    squares = (fit.residuals**2).sum(axis=1)
    size = (fit.task.weighted(blocks.readings) ** 2).sum(axis=1) * blocks.count
    off: BoolArray = squares > np.maximum(MISFIT * blocks.count, MOST_MISFIT**2 * size)
    if blocks.count[off].sum() <= MOST_OFF * blocks.count.sum():
        return off
    try:
        line = Linearisation.of(fit)
    except NoResponseError:
        return off
    allowed = (fit.task.sigma[:, None, None] * line.readings) ** 2
    return off & (squares > TOLERATED_DEVIATIONS**2 * allowed.sum(axis=(0, 2)))


def _checks(fitted: FittedSetUp, periods: Periods) -> list[Check]:
    """Check that each period fits a sticking tip, and that slips have the clamp's direction."""
    fit = fitted.fit
    worst = fit.task.blocks.sums(fit.residuals**2).argmax(axis=1)
    contact = fit.model.contact(fit.u)
    own = np.hypot(fit.known**-0.5, fit.task.recording.position)
    way = np.diff(contact) * fit.task.ends.sign[:-1]
    stays = way < CERTAIN_DEVIATIONS * np.hypot(own[1:], own[:-1])
    against = np.append(stays & ~fit.task.spans.passes[:-1], False)
    against |= periods.status == PeriodStatus.BEYOND
    why = "does not fit a tip that sticks; if slips are slow, state --slip-time"
    return [
        *(
            Check(Grade.WRONG, ~fitted.fits_alone & (worst == number), f"{CHANNELS[channel]} {why}")
            for number, channel in enumerate(fit.task.used)
        ),
        Check(Grade.WRONG, against, "the tip cannot slip in this direction"),
    ]


def read_periods(fitted: FittedSetUp) -> Periods:
    """Estimate the friction of the periods from a fit."""
    fit = fitted.fit
    line = fitted.line
    sign = fit.task.ends.sign
    states, x0 = fit.model.onset(fit.u)
    slope = sign * states.demand_slope(np.clip(x0, states.x0_pull, states.x0_lock))[:, 1]
    # With a filter the beginning of a slip is hidden in noise, for up to the delay.
    late = fit.task.recording.lag[fit.task.spans.ends] / np.sqrt(12.0)
    # Standard deviation of x0 at each period's end, for a known set-up.
    own = np.sqrt(1.0 / fit.known + fit.task.recording.position**2 / 2.0 + late**2)
    by_noise = np.abs(slope) * own
    effects = line.friction + slope[:, None] * line.u
    heights = _by_height(fitted, effects[:, fit.task.number["eta"]])
    effects = (effects + heights.effects)[:, fit.task.free]
    common = common_deviation(effects, fitted.covariance)
    change = heights.change + effects @ fitted.unexpected
    along = fit.model.friction(fit.u)
    against_motion = along.max(axis=1) >= -HALF_WIDTH * by_noise
    possible = _slips_between(states, x0, own) & against_motion
    along = np.where(possible[:, None], along + change[:, None], np.nan)
    periods = periods_of(fit.task, along, np.hypot(by_noise, heights.left), common, effects)
    least, past = _least(fit, own)
    least = least + (change - HALF_WIDTH * common)
    status = _statuses(fit, periods, least, past)
    return replace(periods.ended(status, least), contact=fit.model.contact(fit.u))


def _slips_between(states: States, x0: FloatArray, own: FloatArray) -> BoolArray:
    """Whether tips may slip between the end of pulling and the lock, within the errors of x0.

    Parameters
    ----------
    states : States
        States in the steps in which the tips of p periods slip.
    x0 : ndarray, shape (p, 3)
        Displacements at the start, the middle and the end of these steps (L).
    own : ndarray, shape (p,)
        Standard deviations of the displacements (L).
    """
    # On a level stage all periods have the same height.
    x0_pull, x0_lock = (
        np.broadcast_to(at, x0.shape)[:, 1] for at in (states.x0_pull, states.x0_lock)
    )
    after_pull = x0.max(axis=1) + HALF_WIDTH * own > x0_pull
    return np.asarray(after_pull & (x0.min(axis=1) - HALF_WIDTH * own < x0_lock))


def _statuses(fit: Fit, periods: Periods, least: FloatArray, past: BoolArray) -> StrArray:
    """Status of each period.

    Parameters
    ----------
    least : ndarray, shape (p,)
        Lower bounds of μ0.
    past : ndarray of bool, shape (p,)
        Whether the tip stuck past the lock.
    """
    opened = fit.task.spans.opened
    # Past the lock the tip can slip if the clamp goes back, but not if it goes on.
    locked = fit.task.spans.swung | (past & (opened | (fit.task.ends.sign > 0.0)))
    # If the tip stuck with more friction than at the end of the period, it did not slip there.
    more = ~locked & ~opened & (least > periods.high)
    return np.select(
        [np.isnan(least) | more, locked, opened, np.isnan(periods.mu0)],
        [PeriodStatus.BEYOND, PeriodStatus.LOCK, PeriodStatus.OPEN, PeriodStatus.BEYOND],
        PeriodStatus.SLIP,
    )


class _ByHeight(NamedTuple):
    """Change of μ0 in p periods due to the height of the surface at each tip.

    Attributes
    ----------
    change, left : ndarray, shape (p,)
        The change, and its standard deviation for a known set-up.
    effects : ndarray, shape (p, k)
        Derivatives of the change with respect to each parameter.
    """

    change: FloatArray
    left: FloatArray
    effects: FloatArray


def _by_height(fitted: FittedSetUp, effect: FloatArray) -> _ByHeight:
    """Estimate the change of μ0 due to the heights, where μ0 changes by `effect` per height."""
    none = np.zeros(len(effect))
    line = fitted.line
    if not (fitted.task.slope.deviation and fitted.settled):
        return _ByHeight(change=none, left=none, effects=none[:, None])
    height, variance = fitted.heights
    part = line.allowed / (line.allowed + variance)
    return _ByHeight(
        change=effect * part * height,
        left=np.abs(effect) * np.sqrt(part * variance),
        effects=(effect * part)[:, None] * line.moves_of_heights,
    )


def _least(fit: Fit, own: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Lower bound of μ0 in each period, and whether the tip stuck past the lock.

    The bound is the largest friction that the tip needed to stick. It is NaN if a sample of the
    period fits no state of the rod.
    """
    blocks = fit.task.blocks
    states, x0 = fit.held
    wide = HALF_WIDTH * own[blocks.period]
    none = (x0 - wide > states.x0_end) | (x0 + wide < states.x0_pull)
    # Take the state nearest to α = 0 within the uncertainty of x0: it needs the least friction.
    x0 = np.where(x0 > 0.0, np.maximum(x0 - wide, 0.0), np.minimum(x0 + wide, 0.0))
    needed = np.where(none, np.nan, np.abs(states.demand(states.clip(x0))))
    past = np.logical_or.reduceat(x0 >= states.x0_lock, blocks.starts)
    return np.maximum.reduceat(needed, blocks.starts), past
