"""Requirements, materials, and how they are read from text."""

from dataclasses import replace

import numpy as np
import pytest

from vibrissa.design import MATERIALS, Requirements, read_requirements
from vibrissa.design.materials import material
from vibrissa.design.reading import with_rod_file
from vibrissa.errors import ArgumentError
from vibrissa.sensor.quantities import Kind, range_of
from vibrissa.sensor.transducer import preset

WIRE = MATERIALS["music-wire"]
SENSOR = preset("nano17-si-12-0.12")
ASKED = {"mu0": "0.2 to 0.4", "step": "50 um"}
REQUIREMENTS = Requirements(
    modulus=WIRE.modulus,
    yield_strain=WIRE.yield_strain,
    density=WIRE.density,
    mu0=(0.2, 0.4),
    step=50e-6,
    noise=SENSOR.deviation,
    range=SENSOR.limit,
)


def test_the_largest_taper_of_all_is_allowed():
    assert replace(REQUIREMENTS, theta=(1.0, 50.0)).theta == (1.0, 50.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"mu0": (0.4, 0.2)}, "mu0 must lie above 0, from low to high, got 0.4 to 0.2$"),
        ({"mu0": (0.0, 0.2)}, "mu0 must lie above 0, from low to high, got"),
        ({"theta": (0.5, 2.0)}, "theta must lie between 1 and 50, from low"),
        ({"eta": (0.5, 1.0)}, "eta must lie between 0 and 1"),
        ({"eta": (0.5, float("nan"))}, "eta must lie between 0 and 1"),
        ({"step": 0.0}, "step must be positive"),
        ({"noise": (0.0, 1.0, 1.0)}, "noise must be three positive"),
        ({"noise": (1.0, 1.0, float("nan"))}, "noise must be three positive"),
        ({"noise": (1.0, 1.0, float("inf"))}, "noise must be finite"),
        ({"lock_factor": float("inf")}, "lock_factor must be at least 1"),
        ({"steps": float("inf")}, "steps must be positive and finite"),
        ({"tip": -1e-4}, "tip must not be negative"),
        ({"safety": 0.5}, "at least 1"),
        ({"density": -1.0}, "density must be positive"),
        ({"density": 0.0}, "density must be positive"),
        ({"density": np.inf}, "density must be positive and finite"),
        ({"modulus": 0.0}, "modulus must be positive"),
        ({"yield_strain": 0.0}, "yield_strain must be positive"),
        ({"weight": 0.0}, "weight must be positive"),
        ({"spacing": 0.0}, "spacing must be positive"),
        ({"step": np.inf}, "step must be positive and finite"),
        ({"steps": 0.0}, "steps must be positive and finite"),
        ({"safety": np.inf}, "safety must be at least 1 and finite"),
        ({"tip": np.inf}, "tip must not be negative, and be finite"),
        ({"range": (1.0, 0.0, 1.0)}, "range must be three positive"),
        ({"range": (1.0, 1.0)}, "range must be three positive"),
        ({"diameter": (0.0, 1.0)}, "diameter must lie above 0, from low to high, got 0 to 1 m$"),
        ({"length": (0.1, np.inf)}, "length must lie above 0"),
        ({"theta": (2.0, 50.1)}, "theta must lie between 1 and 50, from low"),
        ({"eta": (0.0, 0.5)}, "eta must lie between 0 and 1"),
        ({"eta": (0.6, 0.5)}, "eta must lie between 0 and 1"),
    ],
)
def test_impossible_requirements_are_refused(change, message):
    with pytest.raises(ArgumentError, match=message):
        replace(REQUIREMENTS, **change)


@pytest.mark.parametrize(
    "change",
    [
        {"tip": 0.0},
        {"safety": 1.0, "lock_factor": 1.0},
        {"theta": (1.0, 1.0), "eta": (0.5, 0.5)},
        {"mu0": (0.3, 0.3), "diameter": (1e-3, 1e-3), "length": (0.1, 0.1)},
        {"density": None, "weight": np.inf, "spacing": np.inf, "yield_strain": np.inf},
        {"range": (np.inf, np.inf, np.inf), "stock": (1e-3, 2e-3)},
    ],
)
def test_the_ends_of_what_is_allowed_are_allowed(change):
    found = replace(REQUIREMENTS, **change)
    assert {name: getattr(found, name) for name in change} == change


def test_materials_and_transducers_have_names():
    named = {"material": "music-wire", "transducer": "nano17-si-12-0.12"}
    assert read_requirements(**named, **ASKED) == REQUIREMENTS
    denser = read_requirements(**named, **ASKED, density="8 g/cm^3")
    assert denser == replace(REQUIREMENTS, density=8000.0)


def test_a_bare_number_is_in_units_of_a_rod_that_is_known():
    made = {"modulus": "200 GPa", "yield_strain": 0.006, "mu0": "0.2 to 0.4", "theta": "2"}
    own = {"step": "0.0005", "noise": "0.001, 0.001, 0.0001", "range": "10, 5 N, 3"}
    read = read_requirements(**made, **own, diameter="1 mm", length="100 mm", eta="85 mm")
    force = 200e9 * np.pi / 64 * 1e-3**4 / 0.1**2
    assert read.step == pytest.approx(50e-6) and read.eta == (0.85, 0.85)
    assert read.noise == pytest.approx((1e-3 * force, 1e-3 * force, 1e-5 * force))
    assert read.range == pytest.approx((10 * force, 5.0, 0.3 * force))
    si = {"noise": "1 mN, 1 mN, 0.1 mN*m", "diameter": "1 to 2 mm", "length": "100 mm"}
    read = read_requirements(**made, **si, step="0.0005", spacing="0.05")
    assert read.spacing == pytest.approx(5e-3) and read.noise == (1e-3, 1e-3, 1e-4)
    with pytest.raises(ArgumentError, match="noise must be a force with a unit"):
        read_requirements(**made, **si | {"noise": own["noise"]}, step="0.0005")
    with pytest.raises(ArgumentError, match="step must be a length with a unit"):
        read_requirements(**made, **si | {"length": "50 to 100 mm"}, step="0.0005")


def test_without_a_material_everything_is_in_units_of_the_rod():
    own = {"step": "0.0005", "noise": "0.003, 0.003, 0.0002", "mu0": "0.2 to 0.4"}
    read = read_requirements(**own, yield_strain=1.2, spacing="0.1", eta="0.8 to 0.9")
    assert read == Requirements.nondimensional(
        step=0.0005,
        noise=(0.003, 0.003, 0.0002),
        mu0=(0.2, 0.4),
        yield_strain=1.2,
        spacing=0.1,
        eta=(0.8, 0.9),
    )
    assert read.rigidity == read.length[0] == 1.0
    with pytest.raises(ArgumentError, match="modulus must be given"):
        replace(read, length=(0.1, 0.1))


def test_a_modulus_that_was_measured_leaves_the_yield_stress():
    found = WIRE.with_modulus(210e9)
    assert found.yield_strain * 210e9 == pytest.approx(WIRE.yield_strain * WIRE.modulus)
    assert (found.modulus, found.density) == (210e9, WIRE.density)
    for modulus in (WIRE.modulus / 1.6, WIRE.modulus * 1.6):
        with pytest.raises(ArgumentError, match="is not that of music wire"):
            WIRE.with_modulus(modulus)


def test_materials_say_where_their_figures_stand():
    for stuff in MATERIALS.values():
        assert len(stuff.source) > 20 and 1e-4 < stuff.yield_strain < 0.05
        assert 1e9 < stuff.modulus < 3e11 and 500 < stuff.density < 1e4
    with pytest.raises(ValueError, match="music-wire"):
        material("unobtainium")


def test_ranges():
    assert range_of("0.2 to 0.4") == ("0.2", "0.4")
    assert range_of("20 to 200 mm") == ("20 mm", "200 mm")
    assert range_of("20 um to 2 mm") == ("20 um", "2 mm")
    assert range_of(" 5 mm") == ("5 mm", "5 mm")
    assert range_of("0.1 to 4e-1") == ("0.1", "4e-1")
    assert range_of("1e-1 to 4 mm") == ("1e-1 mm", "4 mm")
    assert range_of("1 to 2 eV") == ("1 eV", "2 eV")


FILE = """
theta = "2 ± 0.01"
length = "100 ± 0.2 mm"
modulus = "205 ± 4 GPa"
material = "music-wire"
noise = "3 mN, 3 mN, 10 N*mm"
clamp_angle = "0 ± 0.3 deg"
section = "planar"

[tolerances]
eta = "0.1 mm"
"""


def test_a_rod_file_fixes_sizes_and_states_tolerances(tmp_path):
    path = tmp_path / "rod.toml"
    path.write_text(FILE)
    asked = {"step": "20 um", "mu0": "0.2 to 0.4", "eta": None, "diameter": "0.5 to 1 mm"}
    found = read_requirements(**with_rod_file(path, asked))
    assert found.theta == (2.0, 2.0) and found.length == (0.1, 0.1)
    assert found.diameter == pytest.approx((0.5e-3, 1e-3)) and found.eta == Requirements.eta
    assert found.noise == pytest.approx((0.003, 0.003, 0.01))
    assert found.tolerances == {
        "theta": "0.01",
        "length": "0.2 mm",
        "modulus": "4 GPa",
        "clamp_angle": "0.3 deg",
        "eta": "0.1 mm",
    }
    assert found.wished == {Kind.FORCE: "mN", Kind.MOMENT: "N*mm"}
    # Music wire yields at the same stress, whatever modulus was measured.
    wire = MATERIALS["music-wire"]
    assert found.modulus == 205e9 and found.density == wire.density
    assert found.yield_strain * 205e9 == pytest.approx(wire.yield_strain * wire.modulus)


@pytest.mark.parametrize(
    ("given", "instead", "said"),
    [
        ("0 ± 0.3 deg", "1 deg", "of clamp_angle give the tolerance alone"),
        ('material = "music-wire"', 'material = "carbon-rod"', "is not that of pultruded carbon"),
        ('eta = "0.1 mm"', 'eta = "0.1 N"', "the tolerance of eta must be a length"),
        ('eta = "0.1 mm"', 'height = "0.1 mm"', "there is no key height"),
    ],
)
def test_a_rod_file_of_which_nothing_can_be_designed_is_refused(given, instead, said, tmp_path):
    path = tmp_path / "rod.toml"
    path.write_text(FILE.replace(given, instead))
    with pytest.raises(ArgumentError, match=said):
        read_requirements(**with_rod_file(path, {"step": "20 um", "mu0": "0.2 to 0.4"}))


def test_options_take_the_place_of_what_a_rod_file_says(tmp_path):
    path = tmp_path / "rod.toml"
    path.write_text(FILE)
    asked = {"step": "20 um", "mu0": "0.2 to 0.4", "transducer": "nano17-si-12-0.12"}
    asked |= {"theta": "1 to 3", "tolerances": {"eta": "exact"}, "yield_strain": 0.004}
    found = read_requirements(**with_rod_file(path, asked))
    assert found.theta == (1.0, 3.0) and found.yield_strain == 0.004
    assert found.noise[0] > 0.003 and found.tolerances["eta"] == "exact"
    assert "theta" not in found.tolerances
