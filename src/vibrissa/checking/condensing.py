"""The few tables, with one row for each key, that a results folder is condensed to."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa

from vibrissa.errors import ComparisonError
from vibrissa.tables import schemas, store
from vibrissa.tables.frames import to_pandas


def condensed(folder: Path) -> dict[str, pd.DataFrame]:
    """Condense the tables of a results folder; see `condense`.

    Parameters
    ----------
    folder : Path
        ``results/<study>``.

    Returns
    -------
    dict of DataFrame
        By name of the reference table.

    Raises
    ------
    ComparisonError
        If there are no results.
    TableError
        If a table is damaged.
    """
    if not (folder / "tables/stiction.parquet").is_file():
        raise ComparisonError(f"{folder} has no tables/stiction.parquet; run the study first")
    found = {
        name: store.read(path, schemas.TABLES[name])
        for name in ("stiction", "scans", "states")
        if (path := folder / f"tables/{name}.parquet").is_file()
    }
    return condense(found)


def condense(found: Mapping[str, pa.Table]) -> dict[str, pd.DataFrame]:
    """Condense tables to what is compared.

    Parameters
    ----------
    found : mapping of pyarrow.Table
        ``stiction`` and, where the study has them, ``scans`` and ``states``.

    Returns
    -------
    dict of DataFrame
        ``stiction``; ``curves``, one row for each θ and η; ``scans``, one row for each cycle;
        ``states``.
    """
    rows = to_pandas(found["stiction"])
    of_curve = [
        "study",
        "method",
        "theta",
        "eta",
        "x1_init",
        "mu_lock",
        *(n for n in rows if n.endswith("_init")),
    ]
    result = {
        "stiction": rows,
        "curves": rows[list(dict.fromkeys(of_curve))].drop_duplicates(),
    }
    if "scans" in found:
        result["scans"] = _cycles(found["scans"])
    if "states" in found:
        states = to_pandas(found["states"])
        result["states"] = states.assign(top=[_largest(shape) for shape in states["shape_y"]])
    return result


def _largest(values: Any) -> float:
    return max(values, default=np.nan)


def _cycles(table: pa.Table) -> pd.DataFrame:
    """One row for each cycle of each scan."""
    rows = to_pandas(table)
    # Of each shape where its middle is and how high it reaches.
    rows["middle_x"] = [shape[len(shape) // 2] if len(shape) else np.nan for shape in rows.shape_x]
    rows["middle_y"] = [shape[len(shape) // 2] if len(shape) else np.nan for shape in rows.shape_y]
    rows["top"] = [_largest(shape) for shape in rows.shape_y]
    keys = ["scan", "theta", "mu0", "eta", "dx0", "cycle"]
    return (
        rows.groupby(keys, dropna=False)
        .agg(
            study=("study", "last"),
            method=("method", "last"),
            status=("status", "last"),
            steps=("step", "max"),
            slips=("phase", lambda phase: int((phase == "slip").sum())),
            footpoint_end=("footpoint", "last"),
            x0_largest=("x0", "max"),
            x1_begin=("x1", "first"),
            x1_end=("x1", "last"),
            f_largest=("f", "max"),
            alpha_smallest=("alpha", "min"),
            phi1_smallest=("phi1", "min"),
            m_smallest=("reaction_m", "min"),
            m_largest=("reaction_m", "max"),
            middle_x_mean=("middle_x", "mean"),
            middle_y_mean=("middle_y", "mean"),
            top=("top", "max"),
        )
        .reset_index()
    )
