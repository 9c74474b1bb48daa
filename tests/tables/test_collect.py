"""Many tables as one: order, bounded memory, and damaged files that are named."""

import tempfile
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from made_up import COMPLETE
from vibrissa.errors import DamagedTableError
from vibrissa.provenance import commit
from vibrissa.tables import collect as module
from vibrissa.tables import store
from vibrissa.tables.collect import _merged, collect
from vibrissa.tables.completeness import POINT_ORDER
from vibrissa.tables.schemas import SCANS, STICTION

AGAIN = "delete it and run again, it is made anew"


@pytest.fixture
def parts(tmp_path, monkeypatch):
    """Writes tables as parts with small row groups."""
    monkeypatch.setattr(store, "LEAST_ROW_GROUP", 8)

    def write(made):
        paths = [tmp_path / f"{i}.parquet" for i in range(len(made))]
        for table, path in zip(made, paths, strict=True):
            store.write(table, path)
        return paths

    return write


def whole(collected):
    return pa.concat_tables([collected.schema.empty_table(), *collected.parts])


def test_tables_stand_one_below_the_other(parts):
    more = COMPLETE.slice(20, 50)
    found = collect(parts([more, COMPLETE]), STICTION)
    assert found.rows == len(COMPLETE) + 50
    assert found.schema.metadata.items() >= STICTION.metadata.items()
    assert found.schema.metadata[b"vibrissa.part_commits"] == commit().encode()
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


@pytest.mark.slow
@settings(max_examples=8)
@given(st.data())
def test_neither_the_blocks_nor_their_order_matter(data):
    """Points are dealt to blocks at random, and the blocks come in any order."""
    number = data.draw(st.integers(1, 5))
    block = np.array(
        data.draw(st.lists(st.integers(0, number - 1), min_size=200, max_size=200)), dtype=int
    )
    some = COMPLETE.slice(0, 200)
    blocks = data.draw(
        st.permutations([some.take(np.flatnonzero(block == i)) for i in range(number)])
    )
    with tempfile.TemporaryDirectory() as folder:
        paths = [Path(folder, f"{i}.parquet") for i in range(number)]
        for table, path in zip(blocks, paths, strict=True):
            store.write(table, path)
        found = collect(paths, STICTION, POINT_ORDER)
        assert found.rows == 200
        assert whole(found).equals(some)


@given(st.lists(st.lists(st.integers(0, 40), max_size=30), max_size=6), st.integers(1, 9))
def test_merging_is_sorting(numbers, size):
    groups = []
    for part in numbers:
        for start in range(0, len(part), size):
            a, b = (
                [float(value) for value in values]
                for values in zip(
                    *(divmod(n, 7) for n in sorted(part[start : start + size])), strict=True
                )
            )
            groups.append(((min(a), min(b)), pa.table({"a": a, "b": b})))
    groups.sort(key=lambda group: group[0])
    merged = [table.to_pylist() for table in _merged(groups, ("a", "b"))]
    assert [(row["a"], row["b"]) for rows in merged for row in rows] == sorted(
        divmod(n, 7) for part in numbers for n in part
    )


def test_no_more_is_held_than_what_overlaps(parts):
    paths = parts([COMPLETE.slice(i, 64) for i in range(0, len(COMPLETE), 64)])
    sizes = [len(part) for part in collect(paths, STICTION, POINT_ORDER).parts]
    assert max(sizes) == 8 and sum(sizes) == len(COMPLETE)


def test_a_damaged_part_is_named(parts):
    paths = parts([COMPLETE] * 3)
    paths[1].write_bytes(paths[1].read_bytes()[:-9])
    with pytest.raises(DamagedTableError, match=f"{paths[1]} cannot be read .*{AGAIN}") as error:
        collect(paths, STICTION)
    assert error.value.path == paths[1]


def test_a_part_that_is_damaged_while_it_is_read_is_named(parts):
    paths = parts([COMPLETE])
    found = collect(paths, STICTION, POINT_ORDER)
    data = bytearray(paths[0].read_bytes())
    data[len(data) // 2 - 3000 : len(data) // 2] = bytes(3000)
    paths[0].write_bytes(data)
    with pytest.raises(DamagedTableError, match=f"{paths[0]} cannot be read .*{AGAIN}"):
        whole(found)


@pytest.mark.parametrize("schema", [STICTION, SCANS])
def test_nothing_collected_is_an_empty_table(schema, tmp_path):
    found = collect([], schema)
    store.write_parts(found.parts, found.schema, tmp_path / "table.parquet")
    assert len(store.read(tmp_path / "table.parquet", schema)) == 0


def test_what_is_in_order_is_not_sorted(parts, monkeypatch):
    monkeypatch.setattr(module, "_sorted_rows", None)
    found = collect(parts([COMPLETE.slice(100), COMPLETE.slice(0, 100)]), STICTION, POINT_ORDER)
    assert whole(found).equals(COMPLETE)
