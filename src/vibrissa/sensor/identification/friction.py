"""From a recording to the friction of each period of sticking, with its uncertainty."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from vibrissa.errors import RecordingError, WrongRodError
from vibrissa.numerics.arrays import FloatArray, IntArray, StrArray
from vibrissa.numerics.batch import Batch
from vibrissa.sensor.identification.alternatives import Alternative, of_readings
from vibrissa.sensor.identification.misfit.doubts import (
    Doubt,
    Doubted,
    doubts,
    graded,
    in_words,
    misfits,
    notes_of,
)
from vibrissa.sensor.identification.misfit.goodness import Cause, Goodness, likeliest, noisier
from vibrissa.sensor.identification.misfit.mixups import check_columns
from vibrissa.sensor.identification.part import Part, before_swing
from vibrissa.sensor.identification.periods import LEAST_NOISE, MISFIT, Channels
from vibrissa.sensor.identification.reading.uncertainty import (
    CENTRE,
    HALF_WIDTH,
    Summary,
    common_deviation,
    friction_of,
)
from vibrissa.sensor.identification.recording import (
    Recording,
    check_size,
    left_out,
    noise_of,
    suffices,
)
from vibrissa.sensor.identification.seen import Seen
from vibrissa.sensor.identification.setup import Setup, principal_axes
from vibrissa.sensor.quantities import OWN_UNITS, Units
from vibrissa.sensor.transducer import CHANNELS
from vibrissa.wording import counted

# A sample is no state of the rod if its readings differ by more than this part of them from the
# nearest one, and by more than noise. If more than this part of the samples is none, it is another
# rod or has a bias. Recordings that differ by less are read, and in doubt.
MOST_MISFIT, MOST_OFF = 0.1, 0.2
# So many causes are named for a recording that is refused, if each explains this part of χ².
NAMED, EXPLAINS = 3, 0.9
# From this part on that does not fit by itself, no period is left out of the test of the whole.
MOST_ALONE = 0.5


class PeriodStatus(StrEnum):
    """What is known about a period.

    Attributes
    ----------
    SLIP
        It ended with a slip: μ0 is known.
    OPEN
        Its end was not recorded: μ0 is at least `low`.
    LOCK
        The tip stuck past the lock: μ0 is above `low`, which is at most μ_lock. It did not slip, or
        the rod swung aside; a recording is read up to there.
    UNSURE
        By the ratio of the forces of too few samples: `low` alone is known.
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
        Position of the tip (L); NaN where it is not known, without a rod.
    footpoint : ndarray
        Position of the clamp in the last sample (L).
    mu0, deviation, low, high : ndarray
        Static friction there, its standard deviation and the central 95 %. Where only a bound is
        known the others are NaN.
    common : ndarray
        Part of the deviation that all periods share, from the uncertainty of the setup; the rest
        is independent.
    by_step : ndarray
        Part of the deviation by the step of the stage.
    effects : ndarray, shape (p, k)
        Change of μ0 per unit of each of k things that are not known exactly.
    shifts : ndarray, shape (p, q)
        By how much μ0 would be larger if the setup were one standard deviation away along each of
        its principal axes. The root of the sum of the squares is `common`.
    grade : ndarray of str
        `Grade` of the worst doubt; empty where there is none.
    doubt : ndarray of str
        The doubts in words.
    notes : tuple of str
        What was left out or is in doubt, and why.
    goodness : Goodness
        Whether the recording fits what was given, but for periods that do not by themselves.
    causes : tuple of Cause
        What may be other than it was given, the likeliest first; none where the recording fits.
    """

    status: StrArray
    first: IntArray
    last: IntArray
    first_line: IntArray
    last_line: IntArray
    contact: FloatArray
    footpoint: FloatArray
    mu0: FloatArray
    deviation: FloatArray
    low: FloatArray
    high: FloatArray
    common: FloatArray
    by_step: FloatArray
    effects: FloatArray
    shifts: FloatArray
    grade: StrArray
    doubt: StrArray
    notes: tuple[str, ...] = ()
    goodness: Goodness | None = None
    causes: tuple[Cause, ...] = ()

    def __repr__(self) -> str:
        """Say how many there are of each status."""
        each = ", ".join(f"{n} {status}" for status, n in Counter(self.status.tolist()).items())
        return f"{counted(len(self), 'period')}: {each}"


def find_periods(
    setup: Setup,
    recording: Recording,
    noise: FloatArray | None = None,
    *,
    alternatives: Callable[[], Iterable[Alternative]] = of_readings,
    doubtful: Sequence[tuple[Doubt, str]] = (),
    units: Units = OWN_UNITS,
    progress: Callable[[int], None] = lambda done: None,
) -> Periods:
    """Find the periods of sticking in a recording, and the friction of each.

    Does in the rod's own units, and with a known setup, what `vibrissa.sensor.identify` does.

    Parameters
    ----------
    setup : Setup
        Its branch covers x0 < 0 if the clamp went backward.
    recording : Recording
    noise : ndarray, shape (3,), optional
        Standard deviation of one reading; estimated from the recording by default. A channel with a
        noise of 0 is not used.
    alternatives : callable
        Gives what may be other than it was given; asked where the recording does not fit.
    doubtful : sequence of (Doubt, str)
        Reasons to doubt every period, which are known beforehand, and what each concerns.
    units : Units
        In which a message names them.
    progress : callable
        Told how many samples are done.

    Returns
    -------
    Periods

    Raises
    ------
    RecordingError
        If the recording is too short, has no measurable noise, or does not fit the rod, or its
        columns are mixed up.
    ArgumentError
        If an argument is out of range.
    """
    noise_is_given = noise is not None
    noise, channels = _channels(recording, noise)
    branch = setup.branch
    check_columns(branch, recording, channels)
    recording = before_swing(branch, recording, channels)
    part = Part.of(branch, recording, channels, progress)
    _check_states(part, channels, alternatives, units)
    notes = recording.notes + _left_out(part)
    found, seen = _read(setup, part, channels)
    reasons = doubts(seen, noise)
    tested = _tested(seen, noise)
    goodness = Goodness.of(tested, noise_is_given, setup.penalty)
    goodness = replace(goodness, noisier=noisier(noise_of(recording.readings), noise))
    every = np.ones(len(found), dtype=bool)
    reasons.append(Doubted(doubt=Doubt.WHOLE, periods=every & (not goodness.fits)))
    reasons += [Doubted(doubt=why, channel=what, periods=every) for why, what in doubtful]
    return replace(
        found,
        grade=graded(reasons),
        doubt=in_words(reasons),
        notes=(*notes, *notes_of(reasons, found.first_line, found.last_line)),
        goodness=goodness,
        causes=() if goodness.fits else likeliest(tested, alternatives(), goodness),
    )


def _tested(seen: Seen, noise: FloatArray) -> Seen:
    """Keep those periods that fit by themselves; all where most do not."""
    alone = np.any(misfits(seen, noise), axis=0)
    return seen.only(~alone) if alone.mean() < MOST_ALONE else seen


def _read(setup: Setup, part: Part, channels: Channels) -> tuple[Periods, Seen]:
    """Read the friction of the periods, and tell how they were seen."""
    seen, samples = part.seen(channels), part.samples
    periods = seen.periods
    effects, of_least = _effects(seen, setup.displaced)
    shared = np.eye(effects.shape[1]) if setup.shared is None else setup.shared
    common = common_deviation(effects, shared)
    without = seen.without_noise()
    exact = friction_of(without.branch, without.last, np.zeros(len(periods)))
    found = friction_of(seen.branch, seen.last, common)
    least = seen.least - HALF_WIDTH * common_deviation(of_least, shared)
    status = _statuses(seen, found)
    found = _where_known(found, status, least, seen)
    begins, ends = periods.begins, periods.ends
    known = Periods(
        status=status,
        first=samples.row[begins],
        last=samples.row[ends],
        first_line=samples.line[begins],
        last_line=samples.line[ends],
        contact=setup.branch.x1_init + seen.contacts.place,
        footpoint=samples.clamp[ends],
        mu0=found.mean,
        deviation=found.deviation,
        low=found.low,
        high=found.high,
        common=common,
        by_step=np.where(np.isnan(found.mean), np.nan, exact.deviation),
        effects=effects,
        shifts=effects @ principal_axes(shared).T,
        grade=np.full(len(periods), ""),
        doubt=np.full(len(periods), ""),
    )
    return known, seen


def _effects(seen: Seen, displaced: Sequence[Alternative]) -> tuple[FloatArray, FloatArray]:
    """Change of each period's friction, and of its lower bound, per unit, shape (p, k) each."""
    none = np.zeros(len(seen.periods))

    def read(other: Alternative) -> FloatArray:
        near = seen.nearby(other)
        return np.array([friction_of(near.branch, near.last, none, CENTRE).mean, near.least])

    found = np.zeros((2, len(none), len(displaced)))
    bases: dict[int, FloatArray] = {}
    for number, other in enumerate(displaced):
        key = id(other.base)
        if key not in bases:
            bases[key] = read(other.before)
        found[:, :, number] = (read(other) - bases[key]) / other.step
    # Where the change leads out of what this rod can have, it is taken as large as elsewhere.
    largest = np.nanmax(np.abs(np.nan_to_num(found, posinf=0.0, neginf=0.0)), axis=1, initial=0.0)
    effects, of_least = np.where(np.isfinite(found), found, largest[:, None])
    return effects, of_least


def _channels(recording: Recording, noise: FloatArray | None) -> tuple[FloatArray, Channels]:
    """Noise of all channels, and those that are used: recorded ones that have a noise."""
    there = np.flatnonzero(np.isfinite(recording.readings).all(axis=0))
    check_size(len(recording) if len(there) else 0, recording.notes)
    noise = noise_of(recording.readings) if noise is None else noise
    channels = Channels.recorded(recording, noise)
    if not suffices(channels.used):
        checked_noise(noise, there.tolist())
        raise RecordingError(
            "the model needs moment_z, or force_x and force_y: record them, and give their noise"
        )
    return noise, channels


def checked_noise(noise: FloatArray, used: Sequence[int]) -> FloatArray:
    """Refuse noise that is none, of the channels that are used."""
    unknown = [CHANNELS[i] for i in used if not LEAST_NOISE < noise[i] < np.inf]
    if unknown:
        raise RecordingError(
            f"the noise of column {', '.join(unknown)} is 0, or cannot be estimated from the "
            "readings: look whether the channel was recorded, and give the noise"
        )
    return np.asarray(noise)


def _check_states(
    part: Part,
    channels: Channels,
    alternatives: Callable[[], Iterable[Alternative]],
    units: Units,
) -> None:
    """Refuse a recording most of whose samples are no states of the rod, and tell why."""
    every = part.with_all()
    samples = every.samples
    size = (channels.weighted(samples.readings) ** 2).sum(axis=1)
    off = samples.misfit > np.maximum(MISFIT, MOST_MISFIT**2 * size)
    if off.sum() <= MOST_OFF * len(samples):
        return
    said = (
        f"{off.sum()} of {len(samples)} samples are no state of this rod, first in line "
        f"{samples.line[off][0]}: check rod, height, units, zero and noise"
    )
    whole = every.seen(channels)
    causes = likeliest(whole, alternatives(), Goodness.of(whole, noise_is_given=True))
    likely = [cause.spelled(units) for cause in causes[:NAMED] if cause.explained > EXPLAINS]
    raise WrongRodError(f"{said}. Likely: {', or '.join(likely)}" if likely else said)


def _left_out(part: Part) -> tuple[str, ...]:
    """Note the samples that are left out."""
    notes = left_out(part.off.line, "the reading is no state of this rod")
    notes += left_out(part.lone.line, "a lone spike")
    check_size(len(part.samples))
    return notes


def _statuses(seen: Seen, found: Summary) -> StrArray:
    """Tell what is known about each period."""
    opened = np.zeros(len(found), dtype=bool)
    opened[-1] = True
    # Pulled back from past the lock a tip slips after all, but not pushed on.
    locked = seen.locked & (opened | (seen.last.sign > 0.0))
    # A tip that slipped when pushed has not stuck to more than that when it was pulled.
    never = np.isnan(seen.least) | (
        ~(locked | opened) & (seen.last.sign > 0.0) & (seen.least > seen.ending.mu_lock)
    )
    return np.select(
        [never, locked, opened, np.isnan(found.mean)],
        [PeriodStatus.BEYOND, PeriodStatus.LOCK, PeriodStatus.OPEN, PeriodStatus.BEYOND],
        PeriodStatus.SLIP,
    )


def _where_known(found: Summary, status: StrArray, least: FloatArray, seen: Seen) -> Summary:
    """Keep what the status leaves: the whole distribution, a lower bound alone, or nothing."""
    unknown = status == PeriodStatus.BEYOND
    locked = status == PeriodStatus.LOCK
    bounded = locked | (status == PeriodStatus.OPEN)
    least = np.where(locked, np.minimum(least, seen.ending.mu_lock), least)
    return Summary(
        mean=np.where(bounded | unknown, np.nan, found.mean),
        deviation=np.where(bounded | unknown, np.nan, found.deviation),
        low=np.select([unknown, bounded], [np.nan, least], found.low),
        high=np.where(bounded | unknown, np.nan, found.high),
    )
