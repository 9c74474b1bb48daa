"""Tables as pandas has them, with what their columns are."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pyarrow as pa

from vibrissa.errors import TableError
from vibrissa.tables import schemas, store

if TYPE_CHECKING:
    import pandas as pd


def read_table(path: str | Path) -> pd.DataFrame:
    """Read a table that a study made.

    Parameters
    ----------
    path : str or Path
        Parquet file in ``results/<study>/tables``, or a copy of it.

    Returns
    -------
    DataFrame
        Its ``attrs`` are ``table``, the kind of table; ``units`` and ``descriptions`` by column;
        and ``version`` and ``commit`` of the program that wrote the file.

    Raises
    ------
    TableError
        If the file is damaged, is no table of this program or version, or cannot be opened.
    """
    kind = store.kind(path)
    if kind not in schemas.TABLES:
        raise TableError(
            f"{path} is not a table of vibrissa; those are in results/<study>/tables, named "
            f"{', '.join(f'{name}.parquet' for name in schemas.TABLES)}"
        )
    table = store.read(path, schemas.TABLES[kind])
    frame = to_pandas(table)
    frame.attrs = {
        "table": kind,
        "units": _said(table, schemas.UNIT),
        "descriptions": _said(table, schemas.DESCRIPTION),
        "version": table.schema.metadata[b"vibrissa.version"].decode(),
        "commit": table.schema.metadata[b"vibrissa.commit"].decode(),
    }
    return frame


def swung_aside(steps: pd.DataFrame) -> pd.Series:
    """Whether a round rod has swung aside, in each step of scans: its end then points back.

    A rod that stays in its plane, whose margin out of it is not known, does not swing.
    """
    return (steps["phi1"] > 0.5 * math.pi) & steps["stability_aside"].notna()


def to_pandas(table: pa.Table) -> pd.DataFrame:
    """Convert to pandas; whole numbers and flags stay what they are where a row has none."""
    return table.to_pandas(types_mapper=_nullable)


def _nullable(kind: pa.DataType) -> Any:
    import pandas as pd

    return {
        schemas.WHOLE: pd.Int64Dtype(),
        schemas.FLAG: pd.BooleanDtype(),
        schemas.TEXT: pd.StringDtype(),
    }.get(kind)


def _said(table: pa.Table, key: bytes) -> dict[str, str]:
    return {column.name: column.metadata[key].decode() for column in table.schema}
