"""Noise of readings, estimated from the readings themselves."""

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray

# Differences beyond this multiple of their standard deviation are slips, not noise.
OUTLIER = 4.0
# Least part of the steps in which a clamp rests that moves in steps of several samples.
OFTEN_AT_REST = 0.3


def noise_of(readings: FloatArray, clamp: FloatArray | None = None) -> FloatArray:
    """Estimate the noise of each channel from second differences; outliers (slips) are left out.

    With the positions of the clamp, shape (n,), it is estimated from differences at rest, too, if
    the clamp often rests: these contain no rise of the load. The smaller estimate counts, as
    positions of a coarse resolution may be equal while the clamp moves.
    """
    # The second difference of three readings has 1 + 4 + 1 times their variance.
    noise = _scatter(np.diff(readings, n=2, axis=0)) / np.sqrt(6.0)
    rests = np.zeros(0, dtype=bool) if clamp is None else np.diff(clamp) == 0.0
    if rests.sum() > OFTEN_AT_REST * len(rests):
        still = _scatter(np.diff(readings, axis=0)[rests]) / np.sqrt(2.0)
        noise = np.where(still > 0.0, np.fmin(noise, still), noise)
    return noise


def _scatter(changes: FloatArray) -> FloatArray:
    """Root mean square of the columns of changes without outliers; NaN if there are no changes."""
    from scipy.special import ndtri  # half a second to load

    if not len(changes):
        return np.full(changes.shape[1], np.nan)
    size = np.abs(changes)
    usual: BoolArray = size <= OUTLIER * np.median(size, axis=0) / ndtri(0.75)
    with np.errstate(invalid="ignore"):
        return np.sqrt(np.where(usual, size**2, 0.0).sum(axis=0) / usual.sum(axis=0))
