"""What repair finds; tests/faults and tests/test_workflow.py have studies repaired."""

import errno
import shutil

import pytest

from vibrissa.errors import DamagedTableError
from vibrissa.files import write_atomically
from vibrissa.pipeline import repair
from vibrissa.tables import schemas, store


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "results/study"
    for name in ("blocks/point-collocation", "tables", "figures"):
        (folder / name).mkdir(parents=True)
    store.write(schemas.CURVES.empty_table(), folder / "blocks/point-collocation/a.curves.parquet")
    store.write(schemas.STICTION.empty_table(), folder / "tables/stiction.parquet", "study: study")
    (folder / "figures/a.svg").write_text("<svg/>")
    return folder


def test_a_sound_study_is_left_alone(folder, monkeypatch):
    monkeypatch.chdir(folder.parents[1])
    before = sorted(folder.rglob("*"))
    assert list(repair.cut_short(folder)) == []
    repair.remove_leftovers(folder)
    assert sorted(folder.rglob("*")) == before
    assert repair.misplaced(folder) == ""
    assert repair.obstacles(folder, [None]) == []


def test_a_study_that_is_not_there_is_sound(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "results/study"
    assert list(repair.cut_short(folder)) == []
    repair.remove_leftovers(folder)
    assert repair.misplaced(folder) == ""


@pytest.mark.parametrize("name", ["blocks/point-collocation/a.curves.parquet", "figures/a.svg"])
def test_an_empty_file_is_found(folder, name):
    (folder / name).write_bytes(b"")
    assert list(repair.cut_short(folder)) == [folder / name]


@pytest.mark.parametrize(
    "name", ["blocks/point-collocation/a.curves.parquet", "tables/stiction.parquet"]
)
def test_a_file_cut_short_anywhere_is_found(folder, name):
    whole = (folder / name).read_bytes()
    for length in range(1, len(whole), 499):
        (folder / name).write_bytes(whole[:length])
        assert list(repair.cut_short(folder)) == [folder / name]
    (folder / name).write_bytes(bytes(len(whole)))
    assert list(repair.cut_short(folder)) == [folder / name]


def test_a_part_of_another_study_is_found_and_a_copied_table_is_not(folder):
    other = folder.with_name("other")
    shutil.copytree(folder, other)
    paths = sorted(other.glob("*/**/*.parquet"))
    assert [path.name for path in repair.damaged(paths)] == ["a.curves.parquet"]
    with pytest.raises(DamagedTableError, match="is a copy of study/blocks/point-collocation/a"):
        store.read(paths[0], schemas.CURVES)
    assert store.read(paths[1], schemas.STICTION).num_rows == 0


def test_a_table_that_cannot_be_opened_is_not_damaged(folder):
    path = folder / "tables/gone.parquet"
    assert list(repair.damaged([path])) == []


def test_only_what_nobody_writes_is_left_over(folder):
    leftover = folder / "tables/.stiction-0a1b2c3d.tmp.parquet"
    leftover.write_bytes(b"PAR1")
    with write_atomically(folder / "tables/scans.parquet") as temporary:
        temporary.write_bytes(b"new")
        repair.remove_leftovers(folder)
        assert temporary.exists() and not leftover.exists()
    assert (folder / "tables/scans.parquet").read_bytes() == b"new"


def test_records_of_failures_are_left_over(folder):
    record = folder / "logs/curves/a.failure.json"
    record.parent.mkdir(parents=True)
    record.touch()
    repair.remove_leftovers(folder)
    assert not record.exists()


@pytest.mark.parametrize("name", ["", "figures", "tables"])
def test_a_file_in_place_of_a_folder_is_named(folder, name):
    path = folder / name
    shutil.rmtree(path)
    path.write_text("")
    assert repair.misplaced(folder).startswith(f"{path} is a file where a folder is needed; move")


def test_a_full_disk_is_told_by_the_number_of_an_error(folder, monkeypatch):
    monkeypatch.chdir(folder.parents[1])
    (line,) = repair.obstacles(folder, [errno.ENOSPC])
    assert line.endswith("is full; make space and run the same command again.")
    assert repair.obstacles(folder, [errno.ENOENT]) == []


def test_a_table_or_block_without_a_record_is_found(folder, monkeypatch):
    monkeypatch.chdir(folder.parents[1])
    here = folder.relative_to(folder.parents[1])
    assert repair.without_record(here) == here / "tables/stiction.parquet"
    # As Snakemake names it: the text of the path in base64.
    record = repair.RECORDS / "cmVzdWx0cy9zdHVkeS90YWJsZXMvc3RpY3Rpb24ucGFycXVldA=="
    record.parent.mkdir(parents=True)
    record.touch()
    assert repair.without_record(here) is None
    block = here / "blocks/point-collocation/a.points.parquet"
    shutil.copy(here / "tables/stiction.parquet", block)
    assert repair.without_record(here) == block
