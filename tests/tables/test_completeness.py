"""Grid points that are missing, doubled or foreign are found as a table passes."""

import pyarrow as pa
import pytest

from made_up import COMPLETE, GRIDS, grid
from vibrissa.errors import TableError
from vibrissa.study.grid import study_points
from vibrissa.tables import completeness
from vibrissa.tables.completeness import checked_points
from vibrissa.tables.schemas import STICTION


def test_points_are_made_some_at_a_time(monkeypatch):
    monkeypatch.setattr(completeness, "ROWS", 12)
    sizes = [len(table) for table in completeness._tables(study_points(GRIDS))]
    assert sum(sizes) == len(COMPLETE)
    assert min(sizes[:-1]) >= 12 and max(sizes) < 12 + 10


@pytest.fixture(params=[(1, 13), (10, 4), (10, 100), (completeness.ROWS, 1000)], ids=str)
def size(request, monkeypatch):
    """Rows of a part of the table; and how many points are compared together, at least."""
    together, size = request.param
    monkeypatch.setattr(completeness, "ROWS", together)
    return size


@pytest.mark.slow
def test_a_complete_table_passes_in_parts_of_any_size(size):
    made = [COMPLETE.slice(i, size) for i in range(0, len(COMPLETE), size)]
    assert pa.concat_tables(checked_points(made, GRIDS)).equals(COMPLETE)


def without(*rows):
    return COMPLETE.take([i for i in range(len(COMPLETE)) if i not in rows])


def renamed(row, names):
    grids = COMPLETE["grids"].to_pylist()
    grids[row] = names
    position = STICTION.get_field_index("grids")
    return COMPLETE.set_column(position, STICTION.field(position), pa.array(grids))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("table", "problem", "example"),
    [
        (without(0), "lacks 1 grid point", "(0.1, 0.1, 0.1, 0.1)"),
        (without(4, 13), "lacks 2 grid points", "(0.1, 0.3, 0.1, 0.1), (0.2, 0.2, 0.1, 0.2)"),
        (
            without(*range(10)),
            "lacks 10 grid points",
            "(0.1, 0.1, 0.1, 0.1), (0.1, 0.1, 0.1, 0.2), (0.1",
        ),
        (
            COMPLETE.slice(0, len(COMPLETE) - 9),
            "lacks 9 grid points",
            "(0.5, 0.4, 0.5, 0.2), (0.6, 0.1, 0",
        ),
        (COMPLETE.slice(0, 0), f"lacks {len(COMPLETE)} grid points", "(0.1, 0.1, 0.1, 0.1)"),
        (
            pa.concat_tables([COMPLETE.slice(0, 12), COMPLETE.slice(11)]),
            "has 1 grid point more than once",
            "(0.2, 0.1, 0.1, 0.2)",
        ),
        (
            renamed(2, ["main"]),
            "has 1 grid point with the names of other grids",
            "(0.1, 0.2, 0.1, 0.1)",
        ),
    ],
    ids=["first", "two", "curve", "last", "all", "doubled", "grids"],
)
def test_a_wrong_set_of_points_is_refused_with_examples(table, problem, example, size):
    made = [table.slice(i, size) for i in range(0, len(table), size)]
    message = rf"stiction {problem}, such as \(theta, mu0, eta, dx0\) = "
    with pytest.raises(TableError, match=message) as error:
        list(checked_points(made, GRIDS))
    assert example in str(error.value) and str(error.value).count("), (") < 3
    assert "delete the study's blocks folder and run again" in str(error.value)


@pytest.mark.parametrize(
    ("grids", "count", "example"),
    [
        ({"main": grid(), "more": grid(theta=2)}, 20, "(0.1, 0.5, 0.1, 0.1)"),
        ({"main": grid(eta=4), "more": grid(theta=2, mu0=5, eta=4)}, 52, "(0.1, 0.1, 0.5, 0.1)"),
    ],
    ids=["pairs", "curves"],
)
def test_points_that_do_not_belong_are_refused(grids, count, example):
    with pytest.raises(TableError, match=f"has {count} grid points too many") as error:
        list(checked_points([COMPLETE], grids))
    assert example in str(error.value)
