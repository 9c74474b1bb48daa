"""Whether a table of grid points has each point of its study once, found out as it passes."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, lru_cache
from itertools import chain
from types import MappingProxyType

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from vibrissa.decimals import Value
from vibrissa.errors import TableError
from vibrissa.study.grid import CurveKey, CurvePoints, Grid, Refinement, study_points
from vibrissa.tables.added import (
    EXAMPLES,
    POINT_ORDER,
    AddedPoints,
    Fault,
    Problem,
    shown,
    without_added,
)
from vibrissa.tables.collect import Key, key_of, rows_below
from vibrissa.tables.mounted import MOUNTING_COLUMNS, mounting_of, mounting_row
from vibrissa.tables.schemas import ADDED_TO, CURVATURE_POWERS, STICTION

# Expected points that are made at a time, at least.
ROWS = 2**14

_POINT = pa.schema([STICTION.field(name) for name in (*POINT_ORDER, "grids")])
_MARKED = [*_POINT.names, ADDED_TO.name]
_NONE: Mapping[str, Refinement] = MappingProxyType({})


def checked_points(
    parts: Iterable[pa.Table],
    grids: Mapping[str, Grid],
    refinements: Mapping[str, Refinement] = _NONE,
) -> Iterator[pa.Table]:
    """Pass on a table of grid points, and refuse it in the end if points are not as they should be.

    Parameters
    ----------
    parts : iterable of pyarrow.Table
        With the schema `STICTION`, in `POINT_ORDER`.
    grids : mapping of Grid
        The study's grids by name.
    refinements : mapping of Refinement, optional
        Of those grids to which points are added; `vibrissa.tables.added` says what is found out
        about these points.

    Yields
    ------
    pyarrow.Table
        The parts.

    Raises
    ------
    TableError
        If a point of the grids is missing, stands twice, does not belong or names other grids;
        with examples.
    """
    expected = _expected(grids)
    found = wanted = _POINT.empty_table()
    wrong = {problem: _Wrong() for problem in Problem}
    added = AddedPoints(grids=grids, refinements=refinements)
    for part in parts:
        yield part
        _note(added.faults(part), wrong)
        own = without_added(part.select(_MARKED)).select(_POINT.names)
        found = pa.concat_tables([found, own])
        if len(found):
            # The last point waits for the next part, where it may stand again.
            last = key_of(found, -1, POINT_ORDER)
            compared, found = _split(found, last)
            due, wanted = _split(_read_up_to(last, wanted, expected), last)
            _compare(compared, due, wrong)
    for rest in chain([wanted], expected):
        _compare(found, rest, wrong)
        found = found.slice(len(found))
    _note(added.last_faults(), wrong)
    for problem, points in wrong.items():
        if points.count:
            raise TableError(
                f"stiction: {points.count} grid points are {problem}, "
                f"such as {shown(points.examples)}; "
                "delete the study's blocks folder and run again"
            )


@dataclass
class _Wrong:
    """Points with one problem: how many there are, and the first few."""

    count: int = 0
    examples: list[Key] = field(default_factory=list)


def _split(table: pa.Table, bound: Key) -> tuple[pa.Table, pa.Table]:
    """Rows whose keys are less than one, and the others."""
    below = rows_below(table, bound, POINT_ORDER)
    return table.slice(0, below), table.slice(below)


def _read_up_to(key: Key, held: pa.Table, more: Iterator[pa.Table]) -> pa.Table:
    """Rows that are held and as many more as it takes to reach a key."""
    while not len(held) or key_of(held, -1, POINT_ORDER) < key:
        table = next(more, None)
        if table is None:
            break
        held = pa.concat_tables([held, table])
    return held


def _compare(found: pa.Table, wanted: pa.Table, wrong: Mapping[Problem, _Wrong]) -> None:
    """Note what is wrong with the points that were found in one range of keys."""
    if not found.equals(wanted):
        for problem, keys in _problems(found, wanted).items():
            _note(((problem, key) for key in keys), wrong)


def _note(faults: Iterable[Fault], wrong: Mapping[Problem, _Wrong]) -> None:
    for problem, key in faults:
        points = wrong[problem]
        points.count += 1
        if len(points.examples) < EXAMPLES:
            points.examples.append(key)


def _expected(grids: Mapping[str, Grid]) -> Iterator[pa.Table]:
    """Points of a study in the order of its table, some thousands at a time."""
    pairs_of = cache(_pairs)
    curves: list[CurveKey] = []
    pairs: list[pa.Table] = []
    for key, points in study_points(grids):
        curves.append(key)
        pairs.append(pairs_of(points))
        if sum(map(len, pairs)) >= ROWS:
            yield _points(curves, pairs)
            curves, pairs = [], []
    if curves:
        yield _points(curves, pairs)


def _pairs(points: CurvePoints) -> pa.Table:
    """Points of a curve without its key."""
    columns = {
        "mu0": [float(mu0) for mu0 in points.mu0],
        "dx0": [float(dx0) for dx0 in points.dx0],
        "grids": points.grids,
    }
    return pa.table(columns, schema=pa.schema([STICTION.field(name) for name in columns]))


def _points(curves: Sequence[CurveKey], pairs: Sequence[pa.Table]) -> pa.Table:
    """Points of some curves, one below the other."""
    sizes = [len(table) for table in pairs]
    rest = pa.concat_tables(pairs)
    mounted = [_mounted(curve.mounting) for curve in curves]
    columns = {
        "eta": np.repeat([float(curve.eta) for curve in curves], sizes),
        "theta": np.repeat([float(curve.theta) for curve in curves], sizes),
        **{name: np.repeat([row[name] for row in mounted], sizes) for name in MOUNTING_COLUMNS},
        **dict(zip(rest.column_names, rest.columns, strict=True)),
    }
    return pa.table(columns, schema=_POINT)


# Few rods of a study are mounted in another way than the one before.
@lru_cache
def _mounted(mounting: tuple[Value, ...]) -> dict[str, float | str | None]:
    return mounting_row(mounting_of(mounting))


def _problems(found: pa.Table, wanted: pa.Table) -> dict[Problem, list[Key]]:
    """Keys of points that are not as they should be, by what is wrong with them."""
    rows, points = (
        table.set_column(len(POINT_ORDER), "grids", pc.binary_join(table["grids"], ", "))
        .to_pandas()
        .fillna({CURVATURE_POWERS.name: ""})
        for table in (found, wanted)
    )
    keys = list(POINT_ORDER)
    again = rows.duplicated(keys)
    pairs = points.merge(
        rows[~again], on=keys, how="outer", suffixes=("", "_found"), indicator="side"
    )
    both = pairs["side"] == "both"
    wrong = {
        Problem.MISSING: pairs[pairs["side"] == "left_only"],
        Problem.DOUBLED: rows[again].drop_duplicates(keys),
        Problem.FOREIGN: pairs[pairs["side"] == "right_only"],
        Problem.MISNAMED: pairs[both & (pairs["grids"] != pairs["grids_found"])],
    }
    return {
        problem: list(rows[keys].itertuples(index=False, name=None))
        for problem, rows in wrong.items()
    }
