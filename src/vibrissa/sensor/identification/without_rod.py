"""Friction of each period without a rod: the ratio of the forces at the onset of slip."""

import numpy as np

from vibrissa.errors import MixedColumnsError, RecordingError
from vibrissa.numerics.arrays import BoolArray, FloatArray, StrArray
from vibrissa.sensor.identification.friction import Periods, PeriodStatus, checked_noise
from vibrissa.sensor.identification.misfit.doubts import (
    FEW,
    Doubt,
    Doubted,
    graded,
    in_words,
    notes_of,
)
from vibrissa.sensor.identification.reading.carried import Carried
from vibrissa.sensor.identification.reading.jumps import (
    FALL,
    LOST,
    Spans,
    direction,
    spans_of,
    spikes,
    usual_step,
)
from vibrissa.sensor.identification.reading.ratio import Onsets, read_onsets
from vibrissa.sensor.identification.reading.uncertainty import HALF_WIDTH, Summary
from vibrissa.sensor.identification.recording import (
    FORCES,
    Recording,
    check_size,
    left_out,
    noise_of,
)

# Places in a window, from its beginning to the last sample, where the ratio is looked at, and by
# how many standard deviations it has been larger there if the tip has locked.
PLACES = np.linspace(-1.0, 0.0, 9)
CERTAIN = 6.0
# A normal force of fewer standard deviations is none.
PRESSES = 10.0
# From more than this part of the periods on that end past a lock forces are swapped.
MOST_LOCK = 0.5
# After a slip fx keeps its sign, or turns round a little. Where it turns round to this part of what
# it was, and fy stays as large as this part, the rod has swung aside.
TURNED, PRESSED = 0.7, 0.85


def read_ratio(
    recording: Recording, noise: FloatArray | None = None, errors: Carried | None = None
) -> Periods:
    """Find the periods of sticking in a recording, and the friction of each, without a rod.

    Parameters
    ----------
    recording : Recording
        With both forces, in any units.
    noise : ndarray, shape (3,), optional
        Standard deviation of one reading of force_x, force_y and moment_z, of which the last is not
        used; estimated from the recording by default.
    errors : Carried, optional
        Of the readings, which all periods share; none by default.

    Returns
    -------
    Periods
        Of an unknown contact: without a rod it is not known. Their `effects` are those
        of the errors of the readings.

    Raises
    ------
    RecordingError
        If the recording is too short, has no measurable noise, or a force is none or has the
        other sign.
    MixedColumnsError
        If the forces seem to be swapped.
    """
    check_size(len(recording), recording.notes)
    noise = checked_noise(noise_of(recording.readings) if noise is None else noise, FORCES)[FORCES]
    lone = spikes(recording.readings[:, 0], noise[0]) | spikes(recording.readings[:, 1], noise[1])
    notes = recording.notes + left_out(recording.line[lone], "a lone spike")
    recording = recording.take(~lone)
    clamp, forces = recording.clamp, recording.readings[:, FORCES]
    _check_signs(clamp, forces, noise)
    spans = spans_of(clamp, forces[:, 0], noise[0])
    onsets = read_onsets(clamp, forces, noise, spans)
    effects = np.zeros((len(spans), 0))
    shifts = np.full((len(spans), 1), np.nan_to_num(onsets.correction.common))
    if errors is not None:
        at_onset = onsets.fits.forces(0.5 * onsets.fits.gap[:, None])[..., 0].T
        effects = errors.effects(at_onset, recording.take(spans.ends))
        effects = np.nan_to_num(onsets.sign[:, None] * effects)
        shifts = np.hstack([shifts, effects * errors.sizes])
    common = np.sqrt((shifts**2).sum(axis=1))
    found = onsets.summary(common)
    swung = _swung(clamp, forces, spans)
    status, least = _statuses(onsets, found, forces, noise, spans, swung)
    _check_axes(forces, status)
    least = least - HALF_WIDTH * common
    known, nothing = status == PeriodStatus.SLIP, status == PeriodStatus.BEYOND
    reasons = [
        *_doubts(clamp, spans, onsets),
        Doubted(doubt=Doubt.SWUNG, periods=swung),
        Doubted(doubt=Doubt.WRONG_WAY, periods=nothing),
    ]
    first_line, last_line = recording.line[spans.begins], recording.line[spans.ends]
    rows = np.flatnonzero(~lone)
    return Periods(
        status=status,
        first=rows[spans.begins],
        last=rows[spans.ends],
        first_line=first_line,
        last_line=last_line,
        contact=np.full(len(spans), np.nan),
        footpoint=clamp[spans.ends],
        mu0=np.where(known, found.mean, np.nan),
        deviation=np.where(known, found.deviation, np.nan),
        low=np.where(known, found.low, np.where(nothing, np.nan, np.maximum(least, 0.0))),
        high=np.where(known, found.high, np.nan),
        common=np.where(known, common, 0.0),
        by_step=np.where(known, onsets.fits.by_step, np.nan),
        effects=np.where(known, effects.T, 0.0).T,
        shifts=np.where(known, shifts.T, 0.0).T,
        grade=graded(reasons),
        doubt=in_words(reasons),
        notes=(*notes, *notes_of(reasons, first_line, last_line)),
    )


def _check_signs(clamp: FloatArray, forces: FloatArray, noise: FloatArray) -> None:
    """Refuse a recording in which a force has the other sign, or is none.

    Slips are short falls of the load between long rises: with the other sign they are short rises.
    """
    if not np.ptp(forces[:, 0]):
        raise RecordingError("force_x has one value in all rows: the channel was not recorded")
    falls = np.diff(forces[:, 0]) * direction(clamp) / noise[0]
    clear = falls[np.abs(falls) > FALL]
    if (clear**3).sum() < 0.0:
        raise RecordingError(
            "force_x grows suddenly where it should fall, in slips: column force_x or footpoint "
            "has the other sign. force_x is the load of the rod on the clamp, negative where a "
            "clamp that moves forward pushes the tip"
        )
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


def _swung(clamp: FloatArray, forces: FloatArray, spans: Spans) -> BoolArray:
    """Tell which periods end as the rod swings aside: fx turns round, and fy stays."""
    last, first = spans.ends[:-1], spans.begins[1:]
    way = direction(clamp)[last]
    before, after = way * forces[last, 0], way * forces[first, 0]
    turned = (before < 0.0) & (after > -TURNED * before)
    # A tip that slips far, and is pulled after it, presses much less than before.
    turned &= forces[first, 1] < PRESSED * forces[last, 1]
    return np.append(turned, False)


def _statuses(
    onsets: Onsets,
    found: Summary,
    forces: FloatArray,
    noise: FloatArray,
    spans: Spans,
    swung: BoolArray,
) -> tuple[StrArray, FloatArray]:
    """Tell what is known about each period, and the least friction with which its tip has stuck."""
    size = len(spans)
    ratio, deviation = onsets.fits.ratio(np.broadcast_to(PLACES, (size, len(PLACES))))
    ratio = onsets.sign[:, None] * ratio
    # Where too few samples make a curve, the last one alone tells.
    fx, fy = forces[spans.ends].T
    presses = fy < -PRESSES * noise[1]
    alone = onsets.sign * fx / np.where(presses, fy, np.nan)
    error = np.hypot(noise[0], alone * noise[1]) / np.abs(fy)
    least = np.fmax(alone - HALF_WIDTH * error, (ratio - HALF_WIDTH * deviation)[:, -1])
    beyond = (ratio - ratio[:, -1:]) > CERTAIN * np.hypot(deviation, deviation[:, -1:])
    locked = beyond.any(axis=1) | swung
    peak = np.nanmax(np.where(np.isnan(ratio), -np.inf, ratio - HALF_WIDTH * deviation), axis=1)
    opened = spans.cut | (np.arange(size) == size - 1)
    unknown = np.isnan(found.mean) | ~presses
    status = np.select(
        [least < -CERTAIN * error, locked, opened, unknown],
        [PeriodStatus.BEYOND, PeriodStatus.LOCK, PeriodStatus.OPEN, PeriodStatus.UNSURE],
        PeriodStatus.SLIP,
    )
    return status, np.where(locked, np.fmax(least, peak), least)


def _doubts(clamp: FloatArray, spans: Spans, onsets: Onsets) -> list[Doubted]:
    """Tell for each reason to doubt a friction which periods it concerns."""
    gap = clamp[np.minimum(spans.ends + 1, len(clamp) - 1)] - clamp[spans.ends]
    lost = spans.cut | (np.abs(gap) > LOST * usual_step(clamp))
    came = clamp[spans.ends] - clamp[np.maximum(spans.ends - FEW, spans.begins)]
    return [
        Doubted(doubt=Doubt.ROUGH, periods=~onsets.smooth),
        Doubted(doubt=Doubt.GAP_AFTER, periods=lost),
        Doubted(doubt=Doubt.TURN, periods=came * gap < 0.0),
        Doubted(doubt=Doubt.FEW, periods=spans.ends - spans.begins + 1 < FEW),
    ]
