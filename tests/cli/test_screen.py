"""Text on a terminal: wrapped between words, with the answer in bold and doubts in colour."""

import os
import pty
import re
import subprocess
import sys

import pytest

from vibrissa.cli.screen import emphasised, wrapped

TEXT = """mu0 = 0.2890 ± 0.006, mean of 31 of 32 periods (left out: 1 open)
measure first: surface_slope (then ± 0.0047), clamp_angle (then ± 0.0053), length (then ± 0.0054)
the model of the rod and the ratio of the forces differ by +0.00041 ± 0.017 in mu0
  modulus larger by 5 ± 0.1 % (explains 100% of the misfit), off by -0.0468 deg and by 1.9 mm
wrong: force_y does not fit a tip that sticks; if slips are slow, state --slip-time"""
TOGETHER = ("mu0 = 0.2890 ± 0.006", "± 0.0047", "+0.00041 ± 0.017", "5 ± 0.1 %", "-0.0468 deg")


@pytest.mark.parametrize("width", [30, 40, 60, 80, 120])
def test_lines_are_as_wide_as_the_terminal_and_numbers_stay_whole(width):
    lines = wrapped(TEXT, width).split("\n")
    assert max(map(len, lines)) <= width
    for number in TOGETHER:
        assert any(number in line for line in lines), number
    assert " ".join(" ".join(lines).split()) == " ".join(TEXT.split())
    # What continues a line is indented below it.
    assert [line for line in lines if not line.startswith("  ")][1].startswith("measure first")


def test_short_lines_and_columns_stay_as_they_are():
    table = "rod          base 0.8 mm\nheight       159.1 mm"
    assert wrapped(table, 80) == table


def test_the_friction_is_bold_and_doubts_have_colours():
    text = emphasised(TEXT + "\ndoubtful: few samples\n1,200 periods in doubt: see\nno wrong: here")
    assert text.startswith("\x1b[1mmu0 = 0.2890 ± 0.006\x1b[0m, mean")
    assert "\x1b[31m\x1b[1mwrong:\x1b[0m force_y" in text
    assert "\x1b[33m\x1b[1mdoubtful:\x1b[0m few" in text and "\nno wrong: here" in text
    assert "\x1b[33m\x1b[1m1,200 periods in doubt\x1b[0m: see" in text
    in_doubt = emphasised("mu0 = 0.27591 ± 0.00036 (in doubt), mean of 31")
    assert in_doubt == "\x1b[1mmu0 = 0.27591 ± 0.00036 (in doubt)\x1b[0m, mean of 31"


@pytest.mark.slow
@pytest.mark.parametrize("plain", [False, True])
def test_a_terminal_gets_colours_unless_they_are_not_wanted(plain):
    program = f"from vibrissa.cli.screen import say; say({TEXT!r})"
    above, below = pty.openpty()
    environment = os.environ | {"COLUMNS": "60", "NO_COLOR": "1" if plain else ""}
    subprocess.run([sys.executable, "-c", program], stdout=below, env=environment, check=True)
    os.close(below)
    text = os.read(above, 9999).decode()
    assert ("\x1b[1m" in text) is not plain
    lines = re.sub(r"\x1b\[\d+m", "", text).split("\r\n")
    assert max(map(len, lines)) <= 60
    piped = subprocess.run([sys.executable, "-c", program], capture_output=True, env=environment)
    assert piped.stdout.decode() == TEXT + "\n"
