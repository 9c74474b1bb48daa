"""Whether the heights of the surface rise and fall by more than the tolerance of its slope."""

from typing import NamedTuple

import numpy as np
from scipy.special import chdtrc

from vibrissa.numerics.arrays import FloatArray


class Unevenness(NamedTuple):
    """Test of the heights of the surface against the tolerance of its slope.

    Attributes
    ----------
    chi2 : float
        χ² of the heights, for the allowed slope.
    number : int
        Number of heights.
    chance : float
        Probability of heights that rise and fall as much, or more, if the slope is as allowed.
    """

    chi2: float
    number: int
    chance: float


def unevenness_of(height: FloatArray, surface: FloatArray, error: FloatArray) -> Unevenness:
    """Test n heights h, with the covariance K due to the surface, and V due to errors.

    With W = K + V the locally most powerful test of a larger K is that of hᵀ·W⁻¹·K·W⁻¹·h. It is a
    sum of squares of normal numbers with weights, whose distribution is taken as that of a multiple
    of χ² with the same mean and variance (Satterthwaite, 1946). Heights that scatter from place to
    place are found by χ² of h for the covariance W. The smaller of both chances counts, twice.

    Parameters
    ----------
    height : ndarray, shape (n,)
    surface : ndarray, shape (n, n)
        K (L²).
    error : ndarray, shape (n, n)
        V (L²).
    """
    if not surface.any():
        # A single height, or exact ones, tell nothing of an uneven surface.
        return Unevenness(chi2=0.0, number=len(height), chance=1.0)
    root = np.linalg.cholesky(surface + error)
    scaled = np.linalg.solve(root, height)
    part = np.linalg.solve(root, np.linalg.solve(root, surface).T)
    mean = float(np.trace(part))
    square = float((part**2).sum())
    rise = float(scaled @ part @ scaled)
    smooth = float(chdtrc(mean**2 / square, rise * mean / square))
    rough = float(chdtrc(len(height), scaled @ scaled))
    chance = min(1.0, 2.0 * min(smooth, rough))
    return Unevenness(chi2=float(scaled @ scaled), number=len(height), chance=chance)
