"""Stability out of the plane, against closed forms and a chain in space."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from validation import stiffness
from validation.rod_chain import Chain
from vibrissa import Mounting, solve_curve, solve_state
from vibrissa.mechanics import lateral
from vibrissa.mechanics.lateral import lateral_stability
from vibrissa.mechanics.mounting import IDEAL
from vibrissa.outcomes import Contact
from vibrissa.sticking.solving.offsets import solve_offset


def solved(theta, eta, offset, contact="point", mounting=IDEAL):
    return solve_offset(theta, eta, mounting, offset, Contact(contact)).state


def margin(theta, eta, offset, contact="point", mounting=IDEAL):
    return float(lateral_stability(solved(theta, eta, offset, contact, mounting))[0])


@pytest.mark.parametrize(
    ("theta", "eta", "mounting"),
    [
        (1.0, 0.85, Mounting(clamp_angle=0.1)),
        (4.0, 0.6, Mounting(clamp_angle=-0.1)),
        (2.0, 0.7, Mounting(clamp_compliance=0.5)),
        (12.0, 0.8, Mounting(clamp_angle=-0.05, clamp_compliance=0.2)),
    ],
)
def test_of_a_straight_rod_it_vanishes_on_the_axis_of_the_unloaded_clamp(theta, eta, mounting):
    on_axis = -eta * np.tan(mounting.clamp_angle)
    margins = [margin(theta, eta, on_axis + d, mounting=mounting) for d in (-0.02, 0.0, 0.02)]
    assert margins[0] < 0 < margins[2]
    assert margins[1] == pytest.approx(0.0, abs=1e-10)


@pytest.mark.slow
def test_of_a_curved_rod_it_vanishes_elsewhere():
    # To first order where the mean bend, in the sense of the curvature, makes up for the way.
    places = [
        brentq(lambda x: margin(3.0, 0.8, x, mounting=Mounting(curvature=k)), -0.1, 0.1, xtol=1e-10)  # noqa: B023
        for k in (-0.02, -0.01, 0.01)
    ]
    assert places[0] == pytest.approx(2 * places[1], rel=0.05)
    assert places[1] == pytest.approx(-places[2], rel=0.1)
    assert 1e-4 < places[1] < 1e-2


@pytest.mark.slow
@settings(max_examples=4, deadline=None)
@given(st.floats(1.0, 15.0), st.floats(0.4, 0.95))
def test_the_margin_vanishes_where_the_clamp_passes_under_the_tip(theta, eta):
    assert margin(theta, eta, 0.0) == pytest.approx(0.0, abs=1e-9)
    assert margin(theta, eta, 0.02) > 0 > margin(theta, eta, -0.02)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("theta", "eta"), [(1.0, 0.5), (4.0, 0.6), pytest.param(12.0, 0.4, marks=pytest.mark.nightly)]
)
def test_in_line_contact_it_vanishes_where_the_clamp_passes_under_the_contact_point(theta, eta):
    ahead = lambda x1: x1 - 1 + float(solved(theta, eta, x1, "line").s_c[0])  # noqa: E731
    x1 = brentq(ahead, 0.02, 0.9 * solve_curve(theta, eta, contact="line").x1_init, xtol=1e-13)
    assert x1 > 0.1
    assert margin(theta, eta, x1, "line") == pytest.approx(0.0, abs=1e-9)
    assert margin(theta, eta, x1 + 0.02, "line") > 0 > margin(theta, eta, x1 - 0.02, "line")


def test_where_it_vanishes_does_not_depend_on_the_torsional_stiffness(monkeypatch):
    stiff = margin(2.0, 0.85, 0.2)
    monkeypatch.setattr(lateral, "POISSON_RATIO", 0.49)
    assert margin(2.0, 0.85, 0.0) == pytest.approx(0.0, abs=1e-9)
    assert margin(2.0, 0.85, 0.2) < stiff


@pytest.mark.slow
@settings(max_examples=4, deadline=None)
@given(st.floats(1.0, 15.0), st.floats(0.4, 0.95), st.sampled_from(["point", "line"]))
@example(5.0, 0.4375, "line")
def test_the_rod_stays_in_its_plane_up_to_the_lock_and_where_it_is_pulled(theta, eta, contact):
    curve = solve_curve(theta, eta, contact=contact)
    # Pulled farther, a tip on a steep path lifts off.
    for x0 in (max(-0.1 * curve.x1_init, curve.x0_pull), curve.x0_lock):
        assert 0 < margin(theta, eta, curve.x1_init - x0, contact) < 1


def test_a_state_that_was_not_found_has_no_margin():
    state = solved(1.0, 0.85, 0.3)
    lost = state.with_unknowns(np.nan * state.unknowns)
    assert np.isnan(lateral_stability(lost)).all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("theta", "eta", "contact"),
    [(1.0, 0.85, "point"), pytest.param(4.0, 0.6, "line", marks=pytest.mark.nightly)],
)
def test_a_chain_in_space_stays_in_its_plane_until_there_and_then_swings_round(theta, eta, contact):
    # The state on the other side of the clamp at the same distance is the mirror image.
    x1_init = solve_curve(theta, eta, contact=contact).x1_init
    over = 0.0
    if contact == "line":
        ahead = lambda x1: x1 - 1 + solve_state(theta, eta, x1, contact).s_c  # noqa: E731
        over = brentq(ahead, 0.02, 0.9 * x1_init, xtol=1e-10)
    random = np.random.default_rng(4)
    state = solve_state(theta, eta, over + 0.03 * x1_init, contact)
    chain = Chain(theta, 20, state.s_c)
    start = chain.planar(lambda s: state.shape(s)[2])
    target = np.array([over + 0.03 * x1_init - 1 + state.s_c, eta, 0.0])
    mirrored = target * [-1, 1, 1]

    def push():
        return start + 0.02 * np.abs(start).max() * random.normal(size=start.shape)

    before, force = chain.minimum(target, start)
    swept, _ = chain.minimum(target, push())
    assert chain.energy(swept) == pytest.approx(chain.energy(before), abs=1e-6)
    beyond, other = chain.minimum(mirrored, start)
    aside, turned = chain.minimum(mirrored, push())
    assert chain.energy(beyond) > chain.energy(before) + 1e-3
    assert chain.energy(aside) == pytest.approx(chain.energy(before), abs=1e-6)
    # In the plane the chain is pushed on; swung round it pulls the other way, as strongly.
    assert other[0] == pytest.approx(force[0], rel=0.2)
    assert turned == pytest.approx(force * [-1, 1, 1], abs=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("theta", "eta", "offset", "contact", "mounting"),
    [
        (1.0, 0.85, 0.4, "point", IDEAL),
        (4.0, 0.6, -0.1, "point", IDEAL),
        (8.0, 0.5, 0.3, "line", IDEAL),
        (2.0, 0.5, 0.4, "line", IDEAL),
        (1.0, 0.85, 0.2, "point", Mounting(clamp_angle=0.1)),
        (2.0, 0.8, 0.1, "point", Mounting(curvature=(0.3, -0.6))),
        (2.0, 0.8, -0.1, "point", Mounting(curvature=(0.3, -0.6))),
        (
            *(2.0, 0.7, 0.2, "point"),
            Mounting(clamp_angle=-0.1, clamp_compliance=0.3, curvature=0.4),
        ),
        (3.0, 0.8, 0.1, "line", Mounting(curvature=-0.3)),
        (2.0, 0.7, 0.2, "point", Mounting(clamp_angle=0.05, stiffening=(1.0, 2.0), bore=0.4)),
    ],
)
def test_the_margin_is_that_of_a_chain_in_space(theta, eta, offset, contact, mounting):
    state = solve_state(theta, eta, offset, contact, mounting)
    target = np.array([offset - 1.0 + state.s_c, eta, 0.0])
    margins = []
    # A strongly tapered rod bends near its tip: twice as many links.
    links = 20 if theta <= 2.0 else 40
    for count in (links // 2, links):
        chain = Chain(
            theta,
            count,
            state.s_c,
            clamp_angle=mounting.clamp_angle,
            compliance=mounting.clamp_compliance,
            curvature=mounting.coefficients,
            factor=stiffness.Factor.of(theta, mounting),
        )
        start = chain.planar(lambda s: state.shape(s)[2])
        margins.append(chain.lateral_margin(*chain.minimum(target, start)))
    coarse, fine = margins
    # The error falls with the square of the length of a link.
    assert state.stability_aside == pytest.approx((4 * fine - coarse) / 3, abs=2e-5)


@pytest.mark.slow
def test_a_chain_in_an_inclined_clamp_swings_to_the_rod_that_leans_the_other_way():
    beta, eta = -0.1, 0.85
    offset = -eta * np.tan(beta) - 0.02
    state = solve_state(1.0, eta, offset, mounting=Mounting(clamp_angle=beta))
    assert state.stability_aside < 0
    chain = Chain(1.0, 16, clamp_angle=beta)
    target = np.array([offset, eta, 0.0])
    start = chain.planar(lambda s: state.shape(s)[2])
    random = np.random.default_rng(4)
    planar, _ = chain.minimum(target, start)
    aside, force = chain.minimum(target, start + 0.02 * random.normal(size=start.shape))
    other = Chain(1.0, 16, clamp_angle=-beta)
    state = solve_state(1.0, eta, -offset, mounting=Mounting(clamp_angle=-beta))
    mirrored, pull = other.minimum(target * [-1, 1, 1], other.planar(lambda s: state.shape(s)[2]))
    assert chain.energy(planar) > chain.energy(aside) + 1e-3
    assert chain.energy(aside) == pytest.approx(other.energy(mirrored), abs=1e-6)
    assert force == pytest.approx(pull * [-1, 1, 1], abs=2e-3)
