"""Numbers as laboratories write them: which sign is the decimal one, and which groups thousands.

Every notation in which all cells are numbers is possible. If two possible ones give other values,
such as 1.234 and 1234 for ``1,234``, it is refused: nobody can know from the file.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import isfinite
from typing import NamedTuple

import numpy as np

from vibrissa.errors import RecordingError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.series import MISSING

# A cell without a value, besides those of our own files.
NO_VALUE = {*MISSING, "#nv", "#n/a", "n/a", "-nan", "1.#qnan", "-1.#ind", "nan(ind)"}
# What may be a number in one notation or another.
BLANKS = "'’\u00a0\u202f "
LIKE_A_NUMBER = re.compile(
    rf"[-+−]?(?:\d{{1,3}}(?:[{BLANKS}]\d{{3}})+[\d.,]*|[.,]?\d[\d.,]*)(?<!,)(?:e[-+]?\d+)?",
    re.ASCII | re.I,
)
CLOCK = re.compile(r"\d{1,2}:\d{2}(?::\d{2})?(?:[.,]\d*)?", re.ASCII)


@dataclass(frozen=True, kw_only=True)
class Notation:
    """A way to write numbers.

    Attributes
    ----------
    decimal : str
        Before the decimals.
    thousands : str
        Signs any of which may stand between groups of three digits; empty for none.
    """

    decimal: str
    thousands: str

    @cached_property
    def _number(self) -> re.Pattern[str]:
        point = re.escape(self.decimal)
        whole = r"\d+"
        if self.thousands:
            whole = rf"(?:[1-9]\d{{0,2}}(?:[{re.escape(self.thousands)}]\d{{3}})+|\d+)"
        return re.compile(
            rf"[-+]?(?:{whole}(?:{point}\d*)?|{point}\d+)(?:e[-+]?\d{{1,3}})?", re.ASCII | re.I
        )

    def value(self, cell: str) -> float | None:
        """Value of a cell: NaN where it is missing, None where it is no number."""
        text = cell.strip().replace("−", "-")
        if text.lower() in NO_VALUE:
            return float("nan")
        if self._number.fullmatch(text) is None:
            return None
        for mark in self.thousands:
            text = text.replace(mark, "")
        number = float(text.replace(self.decimal, "."))
        return number if isfinite(number) else None

    @property
    def spelled(self) -> str:
        """Say what it is."""
        return {".": "decimal point", ",": "decimal comma"}[self.decimal]


NOTATIONS = (
    Notation(decimal=".", thousands=""),
    Notation(decimal=",", thousands=""),
    Notation(decimal=".", thousands="," + BLANKS),
    Notation(decimal=",", thousands="." + BLANKS),
)


def like_a_number(cell: str) -> bool:
    """Whether a cell may be a number in one notation or another, or says that it is missing."""
    text = cell.strip()
    return LIKE_A_NUMBER.fullmatch(text) is not None or (text.lower() in NO_VALUE and text != "")


class Numbers(NamedTuple):
    """Columns of numbers and how they were written."""

    notation: Notation
    columns: dict[str, FloatArray]


def numbers_of(
    columns: Mapping[str, Sequence[str]], place: Sequence[str], decimal: str | None = None
) -> Numbers:
    """Read columns of numbers.

    Parameters
    ----------
    columns : mapping of str to sequence of str
        Cells by the title of the column.
    place : sequence of str
        Name of each row, for messages.
    decimal : str, optional
        The decimal sign; found by default.

    Returns
    -------
    Numbers
        NaN where a value is missing.

    Raises
    ------
    RecordingError
        If a cell is no number, or two notations give other numbers; the message names it.
    """
    choices = [each for each in NOTATIONS if decimal in (None, each.decimal)]
    possible = [
        Numbers(notation, read)
        for notation in choices
        if (read := _read(columns, notation)) is not None
    ]
    if not possible:
        raise RecordingError(_no_number(choices, columns, place))
    first, *others = possible
    for other in others:
        for title, values in first.columns.items():
            differ = np.flatnonzero((values != other.columns[title]) & ~np.isnan(values))
            if len(differ):
                row = int(differ[0])
                said = " or ".join(
                    f"{float(one.columns[title][row])!r} (--decimal '{one.notation.decimal}')"
                    for one in (first, other)
                )
                raise RecordingError(
                    f"{place[row]}: {title} = {columns[title][row].strip()!r} may be {said}, and "
                    "no other number tells: give the decimal sign"
                )
    return first


def _read(columns: Mapping[str, Sequence[str]], notation: Notation) -> dict[str, FloatArray] | None:
    """Read columns in a notation; None if a cell is no number."""
    read = {}
    for title, cells in columns.items():
        values = np.empty(len(cells))
        for row, cell in enumerate(cells):
            value = notation.value(cell)
            if value is None:
                return None
            values[row] = value
        read[title] = values
    return read


def _no_number(
    choices: Iterable[Notation], columns: Mapping[str, Sequence[str]], place: Sequence[str]
) -> str:
    """Name the first cell that is no number at all, or in the notation that goes furthest."""
    for row, where in enumerate(place):
        for title, cells in columns.items():
            if all(notation.value(cells[row]) is None for notation in NOTATIONS):
                cell = cells[row].strip()
                hint = "leave the cell empty where a value is missing"
                if CLOCK.fullmatch(cell):
                    hint = "clock times are not read: give --rate instead of the column"
                return f"{where}: {title} must be a number, got {cell!r}: {hint}"
    found = [(_first_misfit(columns, each), each) for each in choices]
    (row, title), notation = max(found, key=lambda one: one[0][0])
    cell = columns[title][row].strip()
    return f"{place[row]}: {title} must be a number with a {notation.spelled}, got {cell!r}"


def _first_misfit(columns: Mapping[str, Sequence[str]], notation: Notation) -> tuple[int, str]:
    """Give the first row, and its title, with a cell that is no number in a notation."""
    return min(
        (row, title)
        for title, cells in columns.items()
        for row, cell in enumerate(cells)
        if notation.value(cell) is None
    )
