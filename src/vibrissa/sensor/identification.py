"""From signals back to friction: periods of sticking, and μ0 of each with its uncertainty."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np
from scipy.stats import norm

from vibrissa.arrays import BoolArray, FloatArray, IntArray
from vibrissa.sensor import series
from vibrissa.sensor.calibration import Setup, known_setup
from vibrissa.sensor.doubts import doubts
from vibrissa.sensor.quantities import Kind, Units
from vibrissa.sensor.response import Branch
from vibrissa.sensor.scanning import SlipLaw
from vibrissa.sensor.spacing import spacing
from vibrissa.sensor.sticking import (
    MISFIT,
    fitted,
    jumps,
    located,
    lone_spikes,
    same_contact,
)
from vibrissa.sensor.texture import FEWEST, read_travels
from vibrissa.sensor.transducer import CHANNELS, Transducer
from vibrissa.sensor.uncertainty import (
    LastStates,
    Summary,
    common_deviation,
    friction_of,
    least_friction,
    normal_summary,
    ratio_deviation,
)

# More than this part of the samples off the rod's response: it is another rod, or has an offset.
MOST_OFF = 0.2
# Readings beyond this, in the rod's own units, are none; squares of smaller ones are finite.
LARGEST = 1e100
# Standard deviations on either side of the mean that hold 95 % of a normal distribution.
TWO_SIDED = float(norm.ppf(0.975))


class Method(StrEnum):
    """How μ0 is found.

    Attributes
    ----------
    FORCES
        The ratio of the forces in the last sticking state; the rod's model only says how much the
        ratio grows within a step.
    MOMENT
        The moment alone: all samples of a period, through the rod's model.
    SPACING
        The clamp's travel from slip to slip, which depends on where slips end (the slip law).
    """

    FORCES = "forces"
    MOMENT = "moment"
    SPACING = "spacing"


class Found(StrEnum):
    """What is known of a period.

    Attributes
    ----------
    SLIP
        It ended with a slip: μ0 is known.
    OPEN
        Its end, or for the spacing its beginning, was not recorded: μ0 is at least `low`.
    LOCK
        The tip stuck past the lock: μ0 is above `low`, which is μ_lock; how far is not known.
    UNSURE
        By the spacing, which needs a slip law: `low` and `high` hold for every law.
    BEYOND
        Its last sticking state lies outside the states in which this rod slips: no μ0.
    """

    SLIP = "slip"
    OPEN = "open"
    LOCK = "lock"
    UNSURE = "unsure"
    BEYOND = "beyond"


# What each method reads.
READS = {Method.FORCES: [0, 1], Method.MOMENT: [2], Method.SPACING: [0, 1, 2]}


@dataclass(frozen=True, eq=False)
class Recording:
    """A measured time series, nondimensional.

    Attributes
    ----------
    footpoint : ndarray, shape (n,)
        Clamp positions (L).
    readings : ndarray, shape (n, 3)
        fx, fy (E·I0/L²) and m (E·I0/L); NaN where missing.
    line : ndarray of int, shape (n,)
        Where each stands in its file.
    notes : tuple of str
        What was left out, and why.
    """

    footpoint: FloatArray
    readings: FloatArray
    line: IntArray
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Periods:
    """Periods of sticking, in their order.

    Attributes
    ----------
    status : list of Found
    first, last : ndarray of int
        Rows of the recording in which the period begins and ends.
    contact : ndarray
        Position of the tip (L).
    mu0, deviation, low, high : ndarray
        Static friction there, its standard deviation and the central 95 %. Where only a bound is
        known the others are NaN.
    common : ndarray
        Part of the deviation that all periods share, from the setup's uncertainty; the rest is
        their own.
    notes : tuple of str
        What was left out or is in doubt, and why.
    doubt : list of str
        Why the friction of each period is in doubt; empty where it is not.
    """

    status: list[Found]
    first: IntArray
    last: IntArray
    contact: FloatArray
    mu0: FloatArray
    deviation: FloatArray
    low: FloatArray
    high: FloatArray
    common: FloatArray
    notes: tuple[str, ...]
    doubt: list[str]


def read_recording(
    path: Path, units: Units, method: Method, transducer: Transducer | None = None
) -> Recording:
    """Read a time series from a table with columns such as ``footpoint [mm],force_x [N]``.

    Parameters
    ----------
    path : Path
        CSV or Parquet; columns ``footpoint`` and those that the method reads, each with its unit;
        an optional ``time`` must increase.
    units : Units
    method : Method
    transducer : Transducer, optional
        Whose limits tell which readings are saturated.

    Returns
    -------
    Recording
        Without rows that miss a value or are saturated; its notes name their lines.

    Raises
    ------
    ValueError
        If the table cannot be used; the message names the line.
    """
    names = ["footpoint", *(CHANNELS[i] for i in READS[method])]
    spare = [name for name in CHANNELS if name not in names]
    table = series.read(path, names, ["time", *spare])
    if "time" in table.columns:
        late = np.flatnonzero(~(np.diff(table.columns["time"]) > 0.0))
        if len(late):
            raise ValueError(
                f"{table.place(int(late[0]) + 1)}: time does not increase; sort the table, or "
                "leave the column out"
            )
    kinds = dict(zip(["footpoint", *CHANNELS], "length force force moment".split(), strict=True))
    readings = np.full((len(table.line), 3), np.nan)
    for name in [*names, *(name for name in spare if name in table.columns)]:
        if name not in table.units:
            raise ValueError(f"{path}, line 1: {name} needs its unit, as in '{name} [mm]'")
        factor = units.column_factor(table.units[name], Kind(kinds[name]), f"{path}: {name}")
        with np.errstate(over="ignore"):
            table.columns[name] *= factor
        large = np.flatnonzero(np.abs(table.columns[name]) > LARGEST)
        if len(large):
            raise ValueError(
                f"{table.place(int(large[0]))}: {name} must be a reading, got one of more than "
                f"{LARGEST:g} of the rod's own units"
            )
        if name != "footpoint":
            readings[:, CHANNELS.index(name)] = table.columns[name]
    used = READS[method]
    missing = np.isnan(table.columns["footpoint"]) | np.isnan(readings[:, used]).any(axis=1)
    notes = _note(table.line[missing], "a value is missing")
    keep = ~missing
    if transducer is not None:
        scale = [units.unit(kind) for kind in (Kind.FORCE, Kind.FORCE, Kind.MOMENT)]
        full = transducer.saturated(readings * scale)[:, used].any(axis=1) & keep
        notes += _note(table.line[full], "the transducer is saturated")
        keep &= ~full
    return Recording(table.columns["footpoint"][keep], readings[keep], table.line[keep], notes)


def _note(lines: IntArray, why: str) -> tuple[str, ...]:
    if not len(lines):
        return ()
    shown = ", ".join(str(line) for line in lines[:5]) + (", ..." if len(lines) > 5 else "")
    return (f"{why} in {len(lines)} rows, left out: line {shown}",)


def _doubtful(doubt: list[str], first: IntArray, last: IntArray) -> tuple[str, ...]:
    """One line for each reason to doubt, with the lines of the first periods in doubt for it."""
    notes = []
    for why in dict.fromkeys(why for reasons in doubt for why in reasons.split("; ") if why):
        of = [i for i, reasons in enumerate(doubt) if why in reasons.split("; ")]
        shown = ", ".join(f"{first[i]}-{last[i]}" for i in of[:3]) + (", ..." if of[3:] else "")
        notes.append(f"in doubt, {why}: {len(of)} of {len(doubt)} periods, line {shown}")
    return tuple(notes)


def noise_of(readings: FloatArray) -> FloatArray:
    """Estimate the standard deviation of each channel's noise from its second differences.

    Parameters
    ----------
    readings : ndarray, shape (n, 3)

    Returns
    -------
    ndarray, shape (3,)
        Slips do not count, as they are outliers among the differences. NaN for a channel with a
        missing value.
    """
    second = np.abs(np.diff(readings, n=2, axis=0))
    rough = np.median(second, axis=0) / norm.ppf(0.75)
    usual = second <= 4.0 * rough
    squares, number = np.where(usual, second**2, 0.0).sum(axis=0), usual.sum(axis=0)
    unknown = np.full(len(number), np.nan)
    return np.sqrt(np.divide(squares, 6.0 * number, out=unknown, where=number > 0))


def noise_for(recording: Recording, deviation: FloatArray | None = None) -> FloatArray:
    """Noise of the readings: what is given, or else estimated from the recording, shape (3,)."""
    return noise_of(recording.readings) if deviation is None else np.asarray(deviation)


def identify(
    rod: Branch | Setup,
    recording: Recording,
    deviation: FloatArray | None = None,
    method: Method | str = Method.FORCES,
    step: float | None = None,
    law: SlipLaw | str | None = None,
    kinetic_ratio: float | None = None,
    progress: Callable[[int], None] = lambda done: None,
) -> Periods:
    """Find the periods of sticking in a recording, and the friction of each.

    Parameters
    ----------
    rod : Branch or Setup
        Response of the rod that was used, with pulling if the clamp went backward; or what
        `calibration.calibrate` found, if height or offsets were not known.
    recording : Recording
        In the order in which it was made.
    deviation : ndarray, shape (3,), optional
        Standard deviation of one reading of fx, fy (E·I0/L²) and m (E·I0/L); estimated from the
        recording by default.
    method : Method
    step : float, optional
        Step of the stage (L), which the spacing needs where samples were lost; by default the
        median distance of successive clamp positions.
    law : SlipLaw, optional
        Where slips end, for the spacing; without it bounds are found that hold for all.
    kinetic_ratio : float, optional
        μk/μ0, for the spacing with a law other than ``free``.
    progress : callable
        Told how many samples are done.

    Returns
    -------
    Periods

    Raises
    ------
    ValueError
        If the recording is too short, has no measurable noise, or does not fit the rod; if the
        setup is not known.
    """
    method = Method(method)
    setup = rod if isinstance(rod, Setup) else known_setup(rod)
    if setup.message:
        raise ValueError(setup.message)
    clamp = recording.footpoint
    used = [i for i in READS[method] if not np.isnan(recording.readings[:, i]).any()]
    if len(clamp) < 3 or not used:
        raise ValueError(f"too little to identify friction from: {len(clamp)} usable rows")
    every_noise = noise_for(recording, deviation)
    noise = every_noise[used]
    if not (np.isfinite(noise).all() and (noise > 0.0).all()):
        unknown = [CHANNELS[i] for i, d in zip(used, noise, strict=True) if not 0.0 < d < np.inf]
        raise ValueError(
            f"the noise of column {', '.join(unknown)} cannot be estimated from it: give the noise"
        )

    rows, begins, place, doubt, notes = _cut(setup, recording, every_noise, used, progress)
    ends = np.append(begins[1:], len(rows)) - 1
    line = recording.line[rows]
    notes += _doubtful(doubt, line[begins], line[ends])
    recorded = _Recorded(method, clamp, recording.readings, noise, used, rows, begins, ends, place)
    law = None if law is None else SlipLaw(law)
    size = _stage_step(clamp, step) if method is Method.SPACING else 1.0
    spaced = (law, kinetic_ratio, size) if method is Method.SPACING else None

    branch = setup.branch
    place, least, last_states = recorded.seen(branch, setup.offset)
    none = np.zeros(len(begins))
    found, unsure = _friction(branch, last_states, place, none, spaced)
    displaced = [(moved, *recorded.seen(moved, offset)) for moved, offset in setup.displaced]
    means = [_friction(b, last, at, none, spaced)[0].mean for b, at, _, last in displaced]
    common = common_deviation(found.mean, means)
    if displaced:
        found, unsure = _friction(branch, last_states, place, common, spaced)

    opened = np.zeros(len(begins), dtype=bool)
    opened[-1] = True
    opened[0] |= method is Method.SPACING
    # Pulled back from there a tip slips after all, but not pushed on.
    locked = (least >= branch.mu_lock) & (opened | (last_states.sign > 0.0))
    least -= TWO_SIDED * common_deviation(least, [moved for _, _, moved, _ in displaced])
    beyond = np.isnan(found.mean) & ~opened & ~locked
    unsure &= ~(opened | locked | beyond)
    for values in found:
        values[opened | locked] = np.nan
    found.low[opened | locked] = least[opened | locked]
    for values in (found.mean, found.deviation, found.high):
        values[unsure] = np.nan
    # As it slipped, pushed, it did not lock.
    found.high[unsure & (last_states.sign > 0.0)] = branch.mu_lock
    status = np.select(
        [opened & ~locked, locked, beyond, unsure],
        [Found.OPEN, Found.LOCK, Found.BEYOND, Found.UNSURE],
        Found.SLIP,
    )
    return Periods(
        [Found(value) for value in status],
        rows[begins],
        rows[ends],
        branch.x1_init + place,
        *found,
        common,
        notes,
        doubt,
    )


def _cut(
    setup: Setup,
    recording: Recording,
    every_noise: FloatArray,
    used: list[int],
    progress: Callable[[int], None],
) -> tuple[IntArray, IntArray, FloatArray, list[str], tuple[str, ...]]:
    """Cut a recording into periods.

    Which rows are used, which of them begin a period, its contact and why it is in doubt, and notes
    on the other rows.
    """
    clamp, line, noise = recording.footpoint, recording.line, every_noise[used]
    branch, notes = setup.branch, recording.notes
    readings = recording.readings - setup.offset
    x0, spread, misfit = located(branch, readings[:, used], noise, used, progress)
    off = misfit > MISFIT
    if off.mean() > MOST_OFF:
        raise ValueError(
            f"{off.sum()} of {len(off)} samples are no state of this rod, first in line "
            f"{line[off][0]}: check rod, height, units, zero and noise"
        )
    notes += _note(line[off], "the reading is no state of this rod")
    rows = np.flatnonzero(~off)
    lone = lone_spikes(clamp[rows] - x0[rows], spread[rows])
    notes += _note(line[rows[lone]], "a lone spike")
    rows = rows[~lone]
    if len(rows) < 3:
        raise ValueError(f"too little to identify friction from: {len(rows)} usable rows")

    at = clamp[rows] - x0[rows]
    begins = np.append(0, np.flatnonzero(jumps(at, spread[rows])) + 1)
    samples = (branch, clamp[rows], readings[rows][:, used], noise, used)
    place, place_deviation = fitted(*samples, at, begins)
    own = same_contact(*samples, begins, place, place_deviation) == np.arange(len(begins))
    begins, place = begins[own], place[own]
    refitted = fitted(*samples, np.repeat(place, np.diff(begins, append=len(rows))), begins)
    located_there = (clamp[rows], readings[rows], every_noise, x0[rows], spread[rows])
    return rows, begins, place, doubts(branch, *located_there, *refitted, begins), notes


def _friction(
    branch: Branch,
    last: LastStates,
    place: FloatArray,
    common: FloatArray,
    spaced: tuple[SlipLaw | None, float | None, float] | None,
) -> tuple[Summary, BoolArray]:
    """Friction of every period, for the spacing by law, ratio and step; which have only bounds."""
    if spaced is None:
        return friction_of(branch, last, common), np.zeros(len(place), dtype=bool)
    law, ratio, step = spaced
    before = np.append(0.0, last.sign[:-1])
    relation = spacing(branch, law, ratio)
    found = friction_of(
        branch,
        last,
        common,
        step,
        lambda travel, part: relation.onset(travel, before[part], last.sign[part]),
    )
    unsure = relation.gives_bounds(before, last.sign)
    for run in _runs(last, step) if law is SlipLaw.ENERGY else []:
        try:
            mean, own = read_travels(
                branch, ratio or 0.0, last.travel[run], last.gap[run], place[run]
            )
        except np.linalg.LinAlgError:
            continue  # these travels are none of a surface of one kind: the bounds stay
        normal = normal_summary(branch, mean, np.hypot(own, common[run]))
        # What came before the first of them is not known.
        told = run.start + 1 + np.flatnonzero(~np.isnan(mean[1:]))
        for values, new in zip(found, normal, strict=True):
            values[told] = new[told - run.start]
        unsure[told] = False
    return found, unsure


def _runs(last: LastStates, step: float) -> list[slice]:
    """Periods in a row that end by slips forward in single steps, enough to be read together."""
    plain = (last.sign > 0.0) & (last.gap > 0.5 * step) & (last.gap < 1.5 * step)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], plain, [False]]).astype(np.int8)))
    pairs = edges.reshape(-1, 2).tolist()
    return [slice(start, stop) for start, stop in pairs if stop - start >= FEWEST]


def _stage_step(clamp: FloatArray, step: float | None) -> float:
    """Step of the stage: what is given, or the usual distance of successive positions."""
    moved = np.abs(np.diff(clamp))
    size = float(np.median(moved[moved > 0.0])) if step is None else step
    if not size > 0.0:
        raise ValueError(f"step must be positive, got {size!r}")
    return size


@dataclass(frozen=True, eq=False)
class _Recorded:
    """A recording cut into periods of sticking, to be read with one setup or another."""

    method: Method
    clamp: FloatArray
    readings: FloatArray
    noise: FloatArray
    used: list[int]
    rows: IntArray
    begins: IntArray
    ends: IntArray
    place: FloatArray

    def seen(self, branch: Branch, offset: FloatArray) -> tuple[FloatArray, FloatArray, LastStates]:
        """Place of each contact, least friction there, and the last sticking state."""
        rows, begins, ends = self.rows, self.begins, self.ends
        clamp, readings = self.clamp[rows], self.readings[rows] - offset
        start = np.repeat(self.place, ends - begins + 1)
        place, deviation = fitted(
            branch, clamp, readings[:, self.used], self.noise, self.used, start, begins
        )
        least = least_friction(
            branch,
            np.minimum.reduceat(clamp, begins) - place,
            np.maximum.reduceat(clamp, begins) - place,
            deviation,
        )
        none = np.zeros(len(begins))
        gap = clamp[np.minimum(ends + 1, len(rows) - 1)] - clamp[ends]
        sign = np.where(gap == 0.0, np.sign(clamp[ends] - place), np.sign(gap))
        last = LastStates(clamp[ends] - place, deviation, gap, none, sign, none, none)
        if self.method is Method.FORCES:
            # Ratio and its deviation at the last sticking sample; the model says how it goes on.
            (fx, fy), (noise_x, noise_y) = readings[ends, :2].T, self.noise
            last = last._replace(
                deviation=none,
                base=fx / fy - branch.demand(np.clip(last.travel, branch.x0_pull, branch.x0_end)),
                ratio_deviation=ratio_deviation(fx, fy, noise_x, noise_y),
            )
        if self.method is Method.SPACING:
            # A slip in a gap of the recording may have ended at any step of it.
            early = np.append(0.0, gap[:-1])
            last = last._replace(travel=clamp[ends] - clamp[begins], deviation=none, early=early)
        return place, least, last
