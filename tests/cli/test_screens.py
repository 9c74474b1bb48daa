"""What the commands say and write: whole screens and tables, with numbers to rounding.

What the numbers should be is tested elsewhere. Here stands what a user gets.
"""

import csv
import shlex
from collections import Counter
from math import inf
from pathlib import Path

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from known import WITHIN, Known
from vibrissa.cli import options
from vibrissa.cli.app import app

pytestmark = pytest.mark.slow
# Files that commands read, and one that a command makes.
INPUTS = yaml.safe_load(Path(__file__).with_name("inputs.yaml").read_text(encoding="utf-8"))
NOISY = "noisy.csv"
# A command without a screen is tried and taken as known by `make known`.
KNOWN = Known(__file__)
# Of a long table so many rows are known, and of all its rows two means.
ROWS = 9
# What is fitted ends with the remainder of an iteration.
FITTED = 2e-5


def shown(command, folder):
    """Run a command in a folder, with the files there that it names."""
    for name, text in INPUTS.items():
        if name in command:
            (folder / name).write_text(text, encoding="utf-8")
    there = set(folder.iterdir())
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        # Whether a bar is shown depends on how fast the machine is.
        patch.setattr(options, "PATIENCE", inf)
        result = CliRunner().invoke(app, shlex.split(command))
    new = sorted(set(folder.iterdir()) - there)
    return {
        "exit": result.exit_code,
        "screen": result.output.splitlines(),
        "tables": {path.name: table_of(path) for path in new if path.suffix == ".csv"},
    }


def table_of(path):
    """Some rows of a table, and two means of each column of numbers, or the words of another."""
    with path.open(encoding="utf-8", newline="") as file:
        titles, *rows = csv.reader(file)
    some = np.unique(np.linspace(0, len(rows) - 1, ROWS).astype(int)) if len(rows) > 1 else [0]
    found = {"rows": len(rows)}
    for title, cells in zip(titles, zip(*rows, strict=True), strict=True):
        try:
            values = np.array([float(cell or "nan") for cell in cells])
        except ValueError:
            found[title] = dict(Counter(cells))
        else:
            known = np.isfinite(values)
            late = (np.arange(len(values)) / len(values))[known]
            means = [values[known].mean(), (values[known] * late).mean()] if known.any() else []
            found[title] = [*values[some], *means]
    return found


@pytest.fixture(scope="module")
def noisy(tmp_path_factory):
    """A recording that several commands read."""
    folder = tmp_path_factory.mktemp("noisy")
    (command,) = (one for one in KNOWN.known if one.endswith(f"-o {NOISY}"))
    assert shown(command, folder)["exit"] == 0
    return (folder / NOISY).read_text(encoding="utf-8")


@pytest.mark.parametrize("command", KNOWN.known)
def test_a_command_says_and_writes_the_same(command, request, tmp_path):
    if f"identify {NOISY}" in command:
        recording = request.getfixturevalue("noisy")
        (tmp_path / NOISY).write_text(recording, encoding="utf-8")
    within = FITTED if command.startswith("identify") else WITHIN
    KNOWN.check(command, shown(command, tmp_path), within, told=True)
