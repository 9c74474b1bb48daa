"""Samples, periods and doubts of a rod whose loads grow evenly: all in closed form."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import chdtri

from steel import recording_of
from straight import ALL, SLOPES, Straight, sampled, seen_of
from vibrissa.sensor.identification import periods
from vibrissa.sensor.identification.alternatives import Alternative
from vibrissa.sensor.identification.misfit.doubts import Doubt, doubts, misfits
from vibrissa.sensor.identification.periods import (
    Channels,
    Contacts,
    Partition,
    cut,
    fitted,
    joined_past_lock,
    located,
    lone_spikes,
)
from vibrissa.sensor.identification.reading.uncertainty import HALF_WIDTH
from vibrissa.sensor.identification.recording import Slipping

NAN = np.nan
# Change of the readings with x0, in standard deviations: −20, 2.5 and 10.
TILT = SLOPES / ALL.noise

# --- Where the samples are ---


@pytest.mark.parametrize("used", [[0, 1, 2], [0, 1], [2]])
def test_samples_are_located_at_the_nearest_state(used):
    channels = Channels(used=used, noise=ALL.noise[used])
    tilt = TILT[used]
    x0 = np.array([-0.3, 0.0, 0.1, 0.4, 0.7])
    # An error of the readings in the direction of the slope moves the state, one across it stays.
    across = np.linalg.svd(tilt[None])[2][-1] if len(used) > 1 else np.zeros(1)
    readings = Straight()(x0)
    readings[:, used] += ALL.noise[used] * (3.0 * across + 0.01 * tilt)
    offset = np.array([0.3, -0.2, 0.1])
    clamp = np.arange(5.0)
    found = located(Straight(), recording_of(clamp, readings + offset), channels, offset)
    assert found.x0 == pytest.approx(x0 + 0.01)
    assert found.deviation == pytest.approx(np.full(5, 1.0 / np.linalg.norm(tilt)))
    assert found.misfit == pytest.approx(np.full(5, 9.0 * (across @ across)), abs=1e-12)
    assert found.place == pytest.approx(clamp - x0 - 0.01)
    assert found.row.tolist() == [0, 1, 2, 3, 4] and found.line.tolist() == [2, 3, 4, 5, 6]


def test_a_state_past_the_lock_is_taken_where_none_before_it_fits():
    class Folded(Straight):
        """Past the lock at 1/2 fx goes the same way back, and m a little."""

        def __call__(self, x0):
            x0 = np.asarray(x0)
            folded = np.where(x0 > 0.5, 1.0 - x0, x0)
            return np.stack([-2.0 * folded, 0.0 * x0, 0.1 * x0], axis=-1)

        def slope(self, x0):
            turned = np.where(np.asarray(x0) > 0.5, -1.0, 1.0)
            return np.stack([-2.0 * turned, 0.0 * turned, 0.1 + 0.0 * turned], axis=-1)

    x0 = np.array([0.3, 0.7])
    recording = recording_of(np.zeros(2), Folded()(x0))
    # By m the two are 0.04 apart: 4 standard deviations of it, or 8. From 6 on it is no state.
    for noise, place in ((0.01, 0.3), (0.005, 0.7)):
        channels = Channels(used=[0, 2], noise=np.array([1e-4, noise]))
        found = located(Folded(), recording, channels, np.zeros(3))
        assert found.x0 == pytest.approx([0.3, place], abs=1e-4)


def test_states_end_where_the_rod_snaps_or_slips_back():
    x0 = np.array([-0.6, -0.499, 0.799, 0.9])
    found = located(Straight(), recording_of(np.zeros(4), Straight()(x0)), ALL, np.zeros(3))
    assert found.x0 == pytest.approx([-0.5, -0.499, 0.799, 0.8])


def test_the_moment_alone_tells_the_states_up_to_where_it_turns_back():
    class Turning(Straight):
        """Its moment grows up to x0 = 0.4, before the lock, and then falls."""

        def __call__(self, x0):
            moment = 0.4 - np.abs(np.asarray(x0) - 0.4)
            return np.stack([0.0 * moment, 0.0 * moment, moment], axis=-1)

        def slope(self, x0):
            one = np.where(np.asarray(x0) > 0.4, -1.0, 1.0)
            return np.stack([0.0 * one, 0.0 * one, one], axis=-1)

    x0 = np.linspace(0.1, 0.75, 14)
    recording = recording_of(np.zeros(14), Turning()(x0))
    channels = Channels(used=[2], noise=np.array([0.01]))
    found = located(Turning(), recording, channels, np.zeros(3))
    assert found.x0 == pytest.approx(0.4 - np.abs(x0 - 0.4), abs=1e-3)


def test_samples_are_located_in_blocks_and_progress_is_told(monkeypatch):
    told, x0 = [], np.array([0.1, 0.2, 0.3, -0.1, 0.4])
    recording = recording_of(np.zeros(5), Straight()(x0))
    located(Straight(), recording, ALL, np.zeros(3), told.append)
    assert told == [5]
    monkeypatch.setattr(periods, "BLOCK", 2)
    found = located(Straight(), recording, ALL, np.zeros(3), told.append)
    assert told == [5, 2, 4, 5] and found.x0 == pytest.approx(x0)


@pytest.mark.parametrize(("misfit", "usual"), [(36.0, True), (36.1, False)])
def test_a_sample_is_usual_up_to_a_misfit_or_nine_times_that_of_most(misfit, usual):
    samples = sampled(np.zeros(5), np.zeros(5), misfit=np.array([0.0, 0.1, 4.0, 5.0, misfit]))
    assert samples.usual.tolist() == [True, True, True, True, usual]
    larger = sampled(np.zeros(5), np.zeros(5), misfit=np.array([1.0, 1.0, 5.0, 45.0, 45.1]))
    assert larger.usual.tolist() == [True, True, True, True, False]


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize(("jump", "slips"), [(5.9, False), (6.1, True)])
def test_a_slip_is_a_jump_of_six_deviations(jump, slips, way):
    deviation = np.array([0.3, 0.3, 0.4, 0.1])
    # √(0.3² + 0.4²) is 0.5.
    samples = sampled(np.array([0.0, 0.0, 0.5, 0.5]) * way * jump, np.zeros(4), deviation=deviation)
    assert cut(samples).begins.tolist() == ([0, 2] if slips else [0])


def test_a_lone_spike_jumps_away_and_back():
    one = [0.0, 0.0, 1.0, 0.0, 0.0]
    for place in (one, [-v for v in one]):
        found = lone_spikes(sampled(place, np.zeros(5)))
        assert found.tolist() == [False, False, True, False, False]
    # Two in a row, a slip, and ends of a recording are none.
    for place in ([0, 1, 1, 0, 0], [0, 0, 1, 1, 1], [1, 0, 0, 0, 1], [0, 0, 1, 2, 2]):
        assert not lone_spikes(sampled(place, np.zeros(5))).any()
    # It jumps by 6·√2 deviations away and back, and not once and by less.
    for place in ([0.0, 0.09, 0.04], [0.0, 0.05, -0.04]):
        assert not lone_spikes(sampled(place, np.zeros(3))).any()
    assert lone_spikes(sampled([0.0, 1.0, 0.0], np.zeros(3))).tolist() == [False, True, False]


def test_the_contact_of_a_period_is_the_weighted_mean_of_its_samples():
    clamp = np.array([0.0, 0.1, 0.2, 1.0, 1.1])
    samples = sampled(clamp, clamp - np.array([0.0, 0.0, 0.0, 0.9, 0.9]))
    rng = np.random.default_rng(1)
    samples = replace(samples, readings=samples.readings + 0.01 * rng.standard_normal((5, 3)))
    periods = Partition(begins=np.array([0, 3]), size=5)
    found = fitted(Straight(), samples, ALL, periods, np.array([0.05, 0.85]))
    errors = (samples.readings - Straight()(samples.x0)) / ALL.noise
    each = samples.place - errors @ TILT / (TILT @ TILT)
    assert found.place == pytest.approx([each[:3].mean(), each[3:].mean()])
    expected = 1.0 / np.sqrt(np.array([3.0, 2.0]) * (TILT @ TILT))
    assert found.deviation == pytest.approx(expected)


@pytest.mark.parametrize(
    ("before", "x0", "off", "joined"),
    [
        (0.51, 0.6, 0.0, True),
        (0.5, 0.6, 0.0, False),  # the lock was not passed
        (0.6, 0.8, 0.0, False),  # not where states end, and before they begin
        (0.6, -0.5, 0.0, False),
        (0.6, 0.79, 0.0, True),
        (0.6, -0.49, 0.0, True),
        # √(36 − 1) deviations of two channels, beside one of the third.
        (0.6, 0.7, 5.9, True),
        (0.6, 0.7, 5.93, False),
        (0.6, 0.7, -5.9, True),
        (0.6, 0.7, -5.93, False),
    ],
)
def test_a_period_goes_on_past_the_lock_where_it_fits_the_contact_before(before, x0, off, joined):
    deviation = 0.03
    samples = sampled([before, x0], [before, x0])
    blur = np.hypot(ALL.noise, SLOPES * deviation)
    samples.readings[1] += blur * [off, 1.0, 0.0]
    periods = Partition(begins=np.array([0, 1]), size=2)
    contacts = Contacts(place=np.array([0.0, 0.3]), deviation=np.array([deviation, 9.0]))
    found = joined_past_lock(Straight(), samples, ALL, periods, contacts)
    assert found.tolist() == [False, joined]


def test_several_periods_go_on_with_one_contact_and_the_next_does_not():
    # Two samples each.
    x0 = np.repeat([0.6, 0.65, 0.7, 0.1, 0.2], 2)
    start = np.repeat([0.6, 0.65, 0.7, 5.1, 5.2], 2)
    periods = Partition(begins=2 * np.arange(5), size=10)
    contacts = Contacts(place=np.array([0.0, 1.0, 2.0, 5.0, 5.0]), deviation=np.full(5, 0.01))
    found = joined_past_lock(Straight(), sampled(start, x0), ALL, periods, contacts)
    # The last fits the contact of the one before; but that has not passed its lock.
    assert found.tolist() == [False, True, True, False, False]


# --- What the friction is read from ---


def test_the_last_state_is_that_of_the_contact_and_the_way_to_the_next_sample():
    samples = sampled([0.0, 0.1, 0.4, 0.3, 0.3], [0.0, 0.1, 0.2, 0.1, 0.1])
    seen = seen_of(samples, [0, 2, 3])
    last = seen.last
    assert last.clamp.tolist() == [0.1, 0.4, 0.3]
    assert last.clamp_gap == pytest.approx([0.3, -0.1, 0.0])
    assert last.gap == pytest.approx([0.3, -0.1, 0.0])
    assert last.travel == pytest.approx([0.1, 0.2, 0.1])
    # Where the recording ends the sign is that of the displacement.
    assert last.sign.tolist() == [1.0, -1.0, 1.0]
    back = seen_of(sampled([0.0, -0.2], [0.0, -0.2]), [0]).last
    assert back.sign.tolist() == [-1.0] and back.gap.tolist() == [0.0]
    assert not last.base.any() and not last.lag_low.any() and not last.lag_high.any()
    assert last.deviation.tolist() == [0.01] * 3


def test_the_way_is_that_to_the_first_sample_that_shows_the_slip():
    slipping = Slipping(
        way=np.array([NAN, 0.25, NAN, NAN]),
        lag_low=np.array([1.0, 2.0, 3.0, 4.0]),
        lag_high=np.array([5.0, 6.0, 7.0, 8.0]),
    )
    samples = sampled([0.0, 0.1, 0.6, 0.7], [0.0, 0.1, 0.1, 0.2], slipping=slipping)
    samples = replace(samples, excess=np.array([0.1, 0.2, 0.3, 0.4]))
    last = seen_of(samples, [0, 2]).last
    assert last.clamp_gap == pytest.approx([0.25, 0.0]) and last.gap == pytest.approx([0.25, 0.0])
    assert last.lag_low.tolist() == [2.0, 4.0] and last.lag_high.tolist() == [6.0, 8.0]
    assert last.base.tolist() == [0.2, 0.4]


@pytest.mark.parametrize(("size", "locked"), [(0.51, False), (0.53, True)])
def test_a_tip_has_locked_where_all_of_its_interval_is_past_the_lock(size, locked):
    # The interval is ± 1.96 · 0.01 about a displacement of a sample anywhere in the period.
    samples = sampled([0.0, size, 0.4, 1.0, 1.1], [0.0, size, 0.4, 0.0, 0.1])
    seen = seen_of(samples, [0, 3])
    assert seen.locked.tolist() == [locked, False]
    # What is surely reached needs a friction of twice as much.
    reached = np.array([size, 0.1]) - HALF_WIDTH * 0.01
    assert seen.least == pytest.approx(2.0 * reached)


def test_some_of_the_periods_are_seen_as_among_all():
    clamp = np.arange(9.0)
    samples = sampled(clamp, [0.0, 0.1, 0.0, 0.1, 0.2, 0.0, 0.1, 0.2, 0.3])
    seen = seen_of(samples, [0, 2, 5])
    some = seen.only(np.array([True, False, True]))
    assert some.periods.begins.tolist() == [0, 2] and some.periods.counts.tolist() == [2, 4]
    assert some.samples.clamp.tolist() == [0.0, 1.0, 5.0, 6.0, 7.0, 8.0]
    assert some.contacts.place.tolist() == seen.contacts.place[[0, 2]].tolist()
    assert seen.without_noise().contacts.deviation.tolist() == [0.0] * 3
    assert seen.without_noise().channels.noise.tolist() == [0.0] * 3


def test_periods_are_seen_by_other_channels_at_the_contacts_that_fit_these():
    samples = sampled([0.0, 0.1, 1.0], [0.0, 0.1, 0.1])
    samples.readings[:, 2] += 0.02 * SLOPES[2]
    seen = seen_of(samples, [0, 2])
    other = seen.by(Channels(used=[2], noise=ALL.noise[2:]))
    assert other.contacts.place == pytest.approx([-0.02, 0.88])
    assert other.contacts.deviation == pytest.approx(np.array([0.5**0.5, 1.0]) / TILT[2])
    assert other.residuals == pytest.approx(np.zeros((3, 1)))
    assert seen.residuals == pytest.approx(np.tile([0.0, 0.0, 0.02 * TILT[2]], (3, 1)))


def zero(size, step=0.25):
    """An alternative with zeros that are larger by `size` per step of one."""
    size = np.asarray(size)
    return Alternative(
        name="zero", step=step, corrected=lambda samples, by: samples.without(by * size)
    )


def test_what_an_error_does_to_the_readings_is_told_but_for_a_shift_of_the_contact():
    clamp = np.array([0.0, 0.1, 0.2, 1.0, 1.1])
    seen = seen_of(sampled(clamp, [0.0, 0.1, 0.2, 0.0, 0.1]), [0, 3])
    size = np.array([1.0, 2.0, 0.0])
    unit = TILT / np.linalg.norm(TILT)
    whole = size / ALL.noise
    found = seen.effect_of(zero(size))
    # What a shift makes up for is along the slopes; the same in all samples of a period.
    assert found == pytest.approx(np.tile(whole - (whole @ unit) * unit, (5, 1)))
    # An error that differs from sample to sample shifts the contact in the mean.
    drift = Alternative(
        name="drift",
        step=0.5,
        corrected=lambda samples, by: samples.without(by * samples.clamp[:, None] * SLOPES),
    )
    along = clamp - np.repeat([0.1, 1.05], [3, 2])
    assert seen.effect_of(drift) == pytest.approx(np.outer(along, TILT))
    # The contact of readings without noise, one Gauss-Newton step on, follows the error.
    near = seen.nearby(zero(SLOPES, 0.02))
    assert near.contacts.place == pytest.approx(seen.contacts.place + 0.02)
    assert near.samples.readings == pytest.approx(seen.samples.readings - 0.02 * SLOPES)


def test_another_rod_is_seen_with_the_same_displacements_in_the_mean():
    class Shifted(Straight):
        """Its place is by a half of the clamp's position less a third."""

        def above(self, clamp):
            return self, 1.5 * np.asarray(clamp) - 1.0 / 3.0

    seen = seen_of(sampled([0.0, 0.1, 0.2, 1.0], [0.0, 0.1, 0.2, 0.1]), [0, 3])
    other = seen.as_if(Alternative(name="rod", step=1.0, branch=Shifted()))
    assert other.periods.sums(other.x0) == pytest.approx(seen.periods.sums(seen.x0))
    assert other.x0 == pytest.approx([-0.05, 0.1, 0.25, 0.1])
    assert isinstance(other.branch, Shifted) and other.contacts.deviation.tolist() == [0.01] * 2


# --- Doubts ---


@pytest.mark.parametrize("size", [1, 2, 4])
@pytest.mark.parametrize(("part", "doubted"), [(0.999, False), (1.001, True)])
@pytest.mark.filterwarnings("error")
def test_a_channel_does_not_fit_where_its_misfit_has_a_chance_of_one_in_a_billion(
    size, part, doubted
):
    """Its errors are those of readings, and one of the contact that all samples share."""
    noise = np.array([0.1, 0.0, 0.4])
    displaced = 0.01 * np.arange(5.0 + size)
    samples = sampled(displaced, displaced)
    miss = np.random.default_rng(2).standard_normal(size)
    covariance = np.eye(size) + (0.1 * TILT[2]) ** 2 * np.ones((size, size))
    miss *= np.sqrt(chdtri(size, 1e-9) / (miss @ np.linalg.solve(covariance, miss)))
    samples.readings[3 : 3 + size, 2] += part * 0.4 * miss
    samples.readings[:, 1] += 100.0  # has no noise, so that nothing is known of it
    seen = seen_of(samples, [0, 3, 3 + size], deviation=0.1)
    found = np.array(misfits(seen, noise))
    assert found.tolist() == [[False] * 3, [False] * 3, [False, doubted, False]]
    # What was not recorded does not count.
    samples.readings[3 : 3 + size, 2] = NAN
    assert not np.array(misfits(seen, noise)).any()


STEP = 1.0 / 64.0


def slipping(x0, after, gap=STEP, turned=False, way=1.0, deviation=1e-4):
    """What is doubted of six samples that stick up to x0, and six that stick from `after` on."""
    steps = STEP * np.arange(6)
    clamp = np.concatenate([steps, steps[-1] + gap + (-steps if turned else steps)])
    displaced = np.concatenate([x0 + steps - steps[-1], after + (-steps if turned else steps)])
    seen = seen_of(sampled(way * clamp, way * displaced, deviation=deviation), [0, 6])
    found = doubts(seen, ALL.noise, [0, 1])
    assert [one.doubt for one in found[:3]] == [Doubt.READ_MISFIT] * 2 + [Doubt.OTHER_MISFIT]
    assert [one.channel for one in found[:4]] == ["force_x", "force_y", "moment_z", ""]
    return {one.doubt: one.periods.tolist() for one in found[3:] if one.periods.any()}


WRONG = {Doubt.WRONG_WAY: [True, False]}


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize(
    ("x0", "after", "gap", "wrong"),
    [
        (0.25, 0.125, STEP, False),
        (0.25, 0.25 + STEP, STEP, True),  # the tip has not moved
        (0.25, 0.25 + 2 * STEP, STEP, True),
        (-STEP, -3 * STEP, STEP, True),  # it was not loaded
        (0.125, -0.0625, STEP, False),
        (0.125, -0.25, STEP, True),  # it has gained energy
    ],
)
def test_a_slip_follows_the_clamp_from_a_loaded_state_and_releases_energy(
    way, x0, after, gap, wrong
):
    assert slipping(x0, after, gap, way=way) == (WRONG if wrong else {})


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_contact_that_stays_or_goes_back_is_no_slip_however_uncertain_it_is(way):
    for less, wrong in ((0.0, True), (-0.001, True), (0.001, False)):
        found = slipping(0.25, 0.25 + STEP - less, way=way, deviation=0.01)
        assert found == (WRONG if wrong else {})
    # Where the clamp rests while the tip slips, the load tells the way.
    assert slipping(0.25, 0.125, gap=0.0, way=way) == {}
    assert slipping(0.25, 0.375, gap=0.0, way=way) == WRONG


@pytest.mark.parametrize("wrong", [0, 1, 2])
def test_each_slip_is_judged_by_itself(wrong):
    rows = np.arange(20)
    x0 = 0.25 + STEP * (rows % 5)
    clamp = STEP * rows
    for slip in range(3):
        # The tip is taken back with the clamp, or follows it.
        x0[5 * slip + 5 :] += 0.01 + (10.0 * STEP if slip == wrong else 0.0)
    seen = seen_of(sampled(clamp, x0, deviation=1e-4), [0, 5, 10, 15])
    found = {one.doubt: one.periods.tolist() for one in doubts(seen, ALL.noise, [0])}
    assert found[Doubt.WRONG_WAY] == [slip == wrong for slip in range(4)]


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize(("part", "wrong"), [(0.99, True), (1.01, False)])
def test_a_slip_is_unloaded_or_gains_energy_by_six_deviations(way, part, wrong):
    # Loaded by 3/64 where the clamp is after the slip, or by 6 deviations.
    loaded = slipping(2.0 * STEP, 0.0, way=way, deviation=part * 3.0 * STEP / 6.0)
    assert loaded == ({} if wrong else WRONG)
    # x0² grows from 0.2² to 0.21²; its error is that of 2·x0·deviation of both.
    error = 2.0 * np.hypot(0.2, 0.21)
    deviation = part * (0.21**2 - 0.2**2) / (6.0 * error)
    assert slipping(0.2, 0.21, way=way, deviation=deviation) == (WRONG if wrong else {})


@pytest.mark.parametrize(("gap", "long"), [(1.5 * STEP, False), (1.6 * STEP, True)])
@pytest.mark.parametrize(("part", "certain"), [(0.99, True), (1.01, False)])
def test_over_a_longer_step_a_slip_must_be_certain(gap, long, part, certain):
    deviation = part * (0.2**2 - 0.19**2) / (6.0 * 2.0 * np.hypot(0.2, 0.19))
    found = slipping(0.2, 0.19, gap, deviation=deviation)
    assert found == (WRONG if long and not certain else {})


def test_samples_are_missing_from_ten_usual_steps_on():
    lost = {Doubt.GAP_BEFORE: [False, True], Doubt.GAP_AFTER: [True, False]}
    assert slipping(0.3, 0.1, 10.0 * STEP) == {}
    assert slipping(0.3, 0.1, 10.1 * STEP) == lost
    assert slipping(0.3, 0.1, 10.1 * STEP, way=-1.0) == lost


@pytest.mark.parametrize(
    ("after", "unclear"),
    [
        (0.2, False),  # after one slip, or several
        (0.2999, True),  # as before the gap: the clamp may have jumped
        (0.3 + STEP, True),  # the clamp may have jumped in its next step
        # Six deviations are 0.00085.
        (0.3 + 1.5 * STEP + 0.0008, True),
        (0.3 + 1.5 * STEP + 0.0009, False),  # a slip or several, and bent again
        (0.3 + 10.2 * STEP, True),  # no slip goes back
    ],
)
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_where_samples_are_missing_that_alone_is_told(after, unclear, way):
    kind = Doubt.GAP_UNCLEAR if unclear else Doubt.GAP_AFTER
    found = slipping(0.3, after, 10.1 * STEP, way=way)
    assert found == {Doubt.GAP_BEFORE: [False, True], kind: [True, False]}
    # The errors of both samples count.
    for deviation in ([1e-4, 1e-3], [1e-3, 1e-4]):
        found = slipping(0.3, 0.305 + 1.5 * STEP, 10.1 * STEP, deviation=np.repeat(deviation, 6))
        assert Doubt.GAP_UNCLEAR in found
    # Over no more than ten steps a slip takes the tip away, or none goes that way.
    wrong = WRONG if after > 0.2 else {}
    assert slipping(0.3, after, 10.0 * STEP, way=way) == wrong


def test_a_clamp_that_turns_beside_a_slip_is_told():
    assert slipping(0.3, 0.1, turned=True) == {Doubt.TURN: [True, False]}
    # So it is where the recording ends with the second sample after it, or the first was one.
    clamp = STEP * np.array([0, 1, 2, 3, 4, 5, 6, 5])
    for order in (slice(None), slice(None, None, -1)):
        begin = 6 if order == slice(None) else 2
        seen = seen_of(sampled(clamp[order], np.zeros(8)), [0, begin])
        (turn,) = (one for one in doubts(seen, ALL.noise, [0]) if one.doubt is Doubt.TURN)
        assert turn.periods.tolist() == [True, False]


@pytest.mark.parametrize("counts", [[4, 3, 4], [3, 4, 4], [4, 4, 3], [4, 4, 4]])
def test_four_samples_confirm_each_other(counts):
    begins = np.cumsum(counts) - counts
    x0 = np.concatenate([0.25 + STEP * np.arange(count) for count in counts])
    place = np.repeat([0.0, 0.25, 0.5], counts)
    seen = seen_of(sampled(place + x0, x0), begins)
    found = {one.doubt: one.periods.tolist() for one in doubts(seen, ALL.noise, [2])}
    few = [count < 4 for count in counts]
    assert found[Doubt.FEW] == few and found[Doubt.FEW_AFTER] == [*few[1:], False]


def test_samples_at_the_same_step_do_not_make_it_shorter():
    clamp = np.repeat(STEP * np.arange(12.0), 3)
    x0 = np.where(np.arange(36) < 18, 0.25 + clamp, clamp)
    found = doubts(seen_of(sampled(clamp, x0, deviation=1e-4), [0, 18]), ALL.noise, [0])
    assert not any(one.periods.any() for one in found)


def test_a_clamp_that_rests_has_no_usual_step():
    seen = seen_of(sampled(np.zeros(8), np.zeros(8)), [0, 4])
    found = {one.doubt: one.periods.any() for one in doubts(seen, ALL.noise, [2])}
    assert not found[Doubt.GAP_AFTER] and not found[Doubt.TURN]
