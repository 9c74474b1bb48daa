"""The four descriptions of the environment agree.

pyproject.toml holds the ranges, locks/ and environment.yml the exact versions, and the
CI workflow the Python versions. No conda client is needed. The checks take the files' texts and
return what is wrong, so that the second half of this file can show that they do find mistakes.
"""

from __future__ import annotations

import os
import re
import subprocess
import tomllib
import venv
from collections.abc import Callable
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from packaging.utils import canonicalize_name
from packaging.version import Version

import vibrissa

ROOT = Path(__file__).parents[2]


class Texts(NamedTuple):
    """The texts of the files that have to agree."""

    pyproject: str
    lock: str
    conda: str
    ci: str


TEXTS = Texts(
    pyproject=(ROOT / "pyproject.toml").read_text(encoding="utf-8"),
    lock=(ROOT / "locks/study.lock").read_text(encoding="utf-8"),
    conda=(ROOT / "environment.yml").read_text(encoding="utf-8"),
    ci=(ROOT / ".github/workflows/nightly.yml").read_text(encoding="utf-8"),
)


def direct_dependencies(pyproject: str) -> dict[str, SpecifierSet]:
    """Name -> allowed range, of what a study needs."""
    data = tomllib.loads(pyproject)
    lines = [
        *data["project"]["dependencies"],
        *chain.from_iterable(
            data["project"]["optional-dependencies"][extra]
            for extra in ("tables", "plots", "workflow")
        ),
    ]
    requirements = [Requirement(line) for line in lines]
    # An extra may contain others, as in vibrissa[tables].
    return {canonicalize_name(r.name): r.specifier for r in requirements if r.name != "vibrissa"}


def locked(lock: str) -> dict[str, Version]:
    """Name -> version of every entry of the lock file."""
    entries = re.findall(r"^([A-Za-z0-9._-]+)==([^\s;]+)", lock, re.MULTILINE)
    return {canonicalize_name(name): Version(version) for name, version in entries}


def conda_entries(conda: str) -> list[str]:
    """Return all entries of environment.yml, those of its pip section included."""
    entries: list[str] = []
    for item in yaml.safe_load(conda)["dependencies"]:
        entries += item["pip"] if isinstance(item, dict) else [item]
    return entries


def conda_pins(conda: str) -> dict[str, str]:
    """Name -> the version part of each entry except Python, pip and the project itself."""
    pins: dict[str, str] = {}
    for entry in conda_entries(conda):
        name = re.split(r"[=<>!~ ]", entry, maxsplit=1)[0]
        if name not in {"-e", "pip", "python"}:
            pins[canonicalize_name(name)] = entry.removeprefix(name).strip()
    return pins


def minor_versions(specifier: str) -> list[str]:
    """Return the minor versions of Python 3 that a range allows."""
    return [f"3.{i}" for i in range(50) if SpecifierSet(specifier).contains(f"3.{i}.999")]


# Words by which a lock would name where its packages come from.
ORIGINS = ("http:", "https:", "file:", "index-url", "find-links")


def check_lock_form(texts: Texts) -> list[str]:
    """Every entry of the lock is pinned once and hashed; no index, URL, path or option."""
    text = texts.lock.replace("\\\n", " ")
    lines = [line.partition(" #")[0].strip() for line in text.splitlines()]
    entries = [line for line in lines if line and not line.startswith("#")]
    problems = [] if entries else ["the lock is empty"]
    for entry in entries:
        if not re.match(
            r"^[A-Za-z0-9._-]+==\S+(\s*;[^#]*?)?(\s+--hash=sha256:[0-9a-f]{64})+$", entry
        ):
            problems.append(f"not `name==version --hash=...`: {entry[:60]}")
    names = [canonicalize_name(entry.partition("==")[0]) for entry in entries]
    problems += [f"twice in the lock: {name}" for name in set(names) if names.count(name) > 1]
    for word in ORIGINS:
        if word in texts.lock:
            problems.append(f"`{word}` in the lock")
    return problems


def check_lock_versions(texts: Texts) -> list[str]:
    """Every direct dependency is in the lock with a version that pyproject.toml allows."""
    versions = locked(texts.lock)
    problems = []
    for name, specifier in direct_dependencies(texts.pyproject).items():
        if name not in versions:
            problems.append(f"{name} is not in the lock")
        elif not specifier.contains(versions[name]):
            problems.append(f"{name} {versions[name]} is locked, but pyproject says {specifier}")
    return problems


def check_conda(texts: Texts) -> list[str]:
    """environment.yml names exactly the direct dependencies, in the versions of the lock."""
    versions, pins = locked(texts.lock), conda_pins(texts.conda)
    names = direct_dependencies(texts.pyproject).keys()
    problems = [f"{name} is not in environment.yml" for name in names - pins.keys()]
    problems += [f"{name} of environment.yml is not in pyproject" for name in pins.keys() - names]
    for name in pins.keys() & names & versions.keys():
        if pins[name] not in {f"={versions[name]}", f"=={versions[name]}"}:
            problems.append(f"{name}{pins[name]} in environment.yml, {versions[name]} in the lock")
    if "-e ." not in conda_entries(texts.conda):
        problems.append("environment.yml does not install the project itself")
    return problems


def check_python(texts: Texts) -> list[str]:
    """pyproject.toml, environment.yml and the CI matrix mean the same Python versions."""
    wanted = minor_versions(tomllib.loads(texts.pyproject)["project"]["requires-python"])
    lines = [e for e in conda_entries(texts.conda) if re.match(r"python\b(?!-)", e)]
    conda = minor_versions(lines[0].removeprefix("python")) if lines else []
    jobs = yaml.safe_load(texts.ci)["jobs"].values()
    tests = [job for job in jobs if "strategy" in job]
    ci = [str(v) for job in tests for v in job["strategy"]["matrix"]["python-version"]]
    problems = [] if wanted else ["pyproject allows no Python version"]
    if conda != wanted:
        problems.append(f"environment.yml: Python {conda}, pyproject: {wanted}")
    if sorted(ci) != sorted(wanted):
        problems.append(f"CI: Python {ci}, pyproject: {wanted}")
    return problems


Check = Callable[[Texts], list[str]]


@pytest.mark.parametrize("check", [check_lock_form, check_lock_versions, check_conda, check_python])
def test_files_agree(check: Check) -> None:
    assert check(TEXTS) == []


@pytest.mark.parametrize("purpose", ["test", "docs", "lint", "cluster"])
def test_each_lock_has_what_a_study_needs_and_its_own_group(purpose: str) -> None:
    text = (ROOT / f"locks/{purpose}.lock").read_text(encoding="utf-8")
    assert check_lock_form(TEXTS._replace(lock=text)) == []
    versions = locked(text)
    assert locked(TEXTS.lock).items() <= versions.items()
    pyproject = tomllib.loads(TEXTS.pyproject)
    purposes = pyproject["dependency-groups"] | pyproject["project"]["optional-dependencies"]
    lines = [line for line in purposes[purpose] if isinstance(line, str)]
    for requirement in map(Requirement, lines):
        if requirement.name == "vibrissa":
            continue
        assert requirement.specifier.contains(versions[canonicalize_name(requirement.name)])


def edited(file: str, pattern: str, replacement: str) -> Texts:
    """Return the real texts with one edit, which must have changed something."""
    before = getattr(TEXTS, file)
    after = re.sub(pattern, replacement, before, count=1, flags=re.MULTILINE)
    assert after != before, f"nothing to replace in {file}"
    return TEXTS._replace(**{file: after})


HASHED = r"^numpy==(\S+) \\\n(?:    --hash=\S+(?: \\)?\n)+"


@pytest.mark.parametrize(
    ("check", "file", "pattern", "replacement"),
    [
        pytest.param(check_lock_form, "lock", HASHED, r"numpy==\1\n", id="entry without hash"),
        pytest.param(check_lock_form, "lock", r"^numpy==", "numpy>=", id="entry without pin"),
        pytest.param(check_lock_form, "lock", r"\A", "--no-binary :all:\n", id="option"),
        *(pytest.param(check_lock_form, "lock", r"\A", f"# {w} here\n", id=w) for w in ORIGINS),
        pytest.param(check_lock_form, "lock", r"\Z", "x @ file:///x.whl\n", id="local file"),
        pytest.param(check_lock_form, "lock", rf"({HASHED})", r"\1\1", id="entry twice"),
        pytest.param(check_lock_form, "lock", r"sha256:[0-9a-f]{4}", "sha256:", id="short hash"),
        pytest.param(check_lock_versions, "lock", HASHED, "", id="missing in lock"),
        pytest.param(check_lock_versions, "lock", r"^numpy==", "numpy==1.", id="outside range"),
        pytest.param(
            check_lock_versions,
            "pyproject",
            r'"numpy>=2.2,',
            '"numpy>=2.2,<2.3,',
            id="range narrowed",
        ),
        pytest.param(
            check_lock_versions, "pyproject", r'"numpy>=', '"nump1>=1", "numpy>=', id="dependency"
        ),
        pytest.param(check_conda, "conda", r"^  - numpy=.*\n", "", id="missing in conda"),
        pytest.param(check_conda, "conda", r"numpy=.*", "numpy=2.0.0", id="other conda version"),
        pytest.param(check_conda, "conda", r"numpy=.*", "numpy", id="no conda version"),
        pytest.param(check_conda, "conda", r"^  - pip$", "  - pip\n  - xarray=1", id="unknown"),
        pytest.param(check_conda, "conda", r"^ +- -e \.\n", "", id="project missing in conda"),
        pytest.param(check_python, "conda", r"<3\.14", "<3.13", id="conda Python"),
        pytest.param(check_python, "conda", r"^  - python.*\n", "", id="no conda Python"),
        pytest.param(check_python, "ci", r', "3\.13"', "", id="CI Python missing"),
        pytest.param(check_python, "ci", r'"3\.11"', '"3.10"', id="CI Python too old"),
        pytest.param(check_python, "pyproject", r">=3\.11,", ">=3.12,", id="project Python"),
    ],
)
def test_checks_find_mistakes(check: Check, file: str, pattern: str, replacement: str) -> None:
    assert check(edited(file, pattern, replacement)) != []


def test_the_environment_of_jobs_has_the_versions_of_the_whole_one() -> None:
    jobs = conda_pins((ROOT / "workflow/envs/vibrissa.yaml").read_text(encoding="utf-8"))
    assert jobs.pop("snakemake-minimal") == conda_pins(TEXTS.conda)["snakemake"]
    assert jobs.items() <= conda_pins(TEXTS.conda).items()
    extras = tomllib.loads(TEXTS.pyproject)["project"]["optional-dependencies"]
    core = tomllib.loads(TEXTS.pyproject)["project"]["dependencies"]
    needed = {Requirement(line).name for line in (*core, *extras["tables"], *extras["plots"])}
    assert needed <= jobs.keys()


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


def test_the_version_is_the_same_everywhere() -> None:
    version = tomllib.loads(TEXTS.pyproject)["project"]["version"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    released = [title for title in re.findall(r"^## (\S+)", changelog, re.M) if title[0].isdigit()]
    assert version == vibrissa.__version__ == citation["version"] == released[0]


def test_the_workflow_catalogue_finds_what_it_looks_for() -> None:
    """In the places that its standardized usage names."""
    settings = yaml.safe_load((ROOT / ".snakemake-workflow-catalog.yml").read_text())
    assert settings["usage"]["software-stack-deployment"]
    for name in ("workflow/Snakefile", "config/README.md", "config/config.yaml"):
        assert (ROOT / name).is_file()
    readme = (ROOT / "README.md").read_text(encoding="utf-8").lower()
    assert "snakemake" in readme and "workflow" in readme
