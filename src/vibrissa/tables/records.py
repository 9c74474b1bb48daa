"""Results of computations as tables: a row for each step, state or comparison."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa

from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import Solver, Status
from vibrissa.sticking.piece import StickingState
from vibrissa.study.axes import FREQUENCIES
from vibrissa.tables.schemas import COMPARISONS, SHAPE, STATE, STATES, WHOLE

# For annotations alone: a job then depends only on the code that computes its own results.
if TYPE_CHECKING:
    from vibrissa.sticking.api import EquilibriumState


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


def state_values(state: StickingState, suffix: str = "") -> dict[str, Any]:
    """Return the values of states for the columns `STATE`, whose names get the `suffix`."""
    return {f"{column.name}{suffix}": getattr(state, column.name) for column in STATE}


def frequency_values(frequencies: FloatArray) -> dict[str, FloatArray]:
    """Return the values for the columns `FREQUENCIES` of n states, from an array (n, count).

    Columns beyond `count` are NaN.
    """
    missing = np.full(len(frequencies), np.nan)
    columns = [*frequencies.T, *[missing] * len(FREQUENCIES)]
    return dict(zip(FREQUENCIES, columns, strict=False))


def comparison_table(name: str, compared: Mapping[str, Any], study: str) -> pa.Table:
    """Make the table of the points that `vibrissa.sticking.comparison.compare` returns."""
    same = {"comparison": name, "study": study, "method": Solver.COLLOCATION}
    repeated = {key: [value] * len(compared["theta"]) for key, value in same.items()}
    return table_of(COMPARISONS, {**compared, **repeated})


def states_table(
    states: Mapping[str, EquilibriumState], study: str, frequencies: int = 0
) -> pa.Table:
    """Make the table of single equilibria with their shapes.

    `frequencies` is the number of natural frequencies to compute in each state.
    """
    columns: dict[str, list[Any]] = {field.name: [] for field in STATES}
    s = np.linspace(0.0, 1.0, 101)
    for name, state in states.items():
        solved = state.status is Status.SOLVED
        shape = (s, *state.shape(s)) if solved else ([], [], [], [])
        values: dict[str, Any] = {"study": study, "method": Solver.COLLOCATION, "state": name}
        values |= zip((column.name for column in SHAPE), shape, strict=True)
        values |= dict.fromkeys(FREQUENCIES)
        if solved and frequencies:
            found = state.frequencies(frequencies)
            # An unstable state has none.
            known_ones = [None if np.isnan(one) else float(one) for one in found]
            values |= zip(FREQUENCIES, known_ones, strict=False)
        for field in STATES:
            known = solved or not field.nullable
            value = values[field.name] if field.name in values else getattr(state, field.name)
            columns[field.name].append(value if known else None)
    return table_of(STATES, columns)
