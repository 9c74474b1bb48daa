"""Friction from signals: known surfaces, known noise, damaged recordings."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from recordings import covered, found_in, known, recorded
from responses import by_law, respond
from steel import NOISE, ROD, SCALE, SENSOR, STIFF, TRANSDUCER, identified, measured, recording_of
from vibrissa.errors import WrongRodError
from vibrissa.quantities.units import Units
from vibrissa.scanning import surfaces
from vibrissa.scanning.scan import TipPhase
from vibrissa.scanning.simulation import simulate
from vibrissa.scanning.stage import path
from vibrissa.sensor import Setup, Whisker, scan
from vibrissa.sensor.identification.noise import noise_of
from vibrissa.sensor.identification.periods import PeriodStatus
from vibrissa.sensor.identification.recording import (
    Method,
    direction,
    read_recording,
    table_of,
)
from vibrissa.sensor.identification.slips import Spans, load_of


@pytest.fixture(scope="module")
def response():
    return respond(2.0, 0.85)


@pytest.mark.parametrize("turns", [("1.2",), ("0.6", "0.1")])
def test_every_slip_is_found_and_its_friction(response, turns):
    truth, recording = recorded(response, turns=turns)
    periods = found_in(recording)
    assert periods.notes == ()
    assert len(periods.status) == truth.period[-1]
    assert (np.diff(truth.period)[periods.last[:-1]] == 1).all()
    ok = known(periods)
    assert (~ok).sum() == 1
    error = (periods.mu0 - truth.mu0[periods.last])[ok]
    assert np.abs(error / periods.deviation[ok]).max() < 4.5
    assert np.abs(error.mean()) < 4 * np.std(error) / np.sqrt(len(error))
    assert periods.contact == pytest.approx(truth.contact[periods.last], abs=2e-3)


def test_slips_in_the_noise_of_the_forces_are_seen_in_the_moment_or_refused(response):
    truth = simulate(response, surfaces.constant(0.3), path("0.0005", ["0.6"]))
    rise = np.ptp(truth.reactions[truth.period == 2, 0])
    noise = np.array([rise / 5.5, rise / 5.5, NOISE[2]])
    random = np.random.default_rng(1).normal(size=truth.reactions.shape)
    recording = recording_of(truth.clamp, truth.reactions + noise * random)
    periods = found_in(recording, noise)
    assert len(periods) == truth.period[-1] and periods.notes == ()
    forces = replace(recording, readings=recording.readings * [1.0, 1.0, np.nan])
    with pytest.raises(WrongRodError, match="zero offsets, noise"):
        found_in(forces, noise)


@pytest.mark.slow
def test_intervals_cover_what_they_say(response):
    within = covered(response, "free", range(100, 110))
    # 93 to 97 % is what is promised.
    assert len(within) > 400
    assert 0.93 <= np.mean(within) <= 0.97


@pytest.mark.slow
def test_the_step_biases_the_last_ratio_and_is_accounted_for(response):
    biased, corrected = [], []
    for seed in range(4):
        truth, recording = recorded(response, seed, step="0.002")
        periods = found_in(recording)
        ok, last = known(periods), periods.last
        fx, fy, _ = truth.reactions[last].T
        ratio = fx / fy
        biased += list((ratio - truth.mu0[last])[ok])
        corrected += list((periods.mu0 - truth.mu0[last])[ok])
    assert np.max(biased) <= 0.0
    assert np.mean(biased) < -0.003
    assert abs(np.mean(corrected)) < 0.2 * abs(np.mean(biased))


@pytest.mark.slow
def test_noise_is_no_lateral_buckling():
    whisker = Setup.read(
        theta=1.5, eta=0.684, modulus="200 GPa", diameter="0.35 mm", length="100 mm"
    ).whisker
    signals = scan(whisker, surfaces.constant(0.2), step="50 um", to=["16 mm"])
    frame = signals.measured(TRANSDUCER, 2).to_pandas()
    notes = identified(whisker, frame, transducer=TRANSDUCER, assume=False).periods.notes
    assert not any("buckles laterally" in note for note in notes)


@pytest.mark.slow
def test_noise_is_estimated_despite_the_slips(response):
    _, recording = recorded(response)
    assert noise_of(recording.readings) == pytest.approx(NOISE, rel=0.1)
    # Of two readings at each step, those of different steps tell the rise as well.
    truth, _ = recorded(response, step="0.002")
    rows = np.repeat(np.arange(len(truth)), 2)
    several = measured(truth.reactions[rows], 2)
    assert noise_of(several, truth.clamp[rows]) == pytest.approx(NOISE, rel=0.1)
    # Positions of a coarse encoder are equal while the clamp moves.
    truth, fine = recorded(response)
    coarse = np.floor(np.arange(len(truth)) / 2.0)
    assert noise_of(fine.readings, coarse) == pytest.approx(NOISE, rel=0.1)
    periods = found_in(recording, None)
    given = found_in(recording)
    assert periods.mu0 == pytest.approx(given.mu0, abs=1e-3, nan_ok=True)


def test_a_channel_that_was_not_recorded_has_no_noise_and_is_not_missed(response, recwarn):
    _, recording = recorded(response)
    readings = recording.readings * [np.nan, 1.0, 1.0]
    assert np.isnan(noise_of(readings)).tolist() == [True, False, False]
    alone = replace(recording, readings=readings)
    assert known(found_in(alone, None)).sum() > 40
    assert not recwarn.list


@pytest.mark.slow
def test_lost_samples_widen_the_interval_and_nothing_else(response):
    truth, recording = recorded(response)
    keep = np.random.default_rng(5).random(len(recording.line)) > 0.3
    keep[:2] = keep[-1] = True
    lossy = recording.take(keep)
    periods = found_in(lossy)
    ok = known(periods)
    rows = np.flatnonzero(keep)[periods.last]
    friction0 = truth.mu0[rows]
    inside = ((periods.low <= friction0) & (friction0 <= periods.high))[ok]
    assert len(inside) > 40 and inside.mean() > 0.85
    whole = found_in(recording)
    assert np.nanmean(periods.deviation) > np.nanmean(whole.deviation)


@pytest.mark.slow
def test_several_samples_at_each_step_are_one_step(response):
    truth, _ = recorded(response)
    dwell = np.repeat(np.arange(len(truth)), 3)
    recording = recording_of(truth.clamp[dwell], measured(truth.reactions[dwell], 8))
    periods = found_in(recording)
    assert len(periods.status) == truth.period[-1]
    assert not any("the clamp jumped" in doubt for doubt in periods.doubt)
    friction0, ok = truth.mu0[dwell[periods.last]], known(periods)
    assert ((periods.low <= friction0) & (friction0 <= periods.high))[ok].mean() > 0.85


def test_lone_spikes_are_left_out_and_named(response):
    truth, recording = recorded(response)
    readings = recording.readings.copy()
    at = [i for i in (300, 700, 1500) if TipPhase.SLIP not in truth.phase[i - 1 : i + 3]]
    assert at
    readings[at, 0] += 30.0
    readings[at, 2] -= 0.1
    spiked = replace(recording, readings=readings)
    periods = found_in(spiked)
    assert len(periods.status) == truth.period[-1]
    (note,) = periods.notes
    assert all(str(i + 2) in note for i in at)
    plain, spiked = (identified(None, one, noise=NOISE) for one in (recording, spiked))
    assert spiked.summary().deviation == pytest.approx(plain.summary().deviation, rel=0.05)


def test_a_swing_aside_is_seen_where_positions_are_noisy(response):
    truth = simulate(response, surfaces.constant(0.9), path("0.0005", ["1.1"]))
    for seed in range(4):
        noise = np.random.default_rng(seed).normal(0.0, 0.0005, len(truth))
        recording = recording_of(truth.clamp + noise, measured(truth.reactions, seed))
        notes = identified(None, recording, noise=NOISE, assume=False).periods.notes
        assert any("buckles laterally" in note for note in notes)


def test_positions_that_scatter_by_more_than_a_step_make_no_slips(response):
    truth = simulate(response, surfaces.constant(0.3), path("0.0002", ["0.2"]))
    rows = np.repeat(np.arange(len(truth)), 10)
    noise = np.random.default_rng(1).normal(0.0, 1e-6, len(rows))
    recording = recording_of(truth.clamp[rows] + noise, measured(truth.reactions[rows], 1))
    periods = identified(None, recording, noise=NOISE, assume=False).periods
    assert len(periods) == truth.period[-1] and set(periods.status[:-1]) == {"slip"}


def test_readings_of_a_coarse_resolution_are_weighted_by_their_rise(response):
    truth = simulate(response, surfaces.constant(0.3), path("0.0001", ["0.2"]))
    fall = np.ptp(truth.reactions[truth.period == 2], axis=0)
    noise = fall / [1.0, 1.0, 9.3]
    for seed in range(3):
        random = np.random.default_rng(seed).normal(size=truth.reactions.shape)
        counts = np.round(truth.reactions / noise + random) * noise
        load = load_of(recording_of(truth.clamp, counts), noise)
        # The moment tells most of it.
        assert np.corrcoef(load, -counts[:, 2])[0, 1] > 0.98


def test_a_clamp_turns_where_it_goes_back_by_more_than_its_noise():
    clamp = 0.3 - np.abs(np.linspace(-0.2, 0.1, 15000))
    noisy = clamp + np.random.default_rng(1).normal(0.0, 0.01, len(clamp))
    way = replace(recording_of(noisy, np.zeros((len(clamp), 3))), position=0.01).direction
    assert set(way[:9500]) == {1.0} and set(way[10500:]) == {-1.0}
    assert direction(np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0]), 0.0).tolist() == [1, 1, 1, -1, -1]


def test_rows_of_a_long_gap_between_periods_are_those_of_no_period():
    begins, ends, none = np.array([0, 40, 55]), np.array([9, 50, 70]), np.zeros(3, dtype=bool)
    spans = Spans(begins=begins, ends=ends, after=ends, cut=none, passes=none, swung=none)
    assert spans.between.tolist() == list(range(10, 40))


def measured_over(response, surface, turns, law="free", section="round"):
    """Truth and periods of a scan, readings at the transducer's limit left out."""
    truth = simulate(response, surface, path("0.0005", turns), by_law(law))
    readings = measured(truth.reactions, 3)
    rows = np.flatnonzero(~SENSOR.saturated(readings * STIFF).any(axis=1))
    recording = recording_of(truth.clamp[rows], readings[rows])
    periods = found_in(recording, section=section)
    return truth, periods, rows[periods.last]


# To where a strip snaps through, or to the end of the path somewhat past the lock.
@pytest.mark.parametrize(("section", "stop"), [("planar", "1.5"), ("round", "0.6")])
def test_a_tip_that_locks_gives_a_bound_and_no_number(section, stop):
    response = respond(2.0, 0.85, section=section)
    surface = surfaces.patches([0.0, 0.75], [0.3, 0.8])
    truth, periods, _ = measured_over(response, surface, (stop,), section=section)
    assert truth.phase[-1] == TipPhase.LOCK
    assert len(periods.status) == truth.period[-1]
    assert periods.status[-1] == PeriodStatus.LOCK and PeriodStatus.LOCK not in periods.status[:-1]
    assert response.curve.mu_lock - 1e-3 < periods.low[-1] <= response.curve.mu_lock
    assert np.isnan([periods.mu0[-1], periods.deviation[-1], periods.high[-1]]).all()


@pytest.mark.parametrize("turn", ["0.55", "0.9"])
def test_pulled_back_from_past_the_lock_a_tip_slips_and_tells_its_friction(turn):
    # Until it is let go its moment turns back at x0 = 0.56 at the latest: 0.9 is past that, where
    # a rod that may leave its plane has buckled laterally.
    response = respond(2.0, 0.85, section="planar")
    surface = surfaces.patches([0.0, 0.75], [0.3, 0.8])
    truth, periods, last = measured_over(response, surface, (turn, "0.1"), section="planar")
    assert len(periods.status) == truth.period[-1]
    assert PeriodStatus.LOCK not in periods.status
    ok = known(periods)
    assert (truth.mu0[last][ok] == 0.8).any()
    error = (periods.mu0 - truth.mu0[last])[ok]
    assert np.abs(error / periods.deviation[ok]).max() < 4.5


def test_a_scan_that_ends_while_the_tip_sticks_gives_a_bound(response):
    truth, periods, _ = measured_over(response, surfaces.constant(0.4), ("0.44",))
    assert periods.status[-1] == PeriodStatus.OPEN
    needed = response.demand(truth.x0[-1])
    assert needed - 0.01 < periods.low[-1] < needed


@pytest.mark.slow
def test_another_rod_is_refused(response):
    _, recording = recorded(response, turns=("0.4",))
    with pytest.raises(ValueError, match="no state of this rod"):
        found_in(recording, theta=3.0)


@pytest.mark.slow
def test_what_the_tolerances_allow_is_fitted_not_refused(response):
    _, recording = recorded(response, turns=("0.4",))
    stiffer = replace(recording, readings=1.3 * recording.readings)
    with pytest.raises(ValueError, match="no state of this rod"):
        found_in(stiffer, 1.3 * NOISE, tolerances={"modulus": 0.05})
    found = found_in(stiffer, 1.3 * NOISE, tolerances={"modulus": 0.15})
    expected = found_in(recording)
    assert found.mu0 == pytest.approx(expected.mu0, rel=1e-3, nan_ok=True)
    assert found.doubt.tolist() == expected.doubt.tolist()


def test_noiseless_readings_need_a_noise(response):
    still = recording_of(np.arange(5.0) / 1e3, np.tile([-0.1, -1.2, -0.4], (5, 1)))
    with pytest.raises(ValueError, match="noise"):
        found_in(still, None)


HEADER = "time [s],footpoint [mm],force_x [N],force_y [N],moment_z [N*mm]\n"
GOOD = "0,0,-0.01,-1.2,-50\n1,0.1,-0.02,-1.2,-49\n2,0.2,-0.03,-1.2,-48\n"


def read(tmp_path, text):
    file = tmp_path / "r.csv"
    file.write_text(text)
    return read_recording(table_of(file, Method.MODEL), Units(ROD), Method.MODEL, SENSOR)


def test_recording_is_converted(tmp_path):
    recording = read(tmp_path, HEADER + GOOD)
    assert recording.clamp == pytest.approx([0, 0.001, 0.002])
    assert recording.readings[0] == pytest.approx(np.array([-0.01, -1.2, -0.05]) / SCALE)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (HEADER + "0,0,1,1,1\n0,1,1,1,1\n", "line 3: time does not increase"),
        (HEADER + "0,0,1,1,1\n,1,1,1,1\n0,2,1,1,1\n", "line 4: time does not increase"),
        ("footpoint [N],force_x [N],force_y [N]\n0,1,1\n", "footpoint must be a length"),
    ],
)
def test_bad_recordings_are_refused_with_their_line(tmp_path, text, message):
    with pytest.raises(ValueError, match=message):
        read(tmp_path, text)


CELLS = st.sampled_from(["0", "0.1", "-1.2", "", "nan", "1e400", "x", "-50", "12", "1e-300"])


@pytest.mark.slow
@given(st.lists(st.lists(CELLS, min_size=4, max_size=6), max_size=12), st.sampled_from(Method))
def test_any_recording_is_identified_or_refused_as_a_value_error(tmp_path_factory, rows, method):
    file: Path = tmp_path_factory.mktemp("fuzz") / "r.csv"
    file.write_text(HEADER.partition(",")[2] + "".join(",".join(row) + "\n" for row in rows))
    try:
        recording = read_recording(table_of(file, method), Units(ROD), method, SENSOR)
        periods = identified(FUZZED, recording, noise=NOISE, assume=False).periods
    except ValueError as error:
        assert str(error)
    else:
        assert (periods.low <= periods.high)[known(periods)].all()


FUZZED = Whisker(theta=2.0, eta=0.85)


@pytest.mark.slow
def test_slips_hidden_in_noise_give_no_bound():
    whisker = Setup.read(
        theta=2, eta="85 mm", modulus="210 GPa", diameter="1 mm", length="100 mm"
    ).whisker
    signals = scan(whisker, surfaces.constant(0.3), step="50 um", to=["20 mm"], law="kinetic")
    asked = {"noise": "500 mN, 500 mN, 30 N*mm", "assume": False}
    found = identified(whisker, signals.to_pandas(), **asked).periods
    # Nothing that was seen says that friction is above 0.3.
    assert found.status.tolist() == [PeriodStatus.BEYOND]
    assert np.isnan(found.low).all() and np.isnan(found.mu0).all()


@pytest.mark.parametrize(
    "mounting",
    [
        pytest.param({"clamp_angle": "2 deg"}, marks=pytest.mark.slow),
        pytest.param({"clamp_compliance": "0.1 rad/(N*m)"}, marks=pytest.mark.slow),
        pytest.param({"curvature": "-1 m^-1"}, marks=pytest.mark.slow),
        {"curvature": -0.1},
        pytest.param({"stage_angle": "2 deg", "clamp_angle": "2 deg"}, marks=pytest.mark.slow),
    ],
    ids=str,
)
def test_friction_comes_back_in_any_mounting(mounting):
    rod = {"modulus": "210 GPa", "diameter": "1 mm", "length": "100 mm"}
    whisker = Setup.read(theta=2.0, eta="85 mm", **rod, **mounting).whisker
    signals = scan(whisker, surfaces.constant(0.3), step="20 um", to=["6 mm"])
    truth = signals.truth
    recording = recording_of(truth.clamp, truth.reactions)
    found = identified(whisker, recording, noise="10 uN, 10 uN, 1 uN*m", assume=False)
    known = found.periods.status == PeriodStatus.SLIP
    assert known.sum() == truth.period[-1] - 1 >= 1
    error = np.abs(found.periods.mu0[known] - 0.3)
    assert error.max() < 3e-3
    # Without noise the distribution is uniform within the step.
    assert (error < 1.05 * np.sqrt(3.0) * found.periods.deviation[known]).all()
    assert found.columns()["contact"].values == pytest.approx(
        0.1 * truth.contact[found.periods.last], abs=1e-7
    )
