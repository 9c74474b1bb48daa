"""Friction by the ratio of the forces, without a rod: against an elastica that shares no code."""

from contextlib import nullcontext
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import plain_elastica
from steel import recording_of
from vibrissa.cli.app import app
from vibrissa.errors import ArgumentError, MixedColumnsError, RecordingError
from vibrissa.sensor import PeriodStatus, Recording, identify, surfaces
from vibrissa.sensor.identification.adjusting.properties import Bench
from vibrissa.sensor.identification.friction import find_periods
from vibrissa.sensor.identification.reading.carried import Carried
from vibrissa.sensor.identification.reading.jumps import Spans, spans_of
from vibrissa.sensor.identification.reading.ratio import (
    WHOLE_DEGREE,
    Windows,
    fitted_forces,
    read_onsets,
)
from vibrissa.sensor.identification.reading.uncertainty import HALF_WIDTH
from vibrissa.sensor.identification.setup import Setup
from vibrissa.sensor.identification.without_rod import (
    _check_axes,
    _check_signs,
    _doubts,
    _statuses,
    _swung,
    read_ratio,
)
from vibrissa.sensor.response.branch import respond
from vibrissa.sensor.simulation.scanning import path, simulate

# 3 mN on a steel rod of 1 mm × 100 mm, steps of 20 µm.
NOISE = np.full(3, 0.003 / plain_elastica.FORCE)
STEP = 0.0002
RODS = {
    "as given": {},
    "tilted by two degrees": {"tilt": np.deg2rad(2.0)},
    "bent by nature": {"curvature": -0.08},
}


@cache
def rod(name, theta=2.0, eta=0.85):
    return plain_elastica.rod(theta, eta, 0.1, **RODS[name])


def recorded(seed, name="as given", step=STEP, to=0.3, ratio=0.8):
    random = np.random.default_rng(seed)
    phase = random.uniform(0.0, 2.0 * np.pi)

    def mu0(x):
        return 0.3 + 0.03 * np.sin(40.0 * x + phase)

    forces, friction, period = plain_elastica.slips(rod(name), mu0, np.arange(0.0, to, step), ratio)
    readings = np.full((len(forces), 3), np.nan)
    readings[:, :2] = forces + random.normal(size=forces.shape) * NOISE[:2]
    return recording_of(np.arange(0.0, to, step), readings), friction, period


def errors(found, friction):
    """Errors of μ0, and whether the intervals hold it, of the periods that ended."""
    ok, truth = found.status == PeriodStatus.SLIP, friction[found.last]
    inside = (found.low <= truth) & (truth <= found.high)
    return (found.mu0 - truth)[ok], found.deviation[ok], inside[ok]


@pytest.mark.parametrize("channel", [0, 1])
def test_a_lone_spike_is_seen_by_the_noise_of_its_own_channel(channel):
    recording, _, period = recorded(3, to=0.1)
    row = next(i for i in range(100, 400) if len(set(period[i - 5 : i + 5])) == 1)
    recording.readings[row, channel] += 40.0 * NOISE[channel]
    noise = NOISE.copy()
    noise[1 - channel] *= 5.0
    assert f"a lone spike in 1 rows, left out: line {row + 2}" in read_ratio(recording, noise).notes
    noise[channel] *= 100.0
    assert not any("spike" in note for note in read_ratio(recording, noise).notes)


@pytest.mark.parametrize("noise_of_y", [100.0, 0.01])
def test_slips_are_seen_by_the_noise_of_force_x(noise_of_y):
    recording, _, period = recorded(3, to=0.1)
    noise = NOISE * [1.0, noise_of_y, 1.0]
    found = read_ratio(recording, noise)
    assert len(found.status) == period.max() + 1
    assert found.last[:-1].tolist() == (np.flatnonzero(np.diff(period))).tolist()


@pytest.mark.slow
@pytest.mark.parametrize("name", RODS)
def test_it_reads_any_rod_without_bias(name):
    runs = [recorded(seed, name) for seed in range(20)]
    each = [errors(read_ratio(run, NOISE), friction) for run, friction, _ in runs]
    error, deviation, inside = (np.concatenate(parts) for parts in zip(*each, strict=True))
    assert len(error) > 500
    assert abs(error.mean()) < 2e-4
    assert error.std() == pytest.approx(np.sqrt((deviation**2).mean()), rel=0.1)
    assert 0.93 <= inside.mean() <= 0.98
    if name == "as given":
        # The rod, where it is known, tells more.
        setup = Setup(branch=respond(2.0, 0.85))
        model = [errors(find_periods(setup, run, NOISE), friction)[0] for run, friction, _ in runs]
        assert np.concatenate(model).std() < 0.7 * error.std()


@pytest.mark.slow
@pytest.mark.parametrize("step", [0.0002, 0.001, 0.002])
def test_intervals_are_honest_on_coarse_steps(step):
    each = []
    for seed in range(8):
        run, friction, period = recorded(seed, step=step, to=0.6)
        found = read_ratio(run, NOISE)
        assert (np.diff(period)[found.last[:-1]] == 1).all() and len(found) >= period[-1]
        each.append(errors(found, friction))
    error, deviation, inside = (np.concatenate(parts) for parts in zip(*each, strict=True))
    assert inside.mean() > 0.92
    assert abs(error.mean()) < 0.2 * deviation.mean()


def test_a_tip_that_is_pulled_back_has_the_same_friction():
    response = respond(2.0, 0.85)
    truth = simulate(response, surfaces.constant(0.3), path("0.0002", ["0.1", "-0.1"]), "kinetic")
    noise = np.random.default_rng(1).normal(size=truth.reactions.shape) * NOISE
    found = read_ratio(recording_of(truth.clamp, truth.reactions + noise), NOISE)
    error, deviation, inside = errors(found, truth.mu0)
    assert (np.diff(truth.clamp)[found.last[:-1]] < 0.0).sum() > 50
    assert inside.mean() > 0.9 and np.abs(error / deviation).max() < 4.5


def test_a_locked_tip_and_a_rod_that_swings_aside_give_bounds_alone():
    response = respond(2.0, 0.85)
    truth = simulate(response, surfaces.constant(0.8), path("0.0002", ["0.95"]), "free", 0.8)
    noise = np.random.default_rng(1).normal(size=truth.reactions.shape) * NOISE
    found = read_ratio(recording_of(truth.clamp, truth.reactions + noise), NOISE)
    assert found.status[0] == PeriodStatus.LOCK and "swung" in found.doubt[0]
    assert found.low[0] < response.mu_lock and np.isnan(found.mu0[0])
    error, deviation, _ = errors(found, truth.mu0)
    assert len(error) > 4 and np.abs(error / deviation).max() < 4.0


@pytest.mark.slow
def test_slips_of_several_samples_belong_to_no_period():
    run, _, _ = recorded(1)
    found = read_ratio(run, NOISE)
    clamp, readings, truth = [run.clamp[0]], [run.readings[0]], []
    for row in range(1, len(run)):
        if row - 1 in found.last[:-1]:
            truth.append(len(clamp) - 1)
            for part in (0.3, 0.7):
                readings.append((1 - part) * run.readings[row - 1] + part * run.readings[row])
                clamp.append(clamp[-1] + STEP)
        clamp.append(clamp[-1] + STEP)
        readings.append(run.readings[row])
    slow = read_ratio(recording_of(np.array(clamp), np.array(readings)), NOISE)
    assert slow.last[:-1].tolist() == truth
    ok = found.status == PeriodStatus.SLIP
    assert np.abs(slow.mu0 - found.mu0)[ok].max() < 1e-3


def test_slips_that_noise_hides_are_no_silent_error():
    run, friction, period = recorded(1, ratio=0.97)
    found = read_ratio(run, NOISE)
    error, deviation, _ = errors(found, friction)
    sound = found.doubt[found.status == PeriodStatus.SLIP] == ""
    assert len(found) < period[-1]
    assert np.abs(error / deviation)[sound].max() < 4.5


@pytest.mark.parametrize("before", [4, 30])
def test_samples_that_are_lost_across_a_slip_end_a_period_and_hide_none(before):
    """The force has risen again as far as it had fallen: no reading shows the slip."""
    run, _, _ = recorded(1)
    whole = read_ratio(run, NOISE)
    last, again = whole.last[3], whole.last[4]
    kept = np.ones(len(run), dtype=bool)
    kept[last - before + 1 : again - before + 1] = False
    found = read_ratio(run.take(kept), NOISE)
    assert len(found) == len(whole)
    assert found.status[3] == PeriodStatus.OPEN and np.isnan(found.mu0[3])
    # The tip has stuck with the last forces: to three deviations of their ratio.
    (fx, fy, _), least = run.readings[last - before], found.low[3]
    assert found.last_line[3] == run.line[last - before] and least < whole.mu0[3]
    assert least == pytest.approx(fx / fy, abs=0.005)
    others = np.delete(np.arange(len(whole)), [3, 4, len(whole) - 1])
    assert found.mu0[others] == pytest.approx(whole.mu0[others], abs=2e-3)
    lines = f"{found.first_line[3]}-{found.last_line[3]}"
    why = "samples are missing after it, or the clamp jumped (measure again)"
    assert f"doubtful: {why}: 1 of {len(whole)} periods, line {lines}" in found.notes


def test_few_samples_give_a_bound_and_no_number():
    run, friction, period = recorded(1, step=0.004, to=0.6)
    found = read_ratio(run, NOISE)
    error, deviation, _ = errors(found, friction)
    assert (np.abs(error) < 4.0 * deviation).all()
    unsure = found.status == PeriodStatus.UNSURE
    assert unsure.any() and (found.low <= friction[found.last])[unsure].all()
    assert np.isnan(found.mu0[unsure]).all() and np.isnan(found.high[unsure]).all()
    # Slips at every other sample are no spikes, so that each period is found.
    assert len(found) == period[-1] + 1


def errors_of(run, sizes):
    """Errors of the readings with standard deviations of these sizes."""
    return Carried.of(sizes, Bench.of(run, None, np.ones(3)))


def test_tolerances_of_the_readings_are_a_common_error():
    run, _, _ = recorded(1)
    zero_x, zero_y, angle = 0.01, 0.02, np.deg2rad(0.3)
    plain = read_ratio(run, NOISE)
    known = np.isfinite(plain.mu0)
    mu0, fy = plain.mu0[known], run.readings[plain.last, 1][known]
    expected = {
        "zero_force_x": zero_x / np.abs(fy),
        "zero_force_y": mu0 * zero_y / np.abs(fy),
        "transducer_angle": angle * (1.0 + mu0**2),
    }
    for name, size in zip(expected, (zero_x, zero_y, angle), strict=True):
        found = read_ratio(run, NOISE, errors_of(run, {name: size}))
        shift = np.sqrt(found.common[known] ** 2 - plain.common[known] ** 2)
        assert shift == pytest.approx(expected[name], rel=0.03)
        assert found.mu0[known] == pytest.approx(mu0, abs=1e-3)


def test_an_error_of_a_reading_is_within_its_tolerance():
    run, friction, _ = recorded(1)
    moved = replace(run, readings=run.readings + np.array([0.01, -0.01, 0.0]))
    sizes = {"zero_force_x": 0.01, "zero_force_y": 0.01}
    found = read_ratio(moved, NOISE, errors_of(run, sizes))
    error, deviation, inside = errors(found, friction)
    assert np.abs(errors(read_ratio(moved, NOISE), friction)[0]).mean() > 0.004
    assert inside.all() and np.abs(error / deviation).max() < 2.0


@pytest.mark.parametrize(("column", "said"), [(0, "force_x"), (1, "force_y")])
def test_a_force_with_the_other_sign_is_refused(column, said):
    run, _, _ = recorded(1)
    sign = np.where(np.arange(3) == column, -1.0, 1.0)
    with pytest.raises(RecordingError, match=said):
        read_ratio(replace(run, readings=run.readings * sign), NOISE)


def test_a_spike_is_left_out():
    run, _, _ = recorded(1)
    readings = run.readings.copy()
    readings[100, 0] += 1.0
    found = read_ratio(replace(run, readings=readings), NOISE)
    assert any("spike" in note and "102" in note for note in found.notes)
    assert len(found) == len(read_ratio(run, NOISE))


def test_slips_are_found_in_a_force_that_only_rises_between_them():
    force = -np.concatenate([np.arange(50.0), np.arange(20.0, 60.0), np.arange(30.0, 50.0)])
    found = spans_of(np.arange(110.0), force, 0.1)
    assert found.begins.tolist() == [0, 50, 90] and found.ends.tolist() == [49, 89, 109]
    backward = spans_of(-np.arange(110.0), -force, 0.1)
    assert backward.ends.tolist() == found.ends.tolist()


def table(run):
    """The recording in SI units."""
    return pd.DataFrame(
        {
            "footpoint [mm]": 100.0 * run.clamp,
            "force_x [N]": plain_elastica.FORCE * run.readings[:, 0],
            "force_y [N]": plain_elastica.FORCE * run.readings[:, 1],
        }
    )


def test_no_rod_is_needed_and_results_are_in_si_units(tmp_path):
    run, _, _ = recorded(1)
    table(run).to_csv(tmp_path / "scan.csv", index=False)
    noise = ["--noise", "3 mN, 3 mN, 1 N*m", "--tolerance", "zero_force_x=2 mN"]
    noise += ["--tolerance", "exact"]
    asked = ["identify", str(tmp_path / "scan.csv"), "--method", "ratio", *noise]
    shown = CliRunner().invoke(app, [*asked, "-o", str(tmp_path / "friction.csv")])
    assert shown.exit_code == 0, shown.output
    found = pd.read_csv(tmp_path / "friction.csv")
    limit = {"zero_force_x": 0.002 / plain_elastica.FORCE}
    expected = read_ratio(run, NOISE, errors_of(run, limit))
    assert found["mu0 [1]"].to_numpy() == pytest.approx(expected.mu0, abs=1e-6, nan_ok=True)
    assert found["footpoint [m]"].to_numpy() == pytest.approx(0.1 * expected.footpoint)
    assert found["contact [m]"].isna().all()


@pytest.mark.slow
def test_a_rod_that_is_given_changes_nothing():
    run, _, _ = recorded(1)
    from vibrissa.sensor import Whisker

    wrong = Whisker(theta=5.0, eta=0.5)
    found = identify(wrong, run, method="ratio", noise=NOISE, assume=False).periods
    assert found.mu0.tolist() == pytest.approx(read_ratio(run, NOISE).mu0.tolist(), nan_ok=True)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"method": "forces"}, "ratio"),
        ({"method": "ratio", "tolerances": {"theta": "2 %"}}, "surface_slope, got 'theta'"),
        ({"method": "ratio", "tolerances": {"zero_force_x": "-1 mN"}}, "not be negative"),
    ],
)
def test_what_needs_a_rod_is_said(asked, said):
    run, _, _ = recorded(1)
    with pytest.raises(ArgumentError, match=said):
        identify(None, table(run), **asked)


def test_without_a_rod_the_command_reads_the_ratio(tmp_path):
    table(recorded(1)[0]).to_csv(tmp_path / "scan.csv", index=False)
    asked = ["identify", str(tmp_path / "scan.csv"), "-o", str(tmp_path / "friction.csv")]
    assert CliRunner().invoke(app, asked).exit_code == 0
    shown = CliRunner().invoke(app, [*asked, "--method", "model"])
    assert shown.exit_code == 2 and "give theta and eta, or use the method ratio" in shown.output


def test_a_recording_without_slips_is_one_open_period():
    run, _, _ = recorded(1)
    found = read_ratio(run.take(slice(0, 60)), NOISE)
    assert found.status.tolist() == [PeriodStatus.OPEN]
    assert 0.0 < found.low[0] < 0.3
    with pytest.raises(RecordingError, match="too little"):
        read_ratio(Recording(clamp=np.zeros(1), readings=np.zeros((1, 3)), line=np.ones(1)), NOISE)


def test_a_position_far_off_leaves_too_few_others_for_a_fit():
    # Beside 30 m, steps of 20 um are one place: they tell no polynomial of degree 9.
    clamp = np.arange(60) * STEP
    clamp[35] = -300.0
    spans = Spans(begins=np.array([0, 30]), ends=np.array([29, 59]), cut=np.zeros(2, bool))
    forces = np.column_stack([-0.1 - clamp, np.full(60, -1.0)])
    windows = Windows.of(clamp, spans, np.inf)
    assert (windows.positions == 30).all()
    whole = fitted_forces(windows, forces, NOISE[:2], np.full(2, STEP), WHOLE_DEGREE)
    assert np.isfinite(whole.coefficients[0]).all() and np.isnan(whole.coefficients[1]).all()
    onsets = read_onsets(clamp, forces, NOISE[:2], spans)
    assert onsets.fits.mean[0][0] == pytest.approx(0.1 + 29.5 * STEP)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize(
    ("before", "fx", "fy", "swings"),
    [
        (-1.0, 0.71, -2.56, True),
        (-1.0, 0.7, -2.56, False),
        (-1.0, 0.71, 0.85 * -3.0, False),
        (-1.0, 0.6, -2.6, False),
        (-1.0, 0.8, -2.5, False),
        # A tip that is pulled along has nothing to turn round.
        (1.0, 0.8, -2.9, False),
        (1.0, -0.8, -2.9, False),
        (-1.0, -0.9, -2.9, False),
    ],
)
def test_a_rod_swings_aside_where_fx_turns_round_and_fy_stays(way, before, fx, fy, swings):
    """From fy = −3, at the last sample of a period, to the first of the next."""
    forces = np.array([[-0.5, -2.0], [before, -3.0], [fx, fy], [0.1, -2.0]]) * [way, 1.0]
    spans = Spans(begins=np.array([0, 2]), ends=np.array([1, 3]), cut=np.zeros(2, bool))
    assert _swung(way * np.arange(4.0), forces, spans).tolist() == [swings, False]


def statuses(ratio, deviation=0.01, forces=(-3.0, -10.0), mean=0.3, swung=False, sign=1.0):
    """What is known of a period with this ratio at the nine places, and of one after it."""
    several = np.array([np.broadcast_to(ratio, 9), np.full(9, 0.3)])
    each = np.array([np.full(9, deviation), np.full(9, 0.01)])
    onsets = SimpleNamespace(
        fits=SimpleNamespace(ratio=lambda places: (sign * several, each)),
        sign=np.full(2, sign),
    )
    found = SimpleNamespace(mean=np.array([mean, 0.3]))
    spans = Spans(begins=np.array([0, 1]), ends=np.array([0, 1]), cut=np.zeros(2, bool))
    two = np.array([forces, (sign * -3.0, -10.0)])
    noise = np.array([0.1, 0.2])
    status, least = _statuses(onsets, found, two, noise, spans, np.array([swung, False]))
    assert status[1] == "open"
    return status[0], float(least[0])


RISING = np.linspace(0.1, 0.3, 9)
# The last sample: √(0.1² + (0.3·0.2)²)/10.
ALONE = 0.3 - HALF_WIDTH * np.hypot(0.1, 0.06) / 10.0
# By the curve it is a little more.
CURVE = 0.3 - HALF_WIDTH * 0.01


@pytest.mark.parametrize(
    ("told", "status", "least"),
    [
        ({"ratio": RISING}, "slip", CURVE),
        ({"ratio": RISING, "deviation": 0.001}, "slip", 0.3 - HALF_WIDTH * 0.001),
        ({"ratio": RISING, "deviation": 0.1}, "slip", ALONE),
        ({"ratio": np.nan, "deviation": np.nan, "mean": np.nan}, "unsure", ALONE),
        # A tip that is pushed has needed fx of the other sign: forwards it is negative.
        ({"ratio": RISING, "sign": -1.0, "forces": (3.0, -10.0)}, "slip", CURVE),
        # Ten standard deviations of fy are a load.
        ({"ratio": RISING, "forces": (-0.6, -2.01)}, "slip", CURVE),
        ({"ratio": RISING, "forces": (-0.6, -2.0)}, "unsure", CURVE),
        # Before its end it was 6·√2 deviations larger.
        ({"ratio": [0.3, 0.3, 0.384, *[0.3] * 6]}, "slip", CURVE),
        ({"ratio": [0.3, 0.3, 0.386, *[0.3] * 6]}, "lock", 0.386 - HALF_WIDTH * 0.01),
        ({"ratio": [np.nan, 0.386, *[0.3] * 7]}, "lock", 0.386 - HALF_WIDTH * 0.01),
        ({"ratio": RISING, "swung": True}, "lock", CURVE),
        # By the last sample the friction would be negative, by six deviations.
        ({"ratio": -9.0, "forces": (0.8, -10.0)}, "beyond", None),
        ({"ratio": -9.0, "forces": (0.3, -10.0)}, "slip", None),
    ],
)
def test_what_is_known_of_a_period_by_its_ratio(told, status, least):
    found = statuses(**told)
    assert found[0] == status
    if least is not None:
        assert found[1] == pytest.approx(least)


def doubts_of(clamp, begins, smooth=True, cut=False):
    """What is doubted of the first of two periods."""
    clamp, begins = np.array(clamp, dtype=float), np.array(begins)
    ends = np.append(begins[1:], len(clamp)) - 1
    spans = Spans(begins=begins, ends=ends, cut=np.array([cut, False]))
    found = _doubts(clamp, spans, SimpleNamespace(smooth=np.array([smooth, True])))
    assert not found[1].periods[1] and not found[2].periods[1]
    return [one.doubt.name for one in found if one.periods[0]]


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_friction_by_the_ratio_is_doubted(way):
    even = np.arange(12.0)
    assert doubts_of(way * even, [0, 4]) == []
    assert doubts_of(way * even, [0, 3]) == ["FEW"]
    assert doubts_of(way * even, [0, 6], smooth=False) == ["ROUGH"]
    assert doubts_of(way * even, [0, 6], cut=True) == ["GAP_AFTER"]
    # Of steps of 1 most are usual, and several samples at a step do not count.
    for gap, lost in ((10.0, []), (10.1, ["GAP_AFTER"])):
        assert doubts_of(way * (even + np.where(even > 5, gap - 1.0, 0.0)), [0, 6]) == lost
        slow = np.repeat(even, 3)
        moved = slow + np.where(slow > 5, gap - 1.0, 0.0)
        assert doubts_of(way * moved, [0, 18]) == lost
    turned = np.where(even > 5, 11.0 - even, even)
    assert doubts_of(way * turned, [0, 6]) == []
    assert doubts_of(way * turned, [0, 7]) == ["TURN"]
    back = np.array([0, 1, 2, 3, 4, 3, 2, 1])
    assert doubts_of(way * back, [0, 5]) == ["TURN"]
    assert doubts_of(np.zeros(10), [0, 5]) == []


@pytest.mark.parametrize(
    ("fy", "said"),
    [
        (0.0, "force_y is less than its noise: the rod does not press"),
        (-0.09, "force_y is less than its noise"),
        (-0.1, None),
        (0.09, "force_y is less than its noise"),
        (0.1, "force_y is positive"),
    ],
)
def test_a_normal_force_that_is_none_is_refused(fy, said):
    forces = np.column_stack([-(np.arange(40.0) % 10) / 5.0, np.full(40, fy)])
    with nullcontext() if said is None else pytest.raises(RecordingError, match=said):
        _check_signs(np.arange(40.0), forces, np.array([0.1, 0.1]))


def test_a_channel_that_was_not_recorded_is_refused():
    run, _, _ = recorded(1)
    for channel, said in (
        (0, "force_x has one value in all rows"),
        (1, "force_y is less than its noise"),
    ):
        readings = run.readings.copy()
        readings[:, channel] = 0.0
        with pytest.raises(RecordingError, match=said):
            read_ratio(replace(run, readings=readings), NOISE)


def test_swapped_forces_are_refused():
    run, _, _ = recorded(1)
    readings = run.readings[:, [1, 0, 2]]
    with pytest.raises(MixedColumnsError, match="force_x and force_y seem to be swapped"):
        read_ratio(replace(run, readings=readings), NOISE)


@pytest.mark.parametrize(
    ("status", "size", "refused"),
    [
        (["lock"] * 3, 2.0, True),
        # Two are too few.
        (["lock"] * 2, 2.0, False),
        (["lock", "slip", "lock", "lock", "open"], 2.0, True),
        # Half of them are not most.
        (["lock", "slip", "lock", "lock", "open", "slip"], 2.0, False),
        # The normal force is larger.
        (["lock"] * 3, 0.9, False),
    ],
)
def test_forces_are_swapped_where_the_larger_one_locks_in_most_periods(status, size, refused):
    forces = np.column_stack([np.full(9, -size), np.full(9, -1.0)])
    said = f"in 3 of {len(status)} periods"
    with pytest.raises(MixedColumnsError, match=said) if refused else nullcontext():
        _check_axes(forces, np.array(status))


def test_forces_have_the_signs_of_a_rod_that_is_pushed_and_presses():
    clamp, noise = np.arange(40.0), np.array([0.1, 0.1])
    teeth = -(np.arange(40.0) % 10) / 5.0
    forces = np.column_stack([teeth, np.full(40, -1.0)])
    _check_signs(clamp, forces, noise)
    _check_signs(-clamp, forces * [-1.0, 1.0], noise)
    # A few long falls outweigh many short rises, and what noise may do does not count.
    _check_signs(clamp, forces, np.array([10.0, 0.1]))
    for wrong in (forces * [-1.0, 1.0], forces * [-1.0, -1.0]):
        with pytest.raises(RecordingError, match="force_x grows suddenly where it should fall"):
            _check_signs(clamp, wrong, noise)
        with pytest.raises(RecordingError, match="force_x grows suddenly where it should fall"):
            _check_signs(-clamp, wrong * [-1.0, 1.0], noise)
    with pytest.raises(RecordingError, match="force_y is positive: it is the load of the rod"):
        _check_signs(clamp, forces * [1.0, -1.0], noise)


def even(way=1.0):
    """Four periods of 15 samples in which the ratio grows by 0.02 a sample, to 0.38."""
    clamp, ratio = 0.01 * np.arange(60.0), 0.1 + 0.02 * (np.arange(60) % 15)
    readings = np.column_stack([-way * ratio, np.full(60, -1.0), np.full(60, np.nan)])
    return recording_of(way * clamp, readings)


QUIET = np.full(3, 1e-4)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_ratio_that_grows_evenly_is_uniform_within_the_step_after_the_last_sample(way):
    found = read_ratio(even(way), QUIET)
    assert found.status.tolist() == ["slip", "slip", "slip", "open"]
    assert found.first.tolist() == [0, 15, 30, 45] and found.last.tolist() == [14, 29, 44, 59]
    assert found.first_line.tolist() == [2, 17, 32, 47]
    assert found.last_line.tolist() == [16, 31, 46, 61]
    assert found.footpoint == pytest.approx(way * np.array([0.14, 0.29, 0.44, 0.59]))
    assert found.mu0[:3] == pytest.approx([0.39] * 3, abs=2e-4)
    assert found.by_step[:3] == pytest.approx([0.02 / np.sqrt(12.0)] * 3)
    assert found.deviation[:3] == pytest.approx(found.by_step[:3], rel=2e-3)
    assert found.low[:3] == pytest.approx([0.3805] * 3, abs=2e-4)
    assert found.high[:3] == pytest.approx([0.3995] * 3, abs=2e-4)
    # The last has stuck to what it is.
    assert found.low[3] == pytest.approx(0.38, abs=3e-4)
    for column in (found.mu0, found.deviation, found.high, found.by_step):
        assert np.isnan(column[3])
    assert found.common[3] == 0.0 and not found.shifts[3].any()
    assert found.effects.shape == (4, 0) and found.shifts.shape == (4, 1)
    assert np.isnan(found.contact).all()
    assert set(found.doubt) == set(found.grade) == {""} and found.notes == ()


@pytest.mark.parametrize("channel", [0, 1])
def test_a_lone_spike_takes_its_row_and_no_other(channel):
    run = even()
    run.readings[20, channel] -= 0.5
    found = read_ratio(run, QUIET)
    assert found.notes == ("a lone spike in 1 rows, left out: line 22",)
    assert found.first.tolist() == [0, 15, 30, 45] and found.last.tolist() == [14, 29, 44, 59]
    assert found.last_line.tolist() == [16, 31, 46, 61]
    assert found.mu0[:3] == pytest.approx([0.39] * 3, abs=2e-4)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_errors_of_the_readings_move_all_periods_together(way):
    run, sizes = even(way), {"zero_force_x": 0.01, "zero_force_y": 0.02}
    found, plain = read_ratio(run, QUIET, errors_of(run, sizes)), read_ratio(run, QUIET)
    # Of ratios (fx − a)/(fy − b) with fy = −1, over the size of each.
    expected = [way * 1.0, -0.39 / 1.02]
    assert found.effects == pytest.approx(np.array([expected] * 3 + [[0.0, 0.0]]), abs=1e-3)
    shifts = found.effects * [0.01, 0.02]
    assert found.shifts[:, 1:] == pytest.approx(shifts)
    assert found.common == pytest.approx(np.linalg.norm(found.shifts, axis=1))
    # Of finitely many values it is a little less.
    whole = np.hypot(plain.deviation, found.common)[:3]
    assert found.deviation[:3] == pytest.approx(whole, rel=0.015)
    # What is common widens the bound, too.
    wide = HALF_WIDTH * np.linalg.norm(np.array([1.0, 0.38 / 1.02]) * [0.01, 0.02])
    assert found.low[3] == pytest.approx(plain.low[3] - wide, abs=3e-4)


def test_without_noise_that_can_be_told_and_of_two_samples_nothing_is_read():
    with pytest.raises(RecordingError, match="the noise of column force_y is 0, or cannot be"):
        read_ratio(even())
    with pytest.raises(RecordingError, match="too little to identify friction from: 2 usable"):
        read_ratio(even().take(slice(2)), QUIET)
    # A bound is not below 0.
    weak = replace(even(), readings=even().readings * [0.01, 1.0, 1.0])
    assert read_ratio(weak, np.full(3, 0.05)).low[-1] == 0.0
