"""Whether a recording as a whole fits what was given, and what may be other where it does not."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

import recordings
from responses import respond
from steel import NOISE, identified
from vibrissa import Mounting
from vibrissa.errors import MixedColumnsError
from vibrissa.scanning.stage import path
from vibrissa.sensor import Setup, Whisker
from vibrissa.sensor.identification.goodness import Goodness, most_surprise

GIVEN = Whisker(theta=2.0, eta=0.85)
TURNS = ("0.6",)


@pytest.fixture(scope="module")
def response():
    return respond(2.0, 0.85)


def recorded(response, seed=1):
    return recordings.recorded(response, seed, TURNS)[1]


def found_in(recording, noise=NOISE, given=GIVEN):
    """What is known of a recording whose rod is taken as exact."""
    return identified(given, recording, noise=noise, assume=False)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [NOISE, None])
def test_a_recording_of_the_rod_fits_as_often_as_it_says(response, noise):
    found = recordings.goodness_of(response, range(4), noise)
    chances = np.array([each.chance for each in found])
    assert all(each.fits for each in found)
    assert np.mean([each.ratio for each in found]) == pytest.approx(1.0, abs=0.02)
    if noise is not None:
        # Chances are uniform where the noise is known.
        assert stats.kstest(chances, "uniform").pvalue > 1e-3


def test_the_chance_is_that_of_chi_squared():
    goodness = Goodness(chi2=130.0, degrees=100, noise_degrees=np.inf)
    assert goodness.chance == pytest.approx(stats.chi2.sf(130.0, 100))
    assert goodness.ratio == 1.3 and np.isnan(replace(goodness, degrees=0).ratio)
    # 140 of 100 has a chance of one in 190, 150 of one in 1,100.
    assert replace(goodness, chi2=140.0).fits and not replace(goodness, chi2=150.0).fits
    # With a noise that is not known itself a larger χ² is more likely.
    estimated = replace(goodness, noise_degrees=50.0)
    assert estimated.chance == pytest.approx(stats.f.sf(1.3, 100, 50.0))
    assert Goodness(chi2=0.0, degrees=0, noise_degrees=np.inf).fits


@pytest.mark.slow
def test_a_misfit_by_noise_that_is_larger_than_stated_is_explained(response):
    found = found_in(recorded(response), noise=NOISE / 1.3)
    assert not found.goodness.fits
    notes = [note for note in found.periods.left_out if "scatters from reading to reading" in note]
    assert [note.split()[0] for note in notes] == ["force_x", "force_y", "moment_z"]


def wrong(recording, name, size):
    """Recording whose transducer or stage has an error."""
    (fx, fy, m), clamp = recording.readings.T, recording.clamp
    turned = np.cos(size) * fx + np.sin(size) * fy, np.cos(size) * fy - np.sin(size) * fx
    readings = {
        "zero_force_x": (fx + size, fy, m),
        "zero_force_y": (fx, fy + size, m),
        "zero_moment_z": (fx, fy, m + size),
        "modulus": ((1 + size) * fx, (1 + size) * fy, (1 + size) * m),
        "transducer_angle": (*turned, m),
        "moment_origin_x": (fx, fy, m - size * fy),
        "moment_origin_y": (fx, fy, m + size * fx),
    }.get(name, (fx, fy, m))
    if name == "stage_scale":
        clamp = clamp / (1 + size)
    return replace(recording, readings=np.stack(readings, axis=1), clamp=clamp)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name, size",
    [
        ("zero_force_x", 0.01),
        ("zero_force_y", -0.02),
        ("zero_moment_z", 0.002),
        ("modulus", 0.01),
        ("transducer_angle", np.deg2rad(0.3)),
        ("moment_origin_x", 0.002),
        ("moment_origin_y", -0.005),
        ("stage_scale", 0.02),
    ],
)
def test_an_error_of_transducer_or_stage_is_found_and_its_size(response, name, size):
    recording = wrong(recorded(response), name, size)
    found = found_in(recording)
    assert not found.goodness.fits
    assert (found.periods.doubt != "").all()
    cause = found.causes[0]
    assert cause.parameter.name == name
    assert cause.size == pytest.approx(size, rel=0.1)
    assert cause.explained > 0.9


OTHER = {
    "theta": (replace(GIVEN, theta=2.02), 0.02),
    "eta": (replace(GIVEN, eta=0.846), -0.004),
    "clamp_angle": (replace(GIVEN, mounting=Mounting(clamp_angle=np.deg2rad(0.5))), 0.0087),
    "clamp_compliance": (replace(GIVEN, mounting=Mounting(clamp_compliance=0.01)), 0.01),
    "curvature": (replace(GIVEN, mounting=Mounting(curvature=-0.01)), -0.01),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", OTHER)
def test_another_rod_is_found_and_by_how_much(name):
    whisker, size = OTHER[name]
    found = found_in(recorded(whisker.response))
    assert not found.goodness.fits
    assert found.causes[0].parameter.name == name
    assert found.causes[0].size == pytest.approx(size, rel=0.15)


@pytest.mark.slow
def test_an_inclined_surface_is_found_and_by_how_much():
    whisker = replace(GIVEN, mounting=Mounting(stage_angle=np.deg2rad(0.5)))
    cause = found_in(recorded(whisker.stage(path("0.0005", TURNS)))).causes[0]
    assert cause.parameter.name == "stage_angle"
    assert cause.size == pytest.approx(np.deg2rad(0.5), rel=0.1)


@pytest.mark.parametrize(
    "mixed, said",
    [
        (np.diag([-1.0, 1.0, 1.0]), "the sign of force_x is wrong"),
        (-np.eye(3), "the sign of force_x, force_y, moment_z is wrong"),
        (np.eye(3)[[1, 0, 2]], "force_x and force_y are swapped"),
        (np.diag([1, -1, 1])[[1, 0, 2]], ".* swapped; after swapping them, the sign of force_y is"),
        (np.diag([1e3, 1e3, 1.0]), ".* unit of force_x and force_y is 1000 times too large"),
        (np.diag([1.0, 1.0, 1e-3]), "the stated unit of moment_z is 1000 times too small"),
    ],
)
def test_columns_that_were_mixed_up_are_named(response, mixed, said):
    recording = recorded(response)
    recording = replace(recording, readings=recording.readings @ mixed.T)
    with pytest.raises(MixedColumnsError, match=f"mixed up: {said}.*vibrissa import --column"):
        found_in(recording)


@pytest.mark.slow
@pytest.mark.parametrize("mixed", [np.eye(3)[[1, 0, 2]], np.diag([1.0, 1.0, -1.0])])
@pytest.mark.parametrize("method", ["model", "ratio"])
def test_nothing_is_adjusted_to_columns_that_were_mixed_up(response, mixed, method):
    """Within the assumed tolerances zeros, angles and crosstalk would make up for some of it."""
    recording = recorded(response)
    # The rod is a little other than it is given, within its tolerances.
    near = replace(GIVEN, theta=2.02, eta=0.852)
    recording = replace(recording, readings=recording.readings @ mixed.T)
    with pytest.raises(MixedColumnsError):
        identified(near, recording, noise=NOISE, method=method)


@pytest.mark.slow
def test_the_moment_alone_tells_what_it_can(response):
    recording = recorded(response)
    readings = recording.readings * [np.nan, np.nan, 1.03]
    found = found_in(replace(recording, readings=readings))
    assert not found.goodness.fits and found.causes
    assert "not compared with the ratio of the forces" in " ".join(found.periods.notes)


@pytest.mark.slow
def test_a_period_that_does_not_fit_by_itself_does_not_spoil_the_others(response):
    recording = recorded(response)
    whole = found_in(recording).periods
    bumped = recording.readings.copy()
    bumped[whole.first[3] : whole.last[3], 2] += -0.004
    found = found_in(replace(recording, readings=bumped))
    assert found.goodness.fits
    doubted = np.flatnonzero(found.periods.doubt != "")
    assert 3 in doubted and len(doubted) <= 2


@pytest.mark.slow
def test_sizes_are_said_in_the_units_of_the_rod(response):
    whisker = Setup.read(
        theta=2.0, eta="85 mm", modulus="210 GPa", diameter="1 mm", length="100 mm"
    ).whisker
    recording = wrong(recorded(response), "moment_origin_x", 0.002)
    cause = found_in(recording).causes[0]
    said = replace(cause, size=0.002, deviation=1e-5).spelled(whisker.units)
    assert said.startswith("moment_origin_x larger by 0.2 ± 0.001 mm (explains ")
    angle = replace(cause.parameter, of="clamp_angle")
    turned = replace(cause, parameter=angle, size=-np.pi / 180, deviation=1e-4)
    assert "smaller by 1 ± 0.006 deg" in turned.spelled(whisker.units)


def test_the_largest_of_many_surprises_has_the_same_level_as_one():
    assert most_surprise(1) == pytest.approx(stats.norm.isf(5e-4))
    for number in (1, 5, 25):
        chance = 1.0 - stats.chi2.cdf(most_surprise(number) ** 2, 1) ** number
        assert chance == pytest.approx(1e-3, rel=1e-2)
    assert most_surprise(25) == pytest.approx(4.1, abs=0.05)


@pytest.mark.slow
def test_a_zero_that_is_off_by_far_is_named_however_tight_its_tolerance(response):
    recording = recorded(response)
    wrong_zero = replace(recording, readings=recording.readings + np.array([0.0, 0.06, 0.0]))
    for size in (1e-3, 1e-5):
        tolerances = {f"zero_{name}": size for name in ("force_x", "force_y")}
        found = identified(GIVEN, wrong_zero, noise=NOISE, tolerances=tolerances, assume=False)
        cause = found.causes[0]
        assert cause.parameter.name == "zero_force_y" and cause.explained > 0.9
        assert cause.size == pytest.approx(0.06, rel=0.2)
