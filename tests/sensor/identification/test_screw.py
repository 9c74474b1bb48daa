"""Positions that are wrong by an error that repeats, as by a lead screw."""

from dataclasses import replace

import numpy as np
import pytest

from steel import recording_of
from validation.sensor.bench import scan
from validation.sensor.laboratory import NOISE, STEP, believed, in_words
from validation.sensor.mistakes import bench_of
from vibrissa.sensor import identify
from vibrissa.sensor.identification.screw import PitchError

PITCH, SIZE = 0.02, 5e-5
# Whether the usual tolerances are assumed.
ASSUMED = [False, pytest.param(True, marks=pytest.mark.nightly)]


def read(bench, assume, size=0.0):
    found = scan(bench, STEP, [0.2], NOISE, 1)
    stage = found.stage - size * np.sin(2.0 * np.pi * found.stage / PITCH + 0.7)
    return identify(
        believed(noise=in_words(NOISE), assume=assume), recording_of(stage, found.readings)
    )


@pytest.mark.slow
@pytest.mark.parametrize("assume", ASSUMED)
def test_a_lead_screw_is_named_with_its_pitch_and_its_error(assume):
    found = read(bench_of(1), assume, SIZE)
    first = found.causes[0]
    assert isinstance(first, PitchError)
    assert first.pitch == pytest.approx(PITCH, rel=0.005)
    assert first.size == pytest.approx(SIZE, rel=0.06)
    assert "that repeats every 0.002 m, perhaps the pitch of a lead screw" in str(found.summary())
    assert (found.periods.grade != "").all()


@pytest.mark.slow
@pytest.mark.parametrize("assume", ASSUMED)
def test_a_bent_rod_is_no_lead_screw(assume):
    bench = bench_of(1)
    bent = replace(bench, rod=replace(bench.rod, curvature=0.12))
    found = read(bent, assume)
    assert found.causes and not any(isinstance(one, PitchError) for one in found.causes)
