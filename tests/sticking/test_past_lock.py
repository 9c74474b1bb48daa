"""The motion past the lock in the plane, against solutions that share no code."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

import reference
import vibrissa
from vibrissa import Status, solve_onset, solve_state
from vibrissa.outcomes import Contact, End


def solve_curve(*pair, **kind):
    return vibrissa.solve_curve(*pair, section="planar", **kind)


PAIRS = [(1.0, 0.85), (2.0, 0.85), (4.0, 0.7), (1.5, 0.5)]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pair", "kind"),
    [((1.5, 0.5), "point"), ((2.0, 0.45), "point"), ((12.0, 0.4), "line"), ((5.0, 0.33), "line")],
)
def test_slipping_back_agrees_with_an_independent_shooting(pair, kind):
    curve = solve_curve(*pair, contact="line")
    mu0 = 0.5 * (curve.mu_lock + np.tan(float(curve.state(curve.x0_end).alpha)))
    end, state = curve.motion_end(mu0)
    assert end is End.SLIPS_BACK
    x0, phi1, s_c = state.x0, state.phi1, state.s_c
    p, q = -state.reaction_fy, state.reaction_fx
    assert q == pytest.approx(mu0 * p, rel=1e-12)
    # The surface holds the tip back from sliding to -x here, and from sliding to +x at the onset.
    assert q > 0 > curve.state(curve.onset(0.5 * curve.mu_lock)).reaction_fx
    assert curve.contact(x0) == kind
    near = p * 1.00001, q * 1.00001
    if kind == "point":
        expected = reference.solve_offset(*pair, curve.x1_init - x0, (phi1 + 1e-5, *near))
        assert (phi1, p, q) == pytest.approx(expected, rel=1e-8)
    else:
        expected = reference.solve_line_offset(*pair, curve.x1_init - x0, (s_c * 0.99999, *near))
        assert (s_c, p, q) == pytest.approx(expected, rel=1e-8)


def test_a_tip_slips_back_where_friction_allows_and_the_rod_snaps_where_it_does_not():
    curve = solve_curve(1.5, 0.5, contact="line")
    top = np.tan(float(curve.state(curve.x0_end).alpha))
    assert curve.mu_lock < top
    ends, states = curve.motion_end([0.999 * top, 1.001 * top, 3.0])
    assert ends.tolist() == [End.SLIPS_BACK, End.SNAPS, End.SNAPS]
    assert states.x0[0] < states.x0[1] == states.x0[2] == curve.x0_end


@pytest.mark.slow
@settings(max_examples=8, deadline=None)
@given(st.floats(1.0, 6.0), st.floats(0.5, 0.98))
def test_the_tip_alone_never_slips_back_after_a_lock(theta, eta):
    # Where the branch turns back, tan(alpha) is still less than mu_lock.
    curve = solve_curve(theta, eta)
    assert curve.motion_end(np.nextafter(curve.mu_lock, 9))[0] == curve.end


@pytest.mark.slow
@pytest.mark.parametrize("pair", PAIRS[::3])
def test_the_rod_snaps_where_the_independent_branch_turns_back(pair):
    # On the branch of shapes the offset is a function of alpha; its least value is found by
    # differences of an independent shooting.
    curve = solve_curve(*pair)
    assert curve.end is End.SNAPS
    end = curve.state(curve.x0_end)
    unknowns = np.array([float(end.phi1), -float(end.reaction_fy)])

    def offset(alpha):
        nonlocal unknowns
        unknowns = reference.solve_inclination(*pair, np.tan(alpha), unknowns)
        p = unknowns[1]
        x, *_ = reference.shoot_from_contact(pair[0], unknowns[0], p, p * np.tan(alpha))
        return x

    h = 1e-4
    slope = lambda alpha: (offset(alpha + h) - offset(alpha - h)) / (2 * h)  # noqa: E731
    alpha = brentq(slope, float(end.alpha) - 4e-3, float(end.alpha) + 1e-3, xtol=1e-9)
    assert alpha == pytest.approx(float(end.alpha), abs=2e-5)
    assert curve.x1_init - offset(alpha) == pytest.approx(curve.x0_end, abs=1e-9)


@pytest.mark.slow
@settings(max_examples=8, deadline=None)
@given(st.floats(1.0, 8.0), st.floats(0.5, 0.98), st.sampled_from(list(Contact)))
def test_stability_is_lost_exactly_where_the_branch_turns_back(theta, eta, contact):
    curve = solve_curve(theta, eta, contact=contact)
    assert curve.status is Status.SOLVED
    x0 = np.linspace(0.0, curve.x0_end, 200)
    states = curve.state(x0)
    assert (states.stability[:-1] > 0.0).all()
    if curve.end is End.SNAPS:
        # The margin vanishes with the slope of x0: two computations with nothing in common. In a
        # kink, where the contact changes, both jump to below zero instead.
        changes = states.s_c[-1] > 1.0 - 1e-9 and abs(states.phi1[-1]) < 1e-9
        assert states.stability[-1] == pytest.approx(0.0, abs=1e-4) or changes
    else:
        assert curve.end is End.OUT_OF_REACH and contact is Contact.POINT


@pytest.mark.slow
@settings(max_examples=5, deadline=None)
@given(st.floats(1.0, 12.0), st.floats(0.4, 0.98), st.sampled_from(list(Contact)))
def test_past_the_lock_friction_demand_only_falls(theta, eta, contact):
    # There is no second maximum at which a tip that is stuck might slip forward after all.
    curve = solve_curve(theta, eta, contact=contact)
    x0 = np.linspace(curve.x0_lock, curve.x0_end, 400)
    alpha = curve.state(x0).alpha
    fold = np.argmax(alpha)
    assert (np.diff(alpha[: fold + 1]) > -1e-12).all()
    assert alpha.min() >= -np.arctan(curve.mu_lock) - 1e-12


def test_states_past_the_lock_are_those_of_single_states():
    curve = solve_curve(3.0, 0.85, contact="line")
    x0 = np.linspace(1.1 * curve.x0_lock, 0.99 * curve.x0_end, 7)
    states = curve.state(x0)
    for i, x in enumerate(x0):
        single = solve_state(3.0, 0.85, curve.x1_init - x, "line")
        assert single.status is Status.SOLVED
        assert states.reaction_fx[i] == pytest.approx(single.reaction_fx, abs=1e-9)
        assert states.reaction_m[i] == pytest.approx(single.reaction_m, abs=1e-9)
        assert states.s_c[i] == pytest.approx(single.s_c, abs=1e-9)
        assert states.stability[i] == pytest.approx(single.stability, abs=1e-4)


@pytest.mark.parametrize("contact", ["point", "line"])
def test_work_of_the_clamp_is_the_gain_of_bending_energy_past_the_lock(contact):
    curve = solve_curve(1.0, 0.8, contact=contact)

    def energy(x0):
        state = solve_state(1.0, 0.8, curve.x1_init - x0, contact)
        s = np.linspace(0.0, 1.0, 8001)
        _, _, phi = state.shape(s)
        return np.trapezoid(0.5 * np.gradient(phi, s, edge_order=2) ** 2, s)

    ends = 1.2 * curve.x0_lock, 0.97 * curve.x0_end
    x0 = np.linspace(*ends, 4001)
    work = np.trapezoid(-curve.state(x0).reaction_fx, x0)
    assert energy(ends[1]) - energy(ends[0]) == pytest.approx(work, rel=1e-4)


def test_an_onset_that_locks_says_how_it_goes_on():
    onset = solve_onset(1.0, 0.9, 0.85, section="planar")
    assert (onset.status, onset.end) == (Status.LOCK, "snaps")
    assert "snaps through at x0 = 0.89" in onset.message
    assert float(onset.ended.x0) == solve_curve(1.0, 0.85).x0_end
    slips = solve_onset(1.0, 0.3, 0.85)
    assert slips.end == "" and np.isnan(slips.ended.x0)


def test_motion_end_is_asked_for_locking_friction_only():
    curve = solve_curve(1.0, 0.85)
    with pytest.raises(ValueError, match=r"mu_lock = 0\.5145"):
        curve.motion_end([0.6, 0.5])
