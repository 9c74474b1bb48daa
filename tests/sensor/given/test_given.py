"""Values with tolerances, the rod file, and the table of what is assumed."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given as hypothesis_given
from hypothesis import strategies as st
from typer.testing import CliRunner

from vibrissa.cli.app import app
from vibrissa.errors import ArgumentError
from vibrissa.sensor import Whisker
from vibrissa.sensor.given.rod_file import RodFile, keys_of
from vibrissa.sensor.given.tolerances import assumed_tolerances
from vibrissa.sensor.given.values import Given
from vibrissa.sensor.quantities import Units

ROOT = Path(__file__).parents[3]
STEEL = {"modulus": "210 GPa", "diameter": "1 mm", "length": "100 mm"}


@pytest.mark.parametrize(
    ("text", "value", "tolerance"),
    [
        ("210 ± 5 GPa", "210 GPa", "5 GPa"),
        ("210 GPa +/- 2 %", "210 GPa", "2 %"),
        ("210 GPa ±2%", "210 GPa", "2%"),
        ("(210 +- 5) GPa", "210 GPa", "5 GPa"),
        ("210±5GPa", "210 GPa", "5GPa"),
        ("0.21 TPa ± 5 GPa", "0.21 TPa", "5 GPa"),
        ("85mm ± 0.1mm", "85mm", "0.1mm"),
        ("85 mm ± 0,1 mm", "85 mm", "0,1 mm"),  # refused where it is read
        ("2° ± 0.5°", "2°", "0.5°"),
        ("2 ± 0.02", "2", "0.02"),
        ("2e11 ± 5e-1 Pa", "2e11 Pa", "5e-1 Pa"),
        ("-2 ± 0.1 m^-1", "-2 m^-1", "0.1 m^-1"),
        ("210 GPa", "210 GPa", None),
    ],
)
def test_a_tolerance_stands_behind_its_value(text, value, tolerance):
    assert Given.read(text, "x") == Given(value=value, tolerance=tolerance)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 ± 2 ± 3 mm", "x has one tolerance at most"),
        ("1 ± -2 mm", "the tolerance of x must not be negative"),
        ("1 mm ± 2", "the tolerance of x needs a unit, as in '1 mm ± 2 mm'"),
        ("± 2 mm", "x is given as"),
        ("1 mm ±", "x is given as"),
    ],
)
def test_an_unclear_tolerance_is_refused(text, message):
    with pytest.raises(ArgumentError, match=re.escape(message)):
        Given.read(text, "x")


@hypothesis_given(
    st.decimals("0.001", "1000", places=3), st.decimals("0.001", "10", places=3), st.booleans()
)
def test_every_spelling_means_the_same(value, tolerance, spaced):
    gap = " " if spaced else ""
    spellings = (
        f"{value}{gap}±{gap}{tolerance} mm",
        f"({value}{gap}+/-{gap}{tolerance}) mm",
        f"{value} mm +- {tolerance} mm",
    )
    read = [Whisker.read(2, 0.85, **{**STEEL, "length": text}) for text in spellings]
    assert read[0] == read[1] == read[2]
    assert read[0].tolerances["length"] == pytest.approx(float(tolerance / value))


def test_the_tolerances_of_a_whisker_are_in_its_units():
    whisker = Whisker.read(
        "2 ± 1 %",
        "85 ± 0.1 mm",
        modulus="210 ± 5 GPa",
        diameter="1 mm ± 0.5 %",
        length="100 mm",
        clamp_angle="0 ± 0.3 deg",
        clamp_stiffness="20 ± 2 N*m/rad",
    )
    assert whisker.tolerances == pytest.approx(
        {
            "theta": 0.02,
            "eta": 0.001,
            "modulus": 5 / 210,
            "diameter": 0.005,
            "clamp_angle": np.deg2rad(0.3),
            "clamp_compliance": 0.1 * whisker.mounting.clamp_compliance,
        }
    )


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"theta": "2 ± 1 mm"}, "theta must be a number, got '2 mm'"),
        ({"theta": "2,1"}, "write a decimal point"),
        ({"clamp_angle": "0 ± 2 %"}, "has no value of which it could be 2 %"),
        ({"eta": "0.85 ± 1 deg"}, "eta must be a length"),
    ],
)
def test_a_value_that_is_none_is_refused(values, message):
    with pytest.raises(ArgumentError, match=re.escape(message)):
        Whisker.read(**{"theta": 2, "eta": 0.85, **STEEL, **values})


def test_the_example_is_read_and_an_option_overrides_it():
    path = ROOT / "examples" / "setup.toml"
    setup = RodFile.read(path)
    assert setup.whisker.theta == 2.0 and setup.whisker.tolerances["theta"] == 0.02
    assert setup.reading == {"transducer": "nano17-si-12-0.12"}
    assert setup.whisker.tolerances["moment_origin_x"] == pytest.approx(0.002)

    def solved(*more):
        asked = ["solve", "--rod", str(path), "--mu0", "0.3", *more]
        return CliRunner().invoke(app, asked)

    assert "0.47757141" in solved().output
    assert "no tolerance is used (theta, eta" in solved().output
    other = solved("--theta", "2.1").output
    assert "0.47581762" in other and "used (eta" in other


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("thata = 2", "there is no key thata; did you mean theta?"),
        ("theta = 2,0", "(at line 1"),
        ("theta: 2", "(at line 1"),
        ("theta = true", "theta is a number or a text in quotes, got True"),
        ('theta = 2\neta = "85 mm"', "has a unit, but the rod is not given"),
        ("theta = 2", "eta is not given"),
        ("tolerances = 2", "tolerances is a table"),
        ("theta = 2\neta = 0.85\n[tolerances]\nzero = 2", "there is no key zero"),
        ("theta = 2\neta = 0.85\n[tolerances]\neta = -0.1", "must not be negative"),
        ('theta = 2\neta = 0.85\ncontact = "flat"', "contact must be one of point, line"),
    ],
)
def test_a_mistake_in_a_rod_file_is_named(tmp_path, text, message):
    path = tmp_path / "setup.toml"
    path.write_text(text, encoding="utf-8")
    result = CliRunner().invoke(app, ["solve", "--rod", str(path), "--mu0", "0.3"])
    assert result.exit_code == 2
    assert message in result.stderr and result.stderr.count("\n") == 1


def test_a_file_that_is_no_rod_file_is_refused(tmp_path):
    with pytest.raises(ArgumentError, match="no such rod file"):
        keys_of(tmp_path / "a.toml")
    with pytest.raises(ArgumentError, match="written in TOML"):
        keys_of(tmp_path / "a.yaml")
    (tmp_path / "a.toml").write_bytes("curvature = 'ü'".encode("latin-1"))
    with pytest.raises(ArgumentError, match="not a text in UTF-8"):
        keys_of(tmp_path / "a.toml")
    with pytest.raises(ArgumentError, match="cannot be read"):
        keys_of(tmp_path)


def test_an_option_takes_the_place_of_its_alternative(tmp_path):
    path = tmp_path / "setup.toml"
    path.write_text("theta = 2\neta = 0.85\nclamp_compliance = 0.1\n")
    asked = ["solve", "--rod", str(path), "--mu0", "0.3"]
    with_stiffness = CliRunner().invoke(app, [*asked, "--clamp-stiffness", "20"])
    assert with_stiffness.exit_code == 0
    direct = ["solve", "--theta", "2", "--eta", "0.85", "--clamp-compliance", "0.05"]
    assert with_stiffness.stdout == CliRunner().invoke(app, [*direct, "--mu0", "0.3"]).stdout


def test_assumed_tolerances_follow_the_noise_and_the_size_of_the_rod():
    noise = np.array([0.01, np.nan, 0.001])
    own = assumed_tolerances(Units(), noise)
    assert own["zero_force_x"] == pytest.approx(0.03) and own["eta"] == 0.002
    assert "zero_force_y" not in own and "drift_force_y" not in own
    longer = Whisker.read(2, 0.85, **{**STEEL, "length": "200 mm"})
    assert assumed_tolerances(longer.units, noise)["eta"] == pytest.approx(0.001)


def test_solve_takes_the_material_of_a_rod_file(tmp_path):
    path = tmp_path / "rod.toml"
    size = 'theta = 2\neta = 0.85\ndiameter = "1 mm"\nlength = "100 mm"\nmodulus = "210 GPa"\n'
    asked = ["solve", "--rod", str(path), "--mu0", "0.3"]

    def said(last, *options):
        path.write_text(size + last)
        lines = CliRunner().invoke(app, [*asked, *options]).stdout.splitlines()
        return {line.split()[0]: line.split()[-1] for line in lines}

    wire = said('material = "music-wire"\ndensity = "7800 kg/m^3"\n')
    # It yields at 0.65 of 1840 MPa.
    over = 210e9 * float(wire["strain_most"]) / (0.65 * 1840e6)
    assert float(wire["strain_over_yield"]) == pytest.approx(over, rel=1e-6) and over > 1.0
    given = said('yield_strain = "0.012"\n')
    assert float(given["strain_over_yield"]) == pytest.approx(float(given["strain_most"]) / 0.012)
    # An option takes the place of either.
    assert "strain_over_yield" in said('yield_strain = "0.012"\n', "--material", "music-wire")
    assert "strain_over_yield" not in said("")
