"""The set-up: quantities with tolerances, the file, and the defaults."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given as hypothesis_given
from hypothesis import strategies as st

from vibrissa.errors import ArgumentError
from vibrissa.quantities.keys import read_keys, write_keys
from vibrissa.quantities.units import Measured, Units
from vibrissa.sensor import Setup
from vibrissa.sensor.tolerances import assumed_tolerances

ROOT = Path(__file__).parents[2]
STEEL = {"modulus": "210 GPa", "diameter": "1 mm", "length": "100 mm"}


@pytest.mark.parametrize(
    ("text", "value", "tolerance"),
    [
        ("210 GPa +/- 2 %", "210 GPa", "2 %"),
        ("210±5GPa", "210 GPa", "5GPa"),
        ("0.21 TPa ± 5 GPa", "0.21 TPa", "5 GPa"),
        ("2° ± 0.5°", "2°", "0.5°"),
        ("2e11 ± 5e-1 Pa", "2e11 Pa", "5e-1 Pa"),
        ("-2 ± 0.1 m^-1", "-2 m^-1", "0.1 m^-1"),
        ("2 ± 0.02", "2", "0.02"),
        ("2.00(2)", "2.0", "0.02"),
        ("85 mm ± 2", "85 mm", "2 mm"),
        ("210 GPa", "210 GPa", None),
        (0.85, 0.85, None),
    ],
)
def test_a_quantity_is_split_from_its_tolerance(text, value, tolerance):
    assert Measured.read(text) == Measured(value, tolerance)


@hypothesis_given(
    st.decimals("0.001", "1000", places=3), st.decimals("0.001", "10", places=3), st.booleans()
)
def test_every_spelling_means_the_same(value, tolerance, spaced):
    gap = " " if spaced else ""
    spellings = (
        f"{value}{gap}±{gap}{tolerance} mm",
        f"({value}{gap}+/-{gap}{tolerance}) mm",
        f"{value} mm +- {tolerance} mm",
        f"{value}({round(tolerance * 1000)}) mm",
    )
    read = [
        Setup.read(theta=2, eta=0.85, **{**STEEL, "length": text}).whisker for text in spellings
    ]
    for one in read:
        assert one.rod.length == pytest.approx(float(value) * 1e-3, rel=1e-14)
        assert one.tolerances["length"] == pytest.approx(float(tolerance / value))


def test_tolerances_are_in_units_of_the_rod():
    whisker = Setup.read(
        theta="2 ± 1 %",
        eta="85 ± 0.1 mm",
        modulus="210 ± 5 GPa",
        diameter="1 mm ± 0.5 %",
        length="100 ± 0.1 mm",
        clamp_angle="0 ± 0.3 deg",
        clamp_compliance="0.05 ± 0.005 rad/(N*m)",
        tolerances={"stage_scale": 0.01},
    ).whisker
    assert whisker.tolerances == pytest.approx(
        {
            "theta": 0.02,
            "eta": 0.001,
            "modulus": 5 / 210,
            "diameter": 0.005,
            "length": 0.001,
            "stage_scale": 0.01,
            "clamp_angle": np.deg2rad(0.3),
            "clamp_compliance": 0.1 * whisker.mounting.clamp_compliance,
        }
    )
    assert whisker.mounting.clamp_compliance == pytest.approx(whisker.rod.moment_unit / 20)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"theta": "1 ± 2 ± 3"}, "the tolerance of theta must be a number, got '2 ± 3'"),
        ({"eta": "1 ± -2 mm"}, "the tolerance of eta must not be negative"),
        ({"eta": "± 2 mm"}, "eta must be a length with a unit such as m, got ''"),
        ({"theta": "2 ± 1 mm"}, "theta must be a number, got '2 mm'"),
        ({"theta": "2,1"}, "write a decimal point"),
        ({"theta": True}, "theta must be a number or a text in quotes, got True"),
        ({"eta": "0.85 ± 1 deg"}, "eta must be a length"),
        ({"eta": "110 mm"}, "eta must lie between 0 and the length of the rod, 100 mm"),
        ({"clamp_angle": "0 ± 2 %"}, "the tolerance of clamp_angle is 2 %, but clamp_angle is 0"),
        ({"length": None}, "a rod needs modulus, diameter and length; missing: length"),
        ({"modulus": None, "diameter": None, "length": None, "eta": "8 mm"}, "rod is not given"),
        ({"clamp_angle": "2 mm"}, "clamp_angle must be an angle with a unit such as rad"),
        ({"clamp_angle": 0.5}, "clamp_angle needs a unit: '0.5 deg' or '0.5 rad'"),
        ({"clamp_angle": "100 deg"}, "clamp_angle must lie between -pi/2 and pi/2"),
        ({"curvature": "0.1, 0.2"}, "curvature must be a curvature with a unit such as m^-1"),
        ({"noise": "1 mN, 2 mN"}, "noise needs three values"),
        ({"contact": "flat"}, "contact: input should be 'point' or 'line', got 'flat'"),
        ({"yield_strain": "-1"}, "yield_strain: input should be greater than 0, got '-1'"),
        ({"tolerances": {"zero": 2}}, "a tolerance must be for one of theta, eta"),
        ({"tolerances": {"eta": "-1 mm"}}, "the tolerance of eta must not be negative"),
        ({"tolerances": {"eta": "2 deg"}}, "the tolerance of eta must be a length"),
        ({"tolerances": {"zero_force_x": "2 %"}}, "is 2 %, but zero_force_x is 0 or not given"),
        ({"tolerances": 2}, "tolerances: input should be a valid dictionary"),
        ({"thata": 2}, "'thata' is not a key; did you mean theta?"),
        ({"theta": None}, "theta is not given"),
    ],
)
def test_a_value_that_is_not_allowed_is_refused(values, message):
    with pytest.raises(ArgumentError, match=re.escape(message)):
        _ = Setup.read(**{"theta": 2, "eta": 0.85, **STEEL, **values}).whisker


def test_all_errors_are_reported_together(tmp_path):
    path = tmp_path / "setup.toml"
    path.write_text('thata = 2\neta = "1 GPa"\ncontact = "flat"\n[tolerances]\nzero = 1\n')
    with pytest.raises(ArgumentError) as raised:
        Setup.read(path, clamp_angle="2 mm")
    lines = str(raised.value).splitlines()
    assert len(lines) == 5
    # An error in the file names the file.
    assert [line.startswith(f"{path}: ") for line in lines].count(False) == 1
    for name in ("thata", "eta", "contact", "clamp_angle", "zero"):
        assert any(name in line for line in lines), name


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.toml", "curvature = 'ü'".encode("latin-1"), "cannot be read as TOML in UTF-8"),
        ("a.toml", b"theta = 2,0", "(at line 1"),
        ("a.toml", b"theta: 2", "(at line 1"),
    ],
)
def test_a_file_that_cannot_be_read_is_refused(name, content, message, tmp_path):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(ArgumentError, match=re.escape(message)):
        Setup.read(tmp_path / name)


def test_an_option_takes_the_place_of_a_key_and_of_its_alternative(tmp_path):
    setup = Setup.read(ROOT / "examples" / "setup.toml", theta="2.1", noise="1, 2, 3")
    assert setup.transducer is None and setup.whisker.theta == 2.1
    assert "theta" not in setup.whisker.tolerances and "eta" in setup.whisker.tolerances
    path = tmp_path / "setup.toml"
    keys = {"theta": 2, "eta": "0.85", "tolerances": {"eta": "1 %", "theta": "1 %"}}
    write_keys(path, keys, "made by a test")
    assert path.read_text().startswith("# made by a test\n")
    assert read_keys(path) == keys
    both = Setup.read(path, tolerances={"theta": "exact"}).whisker.tolerances
    assert both == pytest.approx({"eta": 0.0085, "theta": 0.0})


def test_default_tolerances_follow_the_noise_and_the_size_of_the_rod():
    noise = np.array([0.01, np.nan, 0.001])
    own = assumed_tolerances(Units(), noise)
    assert own["zero_force_x"] == pytest.approx(0.03) and own["eta"] == 0.002
    assert "zero_force_y" not in own and "drift_force_y" not in own
    longer = Setup.read(theta=2, eta=0.85, **{**STEEL, "length": "200 mm"}).whisker
    assert assumed_tolerances(longer.units, noise)["eta"] == pytest.approx(0.001)
    whole = Setup.read(theta=2, eta=0.85, **{**STEEL, "length": "1 m"}).whisker
    assert assumed_tolerances(whole.units, noise)["eta"] == pytest.approx(0.0002)
