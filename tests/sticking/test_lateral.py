"""What a locked round rod does: where it buckles laterally, and where it slips at last."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import reference
from vibrissa import Status, solve_curve, solve_onset, solve_state
from vibrissa.outcomes import Contact, End


@pytest.mark.slow
@settings(max_examples=15, deadline=None)
@given(st.floats(1.0, 15.0), st.floats(0.35, 0.95), st.sampled_from(list(Contact)))
def test_the_curve_ends_where_the_clamp_passes_under_the_contact_point(theta, eta, contact):
    curve = solve_curve(theta, eta, contact=contact)
    assert (curve.status, curve.end) == (Status.SOLVED, End.SWINGS_ASIDE)
    end = curve.state(curve.x0_end)
    assert curve.x0_end == pytest.approx(curve.x1_init - (1 - end.s_c), abs=1e-10)
    # Stable up to there, in the plane and out of it; and the tip is still pushed.
    states = curve.state(np.linspace(curve.x0_pull, curve.x0_end, 60))
    assert (states.stability > 0).all() and (states.stability_aside[:-1] > 0).all()
    assert end.stability_aside == pytest.approx(0, abs=1e-5)
    assert end.alpha < 0


@pytest.mark.parametrize("contact", list(Contact))
def test_onsets_and_locks_are_those_of_a_rod_that_is_kept_in_its_plane(contact):
    round_rod, planar = (
        solve_curve(3.0, 0.7, contact=contact, section=section) for section in ("round", "planar")
    )
    mu0 = planar.mu_lock * np.array([0.1, 0.5, 0.9, 0.999])
    assert round_rod.onset(mu0) == pytest.approx(planar.onset(mu0), abs=1e-10)
    assert round_rod.mu_lock == pytest.approx(planar.mu_lock, abs=1e-11)
    assert round_rod.x0_lock == pytest.approx(planar.x0_lock, abs=1e-6)
    assert planar.x0_end > round_rod.x0_end and not planar.retraction
    assert np.isnan(planar.trailing_end(2 * planar.mu_lock).x0).all()


@pytest.mark.parametrize(("theta", "eta"), [(1.0, 0.85), (2.0, 0.85), (6.0, 0.6)])
@pytest.mark.parametrize("mu0", [0.9, 2.0])
def test_the_last_sticking_state_is_that_of_an_independent_shooting(theta, eta, mu0):
    curve = solve_curve(theta, eta)
    state = curve.trailing_end(mu0)
    pulled = reference.solve_inclination(
        *(theta, eta, mu0), [np.pi - state.phi1 + 1e-6, -state.reaction_fy * 1.00001]
    )
    offset = reference.shoot_from_contact(theta, *pulled, mu0 * pulled[1])[0]
    assert 2 * curve.x1_init + offset - curve.x1_init == pytest.approx(float(state.x0), abs=1e-9)
    assert -state.reaction_fx == pytest.approx(mu0 * pulled[1], rel=1e-9)
    # Behind the clamp, the tip is held back as by any surface.
    assert np.tan(state.alpha) == pytest.approx(-mu0, rel=1e-10)


@pytest.mark.parametrize(("theta", "eta"), [(8.0, 0.5), (1.0, 0.6)])
def test_in_line_contact_the_last_sticking_state_is_a_pulled_one(theta, eta):
    curve = solve_curve(theta, eta, contact="line")
    trail = curve.trailing_end(2 * curve.mu_lock)
    x0 = 2 * curve.x0_end - float(trail.x0)
    assert x0 < 0
    state = solve_state(theta, eta, curve.x1_init - x0, "line")
    assert state.reaction_fx == pytest.approx(-2 * curve.mu_lock * state.reaction_fy, rel=1e-8)
    assert state.reaction_m == pytest.approx(-float(trail.reaction_m), abs=1e-8)


def test_the_last_sticking_state_grows_with_friction():
    curve = solve_curve(2.0, 0.85)
    x0 = curve.trailing_end(np.linspace(curve.mu_lock, 3.0, 40)[1:]).x0
    assert (np.diff(x0) > 0).all() and x0[0] > 2 * curve.x1_init
    # Further than it was followed nothing is known.
    assert np.isnan(curve.trailing_end(3.01).x0).all()


def test_an_onset_that_locks_says_where_the_rod_swings_and_slips():
    onset = solve_onset(1.0, 0.9, 0.85)
    assert (onset.status, onset.end) == (Status.LOCK, "swings_aside")
    assert "buckles laterally at x0 = 0.469441" in onset.message
    assert "slips at x0 = 0.944303" in onset.message
    assert float(onset.trail.x0) == pytest.approx(0.944303, abs=1e-6)
    assert np.isnan(solve_onset(1.0, 0.3, 0.85).trail.x0)


def test_a_rod_may_swing_aside_before_its_friction_demand_has_a_maximum():
    # Of very strong taper or at very low eta: there the tip slips up to the demand of the swing.
    round_rod, planar = (solve_curve(25.0, 0.93, section=kind) for kind in ("round", "planar"))
    assert planar.x0_lock > round_rod.x0_lock == round_rod.x0_end
    assert round_rod.mu_lock < planar.mu_lock
    assert round_rod.mu_lock == pytest.approx(planar.mobilised_friction(planar.x1_init), rel=1e-9)


@pytest.mark.parametrize("pair", [(1.0, 0.3), (2.0, 0.85), (4.0, 0.7), (12.0, 0.5)])
def test_the_margin_out_of_the_plane_vanishes_at_the_end_of_a_curve(pair):
    """The last piece ends where the clamp passes under the tip, and no state behind it counts."""
    curve = solve_curve(*pair)
    assert curve.x0_end == curve.x1_init
    assert curve.state(curve.x0_end).stability_aside == pytest.approx(0.0, abs=1e-7)
