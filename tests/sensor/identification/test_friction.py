"""Pieces of the way from a recording to friction: noise, samples left out, effects, causes."""

from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

from steel import NOISE, measured, recording_of
from straight import ALL, SLOPES, Straight, periods_of, sampled, seen_of
from vibrissa.errors import MixedColumnsError, RecordingError, WrongRodError
from vibrissa.sensor import Units, path, simulate, surfaces
from vibrissa.sensor.identification import friction
from vibrissa.sensor.identification.adjusting.adjustment import Tolerance
from vibrissa.sensor.identification.alternatives import Alternative
from vibrissa.sensor.identification.calibration import known_setup
from vibrissa.sensor.identification.friction import (
    _check_states,
    _effects,
    _left_out,
    _tested,
    checked_noise,
    find_periods,
)
from vibrissa.sensor.identification.misfit.doubts import Doubt
from vibrissa.sensor.identification.misfit.goodness import Cause, Goodness, likeliest
from vibrissa.sensor.identification.misfit.mixups import _candidates, check_columns
from vibrissa.sensor.identification.periods import Channels, located
from vibrissa.sensor.identification.recording import MIRROR
from vibrissa.sensor.identification.result import Identification
from vibrissa.sensor.identification.sides import Part
from vibrissa.sensor.response.branch import respond
from vibrissa.sensor.transducer import CHANNELS

NAN = np.nan
ONES = np.ones(3)

# --- What can be read ---


def test_a_recording_without_a_channel_of_the_method_has_no_usable_row():
    readings = np.column_stack([np.full((9, 2), NAN), np.arange(9.0)])
    recording = replace(recording_of(np.arange(9.0), readings), notes=("force_x is lost",))
    with pytest.raises(RecordingError) as raised:
        find_periods(known_setup(Straight()), recording, ONES, method="forces")
    said = "too little to identify friction from: 0 usable rows; force_x is lost"
    assert str(raised.value) == said


@pytest.mark.parametrize(
    ("noise", "used", "said"),
    [
        ([0.0, 1.0, 1.0], [0, 1, 2], "force_x"),
        ([1.0, NAN, 1e-50], [0, 1, 2], "force_y, moment_z"),
        ([1.0, np.inf, 1.0], [0, 1], "force_y"),
        ([1.0, 1e-49, NAN], [0, 1], None),
    ],
)
def test_a_channel_that_is_used_needs_a_noise(noise, used, said):
    noise = np.array(noise)
    if said is None:
        assert checked_noise(noise, used) is noise
        return
    with pytest.raises(RecordingError) as raised:
        checked_noise(noise, used)
    assert str(raised.value) == (
        f"the noise of column {said} is 0, or cannot be estimated from the readings: look whether "
        "the channel was recorded, and give the noise"
    )


def part(states, off=(), lone=(), setup=None, side=1, swung=False):
    """A part of these lines."""
    samples = sampled(np.arange(99.0), np.zeros(99))
    rows = [np.array(one, dtype=int) - 2 for one in (states, off, lone)]
    kept, others, spikes = (samples.take(one) for one in rows)
    return Part(side=side, setup=setup, samples=kept, off=others, lone=spikes, swung=swung)


def test_samples_that_are_left_out_and_where_the_rod_has_swung_are_noted():
    first, second = part([2, 3, 4], [5], [6, 7]), part([9, 10], [8, 11], swung=True)
    assert _left_out([first]) == (
        "the reading is no state of this rod in 1 rows, left out: line 5",
        "a lone spike in 2 rows, left out: line 6, 7",
    )
    assert _left_out([first, second]) == (
        "the reading is no state of this rod in 3 rows, left out: line 5, 8, 11",
        "a lone spike in 2 rows, left out: line 6, 7",
        "the rod has swung aside: line 9",
    )
    # One of which no sample is left has not swung; each swing is named.
    assert _left_out([part([2, 3, 4]), part([])]) == ()
    assert _left_out([part([2, 3]), part([4]), part([6])])[-1].endswith("aside: line 4, 6")
    with pytest.raises(RecordingError, match="2 usable rows"):
        _left_out([part([2]), part([3])])


def test_samples_that_were_left_out_are_taken_back_in_their_order():
    whole = part([2, 5, 6], [4], [3]).with_all()
    assert whole.samples.line.tolist() == [2, 3, 4, 5, 6]


def refused(states, off, alternatives=()):
    """What is said of parts of which some samples are no states, and a zero of force_x is off."""
    setup = known_setup(Straight())
    size, error = len(states) + len(off), np.array([0.5, 0.0, 0.0])
    clamp = np.linspace(0.0, 0.4, size)
    recording = recording_of(clamp, Straight()(clamp) + error)
    first = part(states, off, setup=setup)
    whole = sampled(clamp, clamp)
    whole = replace(whole, readings=recording.readings)
    first = replace(
        first,
        samples=whole.take(np.array(states) - 2),
        off=whole.take(np.array(off, dtype=int) - 2),
        lone=whole.take(slice(0, 0)),
    )
    # Of the mirror image, in which it has another sign, nothing is asked.
    other = replace(part([]), side=-1, setup=SimpleNamespace())
    _check_states([first, other], recording, ALL, ALL.noise, lambda: alternatives, Units())


def zero(channel, size=1e-3):
    error = np.eye(3)[channel]
    return Alternative(
        name=f"zero_{['force_x', 'force_y', 'moment_z'][channel]}",
        step=size,
        corrected=lambda samples, by: samples.without(by * error),
    )


def test_a_fifth_of_the_samples_may_be_no_states():
    refused([2, 3, 4, 5, 6, 7, 8, 9], [10, 11])
    with pytest.raises(WrongRodError) as raised:
        refused([2, 3, 4, 5, 6, 7, 8], [10, 9, 11])
    assert str(raised.value) == (
        "3 of 10 samples are no state of this rod, first in line 10: check rod, height, units, "
        "zero and noise"
    )


def test_the_likeliest_causes_of_a_wrong_rod_are_named():
    with pytest.raises(WrongRodError) as raised:
        refused([2, 3, 4, 5, 6, 7, 8], [10, 9, 11], [zero(1), zero(0)])
    said = str(raised.value).partition(" Likely: ")[2]
    assert said.startswith("zero_force_x larger by 0.5 ± ") and "or" not in said.split(" ")[1:]


def test_causes_that_explain_nine_tenths_of_the_misfit_are_named(monkeypatch):
    parts = {"theta": 0.95, "eta": 0.91, "zero_force_y": 0.89}
    causes = [
        Cause(name=name, size=0.1, deviation=0.01, explained=part) for name, part in parts.items()
    ]
    monkeypatch.setattr(friction, "likeliest", lambda *of: causes)
    with pytest.raises(WrongRodError, match=r"Likely: theta larger .*, or eta larger [^,]*$"):
        refused([2, 3, 4, 5, 6, 7, 8], [10, 9, 11])


# --- Effects ---


def test_effects_are_differences_by_the_step_from_what_they_count_from():
    """Friction is the sum of what is asked for, and its lower bound twice that."""
    values = {"a": [1.0, 2.0, 5.0], "b": [3.0, NAN, 3.5], "base": [2.0, 2.0, 2.0]}

    def nearby(other):
        key = other.branch or ("base" if other.name == "none" else other.name)
        return SimpleNamespace(mean=np.array(values[key]), least=2.0 * np.array(values[key]))

    def friction(seen, none, centre):
        return (seen,)

    reader = SimpleNamespace(as_if=lambda other: SimpleNamespace(friction=friction))
    seen = SimpleNamespace(periods=range(3), nearby=nearby)
    displaced = [
        Alternative(name="x", step=0.5, branch="a", base="base"),
        Alternative(name="y", step=-0.1, branch="b", base="base"),
    ]
    effects, of_least = _effects(seen, reader, displaced)
    # Where it is not known it is as large as elsewhere.
    expected = np.array([[-2.0, -10.0], [0.0, 15.0], [6.0, -15.0]])
    assert effects == pytest.approx(expected)
    assert of_least == pytest.approx(2.0 * expected)
    nothing = _effects(seen, reader, [])
    assert [one.shape for one in nothing] == [(3, 0), (3, 0)]


# --- Whether it fits, and what may be other ---


@pytest.mark.parametrize(("off", "kept"), [([0], 3), ([0, 2], 4), ([0, 1, 2], 4)])
def test_periods_that_do_not_fit_are_left_out_unless_half_of_them_do_not(off, kept):
    x0 = np.tile([0.0, 0.1, 0.2], 4)
    samples = sampled(x0 + np.repeat(np.arange(4.0), 3), x0)
    for period in off:
        samples.readings[3 * period + 1, 2] += 20.0
    seen = seen_of(samples, [0, 3, 6, 9], Channels(used=[0], noise=ALL.noise[:1]))
    found = _tested(seen, ALL.noise)
    assert len(found.periods) == kept and found.channels.used == [0, 1, 2]


def test_a_cause_is_fitted_to_the_residuals_and_explains_a_part_of_what_is_too_much():
    x0 = np.linspace(0.0, 0.4, 9)
    samples = sampled(x0, x0)
    # Across the slopes, so that no contact makes up for it.
    error = np.cross(SLOPES / ALL.noise, [0.0, 0.0, 1.0]) * ALL.noise
    samples = replace(samples, readings=samples.readings + 0.3 * error)
    seen = seen_of(samples, [0])

    def along(direction, name):
        return Alternative(
            name=name, step=0.5, corrected=lambda samples, by: samples.without(by * direction)
        )

    goodness = Goodness.of([seen], 2, noise_is_given=True, penalty=1.5)
    square = (error / ALL.noise) @ (error / ALL.noise)
    assert goodness.chi2 == pytest.approx(9.0 * 0.3**2 * square + 1.5)
    assert goodness.degrees == 27 - 1 - 2 and goodness.noise_degrees == np.inf
    assert Goodness.of([seen, seen], 0, noise_is_given=False).degrees == 52
    assert Goodness.of([seen], 0, noise_is_given=False).noise_degrees == pytest.approx(27 * 18 / 35)
    nothing = along(0.0 * error, "nothing")
    found = likeliest(seen, [along(-SLOPES, "shift"), along(2.0 * error, "a"), nothing], goodness)
    (cause, *others) = [one for one in found if one.name != "shift"]
    # It is told by the readings as if there were nothing else.
    assert cause.name == "a" and others == [] and found[0] is cause
    assert cause.size == pytest.approx(0.15)
    assert cause.deviation == pytest.approx(1.0 / np.sqrt(9.0 * 4.0 * square))
    part = 9.0 * 0.3**2 * square / (goodness.chi2 - 24)
    assert cause.explained == pytest.approx(part)


@pytest.mark.parametrize("used", [[0], [2], [0, 1]])
def test_mix_ups_are_of_the_channels_that_are_there(used):
    found = dict(_candidates(Channels(used=used, noise=np.ones(len(used)))))
    signs, units = "with the other sign", "in a unit 1000 times"
    expected = {
        (0,): [f"force_x {signs}", f"force_x {units} larger", f"force_x {units} smaller"],
        (2,): [f"moment_z {signs}", f"moment_z {units} larger", f"moment_z {units} smaller"],
        (0, 1): [
            f"force_y {signs}",
            f"force_x {signs}",
            f"force_x and force_y {signs}",
            "force_x and force_y swapped",
            f"force_x and force_y swapped, force_y {signs}",
            f"force_x and force_y swapped, force_x {signs}",
            f"force_x and force_y swapped, force_x and force_y {signs}",
            f"force_x and force_y {units} larger",
            f"force_x and force_y {units} smaller",
            f"force_x {units} larger",
            f"force_x {units} smaller",
            f"force_y {units} larger",
            f"force_y {units} smaller",
        ],
    }
    assert list(found) == expected[tuple(used)]
    for name, mixed in found.items():
        factor = {"larger": 1e3, "smaller": 1e-3}.get(name.split()[-1])
        if factor:
            sizes = [factor if channel in name else 1.0 for channel in CHANNELS]
            assert mixed.tolist() == np.diag(sizes).tolist()


# --- What is told ---


def identified(**more):
    shifts, effects = [[0.3, 0.4], [0.0, 0.0]], np.array([[1.0, 2.0], [0.0, -1.0]])
    periods = periods_of([0.3, 0.4], [0.1, 0.2], 0.2, shifts, effects)
    return Identification(**{"periods": periods, "setup": None, "units": Units()} | more)


def told(**more):
    known = {"name": "eta", "tolerance": 0.1, "adjusted": 0.5, "deviation": 0.05}
    return Tolerance(**{"of": more.get("name", "eta")} | known | more)


def test_errors_of_periods_go_together_by_what_they_share():
    own = np.diag([0.05, 0.08])
    shared = np.array([[0.25, 0.0], [0.0, 0.0]])
    assert identified().of_periods == pytest.approx(own + shared)
    # With a rod that is exactly known each has its own error.
    setup = known_setup(Straight())
    assert identified(setup=setup).of_periods == pytest.approx(own + shared)
    covariance = np.array([[4.0, 1.0], [1.0, 9.0]])
    found = identified(setup=setup, tolerances=(told(), told()), covariance=covariance)
    # (1, 2) and (0, −1) with the covariance in between.
    expected = np.array([[4.0 + 36.0 + 4.0, -1.0 - 18.0], [-19.0, 9.0]])
    assert found.of_periods == pytest.approx(own + expected)
    assert found.correlation == pytest.approx(np.array([[1.0, 1.0 / 6.0], [1.0 / 6.0, 1.0]]))
    # Without a rod the shifts tell it, whatever tolerances there are.
    alone = identified(tolerances=(told(), told()), covariance=covariance)
    assert alone.of_periods == pytest.approx(own + shared)


def test_three_causes_are_named_that_explain_a_tenth_of_the_misfit():
    parts = {"theta": 0.9, "eta": 0.5, "modulus": 0.1, "curvature": 0.1, "clamp_angle": 0.09}
    causes = tuple(
        Cause(name=name, size=0.1, deviation=0.01, explained=part) for name, part in parts.items()
    )
    found = identified()
    summary = replace(found, periods=replace(found.periods, causes=causes)).summary()
    assert [one.split()[0] for one in summary.causes] == ["theta", "eta", "modulus"]
    assert summary.causes[0] == "theta larger by 0.1 ± 0.01 (explains 90% of the misfit)"
    few = replace(found, periods=replace(found.periods, causes=causes[2:]))
    assert [one.split()[0] for one in few.summary().causes] == ["modulus", "curvature"]


def test_what_is_far_is_to_be_measured_or_estimated():
    assert identified().summary().far == ()
    (one,) = identified(far=(told(),)).summary().far
    assert one.endswith("standard deviations): measure it again, or --estimate eta")
    zero = told(name="zero_force_x")
    asked, others = identified(far=(zero, told(), told(name="theta"))).summary().far
    assert asked.startswith("zero_force_x larger by") and asked.endswith("or --estimate offset")
    assert others == "Others that may stand for it: eta, theta."


FINE = replace(ALL, noise=0.01 * ALL.noise)
FORWARD = np.linspace(0.05, 0.45, 60)
MIX_UPS = dict(_candidates(ALL))


def checked(readings, channels=FINE):
    recording = recording_of(FORWARD[: len(readings)], readings)
    return check_columns(known_setup(Straight()), recording, channels)


@pytest.mark.parametrize("said", MIX_UPS)
def test_each_mix_up_is_named_that_brings_the_readings_to_the_rod(said):
    readings = Straight()(FORWARD)
    checked(readings)
    with pytest.raises(MixedColumnsError) as raised:
        checked(readings @ np.linalg.inv(MIX_UPS[said]).T)
    text = str(raised.value)
    assert text.startswith(f"the columns seem to be mixed up: {said}. The readings would be ")
    assert text.endswith("a minus before a title turns the sign: 'moment_z=-Mz'")


def slipping(samples):
    """A clamp in 200 steps, and displacements that slip back to the first after so many samples."""
    rows = np.arange(201)
    return 0.005 * rows, 0.1 + 0.005 * (rows % samples)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("rests", [1, 3])
def test_a_clamp_position_with_the_other_sign_is_refused(way, rests):
    clamp, x0 = (np.repeat(each, rests) for each in slipping(10))
    turned = Straight()(0.1 + way * (x0 - 0.1))
    # Sticking and slipping while the clamp moves forward, or back.
    check_columns(known_setup(Straight()), recording_of(way * clamp, turned), FINE)
    with pytest.raises(MixedColumnsError, match="column footpoint has the other sign"):
        check_columns(known_setup(Straight()), recording_of(-way * clamp, turned), FINE)


@pytest.mark.parametrize(
    ("samples", "count", "refused"),
    # The mean step against the motion is 1 − 2/n, and must be 1/4 + 3/√N of N steps.
    [(4, 201, True), (4, 121, False), (6, 65, True), (6, 49, False), (3, 201, False)],
)
def test_few_samples_in_a_period_or_at_all_do_not_tell_the_sign_of_the_clamp(
    samples, count, refused
):
    clamp, x0 = slipping(samples)
    recording = recording_of(-clamp[:count], Straight()(x0[:count]))
    said = "bends against the motion"
    with pytest.raises(MixedColumnsError, match=said) if refused else nullcontext():
        check_columns(known_setup(Straight()), recording, FINE)


def test_steps_from_or_to_a_reading_of_no_state_do_not_hide_the_sign_of_the_clamp():
    clamp, x0 = slipping(10)
    readings = Straight()(x0)
    # No contact makes up for an error across the slopes; along them, the rod seems to jump.
    readings[::3] += 5.0 * np.cross(SLOPES, [0.0, 1.0, 0.0]) + 0.1 * SLOPES
    check_columns(known_setup(Straight()), recording_of(clamp, readings), FINE)
    with pytest.raises(MixedColumnsError, match="bends against the motion"):
        check_columns(known_setup(Straight()), recording_of(-clamp, readings), FINE)


@pytest.mark.parametrize(
    ("factor", "said"),
    [
        (0.1, "the rod bends by 10 times the way of the clamp from sample to sample"),
        (0.19, "in a larger unit"),
        (0.21, None),
        (4.9, None),
        (5.1, "in a smaller unit"),
        (1e3, "the clamp moves by 1000 times what the rod bends"),
    ],
)
def test_a_clamp_position_in_another_unit_is_refused(factor, said):
    clamp, x0 = slipping(10)
    recording = recording_of(factor * clamp, Straight()(x0))
    with nullcontext() if said is None else pytest.raises(MixedColumnsError, match=said):
        check_columns(known_setup(Straight()), recording, FINE)


@pytest.mark.parametrize("factor", [0.01, 100.0])
def test_noise_or_slips_in_every_step_are_no_other_unit(factor):
    # The clamp moves by much less than the noise of x0, or by much more than to the next slip.
    random = np.random.default_rng(3)
    clamp, _ = slipping(10)
    x0 = 0.2 + random.uniform(-0.02, 0.02, len(clamp))
    recording = recording_of(factor * clamp, Straight()(x0))
    check_columns(known_setup(Straight()), recording, FINE)


@pytest.mark.parametrize(("samples", "refused"), [(20, False), (21, True)])
def test_few_samples_tell_no_unit(samples, refused):
    clamp = 0.005 * np.arange(samples)
    recording = recording_of(10.0 * clamp, Straight()(0.1 + clamp))
    with pytest.raises(MixedColumnsError, match="smaller unit") if refused else nullcontext():
        check_columns(known_setup(Straight()), recording, FINE)


def test_a_clamp_that_rests_or_readings_of_no_state_tell_no_sign():
    clamp, x0 = slipping(10)
    readings = Straight()(x0)
    check_columns(known_setup(Straight()), recording_of(np.zeros(201), readings), FINE)
    off = readings + 5.0 * np.cross(SLOPES, [0.0, 1.0, 0.0])
    check_columns(known_setup(Straight()), recording_of(-clamp, off), FINE)


@pytest.mark.parametrize(("nearer", "refused"), [(14.9, False), (15.1, True)])
def test_readings_of_mixed_columns_come_fifteen_times_as_near(nearer, refused):
    turned, state = np.diag([1.0, 1.0, -1.0]), Straight()(np.full(60, 0.3))
    # No contact makes up for an error across the slopes.
    across = np.cross(SLOPES / FINE.noise, [0.0, 1.0, 0.0]) * FINE.noise

    def far(readings):
        recording = recording_of(FORWARD, readings)
        return np.sqrt(located(Straight(), recording, FINE, np.zeros(3)).misfit[0])

    def excess(error):
        readings = state + error * across
        return far(readings @ turned) / far(readings) - nearer

    readings = (state + brentq(excess, 1e-3, 1.0) * across) @ turned
    with pytest.raises(MixedColumnsError) if refused else nullcontext():
        checked(readings)


def test_a_tip_that_begins_behind_the_clamp_is_not_taken_for_one_whose_rod_swings():
    readings = Straight()(FORWARD)
    # Later than the first twenty samples the rod may have swung aside.
    swung = np.where((np.arange(60) >= 25)[:, None], readings * MIRROR, readings)
    checked(swung)
    with pytest.raises(MixedColumnsError, match="force_x and moment_z with the other sign"):
        checked(readings * MIRROR)
    # A rod that is quite another one is not near, however its columns are mixed.
    checked(np.tile([900.0, 800.0, 3.0], (60, 1)))


def test_periods_are_counted_by_what_is_known_of_them():
    found = periods_of([0.3, 0.3, 0.4], 0.1, 0.1)
    assert repr(found) == "3 periods: 3 slip" and repr(found.take([0])) == "1 period: 1 slip"
    found.status[:] = ["lock", "slip", "lock"]
    assert repr(found) == "3 periods: 2 lock, 1 slip"


# --- The whole ---


@pytest.fixture(scope="module")
def scanned():
    """A rod, a scan with twelve slips, and its readings."""
    rod = respond(2.0, 0.85)
    truth = simulate(rod, surfaces.random(1, 0.3, 0.02, 0.05), path("0.0005", ["0.05"]), "kinetic")
    return known_setup(rod), recording_of(truth.clamp, measured(truth.reactions, 1))


def test_what_was_fitted_and_adjusted_counts_in_the_fit_of_the_whole(scanned):
    setup, recording = scanned
    plain = find_periods(setup, recording, NOISE)
    fitted = find_periods(replace(setup, fitted=2, penalty=3.0), recording, NOISE)
    size = 3 * len(recording)
    assert plain.goodness.degrees == size - len(plain) and plain.goodness.noise_degrees == np.inf
    assert fitted.goodness.degrees == size - len(plain) - 2
    assert fitted.goodness.chi2 == pytest.approx(plain.goodness.chi2 + 3.0)
    estimated = find_periods(setup, recording).goodness
    assert estimated.noise_degrees == pytest.approx(18.0 / 35.0 * size) and not estimated.noisier
    assert plain.goodness.fits and plain.causes == () and plain.notes == ()
    assert plain.kinetic is None and plain.effects.shape == (len(plain), 0)


def test_noise_that_is_told_too_small_makes_all_periods_doubtful(scanned):
    setup, recording = scanned
    found = find_periods(setup, recording, 0.6 * NOISE)
    assert not found.goodness.fits
    assert list(found.goodness.noisier) == ["force_x", "force_y", "moment_z"]
    assert [one for one in found.goodness.noisier.values()] == pytest.approx([1.667] * 3, rel=0.2)
    assert all(Doubt.WHOLE.why in one for one in found.doubt)
    assert found.causes[0].explained == max(one.explained for one in found.causes)
    assert "stage_angle" not in {one.name for one in found.causes}
    asked = find_periods(setup, recording, 0.6 * NOISE, alternatives=lambda: [zero(0)])
    assert [one.name for one in asked.causes] == ["zero_force_x"]


def test_what_is_doubted_beforehand_is_said_of_every_period(scanned):
    setup, recording = scanned
    told = []
    doubtful = [(Doubt.FAR, "eta"), (Doubt.NOT_ADJUSTED, "")]
    noted = replace(recording, notes=("before",))
    found = find_periods(setup, noted, NOISE, doubtful=doubtful, progress=told.append)
    said = f"eta {Doubt.FAR.why}; {Doubt.NOT_ADJUSTED.why}"
    assert found.doubt.tolist() == [said] * len(found)
    assert found.grade.tolist() == ["doubtful"] * len(found)
    assert found.notes[0] == "before" and len(found.notes) == 3
    assert told == [len(recording)]


def test_all_periods_are_tested_with_what_is_not_known_of_the_setup(scanned):
    """A zero of force_x moves the ratio by 1/fy, and shifts it as far as it may be off."""
    setup, recording = scanned
    size = 0.01
    unknown = replace(setup, displaced=(zero(0),), shared=np.array([[size**2]]))
    found = find_periods(unknown, recording, NOISE)
    plain = find_periods(setup, recording, NOISE)
    known = found.status == "slip"
    fy = recording.readings[found.last, 1]
    assert found.effects[known, 0] == pytest.approx(1.0 / -fy[known], rel=0.2)
    assert found.common == pytest.approx(size * np.abs(found.effects[:, 0]))
    assert found.shifts == pytest.approx(size * found.effects)
    whole = np.hypot(plain.deviation, found.common)[known]
    assert found.deviation[known] == pytest.approx(whole, rel=0.02)
    # Without a covariance its deviation is 1.
    alone = find_periods(replace(unknown, shared=None), recording, NOISE)
    assert alone.common == pytest.approx(np.abs(found.effects[:, 0]))
    # A bound is as much less certain.
    assert found.status[-1] == "open" and found.low[-1] < plain.low[-1] - 1e-3
