"""What is known to a tolerance is adjusted to the recording, and what remains is carried on."""

from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from adjusted import GIVEN, bias, carried, identify, recorded
from steel import NOISE, identified, recording_of, write
from vibrissa import Mounting
from vibrissa.cli.app import app
from vibrissa.errors import NoResponseError
from vibrissa.scanning import surfaces
from vibrissa.scanning.simulation import simulate
from vibrissa.scanning.stage import path
from vibrissa.sensor import Whisker
from vibrissa.sensor.identification.forward import forward_models


@pytest.mark.slow
def test_a_modulus_within_its_tolerance_is_found_and_spoils_nothing():
    truth, recording = recorded(GIVEN, scale=1.04)
    spoiled = identify(GIVEN, recording, method="model", noise=NOISE)
    assert abs(bias(spoiled, truth)[0]) > 10 * bias(spoiled, truth)[1]
    found = identify(GIVEN, recording, method="model", noise=NOISE, tolerances={"modulus": "3 %"})
    assert found.goodness.fits and (found.periods.doubt == "").all()
    (modulus,) = found.estimates
    assert modulus.size == pytest.approx(0.04, abs=4 * modulus.deviation)
    assert modulus.deviation < 2e-4
    assert abs(bias(found, truth)[0]) < 4 * bias(found, truth)[1]


@pytest.mark.slow
def test_a_small_tolerance_holds_what_was_given_and_then_it_does_not_fit():
    _, recording = recorded(GIVEN)
    error, tolerance = 0.01, 1e-5
    recording = replace(recording, readings=recording.readings + np.array([error, 0.0, 0.0]))
    found = identify(GIVEN, recording, noise=NOISE, tolerances={"zero_force_x": tolerance})
    (zero,) = found.estimates
    # The mean of what the recording tells and what was given, by their variances.
    told = 1.0 - (zero.deviation / tolerance) ** 2
    assert 0.01 < told < 0.9
    assert zero.size == pytest.approx(told * error, rel=0.05)
    assert not found.goodness.fits

    # Fully adjusted, but by more than its tolerance allows.
    _, recording = recorded(GIVEN, scale=1.04)
    found = identify(GIVEN, recording, noise=NOISE, tolerances={"modulus": 0.001})
    assert found.estimates[0].size == pytest.approx(0.04, rel=0.01)
    assert not found.goodness.fits


@pytest.mark.slow
def test_what_cannot_be_told_apart_is_shared_by_the_tolerances():
    _, recording = recorded(GIVEN, scale=1.0005)
    given = {"modulus": 0.03, "diameter": 0.01}
    modulus, diameter = identify(GIVEN, recording, noise=NOISE, tolerances=given).estimates
    # Loads are as E·d0⁴: its variance is 0.03² + (4·0.01)², of which E has 9/25.
    total = modulus.size + 4.0 * diameter.size
    assert total == pytest.approx(0.0005, abs=2e-4)
    assert modulus.size == pytest.approx(9.0 / 25.0 * total, rel=0.05, abs=2e-5)
    # Each stays as uncertain as the difference that no recording tells: 0.03·0.04/0.05.
    assert modulus.deviation == pytest.approx(0.024, rel=0.01)
    assert diameter.deviation == pytest.approx(0.006, rel=0.01)


@pytest.mark.slow
def test_what_a_recording_does_not_tell_is_carried_into_the_intervals():
    scores, shares = zip(*carried(range(3)), strict=True)
    assert 0.6 < np.sqrt(np.mean(np.square(scores))) < 1.5
    # The friction of one period is told by more than that: of a mean it is most of the error.
    assert min(shares) > 0.01


@pytest.mark.slow
@pytest.mark.parametrize(
    "name, size, tolerance",
    [
        ("clamp_angle", np.deg2rad(2.0), "1 deg"),
        pytest.param("clamp_compliance", 0.05, 0.05, marks=pytest.mark.nightly),
        pytest.param("curvature", -0.05, 0.05, marks=pytest.mark.nightly),
    ],
)
def test_another_mounting_within_its_tolerance_is_found(name, size, tolerance):
    truth, recording = recorded(replace(GIVEN, mounting=Mounting(**{name: size})))
    found = identify(GIVEN, recording, method="model", noise=NOISE, tolerances={name: tolerance})
    assert found.goodness.fits
    (one,) = found.estimates
    assert one.size == pytest.approx(size, abs=4 * one.deviation + 1e-9)
    assert abs(bias(found, truth)[0]) < 4 * bias(found, truth)[1]


@pytest.mark.slow
def test_a_moment_that_was_not_recorded_has_no_origin():
    _, recording = recorded(GIVEN)
    forces = replace(recording, readings=recording.readings * [1.0, 1.0, np.nan])
    given = {"moment_origin_x": 0.01, "moment_origin_y": 0.01}
    assert len(identify(GIVEN, recording, noise=NOISE, tolerances=given).estimates) == 2
    assert not identify(GIVEN, forces, noise=NOISE, tolerances=given).estimates


@pytest.mark.slow
def test_a_step_to_a_set_up_without_a_response_is_halved(monkeypatch):
    _, recording = recorded(GIVEN, scale=1.001)
    given = {"modulus": 0.01, "clamp_angle": "0.1 deg"}
    wanted = identify(GIVEN, recording, noise=NOISE, tolerances=given)
    tried = []

    def unsolved_at_first(task, rod, *sets):
        tried.extend(p for p in sets if len(sets) == 1 and p.any())
        if len(tried) == 1:
            raise NoResponseError("no response")
        return forward_models(task, rod, *sets)

    monkeypatch.setattr("vibrissa.sensor.identification.search.forward_models", unsolved_at_first)
    found = identify(GIVEN, recording, noise=NOISE, tolerances=given)
    assert tried[1] == pytest.approx(0.5 * tried[0])
    for one, other in zip(found.estimates, wanted.estimates, strict=True):
        assert one.size == pytest.approx(other.size, abs=0.01 * other.deviation)


@pytest.mark.slow
def test_a_clamp_does_not_yield_less_than_a_rigid_one():
    truth, recording = recorded(GIVEN)
    given = {"clamp_compliance": 0.05, "theta": 0.02}
    found = identify(GIVEN, recording, method="model", noise=NOISE, tolerances=given)
    (adjusted,) = [one.size for one in found.estimates if one.parameter.of == "clamp_compliance"]
    assert adjusted >= 0.0
    assert abs(bias(found, truth)[0]) < 4 * bias(found, truth)[1]


@pytest.mark.slow
def test_the_friction_is_that_of_the_expected_clamp_not_of_the_likeliest_one():
    # The likeliest clamp of all that yield by 0 ± 0.005 is rigid; the mean one yields by this:
    mean = 0.005 * np.sqrt(2.0 / np.pi)
    yielding = Whisker(theta=3.0, eta=0.85, mounting=Mounting(clamp_compliance=mean))
    truth = simulate(yielding.response, surfaces.constant(0.3), path("0.001", ["0.25"]))
    recording = recording_of(truth.clamp, truth.reactions)
    known = identified(yielding, recording, noise=NOISE, tolerances={"clamp_compliance": "exact"})
    stated = identified(Whisker(theta=3.0, eta=0.85), recording, noise=NOISE)
    (compliance,) = [one for one in stated.estimates if one.parameter.of == "clamp_compliance"]
    # The recording hardly tells: the fit is far from the truth, and the friction is not.
    assert compliance.size < 0.5 * mean
    assert stated.summary().mean == pytest.approx(known.summary().mean, abs=1e-4)


@pytest.mark.slow
def test_tolerances_on_the_command_line(tmp_path):
    _, recording = recorded(GIVEN, scale=1.01)
    write(tmp_path / "scan.csv", recording)
    given = ["--theta", "2", "--eta", "0.85", "-o", str(tmp_path / "found.csv")]
    given += ["--verbose", "--noise", ", ".join(f"{value:.9g}" for value in NOISE)]

    def said(*more):
        return CliRunner().invoke(app, ["identify", str(tmp_path / "scan.csv"), *given, *more])

    result = said("--tolerance", "modulus=3 %", "--tolerance", "exact")
    assert result.exit_code == 0
    assert "off by +1" in result.stdout or "off by +0.99" in result.stdout
    assert "modulus: given to ± 3 %, off by +" in result.stdout
    assert "does not fit" not in result.stdout
    assert said("--tolerance", "modulus").exit_code == 2
    twice = said("--tolerance", "modulus=3 %", "--tolerance", "modulus=2 %")
    assert twice.exit_code == 2 and "given twice" in twice.stderr
