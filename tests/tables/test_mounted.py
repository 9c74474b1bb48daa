"""Curvatures that are polynomials, from the study file to the table and the figure."""

import pyarrow as pa
import pytest

from vibrissa.errors import ArgumentError, TableError
from vibrissa.figures.draw import draw
from vibrissa.sticking.solving.collocation import solve_curves
from vibrissa.study.grid import study_points
from vibrissa.study.parsing import parse_study
from vibrissa.tables import store
from vibrissa.tables.collect import collect
from vibrissa.tables.completeness import POINT_ORDER, checked_points
from vibrissa.tables.mounted import mounting_of
from vibrissa.tables.points import points_tables
from vibrissa.tables.schemas import STICTION

POLYNOMIALS = [[-0.05, 0.1], [-0.05, -0.3], [-0.05, -0.1, 0.2]]
AXES = {"theta": [1, 2], "mu0": [0.2, 0.9], "eta": [0.85], "dx0": [0.001], "clamp_angle": [0, 0.02]}
STUDY = parse_study(
    {"study": "a", "grids": {"main": {**AXES, "curvature": [0, -0.05, 0.1, *POLYNOMIALS]}}}
)
POINTS = list(study_points(STUDY.point_grids))


@pytest.fixture(scope="module")
def tables():
    """One for each curve, from the last to the first."""
    keys = [key for key, _ in POINTS]
    rods = ([float(getattr(key, name)) for key in keys] for name in ("theta", "eta"))
    curves = solve_curves(*rods, mountings=[mounting_of(key.mounting) for key in keys])
    return [
        table
        for (_, points), curve in reversed(list(zip(POINTS, curves, strict=True)))
        for table in points_tables([(points, curve)], "a")
    ]


@pytest.fixture
def collected(tables, tmp_path):
    paths = [tmp_path / f"{i}.parquet" for i in range(len(tables))]
    for table, path in zip(tables, paths, strict=True):
        store.write(table, path)
    return pa.concat_tables(collect(paths, STICTION, POINT_ORDER).parts)


@pytest.mark.slow
def test_the_table_has_each_point_in_the_order_of_the_curves(collected):
    passed = pa.concat_tables(checked_points([collected], STUDY.point_grids))
    assert len(passed) == 48
    found = collected.select(["curvature", "curvature_powers"]).slice(0, 12).to_pylist()
    expected = [(-0.05, None), (-0.05, "-0.1, 0.2"), (-0.05, "-0.3"), (-0.05, "0.1")]
    expected += [(0.0, None), (0.1, None)]
    assert [tuple(row.values()) for row in found[::2]] == expected


def test_points_of_a_polynomial_that_are_missing_are_named(collected):
    mask = [row["curvature_powers"] != "0.1" for row in collected.to_pylist()]
    missing = r"lacks 8 grid points, such as \(theta, mu0, .*curvature, curvature_powers, "
    with pytest.raises(TableError, match=missing) as error:
        list(checked_points([collected.filter(pa.array(mask))], STUDY.point_grids))
    assert "(1, 0.2, 0.85, 0.001, 0, 0, -0.05, '0.1', 0)" in str(error.value)


@pytest.mark.slow
@pytest.mark.parametrize("curvature", [0, -0.05, [-0.05, 0.1], [-0.05, -0.1, 0.2]])
def test_a_figure_shows_the_rods_of_one_curvature(collected, curvature):
    entry = {"kind": "mounting", "grid": "main", "over": "clamp_angle", "mu0": 0.2}
    study = {"study": "a", "grids": {"main": {**AXES, "curvature": [0, -0.05, *POLYNOMIALS]}}}
    figures = {"f": {**entry, "curvature": curvature}}
    selection = parse_study({**study, "figures": figures}).figures["f"].selection()
    figure = draw("mounting", collected, selection)
    # A line for each taper, with a point for each inclination.
    assert [len(line.get_xdata()) for line in figure.axes[0].lines] == [2, 2]
    with pytest.raises(ArgumentError, match="no rows to draw"):
        draw("mounting", collected, selection | {"curvature": "-0.05, 0.2"})
