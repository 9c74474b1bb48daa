"""Inverses of many small matrices."""

import numpy as np
import pytest

from vibrissa.numerics.inverses import FEWEST, LARGEST, TOGETHER, inverses

LAST = 3


def near_identity(count, size, seed=0):
    """Matrices like Jacobians: the identity and a bit, but for the end, where pivots are zero."""
    random = np.random.default_rng(seed)
    matrices = np.eye(size) + 0.3 / np.sqrt(size) * random.normal(size=(count, size, size))
    matrices[:, -LAST:, -LAST:] = np.eye(LAST)[::-1]
    return matrices.astype(np.float32)


@pytest.mark.parametrize("size", [4, 13, LARGEST, LARGEST + 1])
@pytest.mark.parametrize("count", [1, FEWEST - 1, FEWEST, TOGETHER + 1])
def test_they_are_inverses(count, size):
    matrices = near_identity(count, size)
    before = matrices.copy()
    found = inverses(matrices, LAST)
    assert found.dtype == np.float32
    expected = np.linalg.inv(matrices.astype(float))
    scale = np.abs(expected).max(axis=(1, 2), keepdims=True)
    assert (found / scale) == pytest.approx(expected / scale, abs=1e-4)
    assert np.array_equal(matrices, before)


def test_pivots_at_the_end_may_be_zero():
    """As of what closes the equations of a rod: there the order of rows is not that of columns."""
    matrices = np.zeros((FEWEST, 5, 5), dtype=np.float32)
    matrices[:] = np.eye(5)[[0, 1, 3, 4, 2]]
    matrices[:, 0, 1] = np.arange(FEWEST)
    expected = np.linalg.inv(matrices.astype(float))
    assert inverses(matrices, LAST) == pytest.approx(expected, abs=1e-6)


def test_a_singular_end_is_told():
    matrices = near_identity(FEWEST, 8)
    matrices[5, -1] = 0.0
    with pytest.raises(np.linalg.LinAlgError):
        inverses(matrices, LAST)


@pytest.mark.parametrize("pivot", [0.0, 1e-4, 1e-2, 0.09])
def test_small_pivots_take_no_digits(pivot):
    """As of a rod near its buckling load."""
    matrices = near_identity(FEWEST, 8)
    matrices[3, :2] = 0.0
    matrices[3, :2, :2] = [[pivot, 1.0], [1.0, 0.0]]
    found = inverses(matrices, LAST)
    products = matrices.astype(float) @ found
    assert np.abs(products - np.eye(8)).max() < 1e-4
