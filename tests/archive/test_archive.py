"""Archives: a study in one file, which is checked and makes its tables again."""

import json
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from vibrissa.archive import crate
from vibrissa.archive.crate import ArchiveError, checked_files, study_file_of, write_archive

ROOT = Path(__file__).parents[2]
STUDY = "study: mine\ngrids: {g: {theta: [2], mu0: [0.3], eta: [0.85], dx0: [0.005]}}\n"
MADE = ["tables/stiction.parquet", "summary.txt", "report.html"]


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A folder with a study file and its results."""
    folder = tmp_path_factory.mktemp("study")
    (folder / "my.yaml").write_text(STUDY)
    command = [sys.executable, ROOT / "workflow/run.py", "--configfile", "my.yaml", "--cores", "1"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return folder


@pytest.fixture
def unpacked(finished, tmp_path):
    results = finished / "results/mine"
    output = tmp_path / "mine.crate.zip"
    write_archive(ROOT, results, MADE, finished / "my.yaml", "0" * 40, output)
    zipfile.ZipFile(output).extractall(tmp_path / "unpacked")
    return tmp_path / "unpacked"


def verified(folder):
    command = [sys.executable, "workflow/verify.py"]
    result = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    return result.returncode, result.stdout + result.stderr


@pytest.mark.slow
def test_an_archive_holds_what_makes_it_and_makes_its_tables_again(unpacked):
    names = checked_files(unpacked)
    assert {"Snakefile", "Makefile", "README.md", "LICENSE", "studies/my.yaml"} < set(names)
    assert {f"results/mine/{name}" for name in MADE} < set(names)
    assert study_file_of(unpacked) == "studies/my.yaml"
    assert (unpacked / "src/vibrissa/commit.txt").read_text() == "0" * 40 + "\n"
    status, screen = verified(unpacked)
    assert status == 0, screen
    assert "\nUnchanged: all 2 rows of " in "\n" + screen
    # Of an archive that was changed nothing is computed.
    path = unpacked / "results/mine/summary.txt"
    path.write_text("9 grid points: 9 slip\n")
    (unpacked / "Snakefile").unlink()
    status, screen = verified(unpacked)
    assert status == 2 and "Snakefile is missing" in screen and "summary.txt has changed" in screen


@pytest.mark.slow
def test_its_description_is_one_of_ro_crate(unpacked):
    graph = json.loads((unpacked / "ro-crate-metadata.json").read_text())["@graph"]
    by_id = {one["@id"]: one for one in graph}
    root = by_id["./"]
    assert root["name"].startswith("Study mine: ") and root["license"]["@id"].endswith("MIT")
    assert root["author"] and root["datePublished"] and root["version"] == "0" * 40
    parts = {part["@id"] for part in root["hasPart"]}
    assert set(checked_files(unpacked)) <= parts | {"Snakefile"}
    run = by_id[root["mentions"]["@id"]]
    assert run["object"]["@id"] == "studies/my.yaml"
    assert {one["@id"] for one in run["result"]} == {f"results/mine/{name}" for name in MADE}
    assert by_id["Snakefile"]["programmingLanguage"]


def test_what_cannot_be_archived_is_refused(tmp_path):
    with pytest.raises(ArchiveError, match="the code was edited since commit abc; commit the"):
        write_archive(ROOT, tmp_path, [], tmp_path / "my.yaml", "abc-dirty", tmp_path / "a.zip")
    with pytest.raises(ArchiveError, match="make archive needs a clone of the project"):
        write_archive(tmp_path, tmp_path, [], tmp_path / "my.yaml", "abc", tmp_path / "a.zip")
    with pytest.raises(ArchiveError, match="is not an unpacked archive"):
        checked_files(tmp_path)
    assert not (tmp_path / "a.zip").exists()


@pytest.mark.slow
def test_the_command_archives_current_results_alone(finished, tmp_path):
    folder = tmp_path / "study"
    shutil.copytree(finished, folder)
    command = [sys.executable, str(ROOT / "workflow/archive.py"), "--configfile", "my.yaml"]

    def archived():
        result = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        return result.returncode, result.stdout + result.stderr

    status, screen = archived()
    # The project itself may be edited since its commit.
    assert "results/mine.crate.zip holds " in screen or "the code was edited" in screen
    (folder / "my.yaml").write_text(STUDY.replace("[0.3]", "[0.4]"))
    status, screen = archived()
    assert status == 2 and "does not answer this study file" in screen
    assert crate.CHECKSUMS == "checksums.sha256"
