"""Equilibrium of the rod: equations, Jacobian, balance and convergence."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibrissa.mechanics import equations, newton
from vibrissa.mechanics.buckling import initial_states
from vibrissa.mechanics.equations import (
    Closure,
    bending_moment,
    coefficient_decay,
    contact_position,
    ends,
    jacobian,
    largest_residual,
    residuals,
)
from vibrissa.mechanics.newton import solve
from vibrissa.mechanics.states import RodStates
from vibrissa.mechanics.taper import arc_density, densities
from vibrissa.numerics.spectral import gauss_rule
from vibrissa.outcomes import Contact


def sticking(theta, eta, travel, nodes=40):
    """States some travel (in units of x1_init) into the period of sticking."""
    theta, eta = np.atleast_1d(theta).astype(float), np.atleast_1d(eta).astype(float)
    states, found = initial_states(theta, eta, nodes)
    assert found.all()
    offset = contact_position(states)[0]
    for part in np.linspace(0.0, travel, 9)[1:]:
        closure = Closure.at_offset(offset * (1.0 - part))
        states, found, _ = solve(states, eta, closure)
        assert found.all()
    return states, eta, closure


DIRECTION = np.array([[0.4, -0.7, 0.5, 0.3]])
pairs = st.tuples(st.floats(1.0, 4.0), st.floats(0.7, 0.95), st.floats(0.01, 0.4))


@pytest.mark.parametrize(
    "closure",
    [
        Closure.at_offset(np.array([0.3])),
        Closure.at_inclination(np.array([-0.4])),
        Closure.at_advance(np.array([0.7]), DIRECTION, np.array([0.6]), np.array([2.7])),
        Closure.at_switch(1),
        Closure.at_offset(np.array([0.3]), Contact.LINE),
        Closure.at_inclination(np.array([-0.4]), Contact.LINE),
        Closure.at_advance(
            np.array([0.7]), DIRECTION, np.array([0.6]), np.array([2.7]), Contact.LINE
        ),
    ],
)
def test_jacobian_is_the_derivative_of_the_residuals(closure):
    rng = np.random.default_rng(1)
    nodes, h = 6, 1e-6
    theta, eta = np.array([2.3]), np.array([0.8])
    line = closure.contact is Contact.LINE
    unknowns = np.append(rng.normal(size=nodes + 2), 0.9 if line else 1.0)

    def system(u):
        fx, fy, s_c = u[nodes:, None]
        state = RodStates(theta=theta, phi=u[None, :nodes], fx=fx, fy=fy, s_c=s_c)
        return state, residuals(state, eta, closure)[0]

    derivative = jacobian(system(unknowns)[0], closure)[0]
    # In point contact the last unknown, s_c, is known.
    for column in range(nodes + 3 if line else nodes + 2):
        step = h * np.eye(nodes + 3)[column]
        difference = (system(unknowns + step)[1] - system(unknowns - step)[1]) / (2 * h)
        # in single precision
        assert derivative[:, column] == pytest.approx(difference, rel=1e-6, abs=1e-6)


@settings(max_examples=25, deadline=None)
@given(pairs)
def test_equations_hold_between_the_nodes(pair):
    states, eta, closure = sticking(*pair, nodes=64)
    assert largest_residual(states, eta, closure)[0] < 1e-12


@settings(max_examples=25, deadline=None)
@given(pairs)
def test_clamp_moment_balances_the_tip_force(pair):
    states, eta, _ = sticking(*pair)
    offset, _ = contact_position(states)
    assert ends(states).moment == pytest.approx(states.fy * offset - states.fx * eta, abs=1e-12)


@pytest.mark.slow
@settings(max_examples=15, deadline=None)
@given(st.floats(1.0, 4.0), st.floats(0.7, 0.95))
def test_work_of_the_clamp_is_the_gain_of_bending_energy(theta, eta):
    def energy(states):
        rule = gauss_rule(states.nodes)
        compliance = densities(rule.nodes, states.theta[:, None])[1]
        return (0.5 * compliance * bending_moment(states) ** 2) @ rule.weights

    # Gauss quadrature of the clamp's force over its travel
    rule = gauss_rule(12)
    start, _, _ = sticking(theta, eta, 0.0)
    x1_init = contact_position(start)[0][0]
    length = 0.3
    forces = [-sticking(theta, eta, length * t)[0].fx[0] for t in rule.nodes]
    work = rule.weights @ forces * length * x1_init
    end, _, _ = sticking(theta, eta, length)
    assert work > 0
    assert (energy(end) - energy(start))[0] == pytest.approx(work, rel=1e-7)


@settings(max_examples=15, deadline=None)
@given(pairs)
def test_mirror_image_of_a_solution_solves_the_mirrored_problem(pair):
    states, eta, closure = sticking(*pair)
    mirrored = replace(states, phi=np.pi - states.phi, fx=-states.fx)
    assert largest_residual(mirrored, eta, Closure.at_offset(-closure.value)) == pytest.approx(
        largest_residual(states, eta, closure), abs=1e-13
    )


def test_error_falls_exponentially_with_the_nodes():
    exact, _, _ = sticking(3.0, 0.85, 0.3, nodes=60)
    errors = [abs(sticking(3.0, 0.85, 0.3, nodes=n)[0].fx[0] - exact.fx[0]) for n in (6, 9, 12, 15)]
    assert all(later < 0.1 * earlier for earlier, later in pairwise(errors))


def test_residual_and_decay_tell_when_the_nodes_do_not_suffice():
    coarse, fine = (sticking(4.0, 0.7, 0.4, nodes=nodes) for nodes in (10, 72))
    assert largest_residual(*coarse)[0] > 1e-5 > 1e-12 > largest_residual(*fine)[0]
    assert coefficient_decay(coarse[0])[0] > 1e-5 > 1e-12 > coefficient_decay(fine[0])[0]


def test_residual_sees_a_wrong_force_and_a_wrong_height():
    states, eta, closure = sticking(2.0, 0.85, 0.1)
    assert largest_residual(replace(states, fx=states.fx + 1e-6), eta, closure)[0] > 1e-8
    assert largest_residual(states, eta + 1e-6, closure)[0] > 1e-7
    assert largest_residual(states, eta, Closure.at_offset(closure.value + 1e-6))[0] > 1e-7


def test_a_prescribed_inclination_gives_the_state_with_that_inclination():
    states, eta, closure = sticking(2.0, 0.85, 0.1)
    alpha = np.arctan2(states.fx, -states.fy)
    again, found, _ = solve(states, eta, Closure.at_inclination(alpha))
    assert found.all()
    assert contact_position(again)[0] == pytest.approx(closure.value, abs=1e-12)


def test_one_hopeless_state_does_not_spoil_its_batch():
    good, _, closure = sticking(2.0, 0.85, 0.1)
    guess = RodStates.concatenate([good, good.unsolved()])
    both = Closure.at_offset(np.array([closure.value[0], -3.0]))
    states, converged, _ = solve(guess, np.array([0.85, 0.85]), both)
    assert converged.tolist() == [True, False]
    assert np.isnan(states.fx[1]) and np.isnan(states.phi[1]).all()


def test_states_are_the_same_however_many_are_solved_together(monkeypatch):
    states, eta, _ = sticking([1.5, 2.0, 2.5, 3.0], [0.8, 0.85, 0.9, 0.75], 0.1)
    wrong = replace(states, phi=states.phi * (1.0 + 1e-3 * np.arange(1, 5))[:, None])
    closure = Closure.at_offset(contact_position(states)[0] - 0.01 * np.arange(4))
    whole, measured = solve(wrong, eta, closure), largest_residual(wrong, eta, closure)
    for module in (equations, newton):
        monkeypatch.setattr(module, "VALUES_TOGETHER", 3 * states.nodes)
    some = solve(wrong, eta, closure)
    assert whole.converged.all() and some.converged.all()
    assert some.states.phi == pytest.approx(whole.states.phi, abs=1e-12)
    assert some.states.fx == pytest.approx(whole.states.fx, rel=1e-11)
    assert some.inverse == pytest.approx(whole.inverse, rel=1e-4, abs=1e-4)
    assert largest_residual(wrong, eta, closure) == pytest.approx(measured, rel=1e-9)
    assert largest_residual(some.states, eta, closure).max() < 1e-12


def test_contact_slope_superconverges():
    fine, _, _ = sticking(2.0, 0.85, 0.2, nodes=60)
    coarse, _, _ = sticking(2.0, 0.85, 0.2, nodes=14)
    polynomial = coarse.phi[0] @ gauss_rule(14).to_coefficients.T  # all P_k(1) = 1
    exact = ends(fine).phi1[0]
    assert abs(ends(coarse).phi1[0] - exact) < 0.01 * abs(polynomial.sum() - exact)


def test_arc_density_integrates_to_the_rods_length():
    rule = gauss_rule(60)
    assert rule.weights @ arc_density(rule.nodes, 8.0) == pytest.approx(1.0, abs=1e-14)
