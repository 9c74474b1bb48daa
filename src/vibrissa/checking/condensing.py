"""The few tables, with one row for each key, that a results folder is condensed to."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from vibrissa.errors import ComparisonError
from vibrissa.tables import query, schemas
from vibrissa.tables.frames import to_pandas
from vibrissa.tables.query import Readable


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
    return condense(opened_tables(folder))


def opened_tables(folder: Path) -> dict[str, Readable]:
    """Open the tables of a results folder that are compared; see `condensed` for errors."""
    if not (folder / "tables/stiction.parquet").is_file():
        raise ComparisonError(f"{folder} has no tables/stiction.parquet; run the study first")
    return {
        name: query.opened(path, schemas.TABLES[name])
        for name in ("stiction", "scans", "states")
        if (path := folder / f"tables/{name}.parquet").is_file()
    }


def condense(found: Mapping[str, Readable]) -> dict[str, pd.DataFrame]:
    """Condense tables to what is compared.

    Parameters
    ----------
    found : mapping of pyarrow.Table or Dataset
        ``stiction`` and, where the study has them, ``scans`` and ``states``.

    Returns
    -------
    dict of DataFrame
        ``stiction``, all rows, and the tables of `summaries`.
    """
    table = found["stiction"]
    return {"stiction": to_pandas(query.rows(table, table.schema.names)), **summaries(found)}


def summaries(found: Mapping[str, Readable]) -> dict[str, pd.DataFrame]:
    """Condense tables to few rows; of long ones no more is held than a part and what it tells.

    Parameters
    ----------
    found : mapping of pyarrow.Table or Dataset
        As in `condense`.

    Returns
    -------
    dict of DataFrame
        ``curves``, one row for each θ and η; ``scans``, one row for each cycle; ``states``.
    """
    result = {"curves": _curves(found["stiction"])}
    if "scans" in found:
        result["scans"] = _cycles(found["scans"])
    if "states" in found:
        states = found["states"]
        result["states"] = _gathered(states, states.schema.names, _with_shapes)
    return result


def _gathered(
    table: Readable, columns: Sequence[str], change: Callable[[pd.DataFrame], pd.DataFrame]
) -> pd.DataFrame:
    """Put what is made of each part of a table one below the other."""
    parts = [change(to_pandas(part)) for part in query.parts(table, columns)]
    return pd.concat(parts) if parts else change(to_pandas(query.rows(table, columns)))


def _curves(table: Readable) -> pd.DataFrame:
    """One row for each curve."""
    names = ["study", "method", "theta", "eta", "x1_init", "mu_lock"]
    names += [name for name in table.schema.names if name.endswith("_init") and name not in names]
    return _gathered(table, names, pd.DataFrame.drop_duplicates).drop_duplicates()


def _with_shapes(rows: pd.DataFrame) -> pd.DataFrame:
    """Rows with where the middle of each shape is and how high it reaches, instead of it."""
    shapes = rows["shape_x"], rows["shape_y"]
    middle = {
        name: [shape[len(shape) // 2] if len(shape) else np.nan for shape in values]
        for name, values in zip(("middle_x", "middle_y"), shapes, strict=True)
    }
    top = [max(shape, default=np.nan) for shape in rows["shape_y"]]
    return rows.drop(columns=["shape_x", "shape_y"]).assign(**middle, top=top)


def _cycles(table: Readable) -> pd.DataFrame:
    """One row for each cycle of each scan."""
    rows = _gathered(table, table.schema.names, _with_shapes)
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
