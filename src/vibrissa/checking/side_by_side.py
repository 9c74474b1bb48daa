"""Two results folders side by side: what differs in their study files, rows and numbers.

The folders are called A and B; a change is from A to B.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml

from vibrissa.checking.condensing import condensed
from vibrissa.checking.differences import (
    Change,
    Difference,
    Problem,
    change_at,
    changes,
    compare,
    moved_values,
)
from vibrissa.checking.layouts import Layout
from vibrissa.checking.texts import as_text
from vibrissa.errors import ComparisonError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.tables import schemas, store
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
    values : DataFrame of str
        ``before`` and ``after`` of the rows that moved; the index has their keys.
    """

    table: str
    column: str
    values: pd.DataFrame

    @property
    def shares(self) -> FloatArray:
        """Relative changes; without rows that are no finite number on both sides."""
        _, relative = changes(self.values)
        return relative[np.isfinite(relative)]

    @property
    def outcomes(self) -> list[str]:
        """Most frequent changes of words, as ``slip -> lock (12 rows)``; numbers have none."""
        if len(self.shares):
            return []
        counts = self.values.value_counts(["before", "after"])[:OUTCOMES]
        return [
            f"{before or 'nothing'} -> {after or 'nothing'} ({number})"
            for (before, after), number in counts.items()
        ]


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
        found = []
        for one in self.moved:
            _, shares = changes(one.values)
            finite = np.flatnonzero(np.isfinite(shares))
            largest = finite[np.argsort(-shares[finite], kind="stable")][:WORST]
            found += [
                (one, change_at(one.values, index, float(shares[index]))) for index in largest
            ]
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
    layouts = {name: _without_study(layout) for name, layout in layouts.items()}
    texts_a, texts_b = (_texts(folder, layouts) for folder in (a, b))
    differences: list[Difference] = []
    moved: list[Moved] = []
    names = [name for name in layouts if name in texts_a or name in texts_b]
    for name in names:
        if not (name in texts_a and name in texts_b):
            continue
        tables = texts_a[name], texts_b[name]
        differences += compare(*tables, layouts[name], name, sides=("A", "B"))
        values = moved_values(*tables, layouts[name])
        moved += (Moved(table=name, column=key, values=value) for key, value in values.items())
    return SideBySide(
        folders=(a, b),
        origins=(_origin(a), _origin(b)),
        rows={name: (len(texts_a.get(name, ())), len(texts_b.get(name, ()))) for name in names},
        differences=differences,
        moved=moved,
    )


def _without_study(layout: Layout) -> Layout:
    columns = {name: value for name, value in layout.columns.items() if name != STUDY}
    return Layout(layout.keys, columns)


def _texts(folder: Path, layouts: Mapping[str, Layout]) -> dict[str, pd.DataFrame]:
    """Tables of a folder as text, in the order of the layouts."""
    frames = condensed(folder)
    return {
        name: as_text(frames[name], layout, name)
        for name, layout in layouts.items()
        if name in frames
    }


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
