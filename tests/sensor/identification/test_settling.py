"""Slips that last several samples, of a rod whose loads grow evenly: all in closed form."""

from dataclasses import replace

import numpy as np
import pytest

from steel import recording_of
from straight import ALL, Straight
from vibrissa.sensor.identification.preparing.settling import Told, settled
from vibrissa.sensor.quantities import Units

STEP, STICK, SLIPS = 0.001, 60, 5
FROM = 0.1


def places(late=0, early=0, lag=0.0, way=1.0, slips=SLIPS, stick=STICK):
    """Place of the contact for each sample: it jumps each 60 samples, or takes a while.

    `late` samples after a slip are half-way, as are `early` before it; or it lags behind with a
    time constant of `lag` samples.
    """
    size = (slips + 1) * stick
    clamp = STEP * np.arange(size)
    jump = stick * STEP
    whole = clamp - FROM - STEP * (np.arange(size) % stick)
    place = whole.copy()
    for first in range(stick, size, stick):
        place[first : first + late] -= 0.5 * jump
        place[first - early : first] += 0.5 * jump
        if lag:
            rows = np.arange(size - first)
            place[first:] -= jump * np.exp(-(rows + 1.0) / lag)
    return way * clamp, way * place


def read(told=None, noise=0.0, **how):
    clamp, place = places(**how)
    rng = np.random.default_rng(1)
    readings = Straight()(clamp - place) + noise * ALL.noise * rng.standard_normal((len(clamp), 3))
    channels = replace(ALL, noise=ALL.noise * 0.01)
    recording = recording_of(clamp, readings)
    return recording, settled(Straight(), recording, channels, told or Told(), Units())


def left_out(recording, found):
    """Which samples are left out, counted from the slip next to them."""
    rows = np.setdiff1d(recording.line, found.line) - 2
    return ((rows + STICK // 2) % STICK - STICK // 2).tolist()


def test_slips_within_a_sample_leave_the_recording_as_it_is():
    recording, found = read()
    assert found is recording
    # Three slips between long periods are the fewest that tell anything; of long readings.
    for how in ({"slips": 2, "late": 3}, {"stick": 19, "slips": 9, "late": 3}):
        recording, found = read(**how)
        assert found is recording


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("slips", [3, 5])
def test_samples_that_fit_neither_contact_are_left_out(way, slips):
    recording, found = read(late=3, way=way, slips=slips)
    # The one before the first that shows the slip may belong to it.
    assert left_out(recording, found) == [-1, 0, 1, 2] * slips
    (note, lag) = found.notes
    number = 4 * slips
    assert note.startswith(f"the readings have not settled after a slip in {number} rows, left out")
    # Half of the step is lacking in three samples.
    assert lag == "the readings lag behind the clamp by 0 L or 0.0015 L"
    last = np.flatnonzero(np.isfinite(found.slipping.way))
    assert found.line[last].tolist() == [2 + 60 * n - 2 for n in range(1, slips + 1)]
    # From it the clamp goes two steps to the first sample that shows the slip.
    assert found.slipping.way[last] == pytest.approx(np.full(slips, way * 2.0 * STEP))
    assert found.slipping.lag_low.tolist() == [0.0] * len(found)
    assert found.slipping.lag_high == pytest.approx(np.full(len(found), way * 1.5 * STEP))


def test_samples_before_the_first_that_shows_a_slip_are_left_out_too():
    recording, found = read(early=2, late=1)
    # Those at −2, −1 and 0 show it.
    assert left_out(recording, found) == [-3, -2, -1, 0] * SLIPS


@pytest.mark.parametrize("lag", [2.0, 4.0])
def test_a_filter_of_first_order_lags_by_its_time_constant(lag):
    _, found = read(lag=lag)
    # Σ e^(−n/τ) from n = 1 on.
    delay = 1.0 / (np.exp(1.0 / lag) - 1.0)
    assert found.slipping.lag_high == pytest.approx(np.full(len(found), delay * STEP), rel=0.03)


def test_what_is_told_of_slips_and_filter_holds():
    # A slip that is longer than what is seen; the readings do not lag.
    recording, found = read(Told(slip=5.2), late=3)
    assert left_out(recording, found) == [-1, 0, 1, 2, 3, 4, 5] * SLIPS
    assert not found.slipping.lag_low.any() and not found.slipping.lag_high.any()
    assert len(found.notes) == 1
    # A shorter one: what is seen is left out all the same.
    recording, found = read(Told(slip=1.0), late=3)
    assert left_out(recording, found) == [-1, 0, 1, 2] * SLIPS
    # A delay holds whatever slips look like.
    for late in (0, 3):
        _, found = read(Told(delay=2.53456), late=late)
        assert found.notes[-1] == "the readings lag behind the clamp by 0.00253 L"
        for lag in (found.slipping.lag_low, found.slipping.lag_high):
            assert lag == pytest.approx(np.full(len(found), 2.53456 * STEP))
    recording, found = read(Told(delay=0.0, slip=0.0))
    assert found is recording


def test_noise_does_not_make_a_slip_longer():
    recording, found = read(noise=0.01, late=3)
    assert left_out(recording, found) == [-1, 0, 1, 2] * SLIPS
    recording, found = read(noise=0.01)
    assert found is recording
