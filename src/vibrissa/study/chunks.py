"""Chunks of a grid: one job solves one chunk, and one file holds its rows.

Axes are cut from their first value on, so that values appended to an axis change no full chunk.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from itertools import product
from typing import Any

import numpy as np

from vibrissa.study.axes import MOUNTING_AXES, POWERS, Values, sortable, spell_value

# Order of the axes in the rows of a table; the last axis varies fastest.
ROW_ORDER = ("eta", "theta", *MOUNTING_AXES, "dx0", "mu0")
# Default largest number of values of each axis in a chunk, and of rods. A job then takes some 10 s;
# a run that is stopped loses no more. Friction and step are not cut, as their points cost little.
SIZES = {"theta": 64, "eta": 16, **dict.fromkeys(MOUNTING_AXES, 16)}
MOST_RODS = 1024
# Characters of a chunk's name before a digest: file systems allow 255 with all endings.
LONGEST_NAME = 150
# The paper's own method takes ten seconds and more for each rod and step.
SIZES_BY_STEP = {"theta": 1, "eta": 1}
# Times requested from a cluster (s), which are upper bounds: for a rod (usually 5 to 20 ms; more
# with a small eta or a strong taper), a rod and step by shooting, a point, the start of a job.
ROD_SECONDS, ROD_BY_STEP_SECONDS, POINT_SECONDS, START_SECONDS = 0.3, 120.0, 15e-6, 300.0


@dataclass(frozen=True, kw_only=True)
class Chunk:
    """Part of a grid: all combinations of some consecutive values of each axis."""

    grid: str
    axes: Mapping[str, Values]

    @property
    def params(self) -> dict[str, Any]:
        """Inputs of the job, as plain values."""
        return {"grid": self.grid, "axes": self.axes}

    @property
    def name(self) -> str:
        """Name made of the grid and first values, such as ``taper/theta1_eta0.85``.

        A name that would be too long for a file has a digest in the place of its end.
        """
        mounted = [axis for axis in MOUNTING_AXES if self.axes[axis] != (0.0,)]
        first = {axis: spell_value(self.axes[axis][0]) for axis in ("theta", "eta", *mounted)}
        values = "_".join(axis + value for axis, value in first.items())
        if len(values) > LONGEST_NAME:
            values = f"{values[:LONGEST_NAME]}_{sha256(values.encode()).hexdigest()[:16]}"
        return f"{self.grid}/{values}"

    def study_part(self, solver: Mapping[str, str]) -> str:
        """Return the inputs that determine the chunk's rows, as text for its file's metadata."""
        lines = {"grid": self.grid, **self.axes, **solver}
        return "".join(f"{key}: {value}\n" for key, value in lines.items())

    def minutes(self, by_step: bool) -> int:
        """Return the minutes to request from a cluster; `by_step`: one solution for each Δx0."""
        points = number_of_points(self.axes)
        steps = points // len(self.axes["mu0"])
        return minutes_for(steps if by_step else steps // len(self.axes["dx0"]), points, by_step)


def minutes_for(rods: int, points: int, by_step: bool) -> int:
    """Return the minutes to request for a job; `by_step`: each rod has one Δx0."""
    seconds = (ROD_BY_STEP_SECONDS if by_step else ROD_SECONDS) * rods
    return 1 + int((START_SECONDS + seconds + POINT_SECONDS * points) / 60)


def sizes_of(axes: Mapping[str, Values], most_rods: int = MOST_RODS) -> dict[str, int]:
    """Return the default number of values of each axis in a chunk.

    An axis has room for what the axes before it leave of `most_rods`. So a value appended to an
    axis of full chunks does not change how the others are cut.
    """
    sizes, room = {}, most_rods
    for axis, most in SIZES.items():
        sizes[axis] = min(most, room)
        room = max(1, room // min(sizes[axis], len(axes[axis])))
    return sizes


def chunks_of(grid: str, axes: Mapping[str, Values], sizes: Mapping[str, int]) -> Iterator[Chunk]:
    """Cut a grid into chunks of at most `sizes[axis]` values; other axes are not cut."""
    pieces = []
    for axis, values in axes.items():
        size = sizes.get(axis, len(values))
        pieces.append([values[i : i + size] for i in range(0, len(values), size)])
    for part in product(*pieces):
        yield Chunk(grid=grid, axes=dict(zip(axes, part, strict=True)))


def points_of(axes: Mapping[str, Values]) -> list[dict[str, Any]]:
    """List the points of a grid, each as a mapping from axis to value."""
    return [dict(zip(axes, values, strict=True)) for values in product(*axes.values())]


def number_of_points(axes: Mapping[str, Values]) -> int:
    """Count the points of a chunk or a grid."""
    return int(np.prod([len(values) for values in axes.values()], dtype=object))


def columns_at(axes: Mapping[str, Values], rows: Any) -> dict[str, Any]:
    """Return the columns of the axes for some rows of a chunk; see `columns_of`.

    `rows` are the numbers of these rows. The rows of a chunk are ordered by the axes `ROW_ORDER`.
    """
    shape = [len(axes[axis]) for axis in ROW_ORDER]
    places = dict(zip(ROW_ORDER, np.unravel_index(rows, shape), strict=True))
    columns = columns_of({axis: axes[axis] for axis in ROW_ORDER})
    places |= {column: places[axis] for axis, column in POWERS.items()}
    return {name: column[places[name]] for name, column in columns.items()}


def columns_of(points: Mapping[str, Sequence[Any]]) -> dict[str, Any]:
    """Return values of axes as columns of a table.

    The first coefficient of a polynomial curvature is in the column ``curvature``, the others are
    in ``curvature_powers``; and so are those of a stiffening.
    """
    columns = {
        axis: np.array([sortable(value)[0] for value in values]) for axis, values in points.items()
    }
    powers = {
        column: np.array([spell_powers(value) for value in points[axis]], dtype=object)
        for axis, column in POWERS.items()
    }
    return columns | powers


def spell_powers(polynomial: float | Sequence[float]) -> str | None:
    """Format the coefficients of a polynomial after the first one; None if there are none."""
    powers = sortable(polynomial)[1:]
    return ", ".join(map(spell_value, powers)) if powers else None
