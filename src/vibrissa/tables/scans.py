"""Scans as a table: a row for each step of the clamp."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pyarrow as pa

from vibrissa.mechanics.mounting import Mounting
from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import Solver, TipMotion
from vibrissa.scanning.simulation import Scan, TipPhase
from vibrissa.sticking.piece import StickingState
from vibrissa.sticking.vibration import state_frequencies
from vibrissa.study.axes import AXES, MOUNTING_AXES, Value, sortable
from vibrissa.study.chunks import spell_powers
from vibrissa.tables.records import frequency_values, state_values, table_of
from vibrissa.tables.schemas import SCANS, SHAPE


def scan_table(
    name: str,
    point: Mapping[str, Value],
    scan: Scan,
    *,
    study: str,
    method: Solver,
    frequencies: int = 0,
) -> pa.Table:
    """Make the table of a scan: a row for each clamp position, or one row if the scan failed.

    `frequencies` is the number of natural frequencies to compute in each state.
    """
    failed, n = not len(scan), max(len(scan), 1)
    columns: dict[str, Any] = {
        "study": [study] * n,
        "method": [method] * n,
        "scan": [name] * n,
        **{axis: np.full(n, sortable(point[axis])[0]) for axis in AXES},
        "curvature_powers": [spell_powers(point["curvature"])] * n,
        "status": [scan.status] * n,
    }
    if failed:
        unknown: dict[str, Any] = {field.name: [None] for field in SCANS if field.nullable}
        unknown |= {column.name: [[]] for column in SHAPE}
        return table_of(SCANS, unknown | columns)
    state, shapes = scan.state, scan.shapes()
    values = {
        "cycle": scan.cycle,
        "step": scan.step,
        "phase": np.where(scan.phase == TipPhase.SLIP, TipPhase.SLIP, TipPhase.STICK),
        "footpoint": scan.clamp,
        "x0": state.x0,
        "x1": scan.contact,
        **state_values(state),
        **frequency_values(_frequencies(point, state, frequencies)),
        "residual": shapes.residual,
        "shape_s": [shapes.s] * n,
        "shape_x": list(shapes.x),
        "shape_y": list(shapes.y),
        "shape_phi": list(shapes.phi),
    }
    return table_of(SCANS, columns | values)


def _frequencies(point: Mapping[str, Value], states: StickingState, count: int) -> FloatArray:
    """Compute natural frequencies in all states of a scan, shape (n, count)."""
    if not count:
        return np.empty((len(states), 0))
    values: Mapping[str, Any] = {axis: point[axis] for axis in MOUNTING_AXES}
    theta = float(sortable(point["theta"])[0])
    line = states.s_c < 1.0
    return state_frequencies(theta, Mounting(**values), states, line, count, TipMotion.STICKS)
