"""Fit of a rod of the model to measured diameters and moduli."""

import numpy as np

from vibrissa.numerics.arrays import FloatArray


def fitted_powers(s: FloatArray, factor: FloatArray, degree: int) -> tuple[float, ...]:
    """Fit the factor of the bending stiffness along a rod by 1 + c1·s + c2·s² + ….

    Parameters
    ----------
    s, factor : ndarray, shape (n,)
        Arc lengths (L), and the positive factor e there; it is 1 at s = 0.
    degree : int
        Number of coefficients, at most n.

    Returns
    -------
    tuple of float
        The coefficients c1, c2, … for which the squares of the relative errors are least.
    """
    powers = np.arange(1, degree + 1)
    matrix = s[:, None] ** powers / factor[:, None]
    found, *_ = np.linalg.lstsq(matrix, 1.0 - 1.0 / factor, rcond=None)
    return tuple(found.tolist())
