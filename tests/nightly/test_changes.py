"""Examples of changes in docs/architecture.md, made in a copy of the program."""

import os
import re
import shutil
import subprocess
import sys

import pytest

from runs import ROOT

PAGE = ROOT / "docs/architecture.md"


# What is done with the changed program, by the heading of the example.
USES = {
    "A new kind of figure": """
from made_tables import grid, points
from vibrissa.figures.draw import draw
from vibrissa.study.reading import read_study
axes = {"theta": [1, 2], "mu0": [0.3], "eta": [0.85], "dx0": [0.001]}
figure = {"kind": "steps", "grid": "g", "mu0": 0.3}
study = read_study(None, {"study": "a", "grids": {"g": axes}, "figures": {"f": figure}})
table = points("g", study.grids["g"].axes)
drawn = draw("steps", table, study.figures["f"].params()["selection"])
assert len(drawn.axes[0].lines[0].get_xdata()) == 2
""",
    "A new column": """
from made_tables import grid, points
rows = points("g", grid(mu0=(0.3, 0.9))).to_pylist()
assert 0.9 < rows[0]["mobilised"] <= 1 and rows[1]["mobilised"] is None
""",
    "A new axis": """
from made_tables import points
from vibrissa.study.reading import read_study
axes = {"theta": [1], "mu0": [0.3], "eta": [0.85], "dx0": [0.001], "adhesion": [0, 0.5]}
study = read_study(None, {"study": "a", "grids": {"g": axes}})
assert list(study.chunks) == ["g/theta1_eta0.85_adhesion0"]
assert points("g", study.grids["g"].axes)["adhesion"].to_pylist() == [0, 0.5]
""",
}


def hunks(example):
    """Yield file, old and new text of each change of an example."""
    for name, body in re.findall(r"^\+\+\+ b/(\S+)\n(.*?)(?=^--- |\Z)", example, re.M | re.S):
        for hunk in body.split("@@\n")[1:]:
            lines = hunk.splitlines(keepends=True)
            yield name, *("".join(line[1:] for line in lines if line[0] != sign) for sign in "+-")


@pytest.mark.slow
@pytest.mark.parametrize("heading", USES)
def test_a_change_has_the_places_that_the_page_names(heading, tmp_path):
    page = PAGE.read_text(encoding="utf-8")
    example = page.partition(f"### {heading}\n")[2].partition("```diff\n")[2].partition("```")[0]
    shutil.copytree(ROOT / "src", tmp_path / "src")
    changed = set()
    for name, old, new in hunks(example):
        path = tmp_path / name
        text = path.read_text(encoding="utf-8")
        assert text.count(old) == 1, old
        path.write_text(text.replace(old, new), encoding="utf-8")
        changed.add(name)
    assert len(changed) <= 4
    paths = os.pathsep.join(map(str, (tmp_path / "src", ROOT / "tests")))
    command = [sys.executable, "-c", USES[heading]]
    result = subprocess.run(
        command, env=os.environ | {"PYTHONPATH": paths}, capture_output=True, text=True
    )
    assert result.returncode == 0, result.stderr
