"""Tables in pandas, and descriptions of their columns."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import pyarrow as pa

from vibrissa.errors import TableError
from vibrissa.tables import schemas, store

if TYPE_CHECKING:
    import pandas as pd


def spell_unit(unit: str) -> str:
    """Format the unit of a column for display, as in E·I0/L² for ``E*I0/L^2``."""
    return unit.replace("*", "·").replace("^2", "²").replace("rho", "ρ").replace("sqrt", "√")


def read_table(path: str | Path) -> pd.DataFrame:
    """Read a table of a study as a DataFrame.

    Parameters
    ----------
    path : str or Path
        Parquet file.

    Returns
    -------
    DataFrame
        Its ``attrs``: ``table`` (kind of table), ``units`` and ``descriptions`` (by column),
        ``version`` and ``commit`` (of the program that wrote the file).

    Raises
    ------
    TableError
        If the file is damaged, is no table of this program or version, or cannot be opened.
    """
    metadata = store.metadata(path)
    kind = metadata.get(store.TABLE, "")
    if kind not in schemas.TABLES:
        raise TableError(
            f"{path} does not hold a table of vibrissa; those are in results/<study>/tables, named "
            f"{', '.join(f'{name}.parquet' for name in schemas.TABLES)}"
        )
    table = store.read(path, schemas.TABLES[kind])
    frame = to_pandas(table)
    frame.attrs = {
        "table": kind,
        "units": _of_columns(table, schemas.UNIT),
        "descriptions": _of_columns(table, schemas.DESCRIPTION),
        "version": metadata[store.PROGRAM],
        "commit": metadata[store.COMMIT],
    }
    return frame


def laterally_buckled(steps: pd.DataFrame) -> pd.Series:
    """Mark the steps at which a round rod has buckled laterally: there φ1 > π/2."""
    return (steps["phi1"] > 0.5 * math.pi) & steps["stability_aside"].notna()


def to_pandas(table: pa.Table) -> pd.DataFrame:
    """Convert a table to pandas, with nullable integer, flag and text columns."""
    import pandas as pd

    nullable = {
        schemas.WHOLE: pd.Int64Dtype(),
        schemas.FLAG: pd.BooleanDtype(),
        schemas.TEXT: pd.StringDtype(),
    }
    return table.to_pandas(types_mapper=nullable.get)


def _of_columns(table: pa.Table, key: bytes) -> dict[str, str]:
    return {column.name: column.metadata[key].decode() for column in table.schema}
