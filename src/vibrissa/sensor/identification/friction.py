"""From a recording to the friction of each period of sticking, with its uncertainty."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from vibrissa.errors import RecordingError, WrongRodError
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray, StrArray
from vibrissa.numerics.batch import Batch
from vibrissa.sensor.identification.alternatives import Alternative, of_readings
from vibrissa.sensor.identification.calibration import Setup, principal_axes
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
from vibrissa.sensor.identification.misfit.law import apart, remaining_part
from vibrissa.sensor.identification.misfit.mixups import check_columns
from vibrissa.sensor.identification.periods import LEAST_NOISE, Channels
from vibrissa.sensor.identification.reading.kinetic import (
    KineticRatio,
    ratio_after_slips,
    sharing_ratio,
    told_closer,
)
from vibrissa.sensor.identification.reading.methods import (
    AT_REST,
    ON_THE_WAY,
    ByMoment,
    BySpacing,
    reader_of,
)
from vibrissa.sensor.identification.reading.uncertainty import (
    CENTRE,
    HALF_WIDTH,
    Summary,
    common_deviation,
)
from vibrissa.sensor.identification.recording import (
    USED,
    Method,
    Recording,
    check_size,
    left_out,
    noise_of,
)
from vibrissa.sensor.identification.seen import Seen
from vibrissa.sensor.identification.sides import Part, parts_of
from vibrissa.sensor.quantities import OWN_UNITS, Units, chosen
from vibrissa.sensor.simulation.scanning import TipSide
from vibrissa.sensor.simulation.slips import SlipLaw
from vibrissa.sensor.transducer import CHANNELS
from vibrissa.wording import counted

# If more than this part of the samples is no state of the rod, it is another rod or has a bias.
MOST_OFF = 0.2
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
        Its end, or for the spacing its beginning, was not recorded: μ0 is at least `low`.
    LOCK
        The tip stuck past the lock: μ0 is above `low`, which is μ_lock. It did not slip, or the rod
        swung aside: then the slip of the trailing tip tells μ0, in the next row. If that was not
        recorded, `low` is what the trailing tip needed at last, if that is more.
    UNSURE
        By the spacing, which needs a slip law: `low` and `high` hold for every law. By the ratio of
        forces of too few samples: `low` alone.
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
    side : ndarray of str
        One `TipSide` for each period. Where the rod swings aside a period of sticking has two
        parts, a row each.
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
    kinetic : KineticRatio or None
        The ratio of the frictions, where the states after slips have told it; the last of the
        `effects` is of its error.
    """

    status: StrArray
    first: IntArray
    last: IntArray
    first_line: IntArray
    last_line: IntArray
    side: StrArray
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
    kinetic: KineticRatio | None = None

    def __repr__(self) -> str:
        """Say how many there are of each status."""
        each = ", ".join(f"{n} {status}" for status, n in Counter(self.status.tolist()).items())
        return f"{counted(len(self), 'period')}: {each}"


def find_periods(
    setup: Setup,
    recording: Recording,
    noise: FloatArray | None = None,
    *,
    method: Method | str = Method.FORCES,
    step: float | None = None,
    law: SlipLaw | str | None = None,
    kinetic_ratio: float | None = None,
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
        From `known_setup` or `calibrate`; its branch covers x0 < 0 if the clamp went backward.
    recording : Recording
    noise : ndarray, shape (3,), optional
        Standard deviation of one reading; estimated from the recording by default.
    method, step, law, kinetic_ratio
        As in `vibrissa.sensor.identify`; the step in units of L.
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
    method = chosen(Method, method, "method")
    noise_is_given = noise is not None
    noise, channels = _channels(recording, method, noise)
    reader = reader_of(method, recording.clamp, step, law, kinetic_ratio)
    check_columns(setup, recording, Channels.recorded(recording, noise))
    parts = parts_of(setup, recording, channels, progress)
    _check_states(parts, recording, channels, noise, alternatives, units)
    notes = recording.notes + _left_out(parts)
    parts = [part for part in parts if len(part.samples)]
    kinetic = None
    if isinstance(reader, BySpacing) and reader.estimates_ratio:
        # Those of a tip that slips while the stage moves differ by parts of a step; their mean is
        # in the ratio.
        reader = replace(reader, early=ON_THE_WAY)
        kinetic = ratio_after_slips(parts[0].seen(channels))
        parts = [replace(one, setup=sharing_ratio(one.setup, kinetic)) for one in parts]
        notes += (
            f"kinetic_ratio = {kinetic.value:.3f} ± {kinetic.deviation:.2g}, by the states after "
            "slips",
        )
    read = [_read(part, channels, reader) for part in parts]
    found = Periods.concatenate([periods for periods, _ in read])
    seen = [each for _, each in read]
    first, *others = [doubts(one, noise, channels.used) for one in seen]
    reasons = [one.followed_by(rest) for one, *rest in zip(first, *others, strict=True)]
    whole = [_tested(one, noise) for one in seen]
    goodness = Goodness.of(whole, setup.fitted, noise_is_given, setup.penalty)
    goodness = replace(goodness, noisier=noisier(noise_of(recording.readings), noise))
    every = np.ones(len(found), dtype=bool)
    reasons.append(Doubted(doubt=Doubt.WHOLE, periods=every & (not goodness.fits)))
    reasons += [Doubted(doubt=why, channel=what, periods=every) for why, what in doubtful]
    if isinstance(reader, BySpacing):
        found, off_law, more = _beside_states(found, reader, parts, channels, seen)
        reasons += [Doubted(doubt=Doubt.LAW, periods=every & off_law)]
        notes += more
    return replace(
        found,
        kinetic=kinetic,
        grade=graded(reasons),
        doubt=in_words(reasons),
        notes=(*notes, *notes_of(reasons, found.first_line, found.last_line)),
        goodness=goodness,
        causes=() if goodness.fits else likeliest(whole[0], alternatives(), goodness),
    )


def _beside_states(
    found: Periods, reader: BySpacing, parts: Sequence[Part], channels: Channels, seen: list[Seen]
) -> tuple[Periods, bool, tuple[str, ...]]:
    """Compare what the travels give with the last states, which the law does not concern.

    Returns
    -------
    Periods
        Read again if the tip slips while the stage moves.
    bool
        Whether slips do not end as the law says.
    tuple of str
        Notes.
    """
    if reader.law is None:
        say = "without a law for the end of a slip, travels give only bounds of mu0: give law "
        return found, False, (say + " or ".join(SlipLaw),)
    states = Periods.concatenate([_read(one, channels, ByMoment())[0] for one in parts])
    told = apart(found, states, parts[0].setup.shared)
    if not reader.estimates_ratio and reader.law != SlipLaw.ENERGY and told.early != AT_REST:
        other = replace(reader, early=told.early)
        found = Periods.concatenate([_read(one, channels, other)[0] for one in parts])
    if told.off_law:
        needed = [one.states.demand(one.x0)[one.periods.begins] for one in seen]
        part = remaining_part(np.concatenate(needed), states.mu0)
        note = f"after its slips the tip needs {part:.3f} of its friction (kinetic_ratio)"
        return found, True, (note,)
    if reader.kinetic_ratio is not None and reader.law == SlipLaw.KINETIC:
        first = parts[0]
        return found, False, told_closer(reader.kinetic_ratio, first.setup, first.seen(channels))
    return found, False, ()


def _tested(seen: Seen, noise: FloatArray) -> Seen:
    """See by all channels those periods that fit by themselves; all where most do not."""
    alone = np.any(misfits(seen, noise), axis=0)
    kept = ~alone if alone.mean() < MOST_ALONE else np.ones(len(alone), dtype=bool)
    return seen.only(kept).by(Channels.recorded(seen.samples, noise))


def _read(part: Part, channels: Channels, reader: ByMoment) -> tuple[Periods, Seen]:
    """Read the friction of the periods on one side of the clamp, and tell how they were seen."""
    setup, samples = part.setup, part.samples
    periods, start = part.cut(channels)
    seen = Seen.fitted(setup.branch, samples.without(setup.offset), channels, periods, start)
    effects, of_least = _effects(seen, reader, setup.displaced)
    shared = np.eye(effects.shape[1]) if setup.shared is None else setup.shared
    common = common_deviation(effects, shared)
    exact = reader.friction(seen.without_noise(), np.zeros(len(periods)))[0]
    found, unsure = reader.friction(seen, common)
    least = seen.least - HALF_WIDTH * common_deviation(of_least, shared)
    status = _statuses(seen, found, unsure, reader.from_slip)
    found = _where_known(found, status, least, seen, part.swung)
    begins, ends = periods.begins, periods.ends
    known = Periods(
        status=status,
        first=samples.row[begins],
        last=samples.row[ends],
        first_line=samples.line[begins],
        last_line=samples.line[ends],
        side=np.full(len(periods), TipSide.AHEAD if part.side > 0 else TipSide.BEHIND),
        contact=part.side * (setup.branch.x1_init + seen.contacts.place),
        footpoint=part.side * samples.clamp[ends],
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


def _effects(
    seen: Seen, reader: ByMoment, displaced: Sequence[Alternative]
) -> tuple[FloatArray, FloatArray]:
    """Change of each period's friction, and of its lower bound, per unit, shape (p, k) each."""
    none = np.zeros(len(seen.periods))

    def read(other: Alternative) -> FloatArray:
        near = seen.nearby(other)
        return np.array([reader.as_if(other).friction(near, none, CENTRE)[0].mean, near.least])

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


def _channels(
    recording: Recording, method: Method, noise: FloatArray | None
) -> tuple[FloatArray, Channels]:
    """Noise of all channels, and the channels that are used."""
    used = [i for i in USED[method] if not np.isnan(recording.readings[:, i]).any()]
    check_size(len(recording) if used else 0, recording.notes)
    noise = checked_noise(noise_of(recording.readings) if noise is None else noise, used)
    return noise, Channels(used=used, noise=noise[used])


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
    parts: Sequence[Part],
    recording: Recording,
    channels: Channels,
    noise: FloatArray,
    alternatives: Callable[[], Iterable[Alternative]],
    units: Units,
) -> None:
    """Refuse a recording most of whose samples are no states of the rod, and tell why."""
    off = np.concatenate([part.off.line for part in parts])
    size = sum(len(each) for part in parts for each in (part.samples, part.off, part.lone))
    if len(off) <= MOST_OFF * size:
        return
    said = (
        f"{len(off)} of {size} samples are no state of this rod, first in line {off[0]}: check "
        "rod, height, units, zero and noise"
    )
    every = Channels.recorded(recording, noise)
    whole = parts[0].with_all().seen(channels).by(every)
    causes = likeliest(whole, alternatives(), Goodness.of([whole], 0, noise_is_given=True))
    likely = [cause.spelled(units) for cause in causes[:NAMED] if cause.explained > EXPLAINS]
    raise WrongRodError(f"{said}. Likely: {', or '.join(likely)}" if likely else said)


def _left_out(parts: Sequence[Part]) -> tuple[str, ...]:
    """Note the samples that are left out, and where the rod swings aside."""
    notes = left_out(
        np.concatenate([part.off.line for part in parts]), "the reading is no state of this rod"
    )
    notes += left_out(np.concatenate([part.lone.line for part in parts]), "a lone spike")
    check_size(sum(len(part.samples) for part in parts))
    swings = ", ".join(str(part.samples.line[0]) for part in parts[1:] if len(part.samples))
    return (*notes, f"the rod has swung aside: line {swings}") if swings else notes


def _statuses(seen: Seen, found: Summary, unsure: BoolArray, from_slip: bool) -> StrArray:
    """Tell what is known about each period, of which `from_slip` needs the slip before it."""
    opened = np.zeros(len(found), dtype=bool)
    opened[-1] = True
    opened[0] |= from_slip
    # Pulled back from past the lock a tip slips after all, but not pushed on.
    locked = seen.locked & (opened | (seen.last.sign > 0.0))
    # A tip that slipped when pushed has not stuck to more than that when it was pulled.
    never = np.isnan(seen.least) | (
        ~(locked | opened) & (seen.last.sign > 0.0) & (seen.least > seen.ending.mu_lock)
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


def _where_known(
    found: Summary, status: StrArray, least: FloatArray, seen: Seen, swung: bool
) -> Summary:
    """Keep what the status leaves: the whole distribution, bounds, or a lower bound alone."""
    unsure, unknown = status == PeriodStatus.UNSURE, status == PeriodStatus.BEYOND
    locked = status == PeriodStatus.LOCK
    bounded = locked | (status == PeriodStatus.OPEN)
    if not swung:  # a trailing tip that is pulled needs more in the end
        least = np.where(locked, np.minimum(least, seen.ending.mu_lock), least)
    # As it slipped, pushed, it did not lock.
    most = np.where(seen.last.sign > 0.0, seen.ending.mu_lock, np.nan)
    return Summary(
        mean=np.where(bounded | unsure | unknown, np.nan, found.mean),
        deviation=np.where(bounded | unsure | unknown, np.nan, found.deviation),
        low=np.select([unknown, bounded], [np.nan, least], found.low),
        high=np.select([bounded | unknown, unsure], [np.nan, most], found.high),
    )
