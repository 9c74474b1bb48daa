"""Reading by the model of the rod: one fit of set-up and contacts to all recorded channels."""

from dataclasses import replace

import numpy as np

from vibrissa.errors import WrongRodError
from vibrissa.numerics.arrays import BoolArray
from vibrissa.sensor.identification.blocks import condensed
from vibrissa.sensor.identification.checks import (
    Check,
    backward,
    checks_of_spans,
    misfit,
    unfitted,
)
from vibrissa.sensor.identification.fit import Fit, Noise, fitted, started
from vibrissa.sensor.identification.forward import Forward
from vibrissa.sensor.identification.friction import read_periods
from vibrissa.sensor.identification.goodness import Goodness, causes_of, tolerances_of
from vibrissa.sensor.identification.mixing import MISFIT, NearestStates, check_columns
from vibrissa.sensor.identification.periods import Periods, PeriodStatus
from vibrissa.sensor.identification.result import Identification
from vibrissa.sensor.identification.slips import Slipped, speed_of
from vibrissa.sensor.identification.summary import Setting
from vibrissa.sensor.identification.task import Task
from vibrissa.sensor.transducer import CHANNELS
from vibrissa.sensor.whisker import Whisker

# A sample is no state of the rod if its readings differ by more than this part of them, and by more
# than noise. If more than this part of the samples is none, it is another rod or has a bias.
MOST_MISFIT, MOST_OFF = 0.1, 0.2
# A cause is named for a recording that is refused if it explains this part of the misfit.
EXPLAINS = 0.9
# Standard deviations by which a contact has surely moved.
CERTAIN = 6.0


def read_model(task: Task, whisker: Whisker) -> tuple[Task, Slipped, Identification]:
    """Read the friction of the periods of a recording.

    Returns
    -------
    Task, Slipped
        With the noise that was found, and the periods that were joined.

    Raises
    ------
    WrongRodError
        If most samples are no states of the rod.
    NoResponseError
        If the rod has no response.
    """
    nearest = _nearest(task, whisker)
    check_columns(nearest, task.recording)
    task = task.with_scatter()
    nearest = replace(nearest, noise=task.noise[task.used])
    slipped = task.slipped
    start = _started(task, whisker, slipped, nearest)
    _check_states(task, start, nearest)
    together = _together(start, slipped)
    if together.any():
        slipped = slipped.joined(together)
        start = _started(task, whisker, slipped, nearest)
    fit = fitted(start)
    goodness = Goodness.of(fit, task.noise_is_given)
    free = [one for one in fit.forward.parameters if one.deviation > 0.0]
    tolerances = tolerances_of(free, fit.p[fit.free], fit.covariance)
    doubted = not goodness.fits or any(one.far for one in tolerances)
    periods = read_periods(fit, slipped)
    checks = checks_of_spans(slipped.clamp, slipped.spans) + _checks(fit, slipped, periods)
    if doubted or not fit.settled:
        checks.append(unfitted(fit.settled, goodness.fits, len(periods)))
    setting = Setting(
        units=task.units,
        slope=task.slope,
        tolerances=tolerances,
        covariance=fit.covariance,
        goodness=goodness,
        causes=causes_of(fit, goodness.fits) if doubted else (),
    )
    found = Identification(periods=periods.doubted(*checks), setting=setting, by_model=True)
    return task, slipped, found


def _nearest(task: Task, whisker: Whisker) -> NearestStates:
    """States at the height in the middle of the way of the stage."""
    clamp, mounting = task.recording.clamp, whisker.mounting
    middle = 0.5 * (clamp.min() + clamp.max())
    level = replace(
        whisker,
        eta=float(whisker.eta - middle * np.sin(mounting.stage_angle)),
        mounting=replace(mounting, stage_angle=0.0),
    )
    branch = level.response(backward=False)
    return NearestStates(branch=branch, used=task.used, noise=task.noise[task.used])


def _started(task: Task, whisker: Whisker, slipped: Slipped, nearest: NearestStates) -> Fit:
    """Fit the contact points with the given set-up."""
    recording = slipped.recording
    blocks = condensed(recording, slipped.spans)
    forward = Forward(
        whisker=whisker,
        parameters=task.parameters,
        blocks=blocks,
        speed=speed_of(recording.clamp)[blocks.row.astype(int)],
        ends=slipped.ends,
        rows=len(recording),
        delay=task.delay,
    )
    noise = Noise(used=task.used, reading=task.noise[task.used], position=slipped.position)
    return started(forward, noise, nearest(blocks.readings)[0], task.slope)


def _check_states(task: Task, fit: Fit, nearest: NearestStates) -> None:
    """Refuse a recording most of whose samples are no states of the rod, with likely causes."""
    blocks = fit.forward.blocks
    squares = (fit.residuals**2).sum(axis=1) / blocks.count
    size = (nearest.weighted(blocks.readings) ** 2).sum(axis=1)
    off = squares > np.maximum(MISFIT, MOST_MISFIT**2 * size)
    part = float(blocks.count[off].sum() / blocks.count.sum())
    if part <= MOST_OFF:
        return
    likely = [one for one in causes_of(replace(fit, settled=False), False)]
    said = [one.spelled(task.units) for one in likely if one.explained > EXPLAINS]
    first = task.slipped.recording.line[int(blocks.row[off][0])]
    text = (
        f"{part:.0%} of the samples are no state of this rod, first in line {first}: check rod, "
        "height, units, zero and noise"
    )
    raise WrongRodError(f"{text}. Likely: {', or '.join(said)}" if said else text)


def _moved(fit: Fit, slipped: Slipped) -> tuple[BoolArray, BoolArray]:
    """Whether the contact has surely moved after each period: forward with the clamp, or at all."""
    contact = fit.forward.contact(fit.p, fit.u, fit.heights)
    own = np.hypot(fit.known**-0.5, slipped.position)
    way = np.diff(contact) * fit.forward.ends.sign[:-1]
    error = CERTAIN * np.hypot(own[1:], own[:-1])
    return way >= error, np.abs(way) >= error


def _together(fit: Fit, slipped: Slipped) -> BoolArray:
    """Periods after which the tip has not moved, so that no slip follows them."""
    _, moved = _moved(fit, slipped)
    return np.append(~moved & ~slipped.spans.passes[:-1], False)


def _checks(fit: Fit, slipped: Slipped, periods: Periods) -> list[Check]:
    """Check whether the readings fit the rod, and the slips go with the clamp."""
    squares = fit.forward.blocks.sums(fit.residuals**2)
    worst, off = squares.argmax(axis=1), ~fit.fits_alone
    forward, _ = _moved(fit, slipped)
    against = np.append(~forward & ~slipped.spans.passes[:-1], False)
    return [
        *(
            misfit(CHANNELS[channel], off & (worst == number))
            for number, channel in enumerate(fit.noise.used)
        ),
        backward(against | (periods.status == PeriodStatus.BEYOND)),
    ]
