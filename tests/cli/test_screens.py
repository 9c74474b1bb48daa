"""What the commands say, word by word: whole screens, with numbers to the last place but rounding.

What the numbers should be is tested elsewhere. Here stands what a user reads.
"""

import math
import re
import shlex
from decimal import Decimal
from pathlib import Path

import pytest
import yaml
from typer.testing import CliRunner

from vibrissa.cli import options
from vibrissa.cli.app import app

# One run of all commands serves all tests.
pytestmark = pytest.mark.slow
SCREENS = Path(__file__).with_name("screens.yaml")
KNOWN = yaml.safe_load(SCREENS.read_text(encoding="utf-8"))
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?!\w)")


def shown(command):
    result = CliRunner().invoke(app, shlex.split(command))
    return {"exit": result.exit_code, "screen": result.output.splitlines()}


@pytest.fixture(scope="module")
def screens(tmp_path_factory):
    """Run the commands one after the other in one folder: some read what others write."""
    folder = tmp_path_factory.mktemp("screens")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        # Whether a bar is shown depends on how fast the machine is.
        patch.setattr(options, "PATIENCE", math.inf)
        found = {command: shown(command) for command in KNOWN}
    new = folder / SCREENS.name
    new.write_text(yaml.safe_dump(found, allow_unicode=True, sort_keys=False, width=1000))
    print(f"If the screens were meant to change: review {new} and copy it over {SCREENS}.")
    return found


def parts(line):
    """Split a line into its words and its numbers, as they are written."""
    return NUMBER.sub("#", line), [Decimal(text) for text in NUMBER.findall(line)]


def same(number, known):
    """Whether numbers are the same but for rounding: one in the last place that is shown."""
    last = Decimal(1).scaleb(known.as_tuple().exponent)
    return abs(number - known) <= max(last, abs(known) * Decimal("1e-4"), Decimal("1e-5"))


@pytest.mark.parametrize("command", KNOWN)
def test_a_command_says_the_same(screens, command):
    found, known = screens[command], KNOWN[command]
    assert found["exit"] == known["exit"], found["screen"]
    assert len(found["screen"]) == len(known["screen"]), found["screen"]
    for line, expected in zip(found["screen"], known["screen"], strict=True):
        (words, numbers), (its_words, its_numbers) = parts(line), parts(expected)
        assert words == its_words
        assert all(map(same, numbers, its_numbers)), (line, expected)
