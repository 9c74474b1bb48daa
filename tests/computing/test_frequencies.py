"""Natural frequencies as columns of the tables, only if a study asks for them."""

import numpy as np
import pytest

import made_tables
from vibrissa import solve_curve, solve_state, stick_slip
from vibrissa.computing.points import points_table
from vibrissa.computing.scans import scan_tables
from vibrissa.computing.states import states_table
from vibrissa.errors import StudyError
from vibrissa.study.axes import FREQUENCIES
from vibrissa.study.chunks import number_of_points
from vibrissa.study.reading import read_study

AXES = made_tables.grid(theta=(1.0, 2.0), mu0=(0.2, 0.4, 0.5), dx0=(0.001, 0.005))
CURVES = [solve_curve(theta, 0.85) for theta in (1.0, 2.0)]


def table(count):
    rows = np.arange(number_of_points(AXES))
    return points_table("main", AXES, rows, CURVES, "a", count).to_pandas()


def test_points_have_the_frequencies_at_their_onsets():
    found = table(2)
    for theta, curve in zip((1.0, 2.0), CURVES, strict=True):
        rows = found[(found["theta"] == theta) & (found["status"] == "slip")]
        expected = curve.frequencies(rows["x0_slip"].to_numpy(), 2)
        assert rows[[*FREQUENCIES]].to_numpy() == pytest.approx(expected, rel=1e-9)
    locked = found[found["status"] == "lock"]
    assert len(locked) and locked[[*FREQUENCIES]].isna().all(axis=None)


def test_fewer_frequencies_leave_columns_empty():
    assert table(0)[[*FREQUENCIES]].isna().all(axis=None)
    one = table(1)
    assert one["frequency_1"].notna().any()
    assert one["frequency_2"].isna().all()


def test_scans_and_states_have_the_frequencies_of_their_states():
    curve = CURVES[1]
    point = {name: one for name, (one,) in made_tables.grid((2.0,), (0.3,), (0.85,)).items()}
    scan = stick_slip(curve, 0.3, 0.01, 2)
    made = scan_tables(
        "runs", point, scan, study="a", method=curve.method, shapes=False, frequencies=2
    ).steps.to_pandas()
    expected = curve.frequencies(made["x0"].to_numpy(), 2)
    assert made[[*FREQUENCIES]].to_numpy() == pytest.approx(expected, rel=1e-9)
    state = solve_state(2.0, 0.85, 0.38)
    (row,) = states_table({"one": state}, "a", 2).to_pylist()
    assert [row[name] for name in FREQUENCIES] == pytest.approx(state.frequencies(2))


def test_a_figure_of_frequencies_needs_them():
    grid = {"theta": [1, 2], "mu0": 0.3, "eta": 0.85, "dx0": 0.001}
    study = {"study": "a", "grids": {"main": grid}}
    study["figures"] = {"over": {"kind": "frequencies", "grid": "main"}}
    with pytest.raises(StudyError, match="this kind needs `frequencies: 1` or 2"):
        read_study(None, study)
    assert read_study(None, study | {"frequencies": 2}).frequencies == 2
    with pytest.raises(StudyError, match="frequencies"):
        read_study(None, study | {"frequencies": 3})
