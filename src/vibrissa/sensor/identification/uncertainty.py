"""How well the friction of one period is known: step, noise and errors of the set-up together.

The last sticking state of a period is at most one step before the onset. So μ0 is at least |tan α|
in that state, and at most what the tip would have needed one step later. The onset is uniform
within the step, all else is normal. The distribution of μ0 that follows is represented by equally
likely values; its mean, deviation and central 95 % are returned.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtri

from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.batch import Batch

# Part of a distribution that its interval holds, and half the width of that of a normal one.
COVERAGE = 0.95
HALF_WIDTH = float(ndtri(0.5 * (1.0 + COVERAGE)))
# Periods that are computed together, to save memory.
BLOCK = 512
# Equally likely values of onset, noise and common error, spread evenly over three dimensions:
# multiples of the powers of the inverse of the root of x⁴ = x + 1 (Roberts).
VALUES = 1024
EVENLY = 1.2207440846057596 ** -np.arange(1.0, 4.0)
_PARTS = np.arange(1, VALUES + 1)[:, None] * EVENLY % 1.0
# The onset as a part of the step, uniform from 0 to 1; noise and common error, standard normal.
ONSET, NOISE, COMMON = _PARTS[:, 0], ndtri(_PARTS[:, 1]), ndtri(_PARTS[:, 2])


@dataclass(frozen=True, eq=False, kw_only=True)
class Summary(Batch):
    """Mean, standard deviation and central 95 % of distributions; NaN where there is none."""

    mean: FloatArray
    deviation: FloatArray
    low: FloatArray
    high: FloatArray


def summary_of(values: FloatArray) -> Summary:
    """Summarise equally likely values, shape (n, k), of which infinite ones do not count."""
    finite = np.where(np.isfinite(values), values, np.nan)
    some = np.asarray(np.isfinite(values).any(axis=1))
    found = Summary(**{name: np.full(len(values), np.nan) for name in Summary.names()})
    tails = 0.5 * (1.0 - COVERAGE), 0.5 * (1.0 + COVERAGE)
    whole = np.asarray(np.isfinite(values).all(axis=1))
    for rows, quantile in ((whole, np.quantile), (some & ~whole, np.nanquantile)):
        if rows.any():
            low, high = quantile(finite[rows], tails, axis=1, method="hazen")
            mean, deviation = np.nanmean(finite[rows], axis=1), np.nanstd(finite[rows], axis=1)
            found.put(rows, Summary(mean=mean, deviation=deviation, low=low, high=high))
    return found


def ratio_deviation(
    fx: ArrayLike, fy: ArrayLike, noise_x: ArrayLike, noise_y: ArrayLike
) -> FloatArray:
    """Propagate the noise of one sample, noise_x and noise_y, to its ratio fx/fy (E·I0/L²)."""
    fx, fy = np.asarray(fx), np.asarray(fy)
    return np.asarray(np.hypot(noise_x / fy, fx * noise_y / fy**2))


def step_deviation(slope: FloatArray, step: FloatArray | float) -> FloatArray:
    """Give the standard deviation of μ0 by the step of the stage, in which the onset is uniform.

    Parameters
    ----------
    slope : ndarray
        Growth of the demand −tan α with x0 at the onset (1/L), constant within a step.
    step : ndarray or float
        Step of the stage (L).
    """
    return np.asarray(np.abs(slope) * step / np.sqrt(12.0))


def common_deviation(effects: FloatArray, covariance: FloatArray) -> FloatArray:
    """Propagate errors with a covariance, shape (k, k), to the standard deviation of values.

    Parameters
    ----------
    effects : ndarray, shape (n, k)
        Change of each value per unit of each error.
    """
    squares = np.einsum("ni,ij,nj->n", effects, covariance, effects)
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)))


def variance_between(values: FloatArray, variance: FloatArray) -> tuple[float, float]:
    """Variance of values beyond that of their errors, by moments (DerSimonian and Laird, 1986).

    Parameters
    ----------
    values, variance : ndarray, shape (n,)
        Values, and the variance of the error of each.

    Returns
    -------
    between, error : float
        At least 0, and its standard error.
    """
    weight, degrees = 1.0 / variance, len(values) - 1
    mean = (weight * values).sum() / weight.sum()
    excess = (weight * (values - mean) ** 2).sum() - degrees
    free = weight.sum() - (weight**2).sum() / weight.sum()
    between = max(float(excess / free), 0.0) if free > 0.0 and degrees > 0 else 0.0
    error = np.sqrt(2.0 / max(degrees, 1)) * (between + float(variance.mean()))
    return between, float(error)
