"""The alpha = 0 state against closed forms."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq
from scipy.special import jv, yv

import reference
from rod_states import first_states
from vibrissa import Mounting
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


def columns():
    """Buckling loads of columns of variable stiffness: coefficients of B, and the load (E·I0/L²).

    The moment obeys B·m'' + f·m = 0 with m'(0) = 0 and m(1) = 0: A. N. Dinnik, Trans. ASME 51
    (1929); S. P. Timoshenko, J. M. Gere, Theory of Elastic Stability, 2nd ed. 1963, p. 126. With z
    = 1 − k·s the solutions are √z times Bessel functions of order 1 for B = z, and √z times sine
    and cosine of a logarithm for B = z².
    """

    def linear(k):
        def condition(f):
            a, b = 2 * np.sqrt(f) / k * np.sqrt([1.0, 1.0 - k])
            # The derivative of √z·C1(2√(f·z)/k) is proportional to C0.
            return jv(0, a) * yv(1, b) - yv(0, a) * jv(1, b)

        return condition

    def square(k):
        def condition(f):
            # The exponents 1/2 ± i·β are real for small loads.
            beta = np.emath.sqrt(f / k**2 - 0.25)
            angle = beta * np.log(1.0 / (1.0 - k))
            return (0.5 * np.sinc(angle / np.pi) * angle / beta + np.cos(angle)).real

        return condition

    for k in (0.5, 0.9, -1.0):
        if k > 0.0:
            yield (-k,), linear(k)
        yield (-2 * k, k**2), square(k)


@pytest.mark.parametrize(("powers", "condition"), list(columns()))
def test_columns_of_variable_stiffness_buckle_at_their_published_loads(powers, condition):
    loads = np.linspace(0.02, 12.0, 1200)
    values = [condition(f) for f in loads]
    first = np.flatnonzero(np.diff(np.sign(values)))[0]
    load = brentq(condition, loads[first], loads[first + 1], xtol=1e-12)
    heights = np.array([0.9998, 0.9999])
    mountings = [Mounting(stiffening=powers)] * 2
    far, near = -first_states(np.ones(2), heights, 64, mountings=mountings).fy
    # The force grows linearly with 1 − η.
    assert 2 * near - far == pytest.approx(load, rel=2e-7)
