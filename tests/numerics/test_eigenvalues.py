"""Smallest eigenvalues of batches of operators."""

import numpy as np
import pytest

from vibrissa.numerics.eigenvalues import smallest_eigenvalue


def rotated(spectra, seed=0):
    """Symmetric matrices with given eigenvalues, shape (n, size), and their eigenvectors."""
    shape = (*spectra.shape, spectra.shape[1])
    vectors, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=shape))
    return (vectors * spectra[:, None]) @ np.swapaxes(vectors, 1, 2), vectors


class Matrices:
    """Operators by their matrices, in all of space or normal to one vector each."""

    def __init__(self, matrices, held=None):
        self.matrices, self.held, self.images = matrices, held, []

    def image(self, u):
        self.images.append(u.shape[1])
        return np.einsum("nij,jn->in", self.matrices, u)

    def free(self, u):
        return u if self.held is None else u - (self.held * u).sum(axis=0) * self.held

    def chosen(self, which):
        some = Matrices(self.matrices[which], None if self.held is None else self.held[:, which])
        some.images = self.images
        return some


def found(matrices, start, held=None):
    return smallest_eigenvalue(Matrices(matrices, held), start)


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


@pytest.mark.parametrize("size", [3, 12, 30])
def test_it_is_sought_among_free_vectors_alone(size):
    random = np.random.default_rng(2)
    index = np.arange(1, size + 1)
    matrices, _ = rotated(-np.outer([1.0, 2.0], 1.0 / index**2))
    held = random.normal(size=(size, 2))
    held /= np.linalg.norm(held, axis=0)
    aside = np.eye(size) - held.T[:, :, None] * held.T[:, None, :]
    expected = np.linalg.eigvalsh(aside @ matrices @ aside)[:, 0]
    start = random.normal(size=(size, 2))
    assert found(matrices, start, held) == pytest.approx(expected, abs=1e-9)


def test_an_eigenvalue_does_not_depend_on_its_company():
    index = np.arange(1, 41)
    spectra = np.stack([-1.0 / index**2.0, np.cos(index), -1.0 / index])
    matrices, _ = rotated(spectra)
    start = np.random.default_rng(1).normal(size=(40, 3))
    alone = [found(matrices[[k]], start[:, [k]])[0] for k in range(3)]
    assert found(matrices, start) == pytest.approx(alone, abs=1e-14)


def test_it_ends_as_soon_as_it_may():
    """Each step is an image of a batch: the most of what a margin of stability costs."""
    index = np.arange(1, 81)
    matrices, _ = rotated(np.stack([-1.0 / index**2.0, -np.sqrt(1.0 / index)]))
    operators = Matrices(matrices)
    smallest_eigenvalue(operators, np.random.default_rng(1).normal(size=(80, 2)))
    # The first one has converged after ten steps, and is left out.
    assert operators.images == [2] * 10 + [1] * 3
