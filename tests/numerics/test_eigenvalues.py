"""Smallest eigenvalues by Lanczos' iteration, beside those of dense matrices."""

import numpy as np
import pytest

from vibrissa.numerics.eigenvalues import smallest_eigenvalue


def made(size, count, decay):
    """Symmetric matrices with eigenvalues −1, −decay, −decay², …, as smooth operators have them."""
    random = np.random.default_rng(size)
    vectors = np.linalg.qr(random.normal(size=(count, size, size)))[0]
    matrices = -np.einsum("nik,k,njk->nij", vectors, decay ** np.arange(size), vectors)
    return matrices, *random.normal(size=(2, size, count))


@pytest.mark.parametrize(("size", "decay"), [(3, 0.3), (9, 0.5), (30, 0.7), (40, 0.3)])
def test_it_is_that_of_the_matrix_in_the_space_normal_to_a_vector(size, decay):
    matrices, start, normal = made(size, 5, decay)
    found = smallest_eigenvalue(lambda u: np.einsum("nij,jn->in", matrices, u), start, [normal])
    for matrix, unit, value in zip(matrices, normal.T, found, strict=True):
        unit = unit / np.linalg.norm(unit)
        held = np.eye(size) - np.outer(unit, unit)
        assert value == pytest.approx(np.linalg.eigvalsh(held @ matrix @ held)[0], abs=1e-9)


def test_an_operator_that_is_not_finite_has_none_and_spoils_no_other():
    matrices, start, normal = made(12, 3, 0.5)
    matrices[1] = np.nan
    found = smallest_eigenvalue(lambda u: np.einsum("nij,jn->in", matrices, u), start, [normal])
    assert np.isfinite(found).tolist() == [True, False, True]


@pytest.mark.parametrize("rank", [2, 5])
def test_an_operator_that_converges_early_stays_right_beside_one_that_needs_more_steps(rank):
    """Its later Lanczos vectors are made of what rounding leaves, and stay in the subspace."""
    size = 40
    matrices, start, normal = made(size, 2, 0.9)
    normal /= np.linalg.norm(normal, axis=0)
    held = np.eye(size) - np.einsum("in,jn->nij", normal, normal)
    few = held[0] @ np.random.default_rng(1).normal(size=(size, rank))
    matrices[0] = -few @ few.T
    # The image of a vector in the subspace has a large part along the normal.
    coupled = 100.0 * np.outer(held[0] @ np.random.default_rng(2).normal(size=size), normal[:, 0])
    matrices[0] += coupled + coupled.T
    found = smallest_eigenvalue(lambda u: np.einsum("nij,jn->in", matrices, u), start, [normal])
    expected = np.linalg.eigvalsh(held @ matrices @ held)[:, 0]
    assert found == pytest.approx(expected, rel=1e-9)
