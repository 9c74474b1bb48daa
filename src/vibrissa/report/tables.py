"""Key rows of the study's tables, as the page shows them."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import and_
from typing import Any

import numpy as np
import pandas as pd
import pyarrow.compute as pc

from vibrissa.report.spelling import spell, spell_unit, symbol
from vibrissa.tables import query
from vibrissa.tables.query import Readable
from vibrissa.wording import figure_name

# Rows that a section shows, and rows above which only the ends of the axes are shown.
MOST_ROWS, FEW_ROWS = 40, 27
# Range of a signal that is only rounding, relative to its greatest size.
ROUNDING = 1e-9

POINT = ("theta", "mu0", "eta", "dx0")
SCAN = ("scan", *POINT)
REACTIONS = ("reaction_fx", "reaction_fy", "reaction_m")
STICTION = (
    *(*POINT, "status", "contact", "x0_max", "x0_slip"),
    *("mu_lock", "f_slip", "reaction_m_slip", "residual"),
)
STATES = (
    *("state", "theta", "eta", "x1", "status", "contact", "f", "alpha", "phi1"),
    *(*REACTIONS, "penetrates", "residual"),
)
COMPARED = ("theta", "mu0", "eta")
COMPARISONS = (
    *(*COMPARED, "status_point", "status_line", "x0_slip_point", "x0_slip_line"),
    *("mu_lock_point", "mu_lock_line", "penetrates"),
)


@dataclass(frozen=True, kw_only=True)
class Column:
    """A column to be read: its name, unit and description, and the text of each cell."""

    name: str
    unit: str = ""
    description: str
    cells: Sequence[str]

    @property
    def is_constant(self) -> bool:
        """Whether several rows have one text."""
        return len(self.cells) > 1 and len(set(self.cells)) == 1


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
    shown = {
        "stiction": _stiction,
        "scans": _scans,
        "states": _states,
        "comparisons": _comparisons,
    }
    return [
        section
        for name, table in found.items()
        if name in shown and query.count(table)
        for section in shown[name](table)
    ]


def corners(table: Readable, columns: Sequence[str]) -> dict[str, pd.DataFrame]:
    """Rows of grid points at the corners and in the middle of each grid, by its name.

    Parameters
    ----------
    table : pyarrow.Table or Dataset
        With the schema `STICTION`.
    columns : sequence of str
        Columns that are wanted, the axes among them.

    Returns
    -------
    dict of DataFrame
    """
    values: dict[str, dict[str, set[float]]] = {}
    # Part by part: the table may be long.
    for part in query.parts(table, ["grid", *POINT]):
        for name in pc.unique(part.column("grid")).to_pylist():
            points = part.filter(query.in_grid(name))
            for axis in POINT:
                seen = values.setdefault(name, {}).setdefault(axis, set())
                seen.update(pc.unique(points.column(axis)).to_pylist())
    found = {}
    for name, axes in sorted(values.items()):
        where = [query.one_of(*axis) for axis in _key_values(axes).items()]
        rows = query.frame(table, columns, reduce(and_, where, query.in_grid(name)))
        found[name] = rows.sort_values(list(POINT))
    return found


def _key_values(values: Mapping[str, set[float]]) -> dict[str, list[float]]:
    """First, middle and last value of each axis, without the middle ones if they are too many."""
    ordered = {name: sorted(axis) for name, axis in values.items()}
    chosen = {name: sorted({v[0], v[len(v) // 2], v[-1]}) for name, v in ordered.items()}
    if math.prod(map(len, chosen.values())) > FEW_ROWS:
        chosen = {name: sorted({v[0], v[-1]}) for name, v in ordered.items()}
    return chosen


def _column(table: Readable, name: str, values: Iterable[Any]) -> Column:
    """Column of a table with the unit and the description of its schema."""
    about = table.schema.field(name).metadata
    digits = 2 if name == "residual" else 5
    return Column(
        name=symbol(name),
        unit=spell_unit(about[b"unit"].decode()),
        description=about[b"description"].decode(),
        cells=[spell(value, digits) for value in values],
    )


def _section(title: str, columns: Sequence[Column], total: int, note: str = "") -> Section:
    """Section whose note has, once, what is the same in all rows, and how many are not shown."""
    shown = len(columns[0].cells)
    if total > shown:
        note += f" Shown are the first {shown} of {total} rows."
    constant = [column for column in columns if column.is_constant]
    if same := [
        f"{column.name} = {text}" for column in constant for text in {*column.cells} - {"–"}
    ]:
        note += f" In all rows: {', '.join(same)}."
    varying = [column for column in columns if not column.is_constant]
    return Section(title=title, note=note.strip(), columns=varying)


def _of_rows(
    table: Readable, rows: pd.DataFrame, names: Sequence[str], title: str, note: str = ""
) -> Section:
    """Section of some columns of a table's rows."""
    shown = rows.head(MOST_ROWS).astype(object)
    return _section(title, [_column(table, name, shown[name]) for name in names], len(rows), note)


def _stiction(table: Readable) -> list[Section]:
    note = "The corners and the middle of the grid."
    return [
        _of_rows(table, rows, STICTION, f"Grid: {figure_name(name)}", note)
        for name, rows in corners(table, STICTION).items()
    ]


def _scans(table: Readable) -> list[Section]:
    """Length of each scan, and least and greatest value of the load on the clamp."""
    rows = query.frame(table, [*SCAN, "status", "footpoint", "cycle", "x0", *REACTIONS])
    scans = [scan for _, scan in rows.groupby(list(SCAN), sort=False)]
    shown = scans[:MOST_ROWS]
    first = pd.DataFrame([scan.iloc[0] for scan in shown]).astype(object)
    first["scan"] = first["scan"].map(figure_name)
    steps = [scan[scan["footpoint"].notna()] for scan in shown]
    counts = {
        "cycles": ("stick-slip cycles", [spell(scan["cycle"].max(), 9) for scan in steps]),
        "states": ("rows of the table", [str(len(scan)) for scan in steps]),
    }
    columns = [
        *(_column(table, name, first[name]) for name in (*SCAN, "status")),
        *(
            Column(name=name, description=text, cells=cells)
            for name, (text, cells) in counts.items()
        ),
        _column(table, "x0", [scan["x0"].max() for scan in steps]),
    ]
    for name in REACTIONS:
        column = _column(table, name, [])
        columns.append(
            Column(
                name=column.name,
                unit=column.unit,
                description=f"{column.description}, least and greatest",
                cells=[_spell_range(scan[name]) for scan in steps],
            )
        )
    return [_section("Scans", columns, len(scans), "x0: the largest of each scan.")]


def _spell_range(values: pd.Series) -> str:
    """Spell the least and the greatest value."""
    if values.empty:
        return "–"
    ends = values.min(), values.max()
    size = max(map(abs, ends))
    return " … ".join(spell(end if abs(end) > ROUNDING * size else 0.0, 4) for end in ends)


def _states(table: Readable) -> list[Section]:
    rows = query.frame(table, STATES)
    rows["state"] = rows["state"].map(figure_name)
    return [_of_rows(table, rows, STATES, "Single states")]


def _comparisons(table: Readable) -> list[Section]:
    rows = query.frame(table, ("comparison", *COMPARISONS))
    shown = []
    for name, points in rows.groupby("comparison", sort=False):
        values = _key_values({axis: set(points[axis]) for axis in COMPARED})
        keep = np.logical_and.reduce([points[axis].isin(some) for axis, some in values.items()])
        note = (
            f"{len(points)} points; the rod would pass through the surface in "
            f"{int(points['penetrates'].sum())} of them."
        )
        key_rows = points[keep].sort_values(list(COMPARED))
        title = f"Comparison: {figure_name(str(name))}"
        shown.append(_of_rows(table, key_rows, COMPARISONS, title, note))
    return shown
