"""Condensed tables of a folder of results, small enough to compare in a diff."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa

from vibrissa.errors import ComparisonError
from vibrissa.study.axes import MOUNTING_COLUMNS
from vibrissa.tables import query, schemas
from vibrissa.tables.counts import SCAN
from vibrissa.tables.frames import to_pandas
from vibrissa.tables.query import Readable

# Tables of a study that are compared.
TABLES = ("stiction", "scans", "periods", "friction", "states", "comparisons")
_ROD = ["theta", "eta", *MOUNTING_COLUMNS]
# Columns of a condensed cycle: column of its steps, and how the values of the steps are combined.
_CYCLE = {
    "status": ("status", "last"),
    "steps": ("step", "max"),
    "slips": ("is_slip", "sum"),
    "footpoint_end": ("footpoint", "last"),
    "x0_largest": ("x0", "max"),
    "x1_begin": ("x1", "first"),
    "x1_end": ("x1", "last"),
    "f_largest": ("f", "max"),
    "alpha_smallest": ("alpha", "min"),
    "phi1_smallest": ("phi1", "min"),
    "m_smallest": ("reaction_m", "min"),
    "m_largest": ("reaction_m", "max"),
    "fx_smallest": ("reaction_fx", "min"),
    "fy_smallest": ("reaction_fy", "min"),
    "stability_smallest": ("stability", "min"),
    "stability_aside_smallest": ("stability_aside", "min"),
    "middle_x_mean": ("middle_x", "mean"),
    "middle_y_mean": ("middle_y", "mean"),
    "top": ("top", "max"),
}


def condensed_parts(folder: Path) -> dict[str, Iterator[pd.DataFrame]]:
    """Read the tables in a folder of results a part at a time, condensed.

    The result maps names to the parts of tables, of which each has at least one. ``stiction``,
    ``periods``, ``friction`` and ``comparisons`` have all rows of the table of the same name.
    ``curves`` has the first row of ``stiction`` for each rod, ``scans`` one row for each stick-slip
    cycle, and ``states`` one row for each state. A table exists only if the study has it.

    Raises
    ------
    ComparisonError
        If the folder has no tables.
    """
    paths = {name: folder / f"tables/{name}.parquet" for name in TABLES}
    found = {
        name: query.opened(path, schemas.TABLES[name])
        for name, path in paths.items()
        if path.is_file()
    }
    if not found:
        raise ComparisonError(f"the folder {folder} has no tables; run the study first")
    result: dict[str, Iterator[pd.DataFrame]] = {
        name: map(to_pandas, _filled(found[name]))
        for name in ("stiction", "periods", "friction", "comparisons")
        if name in found
    }
    if "stiction" in found:
        result["curves"] = _curves(found["stiction"])
    if "scans" in found:
        result["scans"] = _cycles(found["scans"])
    if "states" in found:
        result["states"] = _without_shapes(found["states"])
    return result


def _filled(table: Readable) -> Iterator[pa.Table]:
    """Yield the rows of a table in batches; one without rows if there are none."""
    yield from (
        query.batches(table, table.schema.names)
        if query.count(table)
        else [table.schema.empty_table()]
    )


def _curves(table: Readable) -> Iterator[pd.DataFrame]:
    """Yield the first row of each rod."""
    seen: set[tuple[Any, ...]] = set()
    for part in _filled(table):
        rows = to_pandas(part).drop_duplicates(_ROD)
        # Missing values are not equal to each other.
        rods = list(rows[_ROD].astype(object).fillna("").itertuples(index=False, name=None))
        yield rows[[rod not in seen for rod in rods]]
        seen.update(rods)


def _cycles(table: Readable) -> Iterator[pd.DataFrame]:
    """Yield a row for each cycle of the scans in a table of steps."""
    keys, begun = [*SCAN, "cycle"], pd.DataFrame()
    for part in _without_shapes(table):
        steps = pd.concat([begun, part], ignore_index=True)
        # The steps of a cycle follow each other; the last one may go on in the next part.
        number = steps.groupby(keys, dropna=False, sort=False).ngroup()
        last = number == number.max()
        if not last.all():
            yield _by_cycle(steps[~last], keys)
        begun = steps[last]
    yield _by_cycle(begun, keys)


def _by_cycle(steps: pd.DataFrame, keys: list[str]) -> pd.DataFrame:
    """Combine the steps of each cycle."""
    slips = (steps["phase"] == "slip").fillna(False).astype(int)
    cycles = steps.assign(is_slip=slips).groupby(keys, dropna=False)
    return cycles.agg(**_CYCLE).reset_index()


def _without_shapes(table: Readable) -> Iterator[pd.DataFrame]:
    """Yield parts with the middle point and largest height of shapes in place of coordinates."""
    for part in _filled(table):
        rows = to_pandas(part)
        for axis in "xy":
            shapes = rows.pop(f"shape_{axis}")
            middles = [shape[len(shape) // 2] if len(shape) else np.nan for shape in shapes]
            rows[f"middle_{axis}"] = middles
        rows["top"] = [max(shape, default=np.nan) for shape in shapes]
        yield rows.drop(columns=["shape_s", "shape_phi"])
