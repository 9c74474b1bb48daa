"""Factors by which a rod, a unit or the positions are wrong are named."""

import re
from dataclasses import replace

import numpy as np
import pytest

import recordings
from responses import respond
from steel import NOISE, identified
from vibrissa.errors import RecordingError, WrongRodError
from vibrissa.sensor import Whisker
from vibrissa.sensor.identification.factors import ALL_LOADS, Factor

ROD = Whisker(theta=2.0, eta=0.85)


@pytest.fixture(scope="module")
def recording():
    return recordings.recorded(respond(2.0, 0.85), turns=("0.3",))[1]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("gains", "said"),
    [
        ([16.0, 16.0, 16.0], "all loads are 16 times .* the stated diameter is a radius; check"),
        ([9.80665, 9.80665, 1.0], "force_x and force_y are 9.8.* times .* kgf instead of N"),
        ([1.0, 0.5, 1.0], "force_y is 0.5 times .*: check its gain"),
    ],
)
def test_a_factor_of_the_loads_is_named(recording, gains, said):
    wrong = replace(recording, readings=recording.readings * gains)
    with pytest.raises(WrongRodError, match=said):
        identified(ROD, wrong, noise=NOISE * gains)


@pytest.mark.parametrize(
    ("group", "size", "said"),
    [
        (ALL_LOADS, 0.0625, "all loads are 0.0625 times .* the diameter is stated twice"),
        (ALL_LOADS, 3.0, r"all loads are 3 times .*: check modulus and diameter \(1.32 times"),
        ("moment_z", 25.4, "moment_z is 25.4 times .* an inch instead of mm"),
    ],
)
def test_a_factor_says_what_it_may_come_from(group, size, said):
    assert re.match(said, str(Factor(group=group, size=size, misfit=0.0)))


@pytest.mark.parametrize(
    ("factor", "said"),
    [(25.4, "25.4 times .* the inch instead of mm"), (10.0, "10 times .* cm instead of mm")],
)
def test_a_factor_of_the_positions_is_named(recording, factor, said):
    wrong = replace(recording, clamp=recording.clamp * factor)
    with pytest.raises(WrongRodError, match=f"the clamp travels {said}"):
        identified(ROD, wrong, noise=NOISE)


@pytest.mark.slow
def test_a_rod_of_another_shape_has_no_factor(recording):
    with pytest.raises(WrongRodError, match="check rod, height, columns"):
        identified(replace(ROD, theta=1.0, eta=0.6), recording, noise=NOISE)


@pytest.mark.slow
def test_the_ratio_of_forces_that_fit_no_state_is_doubted(recording):
    wrong = replace(recording, readings=recording.readings * [1.0, 0.5, 1.0])
    found = identified(ROD, wrong, method="ratio", noise=NOISE, assume=False)
    summary = found.summary()
    assert summary.doubtful == summary.used
    assert any("force_y is 0.5 times" in note for note in found.periods.notes)


def test_without_a_rod_the_output_says_that_nothing_checks_mu0(recording):
    found = identified(None, recording, noise=NOISE)
    assert sum("nothing checks mu0" in note for note in found.periods.notes) == 1


@pytest.mark.parametrize("every", [3, 2])
def test_a_slip_in_every_second_or_third_sample_asks_for_finer_samples(every):
    teeth = np.tile([*np.arange(every - 1.0), -1.0], 60)[:100]
    clamp = 0.01 * np.arange(100.0)
    readings = np.stack([-1.0 - 0.1 * teeth, np.full(100, -2.0), 0.3 + 0.1 * teeth], axis=1)
    readings += np.random.default_rng(1).normal(0.0, 1e-3, readings.shape)
    recording = recordings.recording_of(clamp, readings)
    for rod in (ROD, None):
        with pytest.raises(RecordingError, match="sample more finely"):
            identified(rod, recording)
