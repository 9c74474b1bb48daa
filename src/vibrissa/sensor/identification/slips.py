"""Slips of a recording, found once for both methods: sudden falls of the load.

The load on the clamp is counted as positive if it acts against the motion of the clamp. Within a
period it only rises, as sticking is stable. A fall by more than noise is a slip; samples between
the peak of the load before the slip and the trough after it belong to no period.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from vibrissa.errors import RecordingError
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.numerics.batch import Batch
from vibrissa.sensor.identification.noise import noise_of
from vibrissa.sensor.identification.recording import FORCES, MOMENT, RESTING_PART, Recording

# A fall by this many standard deviations of one reading is a slip. In 10^5 samples whose load
# hardly changes from one to the next, noise makes such a fall in one recording of ten.
SLIP_FALL = 8.0
# Least fall from one sample to the next within a slip, in standard deviations, that is not noise.
STEP_FALL = 5.0
# Signs of the changes of fx, fy and m in a slip while the clamp moves forward; fy has either sign.
FALLING = np.array([1.0, np.nan, -1.0])
# Distance of a spike from the mean of its neighbours, in standard deviations.
SPIKE_HEIGHT = 8.0
# Length of a step, in usual steps, above which it is long.
LONG_STEP = 1.5
# Length of a step, in usual steps, above which samples were lost.
LOST_STEP = 10.0
# If the tip sticks over a long step, the load rises by more than this part of the usual rise over
# such a distance; if the tip slips, it rises by less.
STICKS_ON = 0.5
# After a slip fx has its old sign, or the other sign with a small value. If fx has the other sign
# and more than the part TURNED of its size, and fy the part PRESSED, the rod has buckled laterally.
TURNED = 0.7
PRESSED = 0.85
# Part of a step that is rounding, not noise of the positions.
ROUNDED_PART_OF_STEP = 1e-3
# Largest number of rows between two periods that may belong to a single slip.
MOST_BETWEEN = 10
# Least rise of the load, in standard deviations, by which a channel is weighted.
LEAST_RISE = 1e-9
# Least part of the samples in which the load falls if the tip slips too often.
TEETH_PART = 0.25
# Largest median deviation within slips and within rises, as a part of the distance between both.
DISTINCT_SPREAD = 0.15
# Difference of a step from the usual step, in standard deviations of a position, that is not noise.
ANOTHER_STEP = 6.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Spans(Batch):
    """Periods of sticking as rows of a recording, each field an array of shape (p,).

    Attributes
    ----------
    begins, ends : ndarray of int
        First and last row in which the tip sticks. Rows between two periods belong to no period.
    after : ndarray of int
        First row that shows the slip at the end of the period; the last row of the recording if
        the period lasts until then.
    cut : ndarray of bool
        Whether the period ends where samples are missing, without a visible slip.
    passes : ndarray of bool
        Whether the clamp went back after the period without being recorded, for a new pass.
    swung : ndarray of bool
        Whether the period ends because the rod buckles laterally.
    """

    begins: IntArray
    ends: IntArray
    after: IntArray
    cut: BoolArray
    passes: BoolArray
    swung: BoolArray

    @property
    def opened(self) -> BoolArray:
        """Whether the end of each period is open: the recording does not show the slip."""
        return np.asarray((self.after == self.ends) | self.passes)

    @property
    def between(self) -> IntArray:
        """Rows between periods, in gaps that are too long to be a single slip.

        Such a gap has more rows than a usual period (the median), and more than `MOST_BETWEEN`.
        """
        rows = [
            np.arange(last + 1, first)
            for last, first in zip(self.ends, self.begins[1:], strict=False)
        ]
        usual = max(np.median(self.counts), MOST_BETWEEN)
        return np.concatenate([np.arange(0), *(gap for gap in rows if len(gap) > usual)])

    @property
    def counts(self) -> IntArray:
        """Number of rows of each period."""
        return self.ends - self.begins + 1

    @property
    def rows(self) -> tuple[IntArray, IntArray]:
        """Rows that belong to periods, and for each of them the number of its period."""
        counts = self.counts
        period = np.repeat(np.arange(len(counts)), counts)
        first = self.begins - np.cumsum(counts) + counts
        return np.arange(len(period)) + first[period], period


@dataclass(frozen=True, eq=False, kw_only=True)
class PeriodEnds(Batch):
    """Motion of the clamp at the ends of p periods, each field an array of shape (p,).

    Attributes
    ----------
    clamp : ndarray
        Position of the clamp in the last sample of the period (L).
    gap : ndarray
        Travel of the clamp from the last sample of the period to the first one that shows the
        slip (L); 0 before a new pass.
    sign : ndarray
        1 if the clamp moves forward at the slip, −1 if it moves backward.
    """

    clamp: FloatArray
    gap: FloatArray
    sign: FloatArray


def spikes(readings: FloatArray, way: FloatArray) -> BoolArray:
    """Find lone spikes: samples with a reading far from the one before and the one after it.

    The reading before and the reading after a spike agree with each other.

    Parameters
    ----------
    readings : ndarray, shape (n, 3)
        Readings, divided by their standard deviations; NaN for a channel that is not used.
    way : ndarray, shape (n − 1,)
        Direction of the clamp's motion between successive samples.

    Returns
    -------
    ndarray of bool, shape (n,)
        Whether each sample is a lone spike.
    """
    before, middle, after = readings[:-2], readings[1:-1], readings[2:]
    off = np.abs(middle - 0.5 * (after + before))
    lone = np.pad((off > SPIKE_HEIGHT) & (off > 2.0 * np.abs(after - before)), ((1, 1), (0, 0)))
    # If successive samples are all far from their neighbours, the tip slips in every other step.
    alone = lone[1:-1] & ~(lone[2:] | lone[:-2])
    # The load also has a peak where the clamp turns, and where a slip follows.
    peak = ((after - before) * FALLING * way[:-1, None] > SLIP_FALL).any(axis=1) | (
        way[1:] != way[:-1]
    )
    return np.pad(alone.any(axis=1) & ~peak, 1)


def _large_falls(load: Sequence[float]) -> Iterator[tuple[int, int]]:
    """Yield the rows of the peak and of the trough of each fall above `SLIP_FALL`.

    A fall ends where the load has risen by `SLIP_FALL` above its trough. (`scipy.signal.find_peaks`
    finds the same peaks by their prominence, but takes half a second to load.)
    """
    peak = trough = 0
    for row, value in enumerate(load):
        falls = load[peak] - load[trough] > SLIP_FALL
        if falls and value - load[trough] >= SLIP_FALL:
            yield peak, trough
            peak = trough = row
        elif not falls and value >= load[peak]:
            peak = trough = row
        elif value < load[trough]:
            trough = row
    if load[peak] - load[trough] > SLIP_FALL:
        yield peak, trough


def _slips(falls: FloatArray) -> tuple[IntArray, IntArray]:
    """Find the first and the last row of each period; periods end with falls above `SLIP_FALL`."""
    load = -np.cumsum(np.append(0.0, falls))
    begins, ends = [0], []
    for peak, trough in _large_falls(load.tolist()):
        large = np.flatnonzero(falls[peak:trough] > STEP_FALL)
        # Noise may shift the peak by some samples, but not the large fall between two samples.
        ends.append(peak + int(large[0]) if len(large) else peak)
        begins.append(peak + int(large[-1]) + 1 if len(large) else trough)
    return np.array(begins), np.array([*ends, len(falls)])


def _spans(recording: Recording, falls: FloatArray) -> Spans:
    """Find the periods, at least one; periods of a single sample are left out.

    A period is also cut where samples are missing and the load rises less than in sticking.
    """
    begins, ends = _slips(falls)
    clamp = recording.smooth
    steps = np.abs(np.diff(clamp))
    usual = usual_step(clamp)
    moves = steps > 0.0
    rise = np.median(-falls[moves] / steps[moves]) * steps if moves.any() else steps
    short = rise + falls > np.maximum(SLIP_FALL, STICKS_ON * rise)
    rows = np.flatnonzero(short & (steps > LONG_STEP * usual))
    # Long steps between two periods belong to a slip that was found.
    last = rows[rows < ends[np.searchsorted(begins, rows, side="right") - 1]]
    ends = np.sort(np.append(ends, last))
    after = np.minimum(ends + 1, len(clamp) - 1)
    # A new pass: one step as long as many usual steps, against the motion before and after it.
    way = np.append(recording.direction, 0.0)
    turned = (way[ends] * way[np.maximum(ends - 1, 0)] < 0.0) & (way[ends] * way[after] < 0.0)
    spans = Spans(
        begins=np.sort(np.append(begins, last + 1)),
        ends=ends,
        after=after,
        cut=np.isin(ends, last),
        passes=turned & (np.append(steps, 0.0)[ends] > LOST_STEP * usual),
        swung=np.zeros(len(ends), dtype=bool),
    )
    several = spans.ends > spans.begins
    return spans.take(several) if several.any() else spans


def check_slips(recording: Recording, spans: Spans, noise: FloatArray) -> None:
    """Check that force_x has the right sign, and that the recording has a period of sticking.

    Raises
    ------
    RecordingError
        If the load rises suddenly in slips, instead of falling, or there is no period.
    """
    readings = recording.readings / noise
    clamp = recording.smooth
    load = readings[:, 0] if np.isfinite(noise[FORCES]).all() else -readings[:, MOMENT]
    falls = np.diff(load) * recording.direction
    frequent = not recording.position and _saw_teeth(falls)
    if frequent and len(spans) < TEETH_PART * np.count_nonzero(falls > 0.0):
        raise RecordingError(
            "the load falls in every second to third sample: the tip slips too often to see a "
            "period of sticking; sample more finely"
        )
    usual = np.abs(np.diff(clamp)) <= LOST_STEP * usual_step(clamp)
    # With coarse samples the load rises in every step: subtract the median rise.
    sudden = falls - np.median(falls)
    clear = sudden[(np.abs(sudden) > SLIP_FALL) & usual]
    # A load that rises from sample to sample, as it should, may rise unevenly.
    rises = np.median(falls) < -SLIP_FALL / np.sqrt(len(falls))
    if not rises and (clear**3).sum() < 0.0:
        raise RecordingError(
            "during slips the load on the clamp grows instead of falling: the sign of force_x, "
            "moment_z or footpoint is wrong, or the tip slips in almost every step (sample more "
            "finely). force_x and moment_z are loads of the rod on the clamp. While the clamp "
            "moves forward and pushes the tip, force_x is negative and falls, and moment_z rises"
        )
    if not len(spans):
        raise RecordingError("no samples are left between the slips: give a shorter slip_time")


def _saw_teeth(falls: FloatArray) -> bool:
    """Whether changes of the load are of two kinds, slips and rises, and slips are frequent.

    With noise, small changes are the most frequent ones.
    """
    slips, rises = falls[falls > 0.0], falls[falls < 0.0]
    if not min(len(slips), len(rises)) or len(slips) < TEETH_PART * len(falls):
        return False
    slip, rise = np.median(slips), np.median(rises)
    spreads = [np.median(np.abs(slips - slip)), np.median(np.abs(rises - rise))]
    # Noise below the resolution has few values, too: most of them are equal.
    return bool(LEAST_RISE < min(spreads) and max(spreads) < DISTINCT_SPREAD * (slip - rise))


def usual_step(clamp: FloatArray) -> float:
    """Median travel of the clamp between samples in motion (L); infinite if it never moves."""
    steps = np.abs(np.diff(clamp))
    return float(np.median(steps[steps > 0.0])) if steps.any() else np.inf


def position_noise(clamp: FloatArray) -> float:
    """Estimate the standard deviation of one clamp position (L); 0 if positions have no noise.

    They have none if successive positions are often equal, or if they scatter by rounding only.
    """
    steps = np.diff(clamp)
    scatter = noise_of(clamp[:, None])[0]
    rests = np.mean(steps == 0.0) > RESTING_PART if len(steps) else True
    return (
        0.0 if rests or not scatter > ROUNDED_PART_OF_STEP * usual_step(clamp) else float(scatter)
    )


def before_swing(recording: Recording, spans: Spans, noise: FloatArray) -> tuple[Recording, Spans]:
    """End a recording where the rod buckles laterally.

    In lateral buckling fx changes its sign, and fy stays almost the same.
    """
    forces = recording.readings[:, :2]
    last, first = spans.ends[:-1], spans.begins[1:]
    way = recording.direction[last]
    before, after = way * forces[last, 0], way * forces[first, 0]
    # Nor is a force that may be noise a reason to leave out the rest.
    turned = (before < 0.0) & (after > np.maximum(-TURNED * before, SLIP_FALL * noise[0]))
    # In contrast, after a slip beyond α = 0 the pulled tip presses much less than before.
    turned &= forces[first, 1] < PRESSED * forces[last, 1]
    if not turned.any():
        return recording, spans
    kept = int(np.argmax(turned)) + 1
    end = int(spans.ends[kept - 1]) + 1
    note = (
        f"the rod buckles laterally in line {recording.line[end]}: the lines from there on are not "
        "used; begin a new recording there"
    )
    recording = recording.noted(note).take(slice(end))
    spans = spans.take(slice(kept))
    after = np.minimum(spans.after, end - 1)
    swung = np.arange(kept) == kept - 1
    return recording, replace(spans, after=after, swung=swung)


def ends_of(recording: Recording, spans: Spans) -> PeriodEnds:
    """Find the position, travel and direction of the clamp at the end of each period."""
    clamp = recording.clamp
    position = recording.position
    last = clamp[spans.ends]
    unseen = spans.cut | spans.passes
    gap = np.where(spans.passes, 0.0, clamp[spans.after] - last)
    step = np.minimum(spans.ends - unseen, len(clamp) - 2)
    sign = recording.direction[np.maximum(step, 0)]
    if position:
        usual = sign * usual_step(recording.smooth)
        same = (np.abs(gap - usual) < ANOTHER_STEP * position) & ~unseen
        last = np.where(same, last + 0.5 * (gap - usual), last)
        gap = np.where(same, usual, gap)
    return PeriodEnds(clamp=last, gap=gap, sign=sign)


class InPeriods(NamedTuple):
    """A recording, divided into periods of sticking.

    Attributes
    ----------
    recording : Recording
        The given recording without lone spikes, up to where the rod buckles laterally.
    spans : Spans
        The periods of sticking, as rows of this recording.
    row : ndarray of int
        Number in the given recording of each row of this one. If the rod buckles laterally, the
        numbers of the rows after the buckling follow.
    """

    recording: Recording
    spans: Spans
    row: IntArray


def find_slips(recording: Recording, noise: FloatArray) -> InPeriods:
    """Find the slips of a recording, and the periods of sticking between them."""
    recording = replace(recording, position=position_noise(recording.clamp))
    spiky = spikes(recording.readings / noise, recording.direction)
    row = np.flatnonzero(~spiky)
    recording = recording.naming(spiky, "a lone spike").take(row)
    falls = np.diff(load_of(recording, noise)) * recording.direction
    spans = _spans(recording, falls)
    why = "periods too short for the noise of the readings (record the moment, or reduce the noise)"
    recording, spans = before_swing(recording.naming(spans.between, why), spans, noise)
    lasts = int(np.median(spans.begins[1:] - spans.ends[:-1])) if len(spans) > 1 else 1
    late = max(int(np.ceil(recording.slip_rows)), lasts)
    if late > 1 or recording.slip_rows:
        # The first and the last sample of a slow slip may not show it.
        recording, spans = _settled(recording, spans, int(lasts > 1), late)
    return InPeriods(recording=recording, spans=spans, row=row)


def load_of(recording: Recording, noise: FloatArray) -> FloatArray:
    """Combine force_x and the moment into one load, relative to its noise, shape (n,).

    This load has the sign of force_x, unlike the load in the description of this module. It
    decreases while a clamp that moves forward bends the rod.
    """
    readings = recording.readings / noise
    way = recording.direction
    loads: list[FloatArray] = []
    if np.isfinite(noise[FORCES]).all():
        loads.append(readings[:, 0])
    if np.isfinite(noise[MOMENT]):
        # The moment shows the load with the other sign, and mostly with less noise.
        loads.append(-readings[:, MOMENT])
    # The weight of each channel is its rise relative to its noise.
    changes = [-np.diff(load) * way for load in loads]
    rises = np.maximum([_usual(change) for change in changes], LEAST_RISE)
    return np.asarray(rises @ loads / np.linalg.norm(rises))


def _usual(changes: FloatArray) -> float:
    """Median; if most changes are 0, as of a coarse resolution, the mean of the middle half."""
    quarter = len(changes) // 4
    middle = np.sort(changes)[quarter : len(changes) - quarter]
    return float(np.median(changes) or middle.mean())


def _settled(recording: Recording, spans: Spans, early: int, late: int) -> tuple[Recording, Spans]:
    """Leave out `early` samples before and `late` samples after each slip; a note names them."""
    begins = np.maximum(spans.begins, np.append(0, spans.after[:-1] + late))
    # A filter lags behind the first steps, too.
    begins[0] = spans.begins[0] + (late if late > 1 else 0)
    ends = spans.ends - early
    ends[-1] = spans.ends[-1]
    settled = replace(spans, begins=begins, ends=ends).take(ends > begins)
    off = np.arange(len(recording)) >= spans.begins[0]
    off[settled.rows[0]] = False
    return recording.naming(off, "the readings have not settled after a slip"), settled
