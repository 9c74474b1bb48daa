"""The alpha = 0 state against closed forms."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import reference
from rod_states import first_states
from vibrissa.mechanics.buckling import buckling_load, buckling_mode
from vibrissa.mechanics.equations import bending_moment, ends
from vibrissa.mechanics.taper import arc_density, densities
from vibrissa.numerics.spectral import gauss_rule


@given(st.floats(1.0, 20.0))
def test_buckling_load_satisfies_its_equation(theta):
    root = theta * np.sqrt(buckling_load(np.array([theta]))[0])
    assert np.pi / 2 <= root < np.pi
    assert (theta - 1) * np.sin(root) + root * np.cos(root) == pytest.approx(0.0, abs=1e-12)


def test_buckling_load_of_a_cylinder_is_eulers():
    assert buckling_load(np.array([1.0]))[0] == pytest.approx(np.pi**2 / 4, rel=1e-15)


@given(st.floats(1.0, 8.0))
def test_buckling_mode_solves_the_linearised_beam(theta):
    # psi(s) = f * int B^-1 int psi, the integral equation at small deflection
    rule = gauss_rule(60)
    mode = buckling_mode(rule.nodes, np.array([theta]))[0]
    moment = rule.to_end @ (arc_density(rule.nodes, theta) * mode)
    bent = rule.from_start @ (densities(rule.nodes, theta)[1] * moment)
    assert buckling_load(np.array([theta]))[0] * bent == pytest.approx(mode, abs=1e-11)


@settings(max_examples=40, deadline=None)
@given(st.floats(0.03, 0.85))
def test_cylinder_at_alpha_zero_is_the_elliptic_elastica(modulus):
    eta, f, x1 = reference.elastica(modulus)
    states = first_states(np.array([1.0]), np.array([eta]), 48)
    assert -states.fy[0] == pytest.approx(f, rel=1e-9)
    assert ends(states).offset[0] == pytest.approx(x1, rel=1e-9)


@pytest.mark.parametrize("theta", [1.0, 2.0, 3.0, 8.0])
def test_force_tends_to_the_buckling_load_as_the_rod_straightens(theta):
    heights = np.array([0.99, 0.999, 0.9999])
    states = first_states(np.full(3, theta), heights, 48)
    excess = -states.fy - buckling_load(np.array([theta]))[0]
    # The force grows linearly with 1 - eta.
    assert excess[1:] / excess[:-1] == pytest.approx([0.1, 0.1], rel=0.05)


@settings(max_examples=40, deadline=None)
@given(st.floats(1.0, 12.0), st.floats(0.4, 0.999))
def test_initial_state_is_in_the_first_mode_and_bent_forward(theta, eta):
    states = first_states(np.array([theta]), np.array([eta]), 48)
    assert (bending_moment(states) < 0).all()
    assert ends(states).offset[0] > 0 > states.fy[0]


def test_deep_states_far_from_buckling_are_reached():
    states = first_states(np.array([20.0, 1.0]), np.array([0.3, 0.05]), 108)
    assert ends(states).height == pytest.approx([0.3, 0.05], abs=1e-10)
