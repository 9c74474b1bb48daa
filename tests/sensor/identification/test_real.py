"""What real recordings have beside a scan: friction comes out right with it."""

import numpy as np
import pandas as pd
import pytest
from scipy.signal import butter, sosfilt

from steel import ROD, SENSOR, identified
from vibrissa.quantities.units import Units
from vibrissa.scanning import surfaces
from vibrissa.sensor import Whisker, scan
from vibrissa.sensor.identification.ends import moving, touching

MU0 = 0.3
NAMES = ("force_x [N]", "force_y [N]", "moment_z [N*m]")
NOISE = np.array(SENSOR.deviation) / Units(ROD).channels


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


def found_in(whisker, frame, method="model", **options):
    found = identified(whisker, frame, method=method, noise=NOISE, assume=False, **options).periods
    return found, found.take(found.status == "slip")


def right(slips):
    """Whether every friction is within its errors, and the intervals are no wider than needed."""
    off = np.abs((slips.mu0 - MU0) / slips.deviation).max()
    return len(slips) >= 4 and off < 4.5 and slips.deviation.max() < 5e-3 and not any(slips.doubt)


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


@pytest.mark.slow
def test_rest_and_lift_off_are_recognised_and_named(whisker, signals):
    clamp, loads, before = with_ends(signals)
    periods, slips = found_in(whisker, frame_of(clamp, loads))
    assert right(slips)
    assert periods.first_line[0] == pytest.approx(before + 1, abs=30)
    said = " ".join(periods.notes)
    assert "nothing touches the surface" in said and "the clamp rests" in said


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


# --- Slips that take a while, and filters ---

# Of the fine scan so many samples become one.
EVERY = 10


@pytest.fixture(scope="module")
def fine(whisker):
    """Loads of a scan at 1 mm/s in steps of 1 um, of which every tenth is recorded."""
    law = {"law": "kinetic", "kinetic_ratio": 0.6}
    return scan(whisker, surfaces.random(3, MU0, 0.02, 0.05), step="1 um", to=["12.5 mm"], **law)


def in_flight(whisker, signals, rows=50):
    """Loads if a slip takes 50 ms: the contact goes from one place to the next."""
    truth = signals.truth
    place = truth.clamp - truth.x0
    part = np.arange(rows) / rows
    moved = place.copy()
    for slip in np.flatnonzero(np.diff(truth.period)) + 1:
        way = moved[slip : slip + rows]
        smooth = (part**2 * (3 - 2 * part))[: len(way)]
        way[:] = place[slip - 1] + (place[slip] - place[slip - 1]) * smooth
    return whisker.response.reactions(truth.clamp - moved) * whisker.units.channels


def filtered(signals, sections):
    """Loads behind a filter, in equilibrium at the start."""
    first = signals.readings[0]
    return first + sosfilt(sections, signals.readings - first, axis=0)


# A low-pass of first order with a time constant of 40 ms, and a Butterworth filter of 4 Hz: its
# delay is √2/(2π·4 Hz).
FIRST_ORDER = np.array([[1 - np.exp(-1 / 40), 0.0, 0.0, 1.0, -np.exp(-1 / 40), 0.0]])
BUTTERWORTH = butter(2, 2 * 0.004, output="sos")
SMEARED = {
    "flight": (None, {"slip_time": "60 ms"}),
    "first order": (FIRST_ORDER, {"slip_time": "200 ms", "delay": "40 ms"}),
    "Butterworth": (BUTTERWORTH, {"slip_time": "250 ms", "delay": "56.3 ms"}),
}


def smeared(whisker, fine, sections, seed):
    loads = in_flight(whisker, fine) if sections is None else filtered(fine, sections)
    rows = slice(seed % EVERY, None, EVERY)
    return frame_of(clamp_of(fine)[rows], loads[rows], seed, rate=1000.0 / EVERY)


def errors_of(slips, fine):
    contact, mu0 = fine.truth.contact, fine.truth.mu0
    return slips.mu0 - np.interp(slips.contact, contact, mu0)


@pytest.mark.slow
@pytest.mark.parametrize("case", SMEARED)
def test_friction_is_right_though_slips_are_smeared(whisker, fine, case):
    sections, told = SMEARED[case]
    inside, pulls = [], []
    for seed in (1, 5):
        frame = smeared(whisker, fine, sections, seed)
        _, slips = found_in(whisker, frame, **told)
        assert len(slips) == fine.truth.period[-1] - 1
        errors = errors_of(slips, fine)
        pulls += list(errors / slips.deviation)
        inside += list(np.abs(errors) < 2.5 * slips.deviation)
        assert slips.deviation.max() < 5e-3
    assert np.mean(inside) > 0.8 and np.abs(pulls).max() < 5.0


@pytest.mark.slow
def test_a_filter_that_is_not_told_is_not_silent(whisker, fine):
    periods, _ = found_in(whisker, smeared(whisker, fine, FIRST_ORDER, 1))
    assert set(periods.grade) <= {"doubtful", "wrong"}


@pytest.mark.slow
def test_slips_within_one_sample_stay_as_they_are(whisker, fine):
    frame = frame_of(clamp_of(fine)[::EVERY], fine.readings[::EVERY], 1, rate=100.0)
    periods, slips = found_in(whisker, frame)
    assert periods.notes == () and slips.deviation.max() < 1e-3


@pytest.mark.parametrize("told", [{"slip_time": "-1 ms"}, {"delay": "1 mm"}])
def test_times_that_are_none_are_refused(whisker, fine, told):
    with pytest.raises(ValueError, match=next(iter(told))):
        found_in(whisker, frame_of(clamp_of(fine)[::EVERY], fine.readings[::EVERY]), **told)


def test_times_need_the_time(whisker, fine):
    frame = frame_of(clamp_of(fine)[::EVERY], fine.readings[::EVERY]).drop(columns="time [s]")
    with pytest.raises(ValueError, match="delay needs a column 'time"):
        found_in(whisker, frame, delay="1 ms")
