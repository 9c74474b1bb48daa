"""When a stage began to move whose position was not recorded: the readings begin to change."""

from typing import NamedTuple

import numpy as np

from vibrissa.errors import RecordingError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.identification.ends import FEWEST
from vibrissa.sensor.identification.recording import noise_of

# A reading that is so many standard deviations off the mean of those before has changed: by chance
# one of 10^6 has.
CHANGED = 5.0
# While the clamp moves readings change; rests are so many times longer than the usual stretch
# without a change, which all but this part of the stretches are not.
LONGER, USUAL = 4.0, 0.9
# A rest and what follows leave no more than this per reading (in
# squared standard deviations).
LEFT = 3.0
# Sums of squares that differ by less are as good as each other.
AS_GOOD = 4.0
# After a step of a motion readings change in so many further ones at least as much again.
STEPS = 3


class Rest(NamedTuple):
    """Samples up to the end of a rest, and by how many they may be more or less."""

    samples: int
    spread: int


class Motion(NamedTuple):
    """Rows in which a stage moves, and by how many the first of them may be earlier."""

    rows: slice
    spread: int


def moving_by_readings(readings: FloatArray, what: str) -> Motion:
    """Find the part between the rests at the two ends, by the readings alone.

    Where the clamp rests the readings are constant; what comes before the first rest, as the rod
    is lowered onto the surface, is left out with it.

    Parameters
    ----------
    readings : ndarray, shape (n, k)
        Of the channels that were recorded, without missing values.
    what : str
        Name of the file, for messages.

    Returns
    -------
    Motion

    Raises
    ------
    RecordingError
        If it cannot be told where the motion begins or ends.
    """
    noise = noise_of(readings)
    if not (noise > 0.0).all():
        return Motion(slice(0, len(readings)), 0)
    scaled = readings / noise
    begin = _rest(scaled, f"{what}: where the stage begins to move", "from")
    end = _rest(scaled[begin.samples :][::-1], f"{what}: where the stage stops", "to")
    return Motion(slice(begin.samples, len(readings) - end.samples), begin.spread)


def _rest(readings: FloatArray, what: str, option: str) -> Rest:
    """Count the samples up to the end of the first rest."""
    begins = _stretches(readings)
    sizes = np.diff(begins, append=len(readings))
    longest = max(LONGER * np.quantile(sizes, USUAL), 2.0 * FEWEST)
    # A rest that lasts to the last sample is the one at the other end.
    rests = np.flatnonzero(sizes[:-1] > longest)
    if not len(rests):
        return Rest(0, 0)
    # From a rest on a reading is constant, and then, up to the first slip, a parabola in time.
    first, size = int(begins[rests[0]]), int(sizes[rests[0]])
    stretch = readings[first : first + size + size // 2]
    jumps = np.abs(np.diff(stretch[size - 1 :], axis=0)) > 2.0 * CHANGED
    slips = np.flatnonzero(jumps.any(axis=1))
    if len(slips) and slips[0] == 0 and _goes_on(readings[first + size - 1 :]):
        return Rest(first + size, 1)
    stretch = stretch[: size + int(slips[0])] if len(slips) else stretch
    candidates = np.arange(size // 2, min(size + FEWEST, len(stretch)))
    squares = np.array([_squares(stretch, int(begin)) for begin in candidates])
    if squares.min() > LEFT * stretch.size:
        raise RecordingError(f"{what} cannot be told from the readings: give --{option}")
    # Of those that are as good the last: a slip may be the first that is seen of the motion.
    good = candidates[squares < squares.min() + AS_GOOD]
    return Rest(first + int(good[-1]), max(1, int(good[-1] - good[0])))


def _goes_on(readings: FloatArray) -> bool:
    """Whether the first change is a step of a fast motion, which goes on as after no slip."""
    change = readings[1] - readings[0]
    channel = int(np.argmax(np.abs(change)))
    later = readings[1 : 2 + STEPS, channel]
    return bool((later[-1] - later[0]) / change[channel] >= 1.0)


def _stretches(readings: FloatArray) -> FloatArray:
    """Cut readings, in standard deviations, where they are no longer constant."""
    begins, mean, size = [0], readings[0], 1
    for row, reading in enumerate(readings[1:], start=1):
        if (np.abs(reading - mean) > CHANGED * np.sqrt(1.0 + 1.0 / size)).any():
            begins.append(row)
            mean, size = reading, 1
        else:
            size += 1
            mean = mean + (reading - mean) / size
    return np.array(begins)


def _squares(stretch: FloatArray, begin: int) -> float:
    """Sum of squares about a constant that goes on, from a sample on, as a parabola."""
    since = np.maximum(np.arange(len(stretch)) - begin, 0) / len(stretch)
    terms = np.stack([np.ones(len(stretch)), since, since**2], axis=1)
    fitted = terms @ np.linalg.lstsq(terms, stretch, rcond=None)[0]
    return float(((stretch - fitted) ** 2).sum())
