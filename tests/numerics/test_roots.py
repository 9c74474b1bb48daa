"""Roots in brackets."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import lambertw

from vibrissa.numerics.roots import bracketed_root


@given(st.lists(st.floats(1e-6, 50.0), min_size=1, max_size=5))
def test_roots_are_those_of_a_closed_form(values):
    c = np.array(values)
    low, high = np.zeros_like(c), 1.0 + np.log1p(c)
    root = bracketed_root(lambda x, c: (x * np.exp(x) - c, (1 + x) * np.exp(x)), low, high, c)
    assert root == pytest.approx(lambertw(c).real, rel=1e-14, abs=1e-15)


def test_a_root_that_is_not_simple_is_found_without_slopes():
    root = bracketed_root(lambda x: ((x - 0.3) ** 3, 0.0 * x), np.array([0.0]), np.array([1.0]))
    assert root[0] == pytest.approx(0.3, abs=1e-5)


@pytest.mark.parametrize("end", [0.25, 0.5])
def test_an_end_that_is_a_root_up_to_rounding_is_returned(end):
    offset = 1e-17 if end == 0.25 else -1e-17
    root = bracketed_root(
        lambda x: (x - end + offset, np.ones_like(x)), np.array([0.25]), np.array([0.5])
    )
    assert root[0] == end


def test_newton_leads_out_of_no_bracket():
    # From the middle it goes far beyond.
    root = bracketed_root(
        lambda x: (np.arctan(20 * (x - 0.9)), 20 / (1 + (20 * (x - 0.9)) ** 2)),
        np.array([0.0, 0.8]),
        np.array([1.0, 1.0]),
    )
    assert root == pytest.approx([0.9, 0.9], abs=1e-14)
