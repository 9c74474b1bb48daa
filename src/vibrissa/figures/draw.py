"""Draw a figure of any kind from its table."""

from collections.abc import Mapping
from functools import reduce
from operator import and_, or_
from typing import Any

import numpy as np
import pandas as pd
import pyarrow.compute as pc
from matplotlib.figure import Figure

from vibrissa.errors import ArgumentError
from vibrissa.figures import aside, comparisons, mountings, points, regimes, scans, states, style
from vibrissa.figures.kinds import Kind
from vibrissa.study.grid import REFINED_CURVE_AXES
from vibrissa.tables import query
from vibrissa.tables.schemas import ADDED_TO

KINDS: dict[str, Kind] = {
    kind.name: kind
    for family in (points, regimes, aside, mountings, scans, states, comparisons)
    for kind in vars(family).values()
    if isinstance(kind, Kind)
}
NO_RESULT = ("failed", "out_of_reach")


def draw(kind: str, table: query.Readable, selection: Mapping[str, Any]) -> Figure:
    """Draw a figure.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    table : pyarrow.Table or Dataset
        Table that the kind is drawn from (`vibrissa.tables.query`); of one in a file no more is
        read than is shown.
    selection : mapping
        Which rows, by the keys of a figure in the study file: ``grid``, the name of one; ``scan``,
        ``state``, ``comparison`` and the axes, each a value or a list of values; a curvature that
        is a polynomial as in ``"-0.05, 0.1"``.

    Returns
    -------
    matplotlib.figure.Figure
        Says why there is nothing to show where all of the rows are without a result.

    Raises
    ------
    ArgumentError
        If there are no such rows, or the kind is unknown.
    """
    if kind not in KINDS:
        raise ArgumentError(f"unknown kind of figure {kind!r}; allowed: {', '.join(KINDS)}")
    rows = _rows(KINDS[kind], table, selection)
    if rows.empty:
        raise ArgumentError(f"no rows to draw for {kind} figure with {dict(selection)}")
    with style.applied():
        if "status" in rows and rows["status"].isin(NO_RESULT).all():
            return _failure(rows)
        return KINDS[kind].plot(rows)


def _rows(kind: Kind, table: query.Readable, selection: Mapping[str, Any]) -> pd.DataFrame:
    """Rows that are shown: of a grid those on its axes, and those added along the kind's axis."""
    where = _condition(selection)
    if "grid" not in selection:
        return query.frame(table, kind.columns, where)
    if not kind.along:
        return query.frame(table, kind.columns, where & query.on_axes(selection["grid"]))
    rows = query.frame(table, [*kind.columns, ADDED_TO.name], where)
    names = rows.pop(ADDED_TO.name)
    on_axes = [found is None or selection["grid"] not in found for found in names]
    own = rows[np.array(on_axes, dtype=bool)]
    across = {"mu0", *REFINED_CURVE_AXES}.intersection(rows) - {kind.along}
    return rows[np.logical_and.reduce([rows[axis].isin(own[axis]) for axis in across])]


def _condition(selection: Mapping[str, Any]) -> pc.Expression | None:
    """Condition on the rows of what a figure's entry in the study file selects."""
    conditions = []
    for name, value in selection.items():
        if name == "grid":
            conditions.append(query.in_grid(value))
            continue
        values = value if isinstance(value, list) else [value]
        if name == "curvature":
            conditions.append(reduce(or_, map(_has_curvature, values)))
        else:
            conditions.append(query.one_of(name, values))
    return reduce(and_, conditions) if conditions else None


def _has_curvature(value: float | str) -> pc.Expression:
    """Condition that the natural curvature is a constant, or a polynomial."""
    constant, _, powers = str(value).partition(", ")
    found = pc.field("curvature_powers")
    same = found == powers if powers else found.is_null()
    return (pc.field("curvature") == float(constant)) & same


def _failure(rows: pd.DataFrame) -> Figure:
    """Say that there is nothing to show: the study goes on without it."""
    reason = rows["message"].iloc[0] if "message" in rows else "the tables and logs say why"
    status = rows["status"].iloc[0].replace("_", " ")
    return style.message(f"{status}: {reason}")
