"""A condensed recording: means of consecutive samples of each period."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vibrissa.numerics.arrays import FloatArray, IntArray
from vibrissa.numerics.batch import Batch
from vibrissa.sensor.identification.recording import Recording
from vibrissa.sensor.identification.slips import Spans

# Number of blocks in all, if possible.
MOST_BLOCKS = 20000
# Least and largest number of blocks in one period.
FEWEST_IN_PERIOD = 8
MOST_IN_PERIOD = 64


@dataclass(frozen=True, eq=False, kw_only=True)
class Blocks(Batch):
    """Means over n blocks of consecutive samples, each block within one of p periods.

    Attributes
    ----------
    period : ndarray of int, shape (n,)
        Number of the period in which each block lies, ascending from 0.
    clamp, row : ndarray, shape (n,)
        Mean clamp position (L) and mean row number of the samples of each block.
    readings : ndarray, shape (n, 3)
        Mean readings of each block.
    count : ndarray of int, shape (n,)
        Number of samples in each block.
    """

    period: IntArray
    clamp: FloatArray
    readings: FloatArray
    row: FloatArray
    count: IntArray

    @cached_property
    def starts(self) -> IntArray:
        """Number of the first block of each period, shape (p,)."""
        return np.flatnonzero(np.diff(self.period, prepend=-1))

    def sums(self, values: FloatArray) -> FloatArray:
        """Add up the values of the blocks of each period, along the first axis."""
        return np.asarray(np.add.reduceat(values, self.starts))


def condensed(recording: Recording, spans: Spans) -> Blocks:
    """Divide each period of a recording into blocks, and average the samples of each block."""
    rows, period = spans.rows
    limit = int(np.clip(MOST_BLOCKS // len(spans), FEWEST_IN_PERIOD, MOST_IN_PERIOD))
    number = np.minimum(spans.counts, limit)
    block = (rows - spans.begins[period]) * number[period] // spans.counts[period]
    starts = np.flatnonzero((np.diff(block, prepend=-1) != 0) | (np.diff(period, prepend=-1) != 0))
    count = np.diff(starts, append=len(rows))

    def mean(values: FloatArray) -> FloatArray:
        totals = np.add.reduceat(values, starts)
        return np.asarray((totals.T / count).T)

    return Blocks(
        period=period[starts],
        clamp=mean(recording.clamp[rows]),
        readings=mean(recording.readings[rows]),
        row=mean(rows.astype(float)),
        count=count,
    )
