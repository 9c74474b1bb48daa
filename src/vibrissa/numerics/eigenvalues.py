"""Smallest eigenvalues of symmetric operators, many at once, by Lanczos' iteration."""

from collections.abc import Callable, Sequence

import numpy as np

from vibrissa.numerics.arrays import FloatArray

# Steps after which the smallest eigenvalue is looked at for the first time, and then again.
FIRST_LOOK, LOOKS = 10, 2
# Residual of an eigenvector, of length 1, at which its eigenvalue is taken: the error of the
# eigenvalue is its square, divided by the distance to the next one.
RESIDUAL = 3e-6
# Length of a vector that is nothing but rounding.
NOTHING = 1e-14


def smallest_eigenvalue(
    operator: Callable[[FloatArray], FloatArray], start: FloatArray, normals: Sequence[FloatArray]
) -> FloatArray:
    """Smallest eigenvalues of symmetric operators in the spaces normal to some vectors.

    Parameters
    ----------
    operator : callable
        Applies the operators to vectors, shape (size, n).
    start : ndarray, shape (size, n)
        Where the eigenvectors are sought from.
    normals : sequence of ndarray, shape (size, n)
        Zero where there is none.

    Returns
    -------
    ndarray, shape (n,)
        NaN where an operator is not finite.

    Notes
    -----
    B. N. Parlett, The Symmetric Eigenvalue Problem, 1998, §13. Every vector is made orthogonal to
    all before. Where none is left, the iteration goes on with zeros, which have the eigenvalue 0.
    """
    known: list[FloatArray] = []
    for normal in normals:
        known.append(_unit(_orthogonal(normal, known)))
    vector = _unit(_orthogonal(start, known))
    diagonal, beside, smallest = [], [], start[0]
    for step in range(1, len(start) + 1):
        known.append(vector)
        image = operator(vector)
        diagonal.append(_product(vector, image))
        image = _orthogonal(image, known)
        beside.append(np.sqrt(_product(image, image)))
        if step == len(start) or (step >= FIRST_LOOK and (step - FIRST_LOOK) % LOOKS == 0):
            smallest, residual = _tridiagonal(np.array(diagonal), np.array(beside))
            if not (residual > RESIDUAL).any():
                break
        vector = _unit(image)
    return smallest


def _tridiagonal(diagonal: FloatArray, beside: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Smallest eigenvalues of tridiagonal matrices, and the residuals of their eigenvectors."""
    size = np.arange(len(diagonal))
    matrices = np.zeros((diagonal.shape[1], len(size), len(size)))
    matrices[:, size, size] = diagonal.T
    # Only the lower half is read.
    matrices[:, size[1:], size[:-1]] = beside[:-1].T
    finite = np.isfinite(matrices).all(axis=(1, 2))
    smallest, residual = np.full((2, len(matrices)), np.nan)
    values, vectors = np.linalg.eigh(matrices[finite])
    smallest[finite] = values[:, 0]
    residual[finite] = beside[-1, finite] * np.abs(vectors[:, -1, 0])
    return smallest, residual


def _orthogonal(vectors: FloatArray, units: Sequence[FloatArray]) -> FloatArray:
    for unit in units:
        vectors = vectors - _product(unit, vectors) * unit
    return vectors


def _unit(vectors: FloatArray) -> FloatArray:
    length = np.sqrt(_product(vectors, vectors))
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > NOTHING)


def _product(one: FloatArray, other: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("ij,ij->j", one, other))
