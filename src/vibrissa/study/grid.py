"""The study grid: axes of exact values, named grids, and the curves that their points lie on.

A *point* is (θ, μ0, η, Δx0), and where its rod is not mounted as in the paper four numbers more. A
*curve key* names what has to be solved for it: all but μ0 and Δx0, and Δx0 as well where the solver
walks along the steps. Everything here is light enough for a Snakefile.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from itertools import product
from typing import Any, NamedTuple

from vibrissa.decimals import Value, exact, order_of, spell
from vibrissa.errors import ArgumentError
from vibrissa.study.boxes import Box, members

# The axes of a grid, in their order in names, tables and messages.
AXES = ("theta", "mu0", "eta", "dx0")
# Further axes, of how the rod is mounted, which a grid may have. Without them it is ideal: 0.
MOUNTING_AXES = ("clamp_angle", "clamp_compliance", "curvature", "stage_angle")
ZERO = Decimal(0)
# Axes of curves along which points can be added.
REFINED_CURVE_AXES = ("theta", "eta")
# The axes of curves, in the order of curves in blocks and tables.
CURVE_AXES = ("eta", "theta", *MOUNTING_AXES, "dx0")
# Longer axes are typing errors: 10^6 points are three axes of 100.
LONGEST_AXIS = 1_000_000


class CurveKey(NamedTuple):
    """What a sticking curve is solved for.

    Attributes
    ----------
    theta, eta : Decimal
        Taper factor and distance between clamp and surface (L).
    dx0 : Decimal or None
        Step of the clamp (L) that the solver walks in; None where one curve serves all steps.
    clamp_angle, clamp_compliance, curvature, stage_angle : Decimal
        Mounting of the rod (rad, L/(E·I0), 1/L, rad); the curvature may be a polynomial.
    """

    theta: Decimal
    eta: Decimal
    dx0: Decimal | None = None
    clamp_angle: Decimal = ZERO
    clamp_compliance: Decimal = ZERO
    curvature: Value = ZERO
    stage_angle: Decimal = ZERO

    @property
    def mounting(self) -> tuple[Any, ...]:
        """Values of `MOUNTING_AXES`."""
        return self[3:]


class Point(NamedTuple):
    """A grid point, in exact decimals."""

    theta: Decimal
    mu0: Decimal
    eta: Decimal
    dx0: Decimal
    clamp_angle: Decimal = ZERO
    clamp_compliance: Decimal = ZERO
    curvature: Value = ZERO
    stage_angle: Decimal = ZERO

    @property
    def mounting(self) -> tuple[Any, ...]:
        """Values of `MOUNTING_AXES`."""
        return self[4:]

    def curve_key(self, by_step: bool) -> CurveKey:
        """Key of the curve that the point lies on; see `curve_keys` for `by_step`."""
        return CurveKey(self.theta, self.eta, self.dx0 if by_step else None, *self.mounting)


@dataclass(frozen=True, kw_only=True)
class Grid:
    """Product of four axes, and of those of the mounting.

    Attributes
    ----------
    theta, mu0, eta, dx0 : tuple of Decimal
        Distinct values, increasing.
    clamp_angle, clamp_compliance, curvature, stage_angle : tuple of Decimal
        Likewise.
    """

    theta: tuple[Decimal, ...]
    mu0: tuple[Decimal, ...]
    eta: tuple[Decimal, ...]
    dx0: tuple[Decimal, ...]
    clamp_angle: tuple[Decimal, ...] = (ZERO,)
    clamp_compliance: tuple[Decimal, ...] = (ZERO,)
    curvature: tuple[Value, ...] = (ZERO,)
    stage_angle: tuple[Decimal, ...] = (ZERO,)

    @property
    def axes(self) -> dict[str, tuple[Any, ...]]:
        """Axes by name; those of the mounting as far as they are not 0 alone."""
        return {
            name: values for name, values in vars(self).items() if name in AXES or values != (ZERO,)
        }

    def mountings(self) -> Iterable[tuple[Any, ...]]:
        """All combinations of the axes of the mounting."""
        return product(*(getattr(self, name) for name in MOUNTING_AXES))

    def points(self) -> Iterable[Point]:
        """All points of the grid."""
        axes = self.theta, self.mu0, self.eta, self.dx0
        return (
            Point(*values, *mounting)
            for values, mounting in product(product(*axes), self.mountings())
        )

    def curves(self, by_step: bool) -> Box:
        """Return the curves that the grid needs, one for each step size if `by_step`."""
        axes = {name: getattr(self, name) for name in CURVE_AXES}
        return axes if by_step else axes | {"dx0": (None,)}


@dataclass(frozen=True, kw_only=True)
class Refinement:
    """How points are added to a grid; `vibrissa.numerics.halving` says between which.

    Attributes
    ----------
    column : str
        Of the table of grid points, what is to be known between them.
    tolerance : Decimal
        How far it may be from a straight line between two points, in its unit.
    closest : mapping of Decimal
        By axis along which points are added, their least distance from the next.
    """

    column: str
    tolerance: Decimal
    closest: Mapping[str, Decimal]

    @property
    def curve_axes(self) -> tuple[str, ...]:
        """Axes along which each added value is a curve of its own."""
        return tuple(axis for axis in REFINED_CURVE_AXES if axis in self.closest)


def most_added(gap: Decimal, closest: Decimal) -> int:
    """Count the points that halving can add to a gap until none is closer to the next than this.

    Examples
    --------
    >>> most_added(Decimal("0.1"), Decimal("0.025"))
    3
    """
    halvings = 0
    while gap >= 2 * closest * 2**halvings:
        halvings += 1
    return int(2**halvings) - 1


@dataclass(frozen=True, eq=False, kw_only=True)
class CurvePoints:
    """Grid points on one curve, ordered by μ0, then Δx0.

    Attributes
    ----------
    mu0, dx0 : tuple of Decimal, length n
        Friction coefficient and step of each point.
    grids : list of list of str, length n
        Names of the grids that have the point.
    added_to : list of (list of str or None), length n
        Names of those that a refinement added it to; None where the point is on the axes of all.
    """

    mu0: tuple[Decimal, ...]
    dx0: tuple[Decimal, ...]
    grids: list[list[str]]
    added_to: list[list[str] | None]

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.mu0)


def equal_steps(start: Decimal, stop: Decimal, step: Decimal) -> tuple[Decimal, ...]:
    """Values from start to stop, both included, in equal steps.

    Parameters
    ----------
    start, stop, step : Decimal
        The step is positive.

    Returns
    -------
    tuple of Decimal

    Raises
    ------
    ArgumentError
        If the stop is not a whole number of steps from the start, or there are more than
        `LONGEST_AXIS` values.
    """
    count = count_of_steps(start, stop, step) + 1
    return tuple(exact(start + i * step) for i in range(count))


def count_of_steps(start: Decimal, stop: Decimal, step: Decimal) -> int:
    """Count the equal steps from start to stop; see `equal_steps`."""
    steps = Fraction(stop - start) / Fraction(step)
    if steps >= LONGEST_AXIS:
        raise ArgumentError(f"an axis has at most {LONGEST_AXIS} values")
    if steps < 0 or steps.denominator != 1:
        raise ArgumentError(
            f"stop {spell(stop)} must be start {spell(start)} plus a whole number of steps of "
            f"{spell(step)}"
        )
    return int(steps)


def keys_of(curves: Box) -> Iterator[CurveKey]:
    """Keys of the curves of a box, in its order."""
    return (CurveKey(**dict(zip(curves, values, strict=True))) for values in members(curves))


def curve_keys(curves: Sequence[Box]) -> Iterator[CurveKey]:
    """Curves of some boxes, each once, ordered by η, then θ, then the mounting, then Δx0.

    Parameters
    ----------
    curves : sequence of Box
        With the axes `CURVE_AXES`; they may have curves in common.

    Yields
    ------
    CurveKey
    """
    rests: dict[tuple[int, ...], list[tuple[Any, ...]]] = {}
    for eta, at_eta in _sections(dict(enumerate(curves)), "eta"):
        for theta, here in _sections(at_eta, "theta"):
            if (found := tuple(here)) not in rests:
                rests[found] = _rests(here.values())
            for dx0, *mounting in rests[found]:
                yield CurveKey(theta, eta, dx0, *mounting)


def _sections(boxes: Mapping[int, Box], axis: str) -> Iterator[tuple[Decimal, dict[int, Box]]]:
    """Values of an axis in order, each with the boxes that have it."""
    held = {number: frozenset(box[axis]) for number, box in boxes.items()}
    for value in sorted(frozenset().union(*held.values())):
        yield value, {number: boxes[number] for number in boxes if value in held[number]}


def _rests(boxes: Iterable[Box]) -> list[tuple[Any, ...]]:
    """Return steps and mountings of some boxes, each once, ordered by the mounting."""
    names = ("dx0", *MOUNTING_AXES)
    found = {values for box in boxes for values in product(*(box[name] for name in names))}
    return sorted(found, key=lambda values: (*map(order_of, values[1:]), values[0]))


def points_on_curves(
    keys: Iterable[CurveKey], grids: Mapping[str, Grid]
) -> Iterator[tuple[CurveKey, CurvePoints]]:
    """Grid points on each of some curves.

    Parameters
    ----------
    keys : iterable of CurveKey
    grids : mapping of Grid
        Grids by name.

    Yields
    ------
    key : CurveKey
        Of a curve that some grid uses.
    points : CurvePoints
        One and the same object wherever the same grids meet.
    """
    axes = {
        name: (set(grid.theta), set(grid.eta), {None, *grid.dx0}, set(grid.mountings()))
        for name, grid in grids.items()
    }
    known: dict[tuple[tuple[str, ...], Decimal | None], CurvePoints] = {}
    for key in keys:
        names = tuple(
            name
            for name, (thetas, etas, steps, mountings) in axes.items()
            if key.theta in thetas
            and key.eta in etas
            and key.dx0 in steps
            and key.mounting in mountings
        )
        if names:
            found = names, key.dx0
            if found not in known:
                known[found] = points_of({name: grids[name] for name in names}, key.dx0)
            yield key, known[found]


def study_points(grids: Mapping[str, Grid]) -> Iterator[tuple[CurveKey, CurvePoints]]:
    """All points of a study, each once, in the order of its table: by η, θ, mounting, μ0, Δx0.

    Parameters
    ----------
    grids : mapping of Grid
        Grids by name.

    Yields
    ------
    key : CurveKey
        The points' θ, η and mounting; their steps are among the points.
    points : CurvePoints
        One and the same object wherever the same grids meet.
    """
    boxes = [grid.curves(by_step=False) for grid in grids.values()]
    return points_on_curves(curve_keys(boxes), grids)


def points_of(grids: Mapping[str, Grid], step: Decimal | None = None) -> CurvePoints:
    """Points that some grids have on a curve that all of them use, all or those of one Δx0."""
    names: dict[tuple[Decimal, Decimal], list[str]] = {}
    for name, grid in sorted(grids.items()):
        for pair in product(grid.mu0, grid.dx0 if step is None else (step,)):
            names.setdefault(pair, []).append(name)
    return named_points(names, {})


def named_points(
    names: Mapping[tuple[Decimal, Decimal], list[str]],
    added: Mapping[tuple[Decimal, Decimal], list[str]],
) -> CurvePoints:
    """Points on one curve, from the names of the grids that have a pair of μ0 and Δx0.

    Parameters
    ----------
    names : mapping of list of str
        At least one pair.
    added : mapping of list of str
        The names, of pairs among these, of grids that a refinement added them to.

    Returns
    -------
    CurvePoints
    """
    pairs = sorted(names)
    mu0, dx0 = zip(*pairs, strict=True)
    return CurvePoints(
        mu0=mu0,
        dx0=dx0,
        grids=[names[pair] for pair in pairs],
        added_to=[added.get(pair) for pair in pairs],
    )
