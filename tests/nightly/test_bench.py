"""The bench that the sensor is tried on: against closed forms, and against the package itself."""

from dataclasses import replace

import numpy as np
import pytest

import reference
from validation.sensor.bench import Bench, Friction, Slip, crosstalk, moved, scan, turned
from validation.sensor.bench_rod import Rod, States, solve
from vibrissa import Mounting
from vibrissa.scanning import surfaces
from vibrissa.sensor import Whisker
from vibrissa.sensor import scan as simulated

EXACT = np.zeros(3)
WAVE = Friction(wave=0.02)
TILT = np.radians(0.5)
BENT = Rod(theta=2.1, clamp_angle=-0.01, compliance=0.006, curvature=-0.08)


def test_a_cylinder_is_the_elastica():
    eta, force, place = reference.elastica(0.4)
    _, fx, fy, m, dx = solve(Rod(theta=1.0), eta, [[0.55], [0.0], [-1.16]], ratio=0.0)[:, 0]
    assert (fx, fy, dx) == pytest.approx((0.0, -force, place), abs=1e-10)
    # The moment of the force about the clamp.
    assert m == pytest.approx(fy * dx, abs=1e-10)


@pytest.mark.slow
def test_the_table_of_states_is_as_good_as_the_states():
    states = States.tabulated(BENT, 0.848, 0.853)
    parts = np.random.default_rng(1).uniform(size=(2, 20))
    dx, dy = states.low[:, None] + (states.high - states.low)[:, None] * parts
    loads = states(dx, dy)
    known = solve(BENT, dy, [np.full(20, 0.5), *loads.T[:2]], dx=dx)[1:4].T
    assert loads == pytest.approx(known, abs=1e-9)


def same(bench, whisker, law, step=0.001, to=(0.1, 0.06), turn=0.0):
    """The package scans what is on the bench; its forces are those along the surface."""
    found = scan(bench, step, to, EXACT, seed=0)
    surface = surfaces.Surface(name="wave", mu0=lambda place: bench.friction(place))
    theirs = simulated(whisker, surface, step=str(step), to=[str(end) for end in to], law=law)
    truth = theirs.truth
    assert found.period.tolist() == truth.period.tolist()
    assert found.loads == pytest.approx(truth.reactions @ turned(turn).T, abs=1e-8)
    assert found.tip - truth.contact == pytest.approx(found.tip[0] - truth.contact[0], abs=1e-8)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("slip", list(Slip))
@pytest.mark.parametrize(
    ("rod", "mounting"),
    [
        (Rod(), Mounting()),
        (BENT, Mounting(clamp_angle=-0.01, clamp_compliance=0.006, curvature=-0.08)),
    ],
)
def test_scans_are_those_of_the_package(rod, mounting, slip):
    bench = Bench(rod=rod, friction=WAVE, slip=slip)
    whisker = Whisker(theta=rod.theta, eta=bench.eta, mounting=mounting)
    found = same(bench, whisker, str(slip))
    # It turns, and the tip is pulled.
    assert found.period[-1] > 4 and found.loads[-1, 0] > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("incline", [TILT, -TILT])
def test_an_inclined_surface_is_an_oblique_stage_with_an_inclined_clamp(incline):
    mounting = Mounting(clamp_angle=incline, stage_angle=incline)
    # Where the surface is, and so where friction is, is counted along it from other points.
    bench = Bench(friction=Friction(), incline=incline)
    same(bench, Whisker(theta=2.0, eta=0.85, mounting=mounting), "kinetic", turn=incline)


@pytest.mark.slow
def test_a_tip_slips_at_the_very_onset_while_the_stage_moves():
    fine, coarse = (
        scan(Bench(at_rest=rests), step, [0.05], EXACT, seed=0)
        for rests, step in ((True, 1e-5), (False, 1e-3))
    )
    # A stage that rests after very fine steps is one that moves.
    assert coarse.tip == pytest.approx(fine.tip[::100], abs=2e-5)
    coarse_at_rest = scan(Bench(), 1e-3, [0.05], EXACT, seed=0)
    assert np.abs(coarse_at_rest.tip - fine.tip[::100]).max() > 2e-4


def test_the_transducer_turns_moves_and_mixes_loads():
    load = np.array([1.0, -2.0, 0.5])
    # Its x axis points along the force, then.
    assert turned(np.arctan2(-2.0, 1.0)) @ load == pytest.approx([np.sqrt(5.0), 0.0, 0.5])
    # The moment about the point at which a force acts is that of no force.
    about = moved(0.3, 0.7) @ load
    assert about[2] == pytest.approx(0.5 - (0.3 * -2.0 - 0.7 * 1.0))
    assert (crosstalk(0.01 * (1.0 - np.eye(3))) @ load)[0] == pytest.approx(1.0 - 0.015)


def test_noise_drift_and_zero_are_those_that_were_asked_for():
    drift, zero, noise = np.array([0.1, 0.0, 0.0]), np.array([0.0, 0.2, 0.0]), 1e-3
    bench = Bench(zero=zero, drift=drift)
    found = scan(bench, 1e-4, [0.2], np.full(3, noise), seed=1)
    rest = found.readings - found.loads - zero - np.linspace(0, 1, 2001)[:, None] * drift
    assert rest.std(axis=0) == pytest.approx(np.full(3, noise), rel=0.1)
    walk = scan(replace(bench, walk=np.full(3, 0.1)), 1e-4, [0.2], np.zeros(3), seed=1)
    steps = np.diff(walk.readings - walk.loads - zero, axis=0) - drift / 2000
    assert steps.std(axis=0) == pytest.approx(np.full(3, 0.1 / np.sqrt(2000)), rel=0.1)
