"""Sticking curves: onset, locking and accuracy, against solutions that share no code."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import reference
from vibrissa import Status, solve_curve
from vibrissa.sticking.solving import refinement
from vibrissa.sticking.solving.collocation import solve_curves

RANGE = [(theta, eta) for theta in (1.0, 2.0, 3.0, 4.0) for eta in (0.7, 0.85, 0.95)]


@pytest.fixture(scope="module")
def curves():
    theta, eta = np.array(RANGE).T
    return dict(zip(RANGE, solve_curves(theta, eta), strict=True))


@pytest.fixture(scope="module")
def papers():
    theta = np.array([1.0, 2.0, 3.0])
    return dict(zip((1, 2, 3), solve_curves(theta, np.full(3, 0.85)), strict=True))


@pytest.mark.slow
def test_whole_range_is_solved_to_the_promised_residual():
    theta, eta = (a.ravel() for a in np.meshgrid(np.linspace(1, 4, 7), np.linspace(0.7, 0.95, 6)))
    for curve in solve_curves(theta, eta):
        assert curve.status is Status.SOLVED, curve.message
        assert curve.residual <= 1e-12


@pytest.mark.parametrize("pair", RANGE)
@pytest.mark.parametrize("fraction", [0.3, 0.9, 0.999])
def test_onset_agrees_with_an_independent_shooting(curves, pair, fraction):
    curve = curves[pair]
    mu0 = fraction * curve.mu_lock
    x0_slip = float(curve.onset(mu0))
    first, slip = curve.state(0.0), curve.state(x0_slip)
    # Starting guesses are off by far more than the agreement that is asked for.
    expected = reference.onset(
        *(pair[0], mu0, pair[1]),
        (first.phi1 + 1e-3, -first.reaction_fy * 1.001),
        (slip.phi1 + 1e-4, -slip.reaction_fy * 1.0001),
    )
    assert x0_slip == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize("pair", RANGE)
def test_states_between_the_solved_ones_agree_with_an_independent_shooting(curves, pair):
    curve = curves[pair]
    x0 = 0.437 * curve.x0_lock
    state = curve.state(x0)
    guess = (state.phi1 + 1e-4, -state.reaction_fy * 1.0001, state.reaction_fx * 1.0001)
    phi1, p, q = reference.solve_offset(*pair, curve.x1_init - x0, guess)
    assert state.phi1 == pytest.approx(phi1, abs=1e-10)
    assert state.reaction_fy == pytest.approx(-p, abs=1e-10)
    assert state.reaction_fx == pytest.approx(q, abs=1e-10)
    m = reference.shoot_from_contact(pair[0], phi1, p, q)[3]
    assert state.reaction_m == pytest.approx(m, abs=1e-10)


def test_rod_comes_to_lie_along_the_surface_only_with_strong_taper(papers):
    assert np.isnan(papers[1].x0_touch)
    assert papers[3].x0_touch == pytest.approx(0.1157, abs=5e-5)
    assert papers[3].state(papers[3].x0_touch).phi1 == pytest.approx(0.0, abs=1e-12)


def test_a_touch_past_the_lock_does_not_count():
    curve = solve_curve(1.0, 0.7)
    assert np.isnan(curve.x0_touch)
    slopes = curve.state(np.linspace(curve.x0_lock, curve.x0_end, 50)).phi1
    assert slopes[0] > 0.0 > slopes.min()


def test_rod_that_lies_along_the_surface_from_the_start():
    assert solve_curve(3.0, 0.7).x0_touch == 0.0


def test_locking_friction_is_the_maximum_of_the_friction_demand(curves):
    for curve in curves.values():
        demand = curve.mobilised_friction(np.linspace(0.0, curve.x0_end, 4001))
        assert demand.max() <= curve.mu_lock + 1e-14
        assert demand.max() == pytest.approx(curve.mu_lock, rel=1e-6)


def test_friction_demand_near_locking_has_a_square_root_law(papers):
    # x0_lock - x0_slip ~ sqrt(mu_lock - mu0): a gap 100 times smaller is 10 times closer.
    curve = papers[2]
    gaps = np.array([1e-4, 1e-6, 1e-8])
    distance = curve.x0_lock - curve.onset(curve.mu_lock - gaps)
    assert distance[1:] / distance[:-1] == pytest.approx([0.1, 0.1], rel=0.02)


@settings(max_examples=50, deadline=None)
@given(st.sampled_from([1, 2, 3]), st.lists(st.floats(1e-6, 1.0), min_size=1, max_size=20))
def test_onset_needs_exactly_the_friction_there_is(papers, theta, mu0):
    curve = papers[theta]
    mu0 = np.sort(mu0)
    onset = curve.onset(mu0)
    slips = mu0 <= curve.mu_lock
    assert np.isfinite(onset).tolist() == slips.tolist()
    assert curve.mobilised_friction(onset[slips]) == pytest.approx(mu0[slips], abs=1e-13)
    assert (np.diff(onset[slips]) >= -1e-15).all()


def test_locking_begins_exactly_at_the_locking_friction(papers):
    curve = papers[2]
    at, above = curve.onset([curve.mu_lock, np.nextafter(curve.mu_lock, 1)])
    assert at == pytest.approx(curve.x0_lock, abs=1e-7)
    assert np.isnan(above)


def test_states_outside_the_curve_are_refused(papers):
    curve = papers[2]
    for x0 in (curve.x0_pull - 1e-9, curve.x0_end * 1.001, np.nan):
        with pytest.raises(ValueError, match="x0 must lie on the curve"):
            curve.state(x0)


@pytest.mark.parametrize("mu0", [0.0, -0.1, np.nan])
def test_friction_must_be_positive(papers, mu0):
    with pytest.raises(ValueError, match="mu0 must be positive"):
        papers[2].onset(mu0)


@pytest.mark.slow
def test_unresolved_curve_is_failed_and_says_what_to_try(monkeypatch):
    # The rod needs more nodes than these.
    monkeypatch.setattr(refinement, "NODES_ALONG_ROD", refinement.NODES_ALONG_ROD[:1])
    curve = solve_curve(12.0, 0.5)
    assert curve.status is Status.FAILED
    assert "stay above 1e-12" in curve.message and "try a larger eta" in curve.message
    assert np.isnan(curve.mu_lock) and not curve.pieces
    with pytest.raises(ValueError, match="status failed"):
        curve.state(0.0)
    with pytest.raises(ValueError, match="status failed"):
        curve.onset(0.3)


@pytest.mark.parametrize("theta", [5.0, 8.0, 12.0])
def test_strong_taper_refines_itself(theta):
    curve = solve_curve(theta, 0.85)
    assert curve.status is Status.SOLVED
    state = curve.state(0.5 * curve.x0_lock)
    phi1, p, q = reference.solve_offset(
        *(theta, 0.85, curve.x1_init - float(state.x0)),
        (state.phi1 + 1e-5, -state.reaction_fy * 1.00001, state.reaction_fx * 1.00001),
    )
    assert (state.phi1, -state.reaction_fy, state.reaction_fx) == pytest.approx(
        (phi1, p, q), abs=1e-9
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("theta", "eta"),
    [
        (16.7, 0.73),
        (3.1, 0.25),
        pytest.param(18.0, 0.35, marks=pytest.mark.nightly),
        (1.0, 0.9999),
    ],
)
def test_far_from_the_papers_range_it_still_resolves(theta, eta):
    curve = solve_curve(theta, eta)
    assert curve.status is Status.SOLVED
    assert curve.residual <= (1e-12 if theta <= 8 else 1e-11)


@pytest.mark.parametrize(("theta", "eta"), [(1.0, 0.18), (1.0, 0.181), (1.3, 0.1)])
def test_a_tip_that_lifts_off_never_locks(theta, eta):
    # -tan(alpha) has a pole where the surface would begin to pull, not a maximum.
    curve = solve_curve(theta, eta)
    assert curve.mu_lock == np.inf
    assert curve.state(curve.x0_lock).reaction_fy == pytest.approx(0.0, abs=1e-9)
    onset = curve.onset([0.5, 5.0, 500.0, 1e9])
    assert (np.diff(onset) > 0).all() and onset[-1] <= curve.x0_lock
    assert curve.mobilised_friction(onset[:3]) == pytest.approx([0.5, 5.0, 500.0], rel=1e-9)


def test_locking_friction_varies_smoothly_up_to_lifting_off():
    values = [solve_curve(1.0, eta).mu_lock for eta in (0.3, 0.25, 0.2, 0.18)]
    assert values[-1] == np.inf
    assert all(low < high for low, high in pairwise(values))
