"""Which rod measures friction best: θ, η, d0 and L for a material, a transducer and a stage.

For each (θ, η) every limit is straight in the logarithms of d0 and L, and the deviation of μ0,
convex in them, falls as d0 grows (`vibrissa.sensor.limits`). So the best rod is as thick as the
limits allow, and its length is sought along one line (`best_sizes`). What is left is a search over
(θ, η) (`design`).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Any

import numpy as np
from scipy.optimize import linprog

from vibrissa.arrays import BoolArray, FloatArray
from vibrissa.collocation import BATCH
from vibrissa.sensor.limits import (
    FRICTIONS,
    HUGE,
    Limit,
    Shapes,
    deviations,
    limits_of,
    survey,
)
from vibrissa.sensor.quantities import Kind
from vibrissa.sensor.requirements import Requirements
from vibrissa.units import Rod

# Values of θ and η at which a search begins, and how often the mesh is halved around the best.
TAPERS, HEIGHTS, ROUNDS = 10, 14, 5
# Lengths among which the best is sought, twice: on the whole range and around the best of those.
LENGTHS = 129
# A limit is used up from here on: the search comes no closer to where it is.
USED_UP = 0.97
# By this much, in logarithms, a limit may be exceeded: a rod that was found keeps to its limits
# when it is solved again.
ROUNDING = 1e-6


def _worst(
    requirements: Requirements, shapes: Shapes, diameter: FloatArray, length: FloatArray
) -> FloatArray:
    step, reading = deviations(requirements, shapes, diameter, length)
    return np.asarray(np.hypot(step, reading).max(axis=-1))


def best_sizes(
    requirements: Requirements, shapes: Shapes, without: str = ""
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Sizes that measure best within the limits, for each (θ, η).

    Parameters
    ----------
    requirements : Requirements
    shapes : Shapes
        n pairs (θ, η).
    without : str
        A limit that is left out.

    Returns
    -------
    deviation, diameter, length : ndarray, shape (n,)
        Largest standard deviation of μ0 in the range, and the sizes (m); infinite and NaN where
        no size keeps to all limits.
    """
    uses = [x.log_use for x in limits_of(requirements, shapes) if x.name != without]
    low, high, possible = _lengths(uses, len(shapes))
    best = low.copy()
    thickness = np.zeros(len(shapes))
    for _ in range(2):
        part = np.linspace(0.0, 1.0, LENGTHS)
        log_length = low[:, None] + (high - low)[:, None] * part
        thickest = [-(c[:, None] + q * log_length) / p for c, p, q in uses if p > 0]
        log_diameter = np.min(thickest, axis=0)
        worst = _worst(requirements, shapes, np.exp(log_diameter), np.exp(log_length))
        rows, column = np.arange(len(shapes)), np.argmin(np.nan_to_num(worst, nan=np.inf), axis=1)
        best, thickness = log_length[rows, column], log_diameter[rows, column]
        deviation = worst[rows, column]
        low, high = (
            log_length[rows, np.maximum(column - 1, 0)],
            log_length[rows, np.minimum(column + 1, LENGTHS - 1)],
        )
    good = possible & np.isfinite(deviation)
    return (
        np.where(good, deviation, np.inf),
        np.where(good, np.exp(thickness), np.nan),
        np.where(good, np.exp(best), np.nan),
    )


def _lengths(
    uses: Sequence[tuple[FloatArray, int, int]], n: int
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Logarithms of the least and largest length for which some diameter keeps to all limits."""
    low, high, possible = np.full(n, -np.inf), np.full(n, np.inf), np.ones(n, dtype=bool)
    # c + q·ln L ≤ 0: from limits without d0, and from each pair of an upper and a lower one to it.
    rows = [(c, float(q)) for c, p, q in uses if p == 0]
    for c, p, q in uses:
        for other, below, power in uses:
            if p > 0 > below:
                rows.append((c / p - other / below, q / p - power / below))
    for c, slope in rows:
        if slope == 0.0:
            possible &= c <= ROUNDING
        elif slope > 0.0:
            high = np.minimum(high, -c / slope)
        else:
            low = np.maximum(low, -c / slope)
    possible &= low <= high + ROUNDING
    # Where nothing is possible any length will do: it is not used.
    high = np.maximum(low, high)
    return np.clip(low, -HUGE, HUGE), np.clip(high, -HUGE, HUGE), possible


def nearest_sizes(
    requirements: Requirements, shapes: Shapes
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Sizes, among those to choose from, that exceed the limits least.

    Parameters
    ----------
    requirements : Requirements
    shapes : Shapes
        n pairs (θ, η).

    Returns
    -------
    excess, diameter, length : ndarray, shape (n,)
        Logarithm of the largest excess over a limit, and the sizes (m).
    """
    limits = limits_of(requirements, shapes)
    rows = [(*limit.log_use, 0.0 if limit.hard else -1.0) for limit in limits]
    matrix = [[p, q, soft] for _, p, q, soft in rows]
    results = []
    for i in range(len(shapes)):
        found = linprog(
            [0.0, 0.0, 1.0],
            A_ub=matrix,
            b_ub=[-c[i] for c, *_ in rows],
            bounds=[(None, None)] * 3,
        )
        results.append(found.x if found.x is not None else [np.nan, np.nan, np.inf])
    diameter, length, excess = np.array(results).reshape(-1, 3).T
    return excess, np.exp(diameter), np.exp(length)


class Verdict(StrEnum):
    """What came out of a design.

    Attributes
    ----------
    FOUND
        A rod that keeps to all limits: the best of them.
    NONE
        No rod keeps to all limits: the one that exceeds them least.
    FAILED
        No rod could be solved at all; the message says why.
    """

    FOUND = "found"
    NONE = "none"
    FAILED = "failed"


@dataclass(frozen=True)
class Check:
    """One limit at the rod of a design.

    Attributes
    ----------
    name, meaning : str
    kind : Kind
    value, bound : float
    upper : bool
        Whether the bound is the largest value allowed, not the least.
    use : float
        How much of it is used: above 1 it is exceeded.
    """

    name: str
    meaning: str
    kind: Kind
    value: float
    bound: float
    upper: bool
    use: float


@dataclass(frozen=True, eq=False)
class Design:
    """The best rod, what limits it and what would help.

    Attributes
    ----------
    verdict : Verdict
    message : str
        The verdict in words.
    requirements : Requirements
    theta, eta, diameter, length : float
        The rod (m); NaN if none was solved.
    deviation : float
        Largest standard deviation of μ0 in the range, from one period of sticking.
    mu0, by_step, by_reading, x0_slip : ndarray, shape (k,)
        Frictions of the range; standard deviation by the step and by the readings, which add up in
        squares; travel in a period (m). NaN where the tip locks.
    mu_lock : float
        Locking friction.
    checks : list of Check
    limited_by : list of str
        Limits that are used up, or, where there is no rod, exceeded; `theta` or `eta` where the
        best lies at the end of the range to choose from.
    helps : dict
        Deviation if a limit that is used up were twice as wide, or noise or step half as large.
    shapes : Shapes
        All (θ, η) that were solved, and
    worst : ndarray
        the deviation with the best sizes for each; infinite where no size keeps to all limits.
    """

    verdict: Verdict
    message: str
    requirements: Requirements
    theta: float = np.nan
    eta: float = np.nan
    diameter: float = np.nan
    length: float = np.nan
    deviation: float = np.nan
    mu0: FloatArray = field(default_factory=lambda: np.empty(0))
    by_step: FloatArray = field(default_factory=lambda: np.empty(0))
    by_reading: FloatArray = field(default_factory=lambda: np.empty(0))
    x0_slip: FloatArray = field(default_factory=lambda: np.empty(0))
    mu_lock: float = np.nan
    checks: list[Check] = field(default_factory=list)
    limited_by: list[str] = field(default_factory=list)
    helps: dict[str, float] = field(default_factory=dict)
    shapes: Shapes | None = None
    worst: FloatArray = field(default_factory=lambda: np.empty(0))

    @property
    def rod(self) -> Rod:
        """The rod, for `vibrissa.sensor.quantities.Units`."""
        return Rod(self.requirements.modulus, self.diameter, self.length)


class _Search:
    """(θ, η) solved so far; a mesh, geometric in θ and 1 − η, that is refined around the best."""

    def __init__(self, requirements: Requirements, progress: Callable[[int], None]) -> None:
        self.requirements, self.progress = requirements, progress
        self.known: set[tuple[float, float]] = set()
        nothing = np.empty(0)
        self.shapes, self.failures = self._survey(nothing, nothing)
        # Coordinates u, v in [0, 1] of θ and η in their ranges.
        theta, eta = requirements.theta, requirements.eta
        self.free = (theta[0] < theta[1], eta[0] < eta[1])
        counts = [
            n if is_free else 1 for n, is_free in zip((TAPERS, HEIGHTS), self.free, strict=True)
        ]
        self.mesh = [1.0 / max(n - 1, 1) for n in counts]
        u, v = np.meshgrid(*(np.linspace(0.0, 1.0, n) for n in counts))
        self.add(u.ravel(), v.ravel())

    def _survey(self, theta: FloatArray, eta: FloatArray) -> tuple[Shapes, list[str]]:
        return survey(theta, eta, self.requirements.mu0, self.requirements.contact)

    def add(self, u: FloatArray, v: FloatArray) -> None:
        (theta0, theta1), (eta0, eta1) = self.requirements.theta, self.requirements.eta
        theta = theta0 * (theta1 / theta0) ** np.clip(u, 0.0, 1.0)
        eta = 1.0 - (1.0 - eta0) * ((1.0 - eta1) / (1.0 - eta0)) ** np.clip(v, 0.0, 1.0)
        pairs = dict.fromkeys(zip(theta.round(12).tolist(), eta.round(12).tolist(), strict=True))
        new = [pair for pair in pairs if pair not in self.known]
        for start in range(0, len(new), BATCH):
            some = new[start : start + BATCH]
            theta_, eta_ = np.array(some).T
            shapes, failures = self._survey(theta_, eta_)
            self.shapes = self.shapes.joined(shapes)
            self.failures += failures
            self.known |= set(some)
            self.progress(len(self.known))

    def refine(self, requirements: Requirements, rounds: Sequence[int]) -> int:
        """Halve the mesh around the best so often, and return the best."""
        best = self.best(requirements)
        for depth in rounds:
            (theta0, theta1), (eta0, eta1) = self.requirements.theta, self.requirements.eta
            theta, eta = (float(values[best]) for values in (self.shapes.theta, self.shapes.eta))
            u = np.log(theta / theta0) / np.log(theta1 / theta0) if self.free[0] else 0.0
            v = (
                np.log((1.0 - eta) / (1.0 - eta0)) / np.log((1.0 - eta1) / (1.0 - eta0))
                if self.free[1]
                else 0.0
            )
            around = np.array([-1.0, 0.0, 1.0]) / 2**depth
            u_, v_ = np.meshgrid(
                u + around * self.mesh[0] * self.free[0], v + around * self.mesh[1] * self.free[1]
            )
            self.add(u_.ravel(), v_.ravel())
            best = self.best(requirements)
        return best

    def best(self, requirements: Requirements) -> int:
        """Return which is best, or exceeds the limits least."""
        deviation, _, _ = best_sizes(requirements, self.shapes)
        if np.isfinite(deviation).any():
            return int(np.argmin(deviation))
        return int(np.argmin(nearest_sizes(requirements, self.shapes)[0]))


def curves_to_solve(requirements: Requirements) -> int:
    """Count about how many curves a search solves, for showing how far it is."""
    free = [low < high for low, high in (requirements.theta, requirements.eta)]
    around = 3 ** sum(free) - 1
    counts = (n if is_free else 1 for n, is_free in zip((TAPERS, HEIGHTS), free, strict=True))
    return int(np.prod(list(counts))) + 2 * ROUNDS * around


def design(
    requirements: Requirements, progress: Callable[[int], None] = lambda done: None
) -> Design:
    """Find the rod that measures friction best, and say what limits it.

    Parameters
    ----------
    requirements : Requirements
        A rod that is given whole is checked against the limits.
    progress : callable
        Told how many curves are solved, of about `curves_to_solve`.

    Returns
    -------
    Design

    Examples
    --------
    The paper's rod, of structural steel:

    >>> result = design(
    ...     Requirements(
    ...         modulus=210e9,
    ...         yield_strain=0.00112,
    ...         mu0=(0.2, 0.4),
    ...         step=100e-6,
    ...         noise=(0.003, 0.003, 2e-5),
    ...         range=(12.0, 12.0, 0.12),
    ...         theta=(2.0, 2.0),
    ...         eta=(0.85, 0.85),
    ...         diameter=(5e-3, 5e-3),
    ...         length=(0.1, 0.1),
    ...     )
    ... )
    >>> print(result.verdict, *result.limited_by)
    none moment_z force_y force_x strain
    """
    search = _Search(requirements, progress)
    shapes = search.shapes
    if not len(shapes):
        why = search.failures[0]
        return Design(Verdict.FAILED, f"no such rod could be solved: {why}", requirements)
    best = search.refine(requirements, range(1, ROUNDS + 1) if any(search.free) else ())
    shapes = search.shapes
    worst, diameters, lengths = best_sizes(requirements, shapes)
    found = bool(np.isfinite(worst[best]))
    if not found:
        _, diameters, lengths = nearest_sizes(requirements, shapes)
    one = np.array([best])
    rod = shapes.take(one)
    diameter, length = diameters[one], lengths[one]
    by_step, by_reading = deviations(requirements, rod, diameter, length)
    checks = [
        Check(
            limit.name,
            limit.meaning,
            limit.kind,
            value := float(limit.value(diameter, length)[0]),
            limit.bound,
            limit.upper,
            value / limit.bound if limit.upper else limit.bound / value if value > 0.0 else np.inf,
        )
        for limit in limits_of(requirements, rod)
        if not _is_given(requirements, limit)
    ]
    limited = _limited(requirements, checks, rod, found)
    helps = {}
    if found and not requirements.given:
        for name, relaxed in _relaxed(requirements, limited).items():
            index = search.refine(relaxed, (1, 2) if any(search.free) else ())
            helps[name] = float(best_sizes(relaxed, search.shapes)[0][index])
    return Design(
        Verdict.FOUND if found else Verdict.NONE,
        _message(requirements, search.shapes, checks, limited, found),
        requirements,
        float(rod.theta[0]),
        float(rod.eta[0]),
        float(diameter[0]),
        float(length[0]),
        float(np.hypot(by_step, by_reading).max()),
        np.linspace(*requirements.mu0, FRICTIONS),
        by_step[0],
        by_reading[0],
        rod.x0[0] * float(length[0]),
        float(rod.mu_lock[0]),
        checks,
        limited,
        helps,
        shapes,
        worst,
    )


def _is_given(requirements: Requirements, limit: Limit) -> bool:
    """Whether a limit to sizes leaves no choice."""
    low, high = {
        "diameter": requirements.diameter,
        "length": requirements.length,
    }.get(limit.meaning, (0.0, 1.0))
    return low == high


def _limited(
    requirements: Requirements, checks: Sequence[Check], rod: Shapes, found: bool
) -> list[str]:
    """Name the limits that are used up or exceeded, the most first, and ends of the ranges."""
    from_ = USED_UP if found else 1.0 + ROUNDING
    names = [check.name for check in _by_use(checks) if check.use >= from_]
    for name, (low, high), value in (
        ("theta", requirements.theta, rod.theta[0]),
        ("eta", requirements.eta, rod.eta[0]),
    ):
        if found and low < high and not low < value < high:
            names.append(name)
    return names


def _by_use(checks: Sequence[Check]) -> list[Check]:
    """Limits in the order of their use; rounding does not order those that are used up alike."""
    return sorted(checks, key=lambda check: -float(f"{check.use:.3g}"))


def _relaxed(requirements: Requirements, limited: Sequence[str]) -> dict[str, Requirements]:
    """Loosen one thing at a time: noise, step, and each limit that is used up."""
    r = requirements
    changes: dict[str, dict[str, Any]] = {
        "noise": {"noise": tuple(0.5 * value for value in r.noise)},
        "step": {"step": 0.5 * r.step},
        "strain": {"yield_strain": 2.0 * r.yield_strain},
        "lock": {"lock_factor": 1.0},
        "steps": {"steps": 0.5 * r.steps},
        "spacing": {"spacing": 2.0 * r.spacing},
        "weight": {"weight": 2.0 * r.weight},
        "tip": {"tip": 0.5 * r.tip},
        "thickest": {"diameter": (r.diameter[0], 2.0 * r.diameter[1])},
        "thinnest": {"diameter": (0.5 * r.diameter[0], r.diameter[1])},
        "longest": {"length": (r.length[0], 2.0 * r.length[1])},
        "shortest": {"length": (0.5 * r.length[0], r.length[1])},
    }
    for i, name in enumerate(("force_x", "force_y", "moment_z")):
        wider = tuple(2.0 * value if i == j else value for j, value in enumerate(r.range))
        changes[name] = {"range": wider}
    chosen = ["noise", "step", *(name for name in limited if name in changes)]
    return {name: replace(r, **changes[name]) for name in chosen}


def _message(
    requirements: Requirements,
    shapes: Shapes,
    checks: Sequence[Check],
    limited: Sequence[str],
    found: bool,
) -> str:
    subject = "this rod" if requirements.given else "the best rod"
    if found:
        by = ", ".join(limited)
        return f"{subject} keeps to all limits" + (f"; it is limited by {by}" if by else "")
    exceeded = ", ".join(
        f"{check.name} ({check.use:.3g} times what is allowed)"
        for check in _by_use(checks)
        if check.name in limited
    )
    if requirements.given:
        return f"this rod cannot be used: it exceeds {exceeded}"
    alone = [
        check.name
        for check in checks
        if check.use >= USED_UP
        and np.isfinite(best_sizes(requirements, shapes, without=check.name)[0]).any()
    ]
    advice = (
        f"without the limit on {' or on '.join(alone)} there would be one"
        if alone
        else "no single limit is to blame"
    )
    return f"no rod keeps to all limits: the nearest exceeds {exceeded}; {advice}"
