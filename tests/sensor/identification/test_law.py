"""Slips that do not end where their law says are noticed."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from steel import NOISE, measured, recording_of
from vibrissa.errors import ArgumentError, UndeterminedError
from vibrissa.sensor import path, respond, simulate, surfaces
from vibrissa.sensor.identification.calibration import known_setup
from vibrissa.sensor.identification.friction import find_periods
from vibrissa.sensor.identification.misfit.doubts import Doubt
from vibrissa.sensor.identification.misfit.law import apart
from vibrissa.sensor.identification.reading.kinetic import KineticRatio, sharing_ratio
from vibrissa.sensor.identification.reading.methods import AT_REST, EITHER, ON_THE_WAY


@cache
def response():
    return respond(2.0, 0.85)


def read(law, ratio, given_law, given_ratio, method="spacing", to="0.15", unsure=None):
    truth = simulate(
        response(), surfaces.random(1, 0.3, 0.02, 0.05), path("0.0002", [to]), law, ratio
    )
    recording = recording_of(truth.clamp, measured(truth.reactions, 1))
    setup = known_setup(response())
    if unsure is not None:
        setup = sharing_ratio(setup, KineticRatio(value=given_ratio, deviation=unsure))
    return find_periods(
        setup,
        recording,
        NOISE,
        method=method,
        law=given_law,
        kinetic_ratio=given_ratio,
    )


@pytest.mark.parametrize(("unsure", "said"), [(0.05, True), (1e-3, False), (None, False)])
def test_a_ratio_that_the_readings_tell_better_need_not_be_given(unsure, said):
    found = read("kinetic", 0.8, "kinetic", 0.8, unsure=unsure)
    notes = [note for note in found.notes if "closer than the 0.8 ± 0.05 that was given" in note]
    assert len(notes) == said
    if said:
        assert notes[0].startswith("the states after slips tell kinetic_ratio = 0.8")
        larger = found.common[:-1].max()
        assert read("kinetic", 0.8, "kinetic", None).common[1:-1].max() < 0.5 * larger


def doubted(found):
    return np.char.find(found.doubt, Doubt.LAW.why) >= 0


@pytest.mark.parametrize(
    ("law", "ratio", "given_law", "given_ratio", "part"),
    [
        ("kinetic", 0.75, "kinetic", 0.8, "0.75"),
        ("kinetic", 0.8, "kinetic", 0.75, "0.80"),
        ("kinetic", 0.8, "free", None, "0.80"),
        ("free", 0.8, "kinetic", 0.8, "0.00"),
    ],
)
def test_another_law_or_ratio_is_noticed_and_the_ratio_is_told(
    law, ratio, given_law, given_ratio, part
):
    found = read(law, ratio, given_law, given_ratio)
    assert doubted(found).all()
    (note,) = (note for note in found.notes if "after its slips" in note)
    assert f"needs {part}" in note


@pytest.mark.parametrize(
    ("law", "ratio"), [("kinetic", 0.8), ("kinetic", 0.6), ("free", 0.8), ("energy", 0.8)]
)
def test_the_law_by_which_slips_end_is_not_doubted(law, ratio):
    assert not doubted(read(law, ratio, law, ratio)).any()


def test_without_a_law_and_by_other_methods_nothing_is_asked_of_it():
    assert not doubted(read("kinetic", 0.8, None, None)).any()
    assert not doubted(read("kinetic", 0.75, "kinetic", 0.8, "moment")).any()


@pytest.mark.parametrize("ratio", [0.5, 0.8])
def test_the_states_after_kinetic_slips_tell_the_ratio(ratio):
    found = read("kinetic", ratio, "kinetic", None)
    known = found.status == "slip"
    assert abs(found.kinetic.value - ratio) < 3.0 * found.kinetic.deviation < 0.005
    (note,) = (note for note in found.notes if "by the states after slips" in note)
    assert note.startswith(f"kinetic_ratio = {found.kinetic.value:.3f} ± ")
    given = read("kinetic", ratio, "kinetic", ratio)
    change = (found.mu0 - given.mu0)[known]
    assert np.abs(change).max() < found.deviation[known].min()
    # What is not known of the ratio is an error that all periods share, the last one.
    assert found.effects.shape == (len(found), 1) and given.common.max() == 0.0
    by_ratio = found.effects[known, 0] * found.kinetic.deviation
    assert found.common[known] == pytest.approx(np.abs(by_ratio))
    assert (by_ratio > 0.0).all()


def test_few_slips_do_not_tell_the_ratio():
    with pytest.raises(UndeterminedError, match="after its slips: give it"):
        read("kinetic", 0.8, "kinetic", None, to="0.02")


def test_the_law_of_the_energy_needs_the_ratio():
    with pytest.raises(ArgumentError, match="kinetic ratio"):
        read("energy", 0.8, "energy", None)


def periods_at(mu0, by_step, deviation):
    """Periods of which nothing else matters."""
    known = read("kinetic", 0.8, "kinetic", 0.8)
    known = known.take(known.status == "slip")
    whole = np.ones(len(known))
    return replace(known, mu0=mu0 * whole, by_step=by_step * whole, deviation=deviation * whole)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("size", "deviation", "early", "off"),
    [
        (0.0, 1e-5, AT_REST, False),
        (-1e-3, 1e-5, ON_THE_WAY, False),
        (-0.5e-3, 1e-5, EITHER, False),
        (0.0, 1e-3, EITHER, False),
        (-2e-3, 1e-5, ON_THE_WAY, True),
        (2e-3, 1e-5, AT_REST, True),
    ],
)
def test_the_travels_tell_whether_a_tip_slips_while_the_stage_moves(size, deviation, early, off):
    # By half a step, of which √12 deviations are uniform within it.
    step = 1e-3 / np.sqrt(3.0)
    states = periods_at(0.3, 0.0, 0.0)
    travels = periods_at(0.3 + size, step, deviation * np.sqrt(len(states)))
    found = apart(travels, states, None)
    assert found.size == pytest.approx(size) and found.half_step == pytest.approx(1e-3)
    assert found.deviation == pytest.approx(deviation)
    assert (found.early, found.off_law) == (early, off)
