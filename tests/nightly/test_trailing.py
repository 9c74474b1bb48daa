"""Last sticking states of rods that have swung aside, by multiple shooting."""

from dataclasses import replace

import numpy as np
import pytest

from validation import trailing
from vibrissa import solve_curve


# The last three need several parts: shooting in one did not converge.
@pytest.mark.slow
@pytest.mark.parametrize(
    ("theta", "eta", "mu0", "contact"),
    [
        (1.0, 0.85, 0.9, "point"),
        (8.0, 0.5, 1.0, "line"),
        (18.741, 0.36185, 1.0587, "point"),
        (19.928, 0.47369, 0.7045, "line"),
    ],
)
def test_the_last_sticking_state_is_that_of_multiple_shooting(theta, eta, mu0, contact):
    curve = solve_curve(theta, eta, contact=contact)
    difference, gap = trailing.checked(curve, mu0, np.random.default_rng(1))
    assert difference < 1e-12 and gap < 1e-11


def test_a_state_at_another_place_is_noticed():
    curve = solve_curve(2.0, 0.85)
    moved = replace(curve, x1_init=curve.x1_init + 1e-9)
    difference, _ = trailing.checked(moved, 0.9, np.random.default_rng(1))
    assert difference == pytest.approx(1e-9, rel=1e-3)


def test_friction_that_the_curve_was_not_followed_to_is_not_checked():
    assert trailing.checked(solve_curve(2.0, 0.85), 50.0, np.random.default_rng(1)) is None
