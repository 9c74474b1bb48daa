"""Condensed tables of a folder of results, small enough to compare in a diff."""

from pathlib import Path

import numpy as np
import pandas as pd

from vibrissa.errors import ComparisonError
from vibrissa.study.axes import MOUNTING_AXES
from vibrissa.tables import query, schemas
from vibrissa.tables.counts import SCAN
from vibrissa.tables.frames import to_pandas
from vibrissa.tables.query import Readable

# Tables of a study that are compared.
TABLES = ("stiction", "scans", "periods", "states", "comparisons")
_ROD = ["theta", "eta", *MOUNTING_AXES, "curvature_powers"]
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


def condensed(folder: Path) -> dict[str, pd.DataFrame]:
    """Read the tables in a folder of results, condensed enough to compare them in a diff.

    The result maps names to tables. ``stiction``, ``periods`` and ``comparisons`` have all rows of
    the table of the same name. ``curves`` has the first row of ``stiction`` for each rod, ``scans``
    one row for each stick-slip cycle, and ``states`` one row for each state. ``scans``,
    ``periods``, ``states`` and ``comparisons`` exist only if the study has them.
    """
    paths = {name: folder / f"tables/{name}.parquet" for name in TABLES}
    found = {
        name: query.opened(path, schemas.TABLES[name])
        for name, path in paths.items()
        if path.is_file()
    }
    if "stiction" not in found:
        raise ComparisonError(
            f"the folder {folder} has no file tables/stiction.parquet; run the study first"
        )
    result: dict[str, pd.DataFrame] = {
        name: to_pandas(query.rows(found[name], found[name].schema.names))
        for name in ("stiction", "periods", "comparisons")
        if name in found
    }
    result["curves"] = result["stiction"].drop_duplicates(_ROD)
    if "scans" in found:
        steps = _without_shapes(found["scans"])
        steps["is_slip"] = (steps["phase"] == "slip").fillna(False).astype(int)
        cycles = steps.groupby([*SCAN, "cycle"], dropna=False)
        result["scans"] = cycles.agg(**_CYCLE).reset_index()
    if "states" in found:
        result["states"] = _without_shapes(found["states"])
    return result


def _without_shapes(table: Readable) -> pd.DataFrame:
    """Replace the coordinates of each shape by its middle point and its largest height."""
    parts = []
    for part in query.batches(table, table.schema.names):
        rows = to_pandas(part)
        for axis in "xy":
            shapes = rows.pop(f"shape_{axis}")
            middles = [shape[len(shape) // 2] if len(shape) else np.nan for shape in shapes]
            rows[f"middle_{axis}"] = middles
        rows["top"] = [max(shape, default=np.nan) for shape in shapes]
        parts.append(rows)
    return pd.concat(parts)
