"""Recorders that are faster than the sensor or the stage, and readings of a coarse resolution."""

from dataclasses import replace

import numpy as np
import pytest

import recordings
from responses import respond
from steel import NOISE, identified
from vibrissa.sensor import Whisker
from vibrissa.sensor.identification.holds import Holds, fresh_rows, resolution, rounding
from vibrissa.sensor.identification.recording import as_measured

ROD = Whisker(theta=2.0, eta=0.85)


def noisy(rows=400, seed=1):
    """Readings that rise from row to row, with noise."""
    rise = np.linspace(0.0, 1.0, rows)[:, None] * [1.0, -2.0, 0.5]
    return rise + np.random.default_rng(seed).normal(0.0, 0.01, (rows, 3))


def held(rows, lengths):
    """For each of some rows, the row in which its hold begins."""
    starts = np.cumsum(np.append(0, lengths))
    starts = starts[starts < rows]
    return starts[np.searchsorted(starts, np.arange(rows), side="right") - 1]


@pytest.mark.parametrize("times", [2, 3, 10])
@pytest.mark.parametrize("channels", [[0, 1, 2], [2]])
def test_one_row_of_each_repeated_reading_is_fresh(times, channels):
    lengths = times + np.random.default_rng(2).integers(-1, 2, 400) * (times > 3)
    source = held(400, lengths)
    readings = np.full((400, 3), np.nan)
    readings[:, channels] = noisy()[source][:, channels]
    assert np.flatnonzero(fresh_rows(readings)).tolist() == np.unique(source).tolist()


@pytest.mark.parametrize("step", [0.02, 0.05, 0.1])
@pytest.mark.parametrize("channels", [[0, 1, 2], [0, 1], [2]])
def test_a_coarse_resolution_repeats_no_reading(step, channels):
    readings = np.full((400, 3), np.nan)
    readings[:, channels] = (np.round(noisy() / step) * step)[:, channels]
    assert fresh_rows(readings).all()


def test_the_resolution_is_the_step_of_the_values():
    values = noisy(4000)[:, 0]
    assert resolution(values) == 0.0
    assert resolution(np.round(values / 0.05) * 0.05) == pytest.approx(0.05)
    # A step of 0.0244 that is printed with three decimals.
    printed = np.round(np.round(values / 0.0244) * 0.0244, 3)
    assert resolution(printed) == pytest.approx(0.0244, rel=0.05)
    deviation, rows = rounding(np.repeat(np.arange(20.0), 5))
    assert deviation == pytest.approx(1.0 / np.sqrt(12.0)) and rows == 5.0
    assert resolution(np.ones(5)) == 0.0


def test_positions_that_are_held_in_motion_are_interpolated():
    true = 0.01 * np.arange(400.0)
    holds = Holds.of(true[held(400, np.full(50, 8))])
    assert holds.hides_motion(noisy())
    found = holds.interpolated()
    assert found[:393] == pytest.approx(true[:393], abs=1e-12)
    assert np.isnan(found[393:]).all()


def test_a_rest_between_held_positions_remains_a_rest():
    true = 0.01 * np.concatenate([np.arange(100.0), np.full(50, 100.0), np.arange(100.0, 200.0)])
    holds = Holds.of(true[held(250, np.full(60, 5))])
    found = holds.interpolated()
    assert found[:245] == pytest.approx(true[:245], abs=0.011)
    assert np.ptp(found[105:145]) < 1e-12


def test_a_stage_that_rests_after_each_step_holds_no_position():
    clamp = np.repeat(0.01 * np.arange(40.0), 10)
    loads = np.repeat(noisy(40), 10, axis=0) + np.random.default_rng(3).normal(0, 1e-3, (400, 3))
    assert not Holds.of(clamp).hides_motion(loads)
    assert not Holds.of(np.arange(400.0)).hides_motion(loads)


@pytest.fixture(scope="module")
def fine():
    """A recording of many rows, and its true friction."""
    return recordings.recorded(respond(2.0, 0.85), turns=("0.4",), step="0.0001")


def mean_of(recording, **stated):
    found = identified(ROD, recording, assume=False, **stated)
    return found, found.summary()


@pytest.mark.slow
@pytest.mark.parametrize("which", ["readings", "positions", "both"])
def test_a_held_recording_gives_the_friction_without_doubt(fine, which):
    _, recording = fine
    whole = mean_of(recording)[1]
    source = held(len(recording), np.full(len(recording), 10))
    if which != "positions":
        recording = replace(recording, readings=recording.readings[source])
    if which != "readings":
        recording = replace(recording, clamp=recording.clamp[source])
    found, summary = mean_of(recording)
    assert found.goodness.fits and summary.doubtful + summary.wrong <= 1
    # A period ends in the last tenth of its rows at an unknown row.
    assert summary.mean == pytest.approx(whole.mean, abs=4.0 * summary.deviation)
    assert any("about 10 rows" in note for note in found.periods.notes)


@pytest.mark.slow
@pytest.mark.parametrize("steps", [6.0, 30.0])
@pytest.mark.parametrize("noise", [None, NOISE])
def test_a_reading_is_at_least_as_uncertain_as_its_resolution(fine, steps, noise):
    truth, recording = fine
    step = steps * NOISE
    found, summary = mean_of(
        replace(recording, readings=np.round(recording.readings / step) * step), noise=noise
    )
    known = found.periods.status == "slip"
    true = truth.mu0[found.periods.last[known]].mean()
    assert found.goodness.fits and not summary.wrong
    assert sum("coarser than its noise" in note for note in found.periods.notes) == 3
    assert summary.mean == pytest.approx(true, abs=4.0 * summary.deviation)


def test_the_usual_time_between_rows_is_that_of_new_readings():
    _, recording = recordings.recorded(respond(2.0, 0.85), turns=("0.1",))
    repeated = recording.take(np.repeat(np.arange(len(recording)), 4))
    repeated = replace(repeated, clamp=0.001 * np.arange(len(repeated)), interval=0.01)
    found = as_measured(repeated)
    assert len(found) == len(recording) and found.interval == pytest.approx(0.04)
