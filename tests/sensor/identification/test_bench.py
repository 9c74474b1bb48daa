"""Where laboratories err: recordings of a bench that shares no code with the package."""

import numpy as np
import pandas as pd
import pytest

from validation.sensor.bench import Bench, Friction, scan
from validation.sensor.laboratory import NOISE, STEP, believed, in_words, read, recorded
from validation.sensor.laboratory_rows import ROWS, Said
from validation.sensor.mistakes import LENGTH, UNITS
from vibrissa.outcomes import Method
from vibrissa.sensor import PeriodStatus, Setup, identify
from vibrissa.sensor.identification import search

TITLES = {row.title: row for row in ROWS}
NAMES = ("force_x [N]", "force_y [N]", "moment_z [N*m]")


def seen(found, truth):
    """Errors of the frictions, and which intervals hold the truth."""
    periods = found.periods
    known = periods.status == PeriodStatus.SLIP
    mu0 = truth.mu0[periods.last[known]]
    return (periods.mu0[known] - mu0), (periods.low[known] <= mu0) & (mu0 <= periods.high[known])


def frame_of(truth, readings=None, interval=0.01):
    """A table as a laboratory has it."""
    readings = truth.readings if readings is None else readings
    time = interval * np.arange(len(truth.stage))
    columns = {"time [s]": time, "footpoint [mm]": truth.stage * LENGTH * 1e3}
    return pd.DataFrame(columns | dict(zip(NAMES, (readings * UNITS).T, strict=True)))


@pytest.mark.slow
@pytest.mark.parametrize("title", ["E falls by 1 % per decade of time", "E 5 % off"])
def test_what_has_a_tolerance_is_fitted(title):
    row = TITLES[title]
    frame, truth = recorded(row, Said.ENOUGH, 1)
    found = read(frame, row, Said.ENOUGH, Method.MODEL)
    error, hold = seen(found, truth)
    assert set(found.periods.doubt) == {""} and hold.mean() > 0.8
    assert np.abs(error).mean() < 1e-3


@pytest.mark.slow
def test_a_tare_that_was_forgotten_is_not_silent_without_a_rod():
    row = TITLES["channels not tared, 60 mN, no rod"]
    frame, truth = recorded(row, Said.NOTHING, 1)
    found = read(frame, row, Said.NOTHING, Method.RATIO)
    assert not seen(found, truth)[1].any()
    assert set(found.periods.grade) == {"doubtful"}
    assert "the zeros of the forces are not checked" in found.periods.doubt[0]
    tolerances = dict.fromkeys(("zero_force_x", "zero_force_y"), "2 mN")
    told = identify(Setup.read(noise=in_words(NOISE * UNITS), tolerances=tolerances), frame)
    assert set(told.periods.doubt) == {""}


def test_rows_without_load_check_the_tare():
    frame, _ = recorded(TITLES["nothing"], Said.NOTHING, 1)
    air = frame.iloc[:30].copy()
    air[list(NAMES)] = np.random.default_rng(1).normal(size=(30, 3)) * NOISE * UNITS
    # The zero drifts from the middle of these rows to the first row of the scan.
    for parts, way in (([air, frame], 0.0), ([frame, air], 1.0)):
        found = identify(Setup.read(noise=in_words(NOISE * UNITS)), pd.concat(parts))
        assert set(found.periods.doubt) == {""}
        assert any("nothing touches the surface" in note for note in found.periods.notes)
        known = {one.parameter.name: one.parameter for one in found.estimates}
        zero, drift = known["zero_force_x"], known["drift_force_x"].deviation
        variance = (NOISE * UNITS)[0] ** 2 / 30 + (way + 15 / len(frame)) * drift**2
        assert zero.stated
        sizes = dict.fromkeys(("zero_force_x", "zero_force_y"), "2 mN")
        setup = Setup.read(noise=in_words(NOISE * UNITS), tolerances=sizes)
        forces = pd.concat(parts).drop(columns=NAMES[2])
        assert not any("are the means" in one for one in identify(setup, forces).periods.notes)
        assert zero.deviation == pytest.approx(np.sqrt(variance), rel=1e-3)


@pytest.mark.slow
def test_a_fit_that_fails_keeps_the_tolerances(monkeypatch):
    frame, truth = recorded(TITLES["clamp inclined by 2°"], Said.NOTHING, 1)
    monkeypatch.setattr(search, "MOST_STEPS", 1)
    found = identify(believed(noise=in_words(NOISE)), frame)
    error, hold = seen(found, truth)
    assert hold.all() and np.abs(error).mean() > 1e-3
    assert np.abs(error.mean()) < 2.0 * found.summary().deviation
    assert "too far from the given set-up to be fitted" in found.periods.doubt[0]


def filtered(readings, constant):
    """Readings behind a low-pass filter of first order, in equilibrium at the start."""
    found = readings.copy()
    for row in range(1, len(found)):
        found[row] = found[row - 1] + (readings[row] - found[row - 1]) / constant
    return found


@pytest.mark.slow
@pytest.mark.parametrize(
    ("state", "units"), [(believed, 1.0), (Setup.read, UNITS)], ids=["rod", "no rod"]
)
def test_a_delay_that_is_told_helps_both_readings(state, units):
    """A filter y += (x − y)/4 lags by 3 samples of 10 ms."""
    bench = Bench(friction=Friction(mean=0.3, wave=0.02))
    truth = scan(bench, STEP / 2.0, [0.2], np.zeros(3), 3)
    readings = filtered(truth.readings, 4.0)
    readings += np.random.default_rng(1).normal(size=readings.shape) * NOISE
    setup, errors = state(noise=in_words(NOISE * units), assume=False), {}
    for delay in (None, "30 ms"):
        found = identify(setup, frame_of(truth, readings), slip_time="160 ms", delay=delay)
        errors[delay], hold = seen(found, truth)
    # Of slips that take a while the onset is known to two steps.
    assert np.abs(errors["30 ms"].mean()) < 3e-4 < 1e-3 < np.abs(errors[None].mean())
    assert hold.mean() > 0.8
