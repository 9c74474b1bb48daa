"""Krawczyk's test on equations whose solutions are known."""

import pytest
from flint import arb, arb_mat

from validation.proof import NotProvedError
from validation.proof.krawczyk import krawczyk


def circle(at):
    """x² + y² = 1 and x = y."""
    x, y = at.entries()
    return arb_mat([[x * x + y * y - 1], [x - y]]), arb_mat([[2 * x, 2 * y], [1, -1]])


def tried(centre, radius):
    return krawczyk(circle, arb_mat([[arb(v)] for v in centre]), [radius, radius])


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
    with pytest.raises(NotProvedError, match="singular"):
        krawczyk(lambda at: (at * at, 2 * at), arb_mat([[0]]), [0.1])
