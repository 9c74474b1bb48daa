"""From a recording to the friction of each period of sticking, with its uncertainty."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from vibrissa.errors import RecordingError
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray, StrArray
from vibrissa.numerics.batch import Batch
from vibrissa.sensor.identification.calibration import Setup
from vibrissa.sensor.identification.doubts import doubts, in_words, notes_of
from vibrissa.sensor.identification.methods import Seen, reader_of
from vibrissa.sensor.identification.periods import (
    MISFIT,
    Channels,
    Partition,
    Samples,
    cut,
    fitted,
    joined_past_lock,
    located,
    lone_spikes,
)
from vibrissa.sensor.identification.recording import USED, Method, Recording, left_out, noise_of
from vibrissa.sensor.identification.uncertainty import (
    HALF_WIDTH,
    Summary,
    common_deviation,
)
from vibrissa.sensor.quantities import chosen
from vibrissa.sensor.slips import SlipLaw
from vibrissa.sensor.transducer import CHANNELS

# If more than this part of the samples is no state of the rod, it is another rod or has a bias.
MOST_OFF = 0.2
# Fewer samples do not make a period and a slip.
FEWEST_SAMPLES = 3
# Less noise than this, in the rod's own units, is none; readings in units of it can be squared.
LEAST_NOISE = 1e-50


class PeriodStatus(StrEnum):
    """What is known about a period.

    Attributes
    ----------
    SLIP
        It ended with a slip: μ0 is known.
    OPEN
        Its end, or for the spacing its beginning, was not recorded: μ0 is at least `low`.
    LOCK
        The tip stuck past the lock: μ0 is above `low`, which is μ_lock.
    UNSURE
        By the spacing, which needs a slip law: `low` and `high` hold for every law.
    BEYOND
        Its last sticking state is none from which this rod slips, or the clamp went further than
        the tip can stick, so that noise has hidden slips: μ0 is not known.
    """

    SLIP = "slip"
    OPEN = "open"
    LOCK = "lock"
    UNSURE = "unsure"
    BEYOND = "beyond"


@dataclass(frozen=True, eq=False, kw_only=True)
class Periods(Batch):
    """Periods of sticking, in their order, each field an array of shape (p,).

    Attributes
    ----------
    status : ndarray of str
        One `PeriodStatus` for each period.
    first, last : ndarray of int
        Rows of the recording in which the period begins and ends.
    first_line, last_line : ndarray of int
        Lines of the file in which these rows stand.
    contact : ndarray
        Position of the tip (L).
    mu0, deviation, low, high : ndarray
        Static friction there, its standard deviation and the central 95 %. Where only a bound is
        known the others are NaN.
    common : ndarray
        Part of the deviation that all periods share, from the uncertainty of the setup; the rest
        is independent.
    doubt : ndarray of str
        Why the friction of a period is in doubt; empty where it is not.
    notes : tuple of str
        What was left out or is in doubt, and why.
    """

    status: StrArray
    first: IntArray
    last: IntArray
    first_line: IntArray
    last_line: IntArray
    contact: FloatArray
    mu0: FloatArray
    deviation: FloatArray
    low: FloatArray
    high: FloatArray
    common: FloatArray
    doubt: StrArray
    notes: tuple[str, ...]


def find_periods(
    setup: Setup,
    recording: Recording,
    noise: FloatArray | None = None,
    *,
    method: Method | str = Method.FORCES,
    step: float | None = None,
    law: SlipLaw | str | None = None,
    kinetic_ratio: float | None = None,
    progress: Callable[[int], None] = lambda done: None,
) -> Periods:
    """Find the periods of sticking in a recording, and the friction of each.

    Does in the rod's own units, and with a known setup, what `vibrissa.sensor.identify` does.

    Parameters
    ----------
    setup : Setup
        From `known_setup` or `calibrate`; its branch covers x0 < 0 if the clamp went backward.
    recording : Recording
    noise : ndarray, shape (3,), optional
        Standard deviation of one reading; estimated from the recording by default.
    method, step, law, kinetic_ratio
        As in `vibrissa.sensor.identify`; the step in units of L.
    progress : callable
        Told how many samples are done.

    Returns
    -------
    Periods

    Raises
    ------
    RecordingError
        If the recording is too short, has no measurable noise, or does not fit the rod.
    ArgumentError
        If an argument is out of range.
    """
    method = chosen(Method, method, "method")
    noise, channels = _channels(recording, method, noise)
    reader = reader_of(method, recording.clamp, step, law, kinetic_ratio)
    samples, notes = _states(setup, recording, channels, progress)
    periods, start = _cut(setup, samples, channels)
    seen, *displaced = (
        Seen.fitted(branch, samples.without(offset), channels, periods, start)
        for branch, offset in ((setup.branch, setup.offset), *setup.displaced)
    )
    common = np.zeros(len(periods))
    if displaced:
        mean, *means = (reader.friction(one, common)[0].mean for one in (seen, *displaced))
        common = common_deviation(mean, means)
    found, unsure = reader.friction(seen, common)
    least = seen.least - HALF_WIDTH * common_deviation(seen.least, [one.least for one in displaced])
    status = _statuses(seen, found, unsure, reader.from_slip)
    found = _where_known(found, status, least, seen)

    reasons = doubts(seen, noise)
    begins, ends = periods.begins, periods.ends
    first_line, last_line = samples.line[begins], samples.line[ends]
    return Periods(
        status=status,
        first=samples.row[begins],
        last=samples.row[ends],
        first_line=first_line,
        last_line=last_line,
        contact=setup.branch.x1_init + seen.contacts.place,
        mu0=found.mean,
        deviation=found.deviation,
        low=found.low,
        high=found.high,
        common=common,
        doubt=in_words(reasons),
        notes=(*notes, *notes_of(reasons, first_line, last_line)),
    )


def _channels(
    recording: Recording, method: Method, noise: FloatArray | None
) -> tuple[FloatArray, Channels]:
    """Noise of all channels, and the channels that are used."""
    used = [i for i in USED[method] if not np.isnan(recording.readings[:, i]).any()]
    _check_size(len(recording) if used else 0)
    noise = noise_of(recording.readings) if noise is None else np.asarray(noise)
    unknown = [CHANNELS[i] for i in used if not LEAST_NOISE < noise[i] < np.inf]
    if unknown:
        raise RecordingError(
            f"the noise of column {', '.join(unknown)} cannot be estimated from the readings: "
            "give the noise"
        )
    return noise, Channels(used=used, noise=noise[used])


def _check_size(rows: int) -> None:
    if rows < FEWEST_SAMPLES:
        raise RecordingError(f"too little to identify friction from: {rows} usable rows")


def _states(
    setup: Setup, recording: Recording, channels: Channels, progress: Callable[[int], None]
) -> tuple[Samples, tuple[str, ...]]:
    """Take the samples that are states of the rod, and note the others."""
    samples = located(setup.branch, recording, channels, setup.offset, progress)
    off = samples.misfit > MISFIT
    if off.mean() > MOST_OFF:
        raise RecordingError(
            f"{off.sum()} of {len(off)} samples are no state of this rod, first in line "
            f"{samples.line[off][0]}: check rod, height, units, zero and noise"
        )
    notes = recording.notes + left_out(samples.line[off], "the reading is no state of this rod")
    samples = samples.take(~off)
    lone = lone_spikes(samples)
    notes += left_out(samples.line[lone], "a lone spike")
    samples = samples.take(~lone)
    _check_size(len(samples))
    return samples, notes


def _cut(setup: Setup, samples: Samples, channels: Channels) -> tuple[Partition, FloatArray]:
    """Cut samples into periods, those joined that belong together; and guess their places (L)."""
    branch, periods, without = setup.branch, cut(samples), samples.without(setup.offset)
    start = periods.sums(samples.place) / periods.counts
    contacts = fitted(branch, without, channels, periods, start)
    own = ~joined_past_lock(branch, without, channels, periods, contacts)
    return periods.take(own), contacts.place[own]


def _statuses(seen: Seen, found: Summary, unsure: BoolArray, from_slip: bool) -> StrArray:
    """Tell what is known about each period, of which `from_slip` needs the slip before it."""
    opened = np.zeros(len(found), dtype=bool)
    opened[-1] = True
    opened[0] |= from_slip
    # Pulled back from past the lock a tip slips after all, but not pushed on.
    locked = seen.locked & (opened | (seen.last.sign > 0.0))
    # A tip that slipped when pushed has not stuck to more than that when it was pulled.
    never = np.isnan(seen.least) | (
        ~(locked | opened) & (seen.last.sign > 0.0) & (seen.least > seen.branch.mu_lock)
    )
    return np.select(
        [never, locked, opened, np.isnan(found.mean), unsure],
        [
            PeriodStatus.BEYOND,
            PeriodStatus.LOCK,
            PeriodStatus.OPEN,
            PeriodStatus.BEYOND,
            PeriodStatus.UNSURE,
        ],
        PeriodStatus.SLIP,
    )


def _where_known(found: Summary, status: StrArray, least: FloatArray, seen: Seen) -> Summary:
    """Keep what the status leaves: the whole distribution, bounds, or a lower bound alone."""
    unsure, unknown = status == PeriodStatus.UNSURE, status == PeriodStatus.BEYOND
    locked = status == PeriodStatus.LOCK
    bounded = locked | (status == PeriodStatus.OPEN)
    least = np.where(locked, np.minimum(least, seen.branch.mu_lock), least)
    # As it slipped, pushed, it did not lock.
    most = np.where(seen.last.sign > 0.0, seen.branch.mu_lock, np.nan)
    return Summary(
        mean=np.where(bounded | unsure | unknown, np.nan, found.mean),
        deviation=np.where(bounded | unsure | unknown, np.nan, found.deviation),
        low=np.select([unknown, bounded], [np.nan, least], found.low),
        high=np.select([bounded | unknown, unsure], [np.nan, most], found.high),
    )
