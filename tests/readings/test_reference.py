"""A few readings of fixed seeds are those that are stored."""

import pyarrow as pa
import pyarrow.compute as pc
import pytest

from runs import ROOT
from vibrissa.checking.reference import compare_folders
from vibrissa.checking.tolerances import read_layouts
from vibrissa.readings.rows import read_chunk
from vibrissa.study.reading import read_study
from vibrissa.tables import store

pytestmark = pytest.mark.slow
LAYOUTS = read_layouts(ROOT / "workflow/regression.yaml")
STORED = ROOT / "tests/regression/few"
STUDY = read_study(ROOT / "tests/readings/few.yaml")
FIRST = next(iter(STUDY.reading_chunks.values()))


def read(chunk, **changes):
    """Rows of a chunk."""
    params = chunk.params | changes
    return pa.concat_tables(read_chunk(**params, study=STUDY.name, **STUDY.reading_settings))


def all_chunks():
    return pa.concat_tables(map(read, STUDY.reading_chunks.values()))


@pytest.fixture(scope="module")
def table(kept):
    return kept(all_chunks)


@pytest.fixture
def told(tmp_path):
    """Differences of a table from the stored one."""

    def told(table):
        (tmp_path / "tables").mkdir()
        store.write(table, tmp_path / "tables/friction.parquet", "study: few\n")
        return [one.text for one in compare_folders(tmp_path, STORED, LAYOUTS).differences]

    return told


def test_readings_are_unchanged(table, told):
    assert told(table) == []


def test_an_estimate_that_moved_is_named(table, told):
    column = table.schema.get_field_index("mu0_read")
    moved = pc.add(table["mu0_read"], pa.array([0.0] * (len(table) - 1) + [2e-5]))
    (text,) = told(table.set_column(column, table.schema.field(column), moved))
    assert "mu0_read" in text and "ratio" in text


@pytest.mark.nightly
def test_another_seed_is_noticed(table, told):
    other = read(FIRST, last=1, seed=2)
    texts = told(pa.concat_tables([other, table.slice(len(other))]))
    assert any("mu0_read" in text for text in texts)
