"""Heights from files of profilometers, which surfalize writes here as instruments do."""

import warnings

import numpy as np
import pytest
from typer.testing import CliRunner

from vibrissa.cli.app import app
from vibrissa.errors import ArgumentError, RecordingError
from vibrissa.quantities import series
from vibrissa.sensor.topography import read_row

surfalize = pytest.importorskip("surfalize")
# Spacing in um, and an area that is tilted by 2 um in 100.
SPACING, ROWS, COLUMNS = 2.0, 30, 400
X = SPACING * np.arange(COLUMNS)
WAVE = 3.0 * np.sin(2.0 * np.pi * X / 100.0)


@pytest.fixture
def written(tmp_path):
    """Write an area whose rows differ by a step, as a file of a format."""

    def write(ending, holes=()):
        height = WAVE + 0.02 * X + 0.5 * SPACING * np.arange(ROWS)[:, None]
        height = height - height.mean()
        for row, column in holes:
            height[row, column] = np.nan
        path = tmp_path / f"area{ending}"
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            surfalize.Surface(height, SPACING, SPACING).save(path)
        return path

    return write


@pytest.mark.slow
@pytest.mark.parametrize("ending", [".x3p", ".sdf", ".sur"])
def test_a_row_is_levelled_in_metres(written, ending):
    found = read_row(written(ending))
    assert found.x == pytest.approx(1e-6 * X, abs=1e-12)
    # All rows are equal but for a step, so that the plane is the line of a row.
    expected = WAVE - np.polyval(np.polyfit(X, WAVE, 1), X)
    assert found.height == pytest.approx(1e-6 * expected, abs=1e-9)
    assert "area" in found.about and "row 15 of 30" in found.about
    assert "levelled by a least-squares plane; no filter" in found.about


def test_missing_points_are_filled_and_counted(written):
    whole = read_row(written(".sdf"), row=3)
    holed = read_row(written(".sdf", [(2, 0), (2, 11), (2, 12), (4, 9)]), row=3)
    assert "3 points of the row missing" in holed.about
    assert len(holed.x) == len(whole.x) - 1 and holed.x[0] == 0.0
    near = holed.height - whole.height[1:]
    assert np.abs(near).max() < 1e-6 and np.abs(near[20:]).max() < 2e-8


def test_a_filter_takes_short_waves_and_is_named(written):
    found = read_row(written(".sdf"), cutoff=1e-3)
    assert np.abs(found.height[50:-50]).max() < 0.2e-6
    assert "Gaussian low-pass filter, cutoff 1000 um" in found.about
    kept = read_row(written(".sdf"), cutoff=1e-5)
    assert np.abs(kept.height[50:-50]).max() > 2.5e-6


def test_files_that_cannot_be_used_are_refused(written, tmp_path):
    with pytest.raises(ArgumentError, match="has 30 rows, but row 31 is chosen"):
        read_row(written(".sdf"), row=31)
    with pytest.raises(ArgumentError, match="from 0 on"):
        read_row(written(".sdf"), cutoff=-1.0)
    damaged = tmp_path / "damaged.x3p"
    damaged.write_bytes(b"PK\x03\x04 nothing")
    with pytest.raises(RecordingError, match=r"damaged\.x3p cannot be read as a file of a profilo"):
        read_row(damaged)
    with pytest.raises(RecordingError, match="there is no file"):
        read_row(tmp_path / "absent.sur")
    with pytest.raises(RecordingError, match="fewer than two measured points"):
        read_row(written(".sdf", [(0, column) for column in range(COLUMNS - 1)]), row=1)


@pytest.mark.slow
def test_a_scan_over_a_row_names_it_in_its_table(written, tmp_path):
    path, small = tmp_path / "scan.csv", "--modulus 3GPa --diameter 0.1mm --length 10mm"
    told = f"scan --theta 2 --eta 8.5mm {small} --mu0 0.3 --step 4um --to 0.3mm"
    more = ["--heights", str(written(".x3p")), "--heights-start", "4.0 mm", "--heights-row", "4"]
    result = CliRunner().invoke(app, [*told.split(), *more, "-o", str(path)])
    assert result.exit_code == 0, result.output
    assert "# heights = area.x3p, row 4 of 30; spacing 2 um; levelled" in path.read_text()
    found = series.read(path, ["contact", "height", "inclination"]).columns
    assert len(set(found["contact"])) > 1
    expected = np.interp(found["contact"] - 4e-3, 1e-6 * X, read_row(written(".x3p"), 4).height)
    assert found["height"] == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--heights-row", "2"], "heights_row needs a file of heights"),
        (["--heights-start", "1 mm"], "heights_start needs a file of heights"),
        (["--heights", "area.x3p"], "give the rod's modulus, diameter and length"),
    ],
)
def test_options_of_heights_without_a_file_or_a_size_are_refused(more, words):
    told = "scan --theta 2 --eta 0.85 --mu0 0.3 --step 0.001 --to 0.1 -o -"
    result = CliRunner().invoke(app, [*told.split(), *more])
    assert result.exit_code == 2 and words in " ".join(result.output.split())
