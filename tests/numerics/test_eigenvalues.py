"""Smallest eigenvalues of batches of operators."""

import numpy as np
import pytest

from vibrissa.numerics.eigenvalues import smallest_eigenvalue


def rotated(spectra, seed=0):
    """Symmetric matrices with given eigenvalues, shape (n, size), and their eigenvectors."""
    shape = (*spectra.shape, spectra.shape[1])
    vectors, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=shape))
    return (vectors * spectra[:, None]) @ np.swapaxes(vectors, 1, 2), vectors


def found(matrices, start):
    return smallest_eigenvalue(lambda u: np.einsum("nij,jn->in", matrices, u), start)


@pytest.mark.parametrize("size", [1, 2, 5, 9, 30, 80])
def test_it_is_that_of_compact_operators_of_any_size(size):
    # As of an integral operator: both signs, and ever smaller.
    index = np.arange(1, size + 1)
    spectra = -np.outer([1.0, 0.3, 2.0], (-1.0) ** index / index**2)
    spectra[1] *= -1.0
    matrices, _ = rotated(spectra)
    start = np.random.default_rng(1).normal(size=(size, 3))
    assert found(matrices, start) == pytest.approx(spectra.min(axis=1), abs=1e-9)


def test_what_begins_with_an_eigenvector_has_its_eigenvalue():
    spectra = np.linspace(-1.0, 3.0, 24) * np.ones((2, 1))
    matrices, vectors = rotated(spectra)
    assert found(matrices, vectors[:, :, 0].T) == pytest.approx(-1.0, abs=1e-12)


def test_operators_do_not_disturb_each_other():
    """One that converges at once waits for one that does not."""
    size = 60
    slow, fast = np.linspace(-1.0, 1.0, size), np.zeros(size)
    fast[0] = -5.0
    spectra = np.stack([slow, fast])
    matrices, vectors = rotated(spectra)
    start = np.stack([np.ones(size), vectors[1, :, 0] + 1e-3], axis=1)
    assert found(matrices, start) == pytest.approx([-1.0, -5.0], abs=1e-9)


def test_zero_has_zero():
    assert found(np.zeros((1, 12, 12)), np.ones((12, 1))) == pytest.approx(0.0, abs=1e-300)


def test_it_ends_as_soon_as_it_may():
    """Each step is an image of a whole batch: the most of what a margin of stability costs."""
    index = np.arange(1, 81)
    matrices, _ = rotated(-1.0 / index[None] ** 2.0)
    steps = []

    def image(u):
        steps.append(1)
        return np.einsum("nij,jn->in", matrices, u)

    smallest_eigenvalue(image, np.random.default_rng(1).normal(size=(80, 1)))
    assert len(steps) == 14
