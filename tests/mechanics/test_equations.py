"""Equilibrium of the rod: equations, Jacobian, balance and convergence."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rod_states import first_states, made_states
from vibrissa import Mounting
from vibrissa.mechanics.equations import (
    FX,
    FY,
    OFFSET,
    ClosingCondition,
    bending_moment,
    coefficient_decay,
    ends,
    jacobian,
    largest_residual,
    residuals,
)
from vibrissa.mechanics.newton import solve, tangent
from vibrissa.mechanics.states import RodStates
from vibrissa.mechanics.taper import arc_density, densities
from vibrissa.numerics.spectral import gauss_rule


def at_offset(offset, height):
    """Prescribe x1 − x0: E3a."""
    return ClosingCondition.prescribing(height, {OFFSET: 1.0}, offset)


def sticking(theta, eta, travel, nodes=40):
    """States some travel (in units of x1_init) into the period of sticking."""
    eta = np.atleast_1d(eta).astype(float)
    states = first_states(theta, eta, nodes)
    offset = ends(states).offset
    for part in np.linspace(0.0, travel, 9):
        closing = at_offset(offset * (1.0 - part), eta)
        states, found, _ = solve(states, closing)
        assert found.all()
    return states, closing


pairs = st.tuples(st.floats(1.0, 4.0), st.floats(0.7, 0.95), st.floats(0.01, 0.4))
YIELDING = Mounting(clamp_angle=0.1, clamp_compliance=0.4, curvature=(0.5, -0.7, 0.3))
TUBE = Mounting(clamp_compliance=0.2, stiffening=(0.8, -1.1, 0.4), bore=0.35)


@pytest.mark.parametrize("s_c", [1.0, 0.9])
@pytest.mark.parametrize("mountings", [None, [YIELDING], [TUBE]])
def test_jacobian_is_the_derivative_of_the_residuals(s_c, mountings):
    rng = np.random.default_rng(1)
    nodes, h = 6, 1e-6
    states = made_states(2.3, rng.normal(size=nodes), 0.4, -1.3, s_c, mountings)
    one = np.ones(1)
    weights = rng.normal(size=(1, 5))
    closing = ClosingCondition(height=0.8 * one, tilt=0.3 * one, weights=weights, value=0.7 * one)
    derivative = jacobian(states, closing)[0]
    for column, step in enumerate(h * np.eye(nodes + 3)):
        after, before = (
            residuals(states.with_unknowns(states.unknowns + way), closing)[0]
            for way in (step, -step)
        )
        assert derivative[:, column] == pytest.approx((after - before) / (2 * h), abs=1e-8)


def test_the_tangent_is_the_derivative_of_the_states():
    states, closing = sticking(2.0, 0.85, 0.1, nodes=40)
    h = 1e-4
    found = tangent(states, closing)
    sides = [
        solve(states, at_offset(closing.value + way, closing.height)).states for way in (h, -h)
    ]
    difference = (sides[0].unknowns - sides[1].unknowns) / (2 * h)
    assert found.change == pytest.approx(difference, abs=2e-4)
    phi1 = (ends(sides[0]).phi1 - ends(sides[1]).phi1) / (2 * h)
    assert found.ends[0] == pytest.approx([1.0, *difference[0, -3:], phi1[0]], abs=2e-4)


def test_rods_solved_together_have_the_states_of_each_alone_though_one_is_solved_before():
    theta, eta = np.array([1.2, 2.0, 3.5]), np.array([0.9, 0.85, 0.8])
    first = first_states(theta, eta, 24)
    closing = at_offset(np.array([1.0, 0.9, 0.8]) * ends(first).offset, eta)
    together, found, _ = solve(first, closing)
    alone = [solve(first.take([row]), closing.take([row])).states.unknowns[0] for row in range(3)]
    assert found.all() and together.unknowns == pytest.approx(np.array(alone), abs=1e-11)


@settings(max_examples=25, deadline=None)
@given(pairs)
def test_states_balance_and_solve_the_equations_and_so_do_their_mirror_images(pair):
    states, closing = sticking(*pair, nodes=64)
    assert largest_residual(states, closing)[0] < 1e-12
    end = ends(states)
    assert end.moment == pytest.approx(states.fy * end.offset - states.fx * end.height, abs=1e-12)
    phi, fx, fy = np.pi - states.phi, -states.fx, states.fy
    mirrored = made_states(states.theta, phi, fx, fy)
    assert largest_residual(mirrored, at_offset(-closing.value, closing.height)) == pytest.approx(
        largest_residual(states, closing), abs=1e-13
    )


@pytest.mark.slow
@settings(max_examples=3, deadline=None)
@given(st.floats(1.0, 4.0), st.floats(0.7, 0.95))
def test_work_of_the_clamp_is_the_gain_of_bending_energy(theta, eta):
    def energy(states):
        rule = gauss_rule(states.nodes)
        compliance = densities(rule.nodes, states.theta[:, None])[1]
        return (0.5 * compliance * bending_moment(states) ** 2) @ rule.weights

    # Gauss quadrature of the clamp's force over its travel
    rule = gauss_rule(12)
    start, _ = sticking(theta, eta, 0.0)
    length = 0.3
    forces = [-sticking(theta, eta, length * t)[0].fx[0] for t in rule.nodes]
    work = rule.weights @ forces * length * ends(start).offset[0]
    end, _ = sticking(theta, eta, length)
    assert work > 0
    assert (energy(end) - energy(start))[0] == pytest.approx(work, rel=1e-7)


def test_error_falls_exponentially_with_the_nodes():
    exact, _ = sticking(3.0, 0.85, 0.3, nodes=60)
    errors = [abs(sticking(3.0, 0.85, 0.3, nodes=n)[0].fx[0] - exact.fx[0]) for n in (6, 9, 12, 15)]
    assert all(later < 0.1 * earlier for earlier, later in pairwise(errors))


def test_residual_and_decay_tell_when_the_nodes_do_not_suffice():
    coarse, fine = (sticking(4.0, 0.7, 0.4, nodes=nodes) for nodes in (10, 72))
    assert largest_residual(*coarse)[0] > 1e-5 > 1e-12 > largest_residual(*fine)[0]
    assert coefficient_decay(coarse[0])[0] > 1e-5 > 1e-12 > coefficient_decay(fine[0])[0]


@pytest.mark.parametrize(("place", "change"), [(-3, 1e-8), (-2, 1e-8), (-1, 1e-7), (3, 1e-7)])
def test_residual_sees_a_wrong_unknown(place, change):
    states, closing = sticking(2.0, 0.85, 0.1)
    states.unknowns[0, place] += 1e-6
    assert largest_residual(states, closing)[0] > change


def test_a_prescribed_inclination_gives_the_state_with_that_inclination():
    states, closing = sticking(2.0, 0.85, 0.1)
    alpha = np.arctan2(states.fx, -states.fy)
    inclined = {FX: np.cos(alpha), FY: np.sin(alpha)}
    again, found, _ = solve(states, ClosingCondition.prescribing(closing.height, inclined))
    assert found.all()
    assert ends(again).offset == pytest.approx(closing.value, abs=1e-12)


def test_one_hopeless_state_does_not_spoil_its_batch():
    good, closing = sticking(2.0, 0.85, 0.1)
    guess = RodStates.concatenate([good, good.with_unknowns(np.nan * good.unknowns)])
    both = at_offset(np.array([closing.value[0], -3.0]), np.array([0.85, 0.85]))
    states, converged, _ = solve(guess, both)
    assert converged.tolist() == [True, False]
    assert np.isnan(states.unknowns[1]).all()


def test_arc_density_integrates_to_the_rods_length():
    rule = gauss_rule(60)
    assert rule.weights @ arc_density(rule.nodes, 8.0) == pytest.approx(1.0, abs=1e-14)
