"""The closed form of the taper study agrees with what the identification states."""

import numpy as np
import pytest

from validation import taper
from vibrissa.sensor import Recording, Units, identify, path, respond, simulate, surfaces


@pytest.mark.slow
@pytest.mark.parametrize(("theta", "step"), [(1.0, 0.0005), (3.0, 0.0005), (3.0, 0.002)])
def test_prediction_agrees_with_what_the_identification_states(theta, step):
    response = respond(theta, taper.ETA, taper.CONTACT, pull=False)
    rod = taper.rods(theta)[2]
    noise, scale = taper.noise_in(rod), Units(rod).channels
    truth = simulate(response, surfaces.random(1, 0.3, 0.02, 0.02), path(step, [0.6]))
    sensor = taper.SENSOR
    readings = sensor.measured(truth.reactions * scale, np.random.default_rng(1)) / scale
    recording = Recording(clamp=truth.clamp, readings=readings, line=np.arange(len(readings)))
    asked = {"noise": noise, "assume": False}
    found = identify(taper.whisker(theta), recording, **asked).periods
    expected = taper.predicted(response, truth.mu0[found.last], step, noise)
    ratio = (found.deviation / expected)[np.isfinite(found.deviation)]
    assert len(ratio) > 8
    # The reading's own noise and where it stands in its step move single periods.
    assert np.median(ratio) == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("theta", [2.0, 3.0])
def test_rods_are_alike_in_what_their_design_says(theta):
    (force, strain), (force1, strain1) = taper.onset(theta), taper.onset(1.0)
    same, strained, pressed = taper.rods(theta)
    (cylinder, *_) = taper.rods(1.0)
    assert same.base_diameter == cylinder.base_diameter
    assert strain * strained.base_diameter == pytest.approx(strain1 * cylinder.base_diameter)
    assert force * pressed.force_unit == pytest.approx(force1 * cylinder.force_unit)
