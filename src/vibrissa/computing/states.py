"""Single equilibria as a table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa

from vibrissa.outcomes import Solver, Status
from vibrissa.study.axes import FREQUENCIES
from vibrissa.tables.rows import table_of
from vibrissa.tables.schemas import SHAPE, STATES

# For annotations alone: a job then depends only on the code that computes its own results.
if TYPE_CHECKING:
    from vibrissa.sticking.results import EquilibriumState


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
