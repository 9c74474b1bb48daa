"""Points that refinement adds between those of a grid, where the grid is too coarse.

Along μ0 they are read off the curves that are solved already. Along θ and η each is on a curve of
its own, which is solved by itself. Added points depend on nothing but the curves of the grid, the
grid and the refinement: however curves are put into blocks, the same points are added.
"""

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from functools import partial
from itertools import groupby, pairwise, product

import numpy as np

from vibrissa.decimals import spell
from vibrissa.numerics.halving import Halved, Reading, halve
from vibrissa.sticking.curve import StickingCurve
from vibrissa.study.codec import Gap, encode_key
from vibrissa.study.grid import (
    CurveKey,
    CurvePoints,
    Grid,
    Refinement,
    named_points,
    points_of,
    points_on_curves,
)
from vibrissa.tables.points import points_columns
from vibrissa.wording import counted

# Columns that say what happens at a point: where one changes, the change is closed in.
KIND = ("status", "contact", "ends_by")
CurveOf = Callable[[CurveKey], StickingCurve]


@dataclass(frozen=True, kw_only=True)
class Line:
    """Values of an axis that are added to a grid, all else the same.

    Attributes
    ----------
    grid : str
        Name of the grid.
    axis : str
    at : Decimal
        Where the line is: Δx0 of one along μ0; η of one along θ, and θ of one along η.
    halved : Halved
    mounting : str
        Of the rods of a line along θ or η, as in a key; empty where it is ideal.
    """

    grid: str
    axis: str
    at: Decimal
    halved: Halved
    mounting: str = ""

    @property
    def left_over(self) -> Decimal:
        """Length of the gaps that are not within the tolerance, with no change in them."""
        return sum((stop - start for start, stop in self.halved.unmet), Decimal(0))

    def __str__(self) -> str:
        """Return one line for the log."""
        across = {"mu0": "dx0", "theta": "eta", "eta": "theta"}[self.axis]
        halved, found = self.halved, []
        if halved.switches:
            found.append(f"{counted(len(halved.switches), 'change')} of kind closed in")
        if halved.unmet:
            stretches = _joined(halved.unmet)
            shown = ", ".join(f"{spell(start)} to {spell(stop)}" for start, stop in stretches)
            found.append(f"not within the tolerance at closest: {self.axis} {shown}")
        added = f"{counted(len(halved.added), 'value')} of {self.axis} added to {self.grid}"
        place = f"{across} {spell(self.at)} {self.mounting}".strip()
        return "; ".join([f"{place}: {added}", *found])


@dataclass(frozen=True, kw_only=True)
class Refined:
    """Points on some curves, with those that were added.

    Attributes
    ----------
    points : list of (CurveKey, CurvePoints, StickingCurve)
        Curve by curve, first the curves of the grids, then those that were added.
    lines : list of (str, Line)
        What was added along each line; the text names the curve of a line along μ0.
    """

    points: list[tuple[CurveKey, CurvePoints, StickingCurve]]
    lines: list[tuple[str, Line]]

    @property
    def left_over(self) -> list[tuple[str, str, Decimal]]:
        """Grid, axis and length of what is not within the tolerance, line by line."""
        lines = (line for _, line in self.lines)
        return [(line.grid, line.axis, line.left_over) for line in lines if line.left_over]


def refined_points(
    own: Mapping[CurveKey, StickingCurve],
    grids: Mapping[str, Grid],
    refinements: Mapping[str, Refinement],
    gaps: Mapping[str, Mapping[str, Sequence[Gap]]],
    curve_of: CurveOf,
) -> Refined:
    """Points of grids on some curves, and those that refinement adds.

    Parameters
    ----------
    own : mapping of StickingCurve
        The curves, by key.
    grids : mapping of Grid
        By name, the parts of them that are on these curves.
    refinements : mapping of Refinement
        By name of the grid; some grids may have none.
    gaps : mapping
        By name of the grid, the gaps of its axes of curves that begin at these curves.
    curve_of : callable
        As in `curve_lines`.

    Returns
    -------
    Refined
    """
    points: list[tuple[CurveKey, CurvePoints, StickingCurve]] = []
    lines: list[tuple[str, Line]] = []

    def along_mu0(key: CurveKey, curve: StickingCurve, on_curve: CurvePoints) -> CurvePoints:
        found = list(refined_lines(curve, on_curve, refinements))
        lines.extend((" ".join(encode_key(key)), line) for line in found)
        return with_added(on_curve, found)

    for key, on_curve in points_on_curves(own, grids):
        points.append((key, along_mu0(key, own[key], on_curve), own[key]))
    added: dict[CurveKey, dict[str, Grid]] = {}
    for name in sorted(gaps):
        for line, keys in curve_lines(name, grids[name], gaps[name], refinements[name], curve_of):
            lines.append(("", line))
            for key in keys:
                added.setdefault(key, {})[name] = grids[name]
    for key, of_grids in added.items():
        curve = curve_of(key)
        points.append((key, all_added(along_mu0(key, curve, points_of(of_grids))), curve))
    return Refined(points=points, lines=lines)


def _joined(gaps: Sequence[Gap]) -> list[Gap]:
    """Put gaps together, in increasing order, that have an end in common."""
    joined: list[Gap] = []
    for start, stop in gaps:
        before = joined.pop() if joined and joined[-1][1] == start else (start, stop)
        joined.append((before[0], stop))
    return joined


def refined_lines(
    curve: StickingCurve, points: CurvePoints, refinements: Mapping[str, Refinement]
) -> Iterator[Line]:
    """Refine, along μ0, the grids that have points on a curve.

    Parameters
    ----------
    curve : StickingCurve
    points : CurvePoints
        The points of the grids on it.
    refinements : mapping of Refinement
        By name of the grid; a grid without one for μ0 stays as it is.

    Yields
    ------
    Line
        One for each grid that is refined and each of its Δx0.
    """
    rows = zip(points.mu0, points.dx0, points.grids, strict=True)
    refined = {name for name, one in refinements.items() if "mu0" in one.closest}
    named = sorted(
        (name, dx0, mu0) for mu0, dx0, names in rows for name in names if name in refined
    )
    for (grid, dx0), line in groupby(named, lambda row: row[:2]):
        refinement = refinements[grid]
        read = partial(_read_frictions, curve, dx0, refinement.column)
        gaps = list(pairwise(mu0 for *_, mu0 in line))
        halved = halve(gaps, read, float(refinement.tolerance), refinement.closest["mu0"])
        yield Line(grid=grid, axis="mu0", at=dx0, halved=halved)


def with_added(points: CurvePoints, lines: Sequence[Line]) -> CurvePoints:
    """Points of the grids on a curve together with those that were added along μ0.

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
            added.setdefault((mu0, line.at), []).append(line.grid)
    if not added:
        return points
    own = dict(zip(zip(points.mu0, points.dx0, strict=True), points.grids, strict=True))
    names = {pair: sorted([*own.get(pair, []), *added.get(pair, [])]) for pair in own | added}
    return named_points(names, added)


def curve_lines(
    name: str,
    grid: Grid,
    gaps: Mapping[str, Sequence[Gap]],
    refinement: Refinement,
    curve_of: CurveOf,
) -> Iterator[tuple[Line, list[CurveKey]]]:
    """Refine a grid along axes of curves.

    A gap is met if it is for every μ0 and Δx0 of the grid: a curve that is added has them all.

    Parameters
    ----------
    name : str
        Of the grid.
    grid : Grid
        The curves in it are those at which a gap begins.
    gaps : mapping
        By axis, in increasing order.
    refinement : Refinement
    curve_of : callable
        Solves a curve, or has it already.

    Yields
    ------
    line : Line
    keys : list of CurveKey
        Of the curves that are added on it.
    """
    pairs = list(product(grid.mu0, grid.dx0))
    for axis, intervals in gaps.items():
        across = "eta" if axis == "theta" else "theta"
        for at, mounting in product(getattr(grid, across), grid.mountings()):
            start = CurveKey(at, at, None, *mounting)
            read = partial(_read_curves, curve_of, start, axis, pairs, refinement.column)
            closest = refinement.closest[axis]
            halved = halve(intervals, read, float(refinement.tolerance), closest)
            keys = [start._replace(**{axis: value}) for value in halved.added]
            mounted = " ".join(encode_key(start)[2:])
            yield Line(grid=name, axis=axis, at=at, halved=halved, mounting=mounted), keys


def all_added(points: CurvePoints) -> CurvePoints:
    """Points of the grids on a curve that was added to all of them."""
    pairs = zip(points.mu0, points.dx0, strict=True)
    names = dict(zip(pairs, points.grids, strict=True))
    return named_points(names, names)


def _read_frictions(
    curve: StickingCurve, dx0: Decimal, column: str, frictions: Sequence[Decimal]
) -> list[Reading]:
    """Read a column of the table off a curve at some μ0."""
    pairs = [(mu0, dx0) for mu0 in frictions]
    rows = zip(*_readings(curve, pairs, column), strict=True) if pairs else ()
    return [Reading((value,), kind) for value, kind in rows]


def _read_curves(
    curve_of: CurveOf,
    start: CurveKey,
    axis: str,
    pairs: Sequence[tuple[Decimal, Decimal]],
    column: str,
    values: Sequence[Decimal],
) -> list[Reading]:
    """Read a column at all pairs of μ0 and Δx0, off curves with some values of an axis."""
    curves = (curve_of(start._replace(**{axis: value})) for value in values)
    return [Reading(*_readings(curve, pairs, column)) for curve in curves]


def _readings(
    curve: StickingCurve, pairs: Sequence[tuple[Decimal, Decimal]], column: str
) -> tuple[tuple[float, ...], tuple[Hashable, ...]]:
    """Values of a column at pairs of μ0 and Δx0 in increasing order, and what happens there."""
    points = named_points({pair: [] for pair in pairs}, {})
    columns = points_columns([(points, curve)])
    values = np.asarray(columns[column], dtype=float)
    kinds = zip(*(columns[name] for name in KIND), np.isfinite(values), strict=True)
    return tuple(values.tolist()), tuple(kinds)
