"""One table of many: parts are merged into one order and checked on their way, piece by piece.

Nothing here holds more than the pieces, row groups of the parts, that overlap in their order.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyarrow as pa

from vibrissa.arrays import BoolArray, FloatArray
from vibrissa.grid import Grid, Pairs, study_points
from vibrissa.tables import STICTION, Stored, TableError

# Order of the table of grid points.
POINT_ORDER = ("eta", "theta", "mu0", "dx0")
EXAMPLES = 3
PROBLEMS = ("missing", "doubled", "not in the study", "of other grids")
Key = tuple[float, ...]


_PAIR = pa.schema([STICTION.field(name) for name in ("mu0", "dx0", "grids")])
_SCHEMA = pa.schema([STICTION.field("eta"), STICTION.field("theta"), *_PAIR])


@dataclass(frozen=True)
class Collected:
    """Many tables as one.

    Attributes
    ----------
    schema : pyarrow.Schema
        With the commits of the code that made the parts, as parts are kept when the code changes
        elsewhere.
    rows : int
        How many there are.
    parts : iterator of pyarrow.Table
        The rows, one below the other.
    """

    schema: pa.Schema
    rows: int
    parts: Iterator[pa.Table]


class _Piece(NamedTuple):
    """A row group of a file, and the least key in it."""

    first: Key
    file: int
    group: int


def collect(paths: Sequence[str | Path], schema: pa.Schema, order: Sequence[str] = ()) -> Collected:
    """Put tables of one schema one below the other, or merge them by some columns.

    Parameters
    ----------
    paths : sequence of path
    schema : pyarrow.Schema
    order : sequence of str, optional
        Columns of numbers, the most important first; without any, the tables stay as they are.

    Returns
    -------
    Collected

    Raises
    ------
    TableError
        If one of the files is not what it should be.
    """
    commits, rows, pieces = set(), 0, []
    for number, path in enumerate(paths):
        stored = Stored(path, schema)
        commits.add(stored.schema.metadata.get(b"vibrissa.commit", b"unknown"))
        rows += len(stored)
        for group in range(stored.groups):
            first = _least(stored.group(group, order)) if order else ()
            pieces.append(_Piece(first, number, group))
    told = {b"vibrissa.part_commits": b" ".join(sorted(commits))}
    parts = _merged(_read_in_turn(sorted(pieces), paths, schema), order)
    return Collected(schema.with_metadata({**schema.metadata, **told}), rows, parts)


def _read_in_turn(
    pieces: Sequence[_Piece], paths: Sequence[str | Path], schema: pa.Schema
) -> Iterator[tuple[Key, pa.Table]]:
    """Pieces with their least keys, with one file open at a time."""
    number, stored = -1, None
    for piece in pieces:
        if stored is None or piece.file != number:
            number, stored = piece.file, Stored(paths[piece.file], schema, checked=True)
        yield piece.first, stored.group(piece.group).replace_schema_metadata(schema.metadata)


def _merged(pieces: Iterable[tuple[Key, pa.Table]], order: Sequence[str]) -> Iterator[pa.Table]:
    """Merge pieces that come in the order of their least keys."""
    held = None
    for first, rows in pieces:
        if held is not None:
            # Whatever comes from here on is not less than `first`.
            final = int(np.count_nonzero(_less(_keys(held, order), first))) if order else len(held)
            yield held.slice(0, final)
            if final < len(held):
                rows = pa.concat_tables([held.slice(final), rows])
        held = _in_order(rows, order)
    if held is not None:
        yield held


def _keys(table: pa.Table, order: Sequence[str]) -> list[FloatArray]:
    return [table.column(name).to_numpy() for name in order]


def _less(keys: Sequence[FloatArray], bound: Key) -> BoolArray:
    """Which keys are less than another one."""
    less = np.zeros(len(keys[0]), dtype=bool)
    equal = ~less
    for values, other in zip(keys, bound, strict=True):
        less |= equal & (values < other)
        equal &= values == other
    return less


def _least(table: pa.Table) -> Key:
    keys = _keys(table, table.column_names)
    row = np.lexsort(keys[::-1])[0]
    return tuple(float(values[row]) for values in keys)


def _in_order(table: pa.Table, order: Sequence[str]) -> pa.Table:
    keys = _keys(table, order)
    # Most pieces are sorted already.
    falls, equal = np.zeros(max(0, len(table) - 1), dtype=bool), True
    for values in keys:
        falls |= equal & (values[1:] < values[:-1])
        equal = equal & (values[1:] == values[:-1])
    return table.sort_by([(name, "ascending") for name in order]) if falls.any() else table


def checked_points(parts: Iterable[pa.Table], grids: Mapping[str, Grid]) -> Iterator[pa.Table]:
    """Pass on a table of grid points, and refuse it in the end if points are not as they should be.

    Parameters
    ----------
    parts : iterable of pyarrow.Table
        With the schema `STICTION`, in `POINT_ORDER`.
    grids : mapping of Grid
        The study's grids by name.

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
    check = _PointCheck(grids)
    for part in parts:
        check.take(part)
        yield part
    check.finish()


class _PointCheck:
    """Compares grid points with those of a study, curve by curve, as they come."""

    def __init__(self, grids: Mapping[str, Grid]) -> None:
        self._expected = (
            (float(eta), float(theta), pairs) for theta, eta, pairs in study_points(grids)
        )
        self._next = next(self._expected, None)
        self._held = _SCHEMA.empty_table()
        # Pairs of μ0 and Δx0 as they stand in the table, made once for each set of grids.
        self._columns: dict[int, pa.Table] = {}
        self._counts: Counter[str] = Counter()
        self._examples: dict[str, list[Key]] = {}

    def take(self, part: pa.Table) -> None:
        """Compare the next points; those of the last curve may go on in the part to come."""
        columns = part.select(_SCHEMA.names).replace_schema_metadata()
        held = pa.concat_tables([self._held, columns]).combine_chunks()
        if not len(held):
            return
        eta, theta = _keys(held, ("eta", "theta"))
        changes = (theta[1:] != theta[:-1]) | (eta[1:] != eta[:-1])
        starts = [0, *(np.flatnonzero(changes) + 1).tolist()]
        for start, stop in pairwise(starts):
            self._compare(float(eta[start]), float(theta[start]), held.slice(start, stop - start))
        self._held = held.slice(starts[-1])

    def finish(self) -> None:
        """Compare what is left, and refuse what is wrong."""
        if len(self._held):
            eta, theta = _keys(self._held, ("eta", "theta"))
            self._compare(float(eta[0]), float(theta[0]), self._held)
        while self._next is not None:
            self._pass_over()
        for problem in PROBLEMS:
            if count := self._counts[problem]:
                shown = ", ".join(
                    f"({', '.join(f'{value:g}' for value in point)})"
                    for point in self._examples[problem]
                )
                raise TableError(
                    f"stiction: {count} grid points are {problem}, such as (theta, mu0, eta, "
                    f"dx0) = {shown}; delete the study's blocks folder and run again"
                )

    def _compare(self, eta: float, theta: float, rows: pa.Table) -> None:
        """Compare the points of one curve."""
        while self._next is not None and self._next[:2] < (eta, theta):
            self._pass_over()
        wanted: dict[Key, list[str]] = {}
        if self._next is not None and self._next[:2] == (eta, theta):
            pairs = self._next[2]
            self._next = next(self._expected, None)
            if rows.select(_PAIR.names).equals(self._expected_columns(pairs)):
                return
            wanted = dict(zip(_floats(pairs), pairs.grids, strict=True))
        columns = [rows.column(name).to_pylist() for name in _PAIR.names]
        found = [((mu0, dx0), names) for mu0, dx0, names in zip(*columns, strict=True)]
        counts = Counter(pair for pair, _ in found)
        self._note("missing", eta, theta, [pair for pair in wanted if pair not in counts])
        self._note("doubled", eta, theta, [pair for pair, n in counts.items() if n > 1])
        self._note("not in the study", eta, theta, [pair for pair in counts if pair not in wanted])
        others = [pair for pair, names in found if names != wanted.get(pair, names)]
        self._note("of other grids", eta, theta, others)

    def _pass_over(self) -> None:
        """Note that the points of the next curve are missing."""
        if self._next is not None:
            eta, theta, pairs = self._next
            self._note("missing", eta, theta, _floats(pairs))
            self._next = next(self._expected, None)

    def _note(self, problem: str, eta: float, theta: float, pairs: Sequence[Key]) -> None:
        self._counts[problem] += len(pairs)
        examples = self._examples.setdefault(problem, [])
        examples += [(theta, mu0, eta, dx0) for mu0, dx0 in pairs[: EXAMPLES - len(examples)]]

    def _expected_columns(self, pairs: Pairs) -> pa.Table:
        if id(pairs) not in self._columns:
            values = [list(map(float, pairs.mu0)), list(map(float, pairs.dx0)), pairs.grids]
            self._columns[id(pairs)] = pa.table(values, schema=_PAIR)
        return self._columns[id(pairs)]


def _floats(pairs: Pairs) -> list[Key]:
    return [(float(mu0), float(dx0)) for mu0, dx0 in zip(pairs.mu0, pairs.dx0, strict=True)]
