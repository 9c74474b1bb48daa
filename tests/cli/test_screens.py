"""What the commands say and write: whole screens and tables, with numbers to rounding.

What the numbers should be is tested elsewhere. Here stands what a user gets.
"""

import csv
import re
import shlex
from collections import Counter
from decimal import Decimal
from math import inf, isfinite
from pathlib import Path

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from vibrissa.cli import options
from vibrissa.cli.app import app

pytestmark = pytest.mark.slow
SCREENS = Path(__file__).with_name("screens.yaml")
ENTRIES = yaml.safe_load(SCREENS.read_text(encoding="utf-8"))
# Files that commands read, as they are written, and one that a command makes.
INPUTS, KNOWN = ENTRIES["files"], ENTRIES["commands"]
NOISY = "noisy.csv"
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?!\w)")
# Of a long table so many rows are kept, and of all its rows two means.
ROWS = 9
# Of the largest number of a column. What is fitted ends with the remainder of an iteration.
EXACT, FITTED = 1e-7, 2e-5


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
            found[title] = [float(f"{value:.10g}") for value in (*values[some], *means)]
    return found


@pytest.fixture(scope="module")
def noisy(tmp_path_factory):
    """A recording that several commands read."""
    folder = tmp_path_factory.mktemp("noisy")
    (command,) = (one for one in KNOWN if one.endswith(f"-o {NOISY}"))
    assert shown(command, folder)["exit"] == 0
    return (folder / NOISY).read_text(encoding="utf-8")


def parts(line):
    """Split a line into its words and its numbers, as they are written."""
    return NUMBER.sub("#", line), [Decimal(text) for text in NUMBER.findall(line)]


def same(number, known):
    """Whether numbers are the same but for rounding: one in the last place that is shown."""
    last = Decimal(1).scaleb(known.as_tuple().exponent)
    return abs(number - known) <= max(last, abs(known) * Decimal("1e-4"), Decimal("1e-5"))


@pytest.mark.parametrize("command", KNOWN)
def test_a_command_says_and_writes_the_same(command, request, tmp_path):
    if f"identify {NOISY}" in command:
        recording = request.getfixturevalue("noisy")
        (tmp_path / NOISY).write_text(recording, encoding="utf-8")
    found, known = shown(command, tmp_path), KNOWN[command]
    new = yaml.safe_dump({command: found}, allow_unicode=True, sort_keys=False, width=1000)
    print(f"If this was meant to change: review it and put it into {SCREENS}:\n{new}")
    assert found["exit"] == known["exit"]
    assert len(found["screen"]) == len(known["screen"])
    for line, expected in zip(found["screen"], known["screen"], strict=True):
        (words, numbers), (its_words, its_numbers) = parts(line), parts(expected)
        assert words == its_words
        assert all(map(same, numbers, its_numbers)), (line, expected)
    assert found["tables"].keys() == known["tables"].keys()
    within = FITTED if command.startswith("identify") else EXACT
    for name, table in known["tables"].items():
        assert list(found["tables"][name]) == list(table)
        for title, column in table.items():
            new = found["tables"][name][title]
            if isinstance(column, list):
                size = max((abs(value) for value in column if isfinite(value)), default=0.0)
                assert new == pytest.approx(column, rel=0.0, abs=within * size, nan_ok=True), title
            else:
                assert new == column, title
