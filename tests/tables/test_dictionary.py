"""What is said of the columns, and whether the tables agree with it."""

import importlib.util
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import vibrissa
from vibrissa.errors import TableError
from vibrissa.tables import schemas, store
from vibrissa.tables.dictionary import entries

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def stiction(study_tables, tmp_path_factory):
    path = tmp_path_factory.mktemp("tables") / "stiction.parquet"
    store.write(study_tables["stiction"], path)
    return path


def test_the_page_is_that_of_the_schemas():
    spec = importlib.util.spec_from_file_location("tables", ROOT / "docs/tables.py")
    tables = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tables)
    page = tables.PAGE.read_text(encoding="utf-8")
    assert page == tables.replaced(page), "it is old: run make schema"
    assert tables.replaced(page.replace("clamp–surface distance", "height")) == page


def test_an_entry_says_all_of_a_column():
    (entry,) = (one for one in entries(schemas.STICTION) if one.name == "f_slip")
    assert entry.type == "number" and entry.unit == "E·I0/L²" and entry.range == "(0, ∞)"
    assert entry.null == "the tip is self-locking, or no result"
    assert entry.equation == "(fx, fy) = f·(sin α, −cos α)"
    assert entry.description.endswith(", at the exact onset of slip")
    (shape,) = (one for one in entries(schemas.SCANS) if one.name == "shape_phi")
    assert (shape.type, shape.unit, shape.null) == ("list: number", "rad", "")


@pytest.mark.slow
def test_equations_of_the_dictionary_hold_in_the_papers_tables(study_tables):
    points = study_tables["stiction"].to_pandas()
    for suffix in ("_init", "_last", "_slip", "_end"):
        f, alpha, fx, fy = (
            points[f"{name}{suffix}"] for name in ("f", "alpha", "reaction_fx", "reaction_fy")
        )
        assert np.nanmax(np.abs(fx - f * np.sin(alpha))) < 1e-12
        assert np.nanmax(np.abs(fy + f * np.cos(alpha))) < 1e-12
    assert np.nanmax(np.abs(np.tan(points.alpha_slip) + points.mu0)) < 1e-9
    assert np.nanmax(np.abs(points.x0_max - points.n_steps * points.dx0)) < 1e-12
    slips = points[points.status == "slip"]
    assert (slips.n_steps == np.floor(slips.x0_slip / slips.dx0)).all()
    scans = study_tables["scans"].to_pandas()
    sticks = scans[scans.phase == "stick"]
    assert np.abs(sticks.x0 - sticks.step * sticks.dx0).max() < 1e-12
    assert (scans[scans.phase == "slip"].x0 == 0.0).all()


@pytest.mark.slow
def test_a_table_is_read_with_units_and_types(stiction):
    frame = vibrissa.read_table(stiction)
    assert frame.attrs["table"] == "stiction"
    assert frame.attrs["units"]["reaction_m_slip"] == "E*I0/L"
    assert set(frame.attrs["units"]) == set(frame) == set(frame.attrs["descriptions"])
    assert frame.attrs["version"] == vibrissa.__version__
    assert frame["n_steps"].dtype == pd.Int64Dtype() and frame["n_steps"].isna().any()
    assert frame["penetrates"].dtype == pd.BooleanDtype()
    assert set(frame["study"]) == {"paper"}
    # Units stay where rows and columns are chosen.
    assert frame[frame["theta"] == 2][["x0_slip"]].attrs["units"]["x0_slip"] == "L"


def test_a_file_of_another_program_is_not_to_be_deleted(tmp_path):
    path = tmp_path / "other.parquet"
    pq.write_table(pa.table({"x": [1]}), path)
    with pytest.raises(TableError) as caught:
        vibrissa.read_table(path)
    assert str(caught.value).startswith(f"{path} is not a table of vibrissa; those are in results/")
    with pytest.raises(TableError, match=r"cannot be read .*No such file"):
        vibrissa.read_table(tmp_path / "none.parquet")
    path.write_text("a,b\n1,2\n")
    with pytest.raises(TableError, match=f"{path} cannot be read"):
        vibrissa.read_table(path)


def test_a_table_of_older_columns_says_what_to_do(stiction, tmp_path):
    table = store.read(stiction, schemas.STICTION)
    older = table.replace_schema_metadata({**table.schema.metadata, store.VERSION: b"4"})
    store.write(older, tmp_path / "old.parquet")
    with pytest.raises(TableError, match=r"version 4 of the columns.*; run its study again, or"):
        vibrissa.read_table(tmp_path / "old.parquet")
