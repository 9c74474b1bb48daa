"""Recordings that break the rules of sticking and slipping, one rule at a time."""

import numpy as np
import pytest

from responses import by_law, respond
from steel import NOISE, measured, recording_of
from steel import identified as friction_in
from vibrissa.outcomes import SlipLaw
from vibrissa.scanning import surfaces
from vibrissa.scanning.simulation import simulate
from vibrissa.scanning.stage import path
from vibrissa.sensor import Whisker
from vibrissa.sensor.identification.periods import Check, Grade

ROD = Whisker(theta=2.0, eta=0.85)


@pytest.fixture(scope="module")
def response():
    return respond(2.0, 0.85)


def signals(response, law="free", turns=("0.4",), step="0.0005"):
    """Clamp positions, readings and the first row of each period of a clean recording."""
    surface = surfaces.random(3, 0.3, 0.04, 0.05)
    truth = simulate(response, surface, path(step, turns), by_law(law))
    begins = np.flatnonzero(np.diff(truth.period, prepend=0))
    return truth.clamp.copy(), measured(truth.reactions, 4), begins


def identified(clamp, readings):
    return friction_in(ROD, recording_of(clamp, readings), noise=NOISE, assume=False)


@pytest.mark.parametrize("law", list(SlipLaw))
@pytest.mark.parametrize(
    "turns", [("0.4",), pytest.param(("0.3", "0.1"), marks=pytest.mark.nightly)]
)
def test_a_clean_recording_leaves_no_doubt(response, law, turns):
    clamp, readings, begins = signals(response, law, turns)
    periods = identified(clamp, readings).periods
    # Of slips at every third sample some are missed.
    assert 0.9 * len(begins) < len(periods) <= len(begins)
    said = {why for doubt in periods.doubt for why in doubt.split("; ")}
    # Slips of a pulled tip are so short that they follow each other within a few steps.
    short = {one.sentence for one in periods.checks if "few" in one.sentence}
    assert said - (short if law == "kinetic" and len(turns) > 1 else set()) == {""}


def test_a_reading_that_stands_still_is_doubted(response):
    clamp, readings, begins = signals(response, step="0.0001")
    stop = begins[3]
    readings[stop - 30 : stop] = readings[stop - 30]
    periods = identified(clamp, readings).periods
    (doubt,) = [text for text in periods.doubt if text]
    assert "does not fit a tip that sticks" in doubt
    assert periods.grade.tolist() == ["wrong" if text else "" for text in periods.doubt]
    assert periods.doubt[2] == doubt
    (note,) = [note for note in periods.notes if "does not fit" in note]
    assert f"line {begins[2] + 2}-{stop + 1}" in note


@pytest.mark.slow
def test_samples_of_a_rest_that_was_not_cut_off_are_not_in_the_mean(response):
    clamp, readings, _ = signals(response)
    # At rest the readings stay, while the clamp is taken to move.
    rest = np.arange(-2, 0) * 0.0005 + clamp[0]
    begun = measured(response.reactions(np.zeros(2)), 5)
    whole = identified(clamp, readings).periods
    late = identified(np.r_[rest, clamp], np.r_[begun, readings])
    assert late.periods.grade[0] == Grade.WRONG
    late = late.summary()
    assert late.left == {"open": 1, "wrong": 1}
    assert late.mean == pytest.approx(whole.mu0[1:-1].mean(), abs=late.random)


def test_a_recording_that_runs_backward_is_doubted(response):
    clamp, readings, _ = signals(response)
    periods = identified(clamp[::-1], readings[::-1]).periods
    assert all("the tip cannot slip in this direction" in doubt for doubt in periods.doubt[:-1])


def test_a_jump_of_the_clamp_is_doubted(response):
    clamp, readings, begins = signals(response)
    clamp[begins[3] - 10 :] += 0.1
    periods = identified(clamp, readings).periods
    doubtful = [i for i, doubt in enumerate(periods.doubt) if "the clamp jumped" in doubt]
    # The period after the jump has its friction by its own samples.
    assert doubtful == [2] and periods.doubt[3] == ""


def test_the_grade_of_a_period_is_that_of_its_worst_doubt(response):
    """Whatever the order in which the doubts are found."""
    clamp, readings, _ = signals(response)
    sound = identified(clamp, readings).periods
    rows = np.arange(len(sound))
    checks = [Check(grade, rows >= k, grade.value) for k, grade in enumerate(Grade, 1)]
    for order in (checks, checks[::-1]):
        doubted = sound.doubted(*order)
        assert doubted.grade[:3].tolist() == ["", "doubtful", "wrong"]
        assert set(doubted.doubt[2].split("; ")) == {"doubtful", "wrong"}


def test_samples_that_are_missing_on_the_way_back_are_seen(response):
    clamp, readings, begins = signals(response, turns=("0.3", "0.1"))
    slip = begins[begins > np.argmax(clamp) + 50][1]
    kept = np.r_[: slip - 8, slip + 8 : len(clamp)]
    periods = identified(clamp[kept], readings[kept]).periods
    doubtful = [i for i, doubt in enumerate(periods.doubt) if "samples are missing" in doubt]
    assert doubtful == np.flatnonzero(periods.last == slip - 9).tolist() and len(doubtful) == 1


def test_a_clamp_that_turned_unseen_is_doubted(response):
    clamp, readings, begins = signals(response, turns=("0.3", "0.1"))
    top = int(np.argmax(clamp))
    before = int(begins[begins < top][-3]) + 20
    after = top + round((clamp[top] - clamp[before]) / 0.0005) - 1
    keep = np.r_[:before, after : len(clamp)]
    periods = identified(clamp[keep], readings[keep]).periods
    assert any("or turned" in doubt for doubt in periods.doubt)
