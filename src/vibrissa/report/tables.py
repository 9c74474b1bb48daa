"""Key rows of the study's tables, as the page shows them."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from vibrissa.report.spelling import spell, spell_unit, symbol
from vibrissa.study.axes import LAW_AXES, MOUNTING_AXES, SURFACE_AXES
from vibrissa.tables import query
from vibrissa.tables.counts import SCAN, rows_of, scan_keys
from vibrissa.tables.query import Readable
from vibrissa.wording import figure_name

# Largest number of rows that are shown of each table.
MOST_ROWS = 40
# Decimals of a load on the clamp; further ones are rounding errors.
DECIMALS = 9

POINT = ("theta", "mu0", "eta", "dx0")
MOUNTING = (*MOUNTING_AXES, "curvature_powers")
SCAN_AXES = (*SURFACE_AXES, *LAW_AXES)
REACTIONS = ("reaction_fx", "reaction_fy", "reaction_m")
# Title and columns of each table that is shown.
SHOWN = {
    "stiction": (
        "Grid points",
        (
            *("grid", *POINT, "status", "contact", "x0_max", "x0_slip"),
            *("mu_lock", "f_slip", "reaction_m_slip", "residual"),
        ),
    ),
    "scans": (
        "Scans",
        ("scan", *POINT, "surface", *SCAN_AXES, "status", "cycle", "x0", *REACTIONS),
    ),
    "states": (
        "Single states",
        (
            *("state", "theta", "eta", "x1", "status", "contact", "f", "alpha", "phi1"),
            *(*REACTIONS, "penetrates", "residual"),
        ),
    ),
    "comparisons": (
        "Points in both kinds of contact",
        (
            *("comparison", "theta", "mu0", "eta", "status_point", "status_line"),
            *("x0_slip_point", "x0_slip_line", "mu_lock_point", "mu_lock_line", "penetrates"),
        ),
    ),
}


@dataclass(frozen=True, kw_only=True)
class Column:
    """A column for readers: its name, unit and description, and the text of each cell."""

    name: str
    unit: str
    description: str
    cells: Sequence[str]


@dataclass(frozen=True, kw_only=True)
class Section:
    """A table for readers, with a title and a note."""

    title: str
    note: str
    columns: Sequence[Column]

    @property
    def rows(self) -> Iterable[tuple[str, ...]]:
        """Texts of the cells by row."""
        return zip(*(column.cells for column in self.columns), strict=True)


def sections(found: Mapping[str, Readable]) -> list[Section]:
    """Make a section of the page for each table of a study, with selected rows."""
    shown: list[Section] = []
    for name, table in found.items():
        if name not in SHOWN or not query.count(table):
            continue
        title, columns = SHOWN[name]
        mounting = [axis for axis in MOUNTING if axis in table.schema.names]
        if name == "scans":
            note = "cycle, x0: largest value; loads on the clamp: smallest and largest value."
            rows = _scans(table, (*columns, *mounting))
        else:
            note = ""
            rows = query.spaced(table, (*columns, *mounting), MOST_ROWS)
        columns = (*columns, *(axis for axis in mounting if {*rows[axis].dropna()} - {0.0}))
        # A column that no scan has a value of, such as the seed of a plane, tells nothing.
        columns = tuple(
            name for name in columns if name not in SCAN_AXES or rows[name].notna().any()
        )
        shown.append(_section(table, rows, columns, title, note))
    return shown


def _scans(table: Readable, columns: Sequence[str]) -> pd.DataFrame:
    """Return a row for each scan: number of cycles, largest x0, and range of each load."""
    rows = rows_of(table, columns, scan_keys(table).head(MOST_ROWS))
    loads = {name: _range for name in REACTIONS}
    kept = {"status": "first", "cycle": "max", "x0": "max", **loads}
    scans = rows.groupby([*SCAN], sort=False, dropna=False).agg(kept)
    return scans.reset_index()


def _range(values: pd.Series) -> str:
    rounded = values.round(DECIMALS) + 0.0
    return f"{spell(rounded.min(), 4)} … {spell(rounded.max(), 4)}"


def _section(
    table: Readable, rows: pd.DataFrame, names: Sequence[str], title: str, note: str
) -> Section:
    """Make a section; columns with one value in all rows are moved to its note."""
    columns = [_column(table, name, rows[name].astype(object)) for name in names]
    same = [column for column in columns if len(column.cells) > 1 and len({*column.cells}) == 1]
    if equal := [f"{one.name} = {one.cells[0]}" for one in same if one.cells[0] != "–"]:
        note += f" In all of these rows: {', '.join(equal)}."
    varying = [column for column in columns if column not in same]
    return Section(title=title, note=note.strip(), columns=varying)


def _column(table: Readable, name: str, values: Iterable[Any]) -> Column:
    """Make a column; its unit and its description come from the table's schema."""
    about = table.schema.field(name).metadata
    digits = 2 if name == "residual" else 5
    named = figure_name if name in ("grid", "scan", "state", "comparison") else str
    return Column(
        name=symbol(name),
        unit=spell_unit(about[b"unit"].decode()),
        description=about[b"description"].decode(),
        cells=[named(spell(value, digits)) for value in values],
    )
