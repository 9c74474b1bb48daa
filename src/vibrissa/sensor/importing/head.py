"""Titles and units of the columns, from the lines above a table."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from vibrissa.errors import RecordingError
from vibrissa.quantities.units import is_unit
from vibrissa.sensor.importing.delimited import COMMENT, Grid
from vibrissa.sensor.importing.numbers import is_missing, is_whole
from vibrissa.sensor.importing.titles import KINDS, unit_named

# Cells of a row of units that mean "no unit".
NO_UNIT = ("", "-", "1", "%", "°C")
# A line that is drawn below the titles.
RULE = re.compile(r"[-=_+*:.\s]*")
BRACKETS = "[](){} "
# Least number of columns of a row of channel numbers, such as 1;2;3.
FEWEST_NUMBERED = 3


class Head(NamedTuple):
    """Titles and units of the columns, and their lines in the file; 0 if there are none."""

    titles: Sequence[str]
    units: Sequence[str]
    titles_at: int
    units_at: int

    @property
    def note(self) -> str:
        """As in ``titles in line 7, units in line 8``."""
        titles = f"titles in line {self.titles_at}" if self.titles_at else "no titles"
        return titles + (f", units in line {self.units_at}" if self.units_at else "")


def head_of(grid: Grid, name: str, title_line: int | None, unit_line: int | None) -> Head:
    """Find titles and units, in the lines that are stated or else by what they contain.

    The titles are the last line that holds no units, has a text for most columns, and mostly
    different ones: remarks such as raw;raw;raw may stand below the titles.

    Raises
    ------
    RecordingError
        If a stated line has no cell for each column.
    """
    width = grid.cells.shape[1]
    rows = rows_of_head(grid)
    for option, line in {"--title-line": title_line, "--unit-line": unit_line}.items():
        if line is not None and line not in rows:
            lines = ", ".join(map(str, rows)) or "none"
            raise RecordingError(
                f"{name}: {option} {line} is no line above the table with {width} cells; these "
                f"lines are: {lines}"
            )
    of_units = [line for line, cells in rows.items() if line != title_line and are_units(cells)]
    units_at = unit_line or max(of_units, default=0)
    others = {line: cells for line, cells in rows.items() if line != units_at}
    likely = [line for line, cells in others.items() if _are_titles(cells)]
    titles_at = title_line or max(likely or others, default=0)
    return Head(
        titles=rows.get(titles_at, [f"#{number}" for number in range(1, width + 1)]),
        units=rows.get(units_at, [""] * width),
        titles_at=titles_at,
        units_at=units_at,
    )


def rows_of_head(grid: Grid) -> dict[int, list[str]]:
    """Find the lines above the table that have a cell for each of its columns."""
    width = grid.cells.shape[1]
    last = grid.cells.iloc[:, -1]
    ends_empty = bool((last.astype(str) == "").all())  # each row ends with a separator
    rows = {}
    for line, cells in grid.above.items():
        fitted = _fitted(list(cells), width, ends_empty)
        if fitted and not all(is_missing(cell) or RULE.fullmatch(cell) for cell in fitted):
            rows[line] = fitted
    return rows


def _fitted(cells: list[str], width: int, ends_empty: bool) -> list[str]:
    """Cells of a line above a table of this width; empty if it has another number of cells."""
    # The title of a first column may be #; or # marks the line as a comment.
    unmarked = COMMENT.sub("", cells[0], count=1)
    if not unmarked and len(cells) == width + 1:
        cells = cells[1:]
    elif unmarked:
        cells = [unmarked, *cells[1:]]
    while len(cells) > width and not cells[-1]:
        cells = cells[:-1]
    if len(cells) == width - 1 and ends_empty:
        cells = [*cells, ""]
    return cells if len(cells) == width else []


def is_numbering(first: Sequence[str], second: Sequence[str]) -> bool:
    """Whether the first row of a table has the numbers of its columns, such as 1;2;3.

    The second row must have numbers with decimals: a sample may hold any whole numbers.
    """
    if len(first) < FEWEST_NUMBERED or not all(cell.isdecimal() for cell in first):
        return False
    numbers = [int(cell) for cell in first]
    counted = numbers in (list(range(len(first))), list(range(1, len(first) + 1)))
    return counted and not all(is_whole(cell) for cell in second if not is_missing(cell))


def are_units(cells: Sequence[str]) -> bool:
    """Whether the cells are a row of units.

    At least half of the cells that are not in `NO_UNIT` are units of a recording's columns, and the
    others are units, too; or more than half of them are, whatever the others.
    """
    units = [cell for cell in (cell.strip(BRACKETS) for cell in cells) if cell not in NO_UNIT]
    known = sum(1 for unit in units if any(unit_named(unit, kind) for kind in KINDS.values()))
    if not known or 2 * known < len(units):
        return False
    return 2 * known > len(units) or all(map(is_unit, units))


def _are_titles(cells: Sequence[str]) -> bool:
    """Whether most cells are filled, and most of these differ from each other."""
    filled = [cell for cell in cells if cell]
    return 2 * len(filled) > len(cells) and 2 * len(set(filled)) > len(filled)
