"""Slips that last several samples, of a rod whose loads grow evenly: all in closed form."""

from dataclasses import replace

import numpy as np
import pytest

from steel import recording_of
from straight import ALL, SLOPES, Straight
from vibrissa.sensor.identification.preparing.settling import Told, settled
from vibrissa.sensor.quantities import Units

STEP, STICK, SLIPS = 0.001, 60, 5
FROM = 0.1


def places(
    late=0,
    early=0,
    creep=0.0,
    lag=0.0,
    way=1.0,
    slips=SLIPS,
    stick=STICK,
    long=0,
    longer=15,
    step=STEP,
):
    """Place of the contact for each sample: it jumps each 60 samples, or takes a while.

    `late` samples after a slip are half-way, as are `early` before it; eight samples before it are
    off by `creep`, or it lags behind with a time constant of `lag` samples. Of some slips, `long`,
    another number of samples is half-way.
    """
    size = (slips + 1) * stick
    clamp = STEP * np.arange(size)
    jump = stick * STEP
    whole = clamp - FROM - STEP * (np.arange(size) % stick)
    place = whole.copy()
    for number, first in enumerate(range(stick, size, stick)):
        place[first : first + (longer if number < long else late)] -= 0.5 * jump
        place[first - early : first] += 0.5 * jump
        place[first - 8 : first] += creep
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


@pytest.mark.parametrize(
    ("how", "told"),
    [
        ({"slips": 2}, False),
        ({"slips": 3}, True),
        # Beside three samples of the slip, periods of 20 show when readings have settled.
        ({"stick": 22}, False),
        ({"stick": 23}, True),
    ],
)
def test_three_slips_between_long_periods_are_the_fewest_that_tell_anything(how, told):
    recording, found = read(late=3, **how)
    assert (found is not recording) == told


@pytest.mark.parametrize(("long", "late"), [(1, 3), (2, 3), (3, 15)])
def test_slips_last_as_long_as_most_of_them(long, late):
    """A tip that rests at a third place for a while makes no other slip longer."""
    recording, found = read(late=3, long=long)
    assert left_out(recording, found) == [*range(-1, late)] * SLIPS
    counted = [15] * long + [3] * (SLIPS - long) if late == 15 else [3]
    assert found.slipping.lag_high[0] == pytest.approx(0.5 * np.mean(counted) * STEP)


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


def test_a_slip_of_one_sample_lags_by_a_part_of_it():
    recording, found = read(late=1)
    assert left_out(recording, found) == [-1, 0] * SLIPS
    assert found.slipping.lag_high == pytest.approx(np.full(len(found), 0.5 * STEP))


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


def test_a_tip_that_creeps_before_it_slips_is_left_out_for_five_samples_at_most():
    # It is off by 4 standard deviations, which no sample shows to be none of its contact.
    creep = 4.0 * 0.01 / np.linalg.norm(SLOPES / ALL.noise)
    recording, found = read(creep=creep)
    assert left_out(recording, found) == [-5, -4, -3, -2, -1] * SLIPS
    # What is lacking of the step: nearly all of it in these five samples.
    lacking = 5.0 * (1.0 - creep / (STICK * STEP)) * STEP
    assert found.slipping.lag_high == pytest.approx(np.full(len(found), lacking))
    # So it is where a slip is told to take no time.
    recording, found = read(Told(slip=0.0), creep=creep)
    assert left_out(recording, found) == [-5, -4, -3, -2, -1] * SLIPS


def test_readings_have_settled_where_they_are_as_near_to_the_contact_as_usual():
    lag, noise = 4.0, 0.01
    recording, found = read(noise=noise, lag=lag)
    # The rest of a jump in standard deviations. In the mean of five slips the squares of three
    # channels are 3·(1 + 5·√(2/15)) at most.
    rest = STICK * STEP * np.linalg.norm(SLOPES / ALL.noise) / noise
    last = lag * np.log(rest / np.sqrt(15.0 * np.sqrt(2.0 / 15.0)))
    rows = left_out(recording, found)
    assert min(rows) == -1 and max(rows) == pytest.approx(last, abs=1.5)
    assert len(rows) == SLIPS * (max(rows) + 2)


def test_readings_lag_by_the_way_of_the_clamp_in_the_time():
    """Averaged over nine samples; the clamp moves twice as fast in the second half."""
    clamp, place = places()
    faster = np.arange(len(clamp)) > 150
    moved = clamp + STEP * np.where(faster, np.arange(len(clamp)) - 150, 0)
    recording = recording_of(moved, Straight()(clamp - place))
    shifted = replace(recording, readings=recording.readings)
    found = settled(Straight(), shifted, ALL, Told(delay=2.0), Units())
    speed = np.where(np.arange(len(clamp)) < 150, 1.0, 2.0)
    speed[150] = 1.5
    expected = [2.0 * STEP * speed[row - 4 : row + 5].mean() for row in range(140, 160)]
    assert found.slipping.lag_low[140:160] == pytest.approx(expected)
    assert found.slipping.lag_high.tolist() == found.slipping.lag_low.tolist()
