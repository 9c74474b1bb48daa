"""From the bytes of a text file to the cells of its table: encoding, lines, separator, rows."""

import codecs
import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibrissa.errors import RecordingError
from vibrissa.numerics.arrays import IntArray
from vibrissa.quantities.series import lines_of, listed
from vibrissa.sensor.identification.recording import left_out
from vibrissa.sensor.importing.numbers import (
    ERRORS,
    is_empty,
    share_of_numbers,
    without_value,
)
from vibrissa.wording import counted

if TYPE_CHECKING:
    from pandas import DataFrame, Series

# Separators, in the order of preference at equal shares of numbers.
SEPARATORS = {"semicolon": ";", "tab": "\t", "comma": ",", "bar": "|", "blank": " "}
MARK = r"\s*([#%]|//)+\s*"
COMMENT = re.compile(MARK)
# A first cell that begins with the mark of a comment but is a missing value, as #N/A or ####.
NO_COMMENT = rf"\s*(?:(?i:{ERRORS})\s*(?:[;\t,| ]|$)|#{{3,}}\s*[;\t,|])"
# Number of lines in which the first row of the table is sought.
SAMPLE = 1000
# Least numbers of rows and of columns of a table.
FEWEST_ROWS = 3
FEWEST_COLUMNS = 2
# Least share of numbers in a row of a table.
LEAST_SHARE = 0.5
# Bytes in which the encoding is sought.
BEGIN = 4096

# Cells of rows by their line number.
Rows = Mapping[int, Sequence[str]]


@dataclass(frozen=True, eq=False, kw_only=True)
class Grid:
    """Cells of a table, and the lines above it.

    Attributes
    ----------
    above : mapping of int to sequence of str
        Cells of each line above the table.
    cells : DataFrame
        Cells of the table as texts; the index has the line of each row. Rows without any value are
        left out.
    samples : ndarray of int
        Number of the sample in each row, from 0; rows without any value count.
    what : str
        What the file was found to be, as in ``separator tab``.
    notes : tuple of str
        Lines that are left out.
    """

    above: Rows
    cells: "DataFrame"
    samples: IntArray
    what: str
    notes: tuple[str, ...]


class Block(NamedTuple):
    """Successive rows of numbers with equal numbers of cells: first line, and cells by column."""

    first: int
    columns: tuple[tuple[str, ...], ...]

    @property
    def share(self) -> float:
        """Share of numbers among all cells."""
        return share_of_numbers(cell for column in self.columns for cell in column)


def decoded(data: bytes, name: str) -> str:
    """Decode a text file: UTF-8, UTF-16, or else Windows-1252.

    NUL bytes at the end are left out: a recorder that was switched off leaves them behind.

    Raises
    ------
    RecordingError
        If the file is no text file.
    """
    text = _decoded(data).rstrip("\0")
    if "\0" in text:
        raise RecordingError(f"{name}: not a text file: save the table as text (CSV)")
    return text.replace("−", "-")


def _decoded(data: bytes) -> str:
    utf16 = _utf16(data)
    if utf16:
        return data[: len(data) // 2 * 2].decode(utf16, errors="replace").removeprefix("\ufeff")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")


def _utf16(data: bytes) -> str:
    """Name of the encoding UTF-16, with a byte order mark or without; empty if it is another."""
    begin = data.rstrip(b"\0")[:BEGIN]
    for mark, encoding, other in (
        (codecs.BOM_UTF16_LE, "utf-16-le", 1),
        (codecs.BOM_UTF16_BE, "utf-16-be", 0),
    ):
        high, low = begin[other::2], begin[1 - other :: 2]
        # Of each character of a western text one byte is NUL, the other is not.
        if begin.startswith(mark) or high.count(0) > 0.8 * len(high) > 0.0 == low.count(0):
            return encoding
    return ""


def grid_of_text(text: str, name: str) -> Grid:
    """Find the table in a text, and split it into cells.

    Raises
    ------
    RecordingError
        If there is no table, or its rows have different numbers of cells.
    """
    # A line of tabs may be a row of empty cells.
    lines = lines_of(text, " ")
    marked = lines.str.match(MARK)
    marked[marked] = ~lines[marked].str.match(NO_COMMENT)
    sample = lines[~marked].head(SAMPLE)
    tables = {separator: first_block(_rows(sample, separator)) for separator in SEPARATORS}
    blocks = {separator: table for separator, table in tables.items() if table is not None}
    if not blocks:
        raise RecordingError(no_table(name))
    separator = max(blocks, key=lambda separator: blocks[separator].share)
    first = blocks[separator].first
    width = len(blocks[separator].columns)
    lines, sign = _separated(lines, separator)
    under = lines.loc[first:]
    rows = under[~marked[under.index]]
    end = len(rows)
    while not share_of_numbers(cells_of(rows.iloc[end - 1], sign)):
        end -= 1
    table, remarks = _split(rows.iloc[:end], sign, width, name)
    empty = without_value(table)
    cells = table[~empty] if empty.any() else table
    return Grid(
        above={
            line: cells_of(line_text, sign) for line, line_text in lines.loc[: first - 1].items()
        },
        cells=cells,
        samples=table.index.get_indexer(cells.index),
        what=f"separator {separator}",
        notes=(
            *left_out(under.index.difference(rows.index), "comments"),
            *left_out(rows.index[end:], "no numbers below the table"),
            *left_out(table.index[empty], "no value"),
            *remarks,
        ),
    )


def grid_of_rows(rows: Rows, what: str) -> Grid | None:
    """Find the table in rows of equal numbers of cells, as a sheet has; None without a table."""
    import pandas as pd

    sample = {line: rows[line] for line in list(rows)[:SAMPLE]}
    block = first_block(sample)
    if block is None:
        return None
    lines = [line for line in rows if line >= block.first]
    while not share_of_numbers(rows[lines[-1]]):
        lines.pop()
    table = pd.DataFrame([rows[line] for line in lines], index=lines, dtype=str)
    empty = without_value(table)
    below = table.index[-1] + 1
    return Grid(
        above={line: cells for line, cells in rows.items() if line < block.first},
        cells=table[~empty],
        samples=table.index[~empty].to_numpy() - block.first,
        what=what,
        notes=(
            *left_out(_filled(rows, below), "no numbers below the table"),
            *left_out(table.index[empty], "no value"),
        ),
    )


def no_table(name: str) -> str:
    """Message for a file without a table."""
    return (
        f"{name}: no table was found; needed: at least {FEWEST_COLUMNS} columns and "
        f"{FEWEST_ROWS} rows of numbers"
    )


def first_block(rows: Rows) -> Block | None:
    """Find the first rows of the table: those that may go on as its longest block.

    A line between the parts of a table that has another number of cells is reported later.
    """
    blocks = blocks_of(rows)
    longest = max(blocks, key=lambda block: len(block.columns[0]), default=None)
    if longest is None or not longest.share:
        return None
    first = next(block.first for block in blocks if _continued(block, longest))
    return Block(first, longest.columns)


def blocks_of(rows: Rows) -> list[Block]:
    """Find the blocks of at least `FEWEST_ROWS` rows; rows without any value do not count."""
    filled = [(line, tuple(cells)) for line, cells in rows.items() if not is_empty(cells)]
    runs = [list(run) for _, run in groupby(filled, lambda row: _width_of_numbers(row[1]))]
    return [
        Block(run[0][0], tuple(zip(*(cells for _, cells in run), strict=True)))
        for run in runs
        if len(run) >= FEWEST_ROWS and _width_of_numbers(run[0][1]) >= FEWEST_COLUMNS
    ]


def _width_of_numbers(cells: Sequence[str]) -> int:
    """Count the cells of a row of numbers; 0 for another row."""
    return len(cells) if share_of_numbers(cells) >= LEAST_SHARE else 0


def _continued(block: Block, other: Block) -> bool:
    """Whether a block may go on as the other: lines such as ``Rate;50`` do not."""
    if len(block.columns) != len(other.columns):
        return False
    pairs = zip(block.columns, other.columns, strict=True)
    return all(
        bool(share_of_numbers(a)) == bool(share_of_numbers(b))
        for a, b in pairs
        if not (is_empty(a) or is_empty(b))
    )


def cells_of(line: str, sign: str) -> list[str]:
    """Split a line into cells; a line with unpaired quotes is a single cell."""
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=sign, strict=True))]
    except csv.Error:
        return [line]


def _rows(lines: "Series[str]", separator: str) -> dict[int, list[str]]:
    lines, sign = _separated(lines, separator)
    return {line: cells_of(text, sign) for line, text in lines.items()}


def _separated(lines: "Series[str]", separator: str) -> tuple["Series[str]", str]:
    """Return the lines and their separator; if blanks separate the cells, they become tabs."""
    if separator != "tab":
        lines = lines[lines.str.strip() != ""]
    if separator != "blank":
        return lines, SEPARATORS[separator]
    # A unit in brackets belongs to the word before.
    joined = lines.str.replace(r"\s+(?=[\[(])", "", regex=True)
    return joined.str.strip().str.replace(r"\s+", "\t", regex=True), "\t"


def _split(
    lines: "Series[str]", sign: str, width: int, name: str
) -> tuple["DataFrame", tuple[str, ...]]:
    """Split the rows of a table; return notes on remarks beyond its last column, too.

    Cells beyond the last column that hold no number are remarks. Cells may lack in the last columns
    if these hold no numbers.

    Raises
    ------
    RecordingError
        If rows have other numbers of cells, or a quote is not closed; the message names the lines.
    """
    import pandas as pd

    if not lines.str.contains('"', regex=False).any():
        rows = list(csv.reader(iter(lines), delimiter=sign))
    else:
        rows = []
        for number, text in lines.items():
            try:
                rows += csv.reader([text], delimiter=sign, strict=True)
            except csv.Error as error:
                raise RecordingError(f"{name}, line {number}: unpaired quotes ({error})") from None
    unequal = [place for place, row in enumerate(rows) if len(row) != width]
    remarked, wrong = [], []
    for place in unequal:
        row = rows[place]
        if len(row) > width and not share_of_numbers(cell.strip() for cell in row[width:]):
            remarked.append(lines.index[place])
        elif len(row) > width or _numbers_beyond(rows, len(row), width):
            wrong.append(
                f"{name}, line {lines.index[place]}: {counted(len(row), 'value')}, but line "
                f"{lines.index[0]} has {width}"
            )
        rows[place] = [*row[:width], *[""] * (width - len(row))]
    if wrong:
        raise RecordingError(listed(wrong))
    notes = left_out(pd.Index(remarked, dtype=int), "remarks beyond the last column")
    return pd.DataFrame(rows, index=lines.index, dtype=str), notes


def _numbers_beyond(rows: Sequence[Sequence[str]], begin: int, width: int) -> bool:
    """Whether the columns from `begin` on hold numbers, or no text, in the first rows."""
    beyond = [
        cell.strip() for row in rows[:SAMPLE] if len(row) == width for cell in row[begin:width]
    ]
    return is_empty(beyond) or bool(share_of_numbers(beyond))


def _filled(rows: Rows, begin: int) -> IntArray:
    """Lines from `begin` on that have some cell."""
    return np.array(
        [line for line, cells in rows.items() if line >= begin and any(cells)], dtype=int
    )
