"""Whether the points that refinement added to a table of grid points are where they can be.

Halving adds a point in the middle between two others, of the grid or added before it. So a point
that is in no such middle is foreign, and where one of the two others is not there, it is missing.
That a point is missing next to which nothing was added cannot be seen without its curve.
"""

from bisect import bisect_right
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from enum import StrEnum
from itertools import groupby
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc

from vibrissa.study.grid import Grid, Refinement
from vibrissa.tables.collect import Key
from vibrissa.tables.mounted import MOUNTING_COLUMNS, mounting_of, mounting_row
from vibrissa.tables.schemas import ADDED_TO

# What tells curves apart; and points, in the order of the table of grid points.
CURVE_ORDER = ("eta", "theta", *MOUNTING_COLUMNS)
POINT_ORDER = (*CURVE_ORDER, "mu0", "dx0")
Row = Mapping[str, Any]


class Problem(StrEnum):
    """What may be wrong with a grid point, in the words of the message."""

    MISSING = "missing"
    DOUBLED = "doubled"
    FOREIGN = "not in the study"
    MISNAMED = "of other grids"


Fault = tuple[Problem, Key]


def without_added(table: pa.Table) -> pa.Table:
    """Points with the names of those grids alone on whose axes they are; none that was added."""
    if table["added_to"].null_count == len(table):
        return table
    pairs = zip(table["grids"].to_pylist(), table["added_to"].to_pylist(), strict=True)
    own = [[name for name in names if name not in (added or ())] for names, added in pairs]
    place = table.schema.get_field_index("grids")
    named = table.set_column(place, table.schema.field(place), pa.array(own, pa.list_(pa.string())))
    return named.filter(pa.array([bool(names) for names in own], pa.bool_()))


@dataclass(kw_only=True)
class AddedPoints:
    """What is wrong with the added points of a table that passes in parts, in `POINT_ORDER`.

    Attributes
    ----------
    grids : mapping of Grid
        The study's grids by name.
    refinements : mapping of Refinement
        Of those to which points are added.
    """

    grids: Mapping[str, Grid]
    refinements: Mapping[str, Refinement]
    _held: list[Row] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Prepare what is asked of each row."""
        self._axes = {name: _Axes.of(grid) for name, grid in self.grids.items()}

    def faults(self, part: pa.Table) -> Iterator[Fault]:
        """Find what is wrong on those curves that this part ends; the last curve waits."""
        if part["added_to"].null_count == len(part):
            return
        columns = [*POINT_ORDER, "grids", ADDED_TO.name]
        rows = part.select(columns).filter(pc.is_valid(part["added_to"])).to_pylist()
        rows = [*self._held, *rows]
        curves = [list(found) for _, found in groupby(rows, lambda row: _values(row, CURVE_ORDER))]
        *ended, self._held = curves
        for curve in ended:
            yield from self._of_curve(curve)

    def last_faults(self) -> Iterator[Fault]:
        """Find what is wrong on the last curve."""
        yield from self._of_curve(self._held)

    def _of_curve(self, rows: Sequence[Row]) -> Iterator[Fault]:
        places: dict[tuple[str, float], list[Row]] = {}
        for row in rows:
            having = {name for name, axes in self._axes.items() if axes.have(row)}
            if having != set(row["grids"]) - set(row["added_to"]):
                yield Problem.MISNAMED, _values(row, POINT_ORDER)
            for name in row["added_to"]:
                places.setdefault((name, row["dx0"]), []).append(row)
        for (name, _), line in places.items():
            yield from self._of_line(name, line)

    def _of_line(self, name: str, rows: Sequence[Row]) -> Iterator[Fault]:
        """Look at the points that were added to a grid on one curve, of the same Δx0."""
        axes, refinement = self._axes.get(name), self.refinements.get(name)
        counts = Counter(row["mu0"] for row in rows)
        needed: set[float] = set()
        for row in rows:
            between = None
            if axes and refinement and axes.have_curve(row) and row["dx0"] in axes.dx0:
                between = _between(row["mu0"], axes.mu0, refinement.closest)
            if between is None:
                yield Problem.FOREIGN, _values(row, POINT_ORDER)
            elif axes:
                needed |= set(map(float, between)) - axes.frictions
            if counts[row["mu0"]] > 1:
                counts[row["mu0"]] = 1
                yield Problem.DOUBLED, _values(row, POINT_ORDER)
        for mu0 in sorted(needed - counts.keys()):
            yield Problem.MISSING, _values({**rows[0], "mu0": mu0}, POINT_ORDER)


@dataclass(frozen=True, kw_only=True)
class _Axes:
    """Values of a grid's axes as tables have them; those of μ0 exact, too."""

    theta: frozenset[float]
    eta: frozenset[float]
    dx0: frozenset[float]
    mountings: frozenset[tuple[float | str, ...]]
    mu0: tuple[Decimal, ...]
    frictions: frozenset[float]

    @classmethod
    def of(cls, grid: Grid) -> "_Axes":
        rows = (mounting_row(mounting_of(mounting)) for mounting in grid.mountings())
        return cls(
            theta=frozenset(map(float, grid.theta)),
            eta=frozenset(map(float, grid.eta)),
            dx0=frozenset(map(float, grid.dx0)),
            mountings=frozenset(_values(row, MOUNTING_COLUMNS) for row in rows),
            mu0=grid.mu0,
            frictions=frozenset(map(float, grid.mu0)),
        )

    def have_curve(self, row: Row) -> bool:
        """Whether the curve of a row is one of the grid's."""
        mounted = _values(row, MOUNTING_COLUMNS) in self.mountings
        return mounted and row["theta"] in self.theta and row["eta"] in self.eta

    def have(self, row: Row) -> bool:
        """Whether a row is a point of the grid."""
        return row["mu0"] in self.frictions and row["dx0"] in self.dx0 and self.have_curve(row)


def _between(
    mu0: float, axis: Sequence[Decimal], closest: Decimal
) -> tuple[Decimal, Decimal] | None:
    """Two places in whose middle halving puts a point; None where it puts none there."""
    after = bisect_right(axis, mu0)
    if after in (0, len(axis)):
        return None
    start, stop = axis[after - 1], axis[after]
    while (middle := (start + stop) / 2) - start >= closest:
        if float(middle) == mu0:
            return start, stop
        start, stop = (start, middle) if mu0 < middle else (middle, stop)
    return None


def _values(row: Row, names: Sequence[str]) -> Key:
    """Values of some columns; an empty text stands for null."""
    return tuple("" if row[name] is None else row[name] for name in names)
