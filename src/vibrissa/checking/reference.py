"""The results of a study beside reference tables: compared, or put in their place."""

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from vibrissa.checking import texts
from vibrissa.checking.condensing import condensed
from vibrissa.checking.differences import Difference, Problem, compare, moved
from vibrissa.checking.enclosures import Enclosed, enclosed, refuted
from vibrissa.checking.layouts import Layout
from vibrissa.errors import ComparisonError


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Results beside reference tables.

    Attributes
    ----------
    results, reference : Path
        The folders.
    layouts : mapping of Layout
        By table.
    stored, found : mapping of DataFrame of str
        Tables of the reference and of the results.
    differences : sequence of Difference
    enclosed : sequence of Enclosed
        Numbers of the results for which the reference has an enclosure.
    """

    results: Path
    reference: Path
    layouts: Mapping[str, Layout]
    stored: Mapping[str, pd.DataFrame]
    found: Mapping[str, pd.DataFrame]
    differences: Sequence[Difference]
    enclosed: Sequence[Enclosed] = ()

    @property
    def rows(self) -> int:
        """Number of rows of the results that are compared."""
        return sum(len(text) for text in self.found.values())

    @property
    def verdict(self) -> str:
        """One line that says how the comparison ended."""
        if self.differences:
            number = len(self.differences)
            return f"{number} differences between {self.results} and {self.reference}"
        return f"Nothing moved: {self.results} has the {self.rows} rows of {self.reference}."

    def blessed(self) -> dict[str, pd.DataFrame]:
        """Return the reference tables that `bless` would write."""
        return {
            name: blessed_table(self.stored.get(name), text, self.layouts[name])
            for name, text in self.found.items()
        }

    def diff(self) -> str:
        """Return what `bless` would change in the reference tables, as a patch."""
        new = self.blessed()
        lines: list[str] = []
        for name in sorted(self.stored.keys() | new):
            path = (self.reference / f"{name}.csv").as_posix()
            before, after = (
                _csv(tables[name]).splitlines(keepends=True) if name in tables else []
                for tables in (self.stored, new)
            )
            lines += difflib.unified_diff(
                before,
                after,
                f"a/{path}" if before else "/dev/null",
                f"b/{path}" if after else "/dev/null",
                n=0,
            )
        return "".join(lines)


def compare_folders(results: Path, reference: Path, layouts: Mapping[str, Layout]) -> Comparison:
    """Compare the results of a study with reference tables.

    Parameters
    ----------
    results : Path
        ``results/<study>``.
    reference : Path
        Folder with CSV files.
    layouts : mapping of Layout
        What each reference table holds.

    Returns
    -------
    Comparison
        If there is no reference table, every table is new.

    Raises
    ------
    ComparisonError
        If there are no results, or a reference table cannot be read.
    TableError
        If a table is damaged.
    """
    frames = condensed(results)
    found = {
        name: texts.as_text(frame, layouts[name], name)
        for name, frame in frames.items()
        if name in layouts
    }
    stored = {
        path.stem: texts.read(path)
        for path in sorted(reference.glob("*.csv"))
        if path.stem in layouts
    }
    differences = [
        Difference(table=name, problem=Problem.GONE, text=f"{name}: the whole table is missing")
        for name in sorted(stored.keys() - found)
    ]
    for name, text in found.items():
        if name in stored:
            differences += compare(stored[name], text, layouts[name], name)
        else:
            line = f"{name}: a new table of {len(text)} rows"
            rows = len(text)
            differences.append(Difference(table=name, problem=Problem.NEW, rows=rows, text=line))
    numbers = enclosed(frames, reference, layouts)
    differences += refuted(numbers)
    return Comparison(
        results=results,
        reference=reference,
        layouts=layouts,
        stored=stored,
        found=found,
        differences=differences,
        enclosed=numbers,
    )


def bless(comparison: Comparison) -> None:
    """Write the reference tables anew, and remove those that the study has no more."""
    comparison.reference.mkdir(parents=True, exist_ok=True)
    for name, text in comparison.blessed().items():
        texts.write(text, comparison.reference / f"{name}.csv")
    for name in comparison.stored.keys() - comparison.found:
        (comparison.reference / f"{name}.csv").unlink()


def blessed_table(
    reference: pd.DataFrame | None, found: pd.DataFrame, layout: Layout
) -> pd.DataFrame:
    """Make a reference table anew, in which what did not move keeps its spelling.

    Parameters
    ----------
    reference : DataFrame of str or None
        The table that is there.
    found : DataFrame of str
    layout : Layout

    Returns
    -------
    DataFrame of str
    """
    keys = list(layout.keys)
    if reference is None or set(keys) - set(reference):
        return found
    result = found.set_index(keys)
    old = reference.drop_duplicates(keys).set_index(keys).reindex(result.index)
    for column, tolerance in layout.columns.items():
        if column in old:
            stays = old[column].notna().to_numpy()
            before = old[column].where(stays, "")
            stays = stays & ~moved(before, result[column], tolerance)
            result[column] = result[column].where(~stays, before)
    return result.reset_index()


def need_reference(comparison: Comparison) -> None:
    """Refuse to compare with nothing.

    Raises
    ------
    ComparisonError
        If there is no reference table.
    """
    if not comparison.stored:
        raise ComparisonError(
            f"{comparison.reference} has no reference tables; make them with: make bless, and the "
            "same STUDY and REFERENCE"
        )


def _csv(table: pd.DataFrame) -> str:
    return table.to_csv(index=False, lineterminator="\n")
