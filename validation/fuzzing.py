"""Damaged recordings: each is refused, warned of, or read correctly by `vibrissa identify`.

A recording of a known surface is damaged, read and identified. What must never happen: an exception
other than VibrissaError, a warning of Python's own, or a *silent* wrong number, that is a friction
further than 5 of its stated standard deviations from the truth without a message that names a line
or a column. Exit status 1 if any of it happened. The record is records/fuzz.md, which a run without
arguments writes.
"""

import argparse
import csv
import io
import re
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import cache, partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from typer.testing import CliRunner

from validation.records import write_record
from vibrissa.cli.app import app
from vibrissa.errors import VibrissaError
from vibrissa.mechanics.rod import Rod
from vibrissa.sensor import (
    Method,
    PeriodStatus,
    Whisker,
    identify,
    path,
    preset,
    respond,
    simulate,
    surfaces,
)
from vibrissa.sensor.identification.recording import read_recording
from vibrissa.sensor.response import branch
from vibrissa.sensor.transducer import CHANNELS

CASES = 300
# One case of so many also goes through the command line.
SHARE = 12
# So many kinds of damage are tried at once.
JOBS = 2
# Standard deviations from which on a number is wrong. Of 10^6 right ones less than one is: the
# uniform part of the error cannot come that far.
WRONG = 5.0

ROD = Rod(2.1e11, 1e-3, 0.1)
SENSOR = preset("nano17-si-12-0.12")
SURFACE = surfaces.random(11, 0.3, 0.05, 0.05)
WHISKER = Whisker(theta=2.0, eta=0.85, rod=ROD)
DEVIATION = np.array(SENSOR.deviation) / WHISKER.units.channels
# Step of the stage, where it turns: coarse steps, fine steps, forth and back.
PATHS = (("0.001", ("0.4",)), ("0.00025", ("0.12",)), ("0.001", ("0.25", "0.1")))
NAMES = ("time", "footpoint", *CHANNELS)
IN_SI = ("s", "m", "N", "N", "N*m")

Cells = list[list[str]]


class Case(NamedTuple):
    """A recording to be damaged.

    Attributes
    ----------
    header : list of str
        With the units.
    rows : list of list of str
    method : Method
    rng : numpy.random.Generator
    """

    header: list[str]
    rows: Cells
    method: Method
    rng: np.random.Generator

    def some(self, most: int) -> np.ndarray:
        """Between 1 and so many different rows."""
        return self.rng.choice(len(self.rows), int(self.rng.integers(1, most + 1)), replace=False)

    def block(self, most: int) -> slice:
        """Some rows in succession."""
        size = int(self.rng.integers(2, most + 1))
        start = int(self.rng.integers(0, len(self.rows) - size))
        return slice(start, start + size)

    def column(self) -> int:
        """A column that the method reads."""
        return len(self.header) + int(self.rng.choice([-4, -3, -2, -1]))

    def change(self, row: int, column: int, change: Callable[[float], float]) -> None:
        """Put another number into a cell."""
        self.rows[row][column] = repr(float(change(float(self.rows[row][column]))))


@cache
def measured(which: int) -> np.ndarray:
    """Signals of a known surface in SI units: time, footpoint, forces and moment."""
    step, turns = PATHS[which]
    truth = simulate(WHISKER.pulled, SURFACE, path(step, turns))
    reactions = truth.reactions * WHISKER.units.channels
    readings = SENSOR.measured(reactions, np.random.default_rng([which, 1]))
    time = np.arange(len(readings)) * 0.01
    return np.column_stack([time, truth.clamp * ROD.length, readings])


def as_text(header: list[str], rows: Cells) -> bytes:
    """Write it as CSV."""
    file = io.StringIO()
    csv.writer(file, lineterminator="\n").writerows([header, *rows])
    return file.getvalue().encode()


# --- What must not matter: the same answer. ---

UNITS: dict[str, list[tuple[str, float]]] = {
    "s": [("ms", 1e-3), ("min", 60.0)],
    "m": [("mm", 1e-3), ("um", 1e-6), ("µm", 1e-6), ("inch", 0.0254), ("L", 0.1), ("km", 1e3)],
    "N": [("mN", 1e-3), ("kN", 1e3), ("lbf", 4.4482216152605), ("E*I0/L^2", ROD.force_unit)],
    "N*m": [("N*mm", 1e-3), ("mN*m", 1e-3), ("N m", 1.0), ("E*I0/L", ROD.moment_unit)],
}


def other_units(case: Case) -> bytes:
    """Units changed, values converted"""
    for i, title in enumerate(case.header):
        name, _, unit = title.rstrip("]").partition(" [")
        other, size = UNITS[unit][int(case.rng.integers(len(UNITS[unit])))]
        case.header[i] = f"{name} [{other}]"
        for row in case.rows:
            row[i] = repr(float(row[i]) / size)
    return as_text(case.header, case.rows)


def other_order(case: Case) -> bytes:
    """Columns in another order"""
    order = case.rng.permutation(len(case.header))
    return as_text([case.header[i] for i in order], [[row[i] for i in order] for row in case.rows])


def more_columns(case: Case) -> bytes:
    """Further columns of numbers and words"""
    for i in range(int(case.rng.integers(1, 4))):
        at = int(case.rng.integers(0, len(case.header) + 1))
        case.header.insert(at, f"other {i} [furlong]" if i else "note")
        for n, row in enumerate(case.rows):
            row.insert(at, ("", "ok", 'a "b", c', str(n))[int(case.rng.integers(4))])
    return as_text(case.header, case.rows)


def other_writing(case: Case) -> bytes:
    """CRLF, byte order mark, quotes, spaces, other ways to write a number"""
    if case.rng.random() < 0.5:
        for row in case.rows:
            for i, cell in enumerate(row):
                form = ("{:.12e}", "{:+.12f}", "{:.15g}", " {!r} ", "\t{!r}")
                row[i] = form[int(case.rng.integers(len(form)))].format(float(cell))
    file = io.StringIO()
    quoting = csv.QUOTE_ALL if case.rng.random() < 0.5 else csv.QUOTE_MINIMAL
    ending = "\r\n" if case.rng.random() < 0.5 else "\n"
    header = [f" {title} " if case.rng.random() < 0.3 else title for title in case.header]
    csv.writer(file, lineterminator=ending, quoting=quoting).writerows([header, *case.rows])
    text = file.getvalue()
    if case.rng.random() < 0.3:
        text = text.rstrip("\r\n")
    return text.encode("utf-8-sig" if case.rng.random() < 0.5 else "utf-8")


def blank_lines(case: Case) -> bytes:
    """Blank lines"""
    lines = as_text(case.header, case.rows).decode().splitlines(keepends=True)
    for _ in range(int(case.rng.integers(1, 10))):
        lines.insert(int(case.rng.integers(1, len(lines) + 1)), "\n")
    return "".join(lines).encode()


# --- The file is damaged. ---


def flipped_bytes(case: Case) -> bytes:
    """Bytes flipped"""
    text = bytearray(as_text(case.header, case.rows))
    for _ in range(int(case.rng.integers(1, 6))):
        text[int(case.rng.integers(len(text)))] ^= 1 << int(case.rng.integers(8))
    return bytes(text)


def changed_characters(case: Case) -> bytes:
    """Characters of numbers replaced by others of numbers"""
    text = bytearray(as_text(case.header, case.rows))
    start = text.index(b"\n")
    for _ in range(int(case.rng.integers(1, 4))):
        at = int(case.rng.integers(start, len(text)))
        text[at] = int(case.rng.choice(list(b"0123456789.-e,\n_")))
    return bytes(text)


def lost_bytes(case: Case) -> bytes:
    """Bytes lost or put in"""
    text = bytearray(as_text(case.header, case.rows))
    for _ in range(int(case.rng.integers(1, 4))):
        at = int(case.rng.integers(len(text)))
        if case.rng.random() < 0.5:
            del text[at : at + int(case.rng.integers(1, 8))]
        else:
            text.insert(at, int(case.rng.integers(256)))
    return bytes(text)


def truncated(case: Case) -> bytes:
    """Cut off anywhere"""
    text = as_text(case.header, case.rows)
    return text[: int(case.rng.integers(len(text)))]


def strange_bytes(case: Case) -> bytes:
    """NUL, lone quotes, other line ends, very long lines"""
    text = bytearray(as_text(case.header, case.rows))
    strange = [
        b"\0",
        b'"',
        b"\r",
        b"\x0b",
        b"\x0c",
        b"\x1a",
        b"\xff",
        "\u2028".encode(),
        b"9" * 200,
    ]
    strange += [b"," * 9999, b"7" * 140_000, b'"\n"']
    for _ in range(int(case.rng.integers(1, 3))):
        at = int(case.rng.integers(len(text)))
        text[at:at] = strange[int(case.rng.integers(len(strange)))]
    return bytes(text)


def other_encoding(case: Case) -> bytes:
    """Other encodings"""
    case.header[0] += " ²µ"
    text = as_text(case.header, case.rows).decode()
    encodings = (
        "utf-16",
        "utf-32",
        "utf-16-le",
        "latin-1",
        "cp1252",
        "utf-7",
        "cp037",
        "mac-roman",
    )
    return text.encode(encodings[int(case.rng.integers(len(encodings)))], errors="replace")


def locale(case: Case) -> bytes:
    """Decimal commas, semicolons, tabs, thousands separators"""
    kind = int(case.rng.integers(5))
    text = as_text(case.header, case.rows).decode()
    head, _, body = text.partition("\n")
    if kind == 0:
        text = head + "\n" + body.replace(".", ",")
    elif kind == 1:
        text = (head + "\n").replace(",", ";") + body.replace(",", ";").replace(".", ",")
    elif kind == 2:
        text = text.replace(",", "\t")
    elif kind == 3:
        text = "\n".join([head, *(",".join(f'"{c}"' for c in r) for r in case.rows)])
        text = text.partition("\n")[0] + "\n" + text.partition("\n")[2].replace(".", ",")
    else:
        column = case.column()
        for row in case.rows:
            row[column] = f"{float(row[column]) * 1e6:_.0f}".replace(
                "_", "_" if case.rng.random() < 0.5 else ","
            )
        text = as_text(case.header, case.rows).decode()
    return text.encode()


# --- Its lines are damaged. ---


def lines_lost(case: Case) -> bytes:
    """Lines lost, singly"""
    for row in sorted(case.some(60), reverse=True):
        del case.rows[row]
    return as_text(case.header, case.rows)


def block_lost(case: Case) -> bytes:
    """Lines lost, a block"""
    del case.rows[case.block(150)]
    return as_text(case.header, case.rows)


def lines_twice(case: Case) -> bytes:
    """Lines that stand twice, one after the other"""
    for row in sorted(case.some(60), reverse=True):
        case.rows.insert(row, list(case.rows[row]))
    return as_text(case.header, case.rows)


def block_twice(case: Case) -> bytes:
    """A block of lines that stands twice"""
    block = case.block(100)
    at = block.stop if case.rng.random() < 0.5 else int(case.rng.integers(len(case.rows)))
    case.rows[at:at] = [list(row) for row in case.rows[block]]
    return as_text(case.header, case.rows)


def lines_moved(case: Case) -> bytes:
    """Lines swapped or moved"""
    for _ in range(int(case.rng.integers(1, 6))):
        one, other = (int(i) for i in case.rng.integers(len(case.rows), size=2))
        if case.rng.random() < 0.5:
            other = min(one + 1, len(case.rows) - 1)
        case.rows.insert(other, case.rows.pop(one))
    return as_text(case.header, case.rows)


def block_moved(case: Case) -> bytes:
    """A block of lines moved, turned round or shuffled"""
    block = case.block(100)
    rows, kind = case.rows[block], int(case.rng.integers(3))
    del case.rows[block]
    at = block.start
    if kind == 0:
        at = int(case.rng.integers(len(case.rows)))
    elif kind == 1:
        rows = rows[::-1]
    else:
        case.rng.shuffle(rows)
    case.rows[at:at] = rows
    return as_text(case.header, case.rows)


def whole_order(case: Case) -> bytes:
    """All lines turned round, shuffled or sorted as text"""
    kind = int(case.rng.integers(3))
    if kind == 0:
        case.rows.reverse()
    elif kind == 1:
        case.rng.shuffle(case.rows)
    else:
        case.rows.sort()
    return as_text(case.header, case.rows)


def other_rate(case: Case) -> bytes:
    """Another sampling rate, even or uneven"""
    if case.rng.random() < 0.5:
        rows = case.rows[:: int(case.rng.integers(2, 9))]
    else:
        keep = case.rng.random(len(case.rows)) < case.rng.uniform(0.2, 0.95)
        rows = [row for row, kept in zip(case.rows, keep, strict=True) if kept]
    return as_text(case.header, rows)


def ragged(case: Case) -> bytes:
    """A value too many or too few in a line"""
    for row in case.some(3):
        if case.rng.random() < 0.5:
            del case.rows[row][int(case.rng.integers(len(case.rows[row])))]
        else:
            case.rows[row].append("0")
    return as_text(case.header, case.rows)


# --- Its columns are damaged. ---


def column_lost(case: Case) -> bytes:
    """A column lost"""
    column = case.column()
    rows = [[c for i, c in enumerate(row) if i != column] for row in case.rows]
    return as_text([t for i, t in enumerate(case.header) if i != column], rows)


def title_misspelt(case: Case) -> bytes:
    """A title misspelt, missing or twice"""
    column = case.column()
    title, kind = case.header[column], int(case.rng.integers(5))
    if kind == 0:
        at = int(case.rng.integers(title.index(" ")))
        title = title[:at] + title[at + 1 :]
    elif kind == 1:
        title = title.replace("_", " ").upper()
    elif kind == 2:
        title = ""
    elif kind == 3:
        title = case.header[int(case.rng.integers(len(case.header)))]
    else:
        case.header[:] = case.rows.pop(0)
        return as_text(case.header, case.rows)
    case.header[column] = title
    return as_text(case.header, case.rows)


def unit_misspelt(case: Case) -> bytes:
    """A unit missing, misspelt or of another kind"""
    column = case.column()
    name = case.header[column].partition(" [")[0]
    wrong = ("", " []", " [", " [x]", " [Nm m]", " [kg]", " [1]", " [m/]", " [degC]", " [0*m]")
    wrong += (" [m**m]", " [s]", " [m", " [m N]", " [-m]", " [1e400 m]", " [nan]", " (m)")
    unit = wrong[int(case.rng.integers(len(wrong)))]
    case.header[column] = name + unit
    return as_text(case.header, case.rows)


def unit_wrong(case: Case) -> bytes:
    """A unit changed, its values not"""
    column = case.column()
    name, _, unit = case.header[column].rstrip("]").partition(" [")
    other, size = UNITS[unit][int(case.rng.integers(len(UNITS[unit])))]
    if size != 1.0:
        case.header[column] = f"{name} [{other}]"
    return as_text(case.header, case.rows)


def columns_swapped(case: Case) -> bytes:
    """Two columns swapped, their titles not"""
    one, other = case.rng.choice(len(case.header), 2, replace=False)
    for row in case.rows:
        row[one], row[other] = row[other], row[one]
    return as_text(case.header, case.rows)


def sign_turned(case: Case) -> bytes:
    """The sign of a column turned"""
    column = case.column()
    for i in range(len(case.rows)):
        case.change(i, column, lambda value: -value)
    return as_text(case.header, case.rows)


# --- Its values are damaged. ---


def no_numbers(case: Case) -> bytes:
    """Cells that are no numbers, or infinite"""
    words = (
        "x",
        "inf",
        "-Infinity",
        "1e400",
        "0x1p-3",
        "1,5",
        "1_0",
        "١٢",
        "--",
        "1e",
        "#N/A",
        "?",
    )
    words += ("1.2.3", "+-1", "1 000", "True", "0b1", "−1.2", "1d-3", "5%", "\\N", "9" * 400)
    for row in case.some(3):
        case.rows[row][case.column()] = words[int(case.rng.integers(len(words)))]
    return as_text(case.header, case.rows)


def missing(case: Case) -> bytes:
    """Values missing"""
    column = case.column()
    rows = range(*case.block(40).indices(len(case.rows))) if case.rng.random() < 0.3 else ()
    for row in rows or case.some(60):
        word = ("", "nan", "NaN", "NA", "null", "-", " ")[int(case.rng.integers(7))]
        case.rows[row][column] = word
    return as_text(case.header, case.rows)


def monstrous(case: Case) -> bytes:
    """Values far too large or too small"""
    sizes = (1e308, -1e308, 1e30, -1e15, 1e6, 1e-300, -1e-300, 5e-324, 0.0, -0.0)
    column = case.column()
    for row in case.some(3):
        case.rows[row][column] = repr(sizes[int(case.rng.integers(len(sizes)))])
    return as_text(case.header, case.rows)


def slips_of_the_pen(case: Case) -> bytes:
    """points, signs and digits lost in single cells"""
    for row in case.some(3):
        column = case.column()
        cell = case.rows[row][column]
        kind = int(case.rng.integers(4))
        if kind == 0:
            cell = cell.replace(".", "")
        elif kind == 1:
            cell = cell.lstrip("-") if cell.startswith("-") else "-" + cell
        elif kind == 2:
            at = int(case.rng.integers(len(cell)))
            cell = cell[:at] + cell[at + 1 :]
        else:
            other = (column + 1) % len(case.header)
            case.rows[row][other], cell = cell, case.rows[row][other]
        case.rows[row][column] = cell
    return as_text(case.header, case.rows)


def spikes(case: Case) -> bytes:
    """Spikes of one to three samples"""
    size = float(10 ** case.rng.uniform(-3, 1)) * (-1.0) ** int(case.rng.integers(2))
    column = case.column()
    scale = max(abs(float(row[column])) for row in case.rows)
    for row in case.some(5):
        for i in range(row, min(row + int(case.rng.integers(1, 4)), len(case.rows))):
            case.change(i, column, lambda value: value + size * scale)
    return as_text(case.header, case.rows)


def saturated(case: Case) -> bytes:
    """Readings that do not pass a limit"""
    column = len(case.header) - int(case.rng.integers(1, 4))
    values = np.array([float(row[column]) for row in case.rows])
    limit = np.quantile(np.abs(values), case.rng.uniform(0.5, 0.995))
    for i in range(len(case.rows)):
        case.change(i, column, lambda value: float(np.clip(value, -limit, limit)))
    return as_text(case.header, case.rows)


def stuck(case: Case) -> bytes:
    """Columns that stand still for a while"""
    width = len(case.header)
    groups = ([width - 3, width - 2, width - 1], [width - 4], [case.column()])
    block = case.block(60)
    for column in groups[int(case.rng.integers(3))]:
        for row in case.rows[block]:
            row[column] = case.rows[block.start][column]
    return as_text(case.header, case.rows)


def shifted(case: Case) -> bytes:
    """A column that jumps for good, or for a while"""
    column = case.column()
    scale = max(abs(float(row[column])) for row in case.rows)
    size = float(10 ** case.rng.uniform(-2.5, 0.5)) * (-1.0) ** int(case.rng.integers(2)) * scale
    start = int(case.rng.integers(1, len(case.rows)))
    stop = len(case.rows) if case.rng.random() < 0.5 else start + int(case.rng.integers(2, 60))
    for i in range(start, min(stop, len(case.rows))):
        case.change(i, column, lambda value: value + size)
    return as_text(case.header, case.rows)


def late(case: Case) -> bytes:
    """One channel that lags behind by some samples"""
    column, lag = case.column(), int(case.rng.integers(1, 6))
    values = [row[column] for row in case.rows]
    for row, value in zip(case.rows[lag:], values, strict=False):
        row[column] = value
    return as_text(case.header, case.rows)


def time_damaged(case: Case) -> bytes:
    """Time repeated, backward, missing or in another unit"""
    case.header.insert(0, "time [s]")
    kind = int(case.rng.integers(4))
    for i, row in enumerate(case.rows):
        row.insert(0, repr(i * 0.01))
    for row in case.some(4):
        case.rows[row][0] = ("0", "-1", "nan", "x")[kind]
    return as_text(case.header, case.rows)


SAME = (other_units, other_order, more_columns, other_writing, blank_lines)
DAMAGE: tuple[Callable[[Case], bytes], ...] = (
    *SAME,
    flipped_bytes,
    changed_characters,
    lost_bytes,
    truncated,
    strange_bytes,
    other_encoding,
    locale,
    lines_lost,
    block_lost,
    lines_twice,
    block_twice,
    lines_moved,
    block_moved,
    whole_order,
    other_rate,
    ragged,
    column_lost,
    title_misspelt,
    unit_misspelt,
    unit_wrong,
    columns_swapped,
    sign_turned,
    no_numbers,
    missing,
    monstrous,
    slips_of_the_pen,
    spikes,
    saturated,
    stuck,
    shifted,
    late,
    time_damaged,
)


class Verdict(NamedTuple):
    """What came of a case: one of OUTCOMES, and what it said."""

    outcome: str
    said: str


SILENT, BROKEN = "silently wrong", "broken"
OUTCOMES = ("the same", "right", "warned, right", "warned, wrong", "refused", SILENT, BROKEN)
NAMES_A_PLACE = re.compile(r"line \d+|column|usable rows|no rows|[a-z]+_?[a-z]* (must|needs)|UTF-8")


def drawn(damage: Callable[[Case], bytes], number: int) -> tuple[Case, bytes, bool]:
    """Draw the recording and its damage of one case: the case, the file, whether it has a time."""
    kind = DAMAGE.index(damage) if damage in DAMAGE else len(DAMAGE)
    rng = np.random.default_rng([kind, number])
    which, method = number % len(PATHS), Method.MODEL
    timed = bool(rng.random() < 0.3) and damage is not time_damaged
    values = measured(which)[:, 0 if timed else 1 :]
    header = [f"{name} [{unit}]" for name, unit in zip(NAMES, IN_SI, strict=True)]
    case = Case(
        header if timed else header[1:],
        [[repr(v) for v in row] for row in values.tolist()],
        method,
        rng,
    )
    return case, damage(case), timed


def noise_given(number: int) -> np.ndarray | None:
    """Noise of the readings, which every fifth case leaves to be estimated."""
    return DEVIATION if number % 5 else None


@cache
def undamaged(which: int, method: Method, given: bool) -> np.ndarray:
    """Friction that the recording gives before it is damaged."""
    header = [f"{name} [{unit}]" for name, unit in zip(NAMES, IN_SI, strict=True)]
    text = as_text(header, [[repr(v) for v in row] for row in measured(which).tolist()])
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "recording.csv"
        file.write_bytes(text)
        recording = read_recording(file, WHISKER.units, method, SENSOR)
    noise = DEVIATION if given else None
    asked = {"method": method, "assume": False}
    return identify(WHISKER, recording, noise=noise, **asked).periods.mu0


def judged(
    status: list[str], contact: np.ndarray, mu0: np.ndarray, deviation: np.ndarray
) -> tuple[bool, str]:
    """Whether all friction is right, and where it is furthest from the truth."""
    slip = np.array([text == PeriodStatus.SLIP for text in status], dtype=bool)
    if not slip.any():
        return True, ""
    if not np.isfinite([contact[slip], mu0[slip], deviation[slip]]).all():
        return False, "not finite"
    # A contact that is wrong makes the number wrong where the map shows it.
    off = np.abs(mu0[slip] - SURFACE(contact[slip])) / np.maximum(deviation[slip], 1e-12)
    worst = int(np.argmax(off))
    where = f"{off[worst]:.1f} deviations at x = {contact[slip][worst]:.4f}"
    return bool(off[worst] <= WRONG), where


def tried(damage: Callable[[Case], bytes], number: int, file: Path) -> Verdict:
    """Damage a recording, identify it and judge what comes out."""
    case, text, _ = drawn(damage, number)
    file.write_bytes(text)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            recording = read_recording(file, WHISKER.units, case.method, SENSOR)
            asked = {"noise": noise_given(number), "method": case.method}
            found = identify(WHISKER, recording, **asked, assume=False).periods
    except VibrissaError as error:
        said = str(error).replace(str(file), file.name)
        if "\n" in said or not NAMES_A_PLACE.search(said):
            return Verdict(BROKEN, f"says: {said!r}")
        return Verdict(BROKEN if damage in SAME else "refused", said)
    except Exception as error:
        return Verdict(BROKEN, f"{type(error).__name__}: {error}")
    right, where = judged(found.status, found.contact, found.mu0, found.deviation)
    whole = undamaged(number % len(PATHS), case.method, noise_given(number) is not None)
    same = len(whole) == len(found.mu0) and np.allclose(
        found.mu0, whole, rtol=1e-6, atol=1e-9, equal_nan=True
    )
    if same and not found.notes:
        return Verdict("the same", "")
    if damage in SAME:
        return Verdict(BROKEN, f"not the same: {where} {found.notes}")
    if found.notes:
        return Verdict("warned, right" if right else "warned, wrong", "; ".join(found.notes))
    return Verdict("right" if right else SILENT, where)


def on_the_command_line(damage: Callable[[Case], bytes], number: int, folder: Path) -> Verdict:
    """Do the same with the command `vibrissa identify`, and judge what it writes."""
    case, text, _ = drawn(damage, number)
    file, out = folder / "recording.csv", folder / "friction.csv"
    file.write_bytes(text)
    out.unlink(missing_ok=True)
    rod = ["--modulus", "210 GPa", "--diameter", "1 mm", "--length", "100 mm"]
    known = ["--theta", "2", "--eta", "0.85", "--transducer", "nano17-si-12-0.12"]
    asked = ["--method", case.method.value, "-o", str(out)]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = CliRunner().invoke(app, ["identify", str(file), *rod, *known, *asked])
    said = result.output.replace(str(folder) + "/", "").strip()
    if result.exit_code == 2:
        if (
            not said.startswith("vibrissa: ")
            or "\n" in said
            or not NAMES_A_PLACE.search(said)
            or out.exists()
        ):
            return Verdict(BROKEN, said)
        return Verdict("refused", said)
    if result.exit_code != 0 or (result.exception and not isinstance(result.exception, SystemExit)):
        return Verdict(BROKEN, f"exit status {result.exit_code}: {result.exception!r}")
    with out.open(encoding="utf-8") as table:
        rows = list(csv.DictReader(table))
    columns = [
        np.array([float(row[name]) for row in rows])
        for name in ("contact [m]", "mu0 [1]", "deviation [1]")
    ]
    right, where = judged([row["status"] for row in rows], columns[0] / ROD.length, *columns[1:])
    if "line" in result.stderr:
        return Verdict("warned, right" if right else "warned, wrong", said)
    return Verdict("right" if right else SILENT, where)


class Tried(NamedTuple):
    """What came out of all cases of one kind of damage."""

    row: str
    bad: list[str]
    lines: int


def tried_all(damage: Callable[[Case], bytes], begin: int, cases: int) -> Tried:
    """Try all cases of one kind of damage."""
    # The rod is solved once.
    branch.respond = cache(respond)
    bad: list[str] = []
    lines, count = 0, Counter[str]()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for number in range(begin, begin + cases):
            verdicts = [tried(damage, number, folder / "recording.csv")]
            count[verdicts[0].outcome] += 1
            if number % SHARE == 0:
                lines += 1
                verdicts.append(on_the_command_line(damage, number, folder))
            bad += [
                f"{damage.__name__} {number}: {v.outcome}: {v.said}"
                for v in verdicts
                if v.outcome in (SILENT, BROKEN)
            ]
    row = f"| {damage.__doc__} | " + " | ".join(str(count[o]) for o in OUTCOMES) + " |"
    return Tried(row=row, bad=bad, lines=lines)


def main() -> int:
    """Try all, tell what was wrong, write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="?", type=int, default=CASES, help="of each kind of damage")
    parser.add_argument("begin", nargs="?", type=int, default=0, help="number of the first case")
    parser.add_argument("--jobs", type=int, default=JOBS, help="kinds of damage tried at once")
    asked = parser.parse_args()
    found = []
    with ProcessPoolExecutor(asked.jobs) as pool:
        for one in pool.map(partial(tried_all, begin=asked.begin, cases=asked.cases), DAMAGE):
            print(one.row, flush=True)
            found.append(one)
    bad = [text for one in found for text in one.bad]
    for text in bad:
        print(text)
    if (asked.cases, asked.begin) == (CASES, 0):
        total, lines = asked.cases * len(found), sum(one.lines for one in found)
        table = [
            f"{total} recordings, {lines} of them on the command line, too.\n",
            f"| damage | {' | '.join(OUTCOMES)} |",
            "| --- |" + " ---: |" * len(OUTCOMES),
            *(one.row for one in found),
        ]
        write_record("fuzz", __doc__, "\n".join(table))
    return 1 if bad else 0
