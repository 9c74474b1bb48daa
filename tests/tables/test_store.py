"""Files of tables: what is written comes back, and anything else is refused."""

import re
from collections import Counter

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import made_tables
import small_study
from vibrissa import __version__, read_table
from vibrissa.computing.comparisons import comparison_table
from vibrissa.errors import DamagedTableError, TableError
from vibrissa.provenance import commit
from vibrissa.sticking.comparison import compare
from vibrissa.tables import schemas, store
from vibrissa.tables.counts import counts_by_status, need_results, sentence
from vibrissa.tables.schemas import STICTION

ENDS = {"−∞": -np.inf, "−π": -np.pi, "−π/2": -np.pi / 2, "0": 0, "1": 1, "50": 50}
ENDS |= {"π/2": np.pi / 2, "π": np.pi, "2π": 2 * np.pi, "∞": np.inf}
UNITS = {"L", "E*I0/L^2", "E*I0/L", "rad", "1", "L/(E*I0)", "1/L"}
UNITS |= {"sqrt(E*I0/(rho*A0))/L^2"}
# A rod on a transducer has a size.
UNITS |= {"m", "Pa"}


@pytest.fixture(scope="module")
def tables():
    compared = comparison_table("c", compare([1.0, 3.0], [0.2, 0.9], [0.85]), "small")
    return small_study.tables() | {"comparisons": compared}


@pytest.fixture
def path(tmp_path):
    return tmp_path / "stiction.parquet"


@pytest.mark.parametrize("kind", schemas.TABLES)
def test_every_column_has_a_unit_and_a_description(kind):
    for column in schemas.TABLES[kind]:
        assert column.metadata[schemas.UNIT].decode() in UNITS
        assert len(column.metadata[schemas.DESCRIPTION]) > 5
        assert column.nullable == bool(column.metadata[schemas.NULL])


@pytest.mark.parametrize("kind", ["stiction", "scans", "states", "comparisons"])
def test_every_value_is_in_the_range_of_its_column(tables, kind):
    for column in schemas.TABLES[kind]:
        told = column.metadata[schemas.RANGE].decode()
        values = tables[kind].column(column.name).drop_null().to_pylist()
        if match := re.fullmatch(r"([\[(])(.+), (.+)([\])])", told):
            low, high = ENDS[match[2]], ENDS[match[3]]
            lists = (one if isinstance(one, list) else [one] for one in values)
            flat = np.array([value for one in lists for value in one])
            assert ((flat > low) | ((flat == low) & (match[1] == "["))).all(), column.name
            assert ((flat < high) | ((flat == high) & (match[4] == "]"))).all(), column.name
        elif column.type == pa.string() and ", " in told and "letters" not in told:
            assert set(values) <= set(told.split(", ")), column.name


@pytest.mark.parametrize("kind", ["stiction", "scans", "states", "comparisons"])
def test_a_table_comes_back_from_its_file(tables, kind, path):
    store.write(tables[kind], path, "the study")
    back = store.read(path, schemas.TABLES[kind])
    assert back.equals(tables[kind])
    told = store.metadata(path)
    assert (told[store.PROGRAM], told[store.COMMIT]) == (__version__, commit())
    assert (told[store.STUDY], told[store.TABLE]) == ("the study", kind)
    frame = read_table(path)
    assert frame.attrs["table"] == kind and frame.attrs["version"] == __version__
    assert list(frame.columns) == schemas.TABLES[kind].names
    assert set(frame.attrs["units"].values()) <= UNITS


def test_rows_to_be_joined_come_back_from_a_current_table_alone(tables, path):
    store.write(tables["stiction"], path, "the study")
    found = store.current_batches(path, STICTION, "the study")
    assert pa.concat_tables(found).equals(tables["stiction"])
    with pytest.raises(DamagedTableError, match="another study file"):
        list(store.current_batches(path, STICTION, "another study"))


@pytest.mark.slow
def test_a_changed_byte_never_changes_the_table_silently(tables, path):
    table = tables["stiction"]
    store.write(table, path, "the study")
    whole, refused = path.read_bytes(), 0
    for place in np.random.default_rng(0).integers(len(whole), size=150):
        data = bytearray(whole)
        data[place] ^= 1 << int(place) % 8
        path.write_bytes(data)
        try:
            assert store.read(path, STICTION).equals(table)
        except DamagedTableError as error:
            assert str(path) in str(error) and error.path == path
            refused += 1
    assert refused > 75


@pytest.mark.parametrize("length", [0, 3, 100, -1, -1000])
def test_a_file_cut_short_is_refused(tables, path, length):
    store.write(tables["stiction"], path)
    path.write_bytes(path.read_bytes()[:length])
    with pytest.raises(DamagedTableError, match="delete this table and run again: it is made"):
        store.read(path, STICTION)


def test_what_is_no_table_of_this_kind_is_refused(tables, path):
    with pytest.raises(TableError, match="No such file") as error:
        store.read(path, STICTION)
    assert not isinstance(error.value, DamagedTableError)
    pq.write_table(pa.table({"x": [1]}), path)
    with pytest.raises(TableError, match="does not hold a table of vibrissa"):
        read_table(path)
    with pytest.raises(DamagedTableError, match="holds the table 'none', not the table 'stiction'"):
        store.read(path, STICTION)
    store.write(tables["states"], path)
    with pytest.raises(DamagedTableError, match="the table 'states', not the table 'stiction'"):
        store.read(path, STICTION)
    pq.write_table(tables["stiction"].drop_columns(["mu0"]), path)
    with pytest.raises(DamagedTableError, match="has other columns than this version"):
        store.read(path, STICTION)


def test_a_table_of_another_version_says_what_to_do(tables, path):
    metadata = STICTION.metadata | {b"vibrissa.schema": b"5", b"vibrissa.version": b"0.0"}
    pq.write_table(tables["stiction"].replace_schema_metadata(metadata), path)
    with pytest.raises(TableError, match=r"has version 5 of the columns.*version 0\.0"):
        store.read(path, STICTION)


def test_an_empty_place_where_none_may_be_is_refused(tables, path):
    table = tables["stiction"]
    place = table.schema.get_field_index("eta")
    gap = table.set_column(place, STICTION.field("eta"), pa.nulls(len(table), pa.float64()))
    with pytest.raises(pa.ArrowInvalid, match="'eta' is declared non-nullable"):
        store.write(gap, path)
    assert not path.exists() and not list(path.parent.iterdir())


def test_a_failed_write_leaves_the_old_table(tables, path):
    store.write(tables["stiction"], path)
    before = path.read_bytes()

    def parts():
        yield tables["stiction"]
        raise OSError(28, "No space left on device")

    with pytest.raises(OSError, match="No space"):
        store.write_batches(parts(), STICTION, path)
    assert path.read_bytes() == before and len(list(path.parent.iterdir())) == 1


def test_long_tables_are_written_in_row_groups(path):
    axes = made_tables.grid(mu0=tuple(0.1 + i * 1e-6 for i in range(40_000)))
    table = made_tables.points("g", axes)
    store.write_batches([table.slice(0, 7), table.slice(7)], STICTION, path)
    assert pq.read_metadata(path).num_row_groups == 3
    assert store.read(path, STICTION).equals(table)


def test_rows_are_counted_by_status(tables):
    counts = counts_by_status(tables)
    assert counts["stiction"] == {"slip": 9, "lock": 3, "failed": 4}
    assert counts["scans"] == {"slip": 1, "lock": 1, "failed": 1}
    assert "16 grid points: 4 failed, 3 lock, 9 slip\n" in sentence(counts)
    with pytest.raises(TableError, match="but 4 grid points, 1 scan have the status 'failed'"):
        need_results(counts)
    need_results({"states": Counter(solved=9)})
