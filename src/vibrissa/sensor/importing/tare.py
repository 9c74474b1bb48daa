"""Zeros of the channels: readings while nothing touches the rod."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from vibrissa.errors import RecordingError
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.sensor.identification.ends import FEWEST_AT_END, moving, touching
from vibrissa.sensor.identification.noise import noise_of
from vibrissa.sensor.transducer import CHANNELS

# Errors of successive readings may be correlated (filter, hum). With enough readings, the error of
# their mean is therefore estimated from the means of this number of blocks.
BLOCKS = 20
# Least number of readings that are divided into blocks.
FEWEST_IN_BLOCKS = 100
# Least number of readings for a zero and its error.
FEWEST_READINGS = 3
# A change of a reading by this many standard deviations is a load: noise exceeds it once in 10^6.
CHANGED = 5.0
# Least change at the first touch, as a part of the usual load in motion.
LOADED = 0.3
# Part of the rows before this change whose mean is the zero.
TAKEN = 0.8
# A window without load is refused if its readings change by more than this part of the range of
# the recording (and more than the noise): a zero that is wrong by less does little harm.
HARMLESS = 0.02
# Number of blocks in which a stated window is checked.
CHECKED = 20
# Least number of readings of such a block.
FEWEST_CHECKED = 5
# Zeros before and after the scan differ if they do so by this many standard deviations.
DRIFTED = 4.0

Values = Mapping[str, FloatArray]


class Zero(NamedTuple):
    """Mean reading of a channel without load.

    Attributes
    ----------
    value, deviation : float
        Mean, and its standard error.
    rows : int
        Number of readings.
    change : float
        Change of the zero from these rows to those on the other side of the scan; 0 if there are
        none, or if the zeros agree.
    """

    value: float
    deviation: float
    rows: int
    change: float = 0.0


class Tare(NamedTuple):
    """Zeros of the channels.

    Attributes
    ----------
    zeros : dict of str to Zero
    offsets : dict of str to ndarray
        Zero of each sample, which changes steadily if there are rows without load before and after
        the scan that show so.
    notes : tuple of str
        Which rows are without load, if not those before the scan.
    """

    zeros: dict[str, Zero]
    offsets: dict[str, FloatArray]
    notes: tuple[str, ...]


def tare_of(
    values: Values,
    kept: BoolArray,
    stated: BoolArray | None,
    name: str,
    spell: Callable[[BoolArray], str],
) -> Tare:
    """Find the zeros, in the stated window or in rows that are certainly without load.

    Parameters
    ----------
    kept : ndarray of bool
        Rows of the scan.
    stated : ndarray of bool or None
        Rows of the window that the user stated.
    name : str
        Name of the file in messages.
    spell : callable
        Writes rows as a window, such as ``0 s, 1.4 s``.

    Raises
    ------
    RecordingError
        If the stated window contains load; the message names the part that would do.
    """
    rows = np.arange(len(kept))
    before, after = rows < free_before(values, kept), rows >= free_after(values, kept)
    if stated is not None:
        if why := _load_in(values, kept, stated, before if before.any() else after, spell):
            raise RecordingError(f"{name}: {why}")
        first = stated
    else:
        first = before if before.any() else after
    zeros = zeros_of(values, first)
    apart = [side for side in (before, after) if side.any() and not (side & first).any()]
    notes = [f"rows without load only after the scan: {spell(after)}"] if first is after else []
    if not apart or not zeros:
        steady = {name: np.full(len(kept), zero.value) for name, zero in zeros.items()}
        return Tare(zeros, steady, tuple(notes if zeros else []))
    # A stated window may be apart from the rows on both sides: the farther side counts.
    distances = [rows[side].mean() - rows[first].mean() for side in apart]
    farthest = int(np.argmax(np.abs(distances)))
    other = apart[farthest]
    second = zeros_of(values, other)
    way = (rows - rows[first].mean()) / distances[farthest]
    zeros = {
        name: changed(zero, second[name]) if name in second else zero
        for name, zero in zeros.items()
    }
    if not any(zero.change for zero in zeros.values()):
        place = "after" if other is after else "before"
        notes.append(f"the zeros {place} the scan agree: {spell(other)}")
    offsets = {name: zero.value + zero.change * way for name, zero in zeros.items()}
    return Tare(zeros, offsets, tuple(notes))


def changed(zero: Zero, other: Zero) -> Zero:
    """Compare a zero with that on the other side of the scan.

    If they differ, the error of the zero contains what a sudden change, at any time of the scan,
    leaves over when a steady one is subtracted: a uniform distribution over the change.
    """
    change = other.value - zero.value
    deviation = float(np.hypot(zero.deviation, other.deviation))
    if abs(change) <= DRIFTED * deviation:
        return zero
    return zero._replace(
        deviation=float(np.hypot(zero.deviation, change / np.sqrt(12.0))), change=change
    )


def _load_in(
    values: Values,
    kept: BoolArray,
    stated: BoolArray,
    free: BoolArray,
    spell: Callable[[BoolArray], str],
) -> str:
    """Say why a window contains load, or is under load as a whole; empty if it does not."""
    for name in recorded(values):
        good = quiet_part(values[name], kept, stated)
        if not good.all():
            rows = np.zeros_like(stated)
            rows[np.flatnonzero(stated)[good]] = True
            return (
                f"the readings of {name} change in the window of --tare by more than their noise: "
                f"choose a part without load, perhaps --tare {spell(rows)!r}"
            )
    channel = next((name for name in ("force_y", "moment_z") if name in values), None)
    if channel is None or not free.any():
        return ""
    air, window, scan = (np.nanmedian(values[channel][rows]) for rows in (free, stated, kept))
    if abs(window - air) > LOADED * abs(scan - air):
        return (
            f"{channel} is under load in the window of --tare: the rod seems to be free in "
            f"--tare {spell(free)!r}"
        )
    return ""


def quiet_part(readings: FloatArray, kept: BoolArray, stated: BoolArray) -> BoolArray:
    """Find the part of a window whose readings do not change, shape (number of its rows,).

    All is quiet if medians of blocks differ by less than `CHANGED` deviations of the noise, or by a
    harmless part of the range of the recording. Otherwise the quiet part is that of equal readings
    furthest from those of the scan.
    """
    window = readings[stated]
    quiet = np.ones(len(window), dtype=bool)
    blocks = min(CHECKED, int(np.isfinite(window).sum()) // FEWEST_CHECKED)
    if blocks < 2:
        return quiet
    parts = np.array_split(np.arange(len(window)), blocks)
    medians = np.array([np.nanmedian(window[part]) for part in parts])
    noise = np.nanmedian([np.nanstd(window[part]) for part in parts])
    span = np.subtract(*np.nanquantile(readings, [0.98, 0.02]))
    most = max(CHANGED * noise, HARMLESS * span)
    if np.ptp(medians) <= most:
        return quiet
    far = int(np.argmax(np.abs(medians - np.nanmedian(readings[kept]))))
    alike = np.abs(medians - medians[far]) <= 0.5 * most
    first, last = far, far
    while first > 0 and alike[first - 1]:
        first -= 1
    while last < blocks - 1 and alike[last + 1]:
        last += 1
    # The block beside one with load may hold its beginning.
    if last - first > 1:
        first, last = first + (first > 0), last - (last < blocks - 1)
    quiet[:] = False
    quiet[parts[first][0] : parts[last][-1] + 1] = True
    return quiet


def free_before(values: Values, kept: BoolArray) -> int:
    """Count the rows before the scan that are certainly without load."""
    end = len(kept) - int(np.argmax(kept[::-1]))
    free = unloaded(
        {name: each[:end] for name, each in values.items()}, int(np.argmax(kept)) or end
    )
    return free if free >= FEWEST_AT_END else 0


def free_after(values: Values, kept: BoolArray) -> int:
    """Find the first of the rows after the scan that are certainly without load."""
    back = {name: each[::-1] for name, each in values.items()}
    return len(kept) - free_before(back, kept[::-1])


def zeros_of(values: Values, rows: BoolArray) -> dict[str, Zero]:
    """Find the mean reading of each channel in rows without load, and the error of this mean.

    A channel that has too few readings in these rows is left out.
    """
    zeros: dict[str, Zero] = {}
    for name in recorded(values):
        readings = values[name][rows]
        readings = readings[~np.isnan(readings)]
        if len(readings) >= FEWEST_READINGS:
            blocks = BLOCKS if len(readings) >= FEWEST_IN_BLOCKS else len(readings)
            means = np.array([part.mean() for part in np.array_split(readings, blocks)])
            error = means.std(ddof=1) / np.sqrt(blocks) if np.ptp(readings) else 0.0
            zeros[name] = Zero(float(readings.mean()), float(error), len(readings))
    return zeros


def recorded(values: Values) -> list[str]:
    """List the channels that have a reading in some row."""
    return [name for name in CHANNELS if np.isfinite(values.get(name, np.nan)).any()]


def unloaded(values: Values, begin: int) -> int:
    """Count the rows at the beginning that are certainly without load; 0 if none is certain.

    Parameters
    ----------
    begin : int
        First row that was asked for, which is before the clamp moves unless footpoint was recorded;
        without such a row the number of rows.
    """
    channel = next((name for name in ("force_y", "moment_z") if name in values), None)
    if channel is None:
        return 0
    clamp = values.get("footpoint", np.zeros(len(values[channel])))
    rows = np.flatnonzero(np.isfinite(values[channel] + clamp))
    readings = values[channel][rows]
    begin = int(np.searchsorted(rows, begin))
    end = len(rows)
    if "footpoint" in values:
        scan = moving(clamp[rows])
        begin, end = min(begin, scan.start), scan.stop
    if not FEWEST_AT_END < begin < end - FEWEST_AT_END:
        return 0
    load = readings - np.median(readings[:FEWEST_AT_END])
    moved = load[begin:end]
    moved = moved[touching(moved[:, None])]
    usual = np.median(moved)
    changed = int(np.argmax(np.abs(load) > CHANGED * noise_of(readings[:, None])))
    if usual == 0.0 or not changed < begin:
        return 0
    # A rod that touches the surface from the beginning only relaxes: its load changes less.
    lowered = np.median(load[changed:begin]) / usual > LOADED
    pressed = np.quantile(moved / usual, 0.05) > LOADED
    return int(rows[int(TAKEN * changed)]) if lowered and pressed else 0
