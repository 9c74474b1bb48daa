"""Archives: a study in one file, with what makes its tables again."""

import json
import subprocess
import sys

import pytest

from runs import ARCHIVED, ROOT
from vibrissa.archive.crate import ArchiveError, need_committed, write_archive
from vibrissa.tables import schemas, store


@pytest.mark.slow
def test_an_archive_holds_what_makes_it(unpacked):
    for name in ("Snakefile", "Makefile", "README.md", "LICENSE", "helper.py", "workflow/check.py"):
        assert (unpacked / name).is_file()
    assert all((unpacked / "results/tiny" / name).is_file() for name in ARCHIVED)
    assert (unpacked / "config.yaml").read_text().startswith("\nstudy: tiny\n")
    assert (unpacked / "src/vibrissa/commit.txt").read_text() == "0" * 40 + "\n"
    assert not [path for path in unpacked.rglob("__pycache__")]


@pytest.mark.slow
def test_its_description_is_one_of_ro_crate(unpacked):
    graph = json.loads((unpacked / "ro-crate-metadata.json").read_text())["@graph"]
    by_id = {one["@id"]: one for one in graph}
    root = by_id["./"]
    assert root["name"].startswith("Study tiny: ") and root["license"]["@id"].endswith("MIT")
    assert root["author"] and root["datePublished"] and root["version"] == "0" * 40
    parts = {part["@id"] for part in root["hasPart"]}
    assert {f"results/tiny/{name}" for name in ARCHIVED} < parts
    assert {"config.yaml", "src/vibrissa/commit.txt"} < parts
    assert root["mainEntity"]["@id"] == "Snakefile"
    assert by_id["Snakefile"]["programmingLanguage"]


def test_what_cannot_be_archived_is_refused(tmp_path, monkeypatch):
    with pytest.raises(ArchiveError, match="commit of the code is not known, so that it may be ed"):
        need_committed("unknown", [])
    with pytest.raises(ArchiveError, match=r"of this archive was edited since its commit \(abc-d"):
        need_committed("abc-dirty", [])
    monkeypatch.setattr(store, "commit", lambda: "abc-dirty")
    store.write(schemas.STATES.empty_table(), tmp_path / "states.parquet")
    with pytest.raises(ArchiveError, match=r"code of .*states.parquet was edited since"):
        need_committed("abc", [tmp_path / "states.parquet"])
    monkeypatch.setattr(store, "commit", lambda: "unknown")
    store.write(schemas.STATES.empty_table(), tmp_path / "states.parquet")
    with pytest.raises(ArchiveError, match=r"states.parquet does not have the commit of its code"):
        need_committed("abc", [tmp_path / "states.parquet"])
    with pytest.raises(ArchiveError, match="run the archive in a clone of the"):
        write_archive(tmp_path, tmp_path, [], tmp_path / "my.yaml", "abc", tmp_path / "a.zip")
    assert not (tmp_path / "a.zip").exists()


@pytest.mark.slow
def test_the_command_archives_current_results_alone(done):
    command = [sys.executable, str(ROOT / "workflow/archive.py"), "--configfile", "tiny.yaml"]

    def archived():
        result = subprocess.run(command, cwd=done.root, capture_output=True, text=True)
        return result.returncode, result.stdout + result.stderr

    status, screen = archived()
    # The project itself may be edited since its commit.
    assert "results/tiny.crate.zip holds " in screen or "this archive was edited" in screen
    edits = {
        "Two cycles": "captions.md was made by other code or from another study file; run make st",
        "[0.3, 5]": "made from another study",
    }
    for old, words in edits.items():
        done.edit(old, old.replace("5", "4").replace("Two", "2"))
        status, screen = archived()
        assert status == 2 and words in screen
