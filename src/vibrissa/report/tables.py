"""Key rows of the study's tables, as the page shows them."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import and_
from typing import Any

import pandas as pd
import pyarrow.compute as pc

from vibrissa.report.spelling import spell, spell_unit, symbol
from vibrissa.tables import query
from vibrissa.tables.query import Readable
from vibrissa.wording import figure_name

# Rows that a section shows, and rows above which only the ends of the axes are shown.
MOST_ROWS, FEW_ROWS = 40, 27
# Decimals of a load on the clamp; beyond is rounding.
DECIMALS = 9

COMPARED = ("theta", "mu0", "eta")
POINT = (*COMPARED, "dx0")
SCAN = ("scan", *POINT)
REACTIONS = ("reaction_fx", "reaction_fy", "reaction_m")
STICTION = (
    *(*POINT, "status", "contact", "x0_max", "x0_slip"),
    *("mu_lock", "f_slip", "reaction_m_slip", "residual"),
)
SCANS = (*SCAN, "status", "cycle", "x0", *REACTIONS)
STATES = (
    *("state", "theta", "eta", "x1", "status", "contact", "f", "alpha", "phi1"),
    *(*REACTIONS, "penetrates", "residual"),
)
COMPARISONS = (
    *(*COMPARED, "status_point", "status_line", "x0_slip_point", "x0_slip_line"),
    *("mu_lock_point", "mu_lock_line", "penetrates"),
)
# Tables of which the corners and the middle of each grid are shown: the column with its name, its
# axes, and the columns that are shown.
CORNERS = {
    "stiction": ("grid", POINT, STICTION),
    "comparisons": ("comparison", COMPARED, COMPARISONS),
}


@dataclass(frozen=True, kw_only=True)
class Column:
    """A column to be read: its name, unit and description, and the text of each cell."""

    name: str
    unit: str
    description: str
    cells: Sequence[str]


@dataclass(frozen=True, kw_only=True)
class Section:
    """A table to be read, with a title and a note."""

    title: str
    note: str
    columns: Sequence[Column]

    @property
    def rows(self) -> Iterable[tuple[str, ...]]:
        """Texts of the cells by row."""
        return zip(*(column.cells for column in self.columns), strict=True)


def sections(found: Mapping[str, Readable]) -> list[Section]:
    """Key rows of each of a study's tables, by name, that the page shows."""
    shown: list[Section] = []
    for name, table in found.items():
        if not query.count(table):
            continue
        if name in CORNERS:
            shown += _corners(table, *CORNERS[name])
        elif name == "scans":
            shown.append(_scans(table))
        elif name == "states":
            rows = query.frame(table, STATES)
            shown.append(_section(table, rows, STATES, "Single states"))
    return shown


def _scans(table: Readable) -> Section:
    """Cycles, largest x0, and least and greatest load on the clamp of each scan."""
    rows = query.frame(table, SCANS)
    loads = {name: _range for name in REACTIONS}
    kept = {"status": "first", "cycle": "max", "x0": "max", **loads}
    scans = rows.groupby(list(SCAN), sort=False).agg(kept).reset_index()
    note = "cycle, x0: the largest; Fx, Fy, M: the least and the greatest."
    return _section(table, scans, SCANS, "Scans", note)


def _range(values: pd.Series) -> str:
    rounded = values.round(DECIMALS) + 0.0
    return f"{spell(rounded.min(), 4)} … {spell(rounded.max(), 4)}"


def _corners(
    table: Readable, source: str, axes: Sequence[str], names: Sequence[str]
) -> list[Section]:
    """Sections of the corners and the middle of each grid or comparison."""
    values: dict[str, dict[str, set[float]]] = {}
    # Part by part: the table may be long.
    for part in query.parts(table, [source, *axes]):
        distinct = part.group_by(source).aggregate([(axis, "distinct") for axis in axes])
        for row in distinct.to_pylist():
            seen = values.setdefault(row[source], {axis: set() for axis in axes})
            for axis in axes:
                seen[axis].update(row[f"{axis}_distinct"])
    shown = []
    for name, found in sorted(values.items()):
        where = [query.one_of(*axis) for axis in _key_values(found).items()]
        rows = query.frame(table, names, reduce(and_, where, pc.field(source) == name))
        title = f"{source.capitalize()}: {figure_name(name)}"
        note = "The corners and the middle."
        shown.append(_section(table, rows.sort_values(list(axes)), names, title, note))
    return shown


def _key_values(values: Mapping[str, set[float]]) -> dict[str, list[float]]:
    """First, middle and last value of each axis, without the middle ones if they are too many."""
    ordered = {name: sorted(axis) for name, axis in values.items()}
    chosen = {name: sorted({v[0], v[len(v) // 2], v[-1]}) for name, v in ordered.items()}
    if math.prod(map(len, chosen.values())) > FEW_ROWS:
        chosen = {name: sorted({v[0], v[-1]}) for name, v in ordered.items()}
    return chosen


def _section(
    table: Readable, rows: pd.DataFrame, names: Sequence[str], title: str, note: str = ""
) -> Section:
    """Section of some columns; its note has the values that are equal in all rows."""
    shown = rows.head(MOST_ROWS).astype(object)
    if len(rows) > MOST_ROWS:
        note += f" Shown are the first {MOST_ROWS} of {len(rows)} rows."
    columns = [_column(table, name, shown[name]) for name in names]
    same = [column for column in columns if len(column.cells) > 1 and len({*column.cells}) == 1]
    if told := [f"{one.name} = {one.cells[0]}" for one in same if one.cells[0] != "–"]:
        note += f" In all rows: {', '.join(told)}."
    varying = [column for column in columns if column not in same]
    return Section(title=title, note=note.strip(), columns=varying)


def _column(table: Readable, name: str, values: Iterable[Any]) -> Column:
    """Column of a table with the unit and the description of its schema."""
    about = table.schema.field(name).metadata
    digits = 2 if name == "residual" else 5
    named = figure_name if name in ("scan", "state") else str
    return Column(
        name=symbol(name),
        unit=spell_unit(about[b"unit"].decode()),
        description=about[b"description"].decode(),
        cells=[named(spell(value, digits)) for value in values],
    )
