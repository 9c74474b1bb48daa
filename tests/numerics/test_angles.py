"""Sines and cosines against those of the math library."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibrissa.numerics.angles import FEWEST_BY_TANGENT, direction

# Few angles, and many: the same ones again and again.
few_and_many = pytest.mark.parametrize("size", [20, FEWEST_BY_TANGENT])


@few_and_many
@given(st.lists(st.floats(-10.0, 10.0), min_size=1, max_size=20))
def test_sines_and_cosines_are_those_of_the_math_library(size, angles):
    angles = np.resize(angles, size)
    found = direction(angles)
    assert np.abs(found.sin - [math.sin(angle) for angle in angles]).max() < 1e-15
    assert np.abs(found.cos - [math.cos(angle) for angle in angles]).max() < 1e-15


@few_and_many
def test_right_and_straight_angles_have_no_pole(size):
    quarter = np.resize(np.arange(-8, 8), size)
    found = direction(quarter * np.pi / 2)
    assert np.allclose(found.sin, np.resize([0, 1, 0, -1], size), rtol=0, atol=2e-15)
    assert np.allclose(found.cos, np.resize([1, 0, -1, 0], size), rtol=0, atol=2e-15)
