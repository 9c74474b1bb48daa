"""A real rod from measured diameters and moduli."""

import numpy as np
import pandas as pd
import pytest

from vibrissa.cli.rod import run
from vibrissa.errors import ArgumentError
from vibrissa.sensor import Setup, measured_rod


def table(theta=3.0, rise=0.5, bump=0.0, rows=9, swap=1.0):
    """A cone of 1 mm x 50 mm whose modulus rises; its diameter and position may be wrong."""
    s = np.linspace(0.0, 1.0, rows)
    d = (1 - (1 - 1 / theta) * s) * (1 + bump * np.sin(np.pi * s))
    young = 3.0 * (1 + rise * s)
    columns = {"position [mm]": 50 * s * swap, "diameter [um]": 1e3 * d, "modulus [GPa]": young}
    return pd.DataFrame(columns)


def test_a_cone_is_found_as_it_was_made():
    found = measured_rod(table())
    assert found.is_cone
    assert found.theta == pytest.approx(3.0)
    assert (found.base, found.length) == pytest.approx((1e-3, 0.05))
    assert found.modulus == pytest.approx(3e9)
    assert found.stiffening == pytest.approx((0.5, 0.0), abs=1e-9)
    assert np.abs(found.stiffness_errors).max() < 1e-9
    whisker = Setup.read(eta=0.85, **found.keys()).whisker
    assert whisker.mounting.stiffening[0] == pytest.approx(0.5, rel=1e-5)


def test_what_is_no_cone_says_so_and_its_stiffness_has_the_measured_diameters():
    found = measured_rod(table(bump=0.1), degree=4)
    assert not found.is_cone
    assert np.abs(found.stiffness_errors).max() < 0.01
    assert any("no cone within 0.02" in line for line in found.report())
    assert measured_rod(table(bump=0.1), tolerance=0.2).is_cone


def test_a_step_is_not_followed():
    stepped = table(theta=1.0)
    stepped.loc[4:, "diameter [um]"] = 700.0
    text = " ".join(measured_rod(stepped).report())
    assert "steps cannot be followed" in text and "no cone" in text


@pytest.mark.parametrize(
    ("given", "degree", "said"),
    [
        (table(swap=-1.0), 2, "position must increase from clamp to tip; row"),
        (table(theta=0.5), 2, "allowed: a taper from 1 to 50"),
        (table(rows=3), 2, "a fit with 2 coefficients needs 4 rows, got 3"),
        (table(), 9, "degree must lie between 1 and 8, got 9"),
        (table().rename(columns={"position [mm]": "position"}), 2, "position has no unit"),
        (table().rename(columns={"modulus [GPa]": "modulus [mm]"}), 2, "modulus"),
        (table(rise=-1.0), 2, "modulus must be positive; row"),
    ],
)
def test_a_table_that_no_rod_fits_is_refused(given, degree, said):
    with pytest.raises(ArgumentError) as error:
        measured_rod(given, degree)
    assert said in str(error.value)


def test_the_command_writes_a_set_up_and_a_picture(tmp_path):
    path, setup, picture = (tmp_path / name for name in ("rod.csv", "rod.toml", "rod.svg"))
    table().to_csv(path, index=False)
    run(path, setup, picture)
    assert Setup.read(setup, eta=0.85).whisker.theta == pytest.approx(3.0)
    assert "bending stiffness" in picture.read_text() or picture.stat().st_size > 5000
