"""Whether a table of grid points has each point of its study once, found out as it passes.

Points of the axes are compared with the grids as the table passes. Points that refinement added are
compared with the account of their block, before. That none stands twice is asked of all.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cache, lru_cache
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc

from vibrissa.decimals import Value, exact, spell
from vibrissa.errors import DamagedTableError, TableError
from vibrissa.study.grid import AXES, CurveKey, CurvePoints, Grid, study_points
from vibrissa.tables import store
from vibrissa.tables.added import account_of, added_points
from vibrissa.tables.collect import Key, key_of, rows_below
from vibrissa.tables.mounted import MOUNTING_COLUMNS, mounting_of, mounting_row
from vibrissa.tables.schemas import ADDED_TO, CURVATURE_POWERS, STICTION
from vibrissa.wording import counted

# What tells points apart, in the order of their table.
POINT_ORDER = ("eta", "theta", *MOUNTING_COLUMNS, "mu0", "dx0")
# Points that a message names.
EXAMPLES = 3
# Expected points that are made at a time, at least.
ROWS = 2**14

# Names of grids, beside the point.
_NAMES = ("grids", ADDED_TO.name)
_POINT = pa.schema([STICTION.field(name) for name in (*POINT_ORDER, *_NAMES)])


class Problem(StrEnum):
    """What may be wrong with points, in the words of the message."""

    MISSING = "lacks {}"
    DOUBLED = "has {} more than once"
    FOREIGN = "has {} too many"
    MISNAMED = "has {} with the names of other grids"


def checked_points(
    parts: Iterable[pa.Table], grids: Mapping[str, Grid], refined: Set[str] = frozenset()
) -> Iterator[pa.Table]:
    """Pass on a table of grid points, and refuse it in the end if points are not as they should be.

    Parameters
    ----------
    parts : iterable of pyarrow.Table
        With the schema `STICTION`, in `POINT_ORDER`.
    grids : mapping of Grid
        The study's grids by name.
    refined : set of str, optional
        Names of those to which points are added; of these points `check_refined` tells which.

    Yields
    ------
    pyarrow.Table
        The parts.

    Raises
    ------
    TableError
        If a point of the grids is missing, stands twice, does not belong or names other grids, or
        a point that was added stands twice; with examples.
    """
    expected = _tables(study_points(grids))
    found = wanted = _POINT.empty_table()
    wrong = {problem: _Wrong() for problem in Problem}
    for part in parts:
        yield part
        found = pa.concat_tables([found, part.select(_POINT.names)])
        if len(found):
            # The last point waits for the next part, where it may stand again.
            last = key_of(found, -1, POINT_ORDER)
            compared, found = _split(found, last)
            due, wanted = _split(_read_up_to(last, wanted, expected), last)
            _compare(compared, due, refined, wrong)
    for rest in chain([wanted], expected):
        _compare(found, rest, refined, wrong)
        found = found.slice(len(found))
    for problem, points in wrong.items():
        if points.count:
            reason = _reason(problem, counted(points.count, "grid point"), points.examples)
            raise TableError(f"stiction {reason}; delete the study's blocks folder and run again")


def check_refined(path: str | Path, refining: Mapping[str, Any]) -> None:
    """Refuse a block that was refined otherwise, or has other added points than it says.

    Parameters
    ----------
    path : str or Path
        Parquet file of the schema `STICTION`, with `vibrissa.tables.added.refined_metadata` if
        points were to be added.
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
    account = account_of(file)
    if account["refining"] != refining:
        raise DamagedTableError(path, "was refined in another way than the study asks for")
    with store.reading(path):
        table = store.completed(file.read(_POINT.names), _POINT)
    added = table.filter(pc.is_valid(table[ADDED_TO.name]))
    wanted = pa.concat_tables([_POINT.empty_table(), *_tables(added_points(account))])
    for problem, keys in _problems(added, added, wanted).items():
        if keys:
            reason = _reason(problem, counted(len(keys), "added point"), keys[:EXAMPLES])
            raise DamagedTableError(path, reason)


def _reason(problem: Problem, count: str, points: Iterable[Key]) -> str:
    """Say what is wrong, and name a few of the points by their values of `POINT_ORDER`."""
    rows = [dict(zip(POINT_ORDER, key, strict=True)) for key in points]
    names: tuple[str, ...] = AXES
    if any(row[axis] for row in rows for axis in MOUNTING_COLUMNS):
        names += MOUNTING_COLUMNS
    each = ("(" + ", ".join(_spelled(row[name]) for name in names) + ")" for row in rows)
    return f"{problem.format(count)}, such as ({', '.join(names)}) = {', '.join(each)}"


def _spelled(value: float | str) -> str:
    return repr(value) if isinstance(value, str) else spell(exact(value))


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


def _compare(
    found: pa.Table, wanted: pa.Table, refined: Set[str], wrong: Mapping[Problem, _Wrong]
) -> None:
    """Note what is wrong with the points that were found in one range of keys."""
    own = _without_added(found, refined)
    if len(own) < len(found) or not own.equals(wanted):
        for problem, keys in _problems(found, own, wanted).items():
            points = wrong[problem]
            points.count += len(keys)
            points.examples += keys[: EXAMPLES - len(points.examples)]


def _without_added(table: pa.Table, refined: Set[str]) -> pa.Table:
    """Points as they are without those grids that refinement added them to."""
    added_to = table[ADDED_TO.name]
    if added_to.null_count == len(table):  # as in most studies
        return table
    gone = [refined & set(names or ()) for names in added_to.to_pylist()]
    for name in _NAMES:
        rows = zip(table[name].to_pylist(), gone, strict=True)
        left = [[one for one in names or () if one not in lost] or None for names, lost in rows]
        place, column = table.column_names.index(name), _POINT.field(name)
        table = table.set_column(place, column, pa.array(left, column.type))
    return table.filter(pc.is_valid(table["grids"]))


def _tables(points: Iterable[tuple[CurveKey, CurvePoints]]) -> Iterator[pa.Table]:
    """Points on some curves, some thousands at a time."""
    pairs_of = cache(_pairs)
    curves: list[CurveKey] = []
    pairs: list[pa.Table] = []
    rows = 0
    for key, on_curve in points:
        curves.append(key)
        pairs.append(pairs_of(on_curve))
        rows += len(on_curve)
        if rows >= ROWS:
            yield _points(curves, pairs)
            curves, pairs, rows = [], [], 0
    if curves:
        yield _points(curves, pairs)


def _pairs(points: CurvePoints) -> pa.Table:
    """Points of a curve without its key."""
    columns = {
        "mu0": [float(mu0) for mu0 in points.mu0],
        "dx0": [float(dx0) for dx0 in points.dx0],
        "grids": points.grids,
        ADDED_TO.name: points.added_to,
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


def _problems(found: pa.Table, own: pa.Table, wanted: pa.Table) -> dict[Problem, list[Key]]:
    """Keys of points that are not as they should be, by what is wrong with them.

    Those that are compared with what is `wanted` may be fewer than those of which none may stand
    twice.
    """
    keys = list(POINT_ORDER)
    rows, mine, points = map(_frame, (found, own, wanted))
    pairs = points.merge(mine, on=keys, how="outer", suffixes=("", "_found"), indicator="side")
    both = pairs["side"] == "both"
    wrong = {
        Problem.MISSING: pairs[pairs["side"] == "left_only"],
        Problem.DOUBLED: rows[rows.duplicated(keys)].drop_duplicates(keys),
        Problem.FOREIGN: pairs[pairs["side"] == "right_only"],
        Problem.MISNAMED: pairs[both & (pairs["names"] != pairs["names_found"])],
    }
    return {
        problem: list(rows[keys].itertuples(index=False, name=None))
        for problem, rows in wrong.items()
    }


def _frame(table: pa.Table) -> pd.DataFrame:
    """Keys of points, an empty text for null, and the names of their grids as one text."""
    texts = (pc.fill_null(pc.binary_join(table[name], ", "), "") for name in _NAMES)
    names = pc.binary_join_element_wise(*texts, "; ")
    points = table.select(POINT_ORDER).append_column("names", names).to_pandas()
    # pandas 3 cannot merge by its own texts where there are no rows.
    powers = points[CURVATURE_POWERS.name].astype(object).fillna("")
    return points.assign(**{CURVATURE_POWERS.name: powers})
