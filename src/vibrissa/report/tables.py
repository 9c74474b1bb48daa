"""Key rows of the study's tables, as the page shows them."""

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa

from vibrissa.report.spelling import spell, spell_column, spell_unit, symbol
from vibrissa.study.axes import LAW_AXES, MOUNTING_COLUMNS, POWERS, SURFACE_AXES
from vibrissa.tables import query
from vibrissa.tables.counts import SCAN, rows_of, scan_keys
from vibrissa.tables.query import Readable
from vibrissa.wording import figure_name

# Largest number of rows that are shown of each table.
MOST_ROWS = 40
# Least number of rows of a grid, and number of values to which its shorter axes are thinned.
LEAST_ROWS, FEW = 4, 2
# Decimals of a load on the clamp; further ones are rounding errors.
DECIMALS = 9

POINT = ("theta", "mu0", "eta", "dx0")
# Polynomials: their first coefficients, and the others.
POLYNOMIALS = (*POWERS, *POWERS.values())
SCAN_AXES = (*SURFACE_AXES, *LAW_AXES)
REACTIONS = ("reaction_fx", "reaction_fy", "reaction_m")
# Title and columns of each table that is shown.
SHOWN = {
    "stiction": (
        "Grid points",
        (
            "grid",
            *POINT,
            "status",
            "contact",
            "x0_max",
            "x0_slip",
            "mu_lock",
            "f_slip",
            "reaction_m_slip",
            "residual",
        ),
    ),
    "scans": (
        "Scans",
        ("scan", *POINT, "surface", *SCAN_AXES, "status", "cycle", "x0", *REACTIONS),
    ),
    "friction": (
        "Friction read from recordings",
        (
            "readings",
            *POINT,
            "surface",
            *SCAN_AXES,
            "transducer",
            "read_by",
            "recording",
            "status",
            "grade",
            "mu0_true",
            "mu0_read",
            "mu0_deviation",
            "inside",
            "periods_used",
            "way",
        ),
    ),
    "states": (
        "Single states",
        (
            "state",
            "theta",
            "eta",
            "x1",
            "status",
            "contact",
            "f",
            "alpha",
            "phi1",
            *REACTIONS,
            "penetrates",
            "residual",
        ),
    ),
    "comparisons": (
        "Points in both kinds of contact",
        (
            "comparison",
            "theta",
            "mu0",
            "eta",
            "status_point",
            "status_line",
            "x0_slip_point",
            "x0_slip_line",
            "mu_lock_point",
            "mu_lock_line",
            "penetrates",
        ),
    ),
}


@dataclass(frozen=True, kw_only=True)
class ShownColumn:
    """A column for readers: its name, unit and description, and the text of each cell."""

    name: str
    unit: str
    description: str
    cells: Sequence[str]


@dataclass(frozen=True, kw_only=True)
class ShownTable:
    """A table for readers, with a title and a note."""

    title: str
    note: str
    columns: Sequence[ShownColumn]

    @property
    def rows(self) -> Iterable[tuple[str, ...]]:
        """Texts of the cells by row."""
        return zip(*(column.cells for column in self.columns), strict=True)


def sections(found: Mapping[str, Readable]) -> list[ShownTable]:
    """Make a section of the page for each table of a study, with selected rows."""
    shown: list[ShownTable] = []
    for name, table in found.items():
        if name not in SHOWN or not query.count(table):
            continue
        title, columns = SHOWN[name]
        mounting = [axis for axis in MOUNTING_COLUMNS if axis in table.schema.names]
        if name == "scans":
            note = "cycle, x0: largest value; loads on the clamp: smallest and largest value."
            rows = _scans(table, (*columns, *mounting))
        elif name == "stiction":
            note = ""
            rows = _trends(table, (*columns, *mounting), ("grid", *POINT, *mounting))
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


def _trends(table: Readable, columns: Sequence[str], axes: Sequence[str]) -> pd.DataFrame:
    """Return rows of each grid in the order of its longest axis, with few values of the others.

    Of a grid that does not have all combinations of its values, return the first rows.
    """
    found: dict[str, dict[str, set[Any]]] = {}
    counts: Counter[str] = Counter()
    bends: dict[str, set[Any]] = {}
    for part in query.batches(table, axes):
        for grid, rows in part.to_pandas().groupby("grid", sort=False):
            counts[str(grid)] += len(rows)
            curved = (
                rows[[*POLYNOMIALS]].astype(object).fillna("").itertuples(index=False, name=None)
            )
            bends.setdefault(str(grid), set()).update(curved)
            values = found.setdefault(str(grid), {axis: set() for axis in axes[1:]})
            for axis in values:
                values[axis] |= set(rows[axis].dropna())
    most = max(MOST_ROWS // len(found), LEAST_ROWS)
    kept = []
    for grid, values in found.items():
        others = [len(each) for axis, each in values.items() if axis not in POLYNOMIALS]
        if counts[grid] == len(bends[grid]) * math.prod(others):
            kept.append(_trend(table, columns, grid, values, most))
        else:
            kept.append(_first(table, columns, grid, most))
    return pd.concat(kept, ignore_index=True).head(MOST_ROWS)


def _trend(
    table: Readable, columns: Sequence[str], grid: str, values: Mapping[str, set[Any]], most: int
) -> pd.DataFrame:
    """Return at most about `most` rows of a grid: along its longest axis, for some other values."""
    known = {axis: sorted(each) for axis, each in values.items() if each}
    counts = {axis: len(each) for axis, each in known.items()}
    longest = max(counts, key=lambda axis: counts[axis])
    while math.prod(counts.values()) > most:
        # Other axes are thinned first, down to two values.
        others = [axis for axis in counts if axis != longest and counts[axis] > FEW]
        axis = max(others, key=lambda axis: counts[axis]) if others else longest
        if counts[axis] == 1:
            break
        counts[axis] -= 1
    where = query.one_of("grid", [grid])
    for axis, each in known.items():
        places = np.linspace(0, len(each) - 1, counts[axis]).round().astype(int)
        if counts[axis] < len(each):
            where &= query.one_of(axis, [each[place] for place in places])
    others = [axis for axis in known if axis != longest]
    return query.frame(table, columns, where).sort_values([*others, longest])


def _first(table: Readable, columns: Sequence[str], grid: str, most: int) -> pd.DataFrame:
    """Return at most `most` rows of a grid."""
    kept: list[pa.Table] = []
    for part in query.batches(table, columns, query.one_of("grid", [grid])):
        kept.append(part.slice(0, most - sum(map(len, kept))))
        if sum(map(len, kept)) >= most:
            break
    return pa.concat_tables(kept).to_pandas()


def _scans(table: Readable, columns: Sequence[str]) -> pd.DataFrame:
    """Return a row for each scan: number of cycles, largest x0, and range of each load."""
    first = pd.DataFrame()
    for scans in scan_keys(table):
        first = pd.concat([first, scans]).head(MOST_ROWS)
        if len(first) == MOST_ROWS:
            break
    rows = rows_of(table, columns, first)
    loads = {name: _range for name in REACTIONS}
    kept = {"status": "first", "cycle": "max", "x0": "max", **loads}
    scans = rows.groupby([*SCAN], sort=False, dropna=False).agg(kept)
    return scans.reset_index()


def _range(values: pd.Series) -> str:
    rounded = values.round(DECIMALS) + 0.0
    return f"{spell(rounded.min(), 4)} … {spell(rounded.max(), 4)}"


def _section(
    table: Readable, rows: pd.DataFrame, names: Sequence[str], title: str, note: str
) -> ShownTable:
    """Make a section; columns with one value in all rows are moved to its note."""
    columns = [_column(table, name, rows[name].astype(object)) for name in names]
    same = [column for column in columns if len(column.cells) > 1 and len({*column.cells}) == 1]
    if equal := [f"{one.name} = {one.cells[0]}" for one in same if one.cells[0] != "–"]:
        note += f" In all of these rows: {', '.join(equal)}."
    varying = [column for column in columns if column not in same]
    return ShownTable(title=title, note=note.strip(), columns=varying)


def _column(table: Readable, name: str, values: Iterable[Any]) -> ShownColumn:
    """Make a column; its unit and its description come from the table's schema."""
    about = table.schema.field(name).metadata
    found = list(values)
    cells = [spell(value, 2) for value in found] if name == "residual" else spell_column(found)
    named = figure_name if name in ("grid", "scan", "readings", "state", "comparison") else str
    return ShownColumn(
        name=symbol(name),
        unit=spell_unit(about[b"unit"].decode()),
        description=about[b"description"].decode(),
        cells=[named(cell) for cell in cells],
    )
