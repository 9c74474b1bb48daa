"""Points of μ0 that refinement adds between those of a grid, where the grid is too coarse.

They are read off the curves that are solved already, and depend on nothing but the curve, the
grid and the refinement: however curves are put into blocks, the same points are added.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from itertools import groupby

import numpy as np

from vibrissa.decimals import spell
from vibrissa.numerics.halving import Halved, Reading, halve
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.stiction import read_curve
from vibrissa.study.grid import CurvePoints, Refinement, named_points
from vibrissa.tables.records import stiction_columns
from vibrissa.wording import counted

# Columns that say what happens at a point: where one changes, the change is closed in.
KIND = ("status", "contact", "ends_by")


@dataclass(frozen=True, kw_only=True)
class Line:
    """Points of a grid on one curve with the same Δx0, and those that are added between them."""

    grid: str
    dx0: Decimal
    halved: Halved

    def __str__(self) -> str:
        """Return one line for the log."""
        halved = self.halved
        found = [f"{counted(len(halved.added), 'point')} added to {self.grid}"]
        if halved.switches:
            found.append(f"{counted(len(halved.switches), 'change')} of kind closed in")
        if halved.unmet:
            shown = ", ".join(f"{spell(start)} to {spell(stop)}" for start, stop in halved.unmet)
            found.append(f"not within the tolerance at closest: mu0 {shown}")
        return f"dx0 {spell(self.dx0)}: {'; '.join(found)}"


def refined_lines(
    curve: StickingCurve, points: CurvePoints, refinements: Mapping[str, Refinement]
) -> Iterator[Line]:
    """Refine the grids that have points on a curve.

    Parameters
    ----------
    curve : StickingCurve
    points : CurvePoints
        The points of the grids on it.
    refinements : mapping of Refinement
        By name of the grid; a grid without one stays as it is.

    Yields
    ------
    Line
        One for each grid that is refined and each of its Δx0.
    """
    rows = zip(points.mu0, points.dx0, points.grids, strict=True)
    named = sorted(
        (name, dx0, mu0) for mu0, dx0, names in rows for name in names if name in refinements
    )
    for (grid, dx0), line in groupby(named, lambda row: row[:2]):
        refinement = refinements[grid]

        def read(mu0: Sequence[Decimal], dx0: Decimal = dx0, grid: str = grid) -> list[Reading]:
            return _readings(curve, mu0, dx0, refinements[grid].column)

        halved = halve(
            [mu0 for *_, mu0 in line], read, float(refinement.tolerance), refinement.closest
        )
        yield Line(grid=grid, dx0=dx0, halved=halved)


def with_added(points: CurvePoints, lines: Sequence[Line]) -> CurvePoints:
    """Points of the grids on a curve together with those that were added.

    Parameters
    ----------
    points : CurvePoints
    lines : sequence of Line

    Returns
    -------
    CurvePoints
        The same object where nothing was added.
    """
    added: dict[tuple[Decimal, Decimal], list[str]] = {}
    for line in lines:
        for mu0 in line.halved.added:
            added.setdefault((mu0, line.dx0), []).append(line.grid)
    if not added:
        return points
    own = dict(zip(zip(points.mu0, points.dx0, strict=True), points.grids, strict=True))
    names = {pair: sorted([*own.get(pair, []), *added.get(pair, [])]) for pair in own | added}
    return named_points(names, added)


def _readings(
    curve: StickingCurve, mu0: Sequence[Decimal], dx0: Decimal, column: str
) -> list[Reading]:
    """Read a column of the table off a curve, and what happens, at some frictions."""
    if not mu0:
        return []
    points = named_points({(friction, dx0): [] for friction in mu0}, {})
    columns = stiction_columns(points, curve, read_curve(curve, points.mu0, points.dx0))
    values = np.asarray(columns[column], dtype=float)
    kinds = zip(*(columns[name] for name in KIND), np.isfinite(values), strict=True)
    return list(map(Reading, values.tolist(), kinds))
