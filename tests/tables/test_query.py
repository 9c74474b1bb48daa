"""Rows of a table: which are found, and how little is read for them."""

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import made_tables
from vibrissa.errors import DamagedTableError, TableError
from vibrissa.sticking.curve import failed_curve
from vibrissa.tables import query, store
from vibrissa.tables.counts import SCAN, counts_by_status, scan_keys
from vibrissa.tables.schemas import STICTION


def failed_points(grid, theta, mu0, eta):
    """Table of so many points, without results."""
    axes = made_tables.grid(
        *(tuple((i + 1) / 10 for i in range(n)) for n in (theta, mu0, eta)), dx0=(0.001,)
    )
    curve = failed_curve(theta=1.0, eta=0.5, method="collocation", message="")
    return made_tables.points(grid, axes, curves=[curve] * (theta * eta))


@pytest.fixture
def long_table(tmp_path):
    """File of a table of some row groups."""
    path = tmp_path / "long.parquet"
    store.write(failed_points("g", 40, 50, 30), path, "the study")
    return path


def test_a_query_for_one_rod_and_height_reads_one_row_group_or_two(long_table):
    table = query.opened(long_table, STICTION)
    (fragment,) = table.get_fragments()
    assert len(fragment.row_groups) == 4 and query.count(table) == 60_000
    for theta, eta in ((0.1, 0.1), (2.3, 1.1), (4.0, 3.0)):
        here = query.one_of("theta", [theta]) & query.one_of("eta", [eta])
        assert len(fragment.subset(here).row_groups) <= 2
        found = query.rows(table, ["mu0"], here)
        assert found["mu0"].to_pylist() == [(i + 1) / 10 for i in range(50)]


def in_file_and_in_memory(path):
    return query.opened(path, STICTION), store.read(path, STICTION)


@pytest.mark.slow
def test_what_is_read_of_a_table_is_what_was_asked_for(long_table):
    frame = store.read(long_table, STICTION).to_pandas()
    wanted = frame[frame["theta"].isin([0.5, 4]) & (frame["mu0"] == 1)]
    wanted = wanted[["mu0", "status", "eta"]].reset_index(drop=True)
    where = query.one_of("theta", [0.5, 4]) & query.one_of("mu0", [1]) & query.one_of("grid", ["g"])
    for table in in_file_and_in_memory(long_table):
        assert query.frame(table, ("mu0", "status", "eta"), where).equals(wanted)
        read = list(query.batches(table, ("mu0", "status", "eta"), where))
        assert pa.concat_tables(read).to_pandas().equals(wanted)
        assert len(query.rows(table, ["mu0"], query.one_of("grid", ["other"]))) == 0
        assert len(query.rows(table, ["mu0"], query.one_of("theta", [9]))) == 0
        assert query.frame(table, STICTION.names).equals(frame)


def test_a_table_is_read_in_parts_with_its_units(long_table):
    table = query.opened(long_table, STICTION)
    read = list(query.batches(table, ["eta"]))
    assert len(read) == 8 and pa.concat_tables(read).equals(query.rows(table, ["eta"]))
    assert table.schema.field("eta").metadata == STICTION.field("eta").metadata
    assert table.schema.metadata[b"vibrissa.study"] == b"the study"


def test_the_tables_of_a_study_are_opened_and_others_refused(long_table):
    files = {"stiction": str(long_table), "svg": []}
    found = query.opened_tables(files, {"stiction": "the study"})
    assert query.count(found["stiction"]) == 60_000
    with pytest.raises(DamagedTableError, match="was made from another study file"):
        query.opened_tables(files, {"stiction": "another study"})


def test_a_single_wrong_byte_is_noticed(long_table):
    names = STICTION.names
    column = pq.ParquetFile(long_table).metadata.row_group(1).column(names.index("mu0"))
    table, data = query.opened(long_table, STICTION), long_table.read_bytes()
    first = column.dictionary_page_offset or column.data_page_offset
    last = first + column.total_compressed_size - 1
    for back in range(0, 60, 7):
        wrong = bytearray(data)
        wrong[last - back] ^= 1
        long_table.write_bytes(wrong)
        with pytest.raises(DamagedTableError, match="cannot be read"):
            query.rows(table, ["mu0"])


def test_a_table_that_is_damaged_while_it_is_read_is_named(long_table):
    table = query.opened(long_table, STICTION)
    data = bytearray(long_table.read_bytes())
    data[len(data) // 2 - 3000 : len(data) // 2] = bytes(3000)
    long_table.write_bytes(data)
    for read in (query.rows, lambda *asked: list(query.batches(*asked))):
        with pytest.raises(DamagedTableError, match=f"{long_table} cannot be read") as error:
            read(table, STICTION.names)
        assert error.value.path == long_table
    long_table.unlink()
    with pytest.raises(TableError, match=f"No such file: {long_table}") as error:
        query.rows(table, ["eta"])
    assert not isinstance(error.value, DamagedTableError)


def test_a_scan_that_goes_on_in_the_next_part_is_counted_once(monkeypatch):
    """Missing values of its keys are the same scan, too."""
    keys = {name: [None] * 5 for name in SCAN} | {"theta": [1.0, 1.0, 1.0, 2.0, 3.0]}
    keys |= {"scan": ["s"] * 5, "status": ["slip", "slip", "slip", "lock", "slip"]}
    table = pa.table(keys)
    whole = pd.concat(scan_keys(table), ignore_index=True)
    monkeypatch.setattr(query, "batches", lambda *_: (table.slice(n, 2) for n in (0, 2, 4)))
    parts = [part for part in scan_keys(table) if len(part)]
    assert pd.concat(parts, ignore_index=True)["theta"].tolist() == [1.0, 2.0, 3.0]
    assert whole["theta"].tolist() == [1.0, 2.0, 3.0]
    assert counts_by_status({"scans": table}) == {"scans": {"slip": 2, "lock": 1}}
