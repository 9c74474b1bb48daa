"""The slope of the surface: what it does to friction, and how it adds up in a mean."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson

from responses import respond
from steel import NOISE, identified, measured, recording_of
from validation.sensor import laboratory
from validation.sensor.bench import scan
from validation.sensor.laboratory import recorded
from validation.sensor.laboratory_rows import ROWS, Said
from validation.sensor.mistakes import bench_of
from vibrissa.mechanics.rod import Rod
from vibrissa.outcomes import Method
from vibrissa.scanning import surfaces
from vibrissa.scanning.simulation import simulate
from vibrissa.scanning.stage import path
from vibrissa.sensor import Whisker, identify
from vibrissa.sensor.identification import fitted_set_up
from vibrissa.sensor.identification.slope import Slope

GIVEN = {"theta": 2.0, "eta": 0.85}
SLOPE = Slope(deviation=np.deg2rad(1.0), length=0.05)


@pytest.fixture(scope="module")
def recording():
    truth = simulate(respond(**GIVEN), surfaces.random(1, 0.3, 0.02, 0.05), path("0.0005", ["0.3"]))
    return recording_of(truth.clamp, measured(truth.reactions, 1))


def read(recording, method, slope):
    asked = {"method": method, "noise": NOISE, "assume": False}
    asked["tolerances"] = {"surface_slope": f"{slope} rad"}
    return identified(Whisker(**GIVEN), recording, **asked)


def test_a_slope_turns_the_ratio_of_the_forces():
    mu0, delta = 0.3, 1e-4
    turned = np.tan(np.arctan(mu0) + delta) - mu0
    found = Slope(deviation=delta).errors(np.array([mu0]))
    assert found[0] == pytest.approx(turned, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["model", "ratio"])
def test_it_widens_every_interval_and_the_mean_by_what_neighbours_share(recording, method):
    level, found = read(recording, method, 0.0), read(recording, method, SLOPE.deviation)
    known = np.isfinite(found.periods.mu0)
    error = SLOPE.errors(found.periods.mu0[known])
    expected = np.hypot(level.periods.deviation[known], error)
    if method == "ratio":
        assert found.periods.mu0 == pytest.approx(level.periods.mu0, nan_ok=True)
        assert found.periods.deviation[known] == pytest.approx(expected)
    else:
        # The model adjusts the height of each tip, too: by noise alone.
        apart = (found.periods.mu0 - level.periods.mu0)[known]
        more = found.periods.deviation[known] ** 2 - expected**2
        assert (more > 0.0).all() and np.sqrt(more).max() < 0.05 * SLOPE.deviation
        assert np.abs(apart).max() < 4.0 * np.sqrt(more.max())
    wide = (found.periods.high - found.periods.low)[known]
    assert wide == pytest.approx(2.0 * 1.96 * expected, rel=0.1)
    # What is only bounded is bounded less, too.
    bound = np.isfinite(found.periods.low) & ~known
    assert (found.periods.low < level.periods.low)[bound].all()
    one, other = level.summary(), found.summary()
    assert other.random > one.random + SLOPE.deviation / np.sqrt(known.sum())
    assert min(other.if_exact, key=other.if_exact.get) == "surface_slope"


@pytest.mark.slow
def test_only_some_heights_of_many_periods_are_compared(recording, monkeypatch):
    every, level = (read(recording, "model", slope) for slope in (SLOPE.deviation, 0.0))
    # Of each period the height of the surface is fitted, too.
    assert every.goodness.degrees == level.goodness.degrees - len(every.periods)
    monkeypatch.setattr(fitted_set_up, "MOST_HEIGHTS", 3)
    some = read(recording, "model", SLOPE.deviation).goodness
    assert some.degrees == every.goodness.degrees
    assert some.chi2 == pytest.approx(every.goodness.chi2, rel=1e-3)


def test_its_length_is_5_mm_whatever_the_length_of_the_rod(recording):
    whisker = Whisker(**GIVEN, rod=Rod(2.1e11, 8e-4, 0.04))
    found = identified(whisker, recording, noise=NOISE, assume=False)
    assert found.slope.length * 0.04 == pytest.approx(5e-3)


def test_the_variance_of_a_mean_is_between_that_of_one_and_of_many():
    weights, level, place = np.full(1000, 1e-3), np.zeros(1000), np.linspace(0.0, 1.0, 1000)

    def found(length):
        return Slope(deviation=0.01, length=length).variance_of_mean(weights, level, place)

    assert found(1e9) == pytest.approx(1e-4)
    assert found(1e-9) == pytest.approx(1e-7)
    alike = np.exp(-0.5 * ((place[:, None] - place) / 0.05) ** 2)
    assert found(0.05) == pytest.approx(1e-4 * weights @ alike @ weights)


def test_heights_are_what_slopes_add_up_to():
    fine, length = np.linspace(0.0, 0.4, 401), SLOPE.length
    apart = np.exp(-0.5 * ((fine[:, None] - fine) / length) ** 2)
    slopes = SLOPE.deviation**2 * apart
    rises = cumulative_simpson(
        cumulative_simpson(slopes, x=fine, axis=0, initial=0), x=fine, axis=1, initial=0
    )
    some = np.array([0, 60, 240, 400])
    expected = rises[np.ix_(some, some)] + rises[-1, -1]
    assert SLOPE.heights(fine[some]) == pytest.approx(expected, rel=1e-6)


@pytest.mark.nightly
@pytest.mark.slow
def test_a_wave_of_more_slope_is_doubted_and_no_other_quantity_explains_it():
    bench = bench_of(1)
    bench = replace(bench, friction=replace(bench.friction, wave=0.0))
    bench = replace(bench, slope=np.deg2rad(1.8), slope_length=0.2, slope_phase=1.0)
    found = scan(bench, laboratory.STEP, [0.6], laboratory.NOISE, 1)
    stated = laboratory.believed(noise=laboratory.in_words(laboratory.NOISE))
    recording = recording_of(found.stage, found.readings)
    doubted = identify(stated, recording)
    assert "rises and falls by more than surface_slope allows" in str(doubted.summary())
    assert (doubted.periods.grade == "doubtful").all()
    # The wave is an error of no other quantity, such as a zero that drifts, and the rod fits.
    assert max(one.surprise for one in doubted.estimates) < 3.0
    assert doubted.goodness.chance > 1e-3
    stated = laboratory.believed(
        noise=laboratory.in_words(laboratory.NOISE), tolerances={"surface_slope": "1.8 deg"}
    )
    allowed = identify(stated, recording).periods
    known = allowed.status == "slip"
    mu0 = found.mu0[allowed.last[known]]
    inside = (allowed.low[known] <= mu0) & (mu0 <= allowed.high[known])
    assert set(allowed.doubt) == {""} and inside.mean() > 0.9


@pytest.mark.slow
@pytest.mark.parametrize("seed", [47000, pytest.param(47009, marks=pytest.mark.nightly)])
def test_a_surface_that_rises_and_falls_by_what_its_slope_allows_is_not_doubted(seed):
    (row,) = [row for row in ROWS if "surface_slope" in row.sizes]
    frame, _ = recorded(row, Said.ENOUGH, seed)
    for method in Method:
        found = laboratory.read(frame, row, Said.ENOUGH, method)
        assert set(found.periods.doubt) == {""}
    frame, _ = recorded(row, Said.LITTLE, seed)
    for method in Method:
        found = laboratory.read(frame, row, Said.LITTLE, method)
        assert (found.periods.grade == "doubtful").all()
        assert "rises and falls by more than surface_slope allows" in str(found.summary())
