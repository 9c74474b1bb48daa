"""A wheel: what it has, and the workflow that it runs."""

import os
import re
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path
from textwrap import indent

import pytest

from vibrissa.provenance import commit

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs/study.md"


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
    installed("vibrissa.pipeline", CAPTIONS, "--configfile", "my.yaml")
    assert "One point." in (tmp_path / CAPTIONS).read_text()


@pytest.mark.slow
def test_another_workflow_takes_a_wheel_as_its_module(installed, tmp_path):
    """As docs/study.md has it."""
    (snakefile,) = re.findall(r"```snakemake\n(.*?)```", PAGE.read_text(), re.DOTALL)
    (tmp_path / "Snakefile").write_text(snakefile)
    (tmp_path / "mine.yaml").write_text("sensor:\n" + indent(STUDY, "  "))
    installed("snakemake", "--cores", "1", CAPTIONS)
    assert "One point." in (tmp_path / CAPTIONS).read_text()
