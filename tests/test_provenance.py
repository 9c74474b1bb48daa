"""Which commit the code is from: in a clone, without git, and in a wheel."""

import re
import subprocess
from pathlib import Path

import pytest

from vibrissa import provenance
from vibrissa.provenance import commit

ROOT = Path(__file__).parents[1]


def test_the_commit_is_known_or_said_to_be_unknown(monkeypatch, tmp_path):
    assert re.fullmatch(r"[0-9a-f]{40}(-dirty)?|unknown", commit())
    monkeypatch.setenv("PATH", str(tmp_path))
    assert commit() == "unknown"


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


def test_what_counts_as_code_is_there():
    assert [name for name in provenance.CODE if not (ROOT / name).exists()] == []
    assert (ROOT / provenance.PROFILES).is_dir()
