"""docs/architecture.md shows the packages as they import one another."""

import importlib.util
from pathlib import Path

ROOT = Path(__file__).parents[2]

spec = importlib.util.spec_from_file_location("architecture", ROOT / "docs/architecture.py")
architecture = importlib.util.module_from_spec(spec)
spec.loader.exec_module(architecture)


def test_page_fits_the_imports():
    page = architecture.PAGE.read_text(encoding="utf-8")
    assert page == architecture.replaced(page), "it is old: run make architecture"


def test_every_package_is_shown():
    packages = {path.parent.name for path in (ROOT / "src/vibrissa").glob("*/__init__.py")}
    assert packages == set(architecture.package_imports())


def test_imports_that_others_imply_are_left_out():
    imports = {"a": {"b", "c", "d"}, "b": {"c"}, "c": set(), "d": {"c"}}
    assert architecture.without_detours(imports) == {
        "a": {"b", "d"},
        "b": {"c"},
        "c": set(),
        "d": {"c"},
    }


def test_an_old_page_is_noticed():
    page = architecture.PAGE.read_text(encoding="utf-8")
    old = page.replace("    mechanics --> numerics\n", "")
    assert old != page and architecture.replaced(old) == page
