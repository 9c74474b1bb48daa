"""Comparison of the results of a study with a reference, and update of the reference.

Reference tables are CSV files, readable in a diff. For a comparison, results become texts, too.
"""

import json
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pandas as pd
from pandas.errors import ParserWarning

from vibrissa.checking import proofs
from vibrissa.checking.condensing import condensed_parts
from vibrissa.checking.differences import Difference, compare
from vibrissa.checking.tolerances import TableLayout
from vibrissa.errors import ComparisonError
from vibrissa.files import write_atomically
from vibrissa.tables import query, schemas
from vibrissa.wording import counted, markdown_table

# Significant digits of a float: fewer than a double has, more than any tolerance needs.
DIGITS = 12
# Largest number of differences in a summary.
MOST_ROWS = 30
# Number of rows that are compared together: some 50 MB of texts.
AT_ONCE = 10_000


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Comparison of results with a reference and with proofs.

    Attributes
    ----------
    results, reference : Path
        Folder of the results, and folder of the reference tables or of the other results.
    rows : int
        Number of rows in the results.
    differences : sequence of Difference
        Differences from the reference, and columns with numbers that proofs refute.
    proved : DataFrame
        Numbers that have a proof, as `proofs.proved` returns them.
    """

    results: Path
    reference: Path
    rows: int
    differences: Sequence[Difference]
    proved: pd.DataFrame

    @property
    def verdict(self) -> str:
        """One line: unchanged, or the number of differences."""
        if self.differences:
            number = counted(len(self.differences), "difference")
            return f"CHANGED: {number} between {self.results} and {self.reference}."
        return f"Unchanged: all {self.rows} rows of {self.results} agree with {self.reference}."

    def markdown(self) -> str:
        """Return a summary in Markdown."""
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
        return "\n".join([*lines, "", proofs.verdict(self.proved)]).rstrip() + "\n"

    def json(self) -> str:
        """Return the comparison with all differences as JSON."""
        content = {
            "passed": not self.differences,
            "verdict": self.verdict,
            "results": self.results.as_posix(),
            "reference": self.reference.as_posix(),
            "rows": self.rows,
            "proved": len(self.proved),
            "differences": [asdict(one) for one in self.differences],
        }
        return json.dumps(content, indent=2, allow_nan=False) + "\n"


def compare_folders(
    results: Path, reference: Path, layouts: Mapping[str, TableLayout]
) -> Comparison:
    """Compare the results of a study with reference tables or with other results.

    Parameters
    ----------
    reference : Path
        Folder with CSV files, or another folder of results.

    Raises
    ------
    ComparisonError
        If there are no results, or no readable reference tables.
    """
    parts = {name: part for name, part in condensed_parts(results).items() if name in layouts}
    stored = _stored(reference, layouts)
    if not stored:
        raise ComparisonError(
            f"{reference} has no reference tables; write them: run make bless with the same STUDY "
            "and REFERENCE"
        )
    rows, proved, differences = 0, list[pd.DataFrame](), list[Difference]()
    known = proofs.read(reference)
    for name in sorted(stored.keys() - parts):
        text = f"{name}: the whole table is missing"
        differences.append(Difference(table=name, problem="table gone", text=text))
    for name, layout in layouts.items():
        if name not in parts:
            continue
        with TemporaryDirectory() as scratch:
            number = 1 + sum(_sizes(folder, name) for folder in (results, reference)) // AT_ONCE
            found = _Spread(Path(scratch, "results"), layout, number)
            for part in parts[name]:
                found.add(as_text(part, layout))
                proved.append(proofs.proved(name, known, part, layout, reference))
            rows += found.rows
            if name in stored:
                before = _Spread(Path(scratch, "reference"), layout, number)
                for part in stored[name]:
                    before.add(part)
                pairs = ((before.part(n), found.part(n)) for n in range(number))
                differences += compare(pairs, layout, name)
            else:
                text = f"{name}: a new table of {found.rows} rows"
                differences.append(Difference(table=name, problem="table new", text=text))
    numbers = pd.concat(proved, ignore_index=True) if proved else pd.DataFrame()
    return Comparison(
        results=results,
        reference=reference,
        rows=rows,
        differences=[*differences, *proofs.refuted(numbers)],
        proved=numbers,
    )


def _stored(
    reference: Path, layouts: Mapping[str, TableLayout]
) -> dict[str, Iterator[pd.DataFrame]]:
    """Open the tables of a reference, or of other results: parts with texts, by table."""
    if (reference / "tables").is_dir():
        return {
            name: map(partial(as_text, layout=layouts[name]), parts)
            for name, parts in condensed_parts(reference).items()
            if name in layouts
        }
    paths = {name: reference / f"{name}.csv" for name in layouts}
    return {name: read_parts(path) for name, path in paths.items() if path.is_file()}


def _sizes(folder: Path, table: str) -> int:
    """Return the number of rows of a table of results that `table` is condensed from, or 0."""
    # A scan has as many cycles as periods.
    name = {"curves": "stiction", "scans": "periods"}.get(table, table)
    path = folder / f"tables/{name}.parquet"
    return query.count(query.opened(path, schemas.TABLES[name])) if path.is_file() else 0


class _Spread:
    """Rows of a table, spread over some files by their keys, so that few are in memory at a time.

    Equal keys are in the part of the same number.
    """

    def __init__(self, folder: Path, layout: TableLayout, number: int) -> None:
        self.rows = 0
        self._keys, self._names = layout.keys, [*layout.keys, *layout.columns]
        self._files = [folder / f"{n}.csv" for n in range(number)]
        folder.mkdir()

    def add(self, part: pd.DataFrame) -> None:
        """Add rows with texts."""
        self.rows += len(part)
        self._names = list(part)
        keys = [name for name in self._keys if name in part]
        place = pd.util.hash_pandas_object(part[keys], index=False) % len(self._files)
        for n, rows in part.groupby(place.to_numpy(), sort=False):
            path = self._files[int(n)]
            rows.to_csv(path, mode="a", header=not path.exists(), index=False)

    def part(self, number: int) -> pd.DataFrame:
        """Return the rows in a part."""
        if not self._files[number].exists():
            return pd.DataFrame(columns=self._names, dtype=str)
        return pd.read_csv(self._files[number], dtype=str, keep_default_na=False)


def as_text(frame: pd.DataFrame, layout: TableLayout) -> pd.DataFrame:
    """Format the columns of a layout as texts, rows sorted by its keys; missing values are empty.

    Raises
    ------
    ComparisonError
        If a column is missing.
    """
    names = [*layout.keys, *layout.columns]
    if unknown := [column for column in names if column not in frame]:
        raise ComparisonError(
            f"the tolerances name the columns {', '.join(unknown)}, but the table has only "
            f"{', '.join(frame)}"
        )
    ordered = frame.sort_values(layout.keys, ignore_index=True)
    spelled = {name: _spell_key if name in layout.keys else _spell for name in names}
    return pd.DataFrame({name: ordered[name].astype(object).map(spelled[name]) for name in names})


def _spell_key(value: Any) -> str:
    """Format a value that identifies a row: with all its digits, so that no two are alike."""
    text = _spell(value)
    is_float = isinstance(value, float | np.floating) and not pd.isna(value)
    return repr(float(value)) if is_float and float(text) != value else text


def _spell(value: Any) -> str:
    if pd.isna(value):
        return ""
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, float | np.floating):
        return f"{value + 0.0:.{DIGITS}g}"  # + 0.0 turns -0.0 into 0.0
    return str(value)


def read_parts(path: Path) -> Iterator[pd.DataFrame]:
    """Read a reference table as text, a part at a time.

    Raises
    ------
    ComparisonError
        If the file is not a table.
    """
    try:
        with warnings.catch_warnings(action="error", category=ParserWarning):  # a row is too long
            yield from pd.read_csv(
                path, dtype=str, keep_default_na=False, index_col=False, chunksize=AT_ONCE
            )
    # Pandas' own errors and undecodable bytes are ValueErrors.
    except (ValueError, ParserWarning) as error:
        raise ComparisonError(
            f"{path} is not a table ({str(error).strip()}); restore it from version control, or "
            "delete it and type make bless, which takes your results as the reference"
        ) from None


def bless(results: Path, reference: Path, layouts: Mapping[str, TableLayout]) -> None:
    """Write the results as reference tables; remove tables that the study no longer has.

    Rows are sorted by their keys, in a large table every 10,000 rows or so.

    Raises
    ------
    ComparisonError
        If there are no results, or `reference` is a folder of results.
    """
    if (reference / "tables").is_dir():
        raise ComparisonError(
            f"{reference} is a folder of results; reference tables need a folder of their own"
        )
    parts = condensed_parts(results)
    reference.mkdir(parents=True, exist_ok=True)
    for name, layout in layouts.items():
        path = reference / f"{name}.csv"
        if name not in parts:
            path.unlink(missing_ok=True)
            continue
        with write_atomically(path) as temporary:
            for number, rows in enumerate(_gathered(parts[name])):
                text = as_text(rows, layout)
                text.to_csv(
                    temporary, mode="a", header=not number, index=False, lineterminator="\n"
                )


def _gathered(parts: Iterator[pd.DataFrame]) -> Iterator[pd.DataFrame]:
    """Join the parts of a table to parts of `AT_ONCE` rows or more, and a last one."""
    some: list[pd.DataFrame] = []
    for part in parts:
        some.append(part)
        if sum(map(len, some)) >= AT_ONCE:
            yield pd.concat(some)
            some = []
    if some:
        yield pd.concat(some)
