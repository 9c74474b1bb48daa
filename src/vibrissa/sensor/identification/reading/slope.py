"""The local slope of the surface, which no reading tells from friction.

A surface that is inclined by δ where the tip slips turns the normal there. The ratio of the forces
is then tan(arctan μ0 + δ), so that μ0 has the error (1 + μ0²)·δ, by the model and by the ratio
alike. The slope is a normal process along the surface, with the covariance σ²·exp(−d²/(2ℓ²)) over
the distance d: the errors of places that are near to each other go together.
"""

from dataclasses import replace

import numpy as np

from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.identification.friction import Periods
from vibrissa.sensor.identification.reading.uncertainty import HALF_WIDTH

NAME = "surface_slope"
# Distance over which slopes are alike: in m, and in units of the length of a rod without a size.
LENGTH, OWN_LENGTH = 5e-3, 0.05
# Periods whose covariances are computed together, to save memory.
BLOCK = 512


def slope_errors(mu0: FloatArray, slope: float) -> FloatArray:
    """Give the standard deviation of each friction, shape (p,), by that of a slope (rad)."""
    return np.asarray((1.0 + mu0**2) * slope)


def on_a_slope(periods: Periods, slope: float) -> Periods:
    """Widen what is known of friction by the slope of the surface.

    Parameters
    ----------
    periods : Periods
    slope : float
        Standard deviation of the slope (rad).

    Returns
    -------
    Periods
    """
    if not slope > 0.0:
        return periods
    error = slope_errors(np.nan_to_num(periods.mu0), slope)
    # Where there is a bound alone, it is that of the friction that was needed.
    bound = slope_errors(np.nan_to_num(periods.low), slope)
    middle = np.where(np.isnan(periods.mu0), periods.low, periods.mu0)
    error = np.where(np.isnan(periods.mu0), bound, error)
    down = np.hypot(middle - periods.low, HALF_WIDTH * error)
    up = np.hypot(periods.high - middle, HALF_WIDTH * error)
    return replace(
        periods,
        deviation=np.hypot(periods.deviation, error),
        low=np.maximum(middle - down, 0.0),
        high=middle + up,
    )


def variance_of_mean(
    weights: FloatArray, error: FloatArray, place: FloatArray, length: float
) -> float:
    """Variance of a weighted mean by slopes that are alike where places are near.

    Parameters
    ----------
    weights, error, place : ndarray, shape (p,)
        Weights, standard deviations of each value, and where it was read.
    length : float
        ℓ, in units of the places.
    """
    part, total = weights * error, 0.0
    for start in range(0, len(part), BLOCK):
        here = slice(start, start + BLOCK)
        total += float(part[here] @ (alike(place[here], place, length) @ part))
    return total


def alike(one: FloatArray, other: FloatArray, length: float) -> FloatArray:
    """Correlations of slopes at places of shape (n,) and (m,), shape (n, m)."""
    return np.asarray(np.exp(-0.5 * ((one[:, None] - other) / length) ** 2))
