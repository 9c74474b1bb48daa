"""Krawczyk's test on equations whose solutions are known."""

import pytest
from flint import arb, arb_mat

from validation.proof import NotProvedError
from validation.proof.krawczyk import krawczyk


def tried(centre, radius):
    """x² + y² = 1 and x = y."""
    point = arb_mat([[arb(v)] for v in centre])
    box = arb_mat([[arb(v, radius)] for v in centre])
    x, y = point.entries()
    values = arb_mat([[x * x + y * y - 1], [x - y]])
    x, y = box.entries()
    return krawczyk(point, values, box, arb_mat([[2 * x, 2 * y], [1, -1]]))


def test_the_solution_is_enclosed():
    for value in tried((0.7, 0.72), 0.05).entries():
        assert value.contains((arb(1) / 2).sqrt()) and value.rad() < 0.01


@pytest.mark.parametrize("centre", [(0.8, 0.8), (0.7071, 0.7077), (0.6, 0.7)])
def test_a_box_without_it_is_refused(centre):
    with pytest.raises(NotProvedError, match="fails"):
        tried(centre, 1e-4)


def test_a_box_with_two_solutions_is_refused():
    with pytest.raises(NotProvedError):
        tried((0.1, 0.1), 2.0)


def test_a_double_root_is_refused():
    box, zero = arb_mat([[arb(0, 0.1)]]), arb_mat([[0]])
    with pytest.raises(NotProvedError, match="singular"):
        krawczyk(zero, zero, box, 2 * box)
