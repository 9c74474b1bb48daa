"""Set-ups with errors, and what their transducers read, beside an independent bench."""

from dataclasses import replace

import numpy as np
import pytest

from validation.sensor import bench
from validation.sensor.bench_rod import Rod
from validation.sensor.mistakes import MISTAKES
from vibrissa.scanning.cycles import move
from vibrissa.scanning.slip_model import SlipModel
from vibrissa.scanning.surfaces import constant
from vibrissa.sensor import Setup
from vibrissa.sensor.deviations import Deviations, Prior, drawn, recorded, sloped, transduced
from vibrissa.sensor.identification.slope import Slope
from vibrissa.sensor.tolerances import TOLERABLE
from vibrissa.sensor.transducer import Transducer

STEEL = {"modulus": "210 GPa", "diameter": "1 mm", "length": "100 mm"}
# Readings that are neither rounded nor noisy.
EXACT = Transducer(
    name="exact", source="", limit=(100.0, 100.0, 10.0), resolution=(0.0,) * 3, noise=(1e-12,) * 3
)
STEP, WAY = 0.002, 0.12


@pytest.fixture(scope="module")
def prior():
    return Prior.of(Setup.read(theta=2, eta=0.85, **STEEL).whisker, EXACT)


def moves(stage, surface, scale):
    model = SlipModel.of("kinetic", 0.8)
    return move(stage, surface, STEP * scale, to=[WAY * scale], model=model)


def readings_with(prior, deviations):
    generator = np.random.default_rng(1)
    found = recorded(prior, deviations, constant(0.3), [0.0, WAY], moves, generator)
    return found, found.readings / prior.whisker.units.channels


def test_deviates_are_mirrored_at_their_bounds():
    generator = np.random.default_rng(0)
    size = drawn(np.full(4000, 2.0), np.full(4000, 0.0), np.full(4000, np.inf), generator)
    assert size.min() >= 0.0
    # A normal deviate that is mirrored at its mean has the same square.
    assert np.sqrt(np.mean(size**2)) == pytest.approx(2.0, rel=0.05)
    whole = drawn(np.full(4000, 2.0), np.full(4000, -np.inf), np.full(4000, np.inf), generator)
    assert np.mean(whole) == pytest.approx(0.0, abs=0.1)


def test_all_quantities_are_drawn_with_their_tolerance(prior):
    generator = np.random.default_rng(0)
    found = [prior.draw(generator) for _ in range(400)]
    deviation = np.array([one.deviation for one in found[0].parameters])
    usual = np.sqrt(np.mean([one.size**2 for one in found], axis=0))
    assert usual == pytest.approx(deviation, rel=0.15)
    assert {one.of for one in found[0].parameters} == TOLERABLE.keys() - {"surface_slope"}
    assert found[0].slope.deviation == pytest.approx(np.radians(0.5))


def test_the_slope_of_a_surface_has_the_covariance_that_is_assumed():
    slope = Slope(deviation=0.01, length=0.05)
    x = np.linspace(0.0, 0.2, 9)
    generator = np.random.default_rng(2)
    found = [sloped(slope, -0.1, 0.3, 0.1, generator) for _ in range(600)]
    slopes = np.array([one.slope(x) for one in found])
    wanted = slope.deviation**2 * np.exp(-0.5 * ((x[:, None] - x) / slope.length) ** 2)
    assert np.cov(slopes.T) == pytest.approx(wanted, abs=0.2 * slope.deviation**2)
    assert [one.height(np.array(0.1)) for one in found] == pytest.approx([0.0] * 600, abs=1e-12)
    # The heights are the integral of the slope.
    rise = found[0].height(x[1:]) - found[0].height(x[:-1])
    ways = np.linspace(x[:-1], x[1:], 201)
    assert np.trapezoid(found[0].slope(ways), ways, axis=0) == pytest.approx(rise, abs=1e-8)


def only(prior, name, size):
    return prior.stated({name: f"{size!r} rad" if "angle" in name else size})


@pytest.mark.parametrize(
    ("name", "size"),
    [
        ("modulus", 0.2),
        ("diameter", 0.1),
        ("transducer_angle", 0.3),
        ("crosstalk", 0.05),
        ("moment_origin_x", 0.1),
        ("moment_origin_y", -0.1),
        ("zero_force_y", 0.1),
        ("drift_moment_z", -0.1),
    ],
)
def test_a_transducer_reads_what_an_independent_bench_reads(prior, name, size):
    loads = np.array([[0.1, 1.9, -0.4], [0.5, 1.2, 0.3], [-0.2, 1.0, 0.6]])
    error = MISTAKES[name].fixed(bench.Bench(), size)
    # Crosstalk is relative to the full scales, which the bench takes from a scan.
    matrix = error.transducer
    if name == "crosstalk":
        full = np.array(EXACT.limit) / prior.whisker.units.channels
        matrix = np.eye(3) + size * (1.0 - np.eye(3)) * full[:, None] / full
    wanted = loads @ matrix.T + error.zero + np.linspace(0.0, 1.0, 3)[:, None] * error.drift
    assert transduced(only(prior, name, size), loads) == pytest.approx(wanted, abs=1e-12)


@pytest.mark.slow
def test_a_recording_with_errors_agrees_with_an_independent_bench(prior):
    sizes = {
        "theta": 0.03,
        "eta": -0.004,
        "clamp_angle": 0.01,
        "clamp_compliance": 0.006,
        "curvature": -0.02,
        "stage_angle": 0.008,
        "modulus": 0.03,
        "diameter": -0.006,
        "transducer_angle": 0.01,
        "moment_origin_x": 0.003,
        "zero_force_x": 0.02,
        "drift_force_y": 0.03,
        "stage_scale": 0.002,
        "creep": 0.002,
        "length": 0.004,
    }
    stated = {name: f"{size} rad" if "angle" in name else size for name, size in sizes.items()}
    found, readings = readings_with(prior, prior.stated(stated))
    setup = bench.Bench(rod=Rod(theta=2.0), friction=bench.Friction(mean=0.3))
    for name, size in sizes.items():
        setup = MISTAKES[name].fixed(setup, size)
    wanted = bench.scan(setup, STEP, [WAY], np.zeros(3), seed=1)
    assert found.scan.slips == wanted.period[-1] - 1 > 3
    assert readings == pytest.approx(wanted.readings, abs=2e-5)


@pytest.mark.slow
def test_a_recording_without_errors_is_a_scan_of_the_stated_rod(prior):
    found, readings = readings_with(prior, prior.stated({}))
    assert found.whisker == prior.whisker and found.scale == 1.0
    assert readings == pytest.approx(found.scan.reactions, abs=1e-9)
    # A surface that is longer than stated, in lengths of the rod.
    slopes = replace(prior.stated({"length": 0.1}), slope=Slope(deviation=0.01, length=0.05))
    rough, _ = readings_with(prior, slopes)
    assert np.ptp(rough.scan.height) > 1e-5
    assert rough.scan.clamp[-1] == pytest.approx(WAY / 1.1)


def test_sizes_are_those_of_named_parameters(prior):
    deviations: Deviations = prior.stated({"eta": "-0.2 mm", "drift_force_x": 0.1})
    assert {name: size for name, size in deviations.sizes.items() if size} == {
        "eta": pytest.approx(-0.002),
        "drift_force_x": 0.1,
    }
