"""A ball at the tip that rolls on the surface: loads by shooting, and what a recording shows."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from steel import recording_of
from validation.sensor.bench import scan
from validation.sensor.bench_rod import IDEAL_STATE, Rod, solve
from validation.sensor.laboratory import NOISE, STEP, believed, in_words
from validation.sensor.mistakes import bench_of
from vibrissa.scanning.response_over_eta import respond_over
from vibrissa.sensor import Whisker, identify
from vibrissa.sensor.identification.forward import ForwardModel

HEIGHT, RADIUS = 0.85, 0.0025


@pytest.mark.slow
def test_loads_with_a_ball_are_those_of_shooting_to_first_order():
    heights, errors = respond_over(Whisker(theta=2.0, eta=HEIGHT), 0.84, 0.86), []
    sharp = solve(Rod(), HEIGHT, np.array(IDEAL_STATE)[:, None], ratio=np.array([0.2]))
    for radius in (0.5e-3, 1e-3):
        state = solve(Rod(radius=radius), HEIGHT, sharp[:3], dx=sharp[4])
        states = heights.states(HEIGHT - radius)
        x0 = float(states.x1_init - sharp[4, 0])
        x0 = np.array(x0 - radius * states.tip_angle(x0))
        model = SimpleNamespace(radius=radius, heights=heights)
        errors.append(np.abs(ForwardModel._of_ball(model, states, x0) - state[1:4, 0]).max())
    # Without the ball the loads differ by 0.02.
    assert errors[1] < 1e-4
    assert errors[1] == pytest.approx(4.0 * errors[0], rel=0.1)


@pytest.fixture(scope="module")
def found():
    bench = bench_of(4)
    return scan(replace(bench, rod=replace(bench.rod, radius=RADIUS)), STEP, [0.2], NOISE, 4)


def read(found, assume=False, **tolerances):
    setup = believed(noise=in_words(NOISE), tolerances=tolerances, assume=assume)
    return identify(setup, recording_of(found.stage, found.readings))


def error_of_mean(found, result):
    """Error of the mean friction, and its stated standard deviation."""
    summary = result.summary()
    known = np.isfinite(result.periods.mu0)
    return summary.mean - found.mu0[result.periods.last[known]].mean(), summary.deviation


@pytest.mark.slow
def test_a_round_tip_that_was_not_stated_is_named(found):
    result = read(found)
    first = result.causes[0]
    assert first.parameter.of == "tip_radius"
    assert first.size == pytest.approx(RADIUS, rel=0.15)
    assert (result.periods.grade != "").all()


@pytest.mark.slow
def test_a_stated_round_tip_is_fitted(found):
    result = read(found, tip_radius=f"{100.0 * RADIUS} mm")
    (radius,) = [one for one in result.estimates if one.parameter.of == "tip_radius"]
    assert radius.size == pytest.approx(RADIUS, rel=0.05)
    assert radius.deviation < 0.02 * RADIUS
    assert result.fits and not result.causes
    assert abs(error_of_mean(found, result)[0]) < 2e-3


@pytest.mark.slow
def test_the_usual_tolerances_hold_a_small_round_tip(found):
    result = read(found, assume=True)
    error, deviation = error_of_mean(found, result)
    assert result.fits and abs(error) < 2.0 * deviation
