"""Geometry of the taper and the bending coordinate."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibrissa.mechanics import taper

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
def test_bending_coordinate_densities_follow_from_the_diameter(theta, s):
    tau, d = taper.bending_coordinate(s, theta), taper.diameter(s, theta)
    arc, compliance = taper.densities(tau, theta)
    assert arc == taper.arc_density(tau, theta) == pytest.approx(theta * d**2, rel=1e-12)
    assert compliance == pytest.approx(theta / d**2, rel=1e-12)


@given(thetas, st.floats(0.3, 1.0))
def test_arc_length_grows_by_its_density(theta, s_c):
    def error(n):
        tau = np.linspace(0.0, 1.0, n + 1)
        grown = np.append(0.0, np.cumsum(taper.arc_density((tau[1:] + tau[:-1]) / 2, theta, s_c)))
        return np.abs(taper.bending_coordinate(grown[-1] / n, theta, s_c) - 1.0)

    # The midpoint rule errs with the square of its step.
    assert error(4000) < 1e-4 and error(4000) < 0.3 * error(2000) + 1e-12


@given(thetas)
def test_bending_coordinate_spans_the_rod(theta):
    ends = taper.bending_coordinate(np.array([0.0, 1.0]), theta)
    assert ends == pytest.approx([0.0, 1.0], abs=1e-15)


@given(fractions)
def test_bending_coordinate_of_a_cylinder_is_the_arc_length(s):
    assert taper.bending_coordinate(s, 1.0) == s
