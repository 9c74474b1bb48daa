"""Without an extra, one line says what to install; solver and command line need none."""

import subprocess
import sys
import tomllib
from importlib.metadata import distribution
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from vibrissa.errors import MissingExtraError
from vibrissa.extras import require

ROOT = Path(__file__).parents[1]
SOLVE = ("solve", "--theta", "2", "--mu0", "0.4", "--eta", "0.85", "--step", "0.001")


def needed(lines, extras=frozenset({""})):
    """Names of the packages that pip installs for some requirements."""
    found = set()
    for requirement in map(Requirement, lines):
        marker = requirement.marker
        if not marker or any(marker.evaluate({"extra": extra}) for extra in extras):
            own = distribution(requirement.name).requires or ()
            found |= {requirement.name} | needed(own, requirement.extras or {""})
    return found


@pytest.fixture(scope="module")
def bare(tmp_path_factory):
    """A folder of packages as after `pip install vibrissa` without an extra."""
    folder = tmp_path_factory.mktemp("bare")
    (folder / "vibrissa").symlink_to(ROOT / "src/vibrissa")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    for name in needed(project["dependencies"]):
        package = distribution(name)
        for top in {path.parts[0] for path in package.files} - {"..", "__pycache__"}:
            (folder / top).symlink_to(package.locate_file(top))
    return folder


def call(bare, code, *arguments, cwd):
    code = f"import sys; sys.path.append({str(bare)!r})\n{code}"
    command = [sys.executable, "-I", "-S", "-c", code, *arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "status", "line"),
    [
        (("-o", "a.csv"), 0, ""),
        (("-o", "a.parquet"), 2, "vibrissa: this needs pyarrow: pip install 'vibrissa[tables]'\n"),
    ],
)
def test_commands_need_no_extra_but_say_where_they_do(bare, tmp_path, arguments, status, line):
    code = "from vibrissa.cli.app import app; app()"
    result = call(bare, code, *SOLVE, *arguments, cwd=tmp_path)
    assert (result.returncode, result.stderr) == (status, line)


def test_a_program_that_needs_an_extra_says_so_in_one_line(bare):
    result = subprocess.run(
        [sys.executable, "-S", "-m", "vibrissa.pipeline"],
        env={"PYTHONPATH": str(bare)},
        capture_output=True,
        text=True,
    )
    line = "this needs snakemake, yaml: pip install 'vibrissa[workflow]'\n"
    assert (result.returncode, result.stderr) == (1, line)


def test_what_python_looks_for_by_its_name_ends_with_a_line(monkeypatch):
    """The error would be shown with forty lines of a module that looks for modules."""
    line = "this needs none_such, nor_this: pip install 'vibrissa[plots]'"
    monkeypatch.setattr(sys, "argv", ["-m"])
    with pytest.raises(SystemExit) as ended:
        require("plots", "none_such", "sys", "nor_this")
    assert ended.value.code == line
    monkeypatch.setattr(sys, "argv", ["vibrissa", "-m"])
    with pytest.raises(MissingExtraError) as missing:
        require("plots", "none_such", "nor_this")
    assert str(missing.value) == line


@pytest.mark.parametrize(
    ("module", "line"),
    [
        ("tables.store", "this needs pyarrow: pip install 'vibrissa[tables]'"),
        ("figures.draw", "this needs matplotlib: pip install 'vibrissa[plots]'"),
        ("report.page", "this needs jinja2: pip install 'vibrissa[workflow]'"),
    ],
)
def test_an_import_says_what_to_install(bare, tmp_path, module, line):
    result = call(bare, f"import vibrissa.{module}", cwd=tmp_path)
    assert result.stderr.splitlines()[-1] == f"vibrissa.errors.MissingExtraError: {line}"
