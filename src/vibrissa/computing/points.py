"""Grid points as rows of a table, read off the equilibrium paths of their rods."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from vibrissa.computing.columns import frequency_values, state_values
from vibrissa.computing.rods import SolverSettings, rods_of, solve
from vibrissa.decimals import exact
from vibrissa.errors import StudyError
from vibrissa.numerics.arrays import FloatArray, IntArray, ObjectArray
from vibrissa.numerics.batch import slices
from vibrissa.outcomes import Status, TipMotion
from vibrissa.sticking.curve import CURVES_AT_ONCE, StickingCurve
from vibrissa.sticking.periods import read_curves
from vibrissa.sticking.piece import StickingState
from vibrissa.sticking.vibration import state_frequencies
from vibrissa.study.axes import Value, Values
from vibrissa.study.chunks import columns_at, columns_of, number_of_points
from vibrissa.tables.rows import table_of
from vibrissa.tables.schemas import STICTION


def solved_points(
    grid: str,
    axes: Mapping[str, Values],
    study: str,
    solver: SolverSettings,
) -> Iterator[pa.Table]:
    """Solve the rods of a chunk, some rods at a time, and read the grid points off their paths.

    Yields tables of the schema `STICTION`, with rows in the order `ROW_ORDER`.
    """
    rods = rods_of(axes, solver.method.by_step)
    rows_of_rods = np.arange(number_of_points(axes)).reshape(len(rods), -1)
    for together in slices(len(rods), CURVES_AT_ONCE):
        curves = solve(rods[together], solver)
        rows = rows_of_rods[together].ravel()
        yield points_table(grid, axes, rows, curves, study, solver.frequencies)


def solved_points_of_file(
    grid: str,
    file: str,
    common: Mapping[str, Value],
    first: int,
    rods: int,
    content: str,
    study: str,
    solver: SolverSettings,
) -> Iterator[pa.Table]:
    """Solve some rods of a file of points, and read their points off their paths.

    The first arguments are those of `vibrissa.study.points.PointsChunk`.

    Yields tables of the schema `STICTION`, with rows in the order of the rods.

    Raises
    ------
    StudyError
        If the points of these rods are no longer the same.
    """
    from vibrissa.study.points import read_points  # a twentieth of a second to load

    table = read_points(Path(file), common)
    by_step = solver.method.by_step
    chosen = table.rods(by_step)[first : first + rods]
    if table.digest([row for rows in chosen for row in rows]) != content:
        raise StudyError(f"{file} has changed since the run began; run the same command again")
    for some in slices(len(chosen), CURVES_AT_ONCE):
        together = chosen[some]
        axes = columns_of(table.at([row for rows in together for row in rows]))
        curves = solve([table.rod(rows, by_step) for rows in together], solver)
        counts = [len(rows) for rows in together]
        yield _rows_table(grid, axes, counts, curves, study, solver.frequencies)


def points_table(
    grid: str,
    axes: Mapping[str, Values],
    rows: IntArray,
    curves: Sequence[StickingCurve],
    study: str,
    frequencies: int = 0,
) -> pa.Table:
    """Read points off equilibrium paths; `rows` are the row numbers of the points in the chunk.

    `frequencies` is the number of natural frequencies to compute at each onset of slip.
    """
    counts = [len(rows) // len(curves)] * len(curves)
    return _rows_table(grid, columns_at(axes, rows), counts, curves, study, frequencies)


def _rows_table(
    grid: str,
    axes: Mapping[str, Any],
    counts: Sequence[int],
    curves: Sequence[StickingCurve],
    study: str,
    frequencies: int,
) -> pa.Table:
    """Read points off equilibrium paths.

    Parameters
    ----------
    axes : mapping
        Columns of the axes, as `vibrissa.study.chunks.columns_of` returns them.
    counts : sequence of int
        Number of points on each path; the points of a path follow each other.
    """
    ends = np.cumsum(counts)[:-1]
    curve_of_point = np.repeat(np.arange(len(curves)), counts)
    steps = {step: exact(step) for step in set(axes["dx0"].tolist())}
    dx0 = [[steps[step] for step in part.tolist()] for part in np.split(axes["dx0"], ends)]
    periods = read_curves(curves, np.split(axes["mu0"], ends), dx0)

    def of_curves(name: str) -> NDArray[Any]:
        """Repeat an attribute of each path for all its points."""
        return np.array([getattr(curve, name) for curve in curves])[curve_of_point]

    status = np.array(periods.status, dtype=object)
    known = (status == Status.SLIP) | (status == Status.LOCK)
    penetrates: ObjectArray = periods.penetrates.astype(object)
    penetrates[~known] = None
    columns = {
        **axes,
        "study": [study] * sum(counts),
        "grid": [grid] * sum(counts),
        "method": of_curves("method"),
        "status": status,
        "message": np.where(known, "", of_curves("message")),
        "contact": [contact or None for contact in periods.contact],
        "x0_slip": periods.x0_slip,
        "x0_max": periods.x0_max,
        "n_steps": periods.n_steps,
        "mu_lock": of_curves("mu_lock"),
        "x0_lock": of_curves("x0_lock"),
        **state_values(periods.init, "_init"),
        **state_values(periods.last, "_last"),
        **state_values(periods.slip, "_slip"),
        **frequency_values(_onset_frequencies(curves, counts, periods.slip, frequencies)),
        "ends_by": [end or None for end in periods.end],
        "x0_end": periods.ended.x0,
        **state_values(periods.ended, "_end"),
        "x0_trail": periods.trail.x0,
        **state_values(periods.trail, "_trail"),
        "x1_init": of_curves("x1_init"),
        "penetrates": penetrates,
        "residual": of_curves("residual"),
    }
    return table_of(STICTION, columns)


def _onset_frequencies(
    curves: Sequence[StickingCurve], counts: Sequence[int], slip: StickingState, count: int
) -> FloatArray:
    """Compute `count` natural frequencies at the onsets of slip, shape (n, count).

    The n onsets belong to the curves in their order; `counts` has the number of each curve.
    """
    found = np.full((len(slip), count), np.nan)
    if count:
        bounds = np.cumsum([0, *counts]).tolist()
        for curve, (begin, end) in zip(curves, pairwise(bounds), strict=True):
            rows = slice(begin, end)
            # Points that differ only in Δx0 have the same onset.
            onsets, which = np.unique(slip.x0[rows], return_index=True, return_inverse=True)[1:]
            states = slip.take(rows).take(onsets)
            values = state_frequencies(
                curve.theta, curve.mounting, states, states.s_c < 1.0, count, TipMotion.STICKS
            )
            found[rows] = values[which]
    return found
