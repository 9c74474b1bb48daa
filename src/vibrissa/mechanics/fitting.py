"""Fit of the stiffness along a rod."""

import numpy as np

from vibrissa.numerics.arrays import FloatArray


def fitted_stiffness(
    s: FloatArray, stiffness: FloatArray, degree: int
) -> tuple[float, tuple[float, ...]]:
    """Fit a stiffness along a rod by e0·(1 + c1·s + c2·s² + …).

    Parameters
    ----------
    s, stiffness : ndarray, shape (n,)
        Arc lengths (L), and the positive stiffness there, over that of a cone of one material.
    degree : int
        Number of coefficients c1, c2, …, less than n.

    Returns
    -------
    float, tuple of float
        e0 and the coefficients for which the squares of the relative errors are least.
    """
    matrix = s[:, None] ** np.arange(degree + 1) / stiffness[:, None]
    found, *_ = np.linalg.lstsq(matrix, np.ones(len(s)), rcond=None)
    return float(found[0]), tuple((found[1:] / found[0]).tolist())
