"""Draw a figure of any kind from its table."""

import runpy
import traceback
from collections.abc import Mapping, Sequence
from functools import reduce
from operator import and_, or_
from pathlib import Path
from typing import Any

import matplotlib
import pandas as pd
import pyarrow.compute as pc
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibrissa.errors import ArgumentError
from vibrissa.figures import (
    accuracy,
    animation,
    comparisons,
    labels,
    lateral,
    maps,
    mountings,
    periods,
    points,
    regimes,
    scans,
    slip,
    states,
    style,
)
from vibrissa.figures.kinds import KINDS
from vibrissa.outcomes import NO_RESULT
from vibrissa.study.axes import POWERS, SURFACE_AXES, sortable
from vibrissa.study.chunks import spell_powers
from vibrissa.study.figures import DRAW, TABLES
from vibrissa.tables import query

# Axes of scans that may have no value.
WITHOUT_EFFECT = (*SURFACE_AXES, "kinetic_ratio", "damping")
# Importing them registers their kinds.
FAMILIES = (
    points,
    regimes,
    lateral,
    maps,
    mountings,
    periods,
    scans,
    slip,
    states,
    comparisons,
    accuracy,
)


def draw(
    kind: str,
    table: query.Readable,
    selection: Mapping[str, Any],
    script: Path | None = None,
    look: Mapping[str, Any] | None = None,
) -> Figure:
    """Draw a figure; if no row has a result, the figure shows the reason.

    Parameters
    ----------
    kind : str
        One of `KINDS`, or ``script`` for the user's file `script`.
    selection : mapping
        Which rows to draw, as a figure states them in the study file. One of the keys ``grid``,
        ``scan``, ``state`` and ``comparison`` has a name or a list of names. Each further key is an
        axis of the grid, such as ``theta``, with a list of values.
    look : mapping, optional
        ``size`` and ``axes`` as in the study file.

    Raises
    ------
    ArgumentError
        If no rows are selected, or the script fails.
    """
    columns = table.schema.names if script else KINDS[kind].columns
    rows = query.frame(table, columns, _condition(selection))
    if rows.empty:
        raise ArgumentError(
            f"the table has no rows with {dict(selection)} for a figure of kind {kind}"
        )
    with style.applied():
        if script:
            figure = _scripted(script, rows)
        elif "status" in rows and rows["status"].isin(NO_RESULT).all():
            return _failure(rows)
        elif KINDS[kind].is_scaled_by_all:
            source = {key: selection[key] for key in TABLES if key in selection}
            figure = KINDS[kind].plot(rows, query.frame(table, columns, _condition(source)))
        else:
            given = look or {}
            keys = {key: given[key] for key in KINDS[kind].keys if given.get(key)}
            figure = KINDS[kind].plot(rows, **keys)
        # The maps of `regimes` have equal axes.
        _adjust(figure, figure.axes if kind == "regimes" else figure.axes[:1], look or {})
    return figure


def animate(table: query.Readable, selection: Mapping[str, Any], path: Path) -> None:
    """Write the selected scans that have a result as an animation; see `draw`."""
    rows = query.frame(table, animation.COLUMNS, _condition(selection))
    animation.save(rows[rows["footpoint"].notna()], path)


def _condition(selection: Mapping[str, Any]) -> pc.Expression:
    """Return the condition for the rows of a selection; see `draw`."""
    conditions = []
    for name, value in selection.items():
        values = value if isinstance(value, list) else [value]
        if name in POWERS:
            conditions.append(reduce(or_, [_has_polynomial(name, one) for one in values]))
        elif name in WITHOUT_EFFECT:
            # An axis without effect on a scan does not exclude it.
            conditions.append(query.one_of(name, values) | pc.field(name).is_null())
        else:
            conditions.append(query.one_of(name, values))
    return reduce(and_, conditions)


def _has_polynomial(axis: str, value: float | Sequence[float]) -> pc.Expression:
    """Return the condition that an axis has this number or polynomial."""
    first, *_ = sortable(value)
    powers, found = spell_powers(value), pc.field(POWERS[axis])
    same = found == powers if powers else found.is_null()
    return (pc.field(axis) == first) & same


def _scripted(script: Path, rows: pd.DataFrame) -> Figure:
    """Draw with the function `DRAW` of the user's file."""
    try:
        # Titles move above ticks that the file may put at the top.
        with matplotlib.rc_context({"axes.titley": None}):
            figure = runpy.run_path(str(script))[DRAW](rows)
    except (Exception, SystemExit) as error:
        calls = traceback.extract_tb(error.__traceback__)
        lines = [f":{call.lineno}" for call in calls if call.filename == str(script)]
        line = lines[-1] if lines else ""
        raise ArgumentError(f"{script}{line}: {type(error).__name__}: {error}") from error
    if not isinstance(figure, Figure):
        raise ArgumentError(
            f"{script}: {DRAW} returns {type(figure).__name__}; needed: a matplotlib Figure"
        )
    return figure


def _adjust(figure: Figure, panels: Sequence[Axes], look: Mapping[str, Any]) -> None:
    """Set the size of a figure and the axes of its panels as in the study file."""
    if size := look.get("size"):
        figure.set_size_inches(size)
    if axes := look.get("axes"):
        scales = {f"{axis}scale": "log" for axis in axes.get("log", ())}
        # Set last, so that the study file overrides the limits that a kind sets.
        limits = {f"{axis}lim": axes[axis] for axis in "xy" if axis in axes}
        # A figure that is a message has no axes.
        for panel in panels:
            for axis in axes.get("log", ()):
                panel.autoscale(axis=axis)  # a limit may be 0
            panel.set(**scales | limits)
            if any(text.get_gid() == style.NAMED for text in panel.texts):
                labels.at_ends(panel)
            if any(text.get_gid() == style.NAMED for text in panel.texts):
                labels.at_ends(panel)


def _failure(rows: pd.DataFrame) -> Figure:
    """Make a figure that shows why there are no data."""
    reason = rows["message"].iloc[0] if "message" in rows else "the tables and logs have the reason"
    status = rows["status"].iloc[0].replace("_", " ")
    return style.message(f"{status}: {reason}")
