"""The page's JavaScript: its modules as one script."""

from pathlib import Path

import pytest

from vibrissa.explorer import modules

ROOT = Path(__file__).parents[2]


def test_a_script_has_all_modules_in_the_order_of_their_imports():
    script = modules.bundle("solver/path.js")
    assert "import " not in script and "export " not in script and "/**" not in script
    names = ["function factorised(", "class Rod ", "function followed(", "function solvedPath("]
    places = [script.index(name) for name in names]
    assert places == sorted(places)


def test_a_name_may_not_stand_in_two_modules(tmp_path, monkeypatch):
    monkeypatch.setattr(modules, "FOLDER", tmp_path)
    (tmp_path / "one.js").write_text('import { b } from "./two.js";\nconst a = b;\n')
    (tmp_path / "two.js").write_text("export const b = 1;\n")
    assert modules.bundle("one.js") == "const b = 1;\n\nconst a = b;\n"
    (tmp_path / "two.js").write_text("export const b = 1;\nfunction a() {}\n")
    with pytest.raises(ValueError, match="the names a"):
        modules.bundle("one.js")
