"""The page's JavaScript: types as TypeScript's compiler finds them, and modules as one script."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from vibrissa.explorer import modules

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("npx") is None, reason="no npx (Debian: apt install npm)")
def test_types_are_right():
    (command,) = re.findall("^TSC := (.*)$", (ROOT / "Makefile").read_text(), re.MULTILINE)
    run = subprocess.run(command.split(), cwd=ROOT, capture_output=True, text=True, timeout=120)
    if run.returncode and "npm error" in run.stderr:
        pytest.skip("npm cannot fetch TypeScript's compiler here")
    assert run.returncode == 0, run.stdout


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
