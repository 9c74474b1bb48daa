"""What real recordings have beside a scan: friction comes out right with it."""

import numpy as np
import pandas as pd
import pytest

from steel import NOISE, ROD, SENSOR
from vibrissa.sensor import Whisker, identify, scan, surfaces
from vibrissa.sensor.ends import moving, touching
from vibrissa.sensor.identification import recording as recording_module
from vibrissa.sensor.identification.hum import hum_of

MU0 = 0.3
NAMES = ("force_x [N]", "force_y [N]", "moment_z [N*m]")


@pytest.fixture(scope="module")
def whisker():
    return Whisker(theta=2.0, eta=0.85, rod=ROD)


@pytest.fixture(scope="module")
def signals(whisker):
    """Loads of a scan at 1 mm/s, 1,000 samples in a second."""
    law = {"law": "kinetic", "kinetic_ratio": 0.7}
    return scan(whisker, surfaces.constant(MU0), step="1 um", to=["8 mm"], **law)


def frame_of(clamp, loads, seed=1, rate=1000.0, noise=True):
    """A recording with the noise of the transducer."""
    readings = loads
    if noise:
        rng = np.random.default_rng(seed)
        readings = loads + rng.standard_normal(loads.shape) * SENSOR.deviation
    columns = {"time [s]": np.arange(len(clamp)) / rate, "footpoint [m]": clamp}
    return pd.DataFrame(columns | dict(zip(NAMES, readings.T, strict=True)))


def clamp_of(signals):
    return signals.truth.clamp * ROD.length


def found_in(whisker, frame, method="moment", **options):
    periods = identify(whisker, frame, method=method, noise=NOISE, **options).periods
    return periods, periods.take(periods.status == "slip")


def right(slips, least=4):
    """Whether every friction is within its errors, and the intervals are no wider than needed."""
    errors = (slips.mu0 - MU0) / slips.deviation
    return (
        len(slips) >= least
        and np.abs(errors).max() < 4.5
        and slips.deviation.max() < 5e-3
        and not any(slips.doubt)
    )


# --- Rest and lift-off ---


def with_ends(signals):
    """Lowered in half a second, a rest, the scan, a rest, lifted off; with jitter."""
    loads, clamp = signals.readings, clamp_of(signals)
    ramp = np.linspace(0.0, 1.0, 500)[:, None]
    rest = np.ones((1000, 1))
    parts = [ramp * 0 * loads[0], ramp * loads[0], rest * loads[0], loads, rest * loads[-1]]
    parts += [ramp[::-1] * loads[-1], ramp * 0 * loads[0]]
    whole = np.concatenate(parts)
    before = sum(len(part) for part in parts[:3])
    clamp = np.pad(clamp, (before, len(whole) - before - len(clamp)), mode="edge")
    return clamp + np.random.default_rng(3).uniform(-1e-7, 1e-7, len(clamp)), whole, before


def test_rest_and_lift_off_are_recognised_and_named(whisker, signals):
    clamp, loads, before = with_ends(signals)
    periods, slips = found_in(whisker, frame_of(clamp, loads))
    assert right(slips)
    assert periods.first_line[0] == pytest.approx(before + 1, abs=30)
    said = " ".join(periods.notes)
    assert "nothing touches the surface" in said and "the clamp rests" in said


def test_without_it_the_recording_is_refused_or_in_doubt(whisker, signals, monkeypatch):
    clamp, loads, _ = with_ends(signals)
    monkeypatch.setattr(recording_module, "_scanned", lambda recording, used: recording)
    try:
        _, slips = found_in(whisker, frame_of(clamp, loads))
    except ValueError as error:
        assert "no state of this rod" in str(error)
    else:
        assert not right(slips)


def test_ends_of_a_scan_are_not_cut():
    steps = np.arange(300) * 0.5
    assert moving(steps) == slice(0, 300)
    assert moving(np.repeat(steps, 3)) == slice(0, 900)
    assert moving(np.concatenate([steps, steps[::-1]])) == slice(0, 600)
    loads = np.stack([np.sin(steps), np.full(300, -1.0)], axis=1)
    assert touching(loads) == slice(0, 300)
    assert touching(np.zeros((5, 2))) == slice(0, 5)


def test_a_rest_is_cut_to_the_sample():
    clamp = np.concatenate([np.zeros(25), np.arange(1, 200), np.full(40, 199.0)])
    assert moving(clamp) == slice(24, 25 + 199)
    loads = np.concatenate([np.zeros((20, 3)), np.ones((50, 3)), np.zeros((30, 3))])
    assert touching(loads) == slice(20, 70)


# --- Hum ---


def hum(size, frequency, phases=(0.3, 1.1, 2.0)):
    """Hum in all channels, of so many standard deviations of noise."""
    time = np.arange(size) / 1000.0
    amplitude = 8.0 * np.array(SENSOR.deviation)
    angle = 2 * np.pi * frequency * time[:, None] + np.array(phases)
    return amplitude * np.cos(angle)


@pytest.mark.parametrize("frequency", [50.0, 49.93, 60.05])
@pytest.mark.parametrize("method", ["forces", "moment"])
def test_hum_is_found_and_taken_off(whisker, signals, frequency, method):
    loads = signals.readings + hum(len(signals.readings), frequency)
    periods, slips = found_in(whisker, frame_of(clamp_of(signals), loads), method)
    assert right(slips)
    (note,) = [note for note in periods.notes if note.startswith("hum of")]
    told = float(note.split()[2])
    assert told == pytest.approx(frequency, abs=0.02)
    assert "in force_x" in note and "in moment_z" in note


@pytest.mark.parametrize("method", ["forces", "moment"])
def test_hum_that_is_not_taken_off_spoils_friction(whisker, signals, method, monkeypatch):
    monkeypatch.setattr(recording_module, "hum_of", lambda *_: None)
    loads = signals.readings + hum(len(signals.readings), 50.0)
    try:
        _, slips = found_in(whisker, frame_of(clamp_of(signals), loads), method)
    except ValueError as error:
        assert "no state of this rod" in str(error)
    else:
        assert not right(slips)


def test_its_amplitude_and_phase_are_those_that_were_put_in(signals):
    size, rng = len(signals.readings), np.random.default_rng(4)
    noise = rng.standard_normal((size, 3)) * SENSOR.deviation
    wave = hum(size, 50.07)
    found = hum_of(signals.readings + noise + wave, np.arange(size) / 1e3, clamp_of(signals))
    error = (found.signal - wave) / SENSOR.deviation
    # Two parameters and the frequency out of 8,000 readings.
    assert np.sqrt(np.mean(error**2, axis=0)).max() < 0.1
    assert found.frequency == pytest.approx(50.07, abs=0.01)


@pytest.mark.parametrize("rate", [50.0, 100.0, 137.0, 1000.0, 20000.0])
def test_no_hum_is_seen_where_there_is_none(signals, rate):
    rng = np.random.default_rng(int(rate))
    readings = signals.readings + rng.standard_normal(signals.readings.shape) * SENSOR.deviation
    assert hum_of(readings, np.arange(len(readings)) / rate, clamp_of(signals)) is None


def test_steps_of_a_stage_are_no_hum():
    time = np.arange(8000) / 1000.0
    clamp = np.floor(time * 50.0 + 1e-9)
    loads = np.stack([clamp, -clamp, clamp], axis=1) * 1e-2
    loads += np.random.default_rng(1).standard_normal(loads.shape) * 1e-3
    assert hum_of(loads, time, clamp) is None
    assert hum_of(loads, time, time) is not None


def test_time_without_a_unit_does_not_tell_a_frequency(whisker, signals):
    frame = frame_of(clamp_of(signals), signals.readings).rename(columns={"time [s]": "time"})
    assert right(found_in(whisker, frame)[1])
