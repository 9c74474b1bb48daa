"""Uncertainty of the friction of one period: by step, noise and errors of the set-up.

The onset is uniform within the step, all else is normal. So the error is the sum of a uniform one,
up to ±a, and a normal one with the deviation s. It is below h with the probability

    F(h) = (s/2a)·[G((h + a)/s) − G((h − a)/s)],   G(z) = z·Φ(z) + φ(z).
"""

import numpy as np
from scipy.special import ndtr, ndtri

from vibrissa.numerics.arrays import FloatArray

# Part of a distribution that its interval holds, and half the width of that of a normal one.
COVERAGE = 0.95
HALF_WIDTH = float(ndtri(0.5 * (1.0 + COVERAGE)))
# Bisections of the half width of an interval, which make it 10^-9 of what it may be.
BISECTIONS = 30
# Part of a normal deviation from which on a uniform error counts.
LITTLE = 1e-6


def half_width(half: FloatArray, normal: FloatArray) -> FloatArray:
    """Half the width of the central 95 % of the sum of a uniform error (±half) and a normal one."""
    low, high = np.zeros_like(half), half + HALF_WIDTH * normal
    sure = np.maximum(normal, LITTLE * half)
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        more = _inside(middle, half, sure) < COVERAGE
        low, high = np.where(more, middle, low), np.where(more, high, middle)
    return np.where(half > LITTLE * normal, 0.5 * (low + high), HALF_WIDTH * normal)


def _inside(width: FloatArray, half: FloatArray, normal: FloatArray) -> FloatArray:
    """Probability of an error up to ±width: see above."""
    with np.errstate(divide="ignore", invalid="ignore"):
        upper, lower = (width + half) / normal, (width - half) / normal
        return np.asarray((_integral(upper) - _integral(lower)) * normal / half - 1.0)


def _integral(z: FloatArray) -> FloatArray:
    """Integral G of the normal distribution function from −∞ to z."""
    return np.asarray(z * ndtr(z) + np.exp(-0.5 * z**2) / np.sqrt(2.0 * np.pi))


def step_deviation(slope: FloatArray, step: FloatArray | float) -> FloatArray:
    """Give the standard deviation of μ0 due to the step of the stage: the onset is uniform in it.

    Parameters
    ----------
    slope : ndarray
        Growth of the demand −tan α with x0 at the onset (1/L), constant within a step.
    step : ndarray or float
        Step of the stage (L).
    """
    return np.asarray(np.abs(slope) * step / np.sqrt(12.0))


def common_deviation(effects: FloatArray, covariance: FloatArray) -> FloatArray:
    """Propagate errors with a covariance, shape (k, k), to the standard deviation of values."""
    squares = np.einsum("ni,ij,nj->n", effects, covariance, effects)
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)))


def variance_between(values: FloatArray, variance: FloatArray) -> tuple[float, float]:
    """Variance of values beyond that of their errors, by moments (DerSimonian and Laird, 1986)."""
    weight, degrees = 1.0 / variance, len(values) - 1
    mean = (weight * values).sum() / weight.sum()
    excess = (weight * (values - mean) ** 2).sum() - degrees
    free = weight.sum() - (weight**2).sum() / weight.sum()
    between = max(float(excess / free), 0.0) if free > 0.0 and degrees > 0 else 0.0
    error = np.sqrt(2.0 / max(degrees, 1)) * (between + float(variance.mean()))
    return between, float(error)
