"""Friction by the ratio of the forces, without a rod: against an elastica that shares no code."""

from dataclasses import replace
from functools import cache

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import plain_elastica
from responses import by_law, respond
from steel import identified, recording_of
from vibrissa.cli.app import app
from vibrissa.errors import ArgumentError, MixedColumnsError, RecordingError
from vibrissa.scanning import surfaces
from vibrissa.scanning.simulation import simulate
from vibrissa.scanning.stage import path
from vibrissa.sensor import PeriodStatus, Recording, Whisker

# 3 mN on a steel rod of 1 mm × 100 mm, steps of 20 µm.
NOISE = np.full(3, 0.003 / plain_elastica.FORCE)
STEP = 0.0002
RODS = {"as given": {}, "tilted": {"tilt": np.deg2rad(2.0)}, "bent": {"curvature": -0.08}}


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


def read_ratio(run, noise=NOISE, **tolerances):
    """Periods by the ratio of the forces, with these tolerances and no others."""
    return identified(None, run, noise=noise, tolerances=tolerances, assume=False).periods


def errors(found, friction):
    """Errors of μ0, and whether the intervals hold it, of the periods that ended."""
    ok, truth = found.status == PeriodStatus.SLIP, friction[found.last]
    inside = (found.low <= truth) & (truth <= found.high)
    return (found.mu0 - truth)[ok], found.deviation[ok], inside[ok]


def test_crosstalk_of_a_moment_that_was_not_recorded_is_that_of_full_scale():
    run, _, _ = recorded(1)
    exact, found = read_ratio(run), read_ratio(run, crosstalk=0.01)
    fx, fy = run.readings[found.last, :2].T
    most_x, most_y = np.abs(run.readings[:, :2]).max(axis=0)
    # Of fy in fx, of fx in fy, and of a moment of full scale in each of them.
    parts = [most_x / most_y, found.mu0 * most_y / most_x * fx / fy]
    parts += [most_x / fy, found.mu0 * most_y / fy]
    wanted = 0.01 * np.sqrt(sum(part**2 for part in parts))
    more, slips = np.sqrt(found.common**2 - exact.common**2), found.status == PeriodStatus.SLIP
    assert more[slips] == pytest.approx(wanted[slips], rel=0.01)


def test_the_model_is_compared_with_the_ratio_over_three_periods_or_more():
    run, _, period = recorded(1)
    whisker, known = Whisker(theta=2.0, eta=0.85), {"noise": NOISE, "assume": False}
    all_periods = identified(whisker, run, **known).beside
    assert all_periods.agrees and abs(all_periods.difference) < 4.0 * all_periods.spread
    two = run.take(slice(int(np.argmax(period > 1)) + 3))
    found = identified(whisker, two, **known).beside
    assert np.isfinite(found.ratio).sum() == 2 and np.isnan(found.difference) and found.agrees


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    ["as given", *(pytest.param(one, marks=pytest.mark.nightly) for one in ("tilted", "bent"))],
)
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
        rod = Whisker(theta=2.0, eta=0.85)
        known = {"noise": NOISE, "assume": False}
        model = [
            errors(identified(rod, run, **known).periods, friction)[0]
            for run, friction, _ in runs[:6]
        ]
        assert np.concatenate(model).std() < 0.7 * error.std()


@pytest.mark.slow
@pytest.mark.parametrize("step", [pytest.param(0.0002, marks=pytest.mark.nightly), 0.001, 0.002])
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


def test_many_precise_samples_hide_no_slip_and_a_slip_among_them_is_named():
    truth = simulate(respond(2.0, 0.85), surfaces.constant(0.3), path("0.0001", ["0.3"]))
    noise = 0.3 * NOISE
    readings = truth.reactions + np.random.default_rng(1).normal(size=(len(truth), 3)) * noise
    found = read_ratio(recording_of(truth.clamp, readings), noise)
    assert len(found) > 5 and set(found.grade) == {""}
    last = found.last[3]
    readings[last - 60 : last + 1, 0] += 7.0 * noise[0]
    found = read_ratio(recording_of(truth.clamp, readings), noise)
    assert found.grade.tolist().index("wrong") == 3 and "a slip may be hidden" in found.doubt[3]


def test_a_tip_that_is_pulled_back_has_the_same_friction():
    response = respond(2.0, 0.85)
    truth = simulate(
        response, surfaces.constant(0.3), path("0.0002", ["0.1", "-0.1"]), by_law("kinetic")
    )
    noise = np.random.default_rng(1).normal(size=truth.reactions.shape) * NOISE
    found = read_ratio(recording_of(truth.clamp, truth.reactions + noise), NOISE)
    error, deviation, inside = errors(found, truth.mu0)
    assert (np.diff(truth.clamp)[found.last[:-1]] < 0.0).sum() > 50
    assert inside.mean() > 0.9 and np.abs(error / deviation).max() < 4.5


def test_a_locked_tip_and_a_rod_that_swings_aside_give_bounds_alone():
    response = respond(2.0, 0.85)
    truth = simulate(response, surfaces.constant(0.8), path("0.0002", ["0.95"]))
    noise = np.random.default_rng(1).normal(size=truth.reactions.shape) * NOISE
    found = read_ratio(recording_of(truth.clamp, truth.reactions + noise), NOISE)
    assert found.status.tolist() == [PeriodStatus.LOCK]
    assert found.low[0] < response.mu_lock and np.isnan(found.mu0[0])
    # The bound is below the largest ratio, by what noise may add to it.
    lows = []
    for seed in range(4):
        noise = np.random.default_rng(seed).normal(size=truth.reactions.shape) * 10.0 * NOISE
        readings = truth.reactions + noise
        lows.append(read_ratio(recording_of(truth.clamp, readings), 10.0 * NOISE).low[0])
    assert response.mu_lock - np.mean(lows) == pytest.approx(0.003, abs=7e-4)
    assert any("the rod buckles laterally in line" in note for note in found.notes)


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
    # Of a slip that takes a while the first sample may not show it.
    assert slow.last[:-1].tolist() == [row - 1 for row in truth]
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
    why = "samples are missing at a period's end, or the clamp jumped or turned (measure again)"
    assert f"doubtful: {why}: 1 of {len(whole)} periods, line {lines}" in found.notes


def test_few_samples_give_a_bound_and_no_number():
    run, friction, period = recorded(1, step=0.004, to=0.6)
    found = read_ratio(run, NOISE)
    error, deviation, _ = errors(found, friction)
    assert (np.abs(error) < 4.0 * deviation).all()
    unsure = found.status == PeriodStatus.UNSURE
    assert (found.low <= friction[found.last])[unsure].all()
    assert np.isnan(found.mu0[unsure]).all() and np.isnan(found.high[unsure]).all()
    assert "sample more finely" in found.doubt[2]
    # Slips at every other sample are no spikes, so that each period is found.
    assert len(found) == period[-1] + 1


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
    for name, size in zip(expected, (zero_x, zero_y, "0.3 deg"), strict=True):
        found = read_ratio(run, **{name: size})
        shift = np.sqrt(found.common[known] ** 2 - plain.common[known] ** 2)
        assert shift == pytest.approx(expected[name], rel=0.03)
        assert found.mu0[known] == pytest.approx(mu0, abs=1e-3)


@pytest.mark.parametrize(
    ("change", "error", "said"),
    [
        (np.diag([-1.0, 1.0, 1.0]), RecordingError, "force_x"),
        (np.diag([1.0, -1.0, 1.0]), RecordingError, "force_y is not negative"),
        (np.diag([0.0, 1.0, 1.0]), RecordingError, "force_x has one value in all rows"),
        (np.diag([1.0, 0.0, 1.0]), RecordingError, "force_y is not negative"),
        (np.eye(3)[[1, 0, 2]], MixedColumnsError, "force_x and force_y seem to be swapped"),
    ],
)
def test_forces_of_another_sign_or_none_are_refused(change, error, said):
    run, _, _ = recorded(1)
    readings = np.nan_to_num(run.readings) @ change
    readings[:, 2] = np.nan
    with pytest.raises(error, match=said):
        read_ratio(replace(run, readings=readings))


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
    expected = read_ratio(run, **limit)
    assert found["mu0 [1]"].to_numpy() == pytest.approx(expected.mu0, abs=1e-6, nan_ok=True)
    assert found["footpoint [m]"].to_numpy() == pytest.approx(0.1 * expected.footpoint)
    assert found["contact [m]"].isna().all()


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"method": "forces"}, "ratio"),
        ({"method": "ratio", "tolerances": {"thete": "2 %"}}, "did you mean theta"),
        ({"method": "ratio", "tolerances": {"zero_force_x": "-1 mN"}}, "not be negative"),
    ],
)
def test_what_needs_a_rod_is_said(asked, said):
    run, _, _ = recorded(1)
    with pytest.raises(ArgumentError, match=said):
        identified(None, table(run), **asked)


def test_tolerances_that_the_ratio_does_not_use_are_named():
    sizes = {"zero_moment_z": "1 N*mm", "zero_force_x": "2 mN"}
    found = identified(None, table(recorded(1)[0]), tolerances=sizes).periods
    assert "the ratio of the forces does not use the tolerance of zero_moment_z" in found.notes


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
    with pytest.raises(RecordingError, match="too few rows"):
        read_ratio(Recording(clamp=np.zeros(1), readings=np.zeros((1, 3)), line=np.ones(1)), NOISE)


def test_a_slip_time_that_leaves_no_samples_is_refused():
    with pytest.raises(RecordingError, match="no samples are left between the slips"):
        identified(None, replace(even(), interval=1.0), noise=QUIET, slip_time="1 h")


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
    assert found.footpoint == pytest.approx(way * np.array([0.14, 0.29, 0.44, 0.59]))
    assert found.mu0[:3] == pytest.approx([0.39] * 3, abs=2e-4)
    assert found.by_step[:3] == pytest.approx([0.02 / np.sqrt(12.0)] * 3)
    assert found.deviation[:3] == pytest.approx(found.by_step[:3], rel=2e-3)
    assert found.low[:3] == pytest.approx([0.3805] * 3, abs=2e-4)
    assert found.high[:3] == pytest.approx([0.3995] * 3, abs=2e-4)
    # The last has stuck to what it is.
    assert found.low[3] == pytest.approx(0.38, abs=3e-4)
    assert np.isnan([found.mu0[3], found.deviation[3], found.high[3], found.by_step[3]]).all()
    assert np.isnan(found.contact).all()
    assert set(found.doubt) == set(found.grade) == {""}
    assert all("nothing checks mu0" in note for note in found.notes)


@pytest.mark.parametrize("channel", [0, 1])
def test_a_lone_spike_takes_its_row_and_no_other(channel):
    run = even()
    run.readings[20, channel] -= 0.5
    found = read_ratio(run, QUIET)
    assert "a lone spike in 1 row, left out: line 22" in found.notes
    assert found.first.tolist() == [0, 15, 30, 45] and found.last.tolist() == [14, 29, 44, 59]
    assert found.mu0[:3] == pytest.approx([0.39] * 3, abs=2e-4)


def test_two_passes_in_one_file_are_split():
    one = even()
    twice = recording_of(np.tile(one.clamp, 2), np.tile(one.readings, (2, 1)))
    found = read_ratio(twice, QUIET)
    assert found.status.tolist() == ["slip", "slip", "slip", "open"] * 2
    assert set(found.doubt) == {""}


@pytest.mark.parametrize(("rows", "slip_time"), [(46, None), (48, "4 s")])
def test_a_slip_shortly_before_the_end_is_one(rows, slip_time):
    """What follows it is too short for a period, or has not settled."""
    run = replace(even().take(slice(rows)), interval=1.0)
    found = identified(None, run, noise=QUIET, assume=False, slip_time=slip_time).periods
    assert found.status.tolist() == ["slip"] * 3 and found.last[2] == 44
    assert found.mu0 == pytest.approx([0.39] * 3, abs=2e-4)
