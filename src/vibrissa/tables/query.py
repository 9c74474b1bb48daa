"""Rows of a table in memory or in a file; only the requested parts are read.

Rows are selected by pyarrow expressions, such as `one_of` returns; ``&`` combines them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from vibrissa.tables import store
from vibrissa.tables.schemas import TABLES

if TYPE_CHECKING:
    import pandas as pd
    from pyarrow.dataset import Dataset

# A table in memory, or one in a file.
Readable: TypeAlias = "pa.Table | Dataset"
# Options that read little ahead: with the defaults, memory grows with the size of the table.
FEW_AT_ONCE: dict[str, Any] = {"use_threads": False, "batch_readahead": 1, "fragment_readahead": 1}
# Number of rows in a batch: as texts they take some 50 MB.
ROWS = 8192


def opened(path: str | Path, schema: pa.Schema, study_part: str | None = None) -> Dataset:
    """Open a table without reading its rows; with `study_part`, refuse one that is not current."""
    # Imported here, as it imports pandas, which takes time.
    from pyarrow import dataset

    if study_part is not None:
        store.need_current(path, study_part)
    schema = schema.with_metadata(store.opened(path, schema).schema_arrow.metadata)
    options = dataset.ParquetFragmentScanOptions(page_checksum_verification=True, pre_buffer=False)
    format = dataset.ParquetFileFormat(default_fragment_scan_options=options)
    with store.reading(path):
        return dataset.dataset(path, schema, format=format)


def opened_tables(paths: Mapping[str, Any], study_parts: Mapping[str, str]) -> dict[str, Readable]:
    """Open the tables of a study by name, and refuse tables that are not current."""
    return {
        name: opened(path, TABLES[name], study_parts[name])
        for name, path in paths.items()
        if name in study_parts
    }


def one_of(column: str, values: Iterable[float | str]) -> pc.Expression:
    """Return the condition that a column has one of `values`."""
    return pc.field(column).isin(list(values))


def batches(
    table: Readable, columns: Sequence[str], where: pc.Expression | None = None
) -> Iterator[pa.Table]:
    """Yield the selected rows of a table in batches; a file is read a few batches at a time."""
    if isinstance(table, pa.Table):
        yield rows(table, columns, where)
        return
    (path,) = table.files
    with store.reading(path):
        options = {"columns": list(columns), "filter": where, "batch_size": ROWS, **FEW_AT_ONCE}
        for batch in table.to_batches(**options):
            yield pa.Table.from_batches([batch])


def rows(table: Readable, columns: Sequence[str], where: pc.Expression | None = None) -> pa.Table:
    """Return the selected rows as one table."""
    if isinstance(table, pa.Table):
        return (table if where is None else table.filter(where)).select(list(columns))
    (path,) = table.files
    with store.reading(path):
        return table.to_table(columns=list(columns), filter=where, **FEW_AT_ONCE)


def frame(
    table: Readable, columns: Sequence[str], where: pc.Expression | None = None
) -> pd.DataFrame:
    """Return the selected rows as a DataFrame."""
    return rows(table, columns, where).to_pandas()


def spaced(table: Readable, columns: Sequence[str], most: int) -> pd.DataFrame:
    """Return at most `most` rows of a table, equally spaced by row number."""
    places = np.linspace(0, count(table) - 1, min(count(table), most)).astype(int)
    kept, begin = [], 0
    for part in batches(table, columns):
        here = places - begin
        kept.append(part.take(here[(here >= 0) & (here < len(part))]))
        begin += len(part)
    return pa.concat_tables(kept).to_pandas()


def count(table: Readable) -> int:
    """Count the rows of a table."""
    return int(table.num_rows if isinstance(table, pa.Table) else table.count_rows())
