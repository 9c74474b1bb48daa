"""The study grid: axes of exact decimals, named grids, and the blocks that jobs work on.

A *point* is (θ, μ0, η, Δx0). A *curve key* names what has to be solved for it: (θ, η), and Δx0 as
well where the solver walks along the steps. A *block* is a fixed set of curve keys, solved by one
job and named by a hash of its contents. Everything here is light enough for a Snakefile.
"""

import hashlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from itertools import product
from typing import NamedTuple

from vibrissa.decimals import exact, spell

AXES = ("theta", "mu0", "eta", "dx0")
# Longer axes are typing errors: 10^6 points are three axes of 100.
LONGEST_AXIS = 1_000_000

# A curve key: the values spelled as plain decimals, in the order theta, eta and perhaps dx0.
CurveKey = tuple[str, ...]
Blocks = dict[str, tuple[CurveKey, ...]]


class Point(NamedTuple):
    """A grid point, in exact decimals."""

    theta: Decimal
    mu0: Decimal
    eta: Decimal
    dx0: Decimal


@dataclass(frozen=True)
class Grid:
    """Product of four axes.

    Attributes
    ----------
    theta, mu0, eta, dx0 : tuple of Decimal
        Distinct values, increasing.
    """

    theta: tuple[Decimal, ...]
    mu0: tuple[Decimal, ...]
    eta: tuple[Decimal, ...]
    dx0: tuple[Decimal, ...]

    def points(self) -> Iterable[Point]:
        """All points of the grid."""
        return (Point(*values) for values in product(self.theta, self.mu0, self.eta, self.dx0))

    def curve_keys(self, by_step: bool) -> Iterable[CurveKey]:
        """Return the curves that the grid needs, one for each step size if `by_step`."""
        axes = (self.theta, self.eta, self.dx0) if by_step else (self.theta, self.eta)
        return (_spelled_key(values) for values in product(*axes))


@dataclass(frozen=True, eq=False)
class Pairs:
    """Pairs of μ0 and Δx0 that go with a curve, ordered by μ0, then Δx0.

    Attributes
    ----------
    mu0, dx0 : tuple of Decimal, length n
    grids : list of list of str, length n
        Names of the grids that have the pair.
    """

    mu0: tuple[Decimal, ...]
    dx0: tuple[Decimal, ...]
    grids: list[list[str]]

    def __len__(self) -> int:
        """Return the number of pairs."""
        return len(self.mu0)


def axis(values: Sequence[float] | Mapping[str, float]) -> tuple[Decimal, ...]:
    """Exact values of an axis, in increasing order and without repetition.

    Parameters
    ----------
    values : sequence of numbers, or mapping
        The values, or ``start``, ``stop`` (included) and ``step``.

    Returns
    -------
    tuple of Decimal

    Raises
    ------
    ValueError
        If a value is not a finite number, the stop is not a whole number of steps from the start,
        or there are more than `LONGEST_AXIS` values.
    """
    if not isinstance(values, Mapping):
        return tuple(sorted({exact(value) for value in values}))
    start, stop, step = (exact(values[name]) for name in ("start", "stop", "step"))
    steps = Fraction(stop - start) / Fraction(step)
    if steps >= LONGEST_AXIS:
        raise ValueError(f"an axis has at most {LONGEST_AXIS} values")
    if steps < 0 or steps.denominator != 1:
        raise ValueError(
            f"stop {spell(stop)} must be start {spell(start)} plus a whole number of steps of "
            f"{spell(step)}"
        )
    return tuple((start + i * step).normalize() for i in range(int(steps) + 1))


def curve_key(point: Point, by_step: bool) -> CurveKey:
    """Key of the curve that a point is read off; see `curve_keys` for `by_step`."""
    return _spelled_key(
        (point.theta, point.eta, point.dx0) if by_step else (point.theta, point.eta)
    )


def _spelled_key(values: Iterable[Decimal]) -> CurveKey:
    return tuple(spell(value) for value in values)


def curve_keys(grids: Iterable[Grid], by_step: bool) -> list[CurveKey]:
    """Curves that a study needs, each once, ordered by η, then θ, then Δx0.

    Parameters
    ----------
    grids : iterable of Grid
    by_step : bool
        Whether a curve belongs to one Δx0 (shooting) or serves all (collocation).

    Returns
    -------
    list of CurveKey
    """
    keys = {key for grid in grids for key in grid.curve_keys(by_step)}
    return sorted(keys, key=_order)


def partition(keys: Sequence[CurveKey], size: int, known: Blocks) -> Blocks:
    """Distribute curves over blocks, keeping every block that exists.

    An extended grid adds blocks for what is new and leaves the rest as it is, wherever on an axis
    the new values lie: nothing is renamed and nothing solved twice.

    Parameters
    ----------
    keys : sequence of CurveKey
        Curves that are needed.
    size : int
        Largest number of curves in a new block.
    known : dict
        Blocks that exist, by name.

    Returns
    -------
    dict
        Blocks that hold at least one needed curve, known ones first.

    Raises
    ------
    ValueError
        If the size is not positive.
    """
    if size < 1:
        raise ValueError(f"a block holds at least one curve, got block_size {size}")
    wanted = set(keys)
    blocks = {name: members for name, members in known.items() if wanted.intersection(members)}
    wanted.difference_update(*blocks.values())
    new = [key for key in keys if key in wanted]
    for first in range(0, len(new), size):
        members = tuple(new[first : first + size])
        blocks[block_name(members)] = members
    return blocks


def block_name(members: Sequence[CurveKey]) -> str:
    """Name of a block: a hash of its curves, the same wherever and whenever it is made."""
    text = ";".join(",".join(key) for key in members)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def block_readings(
    members: Sequence[CurveKey], grids: Mapping[str, Grid]
) -> dict[str, dict[str, list[str]]]:
    """Grids that read a block's curves, cut down to the part of them that does.

    Parameters
    ----------
    members : sequence of CurveKey
    grids : mapping of Grid
        The study's grids by name.

    Returns
    -------
    dict
        By grid name its axes, spelled; plain values, so that Snakemake sees a change of what a
        block is read for and nothing else.
    """
    thetas, etas = ({key[position] for key in members} for position in (0, 1))
    steps = {key[2] for key in members if len(key) > 2}
    readings = {}
    for name, grid in grids.items():
        part = {
            "theta": [spell(v) for v in grid.theta if spell(v) in thetas],
            "mu0": [spell(v) for v in grid.mu0],
            "eta": [spell(v) for v in grid.eta if spell(v) in etas],
            "dx0": [spell(v) for v in grid.dx0 if not steps or spell(v) in steps],
        }
        if all(part.values()):
            readings[name] = part
    return readings


def spelled(grid: Grid) -> dict[str, list[str]]:
    """Plain form of a grid, for the parameters of a job."""
    return {name: spelled_axis(getattr(grid, name)) for name in AXES}


def spelled_axis(values: Iterable[Decimal]) -> list[str]:
    """Plain form of an axis."""
    return [spell(value) for value in values]


def from_spelled(axes: Mapping[str, Sequence[str]]) -> Grid:
    """Inverse of `spelled`."""
    return Grid(*(tuple(Decimal(value) for value in axes[name]) for name in AXES))


def readings(
    keys: Iterable[CurveKey], grids: Mapping[str, Grid]
) -> Iterator[tuple[CurveKey, Pairs]]:
    """Pairs of μ0 and Δx0 that are read off curves.

    Parameters
    ----------
    keys : iterable of CurveKey
    grids : mapping of Grid
        Grids by name.

    Yields
    ------
    key : CurveKey
        Of a curve that some grid uses.
    pairs : Pairs
        One and the same wherever the same grids meet.
    """
    values = {name: (set(grid.theta), set(grid.eta), set(grid.dx0)) for name, grid in grids.items()}
    known: dict[tuple[tuple[str, ...], tuple[Decimal, ...]], Pairs] = {}
    for key in keys:
        theta, eta, *step = (Decimal(value) for value in key)
        names = tuple(
            name
            for name, (thetas, etas, steps) in values.items()
            if theta in thetas and eta in etas and steps.issuperset(step)
        )
        if names:
            found = names, tuple(step)
            if found not in known:
                known[found] = _pairs({name: grids[name] for name in names}, step)
            yield key, known[found]


def study_points(grids: Mapping[str, Grid]) -> Iterator[tuple[Decimal, Decimal, Pairs]]:
    """All points of a study, each once, in the order of its table: by η, θ, μ0, Δx0.

    Parameters
    ----------
    grids : mapping of Grid
        Grids by name.

    Yields
    ------
    theta, eta : Decimal
    pairs : Pairs
        One and the same wherever the same grids meet.
    """
    thetas = {name: set(grid.theta) for name, grid in grids.items()}
    known: dict[tuple[str, ...], Pairs] = {}
    for eta in sorted({eta for grid in grids.values() for eta in grid.eta}):
        here = [name for name, grid in grids.items() if eta in grid.eta]
        for theta in sorted(set().union(*(thetas[name] for name in here))):
            names = tuple(name for name in here if theta in thetas[name])
            if names not in known:
                known[names] = _pairs({name: grids[name] for name in names})
            yield theta, eta, known[names]


def _pairs(grids: Mapping[str, Grid], step: Sequence[Decimal] = ()) -> Pairs:
    """Pairs of some grids, all or those of one Δx0."""
    names: dict[tuple[Decimal, Decimal], list[str]] = {}
    for name, grid in sorted(grids.items()):
        for pair in product(grid.mu0, step or grid.dx0):
            names.setdefault(pair, []).append(name)
    mu0, dx0 = zip(*sorted(names), strict=True)
    return Pairs(mu0, dx0, [names[pair] for pair in sorted(names)])


def _order(key: CurveKey) -> tuple[Decimal, ...]:
    theta, eta, *step = (Decimal(value) for value in key)
    return (eta, theta, *step)
