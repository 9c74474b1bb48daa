"""The layout of a file's table: titles, units, and cells."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from vibrissa.numerics.arrays import IntArray
from vibrissa.sensor.identification.recording import left_out
from vibrissa.sensor.importing.delimited import Grid, Rows, decoded, grid_of_text
from vibrissa.sensor.importing.head import head_of, is_numbering, rows_of_head
from vibrissa.sensor.importing.numbers import Signs, is_missing, signs_of
from vibrissa.wording import counted

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, eq=False, kw_only=True)
class Layout:
    """A table of a file.

    Attributes
    ----------
    titles, units : sequence of str
        Title and unit of each column. Without titles in the file they are #1, #2, …; without units
        the texts are empty.
    cells : DataFrame
        Cells as texts or numbers; the index has the line number of each row.
    samples : ndarray of int
        Number of the sample in each row, from 0; samples without any value have no row.
    signs : Signs
        Decimal sign, and the signs that separate thousands.
    notes : tuple of str
        What was found in the file, and which lines are left out.
    heads : mapping of int to sequence of str
        Lines above the table that may be titles.
    """

    titles: Sequence[str]
    units: Sequence[str]
    cells: "DataFrame"
    samples: IntArray
    signs: Signs
    notes: tuple[str, ...]
    heads: Rows

    def first_value(self, number: int) -> str:
        """First cell of a column that has a value; empty if there is none."""
        texts = (str(cell).strip() for cell in self.cells.iloc[:, number])
        return next((text for text in texts if not is_missing(text)), "")


def layout_of_text(
    data: bytes,
    name: str,
    decimal: str | None = None,
    title_line: int | None = None,
    unit_line: int | None = None,
) -> Layout:
    """Find the table in a text file.

    Parameters
    ----------
    decimal : str, optional
        Decimal sign, a point or a comma, if it is stated.
    title_line, unit_line : int, optional
        Lines of titles and units, if they are stated.

    Raises
    ------
    RecordingError
        If there is no table, its rows have different numbers of cells, a stated line is none of
        titles, or the decimal sign is ambiguous; the message names the option to add.
    """
    grid = grid_of_text(decoded(data, name), name)
    return layout_of_grid(grid, name, decimal, title_line, unit_line)


def layout_of_grid(
    grid: Grid, name: str, decimal: str | None, title_line: int | None, unit_line: int | None
) -> Layout:
    """Find titles, units and signs of a table of texts; arguments as in `layout_of_text`."""
    head = head_of(grid, name, title_line, unit_line)
    cells = grid.cells
    samples = grid.samples
    numbering: tuple[str, ...] = ()
    first_rows = [[cell.strip() for cell in row] for row in cells.head(2).itertuples(index=False)]
    if len(first_rows) == 2 and is_numbering(*first_rows):
        numbering = left_out(cells.index[:1], "numbers of the columns")
        cells = cells.iloc[1:]
        samples = samples[1:] - samples[1]
    signs = signs_of(cells, name, decimal)
    size = f"{counted(len(cells), 'row')} from line {cells.index[0]} on"
    return Layout(
        titles=head.titles,
        units=head.units,
        cells=cells,
        samples=samples,
        signs=signs,
        notes=(f"{grid.what}, {signs.note}, {head.note}, {size}", *numbering, *grid.notes),
        heads=rows_of_head(grid),
    )
