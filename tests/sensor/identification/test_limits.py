"""Where a rule ends and another begins: each just before its limit, and just past it."""

from types import SimpleNamespace

import numpy as np
import pytest

from vibrissa.errors import RecordingError
from vibrissa.sensor.given.tolerances import TOLERABLE
from vibrissa.sensor.identification.adjusting.adjustment import Adjusted, Tolerance
from vibrissa.sensor.identification.adjusting.priors import Asked, _matters
from vibrissa.sensor.identification.misfit.beside import Beside
from vibrissa.sensor.identification.misfit.doubts import Doubt, Doubted, graded, in_words, notes_of
from vibrissa.sensor.identification.misfit.goodness import Cause, Goodness, noisier
from vibrissa.sensor.identification.misfit.law import Apart, remaining_part
from vibrissa.sensor.identification.periods import Channels, Partition
from vibrissa.sensor.identification.preparing.ends import moving, touching
from vibrissa.sensor.identification.preparing.hum import _Blocks, hum_of
from vibrissa.sensor.identification.reading.jumps import direction, spans_of, spikes
from vibrissa.sensor.identification.reading.uncertainty import (
    HALF_WIDTH,
    common_deviation,
    least_friction,
    ratio_deviation,
    step_deviation,
    summary_of,
)
from vibrissa.sensor.identification.recording import (
    Method,
    Recording,
    check_size,
    left_out,
    noise_of,
)
from vibrissa.sensor.identification.summary import FrictionSummary, Source
from vibrissa.sensor.quantities import Units
from vibrissa.sensor.simulation.slips import SlipLaw

# --- Ends of a recording ---


@pytest.mark.parametrize(("rest", "begin"), [(9, 0), (10, 0), (11, 10), (30, 29)])
def test_ten_samples_are_the_shortest_rest(rest, begin):
    clamp = np.concatenate([np.zeros(rest), np.arange(1.0, 101.0)])
    assert moving(clamp) == slice(begin, len(clamp))
    assert moving(-clamp[::-1]) == slice(0, len(clamp) - begin)


@pytest.mark.parametrize(("speed", "rests"), [(0.15, True), (0.25, False)])
def test_a_clamp_that_creeps_rests(speed, rests):
    creep = speed * np.arange(30.0)
    clamp = np.concatenate([creep, creep[-1] + np.arange(1.0, 301.0)])
    assert (moving(clamp).start > 0) == rests


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("row", range(0, 23, 2))
def test_a_clamp_that_jitters_rests(row, way):
    # A window of ten samples moves from the row 22 on, as the clamp does from the row 29 on.
    clamp = way * np.maximum(np.arange(130.0) - 29.0, 0.0)
    clamp[row] += 0.5
    assert moving(clamp) == slice(29, 130)
    assert moving(clamp[::-1]) == slice(0, 101)


def test_a_short_recording_has_no_ends():
    rest = np.concatenate([np.zeros(15), np.arange(1.0, 6.0)])
    assert moving(rest) == slice(0, 20)
    assert moving(np.append(rest, [6.0])) == slice(14, 21)
    assert moving(np.zeros(50)) == slice(0, 50)


@pytest.mark.parametrize(("free", "begin"), [(9, 0), (10, 10)])
def test_ten_samples_are_the_shortest_lift_off(free, begin):
    loads = np.concatenate([np.zeros((free, 2)), np.ones((100, 2)), np.zeros((9, 2))])
    assert touching(loads) == slice(begin, len(loads))
    assert touching(loads[::-1]) == slice(0, len(loads) - begin)


@pytest.mark.parametrize(("load", "begin"), [(0.049, 20), (0.051, 0)])
def test_a_twentieth_of_the_usual_load_is_none(load, begin):
    loads = np.concatenate([np.full((20, 2), load), np.ones((100, 2))])
    assert touching(loads) == slice(begin, 120)
    loads[:20, 1] = 1.0
    assert touching(loads) == slice(0, 120)


def test_nothing_has_no_part_that_touches():
    assert touching(np.zeros((0, 3))) == slice(0, 0)
    assert touching(np.zeros((30, 3))) == slice(0, 30)


# --- Hum ---


def noisy(size, rate=1000.0, seed=1, frequency=50.0, wave=0.0):
    time = np.arange(size) / rate
    noise = np.random.default_rng(seed).standard_normal((size, 3))
    hum = np.cos(2.0 * np.pi * frequency * time[:, None] + np.arange(3))
    return noise + wave * hum, time, time.copy()


@pytest.mark.parametrize(("size", "seen"), [(399, False), (400, True)])
def test_ten_blocks_of_two_cycles_are_the_fewest_that_tell_a_hum(size, seen):
    assert (hum_of(*noisy(size, wave=5.0)) is not None) == seen


@pytest.mark.parametrize(
    ("frequency", "seen"), [(49.83, 49.83), (60.17, 60.17), (50.35, 50.25), (49.3, 0), (55.0, 0)]
)
def test_the_mains_is_within_a_fifth_of_a_hertz_and_a_step_of_what_is_tried(frequency, seen):
    hum = hum_of(*noisy(4000, wave=2.0, frequency=frequency))
    assert (0 if hum is None else hum.frequency) == pytest.approx(seen, abs=0.01)


def test_hum_is_told_of_those_channels_alone_that_have_it():
    readings, time, clamp = noisy(4000)
    readings[:, 1] += 2.0 * np.cos(2.0 * np.pi * 50.0 * time)
    hum = hum_of(readings, time, clamp)
    assert (hum.amplitude > 0.0).tolist() == [False, True, False]
    assert hum.amplitude[1] == pytest.approx(2.0, abs=0.1)
    assert not hum.signal[:, [0, 2]].any()
    readings[7, 2] = np.nan
    assert hum_of(readings, time, clamp).amplitude[1] == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("time", [np.zeros(1), np.append(np.nan, np.arange(399.0) / 1e3)])
def test_without_times_there_is_no_hum(time):
    readings, _, clamp = noisy(400, wave=5.0)
    assert hum_of(readings[: len(time)], time, clamp[: len(time)]) is None


def test_squares_that_waves_explain_are_those_of_an_f_test():
    readings, time, _ = noisy(800, wave=0.2)
    blocks = _Blocks.of(readings, 40)
    waves = np.stack([np.cos(100.0 * np.pi * time), np.sin(100.0 * np.pi * time)], axis=1)
    weights, explained = blocks.fitted(waves)
    # The same with a parabola for each block beside the waves. The first column is the clamp.
    part = np.kron(np.eye(20), np.vander(np.linspace(-1.0, 1.0, 40), 3))
    left = [np.linalg.lstsq(basis, readings)[1] for basis in (part, np.hstack([part, waves]))]
    whole = np.linalg.lstsq(np.hstack([part, waves]), readings)[0][-2:]
    assert len(blocks.quiet) == 20
    assert weights == pytest.approx(whole)
    assert explained == pytest.approx((left[0] - left[1]) / (left[1] / (800 - 60 - 2)))


# --- Slips by the tangential force ---


@pytest.mark.parametrize(("size", "lone"), [(7.9, False), (8.0, False), (8.1, True)])
def test_a_spike_is_eight_deviations_from_its_neighbours_which_agree(size, lone):
    force = np.zeros(9)
    force[4] = 0.5 * size
    assert spikes(force, 0.5).tolist() == [row == 4 and lone for row in range(9)]
    force[5:] = 0.3 * size
    assert not spikes(force, 0.5).any()
    # Half as far apart as the sample is off their mean, or more: they do not agree.
    assert spikes(np.array([0.0, 100.0, 39.0]), 1.0).tolist() == [False, True, False]
    assert not spikes(np.array([0.0, 100.0, 40.0]), 1.0).any()
    assert not spikes(np.array([0.0, 100.0]), 1.0).any()
    # A tip that slips at every other sample makes no spikes.
    assert not spikes(np.tile([0.0, 100.0], 5), 1.0).any()
    assert spikes(np.array([0, 0, 100, 0, 0, -100, 0.0]), 1.0).nonzero()[0].tolist() == [2, 5]


@pytest.mark.parametrize(("fall", "ends"), [(7.9, [20]), (8.0, [20]), (8.1, [9, 20])])
def test_a_slip_is_a_fall_of_eight_deviations(fall, ends):
    force = -np.arange(21.0)
    force[10:] += 1.0 + fall
    assert spans_of(np.arange(21.0), force, 1.0).ends.tolist() == ends
    assert spans_of(-np.arange(21.0), -force, 1.0).ends.tolist() == ends


def test_samples_within_a_slip_are_of_neither_period():
    load = np.concatenate([np.arange(10.0), [-3.0, -20.0, -23.0, -24.0], np.arange(-23.0, -13.0)])
    found = spans_of(np.arange(24.0), -load, 1.0)
    assert found.begins.tolist() == [0, 11] and found.ends.tolist() == [9, 23]


def sawtooth(gap, risen):
    """Clamp in steps of 1, but for one, and a force whose load rises by 2 a step, but for that."""
    steps = np.ones(39)
    steps[19] = gap
    load = 2.0 * steps
    load[19] = risen
    return np.append(0.0, np.cumsum(steps)), -np.append(0.0, np.cumsum(load))


@pytest.mark.parametrize(
    ("gap", "risen", "cut"),
    [
        # Half of what sticking makes, and eight deviations less.
        (10.0, 10.1, False),
        (10.0, 9.9, True),
        (10.0, -7.9, True),
        (5.0, 2.1, False),
        (5.0, 1.9, True),
        # A step that is hardly longer than the others hides nothing.
        (1.5, -7.0, False),
        (1.6, -7.0, True),
        (10.0, 20.0, False),
    ],
)
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_period_ends_where_a_slip_may_be_missing(gap, risen, cut, way):
    clamp, force = sawtooth(gap, risen)
    found = spans_of(way * clamp, way * force, 1.0)
    assert found.begins.tolist() == ([0, 20] if cut else [0])
    assert found.ends.tolist() == ([19, 39] if cut else [39])
    assert found.cut.tolist() == ([True, False] if cut else [False])


def test_missing_samples_with_a_slip_that_is_seen_cut_nothing():
    clamp, force = sawtooth(50.0, -20.0)
    found = spans_of(clamp, force, 1.0)
    assert found.ends.tolist() == [19, 39] and not found.cut.any()
    # Where the clamp rests it does not move by a usual step.
    clamp, force = (np.repeat(each, 3) for each in sawtooth(10.0, 0.0))
    assert spans_of(clamp, force, 1.0).cut.tolist() == [True, False]
    assert spans_of(np.zeros(5), -np.arange(5.0), 1.0).ends.tolist() == [4]


def test_a_clamp_that_rests_goes_on_as_before():
    clamp = np.array([0.0, 0.0, 1.0, 1.0, 2.0, 1.0, 1.0, 0.0])
    assert direction(clamp).tolist() == [1, 1, 1, 1, -1, -1, -1]
    assert direction(np.zeros(3)).tolist() == [1, 1]


# --- Uncertainty ---


def test_friction_is_at_least_what_a_tip_has_needed():
    states = SimpleNamespace(
        demand=lambda x: np.asarray(x), x0_lock=0.5, x0_end=0.8, x0_pull=-0.4, mu_lock=0.5
    )
    low = np.array([0.1, 0.4, 0.6, 0.7, -0.3, -0.3995, -0.41, 0.1])
    high = np.array([0.2, 0.45, 0.7, 0.81, -0.2, -0.3, -0.4, np.nan])
    # Past the lock of an oblique stage, as the lock may have come to the tip.
    expected = [0.2, 0.45, 0.7, np.nan, 0.3, 0.3995, np.nan, np.nan]
    found = least_friction(states, low, high)
    assert found == pytest.approx(np.array(expected), nan_ok=True, rel=1e-3)
    states.x0_pull = 0.0
    # Without pulling nothing is known of x0 < 0.
    assert least_friction(states, np.array([-0.3]), np.array([0.1])) == pytest.approx([0.1])


def test_errors_are_propagated_to_a_ratio_a_step_and_all_periods():
    assert ratio_deviation(-3.0, -2.0, 0.1, 0.0) == pytest.approx(0.05)
    assert ratio_deviation(-3.0, -2.0, 0.0, 0.1) == pytest.approx(0.075)
    assert ratio_deviation(3.0, -4.0, 0.4, 0.4) == pytest.approx(np.hypot(0.1, 0.075))
    assert step_deviation(np.array([-2.0, 3.0]), 0.1) == pytest.approx(
        np.array([0.2, 0.3]) / np.sqrt(12.0)
    )
    effects, shared = np.array([[1.0, 2.0], [1.0, -1.0]]), np.array([[4.0, 1.0], [1.0, 9.0]])
    assert common_deviation(effects, shared) == pytest.approx(np.sqrt([44.0, 11.0]))
    assert common_deviation(effects, -shared).tolist() == [0.0, 0.0]
    assert pytest.approx(1.959963985) == HALF_WIDTH


def test_impossible_values_do_not_count_in_a_summary():
    even = np.arange(1000.0)
    values = np.stack([even, np.where(even < 500.0, even, np.inf), np.full(1000, np.inf)])
    found = summary_of(values)
    assert found.mean == pytest.approx([499.5, 249.5, np.nan], nan_ok=True)
    assert found.deviation == pytest.approx(
        [1000.0 / np.sqrt(12.0), 500.0 / np.sqrt(12.0), np.nan], nan_ok=True, rel=1e-5
    )
    assert found.low == pytest.approx([24.5, 12.0, np.nan], nan_ok=True)
    assert found.high == pytest.approx([974.5, 487.0, np.nan], nan_ok=True)


def test_noise_is_that_of_second_differences_without_outliers():
    rng = np.random.default_rng(1)
    readings = rng.standard_normal((20_000, 3)) * [1.0, 2.0, 0.5] + np.arange(20_000)[:, None]
    assert noise_of(readings) == pytest.approx([1.0, 2.0, 0.5], rel=0.02)
    readings[::100] += 50.0
    assert noise_of(readings) == pytest.approx([1.0, 2.0, 0.5], rel=0.02)
    assert noise_of(np.array([[0.0, 1.0, np.nan]] * 3))[:2].tolist() == [0.0, 0.0]
    assert np.isnan(noise_of(np.zeros((2, 3)))).all()
    # One second difference, d = 3: √(d²/6).
    three = np.array([[0.0] * 3, [1.0] * 3, [5.0] * 3])
    assert noise_of(three) == pytest.approx([np.sqrt(1.5)] * 3)


def test_three_samples_are_the_fewest():
    check_size(3)
    with pytest.raises(RecordingError) as raised:
        check_size(2, ["row 4 is empty", "row 5, too"])
    assert str(raised.value) == (
        "too little to identify friction from: 2 usable rows; row 4 is empty; row 5, too"
    )


def test_five_lines_are_named_and_that_there_are_more():
    assert left_out(np.arange(2, 7), "why") == ("why in 5 rows, left out: line 2, 3, 4, 5, 6",)
    six = ("why in 6 rows, left out: line 2, 3, 4, 5, 6, ...",)
    assert left_out(np.arange(2, 8), "why") == six
    assert left_out(np.arange(0), "why") == ()


def test_channels_are_those_with_a_noise_and_all_readings():
    readings = np.ones((4, 3))
    recording = Recording(clamp=np.arange(4.0), readings=readings, line=np.arange(4))
    noise = np.array([0.5, 1e-51, np.inf])
    assert Channels.recorded(recording, noise).used == [0]
    assert Channels.recorded(recording, np.array([0.5, 1e-49, 2.0])).used == [0, 1, 2]
    readings[2, 0] = np.nan
    assert Channels.recorded(recording, np.ones(3)).used == [1, 2]
    weighted = Channels(used=[0, 2], noise=np.array([0.5, 2.0])).weighted(np.array([1.0, 7.0, 3.0]))
    assert weighted.tolist() == [2.0, 1.5]


def test_a_partition_has_ends_counts_sums_and_a_mirror_image():
    periods = Partition(begins=np.array([0, 2, 7]), size=8)
    assert periods.counts.tolist() == [2, 5, 1] and periods.ends.tolist() == [1, 6, 7]
    assert periods.sums(np.arange(8.0)).tolist() == [1.0, 20.0, 7.0]
    assert periods.spread(np.array([3, 1, 2])).tolist() == [3, 3, 1, 1, 1, 1, 1, 2]
    assert periods.spread(np.array([[3, 0], [1, 1], [2, 5]]))[[0, 2, 7]].tolist() == [
        [3, 0],
        [1, 1],
        [2, 5],
    ]
    assert periods.reversed().begins.tolist() == [0, 1, 6] and len(periods) == 3
    assert periods.take([0, 2]).counts.tolist() == [7, 1]


# --- What is said ---


@pytest.mark.parametrize(("ratio", "named"), [(1.24, False), (1.25, False), (1.26, True)])
def test_a_quarter_more_scatter_than_the_noise_is_another_noise(ratio, named):
    found = noisier(np.array([ratio, 1.0, 1.0]), np.array([1.0, 0.0, 1.0]))
    assert found == ({"force_x": ratio} if named else {})


def test_a_recording_fits_unless_its_misfit_has_a_chance_of_one_in_a_thousand():
    # χ² of 100 degrees: 149.4 has the probability 1/1000.
    fits = [Goodness(chi2=chi2, degrees=100, noise_degrees=np.inf) for chi2 in (149.3, 149.6)]
    assert [one.fits for one in fits] == [True, False]
    assert fits[0].ratio == 1.493
    # F of 100 and 51 degrees.
    estimated = [Goodness(chi2=chi2, degrees=100, noise_degrees=51.0) for chi2 in (218.0, 225.0)]
    assert [one.fits for one in estimated] == [True, False]
    nothing = Goodness(chi2=3.0, degrees=0, noise_degrees=np.inf)
    assert nothing.fits and nothing.chance == 1.0 and np.isnan(nothing.ratio)
    one = Goodness(chi2=1.0, degrees=1, noise_degrees=np.inf)
    assert one.ratio == 1.0 and one.chance == pytest.approx(0.317310508)


def test_a_cause_says_which_way_and_how_much():
    cause = Cause(name="modulus", size=-0.0123, deviation=0.001, explained=0.5)
    assert cause.spelled(Units()) == "modulus smaller by 1.23 ± 0.1 %"
    cause = Cause(name="theta", size=0.0123, deviation=0.001, explained=0.5)
    assert cause.spelled(Units()) == "theta larger by 0.0123 ± 0.001"


@pytest.mark.parametrize(
    ("size", "off", "early"),
    [
        (0.0, False, (0.0, 0.0)),
        (1.39, False, (0.0, 0.0)),
        (1.41, True, (0.0, 0.0)),
        (-1.39, False, (1.0, 1.0)),
        (-1.41, True, (1.0, 1.0)),
        (-0.21, False, (0.0, 1.0)),
        (-0.19, False, (0.0, 0.0)),
        (-0.79, False, (0.0, 1.0)),
        (-0.81, False, (1.0, 1.0)),
    ],
)
def test_travels_are_off_their_law_by_four_deviations_more_than_half_a_step(size, off, early):
    apart = Apart(size=size, deviation=0.1, half_step=1.0)
    assert apart.off_law == off and apart.early == early


def test_what_is_just_at_its_limit_is_within_it():
    assert not Apart(size=5.0, deviation=1.0, half_step=1.0).off_law
    assert Apart(size=2.5, deviation=1.0, half_step=1.0).early == (0.0, 0.0)
    assert Apart(size=0.0, deviation=np.inf, half_step=0.0).early == (0.0, 1.0)


def test_the_part_that_remains_is_that_of_the_usual_period():
    mu0 = np.array([0.5, np.nan, 0.4, 0.2])
    assert remaining_part(np.array([-0.4, 9.0, 0.2, 0.2]), mu0) == pytest.approx(0.8)


@pytest.mark.parametrize(
    ("difference", "agrees"), [(0.39, True), (-0.39, True), (-0.41, False), (0.5, True)]
)
def test_means_agree_within_four_deviations(difference, agrees):
    none = np.zeros(0)
    spread = 0.125 if difference == 0.5 else 0.1
    told = {"ratio": none, "deviation": none, "off": none > 0.0, "spread": spread}
    three = Beside(difference=difference, number=3, **told)
    assert three.agrees == agrees and three.compared
    assert not Beside(difference=difference, number=2, **told).compared
    assert three.size == f"by {difference:+.2g} ± 0.1"


def tolerance(score=0.0, left=0.5, name="theta", **more):
    return Tolerance(
        name=name, of=name, tolerance=0.1, adjusted=0.1 * score, deviation=0.1 * left, **more
    )


def test_a_surprise_is_in_deviations_of_what_the_recording_tells():
    assert tolerance(3.0, 0.6).surprise == pytest.approx(3.0 / 0.8)
    assert tolerance(-3.0, 0.6).surprise == pytest.approx(3.0 / 0.8)
    assert tolerance(-3.0, 0.6).score == pytest.approx(-3.0)
    assert tolerance(3.0, np.sqrt(0.9899)).surprise == pytest.approx(3.0 / np.sqrt(0.0101))
    assert tolerance(3.0, np.sqrt(0.9901)).surprise == 0.0
    said = "theta smaller by 0.3 than given (3.8 standard deviations)"
    assert tolerance(-3.0, 0.6).moved(Units()) == said
    assert tolerance(3.0, 0.6).moved(Units()) == said.replace("smaller", "larger")
    assert tolerance(-3.0, 0.6).spelled(Units()) == (
        "theta: given to ± 0.1, by the recording -0.3 ± 0.06 beside that"
    )


def adjusted(*tolerances, chance=1.0):
    size = len(tolerances)
    return Adjusted(
        setup=None,
        recording=None,
        whisker=None,
        mixing=np.array([[1.0, 0.5, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0]]),
        tolerances=tolerances,
        covariance=np.eye(size),
        chance=chance,
    )


def test_far_is_what_is_three_deviations_off_the_farthest_first():
    near, far, farther = tolerance(2.39, 0.6), tolerance(2.41, 0.6), tolerance(-5.0, 0.6)
    assert adjusted(near, far, farther).far == (farther, far)
    assert adjusted(near).far == ()
    # All together they may be unlikely, though none is by itself.
    least = tolerance(0.1, 0.6)
    assert adjusted(least, near, chance=0.9e-3).far == (near,)
    assert adjusted(least, near, chance=1e-3).far == ()
    exactly = Tolerance(name="a", of="a", tolerance=1.0, adjusted=3.0, deviation=0.0)
    assert exactly.surprise == 3.0 and adjusted(exactly).far == ()
    asked = tolerance(5.0, 0.6, estimated=True), tolerance(5.0, 0.6, wave=1)
    assert adjusted(*asked, chance=0.0).far == ()
    noise = adjusted(near).noise_of(np.array([1.0, 2.0, 3.0]))
    assert noise == pytest.approx([np.sqrt(2.0), 4.0, 3.0])


def test_a_tolerance_matters_where_its_channel_was_recorded():
    asked = Asked(method=Method.MOMENT, law=None, estimate=(), assume=True)
    for missing, channel in enumerate(("force_x", "force_y", "moment_z")):
        there = [number != missing for number in range(3)]
        lost = {name for name in TOLERABLE if not _matters(name, asked, there)}
        of_moment = {"moment_origin_x", "moment_origin_y"} if missing == 2 else set()
        own = {f"zero_{channel}", f"drift_{channel}"}
        assert lost == own | of_moment | {"kinetic_ratio"}


@pytest.mark.parametrize(
    ("law", "given", "matters"),
    [
        (SlipLaw.KINETIC, True, True),
        (SlipLaw.ENERGY, True, True),
        (SlipLaw.KINETIC, False, False),
        (SlipLaw.FREE, True, False),
        (None, True, False),
    ],
)
def test_the_kinetic_ratio_matters_where_a_law_needs_it(law, given, matters):
    asked = Asked(method=Method.SPACING, law=law, estimate=(), assume=True, ratio_given=given)
    assert _matters("kinetic_ratio", asked, [True] * 3) == matters


def test_doubts_are_graded_worded_and_noted():
    few = Doubted(doubt=Doubt.FEW, periods=np.array([False, True, False, False]))
    gap = Doubted(doubt=Doubt.GAP_BEFORE, periods=np.array([True, True, True, True]))
    law = Doubted(doubt=Doubt.LAW, channel="x", periods=np.array([True, False, False, True]))
    reasons = [few, gap, law]
    assert graded(reasons).tolist() == ["doubtful", "wrong", "information", "doubtful"]
    assert graded([gap]).tolist() == ["information"] * 4
    why = [Doubt.FEW.why, Doubt.GAP_BEFORE.why, f"x {Doubt.LAW.why}"]
    assert in_words(reasons).tolist() == [
        f"{why[1]}; {why[2]}",
        f"{why[0]}; {why[1]}",
        why[1],
        f"{why[1]}; {why[2]}",
    ]
    first, last = np.array([2, 5, 8, 11]), np.array([4, 7, 10, 13])
    assert notes_of(reasons, first, last) == (
        f"wrong: {why[0]}: 1 of 4 periods, line 5-7",
        f"information: {why[1]}: 4 of 4 periods, line 2-4, 5-7, 8-10, ...",
        f"doubtful: {why[2]}: 2 of 4 periods, line 2-4, 11-13",
    )
    assert few.followed_by([few]).periods.tolist() == [False, True, False, False] * 2


def summary(**more):
    known = {"mean": 0.3, "random": 0.003, "common": 0.004, "periods": 5, "used": 5}
    return FrictionSummary(**known | more)


def test_what_helps_most_is_to_be_measured_first():
    gains = {"a": 0.001, "b": 0.002, "c": 0.003, "d": 0.004, "e": 0.00476}
    (line,) = [one for one in str(summary(if_exact=gains)).splitlines() if "measure" in one]
    assert line == ("measure first: a (then ± 0.001), b (then ± 0.002), c (then ± 0.003)")
    assert "measure first: d" in str(summary(if_exact={"d": 0.00474}))
    assert "measure" not in str(summary(if_exact={"d": 0.00476}))


def test_parts_of_a_variance_are_named_from_half_a_per_cent_on():
    sources = {Source.READINGS: 0.9901, Source.STEP: 0.0051, Source.COMMON: 0.0049}
    (line,) = [
        one for one in str(summary(single=0.01, sources=sources)).splitlines() if "one" in one
    ]
    assert line == (
        "one period: ± 0.01; its variance is by the noise of the readings 99%, "
        "the step of the stage 1%"
    )


@pytest.mark.parametrize(
    ("doubtful", "wrong", "said"),
    [
        (0, 0, None),
        (1, 0, "1 of them is in doubt: see the columns grade and doubt"),
        (2, 0, "2 of them are in doubt: see the columns grade and doubt"),
        (2, 3, "do not rely on it: 3 of them are graded wrong, see the column doubt"),
    ],
)
def test_doubts_are_counted_and_what_is_wrong_comes_first(doubtful, wrong, said):
    lines = str(summary(doubtful=doubtful, wrong=wrong)).splitlines()
    assert [one for one in lines if "of them" in one] == ([] if said is None else [said])


@pytest.mark.parametrize(("chance", "varies"), [(0.9e-3, True), (1e-3, False)])
def test_a_surface_varies_where_chance_is_below_one_in_a_thousand(chance, varies):
    found = summary(chance=chance, degrees=1, chi2=11.0, variation=0.01)
    assert found.varies == varies
    assert ("mu0 varies from place to place by ± 0.01 (chi2" in str(found)) == varies
    assert "by more than its errors" not in str(summary(degrees=0))


def test_what_is_far_is_told_whether_the_recording_fits_or_not():
    far = ("eta larger", "Others that may stand for it: theta.")
    fits, off = (Goodness(chi2=chi2, degrees=100, noise_degrees=np.inf) for chi2 in (90.0, 300.0))
    said = str(summary(goodness=fits, far=far)).splitlines()[2:5]
    assert said[1:] == ["The recording fits only with eta larger", far[1]]
    assert "The recording fits what was given." in str(summary(goodness=fits))
    told = str(summary(goodness=off, far=far, causes=("a cause",))).splitlines()[3:7]
    assert told == [
        "The recording does not fit what was given. What may be other, each if it alone is:",
        "  a cause",
        "By the recording is eta larger",
        far[1],
    ]
    alone = str(summary(goodness=off))
    assert "does not fit what was given. No single thing that is other explains it." in alone
