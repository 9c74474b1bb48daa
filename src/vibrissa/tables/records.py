"""Results of computations as tables, and back: a row for each curve, step or state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa

from vibrissa.outcomes import Contact, End, Parameter, RodSection, Solver, Status
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.piece import Piece, StickingState
from vibrissa.study.codec import decode_columns, encode_columns
from vibrissa.study.grid import AXES, CurveKey, Point
from vibrissa.tables.mounted import mounting_of, mounting_row
from vibrissa.tables.schemas import (
    COMPARISONS,
    CURVES,
    SCANS,
    SHAPE,
    STATE,
    STATES,
    WHOLE,
)

# Only their attributes are read: a job need not depend on how the others' results are computed.
if TYPE_CHECKING:
    from vibrissa.sticking.api import EquilibriumState
    from vibrissa.sticking.comparison import Comparison
    from vibrissa.sticking.cycles import Scan


def _array(values: Any, kind: pa.DataType) -> pa.Array:
    """Arrow array of a column; NaN stands for nothing."""
    if isinstance(values, pa.Array):
        return values
    if isinstance(values, np.ndarray):
        if kind == WHOLE and values.dtype.kind == "f":
            return pa.array(np.nan_to_num(values).astype(np.int64), kind, mask=np.isnan(values))
        return pa.array(values, kind, from_pandas=True)
    return pa.array(values, kind)


def table_of(schema: pa.Schema, columns: Mapping[str, Any]) -> pa.Table:
    """Table of the columns of a schema, from lists, or arrays of NumPy or Arrow."""
    arrays = [_array(columns[field.name], field.type) for field in schema]
    return pa.Table.from_arrays(arrays, schema=schema)


def state_values(state: StickingState, suffix: str = "") -> dict[str, Any]:
    """Columns of `STATE`, whose names end with a suffix."""
    return {f"{column.name}{suffix}": getattr(state, column.name) for column in STATE}


def curves_table(keys: Sequence[CurveKey], curves: Sequence[StickingCurve]) -> pa.Table:
    """Table of sticking curves under the keys that they were solved for.

    Parameters
    ----------
    keys : sequence of CurveKey
    curves : sequence of StickingCurve
        In the order of the keys.

    Returns
    -------
    pyarrow.Table
        With the schema `CURVES`.
    """
    columns: dict[str, Any] = {**encode_columns(keys)}
    for name in ("method", "section", "status", "message", "end_message"):
        columns[name] = [getattr(curve, name) for curve in curves]
    columns["ends_by"] = [curve.end for curve in curves]
    for name in _CURVE_SCALARS:
        columns[name] = np.array([getattr(curve, name) for curve in curves])
    whole = [(*curve.pulled, *curve.pieces) for curve in curves]
    columns["piece_states"] = [[len(piece.states) for piece in pieces] for pieces in whole]
    for name in ("contact", "parameter", "start", "stop"):
        columns[f"piece_{name}"] = [[getattr(p, name) for p in pieces] for pieces in whole]
    # Arrays from arrays: to make each number an object would take time and memory.
    pieces = [piece.states for pieces in whole for piece in pieces]
    states = StickingState.concatenate([StickingState.unknown(0), *pieces])
    counts = [sum(states) for states in columns["piece_states"]]
    offsets = pa.array(np.cumsum([0, *counts]), pa.int32())
    for name, values in states.columns.items():
        columns[name] = pa.ListArray.from_arrays(offsets, values)
    return table_of(CURVES, columns)


_CURVE_SCALARS = ("x1_init", "residual", "x0_lock", "mu_lock", "x0_touch")


def curves_from_table(table: pa.Table) -> dict[CurveKey, StickingCurve]:
    """Sticking curves of a table by the keys that they were solved for.

    Parameters
    ----------
    table : pyarrow.Table
        With the schema `CURVES`.

    Returns
    -------
    dict
    """
    curves = {}
    columns = {name: table.column(name).combine_chunks() for name in StickingState.names()}
    states = StickingState(
        **{name: c.flatten().to_numpy(zero_copy_only=False) for name, c in columns.items()}
    )
    first = 0
    for row in table.drop_columns(list(columns)).to_pylist():
        key = decode_columns(row)
        scalars: dict[str, Any] = {
            name: np.nan if row[name] is None else row[name] for name in _CURVE_SCALARS
        }
        method = Solver(row["method"])
        pieces: list[Piece] = []
        pulled: list[Piece] = []
        names = ("contact", "parameter", "start", "stop", "states")
        for contact, parameter, start, stop, count in zip(
            *(row[f"piece_{name}"] for name in names), strict=True
        ):
            piece = Piece(
                contact=Contact(contact),
                parameter=Parameter(parameter),
                start=start,
                stop=stop,
                states=states.take(slice(first, first + count)),
                stepped=method is Solver.SHOOTING,
            )
            # The advance, which counts other pieces, may be negative where the clamp does not pull.
            pulls = piece.parameter is Parameter.X0 and piece.start < 0.0
            (pulled if pulls else pieces).append(piece)
            first += count
        curves[key] = StickingCurve(
            theta=float(key.theta),
            eta=float(key.eta),
            method=method,
            status=Status(row["status"]),
            message=row["message"],
            pieces=tuple(pieces),
            pulled=tuple(pulled),
            section=RodSection(row["section"]),
            **scalars,
            end=End(row["ends_by"]),
            end_message=row["end_message"],
            mounting=mounting_of(key.mounting),
        )
    return curves


def scan_table(name: str, point: Point, scan: Scan, *, study: str, method: Solver) -> pa.Table:
    """Table of one scan, a row for each footpoint position.

    Parameters
    ----------
    name : str
        Name of the set of scans.
    point : Point
    scan : Scan
    study : str
        Name of the study.
    method : Solver
        By which its curve was solved.

    Returns
    -------
    pyarrow.Table
        With the schema `SCANS`; a failed scan has one row that says so.
    """
    failed = scan.status not in (Status.SLIP, Status.LOCK)
    n = 1 if failed else len(scan.step)
    columns: dict[str, Any] = {
        "study": [study] * n,
        "method": [method] * n,
        "scan": [name] * n,
        **{axis: np.full(n, float(getattr(point, axis))) for axis in AXES},
        **{name: [value] * n for name, value in mounting_row(mounting_of(point.mounting)).items()},
        "status": [scan.status] * n,
    }
    values = {
        "cycle": scan.cycle,
        "step": scan.step,
        "phase": scan.phase,
        "footpoint": scan.footpoint,
        "x0": scan.state.x0,
        "x1": scan.x1,
        **state_values(scan.state),
        "residual": scan.residual,
    }
    shapes = {"x": scan.x, "y": scan.y, "phi": scan.phi}
    if failed:
        columns |= {key: [None] for key in values}
        columns |= {column.name: [[]] for column in SHAPE}
    else:
        columns |= values | {f"shape_{axis}": list(shape) for axis, shape in shapes.items()}
        columns["shape_s"] = [scan.s] * n
    return table_of(SCANS, columns)


def comparison_table(name: str, comparison: Comparison, study: str) -> pa.Table:
    """Table of points in both contact models.

    Parameters
    ----------
    name : str
        Name of the comparison.
    comparison : Comparison
    study : str
        Name of the study.

    Returns
    -------
    pyarrow.Table
        With the schema `COMPARISONS`.
    """
    n = len(comparison.theta)
    columns: dict[str, Any] = {"comparison": [name] * n, "study": [study] * n}
    columns["method"] = [Solver.COLLOCATION] * n
    columns |= {key: getattr(comparison, key) for key in ("theta", "mu0", "eta", "penetrates")}
    for model in ("point", "line"):
        result = getattr(comparison, model)
        columns |= {f"{key}_{model}": values for key, values in vars(result).items()}
    return table_of(COMPARISONS, columns)


def states_table(states: Mapping[str, EquilibriumState], study: str) -> pa.Table:
    """Table of single equilibria with their shapes.

    Parameters
    ----------
    states : mapping of EquilibriumState
        By name.
    study : str
        Name of the study.

    Returns
    -------
    pyarrow.Table
        With the schema `STATES`.
    """
    columns: dict[str, list[Any]] = {field.name: [] for field in STATES}
    s = np.linspace(0.0, 1.0, 101)
    for name, state in states.items():
        solved = state.status is Status.SOLVED
        shape = (s, *state.shape(s)) if solved else ([], [], [], [])
        values: dict[str, Any] = {"study": study, "method": Solver.COLLOCATION, "state": name}
        values |= zip((column.name for column in SHAPE), shape, strict=True)
        for field in STATES:
            known = solved or not field.nullable
            value = values[field.name] if field.name in values else getattr(state, field.name)
            columns[field.name].append(value if known else None)
    return table_of(STATES, columns)
