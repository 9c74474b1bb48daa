"""Sines and cosines against those of the math library."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from vibrissa.numerics.angles import direction


@given(st.lists(st.floats(-10.0, 10.0), min_size=1, max_size=20))
def test_sines_and_cosines_are_those_of_the_math_library(angles):
    found = direction(np.array(angles))
    assert np.abs(found.sin - [math.sin(angle) for angle in angles]).max() < 1e-15
    assert np.abs(found.cos - [math.cos(angle) for angle in angles]).max() < 1e-15


def test_right_and_straight_angles_have_no_pole():
    quarter = np.arange(-8, 9)
    found = direction(quarter * np.pi / 2)
    assert np.allclose(found.sin, [0, 1, 0, -1] * 4 + [0], rtol=0, atol=2e-15)
    assert np.allclose(found.cos, [1, 0, -1, 0] * 4 + [1], rtol=0, atol=2e-15)
