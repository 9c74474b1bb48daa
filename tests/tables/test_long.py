"""Long tables: encoded in threads, the same file as pyarrow would write, with a digest in parts."""

import hashlib

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from made_up import COMPLETE
from vibrissa.errors import TableError
from vibrissa.tables import query, store
from vibrissa.tables.collect import collect
from vibrissa.tables.completeness import POINT_ORDER
from vibrissa.tables.parquet import digests
from vibrissa.tables.schemas import STICTION

# 252 points in row groups of 30 make 9, in row groups of 10 more than the 14 of a short list.
SIZES = (30, 10)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "stiction.parquet"


@pytest.fixture(params=SIZES, ids=str)
def size(request, monkeypatch):
    monkeypatch.setattr(store, "LEAST_ROW_GROUP", 8)
    monkeypatch.setattr(store, "row_group_size", lambda rows: request.param)
    return request.param


def write(path, threads=1, table=COMPLETE):
    """Write a table in parts that are no row groups."""
    parts = [table.slice(i, 37) for i in range(0, len(table), 37)]
    store.write_parts(parts, table.schema, path, "study: a", len(table), threads)


def plain(path, size, name):
    """The same rows and metadata as pyarrow alone writes them, with a place for a digest."""
    schema = pq.read_schema(path)
    metadata = {k: v for k, v in schema.metadata.items() if k != name}
    other = path.with_name("plain.parquet")
    with pq.ParquetWriter(
        other,
        COMPLETE.schema.with_metadata(metadata),
        use_dictionary=store._repeating(STICTION),
        write_page_checksum=True,
    ) as writer:
        for i in range(0, len(COMPLETE), size):
            writer.write_table(COMPLETE.slice(i, size))
        writer.add_key_value_metadata({name: digests.NO_DIGEST})
    return other.read_bytes()


@pytest.mark.parametrize("threads", [1, 3])
def test_a_long_table_is_the_file_that_pyarrow_writes(path, size, threads):
    write(path, threads)
    recorded = pq.read_metadata(path).metadata[digests.DIGEST_OF_PARTS]
    made = path.read_bytes().replace(recorded, digests.NO_DIGEST)
    assert made == plain(path, size, digests.DIGEST_OF_PARTS)
    assert recorded != digests.NO_DIGEST


def test_a_table_that_is_not_long_is_encoded_as_before(path):
    write(path, 3)
    metadata = pq.read_metadata(path)
    recorded = metadata.metadata[digests.DIGEST]
    made = path.read_bytes().replace(recorded, digests.NO_DIGEST)
    assert made == plain(path, len(COMPLETE), digests.DIGEST)
    assert digests.DIGEST_OF_PARTS not in metadata.metadata


def test_values_that_repeat_are_written_as_a_dictionary_and_the_others_are_not(path):
    """What is known of the states of a point differs from point to point."""
    write(path)
    group = pq.read_metadata(path).row_group(0)
    columns = map(group.column, range(group.num_columns))
    each = {
        column.path_in_schema.split(".")[0] for column in columns if not column.has_dictionary_page
    }
    ends = ("_last", "_slip", "_end")
    # Parquet has no dictionaries of yes and no.
    assert each == {name for name in STICTION.names if name.endswith(ends)} | {"penetrates"}
    assert "x0_slip" in each and not each & {"theta", "status", "f_init", "mu_lock"}


def test_a_long_table_is_read_as_any_other(path, size):
    write(path, 3)
    assert pq.read_metadata(path).num_row_groups == -(-len(COMPLETE) // size)
    assert store.read(path, STICTION).equals(COMPLETE)
    here = query.one_of("theta", [0.2]) & query.one_of("eta", [0.3])
    assert query.rows(query.opened(path, STICTION), ["mu0"], here).equals(
        COMPLETE.filter(here).select(["mu0"])
    )
    assert pd.read_parquet(path)["mu0"].tolist() == COMPLETE["mu0"].to_pylist()


@pytest.mark.slow
@pytest.mark.parametrize("size", SIZES[:1], indirect=True)
def test_damage_anywhere_in_a_long_table_is_noticed(path, size):
    write(path)
    data = path.read_bytes()
    name = data.index(digests.DIGEST_OF_PARTS)
    for place in [0, 4, *range(5, len(data), 1009), len(data) - 1]:
        # Without its name there is no digest.
        if not name <= place < name + len(digests.DIGEST_OF_PARTS):
            path.write_bytes(data[:place] + bytes([data[place] ^ 255]) + data[place + 1 :])
            with pytest.raises(TableError, match=f"{path} cannot be read"):
                store.check_file(path)
    for length in (0, 7, len(data) // 2, len(data) - 1):
        path.write_bytes(data[:length])
        with pytest.raises(TableError, match=f"{path} cannot be read"):
            store.check_file(path)
    path.write_bytes(data)
    store.check_file(path)


def test_the_digest_of_a_long_table_is_that_of_its_digests(path, size):
    """By hand: each row group ends where the next begins, and the last at the metadata."""
    write(path)
    data = path.read_bytes()
    metadata = pq.read_metadata(path)
    recorded = metadata.metadata[digests.DIGEST_OF_PARTS]
    length = [
        sum(group.column(i).total_compressed_size for i in range(metadata.num_columns))
        for group in map(metadata.row_group, range(metadata.num_row_groups))
    ]
    found, place = b"", 4
    for one in length:
        found += hashlib.sha256(data[place : place + one]).digest()
        place += one
    found += data[:4] + data[place:].replace(recorded, b"0" * 64)
    assert hashlib.sha256(found).hexdigest().encode() == recorded


def test_nothing_of_a_long_table_is_left_if_a_part_is_wrong(path, size):
    write(path)
    before = path.read_bytes()
    column = STICTION.get_field_index("status")
    gap = pa.array([*COMPLETE["status"].to_pylist()[:-1], None])
    with pytest.raises(TableError, match="column status must not be empty"):
        write(path, 3, COMPLETE.set_column(column, STICTION.field(column), gap))
    assert path.read_bytes() == before
    assert list(path.parent.iterdir()) == [path]


def test_parts_are_merged_the_same_in_threads(tmp_path, size):
    paths = [tmp_path / f"{i}.parquet" for i in range(5)]
    for i, one in enumerate(paths):
        rows = COMPLETE.take(list(range(i, len(COMPLETE), 5)))
        store.write_parts([rows], rows.schema, one, rows=len(rows))
    found = collect(paths, STICTION, POINT_ORDER, threads=3)
    assert pa.concat_tables([found.schema.empty_table(), *found.parts]).equals(COMPLETE)
    paths[3].write_bytes(paths[3].read_bytes()[:-9])
    with pytest.raises(TableError, match=f"{paths[3]} cannot be read"):
        collect(paths, STICTION, POINT_ORDER, threads=3)
