"""The descriptions of the environment agree: pyproject.toml, locks/, environment.yml and the CI.

pyproject.toml holds the ranges, locks/ and environment.yml the exact versions, and the CI workflow
the Python versions. No conda client is needed.
"""

import os
import re
import subprocess
import tomllib
import venv
from itertools import chain
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from packaging.utils import canonicalize_name
from packaging.version import Version

import vibrissa

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
GROUPS = PROJECT["dependency-groups"] | PROJECT["project"]["optional-dependencies"]
# A name, its version, where it is for some platforms alone, and its hashes.
ENTRY = re.compile(r"[A-Za-z0-9._-]+==\S+(\s*;[^#]*?)?(\s+--hash=sha256:[0-9a-f]{64})+")


def requirements(lines: list[str]) -> dict[str, SpecifierSet]:
    """Name -> allowed range; an extra may contain others, as in vibrissa[tables]."""
    found = map(Requirement, lines)
    return {canonicalize_name(r.name): r.specifier for r in found if r.name != "vibrissa"}


# What a study needs.
NEEDED = requirements(
    [
        *PROJECT["project"]["dependencies"],
        *chain.from_iterable(GROUPS[extra] for extra in ("tables", "plots", "workflow")),
    ]
)


def entries_of_lock(purpose: str) -> list[str]:
    """Return the entries of a lock file without its comments, each in one line."""
    text = (ROOT / f"locks/{purpose}.lock").read_text(encoding="utf-8").replace("\\\n", " ")
    lines = [line.partition(" #")[0].strip() for line in text.splitlines()]
    return [line for line in lines if line and not line.startswith("#")]


def locked(purpose: str) -> dict[str, Version]:
    """Name -> version of every entry of a lock file."""
    pairs = [entry.split()[0].split("==") for entry in entries_of_lock(purpose)]
    return {canonicalize_name(name): Version(version) for name, version in pairs}


def conda(path: str) -> dict[str, str]:
    """Name -> version part of each entry of a conda environment, its pip section included."""
    entries: list[str] = []
    for item in yaml.safe_load((ROOT / path).read_text(encoding="utf-8"))["dependencies"]:
        entries += item["pip"] if isinstance(item, dict) else [item]
    parts = [re.fullmatch(r"(-e|[\w.-]+)(.*)", entry) for entry in entries]
    return {part[1]: part[2].strip() for part in parts if part}


PURPOSES = ("study", "files", "test", "docs", "lint", "cluster")


@pytest.mark.parametrize("purpose", PURPOSES)
def test_every_entry_of_a_lock_is_pinned_once_and_hashed(purpose: str) -> None:
    # Neither an index, an address, a path nor an option is such an entry.
    assert [entry for entry in entries_of_lock(purpose) if not ENTRY.fullmatch(entry)] == []
    assert len(locked(purpose)) == len(entries_of_lock(purpose))
    text = (ROOT / f"locks/{purpose}.lock").read_text(encoding="utf-8")
    assert not re.search("https?:|file:|index-url|find-links", text)


@pytest.mark.parametrize("purpose", PURPOSES)
def test_a_lock_has_what_a_study_needs_and_its_own_group(purpose: str) -> None:
    versions = locked(purpose)
    assert locked("study").items() <= versions.items()
    own = [line for line in GROUPS.get(purpose, []) if isinstance(line, str)]
    for name, allowed in (NEEDED | requirements(own)).items():
        assert allowed.contains(versions[name]), name


def test_the_conda_environment_has_the_versions_of_the_lock() -> None:
    pins = conda("environment.yml")
    assert pins.pop("-e") == "." and pins.pop("pip") == ""
    assert minor_versions(pins.pop("python")) == minor_versions(
        PROJECT["project"]["requires-python"]
    )
    assert {canonicalize_name(name) for name in pins} == NEEDED.keys()
    for name, pin in pins.items():
        assert pin.lstrip("=") == str(locked("study")[canonicalize_name(name)]), name


def minor_versions(specifier: str) -> list[str]:
    """Return the minor versions of Python 3 that a range allows."""
    return [f"3.{i}" for i in range(50) if SpecifierSet(specifier).contains(f"3.{i}.999")]


def test_the_ci_has_every_python_version() -> None:
    text = (ROOT / ".github/workflows/nightly.yml").read_text(encoding="utf-8")
    jobs = [job for job in yaml.safe_load(text)["jobs"].values() if "strategy" in job]
    tried = [str(v) for job in jobs for v in job["strategy"]["matrix"]["python-version"]]
    assert sorted(tried) == minor_versions(PROJECT["project"]["requires-python"])


def test_the_environment_of_jobs_has_the_versions_of_the_whole_one() -> None:
    jobs, whole = conda("workflow/envs/vibrissa.yaml"), conda("environment.yml")
    assert jobs.pop("snakemake-minimal") == whole["snakemake"]
    assert jobs.items() <= whole.items()
    lines = [*PROJECT["project"]["dependencies"], *GROUPS["tables"], *GROUPS["plots"]]
    assert requirements(lines).keys() <= {canonicalize_name(name) for name in jobs}


def test_an_environment_of_jobs_finds_the_package(tmp_path: Path) -> None:
    """A virtual environment stands for the one that conda has made and activated."""
    venv.create(tmp_path, symlinks=True)
    (tmp_path / "lib/here").mkdir()
    (tmp_path / "lib/here/vibrissa.py").touch()
    variables = os.environ | {"PATH": f"{tmp_path}/bin:{os.environ['PATH']}"}
    script = ROOT / "workflow/envs/vibrissa.post-deploy.sh"
    variables["VIBRISSA_PACKAGES"] = str(tmp_path / "lib/here")
    subprocess.run(["sh", script], env=variables, check=True)
    subprocess.run(["python", "-I", "-c", "import vibrissa"], env=variables, check=True)


def test_groups_of_packages_are_installed_one_after_the_other(tmp_path: Path) -> None:
    (tmp_path / ".study").write_text(f"{ROOT}\n")
    install = "echo begins; sleep 0.2; echo ends; true"
    command = ["make", "-s", "-j2", "setup", "LOCKS=test docs", f"VENV={tmp_path}"]
    command += [f"PIP_INSTALL={install}"]
    screen = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    assert re.findall("^begins|^ends", screen, re.M) == ["begins", "ends"] * 2


def test_the_version_is_the_same_everywhere() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    released = [title for title in re.findall(r"^## (\S+)", changelog, re.M) if title[0].isdigit()]
    assert PROJECT["project"]["dynamic"] == ["version"]
    assert ROOT / PROJECT["tool"]["hatch"]["version"]["path"] == ROOT / "src/vibrissa/__init__.py"
    assert vibrissa.__version__ == citation["version"] == released[0]


def test_the_workflow_catalogue_finds_what_it_looks_for() -> None:
    """In the places that its standardized usage names."""
    settings = yaml.safe_load((ROOT / ".snakemake-workflow-catalog.yml").read_text())
    assert settings["usage"]["software-stack-deployment"]
    for name in ("workflow/Snakefile", "config/README.md", "config/config.yaml"):
        assert (ROOT / name).is_file()
    readme = (ROOT / "README.md").read_text(encoding="utf-8").lower()
    assert "snakemake" in readme and "workflow" in readme
