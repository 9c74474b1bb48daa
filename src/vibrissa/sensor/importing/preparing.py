"""From the readings of a transducer to the load on the clamp, along and normal to the surface."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from vibrissa.errors import ArgumentError, RecordingError
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.sensor.importing.settings import Window
from vibrissa.sensor.transducer import CHANNELS

# Successive readings may share an error (a filter, hum), so that of a mean is told by means of
# blocks. Fewer samples than these have too few blocks.
BLOCKS, FEWEST = 20, 100
# Fewer samples do not tell a zero with its error.
FEWEST_AT_ALL = 3

Values = dict[str, FloatArray]


class Zero(NamedTuple):
    """Reading of a channel without load, its standard deviation, and how many samples told it."""

    value: float
    deviation: float
    samples: int


def turned(values: Values, angle: float) -> Values:
    """Give the forces along the axes of the clamp.

    Parameters
    ----------
    values : dict of str to ndarray
    angle : float
        By which the transducer's axes are turned from x to y (rad).

    Raises
    ------
    ArgumentError
        If one of the forces is missing.
    """
    if not angle:
        return values
    _need(values, ("force_x", "force_y"), "turn")
    x, y = values["force_x"], values["force_y"]
    cos, sin = np.cos(angle), np.sin(angle)
    return values | {"force_x": cos * x - sin * y, "force_y": sin * x + cos * y}


def about_clamp(values: Values, origin: tuple[float, float]) -> Values:
    """Give the moment about the clamp.

    Parameters
    ----------
    values : dict of str to ndarray
        The moment about a point (a, b) is that about the clamp less a·fy − b·fx: the load is the
        same force, with an arm that is shorter by (a, b).
    origin : tuple of float
        That point, from the clamp (m).

    Raises
    ------
    ArgumentError
        If a channel is missing.
    """
    a, b = origin
    if not (a or b):
        return values
    _need(values, CHANNELS, "moment_origin")
    moment = values["moment_z"] + a * values["force_y"] - b * values["force_x"]
    return values | {"moment_z": moment}


def _need(values: Mapping[str, FloatArray], names: Sequence[str], what: str) -> None:
    missing = [name for name in names if name not in values]
    if missing:
        raise ArgumentError(f"{what} needs the columns {', '.join(names)}: no {missing[0]}")


def inside(values: Values, window: Window, what: str) -> BoolArray:
    """Tell which samples lie in a window.

    Raises
    ------
    ArgumentError
        If there is no such column.
    """
    if window.column not in values:
        needed = "column time, or rate" if window.column == "time" else "column footpoint"
        raise ArgumentError(f"{what} needs the {needed}")
    where = values[window.column]
    return np.asarray((where >= window.low) & (where <= window.high))


def zeros_of(values: Values, windows: Sequence[Window]) -> dict[str, Zero]:
    """Find the readings without load in the windows in which there is none.

    Parameters
    ----------
    values : dict of str to ndarray
    windows : sequence of Window

    Returns
    -------
    dict of str to Zero
        For each channel.

    Raises
    ------
    RecordingError
        If there are too few samples.
    """
    if not windows:
        return {}
    rows = np.any([inside(values, window, "tare") for window in windows], axis=0)
    found = {}
    for name in CHANNELS:
        if name in values:
            readings = values[name][rows]
            readings = readings[~np.isnan(readings)]
            if len(readings) < FEWEST_AT_ALL:
                raise RecordingError(f"tare: {len(readings)} readings of {name} are too few")
            found[name] = Zero(float(readings.mean()), _error_of_mean(readings), len(readings))
    return found


def _error_of_mean(readings: FloatArray) -> float:
    parts: Sequence[FloatArray] = [readings]
    if len(readings) >= FEWEST:
        parts = np.array_split(readings, BLOCKS)
    means = readings if len(parts) == 1 else np.array([part.mean() for part in parts])
    return float(means.std(ddof=1) / np.sqrt(len(means)))


def with_time(values: Values, rate: float | None, place: Sequence[str]) -> Values:
    """Give each sample its time, by the rate or as recorded.

    Parameters
    ----------
    values : dict of str to ndarray
    rate : float or None
        Samples in a second.
    place : sequence of str
        Name of each row, for messages.

    Raises
    ------
    RecordingError
        If time was recorded and does not increase.
    """
    if rate is not None:
        size = len(next(iter(values.values())))
        return {"time": np.arange(size) / rate, **values}
    if "time" in values:
        late = ~(np.diff(values["time"]) > 0.0)
        if late.any():
            raise RecordingError(
                f"{place[int(np.argmax(late)) + 1]}: time does not increase: give the rate instead"
            )
    return values
