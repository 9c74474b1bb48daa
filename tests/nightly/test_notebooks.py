"""The notebooks of examples/ run, and what stands in them is what they do."""

import runpy
import shlex
import shutil
from pathlib import Path

import nbformat
import pytest
from typer.testing import CliRunner

from vibrissa.cli.app import app

EXAMPLES = Path(__file__).parents[2] / "examples"
NOTEBOOKS = sorted(EXAMPLES.glob("*.ipynb"))
# A notebook that a reader on the web does not wait for.
LARGEST = 150_000


def shown(notebook):
    """What each code cell says and draws: its text, and how many pictures.

    The pictures themselves may differ by a pixel with another matplotlib.
    """
    cells = []
    for cell in notebook.cells:
        if cell.cell_type == "code":
            data = [output.get("data", {}) for output in cell.outputs]
            said = "".join(output.get("text", "") for output in cell.outputs)
            said += "".join(d.get("text/plain", "") for d in data if "image/png" not in d)
            cells.append((cell.source, said, sum("image/png" in d for d in data)))
    return cells


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_shows_what_it_does(path, tmp_path):
    folder = tmp_path / "examples"
    shutil.copytree(EXAMPLES, folder)
    rerun = runpy.run_path(str(EXAMPLES / "rerun.py"))["rerun"]
    ran = rerun(folder / path.name)
    committed = nbformat.read(path, as_version=4)
    assert shown(ran) == shown(committed), "its outputs are old: run python -m validation notebooks"
    outputs = [output for cell in ran.cells for output in cell.get("outputs", [])]
    assert not any(output.get("name") == "stderr" for output in outputs)
    assert any("image/png" in output.get("data", {}) for output in outputs)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_is_small_and_names_no_machine(path):
    assert path.stat().st_size < LARGEST
    notebook = nbformat.read(path, as_version=4)
    assert set(notebook.metadata) == {"kernelspec", "language_info"}
    said = "".join(str((cell.source, shown(notebook))) for cell in notebook.cells)
    assert str(Path.home()) not in said and str(EXAMPLES.parent) not in said


def test_there_are_notebooks():
    assert {"read_a_measurement", "reproduce_a_figure"} <= {path.stem for path in NOTEBOOKS}


def test_measurement_is_made_by_the_command_that_its_notebook_shows(tmp_path, monkeypatch):
    notebook = nbformat.read(EXAMPLES / "read_a_measurement.ipynb", as_version=4)
    _, _, command = notebook.cells[0].source.partition("```console\n")
    name, *arguments = shlex.split(command.partition("```")[0].replace("\\\n", " "))
    assert name == "vibrissa"
    monkeypatch.chdir(tmp_path)
    assert CliRunner().invoke(app, arguments).exit_code == 0
    made, committed = (
        [line.split(",") for line in (folder / "measurement.csv").read_text().splitlines()]
        for folder in (tmp_path, EXAMPLES)
    )
    assert made[0] == committed[0] and len(made) == len(committed)
    for new, old in zip(made[1:], committed[1:], strict=True):
        assert new[-2:] == old[-2:]
        # A reading is a number of steps of resolution, which a last digit may move by one.
        assert [float(v) for v in new[:-2]] == pytest.approx(
            [float(v) for v in old[:-2]], rel=1e-6, abs=4e-3
        )
