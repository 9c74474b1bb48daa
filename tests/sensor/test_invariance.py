"""What holds of every scan and recording: its place, its units and the size of blocks are all one.

A recording is a function of where the clamp is relative to the surface. So nothing but positions
may change if both move, and nothing at all if numbers are given in other units or computed in
smaller blocks.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from responses import by_law, respond
from steel import NOISE, identified, recording_of
from vibrissa.mechanics.rod import Rod
from vibrissa.outcomes import SlipLaw
from vibrissa.scanning import surfaces, tip
from vibrissa.scanning.simulation import simulate
from vibrissa.scanning.stage import path
from vibrissa.sensor import Whisker, scan, solve
from vibrissa.sensor.identification import slope
from vibrissa.sensor.identification.recording import Method

RESPONSE = respond(2.0, 0.85)
STAGE = path("0.001", ["0.25", "0.1", "0.2"])
# Of a steel whisker that is read at the resolution of its transducer.
PLACES = ("contact", "footpoint")
few = settings(max_examples=3)


def moved(surface, by):
    """Move a surface along itself."""
    return replace(surface, mu0=lambda x: surface.mu0(x - by), edges=surface.edges + by)


def recorded(law=SlipLaw.FREE):
    truth = simulate(RESPONSE, surfaces.random(3, 0.3, 0.04, 0.02), STAGE, by_law(law))
    noise = np.random.default_rng(3).standard_normal(truth.reactions.shape) * NOISE
    return truth, recording_of(truth.clamp, truth.reactions + noise)


def found_in(recording):
    return identified(Whisker(theta=2.0, eta=0.85), recording, noise=NOISE, assume=False).periods


def same(one, other, shift=0.0):
    """Whether all that was found is equal, but for positions along the surface."""
    for name in ("mu0", "deviation", "low", "high", "common", "by_step"):
        assert getattr(one, name) == pytest.approx(
            getattr(other, name), rel=1e-6, abs=1e-9, nan_ok=True
        ), name
    for name in ("status", "first_line", "last_line", "grade", "doubt"):
        assert getattr(one, name).tolist() == getattr(other, name).tolist(), name
    for name in PLACES:
        assert getattr(one, name) == pytest.approx(
            getattr(other, name) + shift, abs=1e-9, nan_ok=True
        ), name


@pytest.mark.slow
@few
@given(by=st.floats(-3.0, 3.0), law=st.sampled_from(SlipLaw), start=st.floats(-0.3, 0.3))
def test_a_scan_moves_with_its_surface(by, law, start):
    surface = surfaces.patches([0.0, 0.5 + start, 0.6 + start], [0.25, 0.35, 0.3])
    one = simulate(RESPONSE, surface, STAGE, by_law(law))
    other = simulate(RESPONSE, moved(surface, by), STAGE + by, by_law(law))
    assert other.reactions == pytest.approx(one.reactions, abs=1e-7)
    assert other.contact - one.contact == pytest.approx(by, abs=1e-9)
    assert other.x0 == pytest.approx(one.x0, abs=1e-9)
    assert [*other.phase, *other.period] == [*one.phase, *one.period]


@pytest.mark.slow
@settings(max_examples=2)
@given(by=st.floats(-30.0, 30.0))
def test_friction_does_not_depend_on_where_the_stage_counts_from(by):
    _, recording = recorded()
    there = replace(recording, clamp=recording.clamp + by)
    same(found_in(there), found_in(recording), shift=by)


@pytest.mark.slow
def test_what_is_found_does_not_depend_on_the_size_of_blocks(monkeypatch):
    _, recording = recorded()
    whole = found_in(recording)
    monkeypatch.setattr(slope, "PERIODS_AT_ONCE", 3)
    same(found_in(recording), whole)


@pytest.mark.slow
@pytest.mark.parametrize(
    "law",
    [
        *(pytest.param(law, marks=pytest.mark.nightly) for law in ("free", "energy")),
        "kinetic",
        "damped",
    ],
)
def test_a_scan_does_not_depend_on_the_size_of_blocks(monkeypatch, law):
    whole, _ = recorded(law)
    monkeypatch.setattr(tip, "STEPS_AT_ONCE", 7)
    parts, _ = recorded(law)
    assert parts.reactions.tolist() == whole.reactions.tolist()
    assert parts.contact.tolist() == whole.contact.tolist()


rods = st.builds(Rod, st.floats(1e9, 4e11), st.floats(2e-4, 5e-3), st.floats(0.02, 0.5))


@pytest.mark.slow
@settings(max_examples=4)
@given(rod=rods, mu0=st.floats(0.1, 0.45))
def test_a_solution_is_the_same_in_all_units(rod, mu0):
    plain = solve(Whisker(theta=2.0, eta=0.85), mu0, 0.001).columns()
    found = solve(Whisker(theta=2.0, eta=0.85, rod=rod), mu0, 0.001).columns()
    units = {"L": rod.length, "E*I0/L^2": rod.force_unit, "E*I0/L": rod.moment_unit}
    assert any(column.unit in units for column in plain.values())
    for name, column in plain.items():
        if column.unit in units:
            value = units[column.unit] * np.asarray(column.values)
            assert found[name].values == pytest.approx(value, rel=1e-6), name
        elif column.unit == "1":
            assert found[name].values == pytest.approx(column.values, rel=1e-6), name


@pytest.mark.slow
@pytest.mark.parametrize("method", Method)
def test_a_recording_in_other_units_is_the_same_recording(method):
    """Units of a table are those of its titles: millinewtons and inches, say."""
    rod = Rod(2.1e11, 0.8e-3, 0.1)
    whisker = Whisker(theta=2.0, eta=0.85, rod=rod)
    signals = scan(whisker, surfaces.constant(0.3), step="50 um", to=["12 mm"])
    asked = {"method": method, "noise": "3 mN, 3 mN, 10 uN*m", "assume": False}
    plain = signals.to_pandas()[["footpoint", "force_x", "force_y", "moment_z"]]
    plain.columns = ["footpoint [m]", "force_x [N]", "force_y [N]", "moment_z [N*m]"]
    other = plain * np.array([1 / 0.0254, 1e3, 1e3, 1e3])
    other.columns = ["footpoint [inch]", "force_x [mN]", "force_y [mN]", "moment_z [N*mm]"]
    one, two = (identified(whisker, table, **asked).periods for table in (plain, other))
    assert np.isfinite(one.mu0).sum() > 2
    same(one, two)
