"""Many tables as one: order, completeness, bounded memory, and how little a query reads."""

from decimal import Decimal

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.dataset
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibrissa import tables
from vibrissa.collecting import POINT_ORDER, _least, _merged, checked_points, collect
from vibrissa.grid import Grid, study_points
from vibrissa.tables import SCANS, STICTION, TableError

AGAIN = "delete it and run again, it is made anew"
COUNTS = {"theta": 6, "mu0": 4, "eta": 5, "dx0": 2}


def grid(**counts):
    """A grid with so many values on each axis."""
    axes = [range(1, counts.get(name, count) + 1) for name, count in COUNTS.items()]
    return Grid(*(tuple(Decimal(i) / 10 for i in axis) for axis in axes))


# The second lies within the first, and reaches beyond it.
GRIDS = {"main": grid(), "more": grid(theta=2, mu0=5)}


def point_table(points):
    """Made-up results at grid points: (theta, mu0, eta, dx0) with the names of the grids."""
    columns = {}
    for field in STICTION:
        if field.name in ("theta", "mu0", "eta", "dx0"):
            position = ("theta", "mu0", "eta", "dx0").index(field.name)
            values = [float(point[position]) for point, _ in points]
        elif field.name == "grids":
            values = [names for _, names in points]
        elif field.type == pa.string():
            values = ["slip" if field.name == "status" else ""] * len(points)
        elif field.nullable:
            values = [None] * len(points)
        columns[field.name] = pa.array(values, field.type)
    return pa.table(columns, schema=STICTION)


def all_points(grids=GRIDS):
    return [
        ((theta, mu0, eta, dx0), names)
        for theta, eta, pairs in study_points(grids)
        for mu0, dx0, names in zip(pairs.mu0, pairs.dx0, pairs.grids, strict=True)
    ]


COMPLETE = point_table(all_points())


@pytest.fixture
def parts(tmp_path, monkeypatch):
    """Writes tables as parts with small row groups."""
    monkeypatch.setattr(tables, "LEAST_ROW_GROUP", 8)

    def write(made):
        paths = [tmp_path / f"{i}.parquet" for i in range(len(made))]
        for table, path in zip(made, paths, strict=True):
            tables.write(table, path)
        return paths

    return write


def whole(collected):
    return pa.concat_tables([collected.schema.empty_table(), *collected.parts])


def test_tables_stand_one_below_the_other(parts):
    more = COMPLETE.slice(20, 50)
    found = collect(parts([more, COMPLETE]), STICTION)
    assert found.rows == len(COMPLETE) + 50
    assert found.schema.metadata.items() >= STICTION.metadata.items()
    assert found.schema.metadata[b"vibrissa.part_commits"] == tables.commit().encode()
    assert not {b"vibrissa.study", b"vibrissa.file"} & found.schema.metadata.keys()
    assert whole(found).equals(pa.concat_tables([more, COMPLETE]))


@pytest.mark.parametrize(
    "blocks",
    [
        [COMPLETE],
        [COMPLETE.slice(i, 37) for i in range(0, len(COMPLETE), 37)],
        # A study grown between its values, or by one value of theta at a time
        [COMPLETE.take(list(range(i, len(COMPLETE), 3))) for i in range(3)],
        [
            COMPLETE.filter(pa.compute.equal(COMPLETE["theta"], theta / 10))
            for theta in (3, 1, 2, 5, 6, 4)
        ],
        # Blocks that are in no order themselves
        [COMPLETE.take(np.random.default_rng(1).permutation(len(COMPLETE)))],
    ],
    ids=["one", "cut", "between", "theta by theta", "shuffled"],
)
def test_parts_are_merged_in_the_order_of_the_points(parts, blocks):
    found = collect(parts(blocks), STICTION, POINT_ORDER)
    assert whole(found).equals(COMPLETE)


@given(st.lists(st.lists(st.integers(0, 40), max_size=30), max_size=6), st.integers(1, 9))
def test_merging_is_sorting(numbers, size):
    pieces = []
    for part in numbers:
        for start in range(0, len(part), size):
            chunk = part[start : start + size]
            table = pa.table({"a": [n // 7 / 1 for n in chunk], "b": [n % 7 / 1 for n in chunk]})
            pieces.append((_least(table), table))
    pieces.sort(key=lambda piece: piece[0])
    merged = [table.to_pylist() for table in _merged(pieces, ("a", "b"))]
    assert [(row["a"], row["b"]) for rows in merged for row in rows] == sorted(
        (n // 7, n % 7) for part in numbers for n in part
    )


def test_no_more_is_held_than_what_overlaps(parts):
    paths = parts([COMPLETE.slice(i, 64) for i in range(0, len(COMPLETE), 64)])
    sizes = [len(part) for part in collect(paths, STICTION, POINT_ORDER).parts]
    assert max(sizes) == 8 and sum(sizes) == len(COMPLETE)


def test_a_damaged_part_is_named(parts):
    paths = parts([COMPLETE] * 3)
    paths[1].write_bytes(paths[1].read_bytes()[:-9])
    with pytest.raises(TableError, match=f"{paths[1]} cannot be read .*{AGAIN}"):
        collect(paths, STICTION)


def test_a_part_that_is_damaged_while_it_is_read_is_named(parts):
    paths = parts([COMPLETE])
    found = collect(paths, STICTION, POINT_ORDER)
    data = bytearray(paths[0].read_bytes())
    data[len(data) // 2 - 3000 : len(data) // 2] = bytes(3000)
    paths[0].write_bytes(data)
    with pytest.raises(TableError, match=f"{paths[0]} cannot be read .*{AGAIN}"):
        whole(found)


@pytest.mark.parametrize("schema", [STICTION, SCANS])
def test_nothing_collected_is_an_empty_table(schema, tmp_path):
    found = collect([], schema)
    tables.write_parts(found.parts, found.schema, tmp_path / "table.parquet")
    assert len(tables.read(tmp_path / "table.parquet", schema)) == 0


@pytest.mark.parametrize("size", [1, 7, 8, 100, 1000])
def test_a_complete_table_passes_in_parts_of_any_size(size):
    made = [COMPLETE.slice(i, size) for i in range(0, len(COMPLETE), size)]
    assert pa.concat_tables(checked_points(made, GRIDS)).equals(COMPLETE)


def without(*rows):
    return COMPLETE.take([i for i in range(len(COMPLETE)) if i not in rows])


def renamed(row, names):
    grids = COMPLETE["grids"].to_pylist()
    grids[row] = names
    return COMPLETE.set_column(0, STICTION.field(0), pa.array(grids, STICTION.field(0).type))


@pytest.mark.parametrize("size", [1, 13, 1000])
@pytest.mark.parametrize(
    ("table", "count", "problem", "example"),
    [
        (without(0), 1, "missing", "(0.1, 0.1, 0.1, 0.1)"),
        (without(4, 13), 2, "missing", "(0.1, 0.3, 0.1, 0.1), (0.2, 0.2, 0.1, 0.2)"),
        (without(*range(10)), 10, "missing", "(0.1, 0.1, 0.1, 0.1), (0.1, 0.1, 0.1, 0.2), (0.1"),
        (COMPLETE.slice(0, len(COMPLETE) - 9), 9, "missing", "(0.5, 0.4, 0.5, 0.2), (0.6, 0.1, 0"),
        (COMPLETE.slice(0, 0), len(COMPLETE), "missing", "(0.1, 0.1, 0.1, 0.1)"),
        (
            pa.concat_tables([COMPLETE.slice(0, 12), COMPLETE.slice(11)]),
            1,
            "doubled",
            "(0.2, 0.1, 0.1, 0.2)",
        ),
        (renamed(2, ["main"]), 1, "of other grids", "(0.1, 0.2, 0.1, 0.1)"),
    ],
    ids=["first", "two", "curve", "last", "all", "doubled", "grids"],
)
def test_a_wrong_set_of_points_is_refused_with_examples(table, count, problem, example, size):
    made = [table.slice(i, size) for i in range(0, len(table), size)]
    message = rf"{count} grid points are {problem}, such as \(theta, mu0, eta, dx0\) = "
    with pytest.raises(TableError, match=message) as error:
        list(checked_points(made, GRIDS))
    assert example in str(error.value)
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
    with pytest.raises(TableError, match=f"{count} grid points are not in the study") as error:
        list(checked_points([COMPLETE], grids))
    assert example in str(error.value)


@pytest.fixture
def long_table(tmp_path):
    """A table of many row groups, its path, and the bytes of each group."""
    grids = {"g": grid(theta=40, mu0=50, eta=30, dx0=1)}
    path = tmp_path / "long.parquet"
    tables.write(point_table(all_points(grids)), path, "the study")
    return path


def test_a_query_for_one_rod_and_height_reads_one_row_group_or_two(long_table):
    stored = tables.Stored(long_table, STICTION)
    assert stored.groups == 4 and len(stored) == 60_000
    for theta, eta in ((0.1, 0.1), (2.3, 1.1), (4.0, 3.0)):
        assert len(list(stored.groups_where({"theta": theta, "eta": eta}))) <= 2
        found = stored.read(where={"theta": theta, "eta": eta})
        assert found["mu0"].to_pylist() == [(i + 1) / 10 for i in range(50)]


def test_what_is_read_of_a_table_is_what_was_asked_for(long_table):
    stored = tables.Stored(long_table, STICTION)
    frame = stored.read().to_pandas()
    where = {"theta": [0.5, 4], "mu0": 1, "grid": "g"}
    wanted = frame[frame["theta"].isin([0.5, 4]) & (frame["mu0"] == 1)]
    found = stored.read(["mu0", "status", "eta"], where)
    assert found.column_names == ["mu0", "status", "eta"]
    assert found.to_pandas().equals(wanted[["mu0", "status", "eta"]].reset_index(drop=True))
    assert len(stored.read(where={"grid": "other"})) == 0
    assert len(stored.read(where={"theta": 9})) == 0


def test_rows_are_known_by_the_grids_they_belong_to():
    for name, own in GRIDS.items():
        rows = tables.in_grid(COMPLETE.slice(3)["grids"], name).to_pylist()
        assert rows == [name in names for names in COMPLETE.slice(3)["grids"].to_pylist()]
        assert 0 < sum(rows) < len(rows) or own is GRIDS["main"]


def test_pandas_and_arrow_read_the_file_and_its_statistics(long_table):
    here = [("theta", "==", 2.3), ("eta", "==", 1.1)]
    frame = pd.read_parquet(long_table, columns=["theta", "eta", "mu0"], filters=here)
    assert len(frame) == 50 and set(frame["theta"]) == {2.3}
    data = pyarrow.dataset.dataset(long_table)
    condition = (pa.compute.field("theta") == 2.3) & (pa.compute.field("eta") == 1.1)
    (fragment,) = data.get_fragments()
    assert len(fragment.subset(condition).row_groups) <= 2
    assert len(data.to_table(filter=condition)) == 50
    assert pq.read_metadata(long_table).row_group(0).column(1).is_stats_set


def test_longer_tables_have_larger_row_groups():
    sizes = [tables.row_group_size(10**n) for n in range(10)]
    assert sizes == sorted(sizes) and sizes[0] == sizes[6] == 2**14
    # The end of the file stays a small part of it.
    assert all(10**n / size * 8_000 < 1e8 for n, size in enumerate(sizes))
