"""Tables of a schema, from their columns."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pyarrow as pa

from vibrissa.tables.schemas import WHOLE


def array(values: Any, kind: pa.DataType) -> pa.Array:
    """Convert a list, or a NumPy or Arrow array, to an Arrow array; NaN becomes null."""
    if isinstance(values, pa.Array):
        return values
    if isinstance(values, np.ndarray) and values.dtype.kind == "f":
        # The option from_pandas does the same, but loads pandas.
        missing = np.isnan(values)
        if kind == WHOLE:
            values = np.where(missing, 0.0, values).astype(np.int64)
        return pa.array(values, kind, mask=missing)
    return pa.array(values.tolist() if isinstance(values, np.ndarray) else values, kind)


def table_of(schema: pa.Schema, columns: Mapping[str, Any]) -> pa.Table:
    """Make a table of a schema from its columns: lists, or NumPy or Arrow arrays."""
    arrays = [array(columns[field.name], field.type) for field in schema]
    return pa.Table.from_arrays(arrays, schema=schema)
