"""Requirements: how they are read from text and from a set-up file, and what is refused."""

import tomllib

import numpy as np
import pytest

from vibrissa.design import MATERIALS, DesignStatus, Requirements, design
from vibrissa.design.materials import Material
from vibrissa.design.requirements import DIAMETERS, LENGTHS, SOLD, TAPERS
from vibrissa.errors import ArgumentError
from vibrissa.quantities.keys import write_keys
from vibrissa.sensor import preset
from vibrissa.sensor.setup import Setup

WIRE = MATERIALS["music-wire"]
SENSOR = preset("nano17-si-12-0.12")
NAMED = {"material": "music-wire", "transducer": "nano17-si-12-0.12"}
ASKED = {"mu0": "0.2 to 0.4", "step": "50 um"}
OWN = {"modulus": "3.6 GPa", "yield_strain": 0.01, "noise": "1 mN, 2 mN, 5 uN*m"}
SETUP = """
theta = 1.2
eta = "158.4 ± 0.2 mm"
diameter = "1 mm ± 0.5 %"
length = "180 mm"
contact = "line"
material = "music-wire"
modulus = "205 ± 4 GPa"
transducer = "nano17-si-12-0.12"
section = "planar"
clamp_angle = "0 ± 0.2 deg"
"""


@pytest.fixture
def setup(tmp_path):
    path = tmp_path / "wire.toml"
    path.write_text(SETUP, encoding="utf-8-sig")  # as editors on Windows write it
    return path


def test_materials_and_transducers_have_names():
    read = Requirements.read(**NAMED, **ASKED)
    assert read.material == WIRE
    assert (tuple(read.noise), tuple(read.largest)) == (tuple(SENSOR.deviation), SENSOR.limit)
    assert read.mu0 == (0.2, 0.4) and read.step == 50e-6
    assert Requirements.read(**NAMED, **ASKED, density="8 g/cm^3").material.density == 8000.0


def test_what_is_chosen_from_is_a_value_a_list_or_a_range_of_what_is_sold(snapshot):
    assert (SOLD, TAPERS, DIAMETERS, LENGTHS) == snapshot
    read = Requirements.read(**NAMED, **ASKED)
    assert (read.theta, read.diameter, read.length) == (TAPERS, DIAMETERS, LENGTHS)
    asked = {"theta": "1 to 2.2", "diameter": "1 mm, 800 um", "length": "55 to 75 mm"}
    read = Requirements.read(**NAMED, **ASKED, **asked)
    assert read.theta == (1.0, 1.5, 2.0, 2.2)
    assert read.diameter == pytest.approx((0.8e-3, 1e-3))
    assert read.length == pytest.approx((0.055, 0.06, 0.07, 0.075))
    one = Requirements.read(**NAMED, **ASKED, length="100 mm", eta="80 to 90 mm")
    assert (one.eta[0], one.eta[-1]) == pytest.approx((0.8, 0.9)) and (np.diff(one.eta) > 0.0).all()
    assert Requirements.read(**NAMED, **ASKED, eta="0.8, 0.85").eta == (0.8, 0.85)
    narrow = Requirements.read(**NAMED, **ASKED, length="190 to 230 mm ± 1", eta="0.8502 to 0.8508")
    assert narrow.length == (0.19, 0.2, 0.21, 0.22, 0.23) and narrow.eta == (0.8502, 0.8508)
    assert narrow.setup.tolerances == {"length": "1 mm"}


def test_a_setup_file_is_read_and_an_option_takes_its_place(setup):
    read = Requirements.read(setup, **ASKED)
    assert read.given and read.eta == pytest.approx((0.88,)) and read.setup.contact == "line"
    made = read.material
    assert made.modulus * made.yield_strain == pytest.approx(WIRE.modulus * WIRE.yield_strain)
    whisker = read.rod_setup(1.2, 0.88, 1e-3, 0.18).whisker
    assert whisker.tolerances == pytest.approx(
        {"eta": 0.2 / 180, "diameter": 0.005, "modulus": 4 / 205, "clamp_angle": np.deg2rad(0.2)}
    )
    other = Requirements.read(
        setup, **ASKED, theta="1 to 2", tolerances={"clamp_angle": "1 deg"}, noise=OWN["noise"]
    )
    assert other.theta == (1.0, 1.5, 2.0) and tuple(other.noise) == (1e-3, 2e-3, 5e-6)
    assert np.isinf(other.largest).all()
    assert other.rod_setup(2, 0.88, 1e-3, 0.18).whisker.tolerances["clamp_angle"] == np.deg2rad(1.0)


@pytest.mark.slow
def test_the_result_is_written_as_a_setup_file_with_what_was_given(setup, tmp_path):
    asked = ASKED | {"mu0": "0.2 to 0.35"}
    found = design(Requirements.read(setup, **asked))
    assert found.status is DesignStatus.FOUND
    path = tmp_path / "rod.toml"
    write_keys(path, found.best.setup.stated(), "a rod, 5 µm off")
    assert path.read_text(encoding="utf-8").startswith("# a rod, 5 µm off\n")
    before, after = Setup.read(setup), Setup.read(path)
    assert (after.transducer, after.noise) == (before.transducer, before.noise)
    for name in ("contact", "section", "rod", "mounting", "tolerances"):
        assert getattr(after.whisker, name) == getattr(before.whisker, name)
    again = design(Requirements.read(path, **asked))
    assert again.best.largest == pytest.approx(found.best.largest)


def test_without_names_the_numbers_are_in_the_setup_file(tmp_path):
    size = {"theta": "2", "eta": "0.85", "diameter": "1 mm", "length": "100 mm"}
    found = design(Requirements.read(**OWN, mu0="0.2", step="5 um", **size))
    assert "weight       not checked: give the density" in repr(found)
    locks = design(Requirements.read(**OWN, mu0="0.6 to 0.8", step="5 um", **size))
    assert "nan" not in repr(locks) and "a factor of inf" not in locks.message
    write_keys(tmp_path / "rod.toml", found.best.setup.stated(), "")
    assert tomllib.loads((tmp_path / "rod.toml").read_text(encoding="utf-8")) == {
        **{"theta": 2.0, "eta": 0.85, "modulus": "3.6 GPa"},
        **{"diameter": "1 mm", "length": "100 mm", "yield_strain": 0.01},
        "noise": OWN["noise"],
    }


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"mu0": "0.4 to 0.2"}, "a range must go from low to high, got '0.4 to 0.2'"),
        ({"mu0": "0 to 0.2"}, "mu0: input should be greater than 0, got 0.0"),
        ({"theta": "0.5"}, "theta: input should be greater than or equal to 1, got 0.5"),
        ({"theta": "much"}, "theta must be a number, got 'much'"),
        ({"eta": "0.5 to 1"}, "eta: input should be less than 1"),
        ({"eta": "85 mm"}, "eta = '85 mm' has a unit, which needs a single length"),
        ({"step": "50"}, "step must be a length with a unit"),
        ({"tip": "-1 mm"}, "tip: input should be greater than or equal to 0"),
        ({"safety": 0.5}, "safety: input should be greater than or equal to 1"),
        ({"load": 1.5}, "load: input should be less than 1"),
        ({"steps": np.inf}, "steps must be a number, got 'inf'"),
        ({"spacing": "0 mm"}, "spacing: input should be greater than 0"),
        ({"density": "-1 kg/m^3"}, "density: input should be greater than 0"),
        ({"contact": "plane"}, "contact: input should be 'point' or 'line', got 'plane'"),
        ({"material": "cheese"}, "material must be one of steel-s235"),
        ({"material": None}, "give the material or modulus"),
        ({"material": None, "modulus": "1 GPa"}, "give the material or yield_strain"),
        ({"transducer": None}, "neither transducer nor noise is given"),
        ({"transducer": None, "noise": "1 N"}, "noise needs three values"),
        ({"transducer": None, "noise": "0 N, 1 N, 1 N*m"}, "noise must be positive"),
        ({"noise": "1 N, 1 N, 1 N*m"}, "the noise or the transducer, not both"),
        ({"length": "1 mm ± 1 %", "tolerances": "exact"}, "tolerances: input should be a valid"),
        ({"yield_strain": "0.1"}, "the material or its yield strain, not both"),
        ({"tolerances": {"eta": "1 GPa"}}, "the tolerance of eta must be a length"),
        ({"tolerances": {"etta": "1 mm"}}, "did you mean eta"),
        ({"colour": "red"}, "'colour' is not a key; the keys are"),
    ],
)
def test_impossible_requirements_are_refused(change, message):
    with pytest.raises(ArgumentError, match="(?s)" + message.replace("(", r"\(")):
        Requirements.read(**NAMED | ASKED | change)


def test_all_errors_are_told_together():
    with pytest.raises(ArgumentError) as error:
        Requirements.read(**NAMED, mu0="0", step="1 GPa", theta="0")
    assert len(str(error.value).splitlines()) == 3


def test_a_mounting_is_no_requirement(setup):
    setup.write_text(SETUP.replace("0 ± 0.2 deg", "2 deg"), encoding="utf-8")
    with pytest.raises(ArgumentError, match="leave out clamp_angle, clamp_compliance"):
        Requirements.read(setup, **ASKED)


def test_a_modulus_that_was_measured_leaves_the_yield_stress():
    found = WIRE.with_modulus(210e9)
    assert found.yield_strain * 210e9 == pytest.approx(WIRE.yield_strain * WIRE.modulus)
    for modulus in (100e9, 400e9):
        with pytest.raises(ArgumentError, match="is far from 200 GPa"):
            WIRE.with_modulus(modulus)


def test_yield_strains_are_on_the_safe_side():
    for stress, name in ((235e6, "steel-s235"), (0.65 * 1840e6, "music-wire"), (379e6, "nitinol")):
        found = MATERIALS[name]
        assert found.yield_strain * found.modulus == pytest.approx(stress, rel=1e-3)
    # Printed parts stay elastic in the weakest direction.
    assert all(
        0.003 < MATERIALS[f"{name}-printed"].yield_strain < 0.005 for name in ("pla", "petg")
    )


MATERIAL = 'modulus = "3.5 GPa"\nyield_strain = 0.004\ndensity = "1240 kg/m^3"\n'
TRANSDUCER = 'limit = "10 N, 20 N, 100 N*mm"\nresolution = "2 mN, 4 mN, 10 uN*m"\n'


def test_a_material_and_a_transducer_of_ones_own(tmp_path):
    path = tmp_path / "mine.TOML"
    path.write_text(MATERIAL)
    found = Material.named(str(path), MATERIALS)
    assert (found.modulus, found.yield_strain, found.density) == (3.5e9, 0.004, 1240.0)
    assert found.name == "mine" and found.source == str(path)
    path.write_text(TRANSDUCER)
    found = preset(str(path))
    assert found.limit == (10.0, 20.0, 0.1) and found.resolution == (0.002, 0.004, 1e-5)
    assert found.noise == found.resolution
    path.write_text(TRANSDUCER + 'noise = "1 mN, 1 mN, 2 uN*m"\nname = "the one in room 5"\n')
    assert preset(str(path)).noise == (0.001, 0.001, 2e-6)
    assert preset(str(path)).name == "the one in room 5"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (MATERIAL.replace("modulus", "stiffness"), "mine.toml: the key modulus is missing"),
        (MATERIAL + "colour = 3\n", "'colour' is not a key; the keys are name, source, modulus"),
        (MATERIAL.replace("GPa", "mm"), "modulus must be a stress"),
        (MATERIAL.replace("0.004", "-1"), "yield_strain: input should be greater than 0"),
        ("modulus: 3", "write key = 2.5"),
    ],
)
def test_a_card_that_is_none_is_refused(text, said, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(ArgumentError, match=said):
        Material.named(str(path), MATERIALS)


def test_a_card_that_is_not_there_or_lacks_a_channel_is_refused(tmp_path):
    with pytest.raises(FileNotFoundError):
        preset("none.toml")
    path = tmp_path / "mine.toml"
    path.write_text(TRANSDUCER.replace(", 100 N*mm", ""))
    with pytest.raises(ArgumentError, match="limit needs three values"):
        preset(str(path))
