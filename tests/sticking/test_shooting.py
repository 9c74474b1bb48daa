"""The paper's own procedure: agrees with collocation, mends false minima, recognises locking."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from vibrissa import Status, solve_curve
from vibrissa.sticking.solving import shooting

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def shot():
    # A coarse step keeps the walk short; it is divided into steps of at most 0.004.
    return shooting.solve_curve(2.0, 0.85, 0.006)


def test_both_methods_find_the_same_curve(shot):
    spectral = solve_curve(2.0, 0.85)
    assert shot.status is Status.SOLVED
    assert shot.residual < 1e-9
    assert shot.x1_init == pytest.approx(spectral.x1_init, abs=1e-9)
    mu0 = [0.1, 0.3, 0.4, 0.47]
    assert shot.onset(mu0) == pytest.approx(spectral.onset(mu0), abs=1e-8)
    x0 = np.linspace(0.0, shot.x0_lock, 23)
    got, expected = shot.state(x0).columns, spectral.state(x0).columns
    # The paper's procedure does not ask for it.
    for name in ("stability", "stability_aside"):
        assert np.isnan(got.pop(name)).all()
    for name, values in got.items():
        assert values == pytest.approx(expected[name], abs=1e-7)


def test_walk_recognises_locking(shot):
    spectral = solve_curve(2.0, 0.85)
    assert shot.mu_lock == pytest.approx(spectral.mu_lock, abs=1e-9)
    assert shot.x0_end < 1.3 * shot.x0_lock


def test_walk_above_the_locking_friction_ends():
    states = shooting.walk(2.0, 0.85, 0.012, mu0=0.6)
    demand = [-np.tan(state.alpha) for state in states]
    assert max(demand) < 0.6
    assert demand[-1] < max(demand)


def test_walk_stops_at_the_first_state_that_slips():
    states = shooting.walk(1.0, 0.85, 0.001, mu0=0.3)
    demand = [-np.tan(state.alpha) for state in states]
    assert len(states) - 1 == 10  # x0_slip = 0.009337
    assert demand[-2] <= 0.3 < demand[-1]


@pytest.mark.parametrize(
    ("tolerances", "least", "most"),
    # With MATLAB's defaults the force is off by up to 1 % at theta = 1.
    [(shooting.PAPER, 1e-4, 2e-2), (shooting.PRECISE, 0.0, 1e-9)],
)
def test_accuracy_of_the_force(tolerances, least, most):
    states = shooting.walk(1.0, 0.85, 0.002, mu0=0.4, tolerances=tolerances)
    exact = solve_curve(1.0, 0.85).state(0.002 * np.arange(len(states)))
    error = np.abs([state.f for state in states] / exact.f - 1.0)
    assert least < error.max() < most


def test_false_minimum_is_mended(monkeypatch):
    # A search that gives up after a few iterations leaves the miss of a false minimum.
    original = shooting.minimize
    calls = []

    def hasty(*args, options, **kwargs):
        calls.append(1)
        if len(calls) == 1:
            options = options | {"maxiter": 6}
        return original(*args, options=options, **kwargs)

    monkeypatch.setattr(shooting, "minimize", hasty)
    state = shooting.initial_state(1.0, 0.98)
    assert state.searches > 1
    assert state.miss <= shooting.PRECISE.miss


def test_false_minimum_that_cannot_be_mended_is_not_believed(monkeypatch):
    original = shooting.minimize

    def hasty(*args, options, **kwargs):
        return original(*args, options=options | {"maxiter": 6}, **kwargs)

    monkeypatch.setattr(shooting, "minimize", hasty)
    curve = shooting.solve_curve(1.0, 0.85, 0.004, replace(shooting.PRECISE, restarts=1))
    assert curve.status is Status.FAILED
    assert "missed the contact point" in curve.message
    assert "method: collocation" in curve.message


def test_low_contact_points_are_reached_from_near_buckling():
    state = shooting.initial_state(1.0, 0.4)
    spectral = solve_curve(1.0, 0.4)
    assert state.x1 == pytest.approx(spectral.x1_init, abs=1e-8)
    assert state.f == pytest.approx(float(spectral.state(0.0).f), abs=1e-7)


def test_short_curves_are_walked_in_short_steps():
    # Near eta = 1 a whole curve is shorter than a common step.
    eta = 0.9999
    shot = shooting.solve_curve(2.0, eta, 0.004)
    spectral = solve_curve(2.0, eta)
    mu0 = 0.8 * spectral.mu_lock
    assert float(shot.onset(mu0)) == pytest.approx(float(spectral.onset(mu0)), rel=1e-5)


def shot_state(f=2.0, alpha=-0.1, x1=0.5, miss=0.0):
    return shooting.ShotState(f=f, alpha=alpha, x1=x1, phi1=0.4, m=-1.0, miss=miss, searches=1)


def test_a_search_starts_where_the_last_two_states_point_to():
    before, last = shot_state(f=2.0, alpha=-0.1), shot_state(f=2.5, alpha=-0.3)
    guess, spread = shooting._warm_start([before, last], shooting.PRECISE)
    assert guess == pytest.approx((3.0, -0.5))
    # The edges of the simplex are a fifth of the change, α further on its way.
    assert spread == pytest.approx((0.1, -0.04))
    _, least = shooting._warm_start([last, last], shooting.PRECISE)
    assert least == (1e-4, -1e-4)


def test_without_prediction_a_search_starts_at_the_last_state_as_fminsearch_does():
    first, last = shot_state(f=2.0, alpha=0.0), shot_state(f=2.5, alpha=-0.3)
    cold = shooting._warm_start([first], shooting.PRECISE)
    assert cold == ((2.0, 0.0), (0.1, 0.00025))
    warm = shooting._warm_start([first, last], shooting.PAPER)
    assert warm == (pytest.approx((2.5, -0.3)), pytest.approx((0.125, -0.015)))


@pytest.fixture
def walked(monkeypatch):
    """Walk through made-up states whose −tan α is t·(2 − t) at x0 = t; and where each is sought."""
    sought = []

    def search(theta, eta, guess, spread, tolerances, *, x1):
        sought.append(x1)
        t = 0.5 - x1
        miss = 1.0 if len(sought) == walk.misses_after else 0.0
        return shot_state(alpha=-np.arctan(t * (2.0 - t) / 0.01), x1=x1, miss=miss)

    def walk(dx0, misses_after=0, **others):
        sought.clear()
        walk.misses_after = misses_after
        states = shooting.walk(2.0, 0.8, dx0, start=shot_state(alpha=0.0), **others)
        assert [state.x1 for state in states[1:]] == sought
        return [0.5 - state.x1 for state in states]

    monkeypatch.setattr(shooting, "_search", search)
    return walk


def test_a_walk_goes_in_equal_steps_up_to_one_and_a_half_x1_init(walked):
    """The friction demand rises as far as x0 = 1, which is twice x1_init."""
    assert walked(0.1) == pytest.approx(0.1 * np.arange(8))
    assert walked(0.125) == pytest.approx(0.125 * np.arange(6))


def test_a_walk_ends_at_the_first_state_that_needs_more_friction(walked):
    most = 100.0 * 0.3 * 1.7
    assert walked(0.1, mu0=most * (1.0 + 1e-9)) == pytest.approx(0.1 * np.arange(5))
    assert walked(0.1, mu0=most * (1.0 - 1e-9)) == pytest.approx(0.1 * np.arange(4))


def test_a_walk_ends_at_a_miss(walked):
    assert walked(0.1, misses_after=2) == pytest.approx(0.1 * np.arange(3))


def test_a_walk_ends_four_steps_behind_the_lock(monkeypatch):
    """Four in a row: a single one that falls is none."""
    alphas = iter(-np.arctan([0.1, 0.2, 0.15, 0.3, 0.29, 0.28, 0.27, 0.26, 0.25, 0.24]))

    def search(*arguments, x1):
        return shot_state(alpha=next(alphas), x1=x1)

    monkeypatch.setattr(shooting, "_search", search)
    states = shooting.walk(2.0, 0.8, 1e-3, start=shot_state(alpha=0.0))
    assert -np.tan(states[-1].alpha) == pytest.approx(0.26)


def test_a_simplex_that_has_collapsed_is_opened_anew_turned_round(monkeypatch):
    """Ten times as wide as what is missing, if it was not wider."""
    simplices, misses = [], iter([0.004, 0.5, 1e-10])

    def minimize(miss, best, *, method, options):
        simplices.append(options["initial_simplex"] - best)
        x, y, _ = shooting.shoot(1.0, 10.0, -0.1, 0.4, 0.85)
        assert miss(best) == np.hypot(x - 0.4, y - 0.85)
        return SimpleNamespace(x=best, fun=next(misses))

    monkeypatch.setattr(shooting, "minimize", minimize)
    state = shooting._search(1.0, 0.85, (10.0, -0.1), (0.2, -0.01), shooting.PRECISE, x1=0.4)
    corners = [(0.2, -0.01), (-0.2, 0.04), (5.0, -5.0)]
    assert state.searches == 3 and state.miss == 1e-10
    for simplex, (f, alpha) in zip(simplices, corners, strict=True):
        assert simplex == pytest.approx(np.array([[0.0, 0.0], [f, 0.0], [0.0, alpha]]))
    assert (state.f, state.alpha, state.x1) == (10.0, -0.1, 0.4)
    # The moment of the contact force about the clamp.
    assert state.m == pytest.approx(-10.0 * (np.cos(0.1) * 0.4 - np.sin(0.1) * 0.85))


@pytest.mark.parametrize("restarts", [0, 2])
def test_a_search_is_given_up_after_its_restarts(monkeypatch, restarts):
    monkeypatch.setattr(
        shooting, "minimize", lambda miss, best, **options: SimpleNamespace(x=best, fun=1.0)
    )
    few = replace(shooting.PRECISE, restarts=restarts)
    state = shooting._search(1.0, 0.85, (10.0, 0.4), (0.2, 0.01), few, alpha=0.0)
    assert state.searches == restarts + 1 and state.miss == 1.0
    assert (state.f, state.alpha, state.x1) == (10.0, 0.0, 0.4)
