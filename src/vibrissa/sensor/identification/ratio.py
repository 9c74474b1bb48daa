"""Reading without a rod: the ratio of the forces at the onset of slip."""

from dataclasses import dataclass

import numpy as np

from vibrissa.errors import MixedColumnsError, RecordingError
from vibrissa.numerics.arrays import BoolArray, FloatArray, StrArray
from vibrissa.sensor.identification.blocks import condensed
from vibrissa.sensor.identification.checks import Check, Grade, checks_of_spans
from vibrissa.sensor.identification.onsets import Ends, Onsets, read_onsets
from vibrissa.sensor.identification.parameters import BEARING, Parameter
from vibrissa.sensor.identification.periods import Periods, PeriodStatus
from vibrissa.sensor.identification.recording import FORCES, MOMENT
from vibrissa.sensor.identification.slips import Slipped, Spans, speed_of
from vibrissa.sensor.identification.uncertainty import HALF_WIDTH, Summary

# Places in a window, from its beginning to the last sample, where the ratio is looked at, and by
# how many standard deviations it has been larger there if the tip has locked.
PLACES = np.linspace(-1.0, 0.0, 9)
CERTAIN = 6.0
# A normal force of fewer standard deviations is none.
PRESSES = 10.0
# From more than this part of the periods on that end past a lock forces are swapped.
MOST_LOCK = 0.5


@dataclass(frozen=True, kw_only=True)
class Lag:
    """By how much the readings lag behind the clamp, and its standard deviation, in samples."""

    delay: float = 0.0
    error: float = 0.0


def bearing(parameters: tuple[Parameter, ...]) -> tuple[Parameter, ...]:
    """Parameters that change the ratio of the forces and are not exact."""
    return tuple(one for one in parameters if one.of in BEARING and one.deviation > 0.0)


def read_ratio(
    slipped: Slipped,
    noise: FloatArray,
    parameters: tuple[Parameter, ...],
    full_scale: FloatArray,
    lag: Lag,
) -> Periods:
    """Read the friction of the periods of a recording.

    Parameters
    ----------
    slipped : Slipped
    noise : ndarray, shape (3,)
        Standard deviation of one reading of each channel; the moment is not used.
    parameters : tuple of Parameter
        As from `bearing`.
    full_scale : ndarray, shape (3,)
        Of the channels; NaN of one that was not recorded.
    lag : Lag

    Returns
    -------
    Periods
        Of an unknown contact. Their `effects` are those of the parameters.

    Raises
    ------
    MixedColumnsError
        If the forces seem to be swapped.
    """
    recording, spans = slipped.recording, slipped.spans
    clamp, forces = recording.clamp, recording.readings[:, FORCES]
    ends, speed = _ends(slipped, lag)
    onsets = read_onsets(condensed(recording, spans), noise[FORCES], ends)
    effects = _effects(onsets, slipped, parameters, full_scale)
    late = np.nan_to_num(onsets.fits.slope / onsets.fits.length) * speed * lag.error
    shared = np.hypot(np.nan_to_num(onsets.correction.common), late)
    sizes = np.array([one.deviation for one in parameters])
    common = np.sqrt(shared**2 + ((effects * sizes) ** 2).sum(axis=1))
    found = onsets.summary(common)
    status, least = _statuses(onsets, found, slipped, noise)
    _check_axes(forces, status)
    known, nothing = status == PeriodStatus.SLIP, status == PeriodStatus.BEYOND
    least = np.maximum(least - HALF_WIDTH * common, 0.0)
    empty = np.full(len(spans), "")
    periods = Periods(
        status=status,
        first=slipped.row[spans.begins],
        last=slipped.row[spans.ends],
        first_line=recording.line[spans.begins],
        last_line=recording.line[spans.ends],
        contact=np.full(len(spans), np.nan),
        footpoint=clamp[spans.ends],
        mu0=np.where(known, found.mean, np.nan),
        deviation=np.where(known, found.deviation, np.nan),
        low=np.where(known, found.low, np.where(nothing, np.nan, least)),
        high=np.where(known, found.high, np.nan),
        common=np.where(known, common, 0.0),
        by_step=np.where(known, onsets.fits.by_step, np.nan),
        shared=np.where(known, shared, 0.0),
        effects=np.where(known, effects.T, 0.0).T,
        grade=empty,
        doubt=empty,
        left_out=recording.notes,
    )
    checks = checks_of_spans(slipped.clamp, spans) + _checks(onsets, slipped, nothing)
    return periods.doubted(*checks)


def _ends(slipped: Slipped, lag: Lag) -> tuple[Ends, FloatArray]:
    """Tell how the periods end, and how far the clamp moves there from sample to sample."""
    clamp, spans = slipped.recording.clamp, slipped.spans
    speed = speed_of(clamp)[spans.ends]
    gap = np.where(spans.cut, 0.0, clamp[spans.after] - clamp[spans.ends])
    ends = Ends(
        clamp=clamp[spans.ends],
        gap=gap,
        sign=slipped.signs,
        lag=lag.delay * speed,
        position=slipped.position,
    )
    return ends, speed


def _effects(
    onsets: Onsets, slipped: Slipped, parameters: tuple[Parameter, ...], full_scale: FloatArray
) -> FloatArray:
    """Change of the friction per unit of each parameter, shape (p, k)."""
    ends, recording = slipped.spans.ends, slipped.recording
    fits = onsets.fits
    fx, fy = fits.forces(fits.within(np.array([0.5])))[..., 0]
    # A moment that was not recorded is taken as that of full scale, of which crosstalk is a part.
    whole = np.nan_to_num(full_scale[MOMENT], nan=1.0)
    moment = np.nan_to_num(recording.readings[ends, MOMENT], nan=whole)
    loads = np.column_stack([fx, fy, moment])
    part = ends / max(len(recording) - 1, 1)
    found = np.zeros((len(ends), len(parameters)))
    for k, one in enumerate(parameters):
        error = np.zeros_like(loads)
        if one.mixing is not None:
            error = loads @ one.mixing.T
        else:
            error[:, one.channel] = one.zero(part)
        x, y, _ = (loads - one.deviation * error).T
        found[:, k] = (x / y - fx / fy) / one.deviation
    return np.nan_to_num(onsets.sign[:, None] * found)


def check_forces(forces: FloatArray, noise: FloatArray) -> None:
    """Refuse a recording in which a force is none, or presses the other way.

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


def _statuses(
    onsets: Onsets, found: Summary, slipped: Slipped, noise: FloatArray
) -> tuple[StrArray, FloatArray]:
    """Tell what is known about each period, and the least friction with which its tip has stuck."""
    spans, size = slipped.spans, len(slipped.spans)
    ratio, deviation = onsets.fits.ratio(np.broadcast_to(PLACES, (size, len(PLACES))))
    ratio = onsets.sign[:, None] * ratio
    # Where too few samples make a curve, the last one alone tells.
    fx, fy = slipped.recording.readings[spans.ends][:, FORCES].T
    presses = fy < -PRESSES * noise[1]
    alone = onsets.sign * fx / np.where(presses, fy, np.nan)
    error = np.hypot(noise[0], alone * noise[1]) / np.abs(fy)
    least = np.fmax(alone - HALF_WIDTH * error, (ratio - HALF_WIDTH * deviation)[:, -1])
    beyond = (ratio - ratio[:, -1:]) > CERTAIN * np.hypot(deviation, deviation[:, -1:])
    locked = beyond.any(axis=1) | slipped.swung
    peak = np.nanmax(np.where(np.isnan(ratio), -np.inf, ratio - HALF_WIDTH * deviation), axis=1)
    opened = _opened(spans)
    unknown = np.isnan(found.mean) | ~presses
    status = np.select(
        [least < -CERTAIN * error, locked, opened, unknown],
        [PeriodStatus.BEYOND, PeriodStatus.LOCK, PeriodStatus.OPEN, PeriodStatus.UNSURE],
        PeriodStatus.SLIP,
    )
    return status, np.where(locked, np.fmax(least, peak), least)


def _opened(spans: Spans) -> BoolArray:
    """Tell which periods end without a slip that is seen."""
    return np.asarray(spans.cut | spans.passes | (np.arange(len(spans)) == len(spans) - 1))


def _checks(onsets: Onsets, slipped: Slipped, nothing: BoolArray) -> list[Check]:
    """Check whether the forces are those of sticking and slipping."""
    return [
        Check(
            name="rough",
            grade=Grade.WRONG,
            periods=~onsets.smooth,
            sentence="the forces do not follow a smooth curve: a slip may be hidden",
        ),
        Check(
            name="backward",
            grade=Grade.WRONG,
            periods=nothing,
            sentence="no slip goes that way",
        ),
    ]
