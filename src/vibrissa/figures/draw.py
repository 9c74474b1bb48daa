"""Draw a figure of any kind from its table."""

from collections.abc import Mapping, Sequence
from functools import reduce
from operator import and_
from typing import Any

import pandas as pd
import pyarrow.compute as pc
from matplotlib.figure import Figure

from vibrissa.errors import ArgumentError
from vibrissa.figures import aside, comparisons, mountings, points, regimes, scans, states, style
from vibrissa.figures.kinds import Kind
from vibrissa.study.axes import sortable
from vibrissa.study.chunks import spell_powers
from vibrissa.tables import query

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
        ``state`` (or a list of them), ``comparison`` and the axes, each a value; of a curvature
        that is a polynomial its coefficients.

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
    rows = query.frame(table, KINDS[kind].columns, _condition(selection))
    if rows.empty:
        raise ArgumentError(f"no rows to draw for {kind} figure with {dict(selection)}")
    with style.applied():
        if "status" in rows and rows["status"].isin(NO_RESULT).all():
            return _failure(rows)
        return KINDS[kind].plot(rows)


def _condition(selection: Mapping[str, Any]) -> pc.Expression | None:
    """Condition on the rows of what a figure's entry in the study file selects."""
    conditions = []
    for name, value in selection.items():
        if name == "grid":
            conditions.append(query.in_grid(value))
            continue
        if name == "curvature":
            conditions.append(_has_curvature(value))
        else:
            conditions.append(query.one_of(name, value if isinstance(value, list) else [value]))
    return reduce(and_, conditions) if conditions else None


def _has_curvature(value: float | Sequence[float]) -> pc.Expression:
    """Condition that the natural curvature is a constant, or a polynomial."""
    constant, *_ = sortable(value)
    powers, found = spell_powers(value), pc.field("curvature_powers")
    same = found == powers if powers else found.is_null()
    return (pc.field("curvature") == constant) & same


def _failure(rows: pd.DataFrame) -> Figure:
    """Say that there is nothing to show: the study goes on without it."""
    reason = rows["message"].iloc[0] if "message" in rows else "the tables and logs say why"
    status = rows["status"].iloc[0].replace("_", " ")
    return style.message(f"{status}: {reason}")
