"""Uncertainty of the friction of one period due to the step, noise and errors of the set-up.

The onset is uniformly distributed over the step; all other errors are normal. The whole error is
the sum of a uniform error up to ±a and a normal error with the standard deviation s. It is below h
with the probability

    F(h) = (s/2a)·[G((h + a)/s) − G((h − a)/s)],   G(z) = z·Φ(z) + φ(z).
"""

import numpy as np
from scipy.special import ndtr, ndtri

from vibrissa.numerics.arrays import FloatArray

# Probability of an interval, and its half width for a normal error with standard deviation 1.
COVERAGE = 0.95
HALF_WIDTH = float(ndtri(0.5 * (1.0 + COVERAGE)))
# Number of bisections of a half width, which leave 10^-9 of its upper bound.
BISECTIONS = 30
# Least ratio of a uniform error to a normal error, and of a normal to a uniform one, that counts.
LEAST_RATIO = 1e-6


def half_width(half: FloatArray, normal: FloatArray) -> FloatArray:
    """Return the half width of the 95 % interval of the sum of a uniform and a normal error.

    Parameters
    ----------
    half : ndarray
        Half width a of the uniform error.
    normal : ndarray
        Standard deviation s of the normal error.
    """
    low, high = np.zeros_like(half), half + HALF_WIDTH * normal
    sure = np.maximum(normal, LEAST_RATIO * half)
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        more = _inside(middle, half, sure) < COVERAGE
        low, high = np.where(more, middle, low), np.where(more, high, middle)
    return np.where(half > LEAST_RATIO * normal, 0.5 * (low + high), HALF_WIDTH * normal)


def _inside(width: FloatArray, half: FloatArray, normal: FloatArray) -> FloatArray:
    """Probability 2·F(width) − 1 of an error up to ±width, with F of this module."""
    with np.errstate(divide="ignore", invalid="ignore"):
        upper, lower = (width + half) / normal, (width - half) / normal
        return np.asarray((_integral(upper) - _integral(lower)) * normal / half - 1.0)


def _integral(z: FloatArray) -> FloatArray:
    """Integral G of the normal distribution function from −∞ to z."""
    return np.asarray(z * ndtr(z) + np.exp(-0.5 * z**2) / np.sqrt(2.0 * np.pi))


def step_deviation(slope: FloatArray, step: FloatArray | float) -> FloatArray:
    """Return the standard deviation of μ0 for an onset that is uniformly distributed over a step.

    Parameters
    ----------
    slope : ndarray
        Derivative of the mobilised friction −tan α with respect to x0 at the onset (1/L), taken as
        constant over the step.
    step : ndarray or float
        Step of the stage (L).
    """
    return np.asarray(np.abs(slope) * step / np.sqrt(12.0))


def common_deviation(effects: FloatArray, covariance: FloatArray) -> FloatArray:
    """Propagate the covariance of k errors to the standard deviations of n values.

    Parameters
    ----------
    effects : ndarray, shape (n, k)
        Change of each value per unit of each error.
    covariance : ndarray, shape (k, k)
        Covariance of the errors.
    """
    squares = np.einsum("ni,ij,nj->n", effects, covariance, effects)
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)))


def variance_between(values: FloatArray, variance: FloatArray) -> tuple[float, float]:
    """From measured values, estimate the variance of the true values, and its standard error.

    The estimate is the one of DerSimonian and Laird (1986), by the method of moments.

    Parameters
    ----------
    values : ndarray
        Measured values.
    variance : ndarray
        Variance of the error of each value.
    """
    weight = 1.0 / variance
    degrees = len(values) - 1
    mean = (weight * values).sum() / weight.sum()
    excess = (weight * (values - mean) ** 2).sum() - degrees
    free = weight.sum() - (weight**2).sum() / weight.sum()
    between = max(float(excess / free), 0.0) if free > 0.0 and degrees > 0 else 0.0
    error = np.sqrt(2.0 / max(degrees, 1)) * (between + float(variance.mean()))
    return between, float(error)
