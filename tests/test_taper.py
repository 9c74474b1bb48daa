"""Geometry of the taper and the bending coordinate."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibrissa import taper

thetas = st.floats(1.0, 20.0)
fractions = st.floats(0.0, 1.0)


@given(thetas)
def test_diameter_falls_from_base_to_tip_by_theta(theta):
    assert taper.diameter(0.0, theta) == 1.0
    assert taper.diameter(1.0, theta) == pytest.approx(1.0 / theta, rel=1e-14)


@given(thetas, fractions)
def test_stiffness_is_the_one_of_paper_equation_2(theta, s):
    paper = (theta * s - theta - s) ** 4 / theta**4
    assert taper.stiffness(s, theta) == pytest.approx(paper, rel=1e-12)


@given(thetas, fractions)
def test_bending_coordinate_densities_follow_from_the_diameter(theta, tau):
    d = taper.diameter(taper.arc_length(tau, theta), theta)
    assert taper.arc_density(tau, theta) == pytest.approx(theta * d**2, rel=1e-12)
    assert taper.compliance_density(tau, theta) == pytest.approx(theta / d**2, rel=1e-12)


@given(thetas)
def test_bending_coordinate_spans_the_rod(theta):
    ends = taper.arc_length(np.array([0.0, 1.0]), theta)
    assert ends == pytest.approx([0.0, 1.0], abs=1e-15)


@given(fractions)
def test_bending_coordinate_of_a_cylinder_is_the_arc_length(tau):
    assert taper.arc_length(tau, 1.0) == tau
