"""Inverses of many small matrices at once."""

import numpy as np

from vibrissa.numerics.arrays import SingleArray
from vibrissa.numerics.batch import slices

# LAPACK is called for each matrix by itself: that is faster for a few of them, and for large ones.
FEWEST, LARGEST = 64, 32
# Matrices that are eliminated together: they stay in the processor's cache.
TOGETHER = 256
# A matrix with a smaller pivot is left to LAPACK, which seeks larger ones: what is lost in digits
# is about the square of its reciprocal.
SMALL_PIVOT = 0.1


def inverses(matrices: SingleArray, last: int) -> SingleArray:
    """Invert matrices that are the identity plus something smooth, but for their last rows.

    Parameters
    ----------
    matrices : ndarray of float32, shape (n, k, k)
    last : int
        Number of last rows and columns among which pivots must be sought.

    Returns
    -------
    ndarray of float32, shape (n, k, k)

    Raises
    ------
    LinAlgError
        If one of them is singular.

    Notes
    -----
    The first rows are eliminated without a search for pivots. Near the buckling load of the rod one
    of them vanishes: LAPACK inverts what has a small one.
    """
    if len(matrices) < FEWEST or matrices.shape[1] > LARGEST:
        return np.asarray(np.linalg.inv(matrices))
    found = np.empty_like(matrices)
    for part in slices(len(matrices), TOGETHER):
        # The matrices count last, so that each step is one for all of them.
        with np.errstate(all="ignore"):
            inverse, least = _eliminated(matrices[part].transpose(1, 2, 0).copy(), last)
        found[part] = inverse.transpose(2, 0, 1)
        small = part.start + np.flatnonzero(~(least >= SMALL_PIVOT))
        found[small] = np.linalg.inv(matrices[small])
    return found


def _eliminated(matrices: SingleArray, last: int) -> tuple[SingleArray, SingleArray]:
    """Invert matrices of shape (k, k, n) in place, by Gauss and Jordan's elimination.

    Returns them with the size of the least pivot of each.
    """
    first = len(matrices) - last
    product, least = np.empty_like(matrices), np.full(matrices.shape[2], np.inf, np.float32)
    for row in range(first):
        least = np.minimum(least, np.abs(matrices[row, row]))
        column, scaled = matrices[:, row].copy(), matrices[row] / matrices[row, row]
        matrices[:, row] = 0.0
        scaled[row] = 1.0 / column[row]
        matrices -= np.multiply(column[:, None], scaled, out=product)
        matrices[row] = scaled
    # What is left at the end is inverted by itself.
    columns = matrices[:first, first:].copy()
    end = np.linalg.inv(matrices[first:, first:].transpose(2, 0, 1)).transpose(1, 2, 0)
    rows = (end[:, :, None] * matrices[first:, :first]).sum(axis=1)
    for column, row in zip(columns.swapaxes(0, 1), rows, strict=True):
        matrices[:first, :first] -= column[:, None] * row
    matrices[:first, first:] = -(columns[:, :, None] * end).sum(axis=1)
    matrices[first:, :first], matrices[first:, first:] = rows, end
    return matrices, least
