"""The explorer's model on a wave, in Node.js: against Python's simulation of the same scans."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

from responses import by_law
from validation.node import node
from vibrissa import Mounting
from vibrissa.explorer.modules import bundle
from vibrissa.explorer.page import WAVES
from vibrissa.scanning import surfaces, textures
from vibrissa.scanning.rods import MountedRod
from vibrissa.scanning.simulation import simulate
from vibrissa.scanning.stage import path, stage_of

pytestmark = pytest.mark.slow

COMMON = {"theta": 2.0, "eta": 0.85, "mu0": 0.3, "dx0": 5e-4, "ratio": 0.8, "wavelength": 0.025}
MODEL = """
function modelAt(settings) {
  const model = new Model();
  model.change(settings);
  model.restore(0, 0, 1);
  return model;
}
"""


@pytest.fixture(scope="module")
def page():
    with node() as scripts:
        scripts.evaluate(f"{bundle('view/model.js', 'solver/wave.js')}\n{MODEL}; 0")
        yield scripts


def of_model(page, settings, value, acts=""):
    """Value of the page's model after acts; the clamp begins at 0."""
    settings = json.dumps(COMMON | settings)
    return page.evaluate(
        f"(() => {{ const model = modelAt({settings}); {acts}; return {value}; }})()"
    )


def in_python(settings, *turns):
    """Scan of the simulation, in steps of the model."""
    given = SimpleNamespace(**({"law": "free", "beta": 0.0, "kappa0": 0.0} | COMMON | settings))
    positions = path(str(given.dx0), list(turns))
    wave = textures.wave(given.amplitude, given.wavelength)
    mounting = Mounting(clamp_angle=math.radians(given.beta), curvature=(given.kappa0, 0.0))
    rod = MountedRod(theta=given.theta, eta=given.eta, mounting=mounting)
    surface = surfaces.constant(given.mu0).with_texture(wave)
    stage = stage_of(rod, positions, texture=wave)
    return simulate(stage, surface, positions, by_law(given.law, given.ratio))


@pytest.mark.parametrize("law", ["free", "kinetic", "energy"])
@pytest.mark.parametrize(
    ("amplitude", "wavelength"),
    [(1e-4, 0.025), (2e-4, 0.02), (5e-3, 0.05), (1e-3, 0.012)],
)
def test_steps_on_a_wave_are_those_of_the_simulation(page, law, amplitude, wavelength):
    settings = {"amplitude": amplitude, "wavelength": wavelength, "law": law}
    rows = "model.trace.map((row) => [row.clamp, row.contact, row.x0, row.fx, row.fy, row.m])"
    found = of_model(page, settings, rows, "for (let k = 0; k < 160; k += 1) model.step()")
    scan = in_python(settings, "0.08")
    expected = np.column_stack([scan.clamp, scan.contact, scan.x0, scan.reactions])
    assert scan.slips > 0
    assert np.array(found)[: len(scan)] == pytest.approx(expected, abs=1e-7)


@pytest.mark.parametrize(
    ("wavelength", "slips_in_wave"),
    [(0.025, 1), pytest.param(0.022, None, marks=pytest.mark.nightly)],
)
def test_slips_lock_to_a_wave_as_in_the_simulation(page, wavelength, slips_in_wave):
    settings = {"amplitude": 1e-4, "wavelength": wavelength, "dx0": 2e-3}
    steps = "for (let k = 0; k < 450; k += 1) model.step()"
    found = of_model(page, settings, "[model.slipsInWave, model.rests]", steps)
    scan = in_python(settings, "0.9")
    rests = [period.footing.contact for period in scan.ends if period.footing is not None][-13:]
    assert found[1] == pytest.approx(rests, abs=1e-7)
    if slips_in_wave:
        assert found[0] == pytest.approx(slips_in_wave, abs=2e-3)
    else:
        assert abs(found[0] - 1) > 0.02


@pytest.mark.parametrize(
    "settings",
    [
        {"beta": 5.0, "kappa0": -0.2, "amplitude": 1e-3, "wavelength": 0.05},
        {"law": "kinetic", "ratio": 0.5, "amplitude": 2e-3, "wavelength": 0.04, "mu0": 0.4},
        # So steep that the tip lifts off.
        {"amplitude": 4e-3, "wavelength": 0.01, "mu0": 0.1},
    ],
)
def test_there_and_back_is_as_in_the_simulation(page, settings):
    settings = settings | {"dx0": 1e-3}
    back = "for (let k = 150; k >= -50; k -= 1) model.part(k * 1e-3, true)"
    acts = f"for (let k = 0; k < 150; k += 1) model.step(); model.trace = []; {back}"
    rows = "model.trace.map((row) => [row.clamp, row.contact, row.x0])"
    found = np.array(of_model(page, settings, rows, acts))
    scan = in_python(settings, "0.15", "-0.05")
    expected = np.column_stack([scan.clamp, scan.contact, scan.x0])[150:]
    assert len(expected) > 150 and scan.slips > 4
    assert ("the tip lifts off" in scan.message) == (settings["wavelength"] == 0.01)
    assert found[: len(expected)] == pytest.approx(expected, abs=1e-6)


def test_a_plane_is_the_limit_of_a_flat_wave(page):
    acts = "for (let k = 0; k < 100; k += 1) model.step()"
    plane, wave = (
        of_model(page, {"amplitude": amplitude}, "[model.place.x0, model.now.contact]", acts)
        for amplitude in (0, 1e-9)
    )
    assert wave == pytest.approx(plane, abs=1e-6)


def test_after_lateral_buckling_the_tip_stays_and_is_dragged(page):
    settings = {"mu0": 0.5, "amplitude": 1e-3, "dx0": 0.01}
    rows = "model.trace.map((row) => [row.clamp, row.contact, row.side])"
    # The model also has a row where the rod buckles, between two steps.
    rows += ".filter(([clamp]) => Math.abs(clamp - 0.01 * Math.round(100 * clamp)) < 1e-9)"
    found = of_model(page, settings, rows, "for (let k = 0; k < 60; k += 1) model.step()")
    scan = in_python(settings, "0.6")
    side = np.where(scan.side == "behind", -1, 1)
    # It slips behind the clamp, too.
    assert (side < 0).any() and sum(one.tip.side < 0 for one in scan.ends) > 3
    expected = np.column_stack([scan.clamp, scan.contact, side])
    assert np.array(found) == pytest.approx(expected, abs=1e-7)


def test_a_clamp_without_steps_slips_at_the_exact_onset(page):
    settings = {"amplitude": 1e-4, "wavelength": 0.025}
    told = "model.moveTo(0.1).map((e) => [e.what, e.clamp, e.slid.from, e.slid.to])"
    found = of_model(page, settings, told)
    scan = in_python(settings | {"dx0": 1e-5}, "0.1")
    expected = [[one.until, one.tip.contact] for one in scan.ends if one.footing is not None]
    assert [what for what, *_ in found] == ["slips"] * len(expected)
    # The first slip; after a step the next ones begin elsewhere.
    assert found[0][1:3] == pytest.approx(expected[0], abs=1e-7)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"contact": "line"}, "choose contact Tip"),
        ({"delta": 2}, "choose contact Tip"),
        ({"eta": 0.99, "amplitude": 0.01, "wavelength": 0.5}, "try a flatter wave"),
    ],
)
def test_what_is_not_computed_on_a_wave_is_told(page, settings, said):
    settings = {"amplitude": 1e-3, "wavelength": 0.02} | settings
    message, missing = of_model(
        page, settings, "[model.message, model.sticking === null]", "model.moveTo(0.2)"
    )
    assert missing and said in message
    # Back on the plane, the model goes on.
    again = of_model(
        page, settings, "[model.message, model.sticking === null]", "model.change({ amplitude: 0 })"
    )
    assert again == ["", False]


@pytest.mark.parametrize("preset", WAVES)
def test_the_slips_of_a_preset_are_on_a_wave(page, preset):
    assert preset.settings["amplitude"] > 0
    assert of_model(page, dict(preset.settings), "model.message") == ""


@pytest.mark.parametrize(("mu0", "slips"), [(0.2, False), (0.05, True)])
def test_a_tip_slips_if_friction_falls_below_its_demand(page, mu0, slips):
    settings = {"amplitude": 2e-4, "wavelength": 0.02}
    acts = f"model.moveTo(0.008); const before = model.contact; model.change({{ mu0: {mu0} }})"
    assert of_model(page, settings, "model.contact !== before", acts) == slips
