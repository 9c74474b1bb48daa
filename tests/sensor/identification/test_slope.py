"""The slope of the surface: what it does to friction, and how it adds up in a mean."""

import numpy as np
import pytest

from steel import NOISE, measured, recording_of
from vibrissa.sensor import Whisker, identify, surfaces
from vibrissa.sensor.identification.periods import alike, slope_errors, variance_of_mean
from vibrissa.sensor.response.branch import respond
from vibrissa.sensor.simulation.scanning import path, simulate

GIVEN = {"theta": 2.0, "eta": 0.85}
SLOPE = np.deg2rad(1.0)


@pytest.fixture(scope="module")
def recording():
    truth = simulate(respond(**GIVEN), surfaces.random(1, 0.3, 0.02, 0.05), path("0.0005", ["0.3"]))
    return recording_of(truth.clamp, measured(truth.reactions, 1))


def read(recording, method, slope):
    asked = {"method": method, "noise": NOISE, "assume": False}
    return identify(Whisker(**GIVEN), recording, tolerances={"surface_slope": slope}, **asked)


def test_a_slope_turns_the_ratio_of_the_forces():
    mu0, delta = 0.3, 1e-4
    turned = np.tan(np.arctan(mu0) + delta) - mu0
    assert slope_errors(np.array([mu0]), delta)[0] == pytest.approx(turned, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["model", "ratio"])
def test_it_widens_every_interval_and_the_mean_by_what_neighbours_share(recording, method):
    level, found = read(recording, method, 0.0), read(recording, method, SLOPE)
    known = np.isfinite(found.periods.mu0)
    error = slope_errors(found.periods.mu0[known], SLOPE)
    expected = np.hypot(level.periods.deviation[known], error)
    assert found.periods.mu0 == pytest.approx(level.periods.mu0, nan_ok=True)
    assert found.periods.deviation[known] == pytest.approx(expected)
    assert (found.periods.high - found.periods.low)[known] == pytest.approx(
        2.0 * 1.96 * expected, rel=0.1
    )
    # What is only bounded is bounded less, too.
    bound = np.isfinite(found.periods.low) & ~known
    assert (found.periods.low < level.periods.low)[bound].all()
    one, other = level.summary(), found.summary()
    assert other.random > one.random + SLOPE / np.sqrt(known.sum())
    assert min(other.if_exact, key=other.if_exact.get) == "surface_slope"


def test_the_variance_of_a_mean_is_between_that_of_one_and_of_many():
    weights, error = np.full(1000, 1e-3), np.full(1000, 0.01)
    place = np.linspace(0.0, 1.0, 1000)
    assert variance_of_mean(weights, error, place, 1e9) == pytest.approx(1e-4)
    assert variance_of_mean(weights, error, place, 1e-9) == pytest.approx(1e-7)
    found = variance_of_mean(weights, error, place, 0.05)
    assert found == pytest.approx(weights @ (1e-4 * alike(place, place, 0.05)) @ weights)
