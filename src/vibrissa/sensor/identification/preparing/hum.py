"""Hum of the mains in the readings: a sinusoid of constant amplitude and phase, by least squares.

The load on the clamp changes much more than the hum. But within two cycles of the hum it is a
parabola, unless the tip slips. So the readings are cut into such blocks, from which parabolas are
taken off, and those with a slip do not count. The mains is not at 50 Hz exactly: the frequency is
fitted, too.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from vibrissa.numerics.arrays import FloatArray, IntArray

# Nominal frequencies of the mains (Hz), and how far off it may be.
MAINS, OFF = (50.0, 60.0), 0.2
# A block has so many cycles, and at least so many samples.
CYCLES, FEWEST = 2.0, 8
# Fewer blocks do not tell a hum.
FEWEST_BLOCKS = 10
# A block has a slip that leaves so many times what the usual one leaves, or has a second difference
# so many times the usual one.
SLIP, JUMP = 4.0, 10.0
# Least part of a sinusoid that blocks without parabolas still have: sampled near the frequency of
# the mains itself, hum is a slow wave, or a constant.
SEEN = 0.2
# Squares that a hum must explain, in squared standard deviations of a reading: by chance less than
# one of 10^6 recordings has them, at the best of all frequencies.
CLEAR = 50.0
# Squares that are no more than this part of others are rounding.
TINY = 1e-20
# Frequencies that are tried for each nominal one, at most.
TRIED = 400


class Hum(NamedTuple):
    """Hum in a recording.

    Attributes
    ----------
    frequency : float
        In Hz.
    amplitude : ndarray, shape (3,)
        Of each channel; 0 where none is seen.
    signal : ndarray, shape (n, 3)
        What it adds to the readings.
    """

    frequency: float
    amplitude: FloatArray
    signal: FloatArray


def hum_of(readings: FloatArray, time: FloatArray, clamp: FloatArray) -> Hum | None:
    """Find the hum in a recording; None where none is seen.

    Parameters
    ----------
    readings : ndarray, shape (n, 3)
        In any units; a channel with a missing value has none.
    time : ndarray, shape (n,)
        In seconds, increasing.
    clamp : ndarray, shape (n,)
        Positions. What the clamp does at this frequency, too, is no hum but the step of a stage, or
        its vibration, and the load follows it.
    """
    there = np.isfinite(readings).all(axis=0)
    if len(time) < 2 or not np.isfinite(time).all() or not there.any():
        return None
    known = np.column_stack([clamp, readings[:, there]])
    found = [one for nominal in MAINS if (one := _near(nominal, known, time)) is not None]
    if not found:
        return None
    best = max(found, key=lambda one: float(one.explained.max()))
    whole = np.zeros((2, readings.shape[1]))
    whole[:, there] = best.weights * (best.explained > CLEAR)
    return Hum(best.frequency, np.hypot(*whole), _waves(time, best.frequency) @ whole)


class _Fit(NamedTuple):
    """Waves of a frequency: their weights, shape (2, k), and the squares they explain, (k,)."""

    frequency: float
    weights: FloatArray
    explained: FloatArray


def _near(nominal: float, known: FloatArray, time: FloatArray) -> _Fit | None:
    """Find hum near a frequency in readings, of which the clamp is the first column."""
    size = _block(time, nominal)
    if len(time) // size < FEWEST_BLOCKS:
        return None
    blocks = _Blocks.of(known, size)
    frequencies = _frequencies(nominal, float(time[-1] - time[0]))
    squares = [_explained(blocks, time, one) for one in frequencies]
    at = int(np.argmax(squares))
    if squares[at] <= CLEAR:
        return None
    step = frequencies[1] - frequencies[0]
    bounds = frequencies[at] - step, frequencies[at] + step
    finest = minimize_scalar(
        lambda one: -_explained(blocks, time, one), bounds=bounds, options={"xatol": 1e-4 * step}
    )
    frequency = float(finest.x)
    weights, explained = blocks.fitted(_waves(time, frequency))
    return None if explained[0] > CLEAR else _Fit(frequency, weights[:, 1:], explained[1:])


def _explained(blocks: "_Blocks", time: FloatArray, frequency: float) -> float:
    """Squares that waves of a frequency explain, in the channel in which they explain most."""
    return float(blocks.fitted(_waves(time, frequency))[1][1:].max())


def _block(time: FloatArray, frequency: float) -> int:
    """Count the samples of a block."""
    rate = 1.0 / float(np.median(np.diff(time)))
    return max(FEWEST, round(CYCLES * rate / frequency))


def _frequencies(nominal: float, duration: float) -> list[float]:
    """List frequencies that a recording of this duration tells apart, a quarter of a cycle each."""
    number = min(int(8.0 * OFF * duration) + 3, TRIED)
    return np.linspace(nominal - OFF, nominal + OFF, number).tolist()


def _waves(time: FloatArray, frequency: float) -> FloatArray:
    """Cosine and sine, shape (n, 2)."""
    angle = 2.0 * np.pi * frequency * (time - time[0])
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


class _Blocks(NamedTuple):
    """Readings in blocks, without parabolas, of which some have a slip."""

    rest: FloatArray
    quiet: IntArray
    project: FloatArray

    @classmethod
    def of(cls, readings: FloatArray, size: int) -> "_Blocks":
        """Cut readings, shape (n, k), into blocks: rest has the shape (blocks, size, k)."""
        basis, _ = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, size), 3))
        project = np.eye(size) - basis @ basis.T
        rest = _cut(readings, project)
        left = (rest**2).sum(axis=1)
        second = np.pad(np.abs(np.diff(readings, n=2, axis=0)), ((1, 1), (0, 0)))
        jump = _cut(second, np.eye(size)).max(axis=1) > JUMP * np.median(second, axis=0)
        # The clamp, the first column, does not show a slip.
        quiet = ((left <= SLIP * np.median(left, axis=0)) & ~jump)[:, 1:].all(axis=1)
        return cls(rest[quiet], np.flatnonzero(quiet), project)

    def fitted(self, waves: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Fit waves, shape (n, 2): their weights in each channel, and the squares they explain."""
        channels, size = self.rest.shape[2], len(self.project)
        seen = _cut(waves, self.project)[self.quiet].reshape(-1, 2)
        readings = self.rest.reshape(-1, channels)
        nothing = np.zeros((2, channels)), np.zeros(channels)
        if len(self.quiet) < FEWEST_BLOCKS or np.mean(seen**2) < 0.5 * SEEN:
            return nothing
        weights = np.asarray(np.linalg.lstsq(seen, readings, rcond=1e-3)[0], dtype=float)
        left = ((readings - seen @ weights) ** 2).sum(axis=0)
        degrees = len(self.quiet) * (size - 3) - 2
        before = (readings**2).sum(axis=0)
        explained: FloatArray = np.divide(
            before - left, left / degrees, out=np.zeros(channels), where=left > TINY * before
        )
        return weights, explained


def _cut(values: FloatArray, project: FloatArray) -> FloatArray:
    """Cut into blocks and take parabolas off, shape (blocks, size, k)."""
    size = len(project)
    blocks = values[: len(values) // size * size].reshape(-1, size, values.shape[1])
    return np.einsum("ij,bjk->bik", project, blocks)
