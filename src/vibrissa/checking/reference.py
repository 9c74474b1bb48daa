"""Comparison of the results of a study with a reference, and update of the reference."""

import difflib
import json
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import pandas as pd

from vibrissa.checking import texts
from vibrissa.checking.condensing import condensed
from vibrissa.checking.differences import Difference, compare, moved
from vibrissa.checking.enclosures import Enclosed, enclosed, refuted, verdict
from vibrissa.checking.layouts import Layout
from vibrissa.errors import ComparisonError
from vibrissa.wording import counted, markdown_table

# Differences that a summary shows.
MOST_ROWS = 30


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Results, their reference, and the numbers that have an enclosure."""

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
        return sum(map(len, self.found.values()))

    @property
    def verdict(self) -> str:
        """Last line: unchanged, or the number of differences."""
        if self.differences:
            number = counted(len(self.differences), "difference")
            return f"CHANGED: {number} between {self.results} and {self.reference}."
        return f"Unchanged: all {self.rows} rows of {self.results} agree with {self.reference}."

    def blessed(self) -> dict[str, pd.DataFrame]:
        """Return the reference tables that `bless` would write."""
        return {
            name: blessed_table(self.stored.get(name), text, self.layouts[name])
            for name, text in self.found.items()
        }

    def diff(self) -> str:
        """Return what `bless` would change, as a patch for ``git apply``.

        Paths count from the root of the reference's repository, or else from its folder.
        """
        new = self.blessed()
        command = ["git", "-C", str(self.reference), "rev-parse", "--show-prefix"]
        prefix = subprocess.run(command, capture_output=True, text=True).stdout.rstrip("\n")
        lines: list[str] = []
        for name in sorted(self.stored.keys() | new):
            before, after = (
                texts.csv(tables[name]).splitlines(keepends=True) if name in tables else []
                for tables in (self.stored, new)
            )
            # After the tab may stand a date: with it git takes spaces for a part of the name.
            path = f"{prefix}{name}.csv\t"
            old = f"a/{path}" if before else "/dev/null"
            lines += difflib.unified_diff(before, after, old, f"b/{path}" if after else "/dev/null")
        return "".join(lines)

    def markdown(self) -> str:
        """Summary for people."""
        mark = "❌" if self.differences else "✅"
        lines = [f"## {mark} Study {self.results.name}: reference tables", "", self.verdict]
        if self.differences:
            rows = [
                [one.table, one.column, one.problem, str(one.rows or ""), one.text]
                for one in self.differences[:MOST_ROWS]
            ]
            head = ("table", "column", "what", "rows", "largest change")
            lines += ["", markdown_table(head, rows)]
        if more := len(self.differences[MOST_ROWS:]):
            lines += ["", f"And {more} more; check.json has all of them."]
        return "\n".join([*lines, "", verdict(self.enclosed)]).rstrip() + "\n"

    def json(self) -> str:
        """All differences, for programs."""
        content = {
            "passed": not self.differences,
            "verdict": self.verdict,
            "results": self.results.as_posix(),
            "reference": self.reference.as_posix(),
            "rows": self.rows,
            "proved": len(self.enclosed),
            "differences": [asdict(one) for one in self.differences],
        }
        return json.dumps(content, indent=2, allow_nan=False) + "\n"


def compare_folders(results: Path, reference: Path, layouts: Mapping[str, Layout]) -> Comparison:
    """Compare the results of a study with reference tables or with other results.

    Parameters
    ----------
    reference : Path
        Folder with CSV files, or another folder of results; without any table every one is new.

    Raises
    ------
    ComparisonError
        If there are no results, or a reference table cannot be read.
    """
    frames = condensed(results)
    found = _as_texts(frames, layouts)
    if (reference / "tables").is_dir():
        stored = _as_texts(condensed(reference), layouts)
    else:
        paths = sorted(reference.glob("*.csv"))
        stored = {path.stem: texts.read(path) for path in paths if path.stem in layouts}
    differences = [
        Difference(table=name, problem="table gone", text=f"{name}: the whole table is missing")
        for name in sorted(stored.keys() - found)
    ]
    for name, text in found.items():
        if name in stored:
            differences += compare(stored[name], text, layouts[name], name)
        else:
            line = f"{name}: a new table of {len(text)} rows"
            differences.append(Difference(table=name, problem="table new", text=line))
    numbers = enclosed(frames, reference, layouts)
    return Comparison(
        results=results,
        reference=reference,
        layouts=layouts,
        stored=stored,
        found=found,
        differences=[*differences, *refuted(numbers)],
        enclosed=numbers,
    )


def _as_texts(
    frames: Mapping[str, pd.DataFrame], layouts: Mapping[str, Layout]
) -> dict[str, pd.DataFrame]:
    return {
        name: texts.as_text(frame, layouts[name])
        for name, frame in frames.items()
        if name in layouts
    }


def bless(comparison: Comparison) -> None:
    """Rewrite the reference tables, and remove those of tables that the study no longer has."""
    comparison.reference.mkdir(parents=True, exist_ok=True)
    for name, text in comparison.blessed().items():
        texts.write(text, comparison.reference / f"{name}.csv")
    for name in comparison.stored.keys() - comparison.found:
        (comparison.reference / f"{name}.csv").unlink()


def blessed_table(
    reference: pd.DataFrame | None, found: pd.DataFrame, layout: Layout
) -> pd.DataFrame:
    """Build a reference table; values within their tolerance keep their former digits."""
    keys = list(layout.keys)
    if reference is None or set(keys) - set(reference):
        return found
    result = found.set_index(keys)
    old = reference.drop_duplicates(keys).set_index(keys).reindex(result.index)
    for column, tolerance in layout.columns.items():
        if column in old:
            known = old[column].notna().to_numpy()
            before = old[column].where(known, "")
            stays = known & ~moved(before, result[column], tolerance)
            result[column] = result[column].where(~stays, before)
    return result.reset_index()


def need_reference(comparison: Comparison) -> None:
    """Raise an error if there is no reference.

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
