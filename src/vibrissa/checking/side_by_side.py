"""Two results folders side by side: what differs in their study files, rows and numbers.

The folders are called A and B; a change is from A to B.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
import pandas as pd
import yaml

from vibrissa.checking.condensing import opened_tables, summaries
from vibrissa.checking.differences import (
    Change,
    Difference,
    Matched,
    Problem,
    change_at,
    changes,
    moved_column,
)
from vibrissa.checking.layouts import Layout
from vibrissa.checking.texts import spelled
from vibrissa.errors import ComparisonError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.tables import query, schemas, store
from vibrissa.tables.frames import to_pandas
from vibrissa.tables.query import Readable
from vibrissa.wording import counted

# Tables that are compared, as `condensed` reads them.
TABLES = ("stiction", "scans", "states")
# Rows with the largest changes that a page shows, and the most frequent changes of an outcome.
WORST, OUTCOMES = 10, 3
# Every row has the study's name; it is compared as a part of the study file.
STUDY = "study"


@dataclass(frozen=True, kw_only=True)
class Origin:
    """What the tables of a results folder say of where they come from.

    Attributes
    ----------
    study : mapping of str
        Values of the study file by their keys, such as ``grids.taper.theta.start``.
    programs : mapping of str
        Version and commit of the program, by table.
    """

    study: Mapping[str, str]
    programs: Mapping[str, str]


@dataclass(frozen=True, kw_only=True)
class Moved:
    """A column that moved.

    Attributes
    ----------
    table, column : str
    numbers : int
        Rows that are a finite number on both sides.
    shares : array, shape (5,)
        Least, quartiles and largest of the relative changes of these; empty without any.
    worst : sequence of Change
        The largest of them, in order.
    outcomes : sequence of str
        Most frequent changes of words, as ``slip -> lock (12)``; numbers have none.
    """

    table: str
    column: str
    numbers: int
    shares: FloatArray
    worst: Sequence[Change] = ()
    outcomes: Sequence[str] = ()

    @classmethod
    def of(cls, table: str, column: str, values: pd.DataFrame) -> Self:
        """Condense the values that moved, as `Matched.moved` has them."""
        _, shares = changes(values)
        finite = np.flatnonzero(np.isfinite(shares))
        if not len(finite):
            counts = values.value_counts(["before", "after"])[:OUTCOMES]
            outcomes = [
                f"{before or 'nothing'} -> {after or 'nothing'} ({number})"
                for (before, after), number in counts.items()
            ]
            return cls(table=table, column=column, numbers=0, shares=np.empty(0), outcomes=outcomes)
        largest = finite[np.argsort(-shares[finite], kind="stable")][:WORST]
        worst = [change_at(values, index, float(shares[index])) for index in largest]
        return cls(
            table=table,
            column=column,
            numbers=len(finite),
            shares=np.percentile(shares[finite], [0, 25, 50, 75, 100]),
            worst=worst,
        )


@dataclass(frozen=True, kw_only=True)
class SideBySide:
    """Two results folders beside each other.

    Attributes
    ----------
    folders : tuple of Path
        A and B.
    origins : tuple of Origin
        Of A and of B.
    rows : mapping of tuple
        Number of rows in A and in B, by table; 0 where there is no such table.
    differences : sequence of Difference
        Of the tables that both have.
    moved : sequence of Moved
        A column each, as in `differences`.
    """

    folders: tuple[Path, Path]
    origins: tuple[Origin, Origin]
    rows: Mapping[str, tuple[int, int]]
    differences: Sequence[Difference]
    moved: Sequence[Moved]

    @property
    def study_changes(self) -> dict[str, tuple[str, str]]:
        """What A and B say for each key of the study file for which they differ; or nothing."""
        a, b = (origin.study for origin in self.origins)
        keys = dict.fromkeys([*a, *b])
        values = {key: (a.get(key, ""), b.get(key, "")) for key in keys}
        return {key: (before, after) for key, (before, after) in values.items() if before != after}

    @property
    def verdict(self) -> str:
        """One line that says how much is different."""
        keys, found = len(self.study_changes), self.differences
        rows = sum(one.rows for one in found if one.problem in (Problem.MISSING, Problem.EXTRA))
        a, b = self.folders
        tables = sum(1 for of_a, of_b in self.rows.values() if not of_a or not of_b)
        if not (keys or found or tables):
            return f"Nothing differs between {a} and {b}."
        alone = f", {counted(tables, 'table')} in one alone" if tables else ""
        return (
            f"{a} (A) and {b} (B): {counted(keys, 'key')} of the study file "
            f"{'differs' if keys == 1 else 'differ'}, {counted(rows, 'row')} in one alone, "
            f"{counted(len(self.moved), 'column')} moved{alone}"
        )

    def worst(self) -> list[tuple[Moved, Change]]:
        """Rows with the largest relative changes, each with the column that changed most."""
        found = [(one, change) for one in self.moved for change in one.worst]
        found.sort(key=lambda pair: -(pair[1].size or 0.0))
        rows: dict[tuple[str, ...], tuple[Moved, Change]] = {}
        for one, change in found:
            rows.setdefault((one.table, *change.row.values()), (one, change))
        return list(rows.values())[:WORST]


def side_by_side(a: Path, b: Path, layouts: Mapping[str, Layout]) -> SideBySide:
    """Compare two results folders.

    Parameters
    ----------
    a, b : Path
        ``results/<study>``.
    layouts : mapping of Layout
        Keys, columns and tolerances of each table.

    Returns
    -------
    SideBySide

    Raises
    ------
    ComparisonError
        If the two are the same folder, or one is no folder or has no results.
    TableError
        If a table is damaged or of another version.
    """
    for folder in (a, b):
        if not folder.is_dir():
            raise ComparisonError(f"{folder} is no folder; allowed: results/<study>")
    if a.resolve() == b.resolve():
        raise ComparisonError(f"A and B are the same folder, {a}; give two")
    of_a, of_b = _tables(a), _tables(b)
    names = [name for name in layouts if name in of_a or name in of_b]
    differences: list[Difference] = []
    moved: list[Moved] = []
    for name in names:
        if name in of_a and name in of_b:
            matched = _matched(of_a[name], of_b[name], layouts[name].keys)
            differences += matched.differences(name, ("A", "B"))
            compared = {key: one for key, one in layouts[name].columns.items() if key != STUDY}
            for column, tolerance in compared.items():
                values = matched.moved(
                    spelled(of_a[name][column]), spelled(of_b[name][column]), tolerance
                )
                if len(values):
                    differences.append(moved_column(name, column, values, len(matched)))
                    moved.append(Moved.of(name, column, values))
                del values  # before the next column is read
    return SideBySide(
        folders=(a, b),
        origins=(_origin(a), _origin(b)),
        rows={name: (len(of_a.get(name, ())), len(of_b.get(name, ()))) for name in names},
        differences=differences,
        moved=moved,
    )


@dataclass(frozen=True)
class _InFile:
    """A table of which a column is read when it is looked at."""

    table: Readable

    def __len__(self) -> int:
        return query.count(self.table)

    def __getitem__(self, column: str) -> pd.Series:
        return to_pandas(query.rows(self.table, [column]))[column]


def _tables(folder: Path) -> dict[str, pd.DataFrame | _InFile]:
    """Tables of a folder; only the one of grid points is long."""
    opened = opened_tables(folder)
    return {"stiction": _InFile(opened["stiction"]), **summaries(opened)}


def _matched(a: pd.DataFrame | _InFile, b: pd.DataFrame | _InFile, keys: Sequence[str]) -> Matched:
    """Match the rows of two tables, in the order of their keys in A."""
    indices = (
        pd.MultiIndex.from_arrays([spelled(table[key]) for key in keys], names=keys)
        for table in (a, b)
    )
    return Matched.of(*indices)


def _origin(folder: Path) -> Origin:
    """Read what the tables of a folder say in their metadata."""
    study: dict[str, str] = {}
    programs: dict[str, str] = {}
    for name in TABLES:
        path = folder / f"tables/{name}.parquet"
        if path.is_file():
            metadata = store.opened(path, schemas.TABLES[name]).schema_arrow.metadata
            said = {key: value.decode(errors="replace") for key, value in metadata.items()}
            study = _flat(yaml.safe_load(said.get(b"vibrissa.study", ""))) | study
            programs[name] = store.writer(said)
    return Origin(study=study, programs=programs)


def _flat(value: Any, key: str = "") -> dict[str, str]:
    """Values of nested mappings under keys with dots."""
    if not isinstance(value, dict):
        return {key: str(value)} if key else {}
    result: dict[str, str] = {}
    for name, part in value.items():
        result |= _flat(part, f"{key}.{name}" if key else str(name))
    return result
