"""A study as one file, and whether it makes its results again."""

import json
import os
import shutil
import subprocess
import sys
import zipfile
from datetime import UTC, datetime, timedelta
from pathlib import Path
from urllib.parse import unquote

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from rocrate.rocrate import ROCrate

from made_up import COMPLETE
from vibrissa.archive import reproduction
from vibrissa.archive.crate import CODE, RUN, ArchiveError, write_archive
from vibrissa.tables import store

ROOT = Path(__file__).parents[2]
STUDY = """
study: whisker
grids:
  main:
    theta: [2]
    mu0: [0.3, 5]
    eta: [0.85]
    dx0: [0.005]
    refine: {tolerance: 0.01, closest: {mu0: 0.5}}
"""
# As people name files, and as the crate's metadata have it.
STUDY_FILE, STUDY_ID = "whisker 50%.yaml", "studies/whisker%2050%25.yaml"
MADE = ("tables/stiction.parquet", "figures/taper.svg", "report.html")
TABLE = "results/whisker/tables/stiction.parquet"
COMMIT = "0123456789abcdef"


@pytest.fixture(scope="module")
def packed(tmp_path_factory):
    """An archive of made-up results."""
    folder = tmp_path_factory.mktemp("study")
    (folder / STUDY_FILE).write_text(STUDY)
    results = folder / "results/whisker"
    for name in ("tables", "figures", "logs"):
        (results / name).mkdir(parents=True)
    store.write(COMPLETE, results / "tables/stiction.parquet")
    # The last three are not of the study as it is now.
    others = ("figures/old.svg", "claims.md", "logs/all.log")
    for name in (*MADE[1:], *others):
        (results / name).write_text(name)
    output = folder / "whisker.zip"
    write_archive(ROOT, results, MADE, folder / STUDY_FILE, COMMIT, output)
    return output


@pytest.fixture
def unpacked(packed, tmp_path):
    with zipfile.ZipFile(packed) as file:
        file.extractall(tmp_path / "a b")
    return tmp_path / "a b"


def test_an_archive_says_to_the_second_when_it_was_made(unpacked):
    graph = json.loads((unpacked / "ro-crate-metadata.json").read_text())["@graph"]
    (root,) = [entity for entity in graph if entity["@id"] == "./"]
    made = datetime.fromisoformat(root["datePublished"])
    assert made.microsecond == 0 and made.utcoffset() == timedelta(0)
    assert abs(datetime.now(UTC) - made) < timedelta(minutes=10)


def test_an_archive_holds_what_makes_the_results(unpacked):
    recorded = reproduction.checksums(unpacked)
    assert {"Snakefile", "requirements.lock", f"studies/{STUDY_FILE}", "README.md"} <= set(recorded)
    assert {name for name in recorded if name.startswith("results/")} == {
        *(TABLE, "results/whisker/figures/taper.svg", "results/whisker/report.html")
    }
    assert list(reproduction.damaged(unpacked, recorded)) == []
    assert not [name for name in recorded if "__pycache__" in name]
    # Two archives of the same files are the same, whatever the order in which a disk lists them.
    source = [name for name in recorded if name.startswith("src/")]
    assert source == sorted(source) and len(source) > 100
    assert (unpacked / "src/vibrissa/commit.txt").read_text() == f"{COMMIT}\n"
    assert f"commit {COMMIT}" in (unpacked / "README.md").read_text()


def test_its_metadata_name_every_file_the_run_and_the_license(unpacked):
    crate = ROCrate(unpacked)
    files = {path.relative_to(unpacked).as_posix() for path in unpacked.rglob("*.*")}
    described = {unquote(entity.id) for entity in crate.data_entities}
    assert set(reproduction.checksums(unpacked)) < described
    assert {name for name in files if (unpacked / name).is_file()} - described == {
        "ro-crate-metadata.json"
    }
    run = crate.get(RUN)
    assert run["instrument"].id == crate.mainEntity.id == "Snakefile"
    assert run["object"].id == STUDY_ID
    assert reproduction.study_file(unpacked) == f"studies/{STUDY_FILE}"
    assert TABLE in [entity.id for entity in run["result"]]
    assert crate.license.id == "https://spdx.org/licenses/MIT"
    assert crate.root_dataset["version"] == COMMIT
    assert crate.root_dataset["author"]["name"] == "Vibrissa developers"


def test_a_damaged_archive_is_found_out(unpacked):
    recorded = reproduction.checksums(unpacked)
    (unpacked / "config.yaml").write_text("study: other\n")
    (unpacked / TABLE).unlink()
    assert sorted(reproduction.damaged(unpacked, recorded)) == [
        "config.yaml was changed",
        f"{TABLE} is gone",
    ]
    with pytest.raises(ArchiveError, match="is not an unpacked archive: it has no checksums"):
        reproduction.checksums(unpacked / "results")


def test_what_differs_is_said(unpacked, tmp_path):
    recorded = reproduction.checksums(unpacked)
    again = tmp_path / "again"

    def differences():
        return list(reproduction.differences(unpacked, again, recorded))

    shutil.copytree(unpacked / "results", again / "results")
    (again / "results/whisker/report.html").write_text("of another day")
    assert differences() == []
    (again / "results/whisker/figures/taper.svg").unlink()
    other = {**COMPLETE.schema.metadata, b"other": b"x"}
    store.write(COMPLETE.replace_schema_metadata(other), again / TABLE)
    assert sorted(differences()) == [
        "results/whisker/figures/taper.svg was not made",
        f"{TABLE}: the same values; other metadata (other)",
    ]
    moved = pa.array(COMPLETE["mu0"].to_pylist()[::-1])
    index = COMPLETE.schema.get_field_index("mu0")
    store.write(COMPLETE.set_column(index, COMPLETE.schema.field(index), moved), again / TABLE)
    assert differences()[1].startswith(f"{TABLE}: other values in mu0, by 0.6 of the largest")
    index = COMPLETE.schema.get_field_index("theta")
    changed = pa.array(COMPLETE["theta"].to_pandas() * (1 + 1e-14))
    store.write(COMPLETE.set_column(index, COMPLETE.schema.field(index), changed), again / TABLE)
    said = f"{TABLE}: other values in theta, by 1e-14 of the largest number of a column at most"
    assert differences()[1] == said
    store.write(COMPLETE.slice(1), again / TABLE)
    assert differences()[1].startswith(f"{TABLE}: rows and columns were (")
    pq.write_table(COMPLETE.rename_columns(COMPLETE.column_names[::-1]), again / TABLE)
    assert differences()[1].startswith(f"{TABLE}: rows and columns were (")


def test_numbers_where_there_were_none_have_no_largest_change():
    nothing, some = (pa.table({"x0_slip": pa.array(x, pa.float64())}) for x in ([None], [0.1]))
    for one, other in ((nothing, some), (some, nothing), (nothing, nothing)):
        assert reproduction._largest_change(one, other) is None


@pytest.mark.parametrize("again", ["one", "other"])
def test_metadata_that_differ_are_named_on_either_side(tmp_path, again):
    table = pa.table({"x": [1]})
    for folder, metadata in (
        ("one", {"was": "1", "both": "1", "same": "1"}),
        ("other", {"is": "1", "both": "2", "same": "1"}),
    ):
        (tmp_path / folder / "results").mkdir(parents=True)
        path = tmp_path / folder / "results/a.parquet"
        pq.write_table(table.replace_schema_metadata(metadata), path)
    (before,) = {"one", "other"} - {again}
    recorded = {"results/a.parquet": "another sum"}
    (line,) = reproduction.differences(tmp_path / before, tmp_path / again, recorded)
    assert line == "results/a.parquet: the same values; other metadata (both, is, was)"


@pytest.mark.parametrize(("was", "now"), [(None, None), ({"a": "1"}, None), (None, {"a": "1"})])
def test_tables_without_metadata_are_compared_too(tmp_path, was, now):
    for name, metadata in (("was", was), ("now", now)):
        pq.write_table(pa.table({"x": [1]}).replace_schema_metadata(metadata), tmp_path / name)
    said = reproduction._table_difference(tmp_path / "was", tmp_path / "now")
    keys = "of the file format" if was == now else "a"
    assert said == f"the same values; other metadata ({keys})"


def test_code_that_no_commit_names_is_refused(tmp_path):
    with pytest.raises(ArchiveError, match="edited since commit abc; commit the changes"):
        write_archive(ROOT, tmp_path, MADE, ROOT / "config.yaml", "abc-dirty", tmp_path / "a.zip")
    with pytest.raises(ArchiveError, match=r"has no Snakefile, .*; make archive needs a clone"):
        write_archive(tmp_path, tmp_path, MADE, ROOT / "config.yaml", "abc", tmp_path / "a.zip")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("status", [0, 3])
def test_how_a_run_of_an_archived_study_has_ended_is_told(unpacked, tmp_path, status):
    (unpacked / "workflow/run.py").write_text(
        "import pathlib, sys\n"
        "assert not pathlib.Path('results').exists() and pathlib.Path('Snakefile').exists()\n"
        f"assert sys.argv[1:] == ['--configfile', 'studies/{STUDY_FILE}']\nsys.exit({status})\n"
    )
    recorded = reproduction.checksums(unpacked)
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    assert reproduction.run_again(unpacked, recorded, scratch) == status


@pytest.mark.slow
def test_an_archive_makes_its_results_again_bit_for_bit(tmp_path):
    project = tmp_path / "a project"
    for name in CODE:
        (project / name).parent.mkdir(parents=True, exist_ok=True)
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, project / name)
    (project / STUDY_FILE).write_text(STUDY)

    def call(folder, *arguments):
        environment = os.environ | {"PYTHONPATH": str(folder / "src")}
        return subprocess.run(
            [sys.executable, *arguments],
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
        )

    study = ("--configfile", STUDY_FILE)
    assert call(project, "workflow/run.py", *study).returncode == 0
    old = project / "results/whisker/figures/old.png"
    old.parent.mkdir()
    old.write_text("of an earlier study file")
    made = call(project, "workflow/archive.py", *study)
    assert made.returncode == 0, made.stderr
    assert made.stdout.startswith("Not of the study file as it is now, and in neither report nor")
    assert "figures/old.png (1 file in results/whisker;" in made.stdout
    with zipfile.ZipFile(project / "results/whisker.crate.zip") as file:
        file.extractall(tmp_path / "else where")
    again = call(tmp_path / "else where", "workflow/verify.py")
    assert again.stdout == "1 of 1 results are the same, bit for bit.\n", again.stderr
    assert again.returncode == 0
