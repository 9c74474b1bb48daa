import ast
import hashlib
import os
import re
import subprocess
import sys
from itertools import count
from pathlib import Path
from types import SimpleNamespace

import pytest

import vibrissa
from vibrissa.outcomes import Solver
from vibrissa.pipeline import sources as module
from vibrissa.pipeline.sources import sources, sources_file

ROOT = Path(__file__).parents[2]
METHODS = tuple(Solver)
NUMBERS = count()


def names(paths):
    """Dotted names of the modules of some source files, without that of the package."""
    return {dotted(path) for path in paths if path.suffix == ".py"}


def dotted(path):
    parts = path.with_suffix("").parts
    top = max(i for i, part in enumerate(parts) if part.startswith(("pkg", "vibrissa")))
    return ".".join(part for part in parts[top + 1 :] if part != "__init__")


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Write a package of the given modules and let `sources` look into it."""
    # Python and `sources` remember packages by their names.
    name = f"pkg{next(NUMBERS)}"
    folder = tmp_path / name
    folder.mkdir()
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(module, "PACKAGE", name)

    def write(**modules):
        for path, text in {"__init__": "", **modules}.items():
            file = folder / f"{path.replace('.', '/')}.py"
            file.parent.mkdir(exist_ok=True)
            file.write_text(text.replace("pkg", name))
        return folder

    return write


def test_imports_are_followed_through_modules_functions_and_circles(package):
    package(
        a="import json\nfrom pkg.b import thing",
        b="from pkg import c",
        c="def late():\n    from pkg.d import thing",
        d="from pkg.a import thing",
        alone="from json import thing",
        unused="",
    )
    assert names(sources("a")) == {"", "a", "b", "c", "d"}
    assert names(sources("alone")) == {"", "alone"}
    assert names(sources("alone", "d")) == {"", "a", "alone", "b", "c", "d"}


def test_modules_of_nested_packages_need_their_packages_and_what_these_import(package):
    package(
        **{
            "low.__init__": "",
            "low.a": "",
            "low.b": "",
            "high.__init__": "from pkg.low import b",
            "high.c": "from pkg.low.a import thing",
        }
    )
    assert names(sources("high.c")) == {"", "high", "high.c", "low", "low.a", "low.b"}


def test_the_files_of_a_page_belong_to_its_package(package):
    folder = package(a="", ab="")
    for name in ("view", "other"):
        (folder / name).mkdir()
    (folder / "other/__init__.py").touch()
    for name in ("a.html", "c.css", "a.py~", "a.json", "view/b.js", "other/d.js"):
        (folder / name).touch()
    found = {path.name for path in sources("a")}
    assert found == {"__init__.py", "a.py", "a.html", "c.css", "b.js"}


def test_imports_for_type_checkers_are_not_followed(package):
    package(
        a="from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from pkg.b import B",
        b="",
    )
    assert names(sources("a")) == {"", "a"}


def test_one_file_stands_for_sources_and_is_no_younger(package, tmp_path, monkeypatch):
    folder = package(a="from pkg import b", b="", c="")
    monkeypatch.chdir(tmp_path)
    files = [folder / f"{name}.py" for name in ("__init__", "a", "b")]
    for age, file in enumerate(files):
        os.utime(file, (1_000 + age, 1_000 + age))
    found = Path(sources_file("a"))
    assert found == Path(".snakemake/code/a.txt")
    assert found.stat().st_mtime == 1_002
    empty = hashlib.sha256(b"").hexdigest()
    digests = [hashlib.sha256(file.read_bytes()).hexdigest() for file in files]
    assert digests[0] == digests[2] == empty != digests[1]
    assert found.read_text() == "".join(
        f"{digest}  {file.relative_to(tmp_path)}\n"
        for digest, file in zip(digests, files, strict=True)
    )
    assert sources_file("c", "b") == ".snakemake/code/c-b.txt"


def test_the_file_of_sources_changes_when_one_does(package, tmp_path, monkeypatch):
    folder = package(a="from pkg import b", b="", c="")
    monkeypatch.chdir(tmp_path)
    found = Path(sources_file("a"))
    before = found.read_text()

    def age():
        os.utime(found, (1_000, 1_000))
        sources_file("a")
        return found.stat().st_mtime

    # What is only touched, or is no source of it, changes nothing.
    (folder / "b.py").touch()
    (folder / "c.py").write_text("x = 1")
    assert age() == 1_000 and found.read_text() == before
    # An older text is new, too, whatever its age.
    (folder / "b.py").write_text("x = 2")
    os.utime(folder / "b.py", (900, 900))
    assert age() > 1_000_000 and found.read_text() != before


def test_the_file_of_sources_of_a_package_elsewhere_is_absolute(package, tmp_path, monkeypatch):
    package(a="")
    (tmp_path / "other").mkdir()
    monkeypatch.chdir(tmp_path / "other")
    assert sources_file("a") == str(tmp_path / "other/.snakemake/code/a.txt")


def test_an_unknown_module_is_an_error(package):
    package(a="")
    with pytest.raises(ValueError, match=r"^no module pkg\d+\.nothing$"):
        sources("a", "nothing")


# Of each module, those that only a function imports.
LATE = {
    "tables.records": set(),
    "figures.draw": set(),
    "sticking.api": {"sticking.solving.shooting", "mechanics.elastica"},
    "study.model": set(),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", LATE)
def test_sources_of_a_module_are_what_python_loads(name):
    code = f"import sys, vibrissa.{name}; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    used = {m.partition(".")[2] for m in loaded.stdout.split() if m.split(".")[0] == "vibrissa"}
    assert used | LATE[name] == names(sources(name))
    assert not used & LATE[name]


def test_the_snakefile_does_not_wait_for_numpy():
    imports = (ROOT / "workflow/rules/common.smk").read_text().partition("# Snakemake (")[0]
    loaded = subprocess.run(
        [sys.executable, "-c", imports + "\nimport sys; print(*sys.modules)"],
        capture_output=True,
        text=True,
    )
    modules = loaded.stdout.split()
    assert "vibrissa.study.model" in modules
    assert not {"numpy", "scipy", "pyarrow", "matplotlib"}.intersection(modules)


def rules():
    """Rules that run a script: the script's name and the text of the rule, by the rule's name."""
    found = {}
    for path in sorted((ROOT / "workflow/rules").glob("*.smk")):
        for name, body in re.findall(r"^rule (\w+):\n((?:\s*\n| .*\n)+)", path.read_text(), re.M):
            if script := re.search(r'script:\s+"\.\./scripts/(\w+\.py)"', body):
                found[name] = (script[1], body)
    return found


def declared(body, method):
    """Modules that the `code=sources_file(...)` of a rule covers."""
    code = re.search(r"\bcode=sources_file(\(.*?\))", body, re.S)
    study = SimpleNamespace(method=method)
    return names(eval(f"sources{code[1]}", {"sources": sources, "STUDY": study})) if code else set()


def imported(script, method):
    """Modules of the package that a workflow script imports."""
    text = (ROOT / "workflow/scripts" / script).read_text()
    modules = set()
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, ast.ImportFrom) or not node.module.startswith("vibrissa"):
            continue
        home = node.module.partition(".")[2]
        for alias in node.names:
            name = f"{home}.{alias.name}".lstrip(".")
            path = ROOT / "src/vibrissa" / f"{name.replace('.', '/')}.py"
            modules.add(name if path.exists() else home or vibrissa._HOMES[alias.name])
    # A script that tells methods apart imports the one that it uses.
    others = {f"sticking.solving.{other}" for other in METHODS if other != method}
    return modules - others if "is Solver." in text else modules


def test_every_script_belongs_to_one_rule():
    scripts = [script for script, _ in rules().values()]
    assert sorted(scripts) == sorted(p.name for p in (ROOT / "workflow/scripts").glob("*.py"))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("rule", rules())
def test_a_rule_depends_on_every_module_that_its_script_imports(rule, method):
    script, body = rules()[rule]
    used = imported(script, method)
    assert used
    assert used <= declared(body, method)
