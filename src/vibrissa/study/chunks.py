"""Chunks: the parts of a grid that one job solves, and that one file holds.

An axis is cut from its first value on: appending values to it leaves all full chunks unchanged.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from vibrissa.study.axes import MOUNTING_AXES, Values, sortable, spell_value

# The axes in the order of the rows of a table, the last one runs fastest.
ROW_ORDER = ("eta", "theta", *MOUNTING_AXES, "dx0", "mu0")
# Values of each axis in a chunk, if the study file does not say otherwise: all friction values
# and steps, which cost little, and so many rods that a job takes seconds to some minutes.
SIZES = {"theta": 128, "eta": 16, **dict.fromkeys(MOUNTING_AXES, 8)}
# The paper's own method takes ten seconds and more for each rod and step.
SIZES_BY_STEP = {"theta": 1, "eta": 1}
# What a cluster is asked for: seconds for a rod at most (usually 5 to 20 ms; with a small eta or a
# strong taper more), by shooting for a rod and step; microseconds for a point; the start of a job.
ROD, ROD_BY_STEP, POINT, START = 0.3, 120.0, 15e-6, 300.0


@dataclass(frozen=True, kw_only=True)
class Chunk:
    """Part of a grid: a product of consecutive values of its axes."""

    grid: str
    axes: Mapping[str, Values]

    @property
    def name(self) -> str:
        """Grid and first values, as in ``taper/theta1_eta0.85``: appended values change no name."""
        mounted = [axis for axis in MOUNTING_AXES if self.axes[axis] != (0.0,)]
        first = {axis: spell_value(self.axes[axis][0]) for axis in ("theta", "eta", *mounted)}
        return f"{self.grid}/{'_'.join(axis + value for axis, value in first.items())}"

    def part(self, solver: Mapping[str, str]) -> str:
        """All that determines the rows of the chunk, as text for the metadata of its file."""
        lines = {"grid": self.grid, **self.axes, **solver}
        return "".join(f"{key}: {value}\n" for key, value in lines.items())

    def minutes(self, by_step: bool) -> int:
        """Minutes to request from a cluster; `by_step`: shooting solves every step."""
        rods = number_of_rods(self.axes)
        points = rods * len(self.axes["mu0"]) * len(self.axes["dx0"])
        seconds = ROD_BY_STEP * rods * len(self.axes["dx0"]) if by_step else ROD * rods
        return 1 + int((START + seconds + POINT * points) / 60)


def chunks_of(grid: str, axes: Mapping[str, Values], sizes: Mapping[str, int]) -> Iterator[Chunk]:
    """Cut a grid into chunks of at most `sizes` values; axes without a size are not cut."""
    pieces = [
        [values[i : i + size] for i in range(0, len(values), size)]
        for axis, values in axes.items()
        for size in [sizes.get(axis, len(values))]
    ]
    for part in product(*pieces):
        yield Chunk(grid=grid, axes=dict(zip(axes, part, strict=True)))


def points_of(axes: Mapping[str, Values]) -> list[dict[str, Any]]:
    """All points of a grid, by axis."""
    return [dict(zip(axes, values, strict=True)) for values in product(*axes.values())]


def number_of_rods(axes: Mapping[str, Values]) -> int:
    """Count the rods of a chunk: combinations of all axes but friction and step."""
    return int(np.prod([len(axes[axis]) for axis in ("eta", "theta", *MOUNTING_AXES)]))


def number_of_points(axes: Mapping[str, Values]) -> int:
    """Count the points of a chunk or a grid."""
    return int(np.prod([len(values) for values in axes.values()], dtype=object))


def columns_at(axes: Mapping[str, Values], rows: Any) -> dict[str, Any]:
    """Return the axis columns at `rows` of a chunk, numbers of rows in the order `ROW_ORDER`.

    A polynomial curvature has its constant in one column, and the other coefficients in another.
    """
    shape = [len(axes[axis]) for axis in ROW_ORDER]
    places = dict(zip(ROW_ORDER, np.unravel_index(rows, shape), strict=True))
    columns = {
        axis: np.array([sortable(value)[0] for value in axes[axis]])[place]
        for axis, place in places.items()
    }
    powers = np.array([spell_powers(value) for value in axes["curvature"]], dtype=object)
    return {**columns, "curvature_powers": powers[places["curvature"]]}


def spell_powers(curvature: float | Sequence[float]) -> str | None:
    """Spell the coefficients of a natural curvature after the constant; None if it is constant."""
    powers = sortable(curvature)[1:]
    return ", ".join(map(spell_value, powers)) if powers else None
