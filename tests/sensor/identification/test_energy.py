"""Friction from slips by the energy law: each relation against scans, and what is read of a run."""

import numpy as np
import pytest

from steel import recording_of
from vibrissa.sensor import surfaces
from vibrissa.sensor.identification.calibration import known_setup
from vibrissa.sensor.identification.friction import PeriodStatus, find_periods
from vibrissa.sensor.identification.reading.energy import (
    EnergySlips,
    _averages,
    read_travels,
)
from vibrissa.sensor.identification.reading.kinetic import KineticRatio, sharing_ratio
from vibrissa.sensor.identification.recording import Method
from vibrissa.sensor.response.branch import respond
from vibrissa.sensor.simulation.scanning import path, simulate
from vibrissa.sensor.simulation.slips import SlipLaw

RESPONSE = respond(2.0, 0.85)
QUIET = np.array([1e-5, 1e-5, 1e-5])


def scanned(seed, stop="1", ratio=0.8):
    surface = surfaces.random(seed, 0.3, 0.04, 0.02)
    return simulate(RESPONSE, surface, path("0.0005", [stop]), SlipLaw.ENERGY, ratio)


def by_spacing(truth, ratio, law="energy", setup=None):
    recording = recording_of(truth.clamp, truth.reactions)
    asked = {"method": Method.SPACING, "law": law, "kinetic_ratio": ratio}
    return find_periods(setup or known_setup(RESPONSE), recording, QUIET, **asked)


def runs(truth):
    """First and last rows of the whole periods."""
    begins = np.flatnonzero(np.diff(truth.period)) + 1
    return begins[:-1], begins[1:] - 1


@pytest.mark.parametrize("ratio", [0.7, 0.9])
def test_rest_is_where_a_scan_says(ratio):
    slips = EnergySlips(RESPONSE, ratio)
    for mu0 in (0.15, 0.3, 0.4):
        truth = simulate(
            RESPONSE, surfaces.constant(mu0), path("0.0005", ["0.3"]), SlipLaw.ENERGY, ratio
        )
        begins, ends = runs(truth)
        start = truth.x0[ends] + 0.0005
        found = slips.rest(start[:-1], np.full(len(start) - 1, mu0))
        assert found == pytest.approx(truth.x0[begins[1:]], abs=1e-6)
        assert slips.onset(np.array([mu0])) == pytest.approx(RESPONSE.curve.onset([mu0]), abs=1e-6)


def test_linear_travels_are_those_of_the_relations():
    slips, generator = EnergySlips(RESPONSE, 0.8), np.random.default_rng(1)
    mu0, way = generator.uniform(0.25, 0.35, 6), generator.uniform(0.25, 0.35, 5)
    gap = np.full(6, 0.0005)
    linear = slips.linearised(mu0, way, gap)
    moved = generator.uniform(-1e-4, 1e-4, 11)
    other = slips.linearised(mu0 + moved[:6], way + moved[6:], gap)
    assert other.travel - linear.travel == pytest.approx(linear.slopes @ moved, abs=1e-6)
    assert (np.linalg.eigvalsh(linear.errors) > 0.0).all()


def drawn_travels(slips, mu0, way, gap):
    """Travels whose onsets are anywhere within their steps, of many runs."""
    onset = slips.onset(mu0) + gap * np.random.default_rng(2).random((10_000, len(gap)))
    rest = [slips.rest(onset[:, i], np.full(len(onset), way[i])) for i in range(len(way))]
    return onset[:, 1:] - gap[1:] - np.transpose(rest)


def test_errors_of_travels_are_those_of_onsets_within_a_step():
    """An onset late in its step makes its period longer; its slip is longer, and so is the next."""
    slips = EnergySlips(RESPONSE, 0.8)
    mu0, way = np.array([0.25, 0.3, 0.35, 0.3]), np.array([0.28, 0.33, 0.31])
    gap = np.array([0.001, 0.003, 0.0015, 0.002])
    travels = drawn_travels(slips, mu0, way, gap)
    linear = slips.linearised(mu0, way, gap)
    unit = gap.max() ** 2 / 12.0
    assert travels.mean(axis=0) == pytest.approx(linear.travel, abs=0.02 * gap.max())
    assert np.cov(travels.T) / unit == pytest.approx(linear.errors / unit, abs=0.05)
    assert np.abs(linear.errors[0, 1]) > 0.3 * unit


def test_the_friction_of_a_slip_is_that_on_its_way_weighted_by_the_normal_force():
    """On a surface whose friction rises evenly it is that at the mean place of the work."""
    slips = EnergySlips(RESPONSE, 0.7)
    place, gap = np.array([0.43, 0.48, 0.55]), np.array([0.0005, 0.005, 0.001])
    mu0, way = np.array([0.2, 0.4, 0.3]), np.array([0.25, 0.35])
    points, parts = _averages(slips, place, np.append(mu0, way), gap)
    assert parts[:3] @ points == pytest.approx(place) and parts.sum(axis=1) == pytest.approx(1.0)
    start = slips.onset(mu0[:2]) + 0.5 * gap[:2]
    rest = slips.rest(start, way)
    for i, mean in enumerate(parts[3:] @ points):
        x0 = np.linspace(start[i], rest[i], 2001)
        normal = np.abs(RESPONSE(x0)[:, 1])
        at = np.linspace(place[i], place[i + 1], 2001)
        expected = np.trapezoid(normal * at, x0) / np.trapezoid(normal, x0)
        assert mean == pytest.approx(expected, abs=1e-4 * (place[i + 1] - place[i]))


def even_run(ratio, mu0, gap):
    """Travels on one friction, whose onsets are in the middle of their steps, and the contacts."""
    slips, mu0 = EnergySlips(RESPONSE, ratio), np.full(len(gap), mu0)
    onset, before = slips.onset(mu0), np.append(gap[0], gap[:-1])
    travel = onset - 0.5 * gap - slips.rest(onset + 0.5 * before, mu0)
    return travel, gap, 0.43 + np.cumsum(travel + gap)


def test_one_friction_is_read_with_the_step_at_the_end_of_each_period():
    travel, gap, place = even_run(0.8, 0.3, np.array([0.0005, 0.0006, 0.0007, 0.02]))
    mean, deviation = read_travels(RESPONSE, 0.8, travel, gap, place)
    assert mean == pytest.approx(0.3, abs=1e-3)
    even, gap, place = even_run(0.8, 0.3, np.full(4, 0.0005))
    _, deviation = read_travels(RESPONSE, 0.8, even, gap, place)
    # A travel goes from one onset within a step to another, and so has the errors of two.
    onsets = EnergySlips(RESPONSE, 0.8).onset(np.array([0.299, 0.301]))
    alone = 0.0005 / np.sqrt(12.0) * 0.002 / np.diff(onsets)
    assert (alone < deviation).all() and (deviation < 2.0 * alone).all()


@pytest.mark.parametrize(
    "gap", [np.array([0.0005, 0.02, 0.0005, 0.02]), np.tile([0.0005, 0.0014], 12)]
)
def test_one_friction_is_read_with_steps_that_are_very_different(gap):
    """The step that ends a period enters its travel and the next one, whatever the others are."""
    mean, deviation = read_travels(RESPONSE, 0.8, *even_run(0.8, 0.3, gap))
    assert mean == pytest.approx(0.3, abs=1e-3)
    # If it were known to be one friction, least squares of all travels would tell it best.
    mu0 = np.full(len(gap), 0.3)
    errors = np.cov(drawn_travels(EnergySlips(RESPONSE, 0.8), mu0, mu0[1:], gap).T)
    less, more = (even_run(0.8, one, gap)[0][1:] for one in (0.299, 0.301))
    slopes = (more - less) / 0.002
    best = 1.0 / np.sqrt(slopes @ np.linalg.solve(errors, slopes))
    assert (best < deviation).all() and (deviation < 2.0 * best).all()


def test_a_tip_that_rests_pulled_with_nearly_all_its_friction_tells_none():
    mean, deviation = read_travels(RESPONSE, 0.05, *even_run(0.05, 0.3, np.full(4, 0.0005)))
    assert np.isnan(mean).all() and np.isnan(deviation).all()


def test_after_a_long_step_alone_a_tip_may_rest_pulled_with_nearly_all_its_friction():
    gap = np.array([0.0005, 0.0005, 0.02, 0.0005, 0.0005])
    mean, _ = read_travels(RESPONSE, 0.6, *even_run(0.6, 0.3, gap))
    assert np.isnan(mean).tolist() == [False, False, True, True, True]
    mean, _ = read_travels(RESPONSE, 0.6, *even_run(0.6, 0.3, np.full(5, 0.0005)))
    assert np.isfinite(mean).all()


@pytest.mark.slow
def test_the_surface_is_read_between_the_travels():
    truth = scanned(3)
    begins, ends = runs(truth)
    clamp = truth.clamp
    travel, gap = clamp[ends] - clamp[begins], np.full(len(ends), 0.0005)
    mean, deviation = read_travels(RESPONSE, 0.8, travel, gap, truth.contact[ends])
    error = mean - truth.mu0[ends]
    assert np.median(np.abs(error)) < 0.01 < 0.5 * truth.mu0[ends].std()
    assert 0.8 < np.mean(np.abs(error) < 1.96 * deviation) <= 1.0


@pytest.mark.slow
def test_intervals_cover_what_they_say():
    inside = []
    for seed in range(100, 106):
        truth = scanned(seed)
        periods = by_spacing(truth, 0.8)
        mu0, ok = truth.mu0[periods.last], periods.status == PeriodStatus.SLIP
        inside += list(((periods.low <= mu0) & (mu0 <= periods.high))[ok])
    assert len(inside) > 250
    assert 0.93 <= np.mean(inside) <= 0.97


@pytest.mark.slow
def test_slips_that_may_have_gone_back_tell_nothing():
    # From 0.4 with kinetic friction of half of that a tip rests pulled, or slips back.
    truth = simulate(RESPONSE, surfaces.constant(0.4), path("0.0005", ["2"]), SlipLaw.ENERGY, 0.5)
    begins, ends = runs(truth)
    travel = truth.clamp[ends] - truth.clamp[begins]
    gap = np.full(len(ends), 0.0005)
    mean, deviation = read_travels(RESPONSE, 0.5, travel, gap, truth.contact[ends])
    assert np.isnan(mean).any() and (np.isnan(mean) == np.isnan(deviation)).all()


@pytest.mark.slow
def test_beside_a_slip_that_may_have_gone_back_nothing_is_told_on_either_side():
    surface = surfaces.random(2, 0.36, 0.03, 0.05)
    truth = simulate(RESPONSE, surface, path("0.002", ["1"]), SlipLaw.ENERGY, 0.5)
    begins, ends = runs(truth)
    travel, gap = truth.clamp[ends] - truth.clamp[begins], np.full(len(ends), 0.002)
    mean, deviation = read_travels(RESPONSE, 0.5, travel, gap, truth.contact[ends])
    told = [*range(4), len(ends) - 1]
    assert np.flatnonzero(np.isfinite(mean)).tolist() == told
    assert (np.isnan(mean) == np.isnan(deviation)).all()


def test_few_periods_give_bounds():
    truth = scanned(3, "0.2")
    status = by_spacing(truth, 0.8).status
    assert PeriodStatus.UNSURE in status and PeriodStatus.SLIP not in status
    with pytest.raises(ValueError, match=r"a kinetic ratio .* got none"):
        by_spacing(truth, None)


@pytest.mark.parametrize(("law", "noted"), [("kinetic", 1), ("energy", 0)])
def test_states_after_slips_by_energy_do_not_tell_the_ratio_of_the_frictions(law, noted):
    """The friction on the whole way of such a slip counts, so that nothing is said about it."""
    truth = simulate(RESPONSE, surfaces.constant(0.3), path("0.0005", ["0.2"]), law, 0.8)
    setup = sharing_ratio(known_setup(RESPONSE), KineticRatio(value=0.8, deviation=0.15))
    notes = by_spacing(truth, 0.8, law, setup).notes
    assert sum("closer than the 0.8 ± 0.15 that was given" in note for note in notes) == noted


def test_travels_that_no_surface_has_are_not_read():
    travel = np.random.default_rng(0).uniform(0.0, 0.2, 30)
    mean, deviation = read_travels(RESPONSE, 0.8, travel, np.full(30, 0.0005), np.zeros(30))
    assert np.isnan(mean).all() and np.isnan(deviation).all()
