"""One table of many files, merged into one order.

Nothing here holds more than the row groups of the files that overlap in their order.
"""

from bisect import bisect_left
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from operator import attrgetter
from pathlib import Path
from threading import get_ident
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from vibrissa.ahead import ahead
from vibrissa.numerics.arrays import IntArray
from vibrissa.tables import store

# Files that are open at a time.
OPEN_FILES = 16
# Values of the columns that a table is ordered by.
Key = tuple[float | str, ...]


@dataclass(frozen=True, kw_only=True)
class Collected:
    """Many tables as one.

    Attributes
    ----------
    schema : pyarrow.Schema
        With the commits of the code that made the files, as files are kept when the code changes
        elsewhere.
    rows : int
        How many there are.
    parts : iterator of pyarrow.Table
        The rows, one below the other.
    """

    schema: pa.Schema
    rows: int
    parts: Iterator[pa.Table]


class _RowGroup(NamedTuple):
    """A row group of a file, and the least key in it."""

    least: Key
    path: str | Path
    number: int


class _File(NamedTuple):
    """A file: the commit of the code that made it, its rows and its row groups."""

    commit: bytes
    rows: int
    groups: list[_RowGroup]


def collect(
    paths: Sequence[str | Path], schema: pa.Schema, order: Sequence[str] = (), threads: int = 1
) -> Collected:
    """Put tables of one schema one below the other, or merge them by some columns.

    Parameters
    ----------
    paths : sequence of path
    schema : pyarrow.Schema
    order : sequence of str, optional
        Columns of numbers or texts, the most important first; without any, the tables stay as they
        are.
    threads : int, optional
        In which files are read.

    Returns
    -------
    Collected

    Raises
    ------
    TableError
        If one of the files is damaged, holds another kind of table or cannot be opened.
    """
    files = list(ahead(partial(_file, schema=schema, order=order), paths, threads))
    groups = sorted((group for file in files for group in file.groups), key=attrgetter("least"))
    # Each thread has files of its own: two cannot read from the same one at a time.
    opened = lru_cache(OPEN_FILES * threads)(lambda _, path: store.opened(path, schema))

    def read(group: _RowGroup) -> tuple[Key, pa.Table]:
        with store.reading(group.path):
            table = opened(get_ident(), group.path).read_row_group(group.number, use_threads=False)
        return group.least, _in_order(store.completed(table, schema), order)

    told = {b"vibrissa.part_commits": b" ".join(sorted({file.commit for file in files}))}
    return Collected(
        schema=schema.with_metadata({**schema.metadata, **told}),
        rows=sum(file.rows for file in files),
        parts=_merged(ahead(read, groups, threads), order),
    )


def _file(path: str | Path, schema: pa.Schema, order: Sequence[str]) -> _File:
    """Look for the row groups of a file."""
    store.check_file(path)
    file = store.opened(path, schema)
    groups = []
    with store.reading(path):
        for number in range(file.num_row_groups):
            keys = file.read_row_group(number, order, use_threads=False)
            least = _least_key(store.completed(keys, _part(schema, order)), order)
            groups.append(_RowGroup(least, path, number))
    return _File(
        commit=file.schema_arrow.metadata.get(b"vibrissa.commit", b"unknown"),
        rows=file.metadata.num_rows,
        groups=groups,
    )


def _part(schema: pa.Schema, names: Sequence[str]) -> pa.Schema:
    return pa.schema([schema.field(name) for name in names])


def _merged(parts: Iterable[tuple[Key, pa.Table]], order: Sequence[str]) -> Iterator[pa.Table]:
    """Merge tables, each in order, that come in the order of their least keys."""
    held = None
    for least, table in parts:
        if held is not None:
            # No row that is still to come is less than this.
            final = rows_below(held, least, order) if order else len(held)
            yield held.slice(0, final)
            if final < len(held):
                table = _in_order(pa.concat_tables([held.slice(final), table]), order)
        held = table
    if held is not None:
        yield held


def _sorted_rows(table: pa.Table, order: Sequence[str]) -> IntArray:
    return np.lexsort([_sortable(table.column(name)) for name in reversed(order)])


def _sortable(column: pa.ChunkedArray) -> Any:
    """Values of a column as they are sorted: no text comes before all others."""
    if not pa.types.is_string(column.type):
        return column.to_numpy()
    # NumPy sorts numbers faster than texts, and most of these are null.
    texts = sorted(set(column.fill_null("").unique().to_pylist()))
    return pc.index_in(column.fill_null(""), pa.array(texts, pa.string())).to_numpy()


def _least_key(table: pa.Table, order: Sequence[str]) -> Key:
    return key_of(_in_order(table, order), 0, order) if order else ()


def _in_order(table: pa.Table, order: Sequence[str]) -> pa.Table:
    # Most are in order already, and to look takes a tenth of the time of sorting.
    return table if _is_in_order(table, order) else table.take(_sorted_rows(table, order))


def _is_in_order(table: pa.Table, order: Sequence[str]) -> bool:
    """Whether no row comes after one whose key is larger."""
    goes_on = np.ones(max(len(table) - 1, 0), dtype=bool)
    for name in reversed(order):
        values = _sortable(table.column(name))
        before, after = values[:-1], values[1:]
        goes_on = (before < after) | ((before == after) & goes_on)
    return bool(goes_on.all())


def key_of(table: pa.Table, row: int, order: Sequence[str]) -> Key:
    """Key of a row; an empty text stands for null."""
    values = (table.column(name)[row].as_py() for name in order)
    return tuple("" if value is None else value for value in values)


def rows_below(table: pa.Table, bound: Key, order: Sequence[str]) -> int:
    """Count the rows, of a table in order, whose keys are less than another one."""
    return bisect_left(range(len(table)), bound, key=lambda row: key_of(table, row, order))
