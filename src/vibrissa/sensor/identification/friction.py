"""From a recording to the friction of each period of sticking, with its uncertainty."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from vibrissa.errors import RecordingError
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray, StrArray
from vibrissa.numerics.batch import Batch
from vibrissa.sensor.identification.calibration import Setup
from vibrissa.sensor.identification.doubts import doubts, in_words, notes_of
from vibrissa.sensor.identification.methods import ByMoment, Seen, reader_of
from vibrissa.sensor.identification.periods import Channels
from vibrissa.sensor.identification.recording import USED, Method, Recording, left_out, noise_of
from vibrissa.sensor.identification.sides import Part, parts_of
from vibrissa.sensor.identification.uncertainty import (
    HALF_WIDTH,
    Summary,
    common_deviation,
)
from vibrissa.sensor.quantities import chosen
from vibrissa.sensor.scanning import TipSide
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
        The tip stuck past the lock: μ0 is above `low`, which is μ_lock. It did not slip, or the rod
        swung aside: then the slip of the trailing tip tells μ0, in the next row. If that was not
        recorded, `low` is what the trailing tip needed at last, if that is more.
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
    side : ndarray of str
        One `TipSide` for each period. Where the rod swings aside a period of sticking has two
        parts, a row each.
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
    side: StrArray
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
    parts = parts_of(setup, recording, channels, progress)
    notes = recording.notes + _left_out(parts)
    read = [_read(part, channels, reader, noise) for part in parts if len(part.samples)]
    reasons = {why: np.concatenate([each[why] for _, each in read]) for why in read[0][1]}
    found = Periods.concatenate([periods for periods, _ in read])
    return replace(
        found,
        doubt=in_words(reasons),
        notes=(*notes, *notes_of(reasons, found.first_line, found.last_line)),
    )


def _read(
    part: Part, channels: Channels, reader: ByMoment, noise: FloatArray
) -> tuple[Periods, dict[str, BoolArray]]:
    """Read the friction of the periods on one side of the clamp, and the reasons to doubt it."""
    setup, samples = part.setup, part.samples
    periods, start = part.cut(channels)
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
        mu0=found.mean,
        deviation=found.deviation,
        low=found.low,
        high=found.high,
        common=common,
        doubt=np.full(len(periods), ""),
        notes=(),
    )
    return known, doubts(seen, noise)


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


def _left_out(parts: Sequence[Part]) -> tuple[str, ...]:
    """Note the samples that are left out, and where the rod swings aside."""
    off = np.concatenate([part.off.line for part in parts])
    lone = np.concatenate([part.lone.line for part in parts])
    left = sum(len(part.samples) for part in parts)
    if len(off) > MOST_OFF * (len(off) + len(lone) + left):
        raise RecordingError(
            f"{len(off)} of {len(off) + len(lone) + left} samples are no state of this rod, first "
            f"in line {off[0]}: check rod, height, units, zero and noise"
        )
    notes = left_out(off, "the reading is no state of this rod")
    notes += left_out(lone, "a lone spike")
    _check_size(left)
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
