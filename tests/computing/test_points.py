"""Rows of grid points: what they hold, and that a chunk's file is the one that is asked for."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

import made_tables
from vibrissa import Mounting, solve_curve
from vibrissa.computing.points import solved_points_of_file
from vibrissa.computing.rods import rods_of
from vibrissa.errors import DamagedTableError, StudyError
from vibrissa.outcomes import Solver
from vibrissa.sticking.curve import failed_curve
from vibrissa.study.chunks import ROW_ORDER, Chunk, columns_at, number_of_points
from vibrissa.study.reading import read_study
from vibrissa.tables import query, store
from vibrissa.tables.schemas import STICTION

SOLVER = {"method": "collocation"}
FAILED = failed_curve(theta=9.0, eta=0.85, method="collocation", message="no luck; try less")


@pytest.fixture(scope="module")
def axes():
    return made_tables.grid(theta=(1.0, 2.0), mu0=(0.2, 0.4, 3.0), dx0=(0.001, 0.01))


@pytest.fixture(scope="module")
def table(axes):
    return made_tables.points("g", axes)


@pytest.mark.parametrize("dx0", [0.001, 0.01])
def test_a_row_is_what_a_single_curve_answers(table, dx0):
    """Bit for bit the same rod may differ in the last digits: it is solved with others."""
    rows = [row for row in table.to_pylist() if row["dx0"] == dx0]
    assert [row["status"] for row in rows] == ["slip", "slip", "lock"] * 2
    for row in rows:
        curve = solve_curve(row["theta"], 0.85)
        assert row["mu_lock"] == pytest.approx(curve.mu_lock, abs=1e-12)
        if row["status"] == "slip":
            onset = float(curve.onset(row["mu0"]))
            assert row["x0_slip"] == pytest.approx(onset, abs=1e-12)
            assert row["n_steps"] == int(onset / dx0) and row["x0_max"] <= onset
            slip = curve.state(np.array([onset]))
            assert row["reaction_m_slip"] == pytest.approx(slip.reaction_m[0], abs=1e-11)
            assert row["ends_by"] is None and row["x0_end"] is None
        else:
            assert row["x0_slip"] is None and row["n_steps"] is None
            assert row["ends_by"] == "swings_aside"


@pytest.mark.slow
def test_a_job_that_solves_points_loads_no_library_that_it_does_not_need():
    # Each takes a third of a second, and every job would load them again.
    code = (
        "import made_tables, sys\n"
        "made_tables.points('g', made_tables.grid(theta=(1.0, 2.0)))\n"
        "print(*{'scipy', 'pandas'} & set(sys.modules), file=sys.stderr)"
    )
    path = [str(Path(__file__).parent.parent), *sys.path]
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(path)},
    )
    assert done.stderr.strip() == ""


def test_the_axes_are_in_their_rows(axes, table):
    keys = columns_at(axes, np.arange(number_of_points(axes)))
    for axis in ROW_ORDER:
        assert table[axis].to_pylist() == keys[axis].tolist()
    assert set(table["grid"].to_pylist()) == {"g"}


def test_a_rod_that_passes_through_the_surface_before_it_slips_is_marked():
    """Also where the last step is before that: the exact onset counts."""
    axes = made_tables.grid(theta=(1.0,), mu0=(1.0,), eta=(0.5,), dx0=(0.1,))
    (row,) = made_tables.points("g", axes).to_pylist()
    assert row["phi1_last"] > 0.0 > row["phi1_slip"] and row["penetrates"]


def test_what_failed_has_its_reason_and_no_numbers():
    axes = made_tables.grid(theta=(9.0,))
    for row in made_tables.points("g", axes, curves=[FAILED]).to_pylist():
        assert (row["status"], row["message"]) == ("failed", "no luck; try less")
        assert row["x0_slip"] is row["mu_lock"] is row["penetrates"] is row["residual"] is None


def test_a_rod_of_any_stiffness_is_that_of_its_mounting():
    stiffening = (0.5, (0.8, -0.3))
    axes = made_tables.grid(theta=(2.0,), mu0=(0.3,), stiffening=stiffening, bore=(0.3,))
    table = made_tables.points("g", axes)
    keys = columns_at(axes, np.arange(number_of_points(axes)))
    for name in ("stiffening", "stiffening_powers", "bore"):
        assert table[name].to_pylist() == keys[name].tolist()
    assert table["stiffening_powers"].to_pylist()[-1] == "-0.3"
    last = {row["stiffening"]: row["x0_slip"] for row in table.to_pylist()}
    for value, first in zip(stiffening, (0.5, 0.8), strict=True):
        curve = solve_curve(2.0, 0.85, mounting=Mounting(stiffening=value, bore=0.3))
        assert last[first] == pytest.approx(float(curve.onset(0.3)), abs=1e-11)


def test_mountings_and_polynomials_are_kept():
    axes = made_tables.grid(curvature=(-0.1, (0.0, -0.3)), clamp_angle=(0.0, 0.02))
    rows = made_tables.points("g", axes).to_pylist()
    assert [(r["clamp_angle"], r["curvature"], r["curvature_powers"]) for r in rows[::2]] == [
        (0.0, -0.1, None),
        (0.0, 0.0, "-0.3"),
        (0.02, -0.1, None),
        (0.02, 0.0, "-0.3"),
    ]
    assert len({row["x0_slip"] for row in rows}) == 8


def test_a_solver_that_walks_along_the_steps_has_a_rod_for_each():
    axes = made_tables.grid(theta=(1.0, 2.0), dx0=(0.001, 0.01))
    assert [rod["dx0"] for rod in rods_of(axes, by_step=True)] == [0.001, 0.01] * 2
    assert [rod["dx0"] for rod in rods_of(axes, by_step=False)] == [None] * 2


@pytest.mark.nightly
@pytest.mark.slow
def test_both_methods_find_the_same():
    # As in another test, which keeps the curve.
    axes = made_tables.grid(theta=(2.0,), mu0=(0.1,), eta=(0.98,), dx0=(0.012,))
    (one,) = made_tables.points("g", axes).to_pylist()
    shooting = made_tables.SOLVER._replace(method=Solver.SHOOTING)
    curves = made_tables.solve(rods_of(axes, by_step=True), shooting)
    (other,) = made_tables.points("g", axes, curves=curves).to_pylist()
    assert other["method"] == "shooting" and other["n_steps"] == one["n_steps"]
    assert other["x0_slip"] == pytest.approx(one["x0_slip"], abs=1e-8)


@pytest.fixture
def chunk(tmp_path, axes, table):
    path = tmp_path / "chunk.parquet"
    store.write(table, path, Chunk(grid="g", axes=axes).study_part(SOLVER))
    return path


def rows_of(path, grid, axes, solver):
    part = Chunk(grid=grid, axes=axes).study_part(solver)
    return query.batches(query.opened(path, STICTION, part), STICTION.names)


def test_the_file_of_a_chunk_is_read_as_it_was_written(chunk, axes, table):
    assert pa.concat_tables(rows_of(chunk, "g", axes, SOLVER)).equals(table)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"mu0": (0.2, 0.4)}, "mu0: (0.2, 0.4, 3.0)"),
        ({"mu0": (0.2, 0.4, 5.0)}, "mu0: (0.2, 0.4, 3.0)"),
        ({"theta": (1.0, 2.5)}, "theta: (1.0, 2.0)"),
        ({"curvature": (-0.1,)}, "curvature: (0.0,)"),
        ({"curvature": ((0.0, 1.0),)}, "curvature: (0.0,)"),
        ({"grid": "h"}, "grid: g"),
        ({"solver": {"method": "another"}}, "method: collocation"),
    ],
)
def test_a_chunk_of_another_study_file_is_refused(chunk, axes, change, words):
    wanted = axes | {key: value for key, value in change.items() if key in axes}
    grid, solver = change.get("grid", "g"), change.get("solver", SOLVER)
    with pytest.raises(DamagedTableError) as error:
        list(rows_of(chunk, grid, wanted, solver))
    assert f"was made from another study file, which has the line '{words}'" in str(error.value)
    assert error.value.path == chunk


POINTS = "theta,mu0,eta,dx0\n2,0.4,0.85,0.01\n1,3,0.85,0.001\n2,0.2,0.85,0.001\n1,0.2,0.85,0.01\n"


@pytest.fixture
def points(tmp_path):
    """A study with points in a file, and the rows of its chunks."""

    def solved(text=POINTS, most=2):
        (tmp_path / "mine.csv").write_text(text)
        path = tmp_path / "my.yaml"
        path.write_text(f"study: a\nchunk: {{rods: {most}}}\ngrids: {{g: {{points: mine.csv}}}}\n")
        study = read_study(path)
        return study, lambda: [
            row
            for chunk in study.chunks.values()
            for part in solved_points_of_file(**chunk.params, study="a", solver=made_tables.SOLVER)
            for row in part.to_pylist()
        ]

    return solved


def test_points_of_a_file_are_those_of_a_grid(points, table):
    _, solved = points()
    rows = solved()
    assert [(row["theta"], row["mu0"]) for row in rows] == [(2, 0.4), (2, 0.2), (1, 3), (1, 0.2)]
    known = {tuple(row[axis] for axis in ROW_ORDER): row for row in table.to_pylist()}
    for row in rows:
        same = known[tuple(row[axis] for axis in ROW_ORDER)]
        for name, value in same.items():
            if isinstance(value, float):
                assert row[name] == pytest.approx(value, abs=1e-9), name
            elif name != "study":
                assert row[name] == value, name


def test_points_do_not_depend_on_their_chunks(points):
    for one, other in zip(points()[1](), points(most=1)[1](), strict=True):
        assert one["status"] == other["status"] and one["n_steps"] == other["n_steps"]
        assert one["x0_slip"] == pytest.approx(other["x0_slip"], abs=1e-12)


def test_a_file_that_changes_while_a_study_runs_ends_it(points, tmp_path):
    _, solved = points()
    (tmp_path / "mine.csv").write_text(POINTS.replace("0.4", "0.41"))
    with pytest.raises(StudyError, match=r"mine\.csv has changed since the run began; run the sa"):
        solved()
