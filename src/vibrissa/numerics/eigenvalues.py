"""Smallest eigenvalues of symmetric operators, many at once, by Lanczos' iteration."""

from collections.abc import Callable, Sequence

import numpy as np

from vibrissa.numerics.arrays import FloatArray

# Steps before the first check of convergence, and between later checks.
FIRST_CHECK, STEPS_BETWEEN_CHECKS = 8, 2
# Change between two checks below which an eigenvalue is accepted. Convergence is so fast that its
# error is then a hundredth of this.
ACCEPTED_CHANGE = 1e-9
# Length below which a vector consists of rounding errors.
ROUNDED_LENGTH = 1e-14


def smallest_eigenvalue(
    operator: Callable[[FloatArray], FloatArray], start: FloatArray, normals: Sequence[FloatArray]
) -> FloatArray:
    """Smallest eigenvalue of each of n symmetric operators, restricted to a subspace.

    In arrays of the shape (size, n), column i has a vector for operator i. The subspace of operator
    i consists of the vectors that are orthogonal to column i of all `normals`.

    Parameters
    ----------
    operator : callable
        Applies operator i to column i of an array, for all i; returns an array of the same shape.
    start : ndarray, shape (size, n)
        Guesses of the eigenvectors; an eigenvector orthogonal to its guess is missed.
    normals : sequence of ndarray, shape (size, n)
        Vectors normal to the subspaces; a column of zeros does not restrict its subspace.

    Returns
    -------
    ndarray, shape (n,)
        Smallest eigenvalues; NaN where an operator is not finite.

    Notes
    -----
    B. N. Parlett, The Symmetric Eigenvalue Problem, 1998, §13. Every Lanczos vector is made
    orthogonal to all earlier vectors.
    """
    first = len(normals)
    known = np.empty((first + len(start), *start.shape))
    for number, normal in enumerate(normals):
        known[number] = _unit(_orthogonal(normal, known[:number]))
    vector = _unit(_orthogonal(start, known[:first]))
    diagonal: list[FloatArray] = []
    beside: list[FloatArray] = []
    smallest = np.full(start.shape[1], np.inf)
    for step in range(1, len(start) + 1):
        known[first + step - 1] = vector
        image = operator(vector)
        diagonal.append(_product(vector, image))
        checks = step >= FIRST_CHECK and (step - FIRST_CHECK) % STEPS_BETWEEN_CHECKS == 0
        if checks or step == len(start):
            before, smallest = smallest, _smallest(np.array(diagonal), np.array(beside))
            if not (np.abs(smallest - before) > ACCEPTED_CHANGE).any():
                break
        # Twice: what is left of an operator that has converged is small beside what is taken away,
        # and after one pass its rounding errors would leave the subspace.
        for _ in range(2):
            image = _orthogonal(image, known[: first + step])
        beside.append(np.sqrt(_product(image, image)))
        vector = _unit(image)
    return smallest


def _smallest(diagonal: FloatArray, beside: FloatArray) -> FloatArray:
    """Smallest eigenvalues of tridiagonal matrices; NaN where a matrix is not finite."""
    size = np.arange(len(diagonal))
    matrices = np.zeros((diagonal.shape[1], len(size), len(size)))
    matrices[:, size, size] = diagonal.T
    # eigvalsh reads only the lower half.
    matrices[:, size[1:], size[:-1]] = beside.T
    finite = np.isfinite(matrices).all(axis=(1, 2))
    smallest = np.full(len(matrices), np.nan)
    smallest[finite] = np.linalg.eigvalsh(matrices[finite])[:, 0]
    return smallest


def _orthogonal(vectors: FloatArray, units: FloatArray) -> FloatArray:
    """Make vectors orthogonal to `units`, which are orthonormal, with the shape (k, size, n)."""
    shares = np.einsum("kij,ij->kj", units, vectors)
    return np.asarray(vectors - np.einsum("kij,kj->ij", units, shares))


def _unit(vectors: FloatArray) -> FloatArray:
    length = np.sqrt(_product(vectors, vectors))
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > ROUNDED_LENGTH)


def _product(one: FloatArray, other: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("ij,ij->j", one, other))
