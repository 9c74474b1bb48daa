"""Key rows of the study's tables, as the page shows them."""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce
from operator import and_
from typing import Any

import numpy as np
import pandas as pd
import pyarrow.compute as pc

from vibrissa.report.proofs import Proved, digits, mark
from vibrissa.report.spelling import spell, spell_unit, symbol
from vibrissa.tables import query, store
from vibrissa.tables.proofs import KEYS
from vibrissa.tables.query import Readable

# Rows that a section shows, and rows above which only the ends of the axes are shown.
MOST_ROWS = 40
FEW_ROWS = 27
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
PROVED = {
    "stiction": ("x0_slip", "f_slip", "phi1_slip", "reaction_m_slip"),
    "curves": ("mu_lock", "x1_init", "f_init", "reaction_m_init"),
    "states": ("f", "alpha", "phi1", "reaction_m"),
}
PROVED_NOTE = (
    "Proved by interval arithmetic: these are digits of the exact solution of the model’s "
    "equations, cut off and not rounded."
)
NOTHING = Proved(())
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


def sections(found: Mapping[str, Readable], proved: Proved = NOTHING) -> list[Section]:
    """Key rows of each of a study's tables that the page shows.

    Parameters
    ----------
    found : mapping of pyarrow.Table or Dataset
        The study's tables by name.
    proved : Proved
        Proofs of their numbers.

    Returns
    -------
    list of Section
        Where there are proofs, rows that have one are marked, and its digits shown in the end.
    """
    return [
        section
        for name, table in found.items()
        if name in _SECTIONS and query.count(table)
        for section in _SECTIONS[name](table, proved)
    ]


def key_rows(rows: pd.DataFrame, axes: Sequence[str]) -> pd.DataFrame:
    """Rows at the first, middle and last value of each axis.

    Parameters
    ----------
    rows : DataFrame
        Rows on a grid.
    axes : sequence of str
        Columns that span the grid.

    Returns
    -------
    DataFrame
        Without the middle values where they would make too many.
    """
    values = _key_values({name: set(rows[name]) for name in axes})
    keep = np.logical_and.reduce([rows[name].isin(chosen) for name, chosen in values.items()])
    return rows[keep].sort_values(list(axes))


def _key_values(values: Mapping[str, set[float]]) -> dict[str, list[float]]:
    """First, middle and last value of each axis, without the middle ones if they are too many."""
    ordered = {name: sorted(axis) for name, axis in values.items()}
    chosen = {name: sorted({v[0], v[len(v) // 2], v[-1]}) for name, v in ordered.items()}
    if math.prod(map(len, chosen.values())) > FEW_ROWS:
        chosen = {name: sorted({v[0], v[-1]}) for name, v in ordered.items()}
    return chosen


def spell_counts(statuses: Mapping[str, int]) -> str:
    """Say how many there are, and how many of them have which status."""
    counts, total = sorted(statuses.items()), sum(statuses.values())
    if len(counts) < 2:
        return f"{total}" + "".join(f", {'all ' * (n > 1)}{spell(s)}" for s, n in counts)
    return f"{total}: " + ", ".join(f"{n} {spell(s)}" for s, n in counts)


def _column(table: Readable, name: str, values: Iterable[Any]) -> Column:
    """Column of a table with the unit and the description of its schema."""
    said = table.schema.field(name).metadata
    digits = 2 if name == "residual" else 5
    return Column(
        name=symbol(name),
        unit=spell_unit(said[b"unit"].decode()),
        description=said[b"description"].decode(),
        cells=[spell(value, digits) for value in values],
    )


def _section(title: str, note: str, columns: Sequence[Column], total: int) -> Section:
    """Section whose note says, once, what is the same in all rows, and how many are not shown."""
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


def _rows_section(
    table: Readable,
    rows: pd.DataFrame,
    names: Sequence[str],
    title: str,
    note: str = "",
    more: Sequence[Column] = (),
) -> Section:
    """Section of some columns of a table's rows, and more columns."""
    shown = rows.head(MOST_ROWS).astype(object)
    columns = [_column(table, name, shown[name]) for name in names]
    return _section(title, note, [*columns, *more], len(rows))


def _marks(name: str, rows: pd.DataFrame, proved: Proved) -> list[Column]:
    """Make a column that marks the rows with proofs, where there are any."""
    if not proved:
        return []
    shown = rows.head(MOST_ROWS).to_dict("records")
    return [
        Column(
            name="proved",
            description="✓: the row’s numbers are proved, and that the onset is the first on its "
            "path, or that the tip locks; ✓ (state): the numbers are",
            cells=[mark(proved.of(name, row)) for row in shown],
        )
    ]


def _digits(
    table: Readable, name: str, rows: pd.DataFrame, proved: Proved, title: str
) -> list[Section]:
    """Section of the proved digits of rows, where there are any."""
    known = {i: proved.of(name, row) for i, row in enumerate(rows.to_dict("records"))}
    kept = [i for i, proofs in known.items() if set(proofs) & set(PROVED[name])]
    if not kept:
        return []
    shown = kept[:MOST_ROWS]
    columns = [
        replace(_column(table, column, []), cells=[digits(known[i].get(column)) for i in shown])
        for column in PROVED[name]
    ]
    keys = [_column(table, key, rows[key].iloc[shown]) for key in KEYS[name]]
    return [_section(title, PROVED_NOTE, [*keys, *columns], len(kept))]


@dataclass(kw_only=True)
class _Grid:
    """What the points of a grid have: statuses with their number, and values of each axis."""

    statuses: Counter[str] = field(default_factory=Counter)
    values: dict[str, set[float]] = field(default_factory=lambda: {name: set() for name in POINT})


def _grids(table: Readable) -> dict[str, _Grid]:
    """Read what each grid has, part by part: the table may be long."""
    grids: dict[str, _Grid] = {}
    for part in query.parts(table, ["grid", *POINT, "status"]):
        for name in pc.unique(part.column("grid")).to_pylist():
            points, grid = part.filter(query.in_grid(name)), grids.setdefault(name, _Grid())
            grid.statuses.update(store.status_counts([points]))
            for axis, seen in grid.values.items():
                seen.update(pc.unique(points.column(axis)).to_pylist())
    return grids


def _corners(table: Readable, columns: Sequence[str], name: str, grid: _Grid) -> pd.DataFrame:
    """Rows at the corners and in the middle of a grid."""
    where = [query.one_of(*axis) for axis in _key_values(grid.values).items()]
    rows = query.frame(table, columns, reduce(and_, where, query.in_grid(name)))
    return rows.sort_values(list(POINT))


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
    return {
        name: _corners(table, columns, name, grid) for name, grid in sorted(_grids(table).items())
    }


def _stiction(table: Readable, proved: Proved) -> list[Section]:
    shown: list[Section] = []
    keyed: list[pd.DataFrame] = []
    for name, grid in sorted(_grids(table).items()):
        rows = _corners(table, STICTION, name, grid)
        note = f"Points: {spell_counts(grid.statuses)}."
        if len(rows) < grid.statuses.total():
            note += " Here are the corners and the middle of the grid."
        more = _marks("stiction", rows, proved)
        shown.append(_rows_section(table, rows, STICTION, f"Grid {name}", note, more))
        keyed.append(rows)
    if proved:
        points = pd.concat(keyed).drop_duplicates(list(POINT)).sort_values(list(POINT))
        axes = list(KEYS["curves"])
        curves = query.frame(table, [*axes, *PROVED["curves"]]).drop_duplicates(axes)
        curves = curves.sort_values(axes)
        shown += _digits(table, "stiction", points, proved, "Proved digits of the onsets")
        shown += _digits(table, "curves", curves, proved, "Proved digits of the curves")
    return shown


def _scans(table: Readable, proved: Proved) -> list[Section]:
    """Length of each scan, and least and greatest value of the load on the clamp."""
    rows = query.frame(table, [*SCAN, "status", "footpoint", "cycle", "x0", *REACTIONS])
    scans = [scan for _, scan in rows.groupby(list(SCAN), sort=False)]
    shown = scans[:MOST_ROWS]
    first = pd.DataFrame([scan.iloc[0] for scan in shown]).astype(object)
    steps = [scan[scan["footpoint"].notna()] for scan in shown]
    columns = [
        *(_column(table, name, first[name]) for name in (*SCAN, "status")),
        Column(
            name="cycles",
            description="stick-slip cycles",
            cells=[spell(scan["cycle"].max(), 9) for scan in steps],
        ),
        Column(
            name="states",
            description="rows of the table",
            cells=[str(len(scan)) for scan in steps],
        ),
        Column(
            name="sticks for",
            unit=spell_unit("L"),
            description="largest clamp displacement in a cycle",
            cells=[spell(scan["x0"].max()) for scan in steps],
        ),
    ]
    for name in REACTIONS:
        column = _column(table, name, [])
        columns.append(
            replace(
                column,
                description=f"{column.description}, least and greatest",
                cells=[_spell_range(scan[name]) for scan in steps],
            )
        )
    return [_section("Scans", "", columns, len(scans))]


def _spell_range(values: pd.Series) -> str:
    """Spell the least and the greatest value."""
    if values.empty:
        return "–"
    ends = values.min(), values.max()
    size = max(map(abs, ends))
    return " … ".join(spell(end if abs(end) > ROUNDING * size else 0.0, 4) for end in ends)


def _states(table: Readable, proved: Proved) -> list[Section]:
    rows = query.frame(table, STATES)
    more = _marks("states", rows, proved)
    return [
        _rows_section(table, rows, STATES, "Single states", more=more),
        *_digits(table, "states", rows, proved, "Proved digits of the states"),
    ]


def _comparisons(table: Readable, proved: Proved) -> list[Section]:
    rows = query.frame(table, ("comparison", *COMPARISONS))
    return [
        _rows_section(
            table,
            key_rows(points, COMPARED),
            COMPARISONS,
            f"Comparison {name}",
            f"{len(points)} points; the rod would pass through the surface in "
            f"{int(points['penetrates'].sum())} of them.",
        )
        for name, points in rows.groupby("comparison", sort=False)
    ]


_SECTIONS: dict[str, Callable[[Readable, Proved], list[Section]]] = {
    "stiction": _stiction,
    "scans": _scans,
    "states": _states,
    "comparisons": _comparisons,
}
