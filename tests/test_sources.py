import ast
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

import vibrissa
from vibrissa import sources as module
from vibrissa.sources import sources

ROOT = Path(__file__).parents[1]
METHODS = ("collocation", "shooting")


def names(paths):
    return {Path(path).stem for path in paths}


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Write a package of the given modules and let `sources` look into it."""
    folder = tmp_path / "pkg"
    folder.mkdir()
    monkeypatch.setattr(module, "PACKAGE", folder)

    def write(**modules):
        for name, text in modules.items():
            (folder / f"{name}.py").write_text(text)

    return write


def test_imports_are_followed_through_modules_functions_and_circles(package):
    package(
        a="import numpy\nfrom pkg.b import thing",
        b="from pkg import VERSION, c",
        c="def late():\n    from pkg.d import thing",
        d="from pkg.a import thing",
        alone="from other.a import thing",
        unused="",
    )
    assert names(sources("a")) == {"a", "b", "c", "d"}
    assert names(sources("alone")) == {"alone"}
    assert names(sources("alone", "d")) == {"a", "alone", "b", "c", "d"}


def test_a_page_of_a_module_belongs_to_it(package, tmp_path):
    package(a="", ab="")
    for name in ("a.html", "a.js", "a.css", "a.py~", "b.js"):
        (tmp_path / "pkg" / name).touch()
    found = {Path(path).name for path in sources("a")}
    assert found == {"a.py", "a.html", "a.js", "a.css"}


def test_imports_for_type_checkers_are_not_followed(package):
    package(
        a="from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from pkg.b import B",
        b="",
    )
    assert names(sources("a")) == {"a"}


def test_an_unknown_module_is_an_error(package):
    package(a="")
    with pytest.raises(FileNotFoundError, match=r"nothing\.py"):
        sources("a", "nothing")


def test_paths_are_relative_to_the_working_directory(monkeypatch, tmp_path):
    monkeypatch.chdir(ROOT)
    assert sources("status") == ["src/vibrissa/status.py"]
    monkeypatch.chdir(tmp_path)
    assert sources("status") == [str(ROOT / "src/vibrissa/status.py")]


@pytest.mark.parametrize("name", ["records", "figures", "api", "study"])
def test_sources_of_a_module_are_what_python_loads(name):
    code = f"import sys, vibrissa.{name}; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    used = {m.removeprefix("vibrissa.") for m in loaded.stdout.split() if "vibrissa." in m}
    assert used == names(sources(name))


def test_the_snakefile_does_not_wait_for_numpy():
    imports = (ROOT / "workflow/rules/common.smk").read_text().partition("ENDINGS")[0]
    loaded = subprocess.run(
        [sys.executable, "-c", imports + "\nimport sys; print(*sys.modules)"],
        capture_output=True,
        text=True,
    )
    modules = loaded.stdout.split()
    assert "vibrissa.study" in modules
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
    """Modules that the `code=sources(...)` of a rule covers."""
    code = re.search(r"\bcode=(sources\(.*?\))", body)
    study = SimpleNamespace(method=method)
    return names(eval(code[1], {"sources": sources, "STUDY": study})) if code else set()


def imported(script, method):
    """Modules of the package that a workflow script imports."""
    text = (ROOT / "workflow/scripts" / script).read_text()
    modules = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found = {alias.name.partition(".") for alias in node.names}
            modules |= {name for package, _, name in found if package == "vibrissa"}
        elif isinstance(node, ast.ImportFrom):
            package, _, name = node.module.partition(".")
            if package == "vibrissa":
                found = {name} if name else {alias.name for alias in node.names}
                modules |= {vibrissa._HOMES.get(name, name) for name in found}
    if "import_module(" in text:
        assert text.count("import_module(") == 1
        assert 'import_module(f"vibrissa.{snakemake.params.method}")' in text
        modules.add(method)
    return modules


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
