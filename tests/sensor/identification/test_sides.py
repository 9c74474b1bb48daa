"""Friction from recordings in which a round rod swings aside."""

import csv
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from typer.testing import CliRunner

from steel import NANO, NOISE, SCALE, SENSOR, SI, WHISKER, measured, recording_of
from vibrissa.cli.app import app
from vibrissa.errors import RecordingError
from vibrissa.sensor import Whisker, identify, scan, surfaces
from vibrissa.sensor.identification.calibration import calibrate, known_setup
from vibrissa.sensor.identification.friction import PeriodStatus, find_periods
from vibrissa.sensor.identification.recording import MIRROR, USED, WITH_ROD, Method
from vibrissa.sensor.response.branch import respond
from vibrissa.sensor.response.heights import respond_between
from vibrissa.sensor.simulation.scanning import TipPhase, TipSide, path, simulate


@pytest.fixture(scope="module")
def response():
    return respond(2.0, 0.85)


def swing_of(truth):
    return int(np.flatnonzero(truth.phase == TipPhase.SWING)[0])


def recorded(response, surface, stop="1.0", seed=1, noise=NOISE):
    """A scan that swings aside, and its readings."""
    truth = simulate(response, surface, path("0.0005", [stop]))
    random = np.random.default_rng(seed)
    readings = truth.reactions + noise * random.standard_normal(truth.reactions.shape)
    return truth, recording_of(truth.clamp, readings)


def columns(periods):
    """All columns as text, in which a missing number equals another."""
    return [str(values.tolist()) for values in periods.columns.values()]


solved = cache(respond)
RODS = [(2.0, 0.85, "point"), (1.0, 0.85, "point"), (10.0, 0.85, "point"), (3.0, 0.7, "line")]


@pytest.mark.parametrize(
    "rod", [RODS[0], *(pytest.param(rod, marks=pytest.mark.slow) for rod in RODS[1:])]
)
@pytest.mark.parametrize("method", WITH_ROD)
def test_both_sides_give_bounds_and_the_trailing_tip_its_friction(rod, method):
    response = solved(*rod)
    noise = 5e-4 * np.abs(response.reactions(response.x0_end))
    truth, recording = recorded(response, surfaces.constant(0.9), "1.05", noise=noise)
    periods = find_periods(
        known_setup(response), recording, noise, method=method, law="free", step=0.0005
    )
    # One row for each period, and one more where the rod swings aside.
    assert len(periods) == truth.period[-1] + 1
    assert (periods.side == truth.side[periods.last]).all()
    assert periods.contact == pytest.approx(truth.contact[periods.last], abs=1e-3)
    assert periods.first[1] == swing_of(truth) == periods.last[0] + 1
    ahead, trailing = periods.take([0]), periods.take([1])
    locked = [ahead] if method is not Method.SPACING else [ahead, trailing]
    for part in locked:
        assert part.status == [PeriodStatus.LOCK] and np.isnan(part.mu0).all()
        assert response.curve.mu_lock * (1.0 - 1e-9) <= part.low < 0.9
    assert ahead.low == pytest.approx(response.curve.mu_lock)
    slips = periods.take(slice(len(locked), -1))
    assert set(slips.status) == {PeriodStatus.SLIP} and not any(slips.doubt[:-1])
    assert (np.abs(slips.mu0 - 0.9) < 4.5 * slips.deviation).all()
    assert periods.status[-1] == PeriodStatus.OPEN
    assert any("swung aside" in note for note in periods.notes)


@pytest.mark.slow
@pytest.mark.parametrize("method", [Method.FORCES, Method.MOMENT])
def test_intervals_past_the_swing_cover_what_they_say(response, method):
    inside, errors = [], []
    for seed in range(20):
        truth = simulate(response, surfaces.random(seed, 0.8, 0.06, 0.02), path("0.0005", ["1.0"]))
        readings = measured(truth.reactions, [seed, 2])
        # Near the swing the moment is beyond the transducer's range.
        rows = np.flatnonzero(~SENSOR.saturated(readings * SCALE)[:, USED[method]].any(axis=1))
        recording = recording_of(truth.clamp[rows], readings[rows])
        periods = find_periods(known_setup(response), recording, NOISE, method=method)
        known = periods.take(periods.status == PeriodStatus.SLIP)
        friction = truth.mu0[rows[known.last]]
        inside += list((known.low <= friction) & (friction <= known.high))
        errors += list((known.mu0 - friction) / known.deviation)
    assert len(inside) > 200
    assert 0.92 <= np.mean(inside) <= 0.98
    assert abs(np.mean(errors)) < 0.25 and 0.9 < np.std(errors) < 1.1


@pytest.mark.parametrize("method", WITH_ROD)
def test_before_the_swing_it_is_what_a_recording_up_to_there_gives(response, method):
    surface = surfaces.patches([0.0, 0.5], [0.3, 0.8])
    truth, recording = recorded(response, surface)
    row = swing_of(truth)
    setup, asked = known_setup(response), {"method": method, "law": "free"}
    whole = find_periods(setup, recording, NOISE, **asked)
    alone = find_periods(setup, recording.take(slice(row)), NOISE, **asked)
    before = whole.take(whole.side == TipSide.AHEAD)
    assert len(before) > 3 and columns(before) == columns(alone)
    # A strip stays in its plane: the rest of the readings are no states of it.
    with pytest.raises(RecordingError, match="no state of this rod"):
        find_periods(known_setup(respond(2.0, 0.85, section="planar")), recording, NOISE)


@pytest.mark.parametrize("method", WITH_ROD)
def test_a_recording_that_ends_before_the_trailing_tip_slips_gives_bounds(response, method):
    truth, recording = recorded(response, surfaces.constant(0.9))
    # First where the mirrored tip is still past its lock, then where the clamp pulls it.
    for stop, beyond_lock in ((0.6, False), (2.0 * response.x0_end + 0.015, True)):
        rows = truth.clamp <= stop
        periods = find_periods(known_setup(response), recording.take(rows), NOISE, method=method)
        assert periods.status.tolist() == [PeriodStatus.LOCK] * 2
        fx, fy, _ = truth.reactions[rows][-1]
        needed = max(response.curve.mu_lock, fx / fy)
        assert (needed > 0.7) == beyond_lock
        assert periods.low[0] == pytest.approx(response.curve.mu_lock)
        assert needed - 0.01 < periods.low[1] < needed * (1.0 + 1e-9)


def test_the_moment_alone_shows_the_swing_too(response):
    _, recording = recorded(response, surfaces.constant(0.8))
    alone = replace(recording, readings=recording.readings * [np.nan, np.nan, 1.0])
    setup = known_setup(response)
    both = (find_periods(setup, one, NOISE, method=Method.MOMENT) for one in (recording, alone))
    first, second = ([p.status.tolist(), p.side.tolist(), p.mu0[1]] for p in both)
    assert first == second


def test_a_stage_that_turns_back_swings_the_rod_back(response):
    truth = simulate(response, surfaces.constant(0.8), path("0.0005", ["0.6", "-0.1"]))
    recording = recording_of(truth.clamp, measured(truth.reactions, 4))
    periods = find_periods(known_setup(response), recording, NOISE)
    assert periods.side[:3].tolist() == ["ahead", "behind", "ahead"]
    assert periods.status[:3].tolist() == ["lock", "lock", "slip"]
    swings = np.flatnonzero(truth.phase == TipPhase.SWING)
    assert periods.first[1:3].tolist() == swings.tolist()
    assert abs(periods.mu0[2] - 0.8) < 4.5 * periods.deviation[2]


@pytest.mark.parametrize("by", [-0.01, 0.01])
def test_a_real_rod_may_swing_a_little_earlier_or_later(response, by):
    truth, recording = recorded(response, surfaces.constant(0.8))
    swing, between = response.x0_end, np.abs(truth.clamp - response.x0_end - 0.5 * by) < 0.5 * 0.01
    # The states of a strip go on where those of the round rod end.
    strip = respond(2.0, 0.85, section="planar")
    here = truth.clamp[between]
    other = strip(2.0 * swing - here) * MIRROR if by < 0.0 else strip(here)
    readings = recording.readings.copy()
    readings[between] += other - truth.reactions[between]
    periods = find_periods(
        known_setup(response), replace(recording, readings=readings), NOISE, method=Method.MOMENT
    )
    assert any("no state of this rod" in note for note in periods.notes)
    assert periods.side[:2].tolist() == ["ahead", "behind"]
    assert periods.status[:2].tolist() == ["lock", "slip"]
    assert abs(periods.mu0[1] - 0.8) < 4.5 * periods.deviation[1]


def test_a_sensor_bias_is_that_of_the_same_transducer_on_both_sides(response):
    _, recording = recorded(response, surfaces.constant(0.8))
    bias = np.array([0.3, -0.2, 0.1])
    biased = replace(recording, readings=recording.readings + bias)
    setup = known_setup(response)
    found = find_periods(replace(setup, offset=bias), biased, NOISE)
    expected = find_periods(setup, recording, NOISE)
    assert found.status.tolist() == expected.status.tolist()
    assert found.mu0 == pytest.approx(expected.mu0, abs=1e-9, nan_ok=True)
    assert (recording.mirrored().readings == recording.readings * MIRROR).all()


@pytest.mark.slow
def test_height_and_bias_are_estimated_from_before_the_swing(response):
    heights = respond_between(2.0, 0.86)
    surface = surfaces.patches([0.0, 0.75], [0.3, 0.8])
    truth, recording = recorded(response, surface, "1.25")
    bias = np.array([0.3, -0.2, 0.1])
    biased = replace(recording, readings=recording.readings + bias)
    setup = calibrate(heights, 0.86, biased, NOISE, ["eta", "offset"])
    error = np.append(setup.eta - 0.85, setup.offset - bias)
    assert (np.abs(error) < 4.5 * setup.deviation).all()
    periods = find_periods(setup, biased, NOISE, method=Method.MOMENT)
    assert (periods.side == truth.side[periods.last]).all()
    (trailing,) = np.flatnonzero(truth.period[periods.first] == truth.period[swing_of(truth)])[1:]
    assert periods.status[trailing] == PeriodStatus.SLIP and periods.common[trailing] > 0.0
    assert abs(periods.mu0[trailing] - 0.8) < 4.5 * periods.deviation[trailing]


@pytest.mark.slow
def test_from_a_surface_past_the_swing_to_its_friction_on_the_command_line(tmp_path):
    out, found = tmp_path / "scan.csv", tmp_path / "friction.csv"
    way = ["--mu0", "0.8", "--step", "50 um", "--to", "95 mm"]
    exact = ["--tolerance", "exact"]
    for words in (
        ["scan", *WHISKER, *SI, *NANO, *way, "-o", str(out)],
        ["identify", str(out), *WHISKER, *SI, *NANO, *exact, "-o", str(found)],
    ):
        result = CliRunner().invoke(app, words)
        assert result.exit_code == 0, result.output
    assert "the rod has swung aside: line 837" in result.output
    assert "moment_z is at the transducer's limit in 200 rows: not used" in result.output
    assert "The recording fits what was given." in result.output
    with found.open() as file:
        ahead, trailing, *dragged = csv.DictReader(file)
    assert (ahead["status"], ahead["side"]) == ("lock", "ahead")
    assert 0.477 < float(ahead["low [1]"]) < 0.478
    assert {row["side"] for row in (trailing, *dragged)} == {"behind"}
    for row in (trailing, *dragged[:-1]):
        assert abs(float(row["mu0 [1]"]) - 0.8) < 4.5 * float(row["deviation [1]"])


@pytest.mark.slow
def test_tolerances_of_a_rod_that_swings_aside_widen_its_intervals_alone():
    whisker = Whisker.read(2, "85 mm", modulus="210 GPa", diameter="1 mm", length="100 mm")
    nano = "nano17-si-12-0.12"
    scanned = scan(whisker, surfaces.constant(0.8), step="50 um", to=["95 mm"], transducer=nano)
    exact, assumed = (
        identify(whisker, scanned.to_pandas(), transducer=nano, assume=assume)
        for assume in (False, True)
    )
    known = np.isfinite(exact.periods.mu0)
    assert known.sum() == 7
    assert exact.periods.goodness.fits and assumed.periods.goodness.fits
    assert not any(assumed.periods.doubt[known])
    np.testing.assert_allclose(assumed.periods.mu0[known], exact.periods.mu0[known], atol=2e-3)
    assert (assumed.periods.common[known] > 0.01).all()
    wide = assumed.periods.high - assumed.periods.low > exact.periods.high - exact.periods.low
    assert wide[known].all()
