"""A recording in the rod's units, and the rows that are left out."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Self

import numpy as np

from vibrissa.errors import ArgumentError, OtherTableError, RecordingError
from vibrissa.numerics.arrays import BoolArray, FloatArray, Index, IntArray
from vibrissa.numerics.batch import Batch
from vibrissa.outcomes import Method
from vibrissa.quantities import series
from vibrissa.quantities.units import CHANNEL_KINDS, SI_UNITS, Kind, Measured, Units, wished_units
from vibrissa.sensor.identification.ends import moving, touching
from vibrissa.sensor.identification.holds import Holds, fresh_rows
from vibrissa.sensor.transducer import CHANNELS, Transducer
from vibrissa.wording import counted

if TYPE_CHECKING:
    from pandas import DataFrame

IMPORT = "If the file has other titles or another layout, convert it with vibrissa import"
# Least number of samples of a recording: a period and a slip.
FEWEST_SAMPLES = 3
# Samples over which positions and speeds of the clamp are averaged.
AVERAGED_SAMPLES = 9
# Number of stretches of lines that a note lists.
LISTED_STRETCHES = 5
# If the clamp rests in more than this part of the steps, it does so on purpose, and its positions
# have no noise.
RESTING_PART = 0.1
# Least way back of a noisy clamp that turns, in standard deviations of one position: the noise of
# the averaged positions comes to half of it.
TURN_DEVIATIONS = 6.0
# A row belongs to the rows without load up to this many median deviations from their median.
LOADED_DEVIATIONS = 7.0

# Numbers of the channels of the two forces, and of the moment.
FORCES = [0, 1]
MOMENT = 2
# A channel that is missing or saturated in more than this part of the rows is not used if the
# other channels suffice.
MOST_MISSING = 0.1


@dataclass(frozen=True, eq=False, kw_only=True)
class Recording(Batch):
    """Samples of a recording in their order, dimensionless.

    Attributes
    ----------
    clamp : ndarray, shape (n,)
        Clamp positions (L).
    readings : ndarray, shape (n, 3)
        fx, fy (E·I0/L²) and m (E·I0/L); NaN where a channel was not recorded.
    line : ndarray of int, shape (n,)
        Line of each sample in the file.
    notes : tuple of str
        Omitted rows, with the reason.
    interval : float
        Usual time from one sample to the next (s); NaN if it is not known.
    zeros : dict of str to str
        Standard deviations, with units, of the zero offsets that were subtracted from channels, as
        stated in the header of the table; keys such as ``zero_force_x``.
    air : tuple of float
        Mean unloaded reading of each channel, dimensionless: over the rows before the scan or, if
        the scan begins in the first row, after it; empty if there are no rows without load.
    air_rows : int
        Number of rows over which `air` is the mean.
    air_way : float
        Rows from the middle of these rows to the first row of the scan, as part of the scan's rows.
    slip_rows, delay : float
        Duration of a slip, and delay of the readings, both in samples.
    position : float
        Standard deviation of one clamp position (L).
    """

    clamp: FloatArray
    readings: FloatArray
    line: IntArray
    notes: tuple[str, ...] = ()
    interval: float = np.nan
    zeros: Mapping[str, str] = field(default_factory=dict)
    air: tuple[float, ...] = ()
    air_rows: int = 0
    air_way: float = 0.0
    slip_rows: float = 0.0
    delay: float = 0.0
    position: float = 0.0

    @cached_property
    def smooth(self) -> FloatArray:
        """Clamp positions, averaged over some samples if they are noisy (L)."""
        return _averaged(self.clamp) if self.position else self.clamp

    @cached_property
    def direction(self) -> FloatArray:
        """Direction of the clamp's motion between successive samples, 1 or −1, shape (n − 1,)."""
        return direction(self.smooth, TURN_DEVIATIONS * self.position)

    @property
    def lag(self) -> FloatArray:
        """Distance that the clamp moves during the delay of the readings (L)."""
        return self.delay * _averaged(np.gradient(self.clamp))

    def noted(self, *notes: str) -> Self:
        """Return a copy with more notes."""
        return replace(self, notes=(*self.notes, *notes))

    def naming(self, rows: Index, why: str) -> Self:
        """Return a copy with a note that says which rows are left out, and why."""
        return self.noted(*left_out(self.line[rows], why))


def direction(clamp: FloatArray, noise: float) -> FloatArray:
    """Direction of the clamp's motion between successive samples, 1 or −1, shape (n − 1,).

    A clamp with a `noise` (L) of its positions turns only if it goes back by more than the noise.
    Without noise, the direction of the last motion holds while the clamp rests; for a rest at the
    beginning, that of the first motion.
    """
    signs = np.sign(np.diff(clamp))
    if noise:
        from scipy.signal import find_peaks  # half a second to load

        peaks = [find_peaks(way * clamp, prominence=noise)[0] for way in (1.0, -1.0)]
        turns = np.concatenate([[0], np.sort(np.concatenate(peaks)), [len(signs)]])
        signs = np.repeat(np.sign(np.diff(clamp[turns])), np.diff(turns))
    moving = np.flatnonzero(signs)
    if not len(moving):
        return np.ones(len(signs))
    before = np.searchsorted(moving, np.arange(len(signs)), side="right") - 1
    return np.asarray(signs[moving[np.maximum(before, 0)]])


def _averaged(values: FloatArray) -> FloatArray:
    # The same as `uniform_filter1d` of SciPy, which takes a fifth of a second to load.
    repeated = np.pad(values, AVERAGED_SAMPLES // 2, mode="edge")
    return np.convolve(repeated, np.full(AVERAGED_SAMPLES, 1.0 / AVERAGED_SAMPLES), mode="valid")


def read_recording(
    table: series.Table, units: Units, method: Method, transducer: Transducer | None = None
) -> Recording:
    """Read a recording from a table, as from `table_of`.

    Rows with a missing value or a saturated reading are left out; the notes list their lines.

    Raises
    ------
    RecordingError
        If the table cannot be used; the message names the line.
    """
    interval = _interval(table)
    clamp = _nondimensional(table, "footpoint", Kind.LENGTH, units)
    absent = np.full(len(clamp), np.nan)
    readings = np.column_stack(
        [
            _nondimensional(table, channel, kind, units) if channel in table.columns else absent
            for channel, kind in zip(CHANNELS, CHANNEL_KINDS, strict=True)
        ]
    )
    zeros, offsets = _zeros(table)
    if transducer is None:
        saturated = np.zeros(readings.shape, dtype=bool)
    else:
        saturated = transducer.saturated(readings * units.channels + offsets)
    used, notes = _used(np.isnan(readings) | saturated, table, method)
    readings = np.where(np.isin(range(len(CHANNELS)), used), readings, np.nan)
    missing = np.isnan(clamp) | np.isnan(readings[:, used]).any(axis=1)
    at_limit = saturated[:, used].any(axis=1) & ~missing
    recording = Recording(
        clamp=clamp, readings=readings, line=table.line, notes=notes, interval=interval, zeros=zeros
    )
    recording = recording.naming(missing, "a value is missing")
    recording = recording.naming(at_limit, "the transducer is saturated")
    return _scanned(as_measured(recording.take(~(missing | at_limit))), used)


def as_measured(recording: Recording) -> Recording:
    """Keep one row of each repeated reading; interpolate positions that are held in motion."""
    holds = Holds.of(recording.clamp)
    if holds.hides_motion(recording.readings):
        recording = replace(recording, clamp=holds.interpolated()).noted(
            f"each position of the clamp is held for about {holds.usual:.0f} rows, while the load "
            "goes on rising: the positions between are interpolated"
        )
        stale = np.isnan(recording.clamp)
        recording = recording.naming(stale, "the position is held to the end").take(~stale)
    fresh = fresh_rows(recording.readings)
    if fresh.all():
        return recording
    times = len(fresh) / fresh.sum()
    recording = recording.noted(
        f"each reading is repeated in about {times:.0f} rows, as the sensor is slower than the "
        f"recorder: {counted(int(fresh.sum()), 'row')} with a new reading are used"
    )
    return replace(recording.take(fresh), interval=times * recording.interval)


def _used(
    lost: BoolArray, table: series.Table, method: Method
) -> tuple[list[int], tuple[str, ...]]:
    """Choose the channels to use, and write notes on recorded channels that are not used.

    Raises
    ------
    OtherTableError
        If neither the moment nor both forces were recorded.
    """
    there = [i for i, name in enumerate(CHANNELS) if name in table.columns]
    if not suffices(there):
        raise OtherTableError(
            f"{table.source}: needs the column moment_z, or both force_x and force_y; the columns "
            f"are: {', '.join(table.columns)}. {IMPORT}"
        )
    part = lost.mean(axis=0)
    # The ratio needs no moment: no row is left out for a missing moment.
    allowed = np.array([1.0, 1.0, 0.0] if method is Method.RATIO else [MOST_MISSING] * 3)
    used = [i for i in there if part[i] <= allowed[i]]
    if not suffices(used):
        used = [MOMENT] if MOMENT in there and part[MOMENT] < part[FORCES].max() else there
    notes = (
        f"{CHANNELS[i]} is missing or saturated in {counted(int(lost[:, i].sum()), 'row')}: the "
        "channel is not used"
        for i in there
        if i not in used
    )
    return used, tuple(notes)


def suffices(channels: Sequence[int]) -> bool:
    """Whether these channels determine the contact point: the moment, or both forces."""
    return MOMENT in channels or set(FORCES) <= set(channels)


def _scanned(recording: Recording, used: list[int]) -> Recording:
    """Leave out the rows before and after the scan, and note them."""
    rows = np.arange(len(recording))
    loaded = touching(recording.readings[:, used])
    air = recording.readings[slice(loaded.start) if loaded.start else slice(loaded.stop, None)]
    kept = rows[loaded][moving(recording.clamp[loaded])]
    free = np.delete(rows, loaded)
    rest = np.setdiff1d(rows[loaded], kept)
    recording = recording.naming(free, "no load: nothing touches the surface")
    recording = recording.naming(rest, "the clamp rests before or after the scan").take(kept)
    if not len(air):
        return recording
    # Rows during touch-down and lift-off have a load. The least change is a step of the resolution.
    off = np.abs(air - np.median(air, axis=0))
    least = np.min(off, axis=0, where=off > 0.0, initial=np.inf)
    air = air[~(off > LOADED_DEVIATIONS * np.maximum(np.median(off, axis=0), least)).any(axis=1)]
    if not len(air):
        return recording
    middle = 0.5 * (loaded.start or loaded.stop + len(rows))
    mean = tuple(air.mean(axis=0).tolist())
    way = abs(middle - kept[0]) / len(kept)
    return replace(recording, air=mean, air_rows=len(air), air_way=way)


def _zeros(table: series.Table) -> tuple[dict[str, str], FloatArray]:
    """Read lines such as ``# zero_force_x = 310 ± 0.3 mN``: zeros that were subtracted.

    Return their errors, and their values in SI units.
    """
    errors = {}
    values = np.zeros(len(CHANNELS))
    for i, kind in enumerate(CHANNEL_KINDS):
        name = f"zero_{CHANNELS[i]}"
        zero = Measured.read(table.header.get(name, "0"))
        what = f"{name} of {table.source}"
        zero.check(kind, what)
        values[i] = SI_UNITS.read(zero.value, kind, what)
        if zero.tolerance is not None:
            errors[name] = zero.tolerance
    return errors, values


def units_of(table: series.Table) -> Units:
    """Units of results without a rod: nondimensional if the recording is, otherwise SI."""
    wished = wished_units(*(f"1 {unit}" for unit in table.units.values()))
    return Units(si=table.units.get("footpoint") != Kind.LENGTH.own, wished=wished)


def table_of(source: "Path | DataFrame", method: Method) -> series.Table:
    """Read the columns of a recording, such as ``footpoint [mm]`` and ``force_x [N]``.

    The column ``footpoint`` is needed, and with the method ``ratio`` both forces; ``time`` is
    optional. For a file of another program the error names `vibrissa import`.
    """
    names = ["footpoint", *(CHANNELS[i] for i in FORCES if method is Method.RATIO)]
    try:
        return series.read(source, names, ["time", *CHANNELS])
    except (ArgumentError, OtherTableError) as error:
        if not isinstance(source, Path):
            raise
        raise OtherTableError(f"{error}. {IMPORT}") from None


def _interval(table: series.Table) -> float:
    """Return the median time from row to row (s); NaN if it is not known."""
    time = table.columns.get("time", np.empty(0))
    rows = np.flatnonzero(np.isfinite(time))
    steps = np.diff(time[rows])
    if (late := ~(steps > 0.0)).any():
        raise RecordingError(
            f"{table.place(int(rows[1:][late][0]))}: time does not increase; sort the table, or "
            "leave the column out"
        )
    if "time" not in table.units or not len(steps):
        return np.nan
    unit = Kind.TIME.read(f"1 {table.units['time']}", f"{table.source}: time")
    return float(np.median(steps)) * unit


def _nondimensional(table: series.Table, name: str, kind: Kind, units: Units) -> FloatArray:
    """Convert a column with a unit to nondimensional values."""
    if name not in table.units:
        raise RecordingError(f"{table.source}: {name} needs its unit, as in '{name} [mm]'")
    factor = units.column_factor(table.units[name], kind, f"{table.source}: {name}")
    return table.columns[name] * factor


def left_out(lines: IntArray, why: str) -> tuple[str, ...]:
    """Write a note that lists rows which are left out; no note if there are none."""
    if not len(lines):
        return ()
    runs = np.split(lines, np.flatnonzero(np.diff(lines) > 1) + 1)
    shown = [
        f"{run[0]}-{run[-1]}" if len(run) > 1 else f"{run[0]}" for run in runs[:LISTED_STRETCHES]
    ]
    more = ["..."] if len(runs) > LISTED_STRETCHES else []
    return (f"{why} in {counted(len(lines), 'row')}, left out: line {', '.join(shown + more)}",)
