"""What a tare tells, the zeros and their errors, travels with the recording to `identify`."""

import numpy as np
import pytest

from vibrissa.errors import ArgumentError
from vibrissa.sensor import Whisker, identify, scan, series, surfaces

ROD = {"modulus": "210 GPa", "diameter": "0.8 mm", "length": "100 mm"}
WHISKER = Whisker.read(2, "85 mm", **ROD)
ZEROS = {"zero_force_x": "0.5 mN", "zero_force_y": "2 mN", "zero_moment_z": "0.04 N*mm"}
HEADER = {name: f"310.2 ± {size}" for name, size in ZEROS.items()} | {"rate": "50 Hz"}


@pytest.fixture(scope="module")
def signals():
    """Noisy signals of three periods of sticking."""
    return scan(
        WHISKER,
        surfaces.constant(0.3),
        step="50 um",
        to=["8 mm"],
        law="kinetic",
        transducer="nano17-si-12-0.12",
    ).columns()


def tolerances_of(found):
    return {one.of: one.tolerance for one in found.tolerances if one.of in ZEROS and one.stated}


@pytest.mark.parametrize("name", ["a.csv", "a.parquet"])
@pytest.mark.parametrize("whisker", [WHISKER, None])
def test_identify_reads_the_errors_of_the_zeros(tmp_path, signals, whisker, name):
    series.write(tmp_path / name, signals, HEADER)
    told = ZEROS
    if whisker is None:  # the ratio of the forces has no moment
        told = {name: size for name, size in ZEROS.items() if name != "zero_moment_z"}
    travelled = identify(whisker, tmp_path / name)
    series.write(tmp_path / "retyped.csv", signals)
    retyped = identify(whisker, tmp_path / "retyped.csv", tolerances=told)
    assert set(tolerances_of(travelled)) == set(told)
    assert tolerances_of(travelled) == pytest.approx(tolerances_of(retyped))
    assert np.array_equal(travelled.periods.mu0, retyped.periods.mu0, equal_nan=True)


def test_a_stated_tolerance_goes_before_that_of_the_recording(tmp_path, signals):
    series.write(tmp_path / "a.csv", signals, HEADER)
    stated = Whisker.read(2, "85 mm", **ROD).tolerating({"zero_force_x": 0.0})
    found = identify(stated, tmp_path / "a.csv", tolerances={"zero_force_y": "7 mN"})
    force = WHISKER.units.channels[0]
    of = tolerances_of(found)
    assert "zero_force_x" not in of and of["zero_force_y"] == pytest.approx(7e-3 / force)


def test_a_wrong_line_of_the_header_is_named(tmp_path, signals):
    series.write(tmp_path / "a.csv", signals, {"zero_force_x": "1 ± 2 ± 3 mN"})
    with pytest.raises(ArgumentError, match=r"a\.csv: zero_force_x has one tolerance at most"):
        identify(WHISKER, tmp_path / "a.csv")
