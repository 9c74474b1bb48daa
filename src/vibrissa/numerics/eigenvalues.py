"""Smallest eigenvalues of symmetric operators, many at once, by what they do to vectors."""

from typing import Protocol, Self

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray

# Steps after which the smallest eigenvalue is looked at for the first time, and then again.
FIRST_LOOK, LOOKS = 10, 3
# Square of the residual of an eigenvector, of length 1, at which its eigenvalue is taken.
SMALL_RESIDUAL = 1e-11
# Part of the largest element of a tridiagonal matrix below which one beside its diagonal is zero.
NOTHING = 1e-13


class Operators(Protocol):
    """A batch of symmetric operators, each in a space of its own."""

    def image(self, u: FloatArray) -> FloatArray:
        """Apply each to a vector of its space, shape (size, n); a new array."""

    def free(self, u: FloatArray) -> FloatArray:
        """Project vectors, shape (size, n), orthogonally to these spaces, in place."""

    def chosen(self, which: BoolArray) -> Self:
        """Select operators."""


def smallest_eigenvalue(operators: Operators, start: FloatArray) -> FloatArray:
    """Find the smallest eigenvalue of each of some symmetric operators by Lanczos' iteration.

    Parameters
    ----------
    operators : Operators
        A vector's image may leave the space: what counts is its projection.
    start : ndarray, shape (size, n)
        Vectors to begin with: the nearer to the eigenvectors, the fewer steps.

    Returns
    -------
    ndarray, shape (n,)
        To 1e-11 at most, divided by the distance to the next eigenvalue.

    Notes
    -----
    An eigenvalue's error is at most the square of the residual of its eigenvector, divided by the
    distance to the next one (B. N. Parlett, The Symmetric Eigenvalue Problem, 1998, §11.7). The
    vectors lose their orthogonality where an eigenvalue has converged. That gives an eigenvalue
    twice, and not another one (C. C. Paige, Linear Algebra Appl. 34 (1980) 235).
    """
    size, count = start.shape
    found, rows = np.empty(count), np.arange(count)
    # The operators in the space of the vectors so far are tridiagonal.
    diagonal, beside = np.empty((size, count)), np.empty((size, count))
    before, length, largest = np.zeros_like(start), np.zeros(count), np.zeros(count)
    ended = np.zeros(count, dtype=bool)
    vector = operators.free(start.copy())
    vector /= np.linalg.norm(vector, axis=0)
    for step in range(size):
        following = operators.image(vector)
        following -= length * before
        # Behind an end, the quotient of the first vector: it is not the smallest.
        diagonal[step] = np.where(ended, diagonal[0], _dot(following, vector))
        following -= diagonal[step] * vector
        # Here, as what little is left of what is not free would grow from step to step.
        following = operators.free(following)
        length = np.sqrt(_dot(following, following))
        beside[step] = length
        largest = np.maximum(largest, np.maximum(length, np.abs(diagonal[step])))
        # Nothing but rounding follows an eigenvector.
        ended = length <= NOTHING * largest
        length[ended] = 0.0
        before, vector = vector, following / np.where(ended, np.inf, length)
        known = step + 1
        if known == size or (known >= FIRST_LOOK and (known - FIRST_LOOK) % LOOKS == 0):
            found[rows], residual = _smallest_tridiagonal(diagonal[:known], beside[:known])
            left = residual**2 > SMALL_RESIDUAL
            if not left.any():
                break
            rows, operators, ended = rows[left], operators.chosen(left), ended[left]
            length, largest = length[left], largest[left]
            diagonal, beside = diagonal[:, left], beside[:, left]
            before, vector = before[:, left], vector[:, left]
    return found


def _smallest_tridiagonal(
    diagonal: FloatArray, beside: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Smallest eigenvalue of each of some symmetric matrices, and its eigenvector's residual.

    Both arguments have the shape (size, n). The last row of `beside` is what the residual is of: it
    is that times the last component of the eigenvector, 1/√(−d') with the slope d' of the last
    pivot.
    """
    size, count = diagonal.shape
    rows = np.arange(size)
    matrices = np.zeros((count, size, size))
    matrices[:, rows, rows] = diagonal.T
    # Only the lower half is read.
    matrices[:, rows[1:], rows[:-1]] = beside[:-1].T
    smallest = np.asarray(np.linalg.eigvalsh(matrices)[:, 0])
    pivot, slope = diagonal[0] - smallest, -np.ones(count)
    # A pivot of 0 has no part in the eigenvector.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for element, side in zip(diagonal[1:] - smallest, beside, strict=False):
            coupled = side**2 / pivot
            pivot, slope = element - coupled, coupled / pivot * slope - 1.0
        return smallest, np.nan_to_num(beside[-1] / np.sqrt(-slope))


def _dot(one: FloatArray, other: FloatArray) -> FloatArray:
    """Inner products of columns."""
    return np.asarray(np.einsum("ij,ij->j", one, other))
