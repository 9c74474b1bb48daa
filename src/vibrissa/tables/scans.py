"""Scans as a table: a row for each step of the clamp."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pyarrow as pa

from vibrissa.outcomes import Solver
from vibrissa.scanning.simulation import Scan, TipPhase
from vibrissa.study.axes import AXES, Value, sortable
from vibrissa.study.chunks import spell_powers
from vibrissa.tables.records import state_values, table_of
from vibrissa.tables.schemas import SCANS, SHAPE


def scan_table(
    name: str, point: Mapping[str, Value], scan: Scan, *, study: str, method: Solver
) -> pa.Table:
    """Make the table of a scan: a row for each clamp position, or one row if the scan failed."""
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
        "residual": shapes.residual,
        "shape_s": [shapes.s] * n,
        "shape_x": list(shapes.x),
        "shape_y": list(shapes.y),
        "shape_phi": list(shapes.phi),
    }
    return table_of(SCANS, columns | values)
