"""The table in a text file: its separator, its titles, its row of units and its rows of numbers.

Every separator is tried. The rows of numbers are the longest stretch of lines with one number of
cells, half of them numbers at least; the titles are the line above with as many cells. Of a wrong
separator, cells are left that are no numbers. Python's own csv.Sniffer looks at the frequency of
letters alone, and reads a decimal comma as a separator. A line that begins with a sign of comment
is none of the rows, but may hold titles or units.
"""

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from itertools import groupby

import numpy as np

from vibrissa.errors import RecordingError
from vibrissa.numerics.arrays import IntArray
from vibrissa.sensor.importing.notation import like_a_number
from vibrissa.sensor.importing.units import is_unit
from vibrissa.wording import counted


class Separator(StrEnum):
    """What stands between the cells of a line."""

    SEMICOLON = "semicolon"
    TAB = "tab"
    COMMA = "comma"
    BAR = "bar"
    BLANK = "blank"


SIGNS = {
    Separator.SEMICOLON: ";",
    Separator.TAB: "\t",
    Separator.COMMA: ",",
    Separator.BAR: "|",
}
LINE_END = re.compile("\r\n|\n|\r")
# Titles between blanks: a unit in brackets belongs to the word before.
TITLE = re.compile(r"[^\s\[(]+(?:\s*[\[(][^\])]*[\])])?")
# Before a comment (not a missing value), which may hold titles or units.
COMMENT = re.compile(r"\s*(?!#n/a|#nv)(?:[#%]+|//+)", re.I)
# Why lines are left out.
BETWEEN = "words between the titles and the rows"
COMMENTS = "comments"
FOOTER = "no numbers below the table"
# About so many rows tell how well a separator fits.
SAMPLE = 1000
# Fewer rows are no recording, fewer columns no table.
FEWEST_ROWS, FEWEST_COLUMNS = 3, 2

Cells = list[str]


@dataclass(frozen=True, eq=False, kw_only=True)
class Layout:
    """A table of text.

    Attributes
    ----------
    separator : Separator
    titles : tuple of str
        Of the columns; empty if there are none.
    units : tuple of str
        Of the row of units below the titles; empty if there is none.
    title_line, unit_line : int
        Line of the titles and of the units, from 1; 0 if there are none.
    rows : list of list of str
        Cells of the rows of numbers, all of one length.
    line : ndarray of int
        Line of each row.
    left_out : dict of str to tuple of int
        Lines that are left out from the titles on, by the reason.
    mistake : str
        Why it is no table after all; empty if it is.
    """

    separator: Separator
    titles: tuple[str, ...]
    units: tuple[str, ...]
    title_line: int
    unit_line: int
    rows: list[Cells]
    line: IntArray
    left_out: dict[str, tuple[int, ...]]
    mistake: str

    @cached_property
    def rank(self) -> tuple[float, bool, bool]:
        """How well this separator fits: the part of cells with numbers, titles, no mistake."""
        some = self.rows[:: len(self.rows) // SAMPLE + 1]
        share = float(np.mean([like_a_number(cell) for row in some for cell in row]))
        return share, bool(self.titles), not self.mistake


def layout_of(
    text: str, name: str, separator: Separator | None = None, title_line: int | None = None
) -> Layout:
    """Find the table in a text.

    Parameters
    ----------
    text : str
    name : str
        Of the file, for messages.
    separator : Separator, optional
        Found by default.
    title_line : int, optional
        Line of the titles, from 1; 0 if there are none. Found by default.

    Raises
    ------
    RecordingError
        If there is no table, or two separators make different ones; the message says why.
    """
    lines = LINE_END.split(text)
    if title_line is not None and not 0 <= title_line <= len(lines):
        raise RecordingError(f"{name}: there is no line {title_line} for the titles")
    tried = list(Separator) if separator is None else [separator]
    found = [_of(lines, each, title_line) for each in tried]
    layouts = sorted((one for one in found if one is not None), key=lambda one: one.rank)
    if layouts:
        return _best(layouts, name)
    raise RecordingError(
        f"{name}: no table with at least {FEWEST_COLUMNS} columns and {FEWEST_ROWS} rows of "
        "numbers was found; if there is one, give the separator"
    )


def _best(layouts: Sequence[Layout], name: str) -> Layout:
    best = layouts[-1]
    if best.mistake:
        raise RecordingError(f"{name}, {best.mistake}")
    equals = [one.separator for one in layouts if one.rank == best.rank]
    if len(equals) > 1:
        raise RecordingError(f"{name}: the separator may be {' or '.join(equals)}: give it")
    return best


def _of(lines: Sequence[str], separator: Separator, title_line: int | None) -> Layout | None:
    """Find the table that a separator makes; None if it makes none."""
    cells = [[] if COMMENT.match(line) else _cells(line, separator) for line in lines]
    blocks = _blocks(cells, title_line or 0)
    if not blocks:
        return None
    block = max(blocks, key=len)
    heads = _heads(lines, cells, block[0], separator, (title_line or 1) - 1)
    titles_at = _titles_at(heads) if title_line is None else title_line - 1
    if titles_at is None or titles_at < 0:
        titles_at, titles, below = None, [], {}
    else:
        titles = _titles(lines[titles_at], separator, len(cells[block[0]]))
        below = {row: head for row, head in heads.items() if row > titles_at}
    units_at = _units_at(below)
    between = [row for row in sorted(below) if below[row].plain and row != units_at]
    width = max(_width(cells, block), len(titles))
    from_titles = range(block[0] if titles_at is None else titles_at + 1, len(lines))
    comments = [row for row in from_titles if COMMENT.match(lines[row]) and row != units_at]
    footer = [row for row in range(block[-1] + 1, len(lines)) if any(cells[row])]
    left_out = {BETWEEN: between, COMMENTS: comments, FOOTER: footer}
    return Layout(
        separator=separator,
        titles=tuple(titles),
        units=() if units_at is None else tuple(_padded(below[units_at].cells, width)),
        title_line=_number(titles_at),
        unit_line=_number(units_at),
        rows=[cells[row][:width] for row in block],
        line=np.array(block) + 1,
        left_out={why: tuple(map(_number, rows)) for why, rows in left_out.items() if rows},
        mistake=_heads_mistake(cells, titles_at, between)
        or _mistake(cells, blocks, width, titles_at, len(titles)),
    )


def _number(row: int | None) -> int:
    """Line of a row, from 1; 0 if there is none."""
    return 0 if row is None else row + 1


def _cells(line: str, separator: Separator) -> Cells:
    """Cells of a line; of one with lone quotes it is one."""
    if separator is Separator.BLANK:
        return re.findall("[^ ]+", line)
    if '"' not in line:
        return [cell.strip() for cell in line.split(SIGNS[separator])] if line else []
    try:
        rows = list(csv.reader([line], delimiter=SIGNS[separator], strict=True))
    except csv.Error:
        return [line]
    return [cell.strip() for cell in rows[0]] if rows else []


def _blocks(cells: Sequence[Cells], start: int) -> list[list[int]]:
    """Stretches of rows with one number of cells, half of them numbers; blank lines are none."""
    rows = (row for row in range(start, len(cells)) if any(cells[row]))
    groups = groupby(rows, key=lambda row: len(cells[row]) if _has_numbers(cells[row]) else 0)
    blocks = [list(group) for width, group in groups if width >= FEWEST_COLUMNS]
    return [block for block in blocks if len(block) >= FEWEST_ROWS]


def _has_numbers(cells: Cells) -> bool:
    return 2 * sum(map(like_a_number, cells)) >= sum(map(bool, cells))


def _width(cells: Sequence[Cells], block: Sequence[int]) -> int:
    """Count the columns without those that a separator at the end of each line makes."""
    return max(_filled(cells[row]) for row in block)


def _filled(cells: Cells) -> int:
    return max((i for i, cell in enumerate(cells, 1) if cell), default=0)


def _padded(cells: Cells, width: int) -> Cells:
    return [*cells, *[""] * width][:width]


def _heads(
    lines: Sequence[str], cells: Sequence[Cells], first: int, separator: Separator, top: int
) -> dict[int, "_Head"]:
    """Lines from the top to the first row of numbers, upwards, without those that are blank."""
    columns = len(cells[first])
    return {
        row: _Head(cells=_titles(lines[row], separator, columns), plain=any(cells[row]))
        for row in range(first - 1, top - 1, -1)
        if any(cells[row]) or COMMENT.match(lines[row])
    }


@dataclass(frozen=True, kw_only=True)
class _Head:
    """A line above the rows of numbers.

    Attributes
    ----------
    cells : list of str
        As many as there are columns; none if the line has another number.
    plain : bool
        Whether it is no comment.
    """

    cells: Cells
    plain: bool

    @property
    def is_words(self) -> bool:
        """Whether these may be titles or units."""
        return self.is_units or (bool(self.cells) and not any(map(like_a_number, self.cells)))

    @property
    def is_units(self) -> bool:
        """Whether these are units alone, some of which, such as -, may look like missing values."""
        return all(map(is_unit, self.cells)) and not all(map(like_a_number, self.cells))


def _titles_at(heads: Mapping[int, _Head]) -> int | None:
    """Find the line of titles, the nearest line above the rows or its units first."""
    plain = [row for row, head in heads.items() if head.plain]
    # Titles are in a comment only if they are nowhere else.
    nearest = plain if plain and heads[plain[0]].is_words else list(heads)
    words = [row for row in nearest if heads[row].plain or heads[row].is_words][:2]
    if not words or not heads[words[0]].is_words:
        return None
    named = len(words) == 2 and heads[words[1]].is_words and heads[words[0]].is_units
    return words[1] if named else words[0]


def _units_at(heads: Mapping[int, _Head]) -> int | None:
    """Find the line of units between the titles and the rows; some may be none that are known."""
    units = [row for row, head in heads.items() if head.is_units]
    some = [row for row, head in heads.items() if head.plain and _has_units(head)]
    return next(iter([*units, *some]), None)


def _has_units(head: _Head) -> bool:
    return head.is_words and any(is_unit(cell) for cell in head.cells if cell)


def _titles(line: str, separator: Separator, width: int) -> Cells:
    """Titles in a line, as many as there are columns; none if the line has another number."""
    line = COMMENT.sub("", line, count=1)
    choices = [_cells(line, separator)]
    if separator is Separator.BLANK:
        choices = [re.split(r"\s{2,}", line.strip()), TITLE.findall(line)]
    for titles in choices:
        if len(titles) == width or _filled(titles) == width:
            return titles[:width]
        if len(titles) == width - 1 and separator is not Separator.BLANK:
            # The rows end with a separator, the titles do not.
            return titles
    return []


def _heads_mistake(cells: Sequence[Cells], titles_at: int | None, between: Sequence[int]) -> str:
    """Say which line has numbers where titles and units are; empty if none has."""
    if titles_at is not None and _has_numbers(cells[titles_at]) and cells[titles_at]:
        return f"line {titles_at + 1}: these are numbers, not titles; without titles give 0"
    row = next((row for row in between if any(map(like_a_number, cells[row]))), None)
    if row is None:
        return ""
    return (
        f"line {row + 1}: numbers stand between the titles and the rows, which begin below: "
        "correct the line, or begin it with # to leave it out"
    )


def _mistake(
    cells: Sequence[Cells],
    blocks: Sequence[Sequence[int]],
    width: int,
    titles_at: int | None,
    titles: int,
) -> str:
    """Say which line does not fit a table; empty if all do."""
    block = max(blocks, key=len)
    same = [one for one in blocks if len(cells[one[0]]) == len(cells[block[0]])]
    lost: int | None
    if len(same) > 1:
        lost = next(row for row in range(same[0][-1] + 1, len(cells)) if any(cells[row]))
        if not any(map(like_a_number, cells[lost])):
            return (
                f"line {lost + 1}: the table ends, but one more begins: give the line of titles, "
                "or begin such a line with #"
            )
    else:
        rest = range(block[-1] + 1, len(cells))
        lost = next((row for row in rest if any(map(like_a_number, cells[row]))), None)
    if lost is not None:
        return f"line {lost + 1}: {counted(len(cells[lost]), 'value')}, but the table has {width}"
    above = titles_at
    if titles_at is None:
        above = next((row for row in range(block[0] - 1, -1, -1) if any(cells[row])), None)
        titles = 0 if above is None else len(cells[above])
    if above is None or titles == width or (titles_at is None and titles < FEWEST_COLUMNS):
        return ""
    return f"line {above + 1}: {counted(titles, 'title')}, but there are {width} columns"
