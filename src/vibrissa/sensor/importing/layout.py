"""The layout of a laboratory's text file: separator, decimal sign, titles, units, rows of numbers.

The best separator turns the largest part of the cells into numbers.
"""

import codecs
import csv
import re
from dataclasses import dataclass
from enum import StrEnum
from itertools import groupby
from typing import TYPE_CHECKING, Any, NamedTuple

from vibrissa.errors import RecordingError
from vibrissa.sensor.importing.titles import NO_UNIT, is_unit
from vibrissa.sensor.series import MISSING, NUMBER, lines_of, split
from vibrissa.wording import counted

if TYPE_CHECKING:
    from pandas import DataFrame, Index, Series


class Separator(StrEnum):
    """Separator of the cells of a line."""

    SEMICOLON = "semicolon"
    TAB = "tab"
    COMMA = "comma"
    BAR = "bar"
    BLANK = "blank"


SIGNS = dict(zip(Separator, ";\t,| ", strict=True))
DECIMALS = {".": "decimal point", ",": "decimal comma"}
EITHER = re.compile(NUMBER.format("[.,]"))
# A number with a decimal sign.
DECIMAL = NUMBER.replace("{0}?", "{0}")
# With a decimal sign such a number is another one than with a sign between groups of thousands.
GROUPS = r"[-+]?[1-9][0-9]{0,2}[.,][0-9]{3}"
COMMENT = re.compile(r"\s*([#%]|//)+")
# Lines that show where the table is.
SAMPLE = 1000
# Fewer rows are no recording, fewer columns no table.
FEWEST_ROWS, FEWEST_COLUMNS = 3, 2
# LabVIEW's title of a column that its rows do not have.
REMARKS = "Comment"


@dataclass(frozen=True, eq=False, kw_only=True)
class Layout:
    """A table of text.

    Attributes
    ----------
    titles, units : list of str
        One for each column; no titles, or no units, where the file has none.
    cells : DataFrame
        Cells of the rows as texts; the index is their lines.
    """

    titles: list[str]
    units: list[str]
    cells: "DataFrame"
    decimal: str
    notes: tuple[str, ...]


class _Block(NamedTuple):
    """Rows of numbers by one separator: their first line, and the share of numbers."""

    separator: Separator
    first: int
    share: float


def decoded(data: bytes, name: str) -> str:
    """Decode a text file: UTF-8, UTF-16 with its mark, or else the Western letters of Windows.

    Raises
    ------
    RecordingError
        If it is no text.
    """
    marked = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    try:
        text = data.decode("utf-16" if marked else "utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("cp1252", errors="replace")
    if "\0" in text:
        raise RecordingError(f"{name}: not a text file: save the table as text (CSV)")
    return text.replace("−", "-")


def layout_of(
    text: str,
    name: str,
    separator: Separator | None = None,
    decimal: str | None = None,
    title_line: int | None = None,
) -> Layout:
    """Find the table in a text.

    Raises
    ------
    RecordingError
        If there is no table, or more than one reading of it; the message has the choices to type.
    """
    lines = lines_of(text)
    plain = lines[~lines.str.match(COMMENT) & (lines.index > (title_line or 0))]
    tried = [_block(plain.head(SAMPLE), one) for one in ([separator] if separator else Separator)]
    block = max((one for one in tried if one), key=lambda one: one.share, default=None)
    if block is None:
        raise RecordingError(
            f"{name}: no table of {FEWEST_COLUMNS} columns and {FEWEST_ROWS} rows of numbers at "
            "least was found; if there is one, add --separator"
        )
    rows = plain.loc[block.first :]
    end = len(rows)
    while not any(map(EITHER.fullmatch, cells_of(rows.iloc[end - 1], block.separator))):
        end -= 1
    cells = _split(rows.iloc[:end], name, block.separator)
    decimal = decimal or _decimal(cells, name)
    heads = _heads(lines.loc[: block.first - 1], block.separator, cells)
    units_at = max((line for line, head in heads.items() if _are_units(head)), default=0)
    named = max((line for line in heads if line != units_at), default=0)
    titles_at = named if title_line is None else title_line
    if titles_at and titles_at not in heads:
        raise RecordingError(
            f"{name}, line {titles_at} has not one title for each of the {cells.shape[1]} columns"
        )
    head = f"titles in line {titles_at}" if titles_at else "no titles"
    head += f", units in line {units_at}" if units_at else ""
    size = f"{counted(len(cells), 'row')} from line {block.first} on"
    return Layout(
        titles=heads.get(titles_at, []),
        units=heads.get(units_at, []),
        cells=cells,
        decimal=decimal,
        notes=(
            f"separator {block.separator}, {DECIMALS[decimal]}, {head}, {size}",
            *_left_out(lines.loc[block.first :].index.difference(rows.index), "comments"),
            *_left_out(rows.index[end:], "no numbers below the table"),
        ),
    )


def _block(lines: "Series[str]", separator: Separator) -> _Block | None:
    """Find the largest block of rows of numbers by one separator, and where such rows begin."""
    rows = [(line, cells_of(text, separator)) for line, text in lines.items()]
    groups = groupby(rows, lambda row: len(row[1]) if _share(row[1]) >= 0.5 else 0)
    blocks = [list(group) for width, group in groups if width >= FEWEST_COLUMNS]
    blocks = [block for block in blocks if len(block) >= FEWEST_ROWS]
    if not blocks:
        return None
    cells = [cells for _, cells in max(blocks, key=len)]
    width = len(cells[0])
    return _Block(
        separator=separator,
        # A line between that fits neither is named later.
        first=next(line for [(line, row), *_] in blocks if len(row) == width),
        share=_share([cell for row in cells for cell in row]),
    )


def _share(cells: list[str]) -> float:
    """Share of numbers among the cells that are not empty."""
    filled = [cell for cell in cells if cell.lower() not in MISSING]
    return sum(1 for cell in filled if EITHER.fullmatch(cell)) / max(len(filled), 1)


def cells_of(line: str, separator: Separator) -> list[str]:
    """Split a line; a line with unpaired quotes is one cell."""
    if separator is Separator.BLANK:
        return line.split()
    try:
        cells = next(csv.reader([line], delimiter=SIGNS[separator], strict=True), [])
    except csv.Error:
        return [line]
    return [cell.strip() for cell in cells]


def _split(rows: "Series[str]", name: str, separator: Separator) -> "DataFrame":
    if separator is not Separator.BLANK:
        return split(rows, name, SIGNS[separator])
    return split(rows.str.strip().str.replace(r"\s+", "\t", regex=True), name, "\t")


def _decimal(cells: "DataFrame", name: str) -> str:
    """Find the decimal sign, of which each number with another count of decimals is a proof."""
    text = cells.stack().str.strip()
    groups = text.str.fullmatch(GROUPS)
    proofs = {
        sign: (~groups & text.str.fullmatch(DECIMAL.format(re.escape(sign)))).sum()
        for sign in DECIMALS
    }
    if groups.any() and not any(proofs.values()):
        (line, _), cell = next(iter(text[groups].items()))
        raise RecordingError(
            f"{name}, line {line}: {cell!r} may have decimals or thousands, and no number of the "
            "file decides: add --decimal '.' or --decimal ','"
        )
    return max(proofs, key=lambda sign: proofs[sign])


def _heads(above: "Series[str]", separator: Separator, rows: "DataFrame") -> dict[int, list[str]]:
    """Find the lines above the rows that have a cell for each column."""
    width, heads = rows.shape[1], {}
    ends_empty = (rows.iloc[:, -1] == "").all()  # each row ends with a separator
    for line, text in above.items():
        plain = COMMENT.sub("", text, count=1)
        if separator is Separator.BLANK:  # a unit in brackets belongs to the word before
            plain = re.sub(r"\s+(?=[\[(])", "", plain)
        cells = cells_of(plain, separator)
        while len(cells) > width and cells[-1] in ("", REMARKS):
            cells.pop()
        if len(cells) == width - 1 and ends_empty:
            cells.append("")
        if len(cells) == width:
            heads[line] = cells
    return heads


def _are_units(cells: list[str]) -> bool:
    return all(map(is_unit, cells)) and any(cell not in NO_UNIT for cell in cells)


def _left_out(lines: "Index[Any]", what: str) -> list[str]:
    some = ", ".join(map(str, lines[:5])) + ", ..." * (len(lines) > 5)
    return [f"left out, {what}: line {some}"] if len(lines) else []
