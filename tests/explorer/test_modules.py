"""The page's JavaScript: its modules as one script."""

import pytest

from vibrissa.explorer import modules


def test_modules_are_one_script_in_the_order_of_their_imports(tmp_path, monkeypatch):
    monkeypatch.setattr(modules, "FOLDER", tmp_path)
    (tmp_path / "one.js").write_text('import { b } from "./two.js";\nconst a = b;\n')
    (tmp_path / "two.js").write_text("/** One. */\nexport const b = 1;\n")
    assert modules.bundle("one.js") == "const b = 1;\n\nconst a = b;\n"
    (tmp_path / "two.js").write_text("export const b = 1;\nfunction a() {}\n")
    with pytest.raises(ValueError, match="the names a"):
        modules.bundle("one.js")
