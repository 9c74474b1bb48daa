"""The search for the rod that measures friction best: θ, η, d0 and L.

The best d0 and L of each pair (θ, η) are found directly (`vibrissa.design.sizes`). So only θ and η
are searched, on a mesh that is refined around the best pair.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vibrissa.design.limits import Check, limits_of
from vibrissa.design.pairs import Pairs, survey
from vibrissa.design.requirements import Requirements
from vibrissa.design.result import Design, DesignStatus
from vibrissa.design.sizes import ROUNDING, Sizes, best_sizes, deviations, nearest_sizes
from vibrissa.design.stock import near
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.whisker import Progress, quiet

# Values of θ and η at which a search begins, and how often the mesh is halved around the best pair.
TAPERS, HEIGHTS, ROUNDS = 10, 14, 5
# Rounds of the search with a relaxed limit, which begins at the best pair.
RELAXED_ROUNDS = 2
# Pairs that are solved before the progress is told.
PAIRS_AT_ONCE = 64
# A limit counts as used up from here on, as the mesh is not infinitely fine.
USED_UP = 0.97


def design(requirements: Requirements, progress: Progress = quiet) -> Design:
    """Find the rod that measures friction best, and say what limits it.

    The best rod has the smallest standard deviation of μ0 from one period of sticking, at that μ0
    of the range where it is largest.

    Parameters
    ----------
    requirements : Requirements
        A rod of which they give all four sizes is only checked.
    progress : callable
        Told what is being done, how many curves are solved and about how many there are.

    Returns
    -------
    Design

    Examples
    --------
    The paper's rod, of structural steel:

    >>> from vibrissa.design import read_requirements
    >>> steel = {"material": "steel-s235", "diameter": "5 mm", "length": "100 mm"}
    >>> shape = {"theta": "2", "eta": "0.85"}
    >>> asked = {"transducer": "nano17-si-12-0.12", "step": "50 um", "mu0": "0.2 to 0.4"}
    >>> result = design(read_requirements(**steel, **shape, **asked))
    >>> print(result.status, *result.active_constraints)
    none moment_z force_y force_x strain
    """
    search = _Search(requirements, progress)
    if not search.parts:
        message = f"no such rod could be solved: {search.failures[0]}"
        return Design(status=DesignStatus.FAILED, message=message, requirements=requirements)
    best = search.refine(requirements, ROUNDS)
    found = _result(requirements, search.pairs, best)
    if found.status is DesignStatus.FOUND and not requirements.given:
        changes = _relaxed(requirements, search.pairs, found.active_constraints)
        bests = {name: search.refine(new, RELAXED_ROUNDS) for name, new in changes.items()}
        relaxed = {name: float(other.deviation.min()) for name, other in bests.items()}
        found = replace(found, relaxed=relaxed)
    if found.status is DesignStatus.FOUND and requirements.stock:
        found = _of_stock(search, found)
    progress("solving", search.total, search.total)
    return found


def _of_stock(search: "_Search", any_size: Design) -> Design:
    """Take the best of the rods whose diameter is of the stock; none may keep to all limits."""
    asked, relaxed = any_size.requirements, any_size.relaxed
    sizes = near(asked.stock, any_size.diameter)
    tried = [replace(asked, diameter=(size, size), stock=()) for size in sizes]
    for one in tried:
        search.refine(one, ROUNDS)
    # Each among all pairs that are solved by now.
    bests = [_best(one, search.pairs) for one in tried]
    costs = [best.deviation.min() for best in bests]
    chosen = int(np.argmin(costs))
    if not np.isfinite(costs[chosen]):
        shown = ", ".join(f"{1e3 * size:.4g}" for size in sizes)
        message = f"no rod of a stock diameter near the best ({shown} mm) keeps to all limits"
        return replace(any_size, status=DesignStatus.NONE, message=f"{message}; shown is the best")
    found = _result(tried[chosen], search.pairs, bests[chosen])
    any_size = _result(asked, search.pairs, _best(asked, search.pairs))
    return replace(found, relaxed=relaxed, any_size=any_size)


@dataclass(frozen=True, kw_only=True)
class _Axis:
    """A coordinate of the mesh, from 0 to 1 along a range; values are spaced geometrically."""

    start: float
    stop: float
    count: int

    @property
    def nodes(self) -> FloatArray:
        """Coordinates of the mesh before it is refined; one if a value is given."""
        return np.linspace(0.0, 1.0, self.count if self.start != self.stop else 1)

    def values(self, coordinates: FloatArray) -> FloatArray:
        """Values at coordinates, of which those beyond the ends count as the ends."""
        ratio = self.stop / self.start
        return np.asarray(self.start * ratio ** np.clip(coordinates, 0.0, 1.0))

    def around(self, value: float, rounds: int) -> FloatArray:
        """Coordinates of a value and its neighbours on a mesh that is halved so many times."""
        if self.start == self.stop:
            return self.nodes
        at = np.log(value / self.start) / np.log(self.stop / self.start)
        spacing = 1.0 / (self.count - 1)
        return np.asarray(at + np.array([-1.0, 0.0, 1.0]) / 2**rounds * spacing)


@dataclass(frozen=True, eq=False, kw_only=True)
class _Best:
    """The best of n pairs (θ, η), and whether it keeps to all limits.

    `sizes` are the best of each pair, or those that violate the limits least. `deviation` is the
    standard deviation of μ0 with the best size of each pair, infinite where there is none.
    """

    found: bool
    row: int
    sizes: Sizes
    deviation: FloatArray


def _best(requirements: Requirements, pairs: Pairs) -> _Best:
    """Choose the pair with the smallest standard deviation, or the smallest violation of limits."""
    sizes = best_sizes(requirements, pairs)
    deviation = sizes.cost
    found = bool(np.isfinite(deviation).any())
    if not found:
        sizes = nearest_sizes(requirements, pairs)
    return _Best(found=found, row=int(np.argmin(sizes.cost)), sizes=sizes, deviation=deviation)


class _Search:
    """Pairs (θ, η) that were solved: a mesh, geometric in θ and in 1 − η."""

    def __init__(self, requirements: Requirements, progress: Progress) -> None:
        self.requirements, self.progress = requirements, progress
        (theta, theta_end), (eta, eta_end) = requirements.theta, requirements.eta
        self.tapers = _Axis(start=theta, stop=theta_end, count=TAPERS)
        self.gaps = _Axis(start=1.0 - eta, stop=1.0 - eta_end, count=HEIGHTS)
        self.known: set[tuple[float, float]] = set()
        self.parts: list[Pairs] = []
        self.failures: list[str] = []
        nodes = self.tapers.nodes, self.gaps.nodes
        # About so many curves will be solved.
        neighbours = 3 ** sum(len(x) > 1 for x in nodes) - 1
        self.total = len(nodes[0]) * len(nodes[1]) + 2 * ROUNDS * neighbours
        self._solve(*nodes)

    @property
    def pairs(self) -> Pairs:
        """All pairs that were solved."""
        return Pairs.concatenate(self.parts)

    def refine(self, requirements: Requirements, rounds: int) -> _Best:
        """Halve the mesh around the best pair so often, and return the best."""
        best = _best(requirements, self.pairs)
        for done in range(1, rounds + 1):
            theta, eta = (float(x[best.row]) for x in (self.pairs.theta, self.pairs.eta))
            self._solve(self.tapers.around(theta, done), self.gaps.around(1.0 - eta, done))
            best = _best(requirements, self.pairs)
        return best

    def _solve(self, u: FloatArray, v: FloatArray) -> None:
        """Solve the pairs at all coordinates of θ and 1 − η that are not known."""
        theta, gap = np.meshgrid(self.tapers.values(u), self.gaps.values(v))
        rounded = (theta.ravel().round(12).tolist(), (1.0 - gap).ravel().round(12).tolist())
        pairs = dict.fromkeys(zip(*rounded, strict=True))
        new = [pair for pair in pairs if pair not in self.known]
        for start in range(0, len(new), PAIRS_AT_ONCE):
            some = new[start : start + PAIRS_AT_ONCE]
            taper, eta = np.array(some).T
            frictions, contact = self.requirements.frictions, self.requirements.contact
            solved, failures = survey(taper, eta, frictions, contact)
            self.parts += [] if solved is None else [solved]
            self.failures += failures
            self.known |= set(some)
            self.progress("solving", min(len(self.known), self.total - 1), self.total)


def _result(requirements: Requirements, pairs: Pairs, best: _Best) -> Design:
    """Check the best rod against the limits, and put together what is known of it."""
    row = np.array([best.row])
    rod, size = pairs.take(row), best.sizes.take(row)
    limits = [limit for limit in limits_of(requirements, rod) if not limit.given]
    checks = [limit.check(size.diameter, size.length) for limit in limits]
    theta, eta, diameter, length = (
        float(x[0]) for x in (rod.theta, rod.eta, size.diameter, size.length)
    )
    # Where a rod is found the mesh leaves a little of each limit, otherwise rounding exceeds it.
    least = USED_UP if best.found else 1.0 + ROUNDING
    active = [check.name for check in _by_use(checks) if check.use >= least]
    if best.found:
        active += _at_ends(requirements, theta, eta)
        message = f"{'this' if requirements.given else 'the best'} rod keeps to all limits"
        message += f"; active constraints: {', '.join(active)}" if active else ""
    else:
        message = _why_none(requirements, pairs, checks, active)
    return Design(
        status=DesignStatus.FOUND if best.found else DesignStatus.NONE,
        message=message,
        requirements=requirements,
        theta=theta,
        eta=eta,
        diameter=diameter,
        length=length,
        mu_lock=float(rod.mu_lock[0]),
        x0_slip=rod.x0_slip[0] * length,
        deviations=deviations(requirements, rod, size.diameter, size.length).take(0),
        checks=checks,
        active_constraints=active,
        pairs=pairs,
        pair_deviation=best.deviation,
    )


def _by_use(checks: Sequence[Check]) -> list[Check]:
    """Limits in the order of their use; rounding does not order those that are used up alike."""
    return sorted(checks, key=lambda check: -float(f"{check.use:.3g}"))


def _at_ends(requirements: Requirements, theta: float, eta: float) -> list[str]:
    """Name θ and η where they are at an end of a range."""
    ranges = ("theta", requirements.theta, theta), ("eta", requirements.eta, eta)
    return [name for name, (low, high), x in ranges if low < high and not low < x < high]


def _relaxed(
    requirements: Requirements, pairs: Pairs, active: Sequence[str]
) -> dict[str, Requirements]:
    """Relax one thing at a time: noise, step, and each active constraint."""
    x, y, z = requirements.noise
    limits = limits_of(requirements, pairs)
    rooms = {limit.name: limit.room for limit in limits if limit.room > 1.0}
    return {
        "noise": replace(requirements, noise=(0.5 * x, 0.5 * y, 0.5 * z)),
        "step": replace(requirements, step=0.5 * requirements.step),
    } | {name: replace(requirements, room={name: rooms[name]}) for name in active if name in rooms}


def _why_none(
    requirements: Requirements, pairs: Pairs, checks: Sequence[Check], violated: Sequence[str]
) -> str:
    """Say which limits leave no rod."""
    factors = ", ".join(
        f"{check.name} (by a factor of {check.use:.3g})"
        for check in _by_use(checks)
        if check.name in violated
    )
    if requirements.given:
        return f"this rod cannot be used: it violates the limits {factors}"
    alone = []
    for check in checks:
        others = replace(requirements, room={check.name: np.inf})
        if check.use >= USED_UP and np.isfinite(best_sizes(others, pairs).cost).any():
            alone.append(check.name)
    advice = "no single limit is the cause"
    if alone:
        advice = f"there would be one without the limit {' or '.join(alone)}"
    return f"no rod keeps to all limits: the closest one violates {factors}; {advice}"
