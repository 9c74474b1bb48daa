"""Tables of a schema, from their columns."""

from collections.abc import Mapping, Sequence, Sized
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from vibrissa.tables.schemas import FLAG, NUMBER, NUMBERS, TEXT, TEXTS, WHOLE

_TYPES = {NUMBER: np.float64, WHOLE: np.int64, FLAG: np.bool_}


def array(values: Any, kind: pa.DataType) -> pa.Array:
    """Convert a list or a NumPy array to an Arrow array; None, and NaN of an array, become null.

    The buffers of all kinds but lists of texts are laid out here, by the Arrow columnar format:
    `pyarrow.array` loads pandas, a third of a second in each job that solves points or scans.
    """
    if kind == TEXTS:
        return pa.array(values, kind)
    if isinstance(values, np.ndarray) and values.dtype.kind == "f":
        missing = np.isnan(values)
    else:
        values = values.tolist() if isinstance(values, np.ndarray) else values
        missing = np.array([value is None for value in values], dtype=bool)
    validity = _bits(~missing)
    if kind in _TYPES:
        given = np.where(missing, 0, values)
        data: NDArray[Any] = given.astype(_TYPES[kind])
        if kind == WHOLE and (data != given).any():
            raise ValueError(f"a column of whole numbers has other values: {values}")
        buffer = _bits(data) if kind == FLAG else pa.py_buffer(data)
        return pa.Array.from_buffers(kind, len(missing), [validity, buffer])
    if kind == TEXT:
        texts = [b"" if value is None else value.encode() for value in values]
        buffers = [validity, _starts(texts), pa.py_buffer(b"".join(texts))]
        return pa.Array.from_buffers(kind, len(texts), buffers)
    if kind != NUMBERS:
        raise TypeError(f"no column has the type {kind}")
    lists = [() if value is None else value for value in values]
    numbers = np.concatenate([np.empty(0), *lists])
    items = pa.Array.from_buffers(NUMBER, len(numbers), [None, pa.py_buffer(numbers)])
    return pa.Array.from_buffers(kind, len(lists), [validity, _starts(lists)], children=[items])


def _starts(parts: Sequence[Sized]) -> pa.Buffer:
    """Places at which parts begin that follow each other, and the end of the last."""
    lengths = np.fromiter(map(len, parts), np.int64, len(parts))
    return pa.py_buffer(np.append(0, np.cumsum(lengths)).astype(np.int32))


def _bits(flags: NDArray[np.bool_]) -> pa.Buffer:
    return pa.py_buffer(np.packbits(flags, bitorder="little"))


def table_of(schema: pa.Schema, columns: Mapping[str, Any]) -> pa.Table:
    """Make a table of a schema from its columns: lists or NumPy arrays."""
    arrays = [array(columns[field.name], field.type) for field in schema]
    return pa.Table.from_arrays(arrays, schema=schema)
