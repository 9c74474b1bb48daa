"""Smallest eigenvalues of symmetric operators, many at once, by what they do to vectors."""

from collections.abc import Callable, Sequence

import numpy as np

from vibrissa.numerics.arrays import FloatArray

# Steps after which the smallest eigenvalue is looked at for the first time, and then again.
FIRST_LOOK, LOOKS = 10, 4
# Change since the look before at which it is taken: a thousand times what is then still to come.
SMALL_CHANGE = 1e-7


def smallest_eigenvalue(image: Callable[[FloatArray], FloatArray], start: FloatArray) -> FloatArray:
    """Find the smallest eigenvalue of each of some symmetric operators by Lanczos' iteration.

    Parameters
    ----------
    image : callable
        Maps one vector for each operator, shape (size, n), to their images.
    start : ndarray, shape (size, n)
        Vectors to begin with: the nearer to the eigenvectors, the fewer steps.

    Returns
    -------
    ndarray, shape (n,)
        To about 1e-10 of the operator's largest eigenvalue.

    Notes
    -----
    The vectors lose their orthogonality where an eigenvalue has converged. That gives an eigenvalue
    twice, and not another one (C. C. Paige, Linear Algebra Appl. 34 (1980) 235).
    """
    size, count = start.shape
    # The operators in the space of the vectors so far are tridiagonal.
    diagonal: list[FloatArray] = []
    beside: list[FloatArray] = []
    smallest = np.full(count, np.inf)
    before, length = np.zeros_like(start), np.zeros(count)
    vector = start / np.linalg.norm(start, axis=0)
    for steps in range(1, size + 1):
        following = image(vector) - length * before
        diagonal.append(_dot(following, vector))
        if steps == size or (steps >= FIRST_LOOK and (steps - FIRST_LOOK) % LOOKS == 0):
            known, smallest = smallest, _smallest_tridiagonal(diagonal, beside)
            if np.all(known - smallest < SMALL_CHANGE):
                break
        following -= diagonal[-1] * vector
        length = np.sqrt(_dot(following, following))
        beside.append(length)
        # Nothing follows an eigenvector.
        before, vector = vector, following / np.maximum(length, np.finfo(float).tiny)
    return smallest


def _smallest_tridiagonal(
    diagonal: Sequence[FloatArray], beside: Sequence[FloatArray]
) -> FloatArray:
    """Smallest eigenvalue of each of some symmetric matrices, by their diagonals."""
    size, count = len(diagonal), len(diagonal[0])
    rows = np.arange(size)
    matrices = np.zeros((count, size, size))
    matrices[:, rows, rows] = np.array(diagonal).T
    # Only the lower half is read.
    matrices[:, rows[1:], rows[:-1]] = np.reshape(beside, (size - 1, count)).T
    return np.asarray(np.linalg.eigvalsh(matrices)[:, 0])


def _dot(one: FloatArray, other: FloatArray) -> FloatArray:
    """Inner products of columns."""
    return np.asarray(np.einsum("ij,ij->j", one, other))
