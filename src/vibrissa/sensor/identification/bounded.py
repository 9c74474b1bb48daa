"""Expected value of normal errors of which bounds cut off a part.

Of a normal number with the mean m and the standard deviation s, of which only values above a bound
b are left, mean and variance are

    m + s·λ,   s²·(1 − λ·(λ − z)),   z = (b − m)/s,   λ = φ(z)/(1 − Φ(z)),

and every number that is correlated with it moves along. One bound is exact. With several, the
numbers are taken as normal again after each cut (assumed density filtering: Minka, 2001).
"""

import numpy as np
from scipy.special import erfcx

from vibrissa.numerics.arrays import FloatArray


def mean_within(
    mean: FloatArray, covariance: FloatArray, low: FloatArray, high: FloatArray
) -> FloatArray:
    """Return the mean of k normal numbers of which only values within bounds are left, shape (k,).

    Parameters
    ----------
    mean : ndarray, shape (k,)
        Mean without bounds, which may be beyond them.
    covariance : ndarray, shape (k, k)
        Covariance without bounds.
    low, high : ndarray, shape (k,)
        Bounds; infinite if there is none.
    """
    for side, bounds in ((1.0, low), (-1.0, high)):
        for k in np.flatnonzero(np.isfinite(bounds)):
            deviation = np.sqrt(covariance[k, k])
            z = side * (bounds[k] - mean[k]) / deviation
            # The ratio λ, without the quotient of two small numbers far beyond a bound.
            rise = np.sqrt(2.0 / np.pi) / erfcx(z / np.sqrt(2.0))
            along = covariance[k] / deviation
            mean = mean + side * rise * along
            covariance = covariance - rise * (rise - z) * np.outer(along, along)
    return mean
