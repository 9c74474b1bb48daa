"""Stability out of the plane, against finite elements and a chain in space."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from rod_chain import Chain
from scipy.linalg import eigh, null_space
from scipy.optimize import brentq

import reference
from vibrissa import solve_curve, solve_state
from vibrissa.mechanics import aside
from vibrissa.mechanics.aside import stability_aside
from vibrissa.outcomes import Contact
from vibrissa.sticking.collocation import solve_offset

POISSON_RATIO = 0.3


def solved(theta, eta, offset, contact="point"):
    return solve_offset(theta, eta, offset, Contact(contact)).state


def margin(theta, eta, offset, contact="point"):
    return float(stability_aside(solved(theta, eta, offset, contact))[0])


def finite_elements(theta, state, count):
    """Least second variation, of linear elements for the rotations about tangent and normal."""
    s_c, fx, fy = float(state.s_c[0]), float(state.fx[0]), float(state.fy[0])
    # Nodes are dense where the rod is thin.
    tau = np.linspace(0, 1, count + 1)
    tip = 1 - (1 - 1 / theta) * s_c
    s = s_c * tau / (tau + (1 - tau) * tip)
    middle = 0.5 * (s[1:] + s[:-1])
    phi1 = phi_at_contact(theta, state)
    _, _, phi, moment = reference.integrated(theta, s_c, phi1, -fy, fx, (s_c - middle)[::-1])
    phi, moment, h = phi[::-1], moment[::-1], np.diff(s)
    bend = (1 - (1 - 1 / theta) * middle) ** 4
    turn = moment / bend
    ahead, up = fx * np.cos(phi) + fy * np.sin(phi), -fx * np.sin(phi) + fy * np.cos(phi)
    elastic, load = np.zeros((2, 2 * count + 2, 2 * count + 2))
    held = np.zeros(2 * count + 2)
    mean, slope = np.array([0.5, 0.5]), np.array([-1.0, 1.0])
    for k in range(count):
        at = [2 * k, 2 * k + 2, 2 * k + 1, 2 * k + 3]
        t, n = np.r_[mean, 0, 0], np.r_[0, 0, mean]
        twist, bending = np.r_[slope / h[k], -turn[k] * mean], np.r_[turn[k] * mean, slope / h[k]]
        part = np.ix_(at, at)
        stiff = np.outer(twist, twist) / (1 + POISSON_RATIO) + np.outer(bending, bending)
        elastic[part] += h[k] * bend[k] * stiff
        work = moment[k] * (np.outer(t, bending) - np.outer(n, twist))
        work += up[k] * np.outer(t, n) - ahead[k] * np.outer(n, n)
        load[part] -= h[k] * 0.5 * (work + work.T)
        held[at] += h[k] * n
    free = null_space(held[None, 2:])
    inner = slice(2, None), slice(2, None)
    return 1 + eigh(free.T @ load[inner] @ free, free.T @ elastic[inner] @ free)[0][0]


def phi_at_contact(theta, state):
    """Tangent angle at the contact point, by shooting at the clamp's."""
    force = -float(state.fy[0]), float(state.fx[0])
    s_c, last = float(state.s_c[0]), float(state.phi[0, -1])
    miss = lambda phi1: reference.shoot(theta, s_c, phi1, *force)[2] - np.pi / 2  # noqa: E731
    return brentq(miss, last - 0.05, last + 0.05, xtol=1e-13)


@pytest.mark.parametrize(
    ("theta", "eta", "place", "contact"),
    [
        (1.0, 0.85, 0.0, "point"),
        (4.0, 0.6, 0.8, "point"),
        (2.0, 0.85, 1.3, "point"),
        (12.0, 0.9, -0.2, "point"),
        (2.0, 0.5, 0.3, "line"),
        (8.0, 0.5, 0.6, "line"),
    ],
)
def test_the_margin_is_that_of_finite_elements(theta, eta, place, contact):
    x1_init = solve_curve(theta, eta, contact=contact).x1_init
    state = solved(theta, eta, x1_init * (1 - place), contact)
    coarse, fine = (finite_elements(theta, state, count) for count in (60, 120))
    # Linear elements: the error falls with the square of their length.
    assert float(stability_aside(state)[0]) == pytest.approx((4 * fine - coarse) / 3, abs=3e-4)


@settings(max_examples=8, deadline=None)
@given(st.floats(1.0, 15.0), st.floats(0.4, 0.95))
def test_the_margin_vanishes_where_the_clamp_passes_under_the_tip(theta, eta):
    assert margin(theta, eta, 0.0) == pytest.approx(0.0, abs=1e-9)
    assert margin(theta, eta, 0.02) > 0 > margin(theta, eta, -0.02)


@pytest.mark.parametrize(("theta", "eta"), [(1.0, 0.5), (4.0, 0.6), (12.0, 0.4)])
def test_in_line_contact_it_vanishes_where_the_clamp_passes_under_the_contact_point(theta, eta):
    ahead = lambda x1: x1 - 1 + float(solved(theta, eta, x1, "line").s_c[0])  # noqa: E731
    x1 = brentq(ahead, 0.02, 0.9 * solve_curve(theta, eta, contact="line").x1_init, xtol=1e-13)
    assert x1 > 0.1
    assert margin(theta, eta, x1, "line") == pytest.approx(0.0, abs=1e-9)
    assert margin(theta, eta, x1 + 0.02, "line") > 0 > margin(theta, eta, x1 - 0.02, "line")


def test_where_it_vanishes_does_not_depend_on_the_torsional_stiffness(monkeypatch):
    stiff = margin(2.0, 0.85, 0.2)
    monkeypatch.setattr(aside, "POISSON_RATIO", 0.49)
    assert margin(2.0, 0.85, 0.0) == pytest.approx(0.0, abs=1e-9)
    assert margin(2.0, 0.85, 0.2) < stiff


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
    lost = replace(state, phi=np.full_like(state.phi, np.nan))
    assert np.isnan(stability_aside(lost)).all()


@pytest.mark.parametrize(("theta", "eta", "contact"), [(1.0, 0.85, "point"), (4.0, 0.6, "line")])
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
