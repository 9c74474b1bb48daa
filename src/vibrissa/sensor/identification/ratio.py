"""Reading without a rod: the ratio of the forces at the onset of slip."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vibrissa.errors import MixedColumnsError, RecordingError
from vibrissa.numerics.arrays import FloatArray, StrArray
from vibrissa.sensor.identification.blocks import condensed
from vibrissa.sensor.identification.checks import Check, Grade, checks_of_spans
from vibrissa.sensor.identification.goodness import tolerances_of
from vibrissa.sensor.identification.onsets import Onsets, read_onsets
from vibrissa.sensor.identification.parameters import BEARING, Parameter
from vibrissa.sensor.identification.periods import PeriodStatus, periods_of
from vibrissa.sensor.identification.recording import FORCES, MOMENT
from vibrissa.sensor.identification.result import Identification
from vibrissa.sensor.identification.slips import Slipped
from vibrissa.sensor.identification.task import Task
from vibrissa.sensor.identification.uncertainty import HALF_WIDTH, common_deviation, summary_of

# Places in a window, from its beginning to the last sample, where the ratio is looked at, and by
# how many standard deviations it has been larger there if the tip has locked.
PLACES = np.linspace(-1.0, 0.0, 9)
CERTAIN = 6.0
# A normal force of fewer standard deviations is none.
PRESSES = 10.0
# From more than this part of the periods on that end past a lock forces are swapped.
MOST_LOCK = 0.5


def read_ratio(task: Task) -> Identification:
    """Read the friction of the periods of a recording.

    Raises
    ------
    RecordingError
        If the forces are none, press the other way, seem to be swapped, or have no noise.
    """
    if not task.both_forces:
        raise RecordingError("the method ratio needs the noise of both forces, above 0")
    slipped = task.slipped
    recording, spans, ends = slipped.recording, slipped.spans, slipped.ends
    forces, noise = recording.readings[:, FORCES], task.noise[FORCES]
    check_forces(forces, noise)
    ends = replace(ends, gap=np.where(spans.cut, 0.0, ends.gap))
    onsets = read_onsets(
        condensed(recording, spans), noise, ends, task.delay * ends.speed, slipped.position
    )
    parameters = [one for one in task.parameters if one.of in BEARING and one.deviation > 0.0]
    # How the forces curve is an error of all periods, too.
    effects = _effects(slipped, onsets, parameters, task.full_scale[MOMENT])
    effects = np.column_stack([effects, np.ones(len(spans))])
    covariance = np.diag([*(one.deviation**2 for one in parameters), onsets.shared**2])
    common = common_deviation(effects, covariance)
    found = summary_of(onsets.along, np.hypot(onsets.own, common))
    status, least = _statuses(onsets, slipped, noise)
    _check_axes(forces, status)
    periods = periods_of(slipped, status, found, least - HALF_WIDTH * common, common, effects)
    hidden = "the forces do not follow a smooth curve: a slip may be hidden"
    against = "the tip cannot slip in this direction"
    return Identification(
        periods=periods.doubted(
            *checks_of_spans(slipped.clamp, spans),
            Check(Grade.WRONG, ~onsets.smooth, hidden),
            Check(Grade.WRONG, status == PeriodStatus.BEYOND, against),
        ),
        units=task.units,
        by_model=False,
        tolerances=tolerances_of(parameters, np.zeros(len(parameters)), covariance[:-1, :-1]),
        covariance=covariance,
        slope=task.slope,
    )


def _effects(
    slipped: Slipped, onsets: Onsets, parameters: Sequence[Parameter], moment: float
) -> FloatArray:
    """Change of the friction per unit of each parameter, shape (p, k): −(δfx − (fx/fy)·δfy)/fy."""
    ends, recording = slipped.spans.ends, slipped.recording
    loads = recording.readings[ends].copy()
    # A moment that was not recorded is taken as that of full scale, of which crosstalk is a part.
    whole = np.nan_to_num(moment, nan=1.0)
    loads[:, MOMENT] = np.nan_to_num(loads[:, MOMENT], nan=whole)
    sign = slipped.ends.sign
    ratio, part = sign * onsets.along[:, 1], ends / max(len(recording) - 1, 1)
    found = np.zeros((len(ends), len(parameters)))
    for k, one in enumerate(parameters):
        error = np.zeros_like(loads)
        if one.mixing is not None:
            error = loads @ one.mixing.T
        else:
            error[:, one.channel] = one.zero(part)
        found[:, k] = -sign * (error[:, 0] - ratio * error[:, 1]) / loads[:, 1]
    return np.nan_to_num(found)


def check_forces(forces: FloatArray, noise: FloatArray) -> None:
    """Refuse a recording in which a force is missing or has the wrong sign.

    Raises
    ------
    RecordingError
    """
    if not np.ptp(forces[:, 0]):
        raise RecordingError("force_x has one value in all rows: the channel was not recorded")
    usual = float(np.median(forces[:, 1]) / noise[1])
    if usual >= 1.0:
        raise RecordingError(
            "force_y is positive: it is the load of the rod on the clamp, negative where the rod "
            "presses against the surface"
        )
    if usual > -1.0:
        raise RecordingError(
            "force_y is less than its noise: the rod does not press against the surface, or the "
            "channel was not recorded"
        )


def _check_axes(forces: FloatArray, status: StrArray) -> None:
    """Refuse a recording of swapped forces: their ratio falls in most periods, from a large one."""
    tangential, normal = np.median(np.abs(forces), axis=0)
    locked = int((status == PeriodStatus.LOCK).sum())
    if locked > max(2, MOST_LOCK * len(status)) and tangential > normal:
        raise MixedColumnsError(
            f"in {locked} of {len(status)} periods force_x over force_y falls until the tip slips: "
            "the columns force_x and force_y seem to be swapped. force_x is along the surface, "
            "force_y normal to it"
        )


def _statuses(onsets: Onsets, slipped: Slipped, noise: FloatArray) -> tuple[StrArray, FloatArray]:
    """Status of each period, and the least friction with which its tip stuck."""
    spans, sign = slipped.spans, slipped.ends.sign
    ratio, deviation = onsets.fits.ratio(np.tile(PLACES, (len(spans), 1)))
    ratio = sign[:, None] * ratio
    # Where too few samples make a curve, the last one alone tells.
    fx, fy = slipped.recording.readings[spans.ends][:, FORCES].T
    presses = fy < -PRESSES * noise[1]
    alone = sign * fx / np.where(presses, fy, np.nan)
    error = np.hypot(noise[0], alone * noise[1]) / np.abs(fy)
    fallen = (ratio - ratio[:, -1:]) > CERTAIN * np.hypot(deviation, deviation[:, -1:])
    locked = fallen.any(axis=1) | slipped.swung
    curve = ratio - HALF_WIDTH * deviation
    least = np.fmax(alone - HALF_WIDTH * error, curve[:, -1])
    peak = np.max(np.nan_to_num(curve, nan=-np.inf), axis=1)
    status = np.select(
        [
            least < -CERTAIN * error,
            locked,
            spans.cut | spans.opened,
            np.isnan(onsets.along[:, 1]) | ~presses,
        ],
        [PeriodStatus.BEYOND, PeriodStatus.LOCK, PeriodStatus.OPEN, PeriodStatus.UNSURE],
        PeriodStatus.SLIP,
    )
    return status, np.where(locked, np.fmax(least, peak), least)
