"""Recordings of a rod that swings aside, whose loads grow evenly: parts in closed form."""

from dataclasses import replace

import numpy as np
import pytest

from steel import recording_of
from straight import ALL, Straight, sampled
from vibrissa.sensor.identification.calibration import known_setup
from vibrissa.sensor.identification.recording import MIRROR
from vibrissa.sensor.identification.sides import Part, parts_of


class Swinging(Straight):
    """It leaves its plane at x0 = 0.8, and then trails: the tip is as far behind as it was ahead.

    The clamp is in its mirror image where the tip is by twice 0.8 behind.
    """

    swings = True

    def mirrored(self):
        return self


SETUP = known_setup(Swinging())
FINE = replace(ALL, noise=0.1 * ALL.noise)
STEP = 0.01


def readings_of(clamp, place, swings):
    """Readings of a tip at a place, of which the rows from `swings` on trail."""
    x0 = clamp - place
    ahead, behind = Swinging()(x0), Swinging()(1.6 - x0) * MIRROR
    return np.where((np.arange(len(clamp)) >= swings)[:, None], behind, ahead)


def scan(to=1.2, place=0.0, swings=81, before=0):
    """Forward by hundredths; `before` samples with another tip come first."""
    clamp = place + STEP * np.arange(-before, round(to / STEP) + 1)
    first = Swinging()(clamp[:before] - place + 0.2)
    rest = readings_of(clamp[before:], place, swings)
    return recording_of(clamp, np.concatenate([first, rest]))


def read(recording, setup=SETUP):
    return parts_of(setup, recording, FINE)


@pytest.mark.parametrize("place", [0.0, 0.37, -2.0])
@pytest.mark.parametrize("before", [0, 5])
def test_a_rod_that_has_locked_swings_aside_where_the_clamp_has_passed_under_it(place, before):
    ahead, behind = read(scan(place=place, before=before))
    assert (ahead.side, behind.side) == (1, -1) and (ahead.swung, behind.swung) == (False, True)
    assert ahead.samples.row.tolist() == list(range(before + 81))
    assert behind.samples.row.tolist() == list(range(before + 81, before + 121))
    assert behind.samples.clamp == pytest.approx(-place - STEP * np.arange(81, 121))
    # In the mirror image the tip is pulled back from 1.6 less what it was.
    assert behind.samples.x0 == pytest.approx(1.6 - STEP * np.arange(81, 121))
    assert behind.samples.place == pytest.approx(np.full(40, -1.6 - place))
    for one in (ahead, behind):
        assert not len(one.off) and not len(one.lone)
    periods, start = ahead.cut(FINE)
    assert len(periods) == (2 if before else 1) and start[-1] == pytest.approx(place)
    periods, start = behind.cut(FINE)
    assert len(periods) == 1 and start == pytest.approx([-1.6 - place])


@pytest.mark.parametrize(("rows", "swings"), [(3, False), (4, True)])
def test_four_samples_show_that_a_rod_has_swung_aside(rows, swings):
    recording = scan().take(slice(81 + rows))
    parts = read(recording)
    assert len(parts) == (2 if swings else 1)
    # Otherwise they are no states of it.
    assert len(parts[0].off) == (0 if swings else rows)


def test_a_rod_that_has_not_locked_or_does_not_swing_has_one_part():
    # It slips before x0 = 0.5, where the samples are those of another contact.
    for stop in (30, 49):
        clamp = STEP * np.arange(121)
        x0 = np.where(np.arange(121) <= stop, clamp, clamp - 1.0)
        (whole,) = read(recording_of(clamp, Swinging()(x0)))
        assert not whole.swung and whole.side == 1
    (whole,) = parts_of(known_setup(Straight()), scan(), FINE)
    assert len(whole.off) == 40
    (whole,) = read(scan(to=0.8))
    assert len(whole.samples) == 81


@pytest.mark.parametrize("late", [2, 6])
def test_samples_between_belong_to_neither(late):
    recording = scan()
    # While it swings the readings are none of either side.
    recording.readings[81 : 81 + late] = 7.0
    ahead, behind = read(recording)
    assert ahead.samples.row.tolist() == list(range(81))
    assert ahead.off.row.tolist() == list(range(81, 81 + late))
    assert behind.samples.row[0] == 81 + late and not len(behind.off)


def test_a_rod_swings_back_where_the_stage_turns():
    forward = scan()
    # Trailing tips that are pulled along slip; pushed back they stick, and swing at the other side.
    place = -1.6 - 0.0
    clamp = forward.clamp[-1] - STEP * np.arange(1, 141)
    x0 = -clamp - place  # in the mirror image
    behind, ahead = Swinging()(x0) * MIRROR, Swinging()(1.6 - x0)
    back = np.where((x0 > 0.8)[:, None], ahead, behind)
    # By rounding the last state before the swing is at 0.8.
    whole = recording_of(
        np.concatenate([forward.clamp, clamp]), np.concatenate([forward.readings, back])
    )
    parts = read(whole)
    assert [one.side for one in parts] == [1, -1, 1]
    swing = 121 + int(np.argmax(x0 > 0.8))
    assert parts[2].samples.row[0] == swing and parts[2].swung
    assert parts[1].samples.row[-1] == swing - 1
    # It is where it was.
    assert parts[2].samples.place == pytest.approx(np.zeros(len(parts[2].samples)), abs=1e-9)
    assert parts[2].samples.clamp == pytest.approx(whole.clamp[swing:])


def test_an_offset_is_that_of_the_transducer_on_both_sides():
    offset = np.array([0.3, -0.2, 0.5])
    recording = scan()
    moved = replace(recording, readings=recording.readings + offset)
    expected = read(recording)
    found = read(moved, replace(SETUP, offset=offset))
    for one, other in zip(found, expected, strict=True):
        assert one.samples.row.tolist() == other.samples.row.tolist()
        assert one.samples.x0 == pytest.approx(other.samples.x0)
    assert found[1].setup.offset == pytest.approx(offset * MIRROR)


def test_what_is_no_state_and_a_lone_spike_are_left_out():
    samples = sampled(np.arange(7.0), np.zeros(7))
    samples.x0[2] = -1.0
    samples = type(samples)(**vars(samples) | {"misfit": np.array([0, 0, 0, 0, 36, 36.1, 0.0])})
    found = Part.of(1, SETUP, samples)
    still = sampled(np.zeros(7), np.array([0, 0, 1.0, 0, 0, 0, 0]))
    spiked = Part.of(1, SETUP, still)
    assert found.off.row.tolist() == [5] and 4 in found.samples.row
    assert spiked.lone.row.tolist() == [2] and spiked.samples.row.tolist() == [0, 1, 3, 4, 5, 6]
    assert not found.swung and Part.of(-1, SETUP, still.take(slice(1, None))).swung
    kept = spiked.only(np.array([True, False, True, False, True, False]))
    assert kept.samples.row.tolist() == [0, 3, 5]


def test_what_was_before_a_period_is_not_what_its_tip_does_later():
    # A tip that was pulled farther ahead, where that of the period after would trail.
    clamp = np.concatenate([1.2 - STEP * np.arange(6), STEP * np.arange(61)])
    x0 = np.concatenate([-0.4 - STEP * np.arange(6), STEP * np.arange(61)])
    (whole,) = parts_of(SETUP, recording_of(clamp, Swinging()(x0)), ALL)
    assert len(whole.samples) == 67 and not whole.swung
