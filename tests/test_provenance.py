"""Which commit the code is from: in a clone, without git, and in a wheel."""

import os
import re
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path
from textwrap import indent

import pytest

from vibrissa import provenance
from vibrissa.provenance import commit

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs/study.md"


def test_the_commit_is_known_or_said_to_be_unknown(monkeypatch, tmp_path):
    assert re.fullmatch(r"[0-9a-f]{40}(-dirty)?|unknown", commit())
    monkeypatch.setenv("PATH", str(tmp_path))
    assert commit() == "unknown"


def test_what_a_build_recorded_counts(monkeypatch, tmp_path):
    (tmp_path / provenance.COMMIT_FILE).write_text("0123456789-dirty\n")
    monkeypatch.setattr(provenance, "_PACKAGE", tmp_path)
    assert commit() == "0123456789-dirty"


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


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """A wheel, and a source distribution, as `pip` has them made."""
    folder = tmp_path_factory.mktemp("wheel")
    build = "import sys; from hatchling.build import *; print({}(sys.argv[1]))"
    names = [
        subprocess.run(
            [sys.executable, "-c", build.format(f"build_{kind}"), str(folder)],
            cwd=ROOT,
            check=True,
            capture_output=True,
            text=True,
        ).stdout.split()[-1]
        for kind in ("wheel", "sdist")
    ]
    return [folder / name for name in names]


@pytest.mark.slow
def test_a_wheel_has_commit_schema_and_workflow(wheel):
    archive, source = wheel
    with zipfile.ZipFile(archive) as files:
        assert files.read("vibrissa/commit.txt").decode().strip() == commit()
        names = set(files.namelist())
    workflow = [path for path in (ROOT / "workflow").rglob("*") if path.is_file()]
    for path in (ROOT / "Snakefile", ROOT / "config.yaml", *workflow):
        assert "__pycache__" in path.parts or f"vibrissa/{path.relative_to(ROOT)}" in names
    pages = [p for p in (ROOT / "src").rglob("*") if p.suffix in {".html", ".css", ".js"}]
    assert len(pages) > 20
    assert {str(path.relative_to(ROOT / "src")) for path in pages} <= names
    assert {name.partition("/")[0] for name in names} == {
        "vibrissa",
        archive.name.removesuffix("-py3-none-any.whl") + ".dist-info",
    }
    assert not [name for name in names if "__pycache__" in name]
    with tarfile.open(source) as files:
        (recorded,) = [name for name in files.getnames() if name.endswith("commit.txt")]
        assert files.extractfile(recorded).read().decode().strip() == commit()


STUDY = """study: mine
grids: {g: {theta: [1], mu0: [0.3], eta: [0.85], dx0: [0.005]}}
figures: {f: {kind: friction, grid: g, caption: One point.}}
"""
CAPTIONS = "results/mine/figures/captions.md"


@pytest.fixture
def installed(wheel, tmp_path):
    """Run a Python module in a folder beside an installed wheel."""
    archive, _ = wheel
    zipfile.ZipFile(archive).extractall(tmp_path / "packages")

    def run(*arguments):
        result = subprocess.run(
            [sys.executable, "-m", *arguments],
            cwd=tmp_path,
            env=os.environ | {"PYTHONPATH": str(tmp_path / "packages")},
            capture_output=True,
            text=True,
        )
        assert result.returncode == 0, result.stderr
        return result

    return run


@pytest.mark.slow
def test_a_wheel_runs_the_workflow_that_it_contains(installed, tmp_path):
    (tmp_path / "my.yaml").write_text(STUDY)
    result = installed("vibrissa.pipeline.run", CAPTIONS, "--configfile", "my.yaml")
    assert "--snakefile packages/vibrissa/Snakefile" in result.stderr
    assert "One point." in (tmp_path / CAPTIONS).read_text()


@pytest.mark.slow
def test_another_workflow_takes_a_wheel_as_its_module(installed, tmp_path):
    """As docs/study.md has it."""
    (snakefile,) = re.findall(r"```snakemake\n(.*?)```", PAGE.read_text(), re.DOTALL)
    (tmp_path / "Snakefile").write_text(snakefile)
    (tmp_path / "mine.yaml").write_text("sensor:\n" + indent(STUDY, "  "))
    installed("snakemake", "--cores", "1", CAPTIONS)
    assert "One point." in (tmp_path / CAPTIONS).read_text()
