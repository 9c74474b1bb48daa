"""Which commit the code is from: in a clone, without git, and in a wheel."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from vibrissa import provenance
from vibrissa.provenance import code_of, commit, why_unknown

ROOT = Path(__file__).parents[1]


def test_the_commit_is_known_or_said_to_be_unknown(monkeypatch, tmp_path):
    assert re.fullmatch(r"[0-9a-f]{40}(-dirty)?|unknown", commit())
    assert (commit() == "unknown") is bool(why_unknown())
    monkeypatch.setenv("PATH", str(tmp_path))
    assert commit() == "unknown"
    assert why_unknown().endswith(": install git")


def test_what_a_build_recorded_counts(monkeypatch, tmp_path):
    (tmp_path / provenance.COMMIT_FILE).write_text("0123456789-dirty\n")
    monkeypatch.setattr(provenance, "_PACKAGE", tmp_path)
    assert commit() == "0123456789-dirty"


def test_every_source_of_the_package_is_in_its_digest():
    files = {path.suffix for path in provenance._PACKAGE.rglob("*") if path.is_file()}
    assert files - {".pyc", ".typed", ".ts", ".json"} == set(provenance.SOURCES)


@pytest.fixture
def clone(tmp_path, monkeypatch):
    """A clone of a project that has the files of this one, with little in them."""
    names = ("config.yaml", "README.md", "workflow/profiles/slurm/config.yaml", *provenance.CODE)
    for name in names:
        path = tmp_path / name
        if (ROOT / name).is_dir():
            path /= "study.lock" if name == "locks" else "vibrissa/provenance.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("as committed")
    git = ["git", "-C", str(tmp_path), "-c", "user.name=a", "-c", "user.email=a@example.org"]
    for arguments in (["init", "-q"], ["add", "."], ["commit", "-qm", "all"]):
        subprocess.run([*git, *arguments], check=True)
    monkeypatch.setattr(provenance, "_PACKAGE", tmp_path / "src/vibrissa")
    return tmp_path


def test_a_link_to_nowhere_is_no_source(clone):
    before = provenance.digest()
    (clone / "src/vibrissa/.#provenance.py").symlink_to("me@here.1")
    assert provenance.digest() == before


@pytest.mark.parametrize(
    ("name", "counts"),
    [
        ("src/vibrissa/provenance.py", True),
        ("workflow/vibrissa/provenance.py", True),
        ("Snakefile", True),
        ("locks/study.lock", True),
        # They change no number, and tables hold the study file.
        ("workflow/profiles/slurm/config.yaml", False),
        ("config.yaml", False),
        ("README.md", False),
    ],
)
def test_edits_that_may_change_a_number_are_told(clone, name, counts):
    assert re.fullmatch("[0-9a-f]{40}", was := commit())
    (clone / name).write_text("edited")
    assert commit() == (f"{was}-dirty" if counts else was)


def test_the_commit_of_another_repository_says_nothing(clone):
    git = ["git", "-C", str(clone), "rm", "-q", "--cached", "src/vibrissa/provenance.py"]
    subprocess.run(git, check=True)
    assert commit() == "unknown"


def test_the_owner_of_a_clone_does_not_matter(clone, monkeypatch):
    """git refuses to work in the clone of another user; but its code is running already."""
    was = commit()
    monkeypatch.setenv("GIT_TEST_ASSUME_DIFFERENT_OWNER", "1")
    refused = subprocess.run(["git", "-C", clone, "status"], capture_output=True, text=True)
    assert "dubious ownership" in refused.stderr
    assert commit() == was and re.fullmatch("[0-9a-f]{40}", was)
    (clone / "Snakefile").write_text("edited")
    assert commit() == f"{was}-dirty"


def test_the_digest_of_the_code_is_that_of_its_content(clone):
    """The same in a clone and in a wheel, which has the workflow in the package."""
    package, scripts = clone / "src/vibrissa", clone / "workflow/scripts"
    for path in (package / "tables/a.py", scripts / "chunk.py"):
        path.parent.mkdir(parents=True)
        path.write_text("a = 1")
    was = code_of("stiction")
    scripts.joinpath("chunk.py").touch()
    assert code_of("stiction") == was
    shutil.move(clone / "workflow", package / "workflow")
    shutil.copy(clone / "Snakefile", package)
    assert code_of("stiction") == was
    for path in (package / "tables/a.py", package / "workflow/scripts/chunk.py"):
        path.write_text(f"{path.read_text()} + 1")
        assert code_of("stiction") != was
        was = code_of("stiction")
    assert f"numpy {np.__version__}, scipy " in was and "pandas" not in was
    assert "pandas" in code_of("claims")


def test_what_counts_as_code_is_there():
    assert [name for name in provenance.CODE if not (ROOT / name).exists()] == []
    assert (ROOT / provenance.PROFILES).is_dir()
