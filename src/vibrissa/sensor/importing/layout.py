"""The layout of a laboratory's text file: separator, decimal sign, columns and their units.

The separator is chosen so that the largest share of the cells are numbers.
"""

import codecs
import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING, NamedTuple

from vibrissa.errors import ArgumentError, RecordingError
from vibrissa.numerics.arrays import IntArray
from vibrissa.quantities.series import MISSING, NUMBER, lines_of, split
from vibrissa.quantities.units import CHANNEL_KINDS, Kind, unit_size
from vibrissa.sensor.identification.recording import left_out
from vibrissa.sensor.transducer import CHANNELS
from vibrissa.wording import counted

if TYPE_CHECKING:
    from pandas import DataFrame, Series

# Separators, in the order of preference at equal shares of numbers.
SEPARATORS = {"semicolon": ";", "tab": "\t", "comma": ",", "bar": "|", "blank": " "}
DECIMALS = {".": "decimal point", ",": "decimal comma"}
EITHER = re.compile(NUMBER.format("[.,]"))
# A number with a decimal sign.
DECIMAL = NUMBER.replace("{0}?", "{0}")
# A number such as 1.234, whose sign may separate decimals or thousands.
GROUPS = r"[-+]?[1-9][0-9]{0,2}[.,][0-9]{3}"
COMMENT = re.compile(r"\s*([#%]|//)+\s*")
# Number of lines in which the first row of the table is sought.
SAMPLE = 1000
# Least numbers of rows and of columns of a table.
FEWEST_ROWS, FEWEST_COLUMNS = 3, 2
# LabVIEW's title of a column that its rows do not have.
REMARKS = "Comment"
# Columns of a recording and what they measure.
KINDS = {
    "time": Kind.TIME,
    "footpoint": Kind.LENGTH,
    **dict(zip(CHANNELS, CHANNEL_KINDS, strict=True)),
}
# Cells of a row of units that mean "no unit", or units of quantities that no recording has.
NO_UNIT = ("", "-", "1", "%", "V", "mV", "°C", "K")
# Titles with units: Fz [mN], Fz (mN); if the unit is one of the quantity that the column must hold,
# also Fz / mN, Fz in mN, Fz_mN, Fz mN.
TITLE = re.compile(r"(.*?)\s*[\[(]([^\[\]()]*)[\])]")
ENDING = re.compile(r"(.+?)\s*(?:/|\bin\b|[_ ])\s*([^\s_/]+)")
# Column in an option, with sign and unit: -Fz [mN].
SOURCE = re.compile(r"(-?)\s*(.*?)\s*(?:\[([^\[\]]*)\])?")


class FileColumn(NamedTuple):
    """A column of a file: its number from 0, title, unit, and the factor to SI units."""

    number: int
    title: str
    unit: str
    factor: float

    @property
    def note(self) -> str:
        """How the column is read, as in ``minus Fz in mN``."""
        return f"{'minus ' * (self.factor < 0.0)}{self.title} in {self.unit}"


@dataclass(frozen=True, eq=False, kw_only=True)
class Layout:
    """The table of a text file.

    Attributes
    ----------
    titles, units : list of str
        Title and unit of each column. Without titles in the file they are #1, #2, …; without units
        the texts are empty.
    cells : DataFrame
        Cells as texts; the index has the line number of each row.
    samples : ndarray of int
        Number of the sample in each row, from 0; samples without any value have no row.
    decimal : str
        Decimal sign: a point or a comma.
    notes : tuple of str
        What was found in the file, and which lines are left out.
    """

    titles: list[str]
    units: list[str]
    cells: "DataFrame"
    samples: IntArray
    decimal: str
    notes: tuple[str, ...]

    def column(self, target: str, source: str) -> FileColumn | None:
        """Find the column that `source` names, with its unit; None if there is no such column.

        Parameters
        ----------
        target : str
            Name of the quantity: time, footpoint, force_x, force_y or moment_z.
        source : str
            Name of the file's column: ``force_x``, ``-Fz [mN]``, or ``#3`` for the third.

        Raises
        ------
        ArgumentError
            If several columns have this name, or the unit is missing, or is no unit of the
            quantity.
        """
        kind = KINDS[target]
        minus, name, told = SOURCE.fullmatch(source.strip()).groups(default="")  # type: ignore[union-attr]
        names = [
            {title.casefold(), title_of(title, kind)[0].casefold(), f"#{number}"}
            for number, title in enumerate(self.titles, 1)
        ]
        found = [number for number, title in enumerate(self.titles) if title == source]
        found = found or [number for number, each in enumerate(names) if name.casefold() in each]
        if len(found) > 1:
            raise ArgumentError(
                f"several columns are called {name}: choose one by its place in the file; "
                f"{target}=#2 is the second column"
            )
        if not found:
            return None
        title = self.titles[found[0]]
        own, below = title_of(title, kind)[1], self.units[found[0]].strip("[]() ")
        # Brackets in a title may hold a remark.
        unit = told.strip() or (own if unit_size(own, kind) or not below else below)
        if not unit:
            raise ArgumentError(
                f'column {title} has no unit: add it, as in --column "{target}={name} [{kind.si}]"'
            )
        size = float(unit_size(unit, kind))
        if not size:
            raise ArgumentError(
                f"column {title} must have a unit of {kind}, such as {kind.si}, got {unit!r}"
            )
        return FileColumn(found[0], title, unit, -size if minus else size)


def title_of(text: str, kind: Kind) -> tuple[str, str]:
    """Split a title into the name of a column and its unit, which is empty if there is none.

    A unit without brackets counts only if it is a unit of the given kind.

    Examples
    --------
    >>> title_of("Fx_mN", Kind.FORCE)
    ('Fx', 'mN')
    """
    if parts := TITLE.fullmatch(text):
        return parts[1], parts[2].strip()
    parts = ENDING.fullmatch(text)
    return (parts[1], parts[2]) if parts and unit_size(parts[2], kind) else (text, "")


def decoded(data: bytes, name: str) -> str:
    """Decode a text file: UTF-8, UTF-16 with a byte order mark, or else Windows-1252.

    Raises
    ------
    RecordingError
        If the file is no text file.
    """
    marked = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    try:
        text = data.decode("utf-16" if marked else "utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("cp1252", errors="replace")
    if "\0" in text:
        raise RecordingError(f"{name}: not a text file: save the table as text (CSV)")
    return text.replace("−", "-")


def layout_of(text: str, name: str, decimal: str | None = None) -> Layout:
    """Find the table in a text.

    Raises
    ------
    RecordingError
        If there is no table, its rows have different numbers of cells, or the decimal sign is
        ambiguous; in the last case the message names the option to add.
    """
    # A line of tabs may be a row of empty cells.
    lines = lines_of(text, " ")
    sample = lines[~lines.str.match(COMMENT)].head(SAMPLE)
    tried = {one: _block(sample, one) for one in SEPARATORS}
    separator = max(tried, key=lambda one: tried[one][1])
    first, share = tried[separator]
    if not share:
        raise RecordingError(
            f"{name}: no table was found; needed: at least {FEWEST_COLUMNS} columns and "
            f"{FEWEST_ROWS} rows of numbers"
        )
    lines, sign = _separated(lines, separator)
    above, under = lines.loc[: first - 1], lines.loc[first:]
    rows = under[~under.str.match(COMMENT)]
    end = len(rows)
    while not _share(cells_of(rows.iloc[end - 1], sign)):
        end -= 1
    every = split(rows.iloc[:end], name, sign)
    empty = every.apply(lambda column: column.str.strip().str.lower().isin(MISSING)).all(axis=1)
    cells = every[~empty]
    decimal = decimal or _decimal(cells, name)
    heads = _heads(above, sign, cells)
    units_at = max((line for line, head in heads.items() if _are_units(head)), default=0)
    titles_at = max((line for line in heads if line != units_at), default=0)
    head = f"titles in line {titles_at}" if titles_at else "no titles"
    head += f", units in line {units_at}" if units_at else ""
    size = f"{counted(len(cells), 'row')} from line {first} on"
    return Layout(
        titles=heads.get(titles_at, [f"#{number}" for number in range(1, cells.shape[1] + 1)]),
        units=heads.get(units_at, [""] * cells.shape[1]),
        cells=cells,
        samples=every.index.get_indexer(cells.index),
        decimal=decimal,
        notes=(
            f"separator {separator}, {DECIMALS[decimal]}, {head}, {size}",
            *left_out(under.index.difference(rows.index), "comments"),
            *left_out(rows.index[end:], "no numbers below the table"),
            *left_out(every.index[empty], "no value"),
        ),
    )


def _separated(lines: "Series[str]", separator: str) -> tuple["Series[str]", str]:
    """Return the lines and their separator; if blanks separate the cells, they become tabs."""
    if separator != "tab":
        lines = lines[lines.str.strip() != ""]
    if separator != "blank":
        return lines, SEPARATORS[separator]
    # A unit in brackets belongs to the word before.
    joined = lines.str.replace(r"\s+(?=[\[(])", "", regex=True)
    return joined.str.strip().str.replace(r"\s+", "\t", regex=True), "\t"


def _block(lines: "Series[str]", separator: str) -> tuple[int, float]:
    """Find the table's first line, and the share of numbers in the table; 0, 0 without a table."""
    lines, sign = _separated(lines, separator)
    filled = ((n, row) for n, text in lines.items() if not _empty(row := cells_of(text, sign)))
    tables: dict[int, list[tuple[str, ...]]] = {}
    for width, group in groupby(filled, lambda row: len(row[1]) * (_share(row[1]) >= 0.5)):
        numbered, cells = zip(*group, strict=True)
        if width >= FEWEST_COLUMNS and len(cells) >= FEWEST_ROWS:
            tables[numbered[0]] = list(zip(*cells, strict=True))
    longest = max(tables.values(), key=lambda columns: len(columns[0]), default=[])
    # A line between the parts of a table that has another number of cells is reported later.
    first = next((line for line, part in tables.items() if _continued(part, longest)), 0)
    return first, _share([cell for column in longest for cell in column])


def _continued(columns: Sequence[Sequence[str]], others: Sequence[Sequence[str]]) -> bool:
    """Whether these columns may go on as the others: lines such as ``Rate;50`` do not."""
    pairs = [pair for pair in zip(columns, others, strict=False) if not any(map(_empty, pair))]
    return len(columns) == len(others) and all(bool(_share(a)) == bool(_share(b)) for a, b in pairs)


def _empty(cells: Sequence[str]) -> bool:
    return all(cell.lower() in MISSING for cell in cells)


def _share(cells: Sequence[str]) -> float:
    """Share of numbers among the cells that are not empty."""
    filled = [cell for cell in cells if cell.lower() not in MISSING]
    return sum(1 for cell in filled if EITHER.fullmatch(cell)) / max(len(filled), 1)


def cells_of(line: str, sign: str) -> list[str]:
    """Split a line into cells; a line with unpaired quotes is a single cell."""
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=sign, strict=True))]
    except csv.Error:
        return [line]


def _decimal(cells: "DataFrame", name: str) -> str:
    """Find the decimal sign from the numbers whose point or comma cannot separate thousands."""
    text = cells.stack().str.strip()
    groups = text.str.fullmatch(GROUPS)
    proofs = {
        sign: (~groups & text.str.fullmatch(DECIMAL.format(re.escape(sign)))).sum()
        for sign in DECIMALS
    }
    if groups.any() and not any(proofs.values()):
        (line, _), cell = next(iter(text[groups].items()))
        raise RecordingError(
            f"{name}, line {line}: the separator in {cell!r} may mark decimals or thousands: "
            "add --decimal ',' or --decimal '.', whichever marks decimals"
        )
    return max(proofs, key=lambda sign: proofs[sign])


def _heads(above: "Series[str]", sign: str, rows: "DataFrame") -> dict[int, list[str]]:
    """Find the lines above the table that have a cell for each of its columns."""
    width, heads = rows.shape[1], {}
    ends_empty = (rows.iloc[:, -1] == "").all()  # each row ends with a separator
    for line, text in above.items():
        cells = cells_of(text, sign)
        # The title of a first column may be #; or # marks the line as a comment.
        cells[0] = COMMENT.sub("", cells[0], count=1) or cells[0]
        if len(cells) != width:
            cells = cells_of(COMMENT.sub("", text, count=1), sign)
        while len(cells) > width and cells[-1] in ("", REMARKS):
            cells.pop()
        if len(cells) == width - 1 and ends_empty:
            cells.append("")
        if len(cells) == width and not _empty(cells):
            heads[line] = cells
    return heads


def _are_units(cells: list[str]) -> bool:
    """Whether the cells are a row of units.

    More than half of the cells that are not in `NO_UNIT` are units of `KINDS`, as further columns
    may have others.
    """
    units = [cell for cell in (one.strip("[]() ") for one in cells) if cell not in NO_UNIT]
    known = [any(unit_size(unit, kind) for kind in KINDS.values()) for unit in units]
    return sum(known) > 0.5 * len(units)
