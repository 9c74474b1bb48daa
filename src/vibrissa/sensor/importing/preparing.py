"""From the readings of a transducer to the load on the clamp: axes, origin of the moment, zeros."""

from typing import NamedTuple

import numpy as np

from vibrissa.errors import RecordingError
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.sensor.identification.ends import FEWEST, moving, touching
from vibrissa.sensor.identification.recording import noise_of
from vibrissa.sensor.transducer import CHANNELS

# Successive readings may share an error (a filter, hum): that of a mean is estimated from means of
# so many blocks, if there are enough readings.
BLOCKS, FEWEST_IN_BLOCKS = 20, 100
# Fewer readings do not give a zero with its error.
FEWEST_READINGS = 3
# A reading that is so many standard deviations off has changed: by chance one of 10^6 has.
CHANGED = 5.0
# So much of the usual load of the motion is a load; of the rows before it, so many are taken.
LOADED, TAKEN = 0.3, 0.8

Values = dict[str, FloatArray]


class Zero(NamedTuple):
    """Mean reading of a channel without load, its standard deviation, and its number of rows."""

    value: float
    deviation: float
    rows: int


def turned(values: Values, angle: float) -> Values:
    """Give the forces along the axes of the clamp.

    Parameters
    ----------
    angle : float
        By which the transducer's axes are turned from x to y (rad).
    """
    x, y = values["force_x"], values["force_y"]
    cos, sin = np.cos(angle), np.sin(angle)
    return values | {"force_x": cos * x - sin * y, "force_y": sin * x + cos * y}


def about_clamp(values: Values, origin: tuple[float, float]) -> Values:
    """Give the moment about the clamp: m = m(a, b) + a·fy − b·fx.

    Parameters
    ----------
    origin : tuple of float
        That point, from the clamp (m).
    """
    a, b = origin
    moment = values["moment_z"] + a * values["force_y"] - b * values["force_x"]
    return values | {"moment_z": moment}


def zeros_of(values: Values, rows: BoolArray) -> dict[str, Zero]:
    """Find the mean reading of each channel in the rows without load, and its error.

    Raises
    ------
    RecordingError
        If there are too few rows.
    """
    found = {}
    for name in CHANNELS:
        if name in values:
            readings = values[name][rows]
            readings = readings[~np.isnan(readings)]
            if len(readings) < FEWEST_READINGS:
                raise RecordingError(f"tare: {len(readings)} readings of {name} are too few")
            blocks = BLOCKS if len(readings) >= FEWEST_IN_BLOCKS else len(readings)
            means = np.array([part.mean() for part in np.array_split(readings, blocks)])
            error = means.std(ddof=1) / np.sqrt(blocks)
            found[name] = Zero(float(readings.mean()), float(error), len(readings))
    return found


def unloaded(values: Values, begin: int | None) -> int:
    """Count the rows at the beginning in which no load acts, if that is certain; else 0.

    Parameters
    ----------
    begin : int or None
        Row in which the clamp begins to move; None: by its positions.
    """
    channel = next((name for name in ("force_y", "moment_z") if name in values), None)
    if channel is None:
        return 0
    readings = values[channel]
    if np.isnan(readings).any() or (begin is None and np.isnan(values["footpoint"]).any()):
        return 0
    if begin is None:
        begin = moving(values["footpoint"]).start
    if not FEWEST < begin < len(readings) - FEWEST:
        return 0
    load = readings - np.median(readings[:FEWEST])
    moved = load[begin:]
    moved = moved[touching(moved[:, None])]
    usual = np.median(moved)
    changed = int(np.argmax(np.abs(load) > CHANGED * noise_of(readings[:, None])))
    if usual == 0.0 or not changed < begin:
        return 0
    # A rod that rests on the surface from the beginning relaxes by less.
    lowered = np.median(load[changed:begin]) / usual > LOADED
    pressed = np.quantile(moved / usual, 0.05) > LOADED
    return int(TAKEN * changed) if lowered and pressed else 0
