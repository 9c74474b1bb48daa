"""Readings and positions that a recorder repeats, as it is faster than the sensor or the stage.

A transducer that is slower than the recorder repeats each reading in several rows. A position that
is slower, or has a coarse resolution, stays in several rows while the clamp moves on.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray

# Readings are repeated if half of the readings stay for more than this number of rows.
REPEATED_ROWS = 1.4
# In rows with a new reading, nearly all channels change. With a coarse resolution they change
# independently: of two channels that repeat so often, at most 65 % change in such a row.
CHANGES_TOGETHER = 0.75
# A single channel has a coarse resolution if more than this part of its changes is one step.
ONE_STEP = 0.5
# The clamp moves in a hold if the load rises there by more than this part of the expected rise.
MOVES_ON = 0.5
# A hold that is longer than this many usual holds is a rest of the clamp.
REST_IN_HOLDS = 2.0
# Least number of holds, and of changes of a value, from which anything is concluded.
FEWEST_HOLDS = 8
# Least part of successive values that are equal, or differ by more than a step.
OFTEN_EQUAL = 0.1
# Part of a step that is rounding.
ROUNDED_PART_OF_STEP = 1e-2
# Part of the range of the values that is rounding.
ROUNDED_PART_OF_RANGE = 1e-12
# Largest part of the values that are distinct if each step occurs again and again.
MOST_DISTINCT = 0.5


def fresh_rows(readings: FloatArray) -> BoolArray:
    """Find the rows with a new reading; all rows, unless the recorder repeats the readings.

    Parameters
    ----------
    readings : ndarray, shape (n, 3)
        Readings; NaN for a channel that is not used.

    Returns
    -------
    ndarray of bool, shape (n,)
    """
    changes = np.nan_to_num(np.diff(readings, axis=0))
    changes = changes[:, changes.any(axis=0)]
    new = changes[changes.any(axis=1)]
    every = np.ones(len(readings), dtype=bool)
    fresh = np.append(True, changes.any(axis=1))
    # A few long runs, as of readings at rest, are not repeated by the recorder.
    if len(new) < FEWEST_HOLDS or np.median(np.diff(np.flatnonzero(fresh))) < REPEATED_ROWS:
        return every
    if new.shape[1] > 1:
        held = np.mean(new != 0.0) > CHANGES_TOGETHER
    else:
        size = np.abs(new)
        held = np.mean(size < 1.5 * size.min()) <= ONE_STEP
    return fresh if held else every


@dataclass(frozen=True, eq=False, kw_only=True)
class Holds:
    """Runs of rows in which the recorded position of the clamp stays the same.

    Attributes
    ----------
    clamp : ndarray, shape (n,)
        Recorded positions of n rows (L).
    starts : ndarray of int, shape (h,)
        First row of each of h runs.
    """

    clamp: FloatArray
    starts: IntArray

    @classmethod
    def of(cls, clamp: FloatArray) -> "Holds":
        """Find the runs of equal positions."""
        return cls(clamp=clamp, starts=np.flatnonzero(np.diff(clamp, prepend=np.nan) != 0.0))

    @cached_property
    def lengths(self) -> IntArray:
        """Number of rows of each run."""
        return np.diff(self.starts, append=len(self.clamp))

    @cached_property
    def usual(self) -> float:
        """Median number of rows of a run; the first and the last run may be incomplete."""
        return float(np.median(self.lengths[1:-1])) if len(self.lengths) > 2 else 1.0

    def hides_motion(self, readings: FloatArray) -> bool:
        """Whether the clamp moves within the runs, as the load rises there.

        While the clamp rests, the load rises from run to run only.

        Parameters
        ----------
        readings : ndarray, shape (n, 3)
            Readings; NaN for a channel that is not used.
        """
        if len(self.starts) < FEWEST_HOLDS or self.usual < 2.0:
            return False
        way = np.sign(np.diff(self.clamp[self.starts]))[1:, None]
        first, following = self.starts[1:-1], self.starts[2:]
        complete = self.lengths[1:-1] <= REST_IN_HOLDS * self.usual
        readings = readings[:, np.isfinite(readings[0])]
        rises = ((readings[following] - readings[first]) * way)[complete]
        within = ((readings[following - 1] - readings[first]) * way)[complete]
        usual = np.median(rises, axis=0)
        scatter = np.median(np.abs(rises - usual), axis=0)
        best = int(np.argmax(np.abs(usual) / np.where(scatter > 0.0, scatter, np.inf)))
        expected = usual[best] * (1.0 - 1.0 / self.usual)
        return bool(np.median(within[:, best]) * expected > MOVES_ON * expected**2)

    def interpolated(self) -> FloatArray:
        """Return positions interpolated from the first rows of the runs; NaN after the last one.

        In a long run the clamp rests until a usual run before the next position. It rests to the
        end if the last run is long.
        """
        following = self.starts[1:]
        rests = self.lengths[:-1] > REST_IN_HOLDS * self.usual
        # The first run may have begun before the first row.
        rests[0] = True
        rows = np.concatenate([self.starts[1:], following[rests] - self.usual])
        values = np.concatenate([self.clamp[self.starts[1:]], self.clamp[self.starts[:-1]][rests]])
        order = np.argsort(rows, kind="stable")
        positions = np.interp(np.arange(len(self.clamp)), rows[order], values[order])
        if self.lengths[-1] <= REST_IN_HOLDS * self.usual:
            positions[self.starts[-1] + 1 :] = np.nan
        return np.asarray(positions)


def rounding(values: FloatArray) -> tuple[float, float]:
    """Return the standard deviation of the rounding of values, and the number of rows it lasts.

    With a coarse resolution, successive values are equal, and have nearly the same error.
    """
    changed = np.count_nonzero(np.diff(values))
    return resolution(values) / np.sqrt(12.0), len(values) / (changed + 1.0)


def resolution(values: FloatArray) -> float:
    """Estimate the step of which the values are multiples; 0 if there is none.

    The values of an ideal ramp are no evidence: successive values must often be equal, or differ by
    more than a step.
    """
    distinct = np.unique(values)
    gaps = np.diff(distinct)
    gaps = gaps[gaps > ROUNDED_PART_OF_RANGE * np.ptp(values)]
    if len(gaps) < FEWEST_HOLDS:
        return 0.0
    steps = (distinct - distinct[0]) / gaps.min()
    # A step that is printed with few digits is known by values that occur again and again.
    if np.abs(steps - np.round(steps)).max() < ROUNDED_PART_OF_STEP:
        step = float(gaps.min())
    elif len(distinct) < MOST_DISTINCT * len(values):
        step = float(np.median(gaps))
    else:
        return 0.0
    ways = np.abs(np.diff(values)) / step
    return step if np.mean(np.abs(ways - 1.0) > 0.5) > OFTEN_EQUAL else 0.0
