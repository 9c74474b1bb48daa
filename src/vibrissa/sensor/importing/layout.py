"""The layout of a laboratory's text file: separator, decimal sign, titles, units, rows of numbers.

The best pair of separator and decimal sign turns the largest part of the cells into numbers.
"""

import codecs
import csv
import re
from dataclasses import dataclass
from enum import StrEnum
from itertools import groupby, product
from typing import TYPE_CHECKING, Any

from vibrissa.errors import RecordingError
from vibrissa.sensor.importing.titles import NO_UNIT, is_unit
from vibrissa.sensor.series import MISSING, Notation, lines_of
from vibrissa.wording import counted

if TYPE_CHECKING:
    from pandas import Index, Series


class Separator(StrEnum):
    """Separator of the cells of a line."""

    SEMICOLON = "semicolon"
    TAB = "tab"
    COMMA = "comma"
    BAR = "bar"
    BLANK = "blank"


SIGNS = dict(zip(Separator, ";\t,| ", strict=True))
_EXPONENT = "([eE][-+]?[0-9]+)?"
# Numbers by their decimal sign. The other sign may stand between groups of three digits.
NOTATIONS = {
    ".": Notation(
        r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+|[1-9][0-9]{0,2}(,[0-9]{3})+(\.[0-9]*)?)" + _EXPONENT,
        decimal=".",
        groups=",",
    ),
    ",": Notation(
        r"[-+]?([0-9]+(,[0-9]+)?|,[0-9]+|[1-9][0-9]{0,2}(\.[0-9]{3})+(,[0-9]+)?)" + _EXPONENT,
        decimal=",",
        groups=".",
    ),
}
COMMENT = re.compile(r"\s*([#%]|//)+")
# Lines that show the layout, unless no number among them decides what the decimal sign is.
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
    titles, units : tuple of str
        One for each column; no titles, or no units, where the file has none.
    rows : Series of str
        Lines of the rows, with their numbers as index and `sign` between the cells.
    """

    separator: Separator
    notation: Notation
    titles: tuple[str, ...]
    units: tuple[str, ...]
    rows: "Series[str]"
    notes: tuple[str, ...]

    @property
    def sign(self) -> str:
        """What separates the cells of a row."""
        return "\t" if self.separator is Separator.BLANK else SIGNS[self.separator]


@dataclass(frozen=True, kw_only=True)
class _Try:
    """Result of reading the sampled lines with one separator and decimal sign."""

    separator: Separator
    notation: Notation
    first: int
    width: int
    values: list[float]
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
    signs = product([separator] if separator else Separator, [decimal] if decimal else NOTATIONS)
    pairs = [(one, NOTATIONS[point]) for one, point in signs if SIGNS[one] != point]
    below = lines[lines.index > (title_line or 0)]
    found = _best(below[:SAMPLE], pairs)
    if len(found) != 1:
        found = _best(below, pairs)
    if not found:
        raise RecordingError(
            f"{name}: no table of {FEWEST_COLUMNS} columns and {FEWEST_ROWS} rows of numbers at "
            "least was found; if there is one, add --separator and --decimal"
        )
    if len(found) > 1:
        raise RecordingError(_ambiguous(found, lines, name))
    return _laid_out(found[0], lines, name, title_line)


def _best(lines: "Series[str]", pairs: list[tuple[Separator, Notation]]) -> list[_Try]:
    """Try all separators and decimal signs; return the best, once for each distinct reading."""
    tried = [one for pair in pairs if (one := _tried(lines, *pair)) is not None]
    best: list[_Try] = []
    for one in tried:
        same = any(one.values == other.values for other in best)
        if one.share == max(each.share for each in tried) and not same:
            best.append(one)
    return best


def _tried(lines: "Series[str]", separator: Separator, notation: Notation) -> _Try | None:
    number = re.compile(notation.number)
    rows = [
        (line, cells_of(text, separator)) for line, text in lines.items() if not COMMENT.match(text)
    ]
    groups = groupby(rows, lambda row: len(row[1]) if _has_numbers(row[1], number) else 0)
    blocks = [list(group) for width, group in groups if width >= FEWEST_COLUMNS]
    blocks = [block for block in blocks if len(block) >= FEWEST_ROWS]
    if not blocks:
        return None
    block = max(blocks, key=len)
    width = len(block[0][1])
    filled = [cell for _, cells in block for cell in cells if cell.lower() not in MISSING]
    values = [notation.value(cell) for cell in filled if number.fullmatch(cell)]
    return _Try(
        separator=separator,
        notation=notation,
        # A line between that fits neither is named later.
        first=next(line for [(line, cells), *_] in blocks if len(cells) == width),
        width=width,
        values=values,
        share=len(values) / max(len(filled), 1),
    )


def _has_numbers(cells: list[str], number: re.Pattern[str]) -> bool:
    """Whether half of the cells that are not empty are numbers."""
    filled = [cell for cell in cells if cell.lower() not in MISSING]
    found = sum(bool(number.fullmatch(cell)) for cell in filled)
    return 2 * found >= len(filled) and any(cells)


def cells_of(line: str, separator: Separator) -> list[str]:
    """Split a line; a line with unpaired quotes is one cell."""
    if separator is Separator.BLANK:
        return line.split()
    try:
        cells = next(csv.reader([line], delimiter=SIGNS[separator], strict=True), [])
    except csv.Error:
        return [line]
    return [cell.strip() for cell in cells]


def _ambiguous(found: list[_Try], lines: "Series[str]", name: str) -> str:
    """Report an ambiguous file, with the option that chooses each reading."""
    one, other = found[:2]
    if one.separator is not other.separator:
        return f"{name}: add --separator {one.separator} or --separator {other.separator}"
    for line, text in lines.loc[one.first :].items():
        for cell in cells_of(text, one.separator):
            if not all(re.fullmatch(each.notation.number, cell) for each in (one, other)):
                continue
            value, other_value = (each.notation.value(cell) for each in (one, other))
            if value != other_value:
                return (
                    f"{name}, line {line}: {cell!r} may be {value!r} or {other_value!r}, and no "
                    f"number of the file decides: add --decimal '{one.notation.decimal}' or "
                    f"--decimal '{other.notation.decimal}'"
                )
    return (
        f"{name}: some numbers have a decimal point, others a decimal comma: correct them; "
        "--decimal '.' or --decimal ',' lists those that do not fit"
    )


def _laid_out(found: _Try, lines: "Series[str]", name: str, title_line: int | None) -> Layout:
    """Find the titles above the rows, and the lines below them that are no rows."""
    rows = lines.loc[found.first :]
    comments = rows.index[rows.str.match(COMMENT)]
    rows = rows.drop(comments)
    number = re.compile(found.notation.number)
    end = len(rows)
    while not any(map(number.fullmatch, cells_of(rows.iloc[end - 1], found.separator))):
        end -= 1
    footer, rows = rows.index[end:], rows.iloc[:end]
    ends_empty = bool(rows.str.rstrip(" ").str.endswith(SIGNS[found.separator]).all())
    heads = _heads(lines.loc[: found.first - 1], found, ends_empty)
    titles_at, units_at = _titles_at(heads, found, name, title_line)
    if found.separator is Separator.BLANK:
        rows = rows.str.strip().str.replace(r"\s+", "\t", regex=True)
    head = f"titles in line {titles_at}" if titles_at else "no titles"
    units = f", units in line {units_at}" if units_at else ""
    size = f"{counted(len(rows), 'row')} from line {found.first} on"
    sign = {".": "decimal point", ",": "decimal comma"}[found.notation.decimal]
    return Layout(
        separator=found.separator,
        notation=found.notation,
        titles=tuple(heads[titles_at]) if titles_at else (),
        units=tuple(heads[units_at]) if units_at else (),
        rows=rows,
        notes=(
            f"separator {found.separator}, {sign}, {head}{units}, {size}",
            *_left_out(comments, "comments"),
            *_left_out(footer, "no numbers below the table"),
        ),
    )


def _left_out(lines: "Index[Any]", what: str) -> list[str]:
    some = ", ".join(map(str, lines[:5])) + ", ..." * (len(lines) > 5)
    return [f"left out, {what}: line {some}"] if len(lines) else []


def _heads(above: "Series[str]", found: _Try, ends_empty: bool) -> dict[int, list[str]]:
    """Cells of the lines above the rows, without comments that have not one for each column."""
    heads = {}
    for line, text in above.items():
        plain = COMMENT.sub("", text, count=1)
        if found.separator is Separator.BLANK:  # a unit in brackets belongs to the word before
            plain = re.sub(r"\s+(?=[\[(])", "", plain)
        cells = cells_of(plain, found.separator)
        while len(cells) > found.width and cells[-1] in ("", REMARKS):
            cells.pop()
        if ends_empty and len(cells) == found.width - 1:
            cells.append("")
        if plain == text or len(cells) == found.width:
            heads[line] = cells
    return heads


def _titles_at(
    heads: dict[int, list[str]], found: _Try, name: str, title_line: int | None
) -> tuple[int, int]:
    """Find the lines of titles and units; 0 where there is none.

    Raises
    ------
    RecordingError
        If the titles are not as many as the columns.
    """
    if title_line == 0 or not heads:
        return 0, 0
    below = [line for line in heads if line > (title_line or 0)]
    units_at = below[-1] if below and _are_units(heads[below[-1]]) else 0
    named = [line for line in heads if line != units_at]
    titles_at = title_line or (named[-1] if named else 0)
    cells = heads.get(titles_at, [])
    if len(cells) == found.width and not any(map(_like_a_number, cells)):
        return titles_at, units_at
    if units_at and not title_line:  # units, and no titles above: they are the titles
        return units_at, 0
    if title_line is None and len(cells) < FEWEST_COLUMNS:
        return 0, 0
    raise RecordingError(
        f"{name}, line {titles_at}: {counted(len(cells), 'title')}, but line {found.first} has "
        f"{counted(found.width, 'value')}: correct it, or add --titles with the line of the titles "
        "(0: none)"
    )


def _are_units(cells: list[str]) -> bool:
    return all(map(is_unit, cells)) and any(cell not in NO_UNIT for cell in cells)


def _like_a_number(cell: str) -> bool:
    return any(re.fullmatch(one.number, cell) for one in NOTATIONS.values())
