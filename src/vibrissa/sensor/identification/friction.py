"""From a recording to the friction of each period of sticking, with its uncertainty."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from scipy.ndimage import find_objects, label

from vibrissa.errors import ArgumentError, RecordingError
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray, StrArray
from vibrissa.numerics.batch import Batch
from vibrissa.sensor.identification.calibration import Setup
from vibrissa.sensor.identification.doubts import doubts
from vibrissa.sensor.identification.energy import FEWEST, read_travels
from vibrissa.sensor.identification.periods import (
    MISFIT,
    Channels,
    Contacts,
    Partition,
    Samples,
    cut,
    fitted,
    joined_past_lock,
    located,
    lone_spikes,
)
from vibrissa.sensor.identification.recording import USED, Method, Recording, left_out, noise_of
from vibrissa.sensor.identification.spacing import spacing
from vibrissa.sensor.identification.uncertainty import (
    HALF_WIDTH,
    LastStates,
    Summary,
    common_deviation,
    friction_of,
    least_friction,
    normal_summary,
    ratio_deviation,
)
from vibrissa.sensor.quantities import chosen
from vibrissa.sensor.response import Branch
from vibrissa.sensor.slips import SlipLaw
from vibrissa.sensor.transducer import CHANNELS

# If more than this part of the samples is no state of the rod, it is another rod or has a bias.
MOST_OFF = 0.2
# Fewer samples do not make a period and a slip.
FEWEST_SAMPLES = 3
# Less noise than this, in the rod's own units, is none; readings in units of it can be squared.
LEAST_NOISE = 1e-50
# Lines of so many periods are named in a note.
NAMED = 3


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


@dataclass(frozen=True, kw_only=True)
class _Slips:
    """What is known of the slips, for the spacing: step of the stage (L), slip law and μk/μ0."""

    step: float
    law: SlipLaw | None
    kinetic_ratio: float | None


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
    slips = None
    if method is Method.SPACING:
        law = None if law is None else chosen(SlipLaw, law, "law")
        slips = _Slips(
            step=_stage_step(recording.clamp, step), law=law, kinetic_ratio=kinetic_ratio
        )
    samples, notes = _states(setup, recording, channels, progress)
    recorded = _cut(setup, samples, channels, method)

    seen = recorded.seen(setup.branch, setup.offset)
    moved = [recorded.seen(branch, offset) for branch, offset in setup.displaced]
    common = np.zeros(len(recorded.periods))
    if moved:
        means = [_friction(other, slips, common)[0].mean for other in moved]
        common = common_deviation(_friction(seen, slips, common)[0].mean, means)
    found, unsure = _friction(seen, slips, common)
    least = seen.least - HALF_WIDTH * common_deviation(seen.least, [o.least for o in moved])
    status = _statuses(seen, found, unsure, from_slip=slips is not None)
    found = _where_known(found, status, least, seen)

    reasons = doubts(
        setup.branch, samples.without(setup.offset), noise, recorded.periods, seen.contacts
    )
    begins, ends = recorded.periods.begins, recorded.periods.ends
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
        doubt=_in_words(reasons),
        notes=(*notes, *_in_doubt(reasons, first_line, last_line)),
    )


def _stage_step(clamp: FloatArray, step: float | None) -> float:
    """Step of the stage: the given one, or the usual distance of successive positions."""
    if step is not None:
        if not step > 0.0:
            raise ArgumentError(f"step must be positive, got {step!r}")
        return step
    moved = np.abs(np.diff(clamp))
    if not moved.any():
        raise RecordingError("the clamp never moves: column footpoint has one value")
    return float(np.median(moved[moved > 0.0]))


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


def _cut(setup: Setup, samples: Samples, channels: Channels, method: Method) -> "_Recorded":
    """Cut samples into periods, those joined that belong together."""
    periods = cut(samples)
    start = periods.sums(samples.place) / periods.counts
    without = samples.without(setup.offset)
    contacts = fitted(setup.branch, without, channels, periods, start)
    own = ~joined_past_lock(setup.branch, without, channels, periods, contacts)
    return _Recorded(
        method=method,
        samples=samples,
        channels=channels,
        periods=periods.take(own),
        start=contacts.place[own],
    )


@dataclass(frozen=True, eq=False, kw_only=True)
class _Seen:
    """Periods as one setup shows them: contacts, least friction and locks (p,), last states."""

    branch: Branch
    contacts: Contacts
    least: FloatArray
    locked: BoolArray
    last: LastStates


@dataclass(frozen=True, eq=False, kw_only=True)
class _Recorded:
    """Samples (with offsets) cut into p periods, and a first guess of their places (L, (p,))."""

    method: Method
    samples: Samples
    channels: Channels
    periods: Partition
    start: FloatArray

    def seen(self, branch: Branch, offset: FloatArray) -> _Seen:
        """Read the periods with a branch, and offsets of the channels."""
        samples, periods = self.samples.without(offset), self.periods
        contacts = fitted(branch, samples, self.channels, periods, self.start)
        low = np.minimum.reduceat(samples.clamp, periods.begins) - contacts.place
        high = np.maximum.reduceat(samples.clamp, periods.begins) - contacts.place
        return _Seen(
            branch=branch,
            contacts=contacts,
            least=least_friction(branch, low, high, contacts.deviation),
            locked=high - HALF_WIDTH * contacts.deviation >= branch.x0_lock,
            last=self._last_states(branch, samples, contacts),
        )

    def _last_states(self, branch: Branch, samples: Samples, contacts: Contacts) -> LastStates:
        clamp, ends = samples.clamp, self.periods.ends
        x0 = clamp[ends] - contacts.place
        gap = clamp[np.minimum(ends + 1, len(clamp) - 1)] - clamp[ends]
        none = np.zeros(len(ends))
        by_moment = LastStates(
            travel=x0,
            deviation=contacts.deviation,
            gap=gap,
            gap_before=none,
            sign=np.where(gap == 0.0, np.sign(x0), np.sign(gap)),
            base=none,
            ratio_deviation=none,
        )
        if self.method is Method.SPACING:
            travel = clamp[ends] - clamp[self.periods.begins]
            gap_before = np.append(0.0, gap[:-1])
            return replace(by_moment, travel=travel, deviation=none, gap_before=gap_before)
        if self.method is Method.FORCES:
            # The ratio is measured in the last sticking state; the model says how it goes on.
            fx, fy, _ = samples.readings[ends].T
            modelled = branch.demand(np.clip(x0, branch.x0_pull, branch.x0_end))
            error = ratio_deviation(fx, fy, *self.channels.noise)
            return replace(
                by_moment, deviation=none, base=fx / fy - modelled, ratio_deviation=error
            )
        return by_moment


def _friction(seen: _Seen, slips: _Slips | None, common: FloatArray) -> tuple[Summary, BoolArray]:
    """Friction of every period, and for which of them only bounds are known."""
    if slips is None:
        return friction_of(seen.branch, seen.last, common), np.zeros(len(common), dtype=bool)
    last = seen.last
    before = np.append(0.0, last.sign[:-1])
    relation = spacing(seen.branch, slips.law, slips.kinetic_ratio)
    found = friction_of(
        seen.branch,
        last,
        common,
        slips.step,
        lambda travel, part: relation.onset(travel, before[part], last.sign[part]),
    )
    unsure = relation.gives_bounds(before, last.sign)
    if slips.law is SlipLaw.ENERGY and slips.kinetic_ratio is not None:
        for run in _runs(last, slips.step):
            read = _run(seen, run, slips.kinetic_ratio, common)
            rows = np.arange(run.start, run.stop)[~np.isnan(read.mean)]
            found.put(rows, read.take(~np.isnan(read.mean)))
            unsure[rows] = False
    return found, unsure


def _runs(last: LastStates, step: float) -> list[slice]:
    """Periods in a row that end by slips forward in single steps, enough to be read together."""
    plain = (last.sign > 0.0) & (last.gap > 0.5 * step) & (last.gap < 1.5 * step)
    runs = [run for (run,) in find_objects(label(plain)[0])]
    return [run for run in runs if run.stop - run.start >= FEWEST]


def _run(seen: _Seen, run: slice, kinetic_ratio: float, common: FloatArray) -> Summary:
    """Friction of a run of periods by the energy law; NaN where it is not known."""
    last = seen.last.take(run)
    mean, own = read_travels(
        seen.branch, kinetic_ratio, last.travel, last.gap, seen.contacts.place[run]
    )
    # What came before the first of them is not known.
    mean[0] = np.nan
    return normal_summary(seen.branch, mean, np.hypot(own, common[run]))


def _statuses(seen: _Seen, found: Summary, unsure: BoolArray, from_slip: bool) -> StrArray:
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


def _where_known(found: Summary, status: StrArray, least: FloatArray, seen: _Seen) -> Summary:
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


def _in_words(reasons: dict[str, BoolArray]) -> StrArray:
    """Reasons to doubt each period, separated by semicolons."""
    rows = np.array(list(reasons.values())).T
    return np.array(["; ".join(np.array(list(reasons))[row]) for row in rows])


def _in_doubt(
    reasons: dict[str, BoolArray], first_line: IntArray, last_line: IntArray
) -> tuple[str, ...]:
    """One line for each reason to doubt, with the lines of the first periods that it concerns."""
    notes = []
    for why, periods in reasons.items():
        lines = list(zip(first_line[periods], last_line[periods], strict=True))
        if lines:
            shown = ", ".join(f"{first}-{last}" for first, last in lines[:NAMED])
            more = ", ..." if lines[NAMED:] else ""
            notes.append(
                f"in doubt, {why}: {len(lines)} of {len(periods)} periods, line {shown}{more}"
            )
    return tuple(notes)
