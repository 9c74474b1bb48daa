"""Whether the points that refinement added to a table of grid points are where they can be.

Halving adds a value in the middle between two others, of the grid's axis or added before it. So a
point that is in no such middle is foreign, and where one of the two others is not there, it is
missing. A curve that was added has all points of the grid's μ0 and Δx0. That a value is missing
next to which nothing was added cannot be seen without solving curves. So each block says in its
metadata how it was refined, and which points it got.
"""

import json
from bisect import bisect_right
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from enum import StrEnum
from itertools import groupby, islice
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from vibrissa.decimals import exact, spell
from vibrissa.errors import DamagedTableError
from vibrissa.study.codec import decode_axis, decode_key, encode_axis, encode_key
from vibrissa.study.grid import AXES, CurveKey, CurvePoints, Grid, Refinement
from vibrissa.tables import store
from vibrissa.tables.collect import Key
from vibrissa.tables.mounted import MOUNTING_COLUMNS, mounting_of, mounting_row
from vibrissa.tables.schemas import ADDED_TO, STICTION
from vibrissa.wording import counted

# What tells curves apart; and points, in the order of the table of grid points.
CURVE_ORDER = ("eta", "theta", *MOUNTING_COLUMNS)
POINT_ORDER = (*CURVE_ORDER, "mu0", "dx0")
# Points that a message names.
EXAMPLES = 3
# In the metadata of a block: how it was refined, which points were added, and what is left over.
ACCOUNT = b"vibrissa.refining"
Row = Mapping[str, Any]


class Problem(StrEnum):
    """What may be wrong with a grid point, in the words of the message."""

    MISSING = "missing"
    DOUBLED = "doubled"
    FOREIGN = "not in the study"
    MISNAMED = "of other grids"


Fault = tuple[Problem, Key]


def shown(points: Iterable[Key]) -> str:
    """Name the first few of some points, each by its values of `POINT_ORDER`."""
    rows = [dict(zip(POINT_ORDER, key, strict=True)) for key in islice(points, EXAMPLES)]
    names: tuple[str, ...] = AXES
    if any(row[axis] for row in rows for axis in MOUNTING_COLUMNS):
        names += MOUNTING_COLUMNS
    each = ("(" + ", ".join(_spelled(row[name]) for name in names) + ")" for row in rows)
    return f"({', '.join(names)}) = {', '.join(each)}"


def _spelled(value: float | str) -> str:
    return repr(value) if isinstance(value, str) else spell(exact(value))


def refined_metadata(
    refining: Mapping[str, Any],
    points: Iterable[tuple[CurveKey, CurvePoints]],
    left: Iterable[tuple[str, str, Decimal]],
) -> dict[bytes, bytes]:
    """Metadata of a block: how it was refined, which points were added, and what is left over.

    Parameters
    ----------
    refining : mapping
        How, in plain values as JSON has them.
    points : iterable of (CurveKey, CurvePoints)
        All points of the block, curve by curve.
    left : iterable of (str, str, Decimal)
        Grid and axis of each line that is not within the tolerance everywhere, and the length of
        its gaps that are not.

    Returns
    -------
    dict of bytes
        For `check_refined` and `refined_summary`.
    """
    lines = []
    for key, on_curve in points:
        frictions: dict[Decimal, list[Decimal]] = {}
        for mu0, dx0, names in zip(on_curve.mu0, on_curve.dx0, on_curve.added_to, strict=True):
            if names:
                frictions.setdefault(dx0, []).append(mu0)
        lines += [[encode_key(key), spell(dx0), encode_axis(mu0)] for dx0, mu0 in frictions.items()]
    said = {
        "refining": refining,
        "added": lines,
        "left": [[grid, axis, spell(length)] for grid, axis, length in left],
    }
    return {ACCOUNT: json.dumps(said).encode()}


def check_refined(path: str | Path, refining: Mapping[str, Any]) -> None:
    """Refuse a block that was refined otherwise, or has other added points than it says.

    Parameters
    ----------
    path : str or Path
        Parquet file of the schema `STICTION`, with `refined_metadata`.
    refining : mapping
        How it is to be refined.

    Raises
    ------
    DamagedTableError
        With the points. The file must be deleted.
    TableError
        If it cannot be opened.
    """
    file = store.opened(path, STICTION)
    said = _said(file)
    if said.get("refining") != refining:
        raise DamagedTableError(path, "was refined in another way than the study asks for")
    with store.reading(path):
        table = file.read([*POINT_ORDER, ADDED_TO.name])
    rows = table.filter(pc.is_valid(table[ADDED_TO.name])).to_pylist()
    found = {_values(row, POINT_ORDER) for row in rows}
    wanted = {point for line in said["added"] for point in _points_of(*line)}
    for what, points in (("lacks", wanted - found), ("has no account of", found - wanted)):
        if points:
            count = counted(len(points), "point")
            reason = f"{what} {count} that refine added, such as {shown(sorted(points))}"
            raise DamagedTableError(path, reason)


def _said(file: pq.ParquetFile) -> dict[str, Any]:
    """Read what a block says about its refinement; see `refined_metadata`."""
    return json.loads((file.schema_arrow.metadata or {}).get(ACCOUNT, b"{}"))


def refined_summary(paths: Iterable[str | Path]) -> str:
    """Say how many points were added to some blocks, and what is not within the tolerance.

    Parameters
    ----------
    paths : iterable of path
        Parquet files, of which `check_refined` accepts each.

    Returns
    -------
    str
        One line.
    """
    added = 0
    left: dict[tuple[str, str], list[Decimal]] = {}
    for path in paths:
        said = _said(store.opened(path, STICTION))
        added += sum(len(decode_axis(frictions)) for *_, frictions in said["added"])
        for grid, axis, length in said["left"]:
            left.setdefault((grid, axis), []).append(exact(length))
    if not added:
        return (
            "refine added no points: straight lines between those of the axes are within the "
            "tolerance, closest allows none, or there are no values"
        )
    found = [
        f"up to {spell(max(lengths))} of {axis} on {counted(len(lengths), 'line')} of {grid}"
        for (grid, axis), lengths in sorted(left.items())
    ]
    more = f"; not within the tolerance at closest: {', '.join(found)}" if found else ""
    return f"refine added {counted(added, 'point')}{more}"


def _points_of(key: Sequence[str], dx0: str, frictions: Sequence[str]) -> Iterator[Key]:
    """Points of a line of `refined_metadata`."""
    curve = decode_key(key)
    row = {
        **mounting_row(mounting_of(curve.mounting)),
        "eta": float(curve.eta),
        "theta": float(curve.theta),
        "dx0": float(exact(dx0)),
    }
    for mu0 in decode_axis(frictions):
        yield _values({**row, "mu0": float(mu0)}, POINT_ORDER)


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
    # Of each grid and axis, and of all else that a curve has: added values, each with a row.
    _curves: dict[tuple[str, str, Key], dict[float, Row]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Prepare what is asked of each row."""
        self._axes = {
            name: _Axes.of(grid, self.refinements.get(name)) for name, grid in self.grids.items()
        }

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
        """Find what is wrong on the last curve, and which curves are missing."""
        yield from self._of_curve(self._held)
        for (name, axis, _), found in self._curves.items():
            row = next(iter(found.values()))
            for value in sorted(self._axes[name].needed(axis, found) - found.keys()):
                yield Problem.MISSING, _values({**row, axis: value}, POINT_ORDER)

    def _of_curve(self, rows: Sequence[Row]) -> Iterator[Fault]:
        of_grids: dict[str, list[Row]] = {}
        for row in rows:
            having = {name for name, axes in self._axes.items() if axes.have(row)}
            if having != set(row["grids"]) - set(row["added_to"]):
                yield Problem.MISNAMED, _values(row, POINT_ORDER)
            for name in row["added_to"]:
                of_grids.setdefault(name, []).append(row)
        for name, some in of_grids.items():
            axes, one = self._axes.get(name), some[0]
            along = axes.curve_axis(one) if axes else None
            if axes is None or not (along or axes.have_curve(one)):
                yield from ((Problem.FOREIGN, _values(row, POINT_ORDER)) for row in some)
                continue
            if along:
                across = tuple(column for column in CURVE_ORDER if column != along)
                place = (name, along, _values(one, across))
                self._curves.setdefault(place, {})[one[along]] = one
            yield from axes.faults(some, is_added=along is not None)


@dataclass(frozen=True, kw_only=True)
class _Axes:
    """Axes of a grid, exact and as tables have them, and how close values may be added to them."""

    exact: Mapping[str, Sequence[Decimal]]
    values: Mapping[str, frozenset[float]]
    mountings: frozenset[Key]
    closest: Mapping[str, Decimal]

    @classmethod
    def of(cls, grid: Grid, refinement: Refinement | None) -> "_Axes":
        rows = (mounting_row(mounting_of(mounting)) for mounting in grid.mountings())
        exact = {axis: getattr(grid, axis) for axis in AXES}
        return cls(
            exact=exact,
            values={axis: frozenset(map(float, values)) for axis, values in exact.items()},
            mountings=frozenset(_values(row, MOUNTING_COLUMNS) for row in rows),
            closest=refinement.closest if refinement else {},
        )

    def on_axis(self, axis: str, row: Row) -> bool:
        """Whether a row's value is one of the grid's axis."""
        return row[axis] in self.values[axis]

    def have_curve(self, row: Row) -> bool:
        """Whether the curve of a row is one of the grid's."""
        mounted = _values(row, MOUNTING_COLUMNS) in self.mountings
        return mounted and self.on_axis("theta", row) and self.on_axis("eta", row)

    def have(self, row: Row) -> bool:
        """Whether a row is a point of the grid."""
        return self.have_curve(row) and self.on_axis("mu0", row) and self.on_axis("dx0", row)

    def curve_axis(self, row: Row) -> str | None:
        """Axis along which halving adds the curve of a row; None where it adds none."""
        for axis, across in (("theta", "eta"), ("eta", "theta")):
            mounted = _values(row, MOUNTING_COLUMNS) in self.mountings
            if mounted and self.on_axis(across, row) and self._between(axis, row[axis]):
                return axis
        return None

    def faults(self, rows: Sequence[Row], is_added: bool) -> Iterator[Fault]:
        """Find what is wrong with the points of one curve that were added to the grid."""
        own = self.values["mu0"] if is_added else frozenset()
        lines: dict[float, Counter[float]] = {dx0: Counter() for dx0 in self.values["dx0"]}
        for row in rows:
            is_foreign = not (row["mu0"] in own or self._between("mu0", row["mu0"]))
            if is_foreign or not self.on_axis("dx0", row):
                yield Problem.FOREIGN, _values(row, POINT_ORDER)
                continue
            lines[row["dx0"]][row["mu0"]] += 1
            if lines[row["dx0"]][row["mu0"]] == 2:
                yield Problem.DOUBLED, _values(row, POINT_ORDER)
        for dx0, found in lines.items():
            for mu0 in sorted((own | self.needed("mu0", found)) - found.keys()):
                yield Problem.MISSING, _values({**rows[0], "mu0": mu0, "dx0": dx0}, POINT_ORDER)

    def needed(self, axis: str, values: Iterable[float]) -> set[float]:
        """Values between which halving adds some, and which are not on the grid's axis."""
        return {end for v in values for end in self._between(axis, v)} - self.values[axis]

    def _between(self, axis: str, value: float) -> tuple[float, ...]:
        """Two values in whose middle halving adds one; nothing where it adds none there."""
        values = self.exact[axis]
        after = bisect_right(values, value)
        if axis not in self.closest or after in (0, len(values)):
            return ()
        start, stop = values[after - 1], values[after]
        while (middle := (start + stop) / 2) - start >= self.closest[axis]:
            if float(middle) == value:
                return float(start), float(stop)
            start, stop = (start, middle) if value < middle else (middle, stop)
        return ()


def _values(row: Row, names: Sequence[str]) -> Key:
    """Values of some columns; an empty text stands for null."""
    return tuple("" if row[name] is None else row[name] for name in names)
