"""Grid points: read off their curves, many at once, and put into rows of the table."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, TypeVar

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from vibrissa.outcomes import Status
from vibrissa.sticking.curve import CURVES_AT_ONCE, StickingCurve
from vibrissa.sticking.stiction import read_curves
from vibrissa.study.grid import CurvePoints
from vibrissa.tables.mounted import mounting_row
from vibrissa.tables.records import state_values, table_of
from vibrissa.tables.schemas import (
    ADDED_TO,
    CURVATURE_POWERS,
    MOUNTING,
    NUMBER,
    STICTION,
    TEXT,
    TEXTS,
)
from vibrissa.tables.store import LEAST_ROW_GROUP

OnCurve = tuple[CurvePoints, StickingCurve]
T = TypeVar("T")


def points_tables(points: Iterable[OnCurve], study: str) -> Iterator[pa.Table]:
    """Tables of grid points, read off their curves, of a row group or of some curves each.

    Parameters
    ----------
    points : iterable of (CurvePoints, StickingCurve)
        The points on each curve, and the curve.
    study : str
        Name of the study.

    Yields
    ------
    pyarrow.Table
        With the schema `STICTION`; the points of one curve are not torn apart. A row is the same,
        bit for bit, whatever curves are read with it.
    """
    held: list[OnCurve] = []
    rows = 0
    for on_curve, curve in points:
        held.append((on_curve, curve))
        rows += len(on_curve)
        if rows >= LEAST_ROW_GROUP or len(held) >= CURVES_AT_ONCE:
            yield _table(held, study)
            held, rows = [], 0
    if held:
        yield _table(held, study)


def _table(points: Sequence[OnCurve], study: str) -> pa.Table:
    columns = points_columns(points)
    columns["study"] = pa.repeat(study, len(columns["theta"]))
    return table_of(STICTION, columns)


def points_columns(points: Sequence[OnCurve]) -> dict[str, Any]:
    """Columns of the grid points on some curves, but the name of the study; see `points_tables`."""
    on_curves, curves = zip(*points, strict=True)
    mu0 = _each(on_curves, lambda one: np.array(one.mu0, dtype=float))
    stiction = read_curves(curves, mu0, [one.dx0 for one in on_curves])
    of = np.repeat(np.arange(len(curves)), [len(one) for one in on_curves])

    def of_curves(values: Iterable[Any], kind: pa.DataType = NUMBER) -> pa.Array:
        """Values of the curves, for each of their points; NaN stands for nothing."""
        return pa.array(list(values), kind, from_pandas=True).take(pa.array(of))

    mountings = _each([curve.mounting for curve in curves], mounting_row)
    status = np.array(stiction.status, dtype=object)
    known = pa.array((status == Status.SLIP) | (status == Status.LOCK))
    return {
        "method": of_curves((curve.method for curve in curves), TEXT),
        "grids": _joined(on_curves, lambda one: pa.array(one.grids, TEXTS)),
        ADDED_TO.name: _joined(on_curves, lambda one: pa.array(one.added_to, TEXTS)),
        "theta": of_curves(curve.theta for curve in curves),
        "mu0": np.concatenate(mu0),
        "eta": of_curves(curve.eta for curve in curves),
        "dx0": np.concatenate(_each(on_curves, lambda one: np.array(one.dx0, dtype=float))),
        **{
            column.name: of_curves((row[column.name] for row in mountings), column.type)
            for column in (*MOUNTING, CURVATURE_POWERS)
        },
        "status": status,
        "message": pc.if_else(known, "", of_curves((curve.message for curve in curves), TEXT)),
        "contact": [contact or None for contact in stiction.contact],
        "x0_slip": stiction.x0_slip,
        "x0_max": stiction.x0_max,
        "n_steps": stiction.n_steps,
        "mu_lock": of_curves(curve.mu_lock for curve in curves),
        "x0_lock": of_curves(curve.x0_lock for curve in curves),
        **state_values(stiction.init, "_init"),
        **state_values(stiction.last, "_last"),
        **state_values(stiction.slip, "_slip"),
        "ends_by": [end or None for end in stiction.end],
        "x0_end": stiction.ended.x0,
        **state_values(stiction.ended, "_end"),
        "x0_trail": stiction.trail.x0,
        **state_values(stiction.trail, "_trail"),
        "x1_init": of_curves(curve.x1_init for curve in curves),
        "penetrates": pc.if_else(known, pa.array(stiction.penetrates), None),
        "residual": of_curves(curve.residual for curve in curves),
    }


def _each(items: Sequence[Any], make: Callable[[Any], T]) -> list[T]:
    """Make something of each item, once of an item that comes again."""
    known: dict[int, T] = {}
    for item in items:
        if id(item) not in known:
            known[id(item)] = make(item)
    return [known[id(item)] for item in items]


def _joined(items: Sequence[Any], make: Callable[[Any], pa.Array]) -> pa.Array:
    """Join the arrays of all items."""
    return pa.concat_arrays(_each(items, make))
