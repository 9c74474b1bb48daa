"""The choice of the rod that measures friction best, among those that one can buy or turn."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from vibrissa.design.limits import Limit, limits_of
from vibrissa.design.pairs import Pairs, survey
from vibrissa.design.requirements import Requirements
from vibrissa.design.result import Alternative, Design, DesignStatus
from vibrissa.design.uncertainty import Uncertainty
from vibrissa.errors import NoResponseError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.batch import slices
from vibrissa.sensor.whisker import Progress, quiet

# Pairs (θ, η) that are solved before the progress is told.
PAIRS_AT_ONCE = 28
# By this much a limit may be exceeded, as numbers are rounded.
ROUNDING = 1e-9


def design(requirements: Requirements, progress: Progress = quiet) -> Design:
    """Find the rod that measures friction best, and its active constraints.

    The best rod has the smallest uncertainty of μ0 from one period of sticking, random and by the
    tolerances, at that μ0 of the range where it is largest.

    Parameters
    ----------
    requirements : Requirements
        A rod of which they give all four sizes is only checked.
    progress : callable
        Told what is being done, how many pairs (θ, η) are solved and how many there are.

    Returns
    -------
    Design

    Raises
    ------
    NoResponseError
        If no rod could be solved.

    Examples
    --------
    The paper's rod, of structural steel:

    >>> from vibrissa.design import Requirements
    >>> steel = {"material": "steel-s235", "diameter": "5 mm", "length": "100 mm"}
    >>> shape = {"theta": "2", "eta": "0.85"}
    >>> asked = {"transducer": "nano17-si-12-0.12", "step": "50 um", "mu0": "0.2 to 0.4"}
    >>> result = design(Requirements.read(**steel, **shape, **asked))
    >>> print(result.status, *result.active_constraints)
    none moment_z force_y force_x strain
    """
    pairs, failures = _solved(requirements, progress)
    if pairs is None:
        raise NoResponseError(f"no such rod could be solved: {failures[0]}")
    rods = _Rods.of(requirements, pairs)
    whole = rods.uncertainty()
    return _found(rods, whole) if np.isfinite(whole).any() else _nearest(rods)


def _solved(r: Requirements, progress: Progress) -> tuple[Pairs | None, list[str]]:
    """Solve all pairs (θ, η)."""
    theta, eta = np.array(list(product(r.theta, r.eta))).T
    parts, failures = [], []
    for some in slices(len(theta), PAIRS_AT_ONCE):
        solved, messages = survey(theta[some], eta[some], r.frictions, r.contact)
        parts += [] if solved is None else [solved]
        failures += messages
        progress("solving", min(some.stop, len(theta)), len(theta))
    return (Pairs.concatenate(parts) if parts else None), failures


@dataclass(frozen=True, eq=False, kw_only=True)
class _Rods:
    """All rods: n pairs (θ, η), d diameters and l lengths.

    Attributes
    ----------
    requirements : Requirements
    pairs : Pairs
    limits : list of Limit
    use : ndarray, shape (limits, n, d, l)
        Part of each limit that is used.
    """

    requirements: Requirements
    pairs: Pairs
    limits: list[Limit]
    use: FloatArray

    @classmethod
    def of(cls, r: Requirements, pairs: Pairs) -> "_Rods":
        """Compare all rods with all limits."""
        limits = limits_of(r, pairs, np.array(r.diameter), np.array(r.length))
        shape = (len(pairs), len(r.diameter), len(r.length))
        use = np.array([np.broadcast_to(limit.use, shape) for limit in limits])
        return cls(requirements=r, pairs=pairs, limits=limits, use=use)

    def known(self, rod: Sequence[Any]) -> Uncertainty:
        """Predict the uncertainty of one rod, by its indices."""
        n, d, k = rod
        r = self.requirements
        pair = self.pairs.take(np.array([n]))
        return Uncertainty(requirements=r, pair=pair, diameter=r.diameter[d], length=r.length[k])

    def uncertainty(self) -> FloatArray:
        """Largest uncertainty of μ0 of each rod; infinite where a constraint is violated."""
        found = np.full(self.use.shape[1:], np.inf)
        for rod in np.argwhere(self.use.max(axis=0) <= 1.0 + ROUNDING):
            found[tuple(rod)] = np.nan_to_num(self.known(rod.tolist()).largest, nan=np.inf)
        return found

    def result(self, rod: Sequence[Any], status: DesignStatus, message: str) -> Design:
        """Put together what is known of one rod."""
        known, shape = self.known(rod), self.use.shape[1:]
        checks = [limit.at(tuple(rod), shape) for limit in self.limits]
        pair = known.pair
        return Design(
            status=status,
            message=message,
            requirements=self.requirements,
            theta=float(pair.theta[0]),
            eta=float(pair.eta[0]),
            diameter=known.diameter,
            length=known.length,
            mu_lock=float(pair.mu_lock[0]),
            x0_slip=pair.x0_slip[0] * known.length,
            uncertainty=known,
            checks=sorted(checks, key=lambda check: -float(f"{check.use:.3g}")),
            parts=known.parts() if np.isfinite(known.whole).all() else [],
            pairs=self.pairs,
        )


def _best(values: FloatArray) -> tuple[np.intp, ...]:
    """Find the indices of the least value."""
    return np.unravel_index(np.argmin(values), values.shape)


def _found(rods: _Rods, whole: FloatArray) -> Design:
    """Take the best rod, and the best of each taper beside it."""
    r, pairs = rods.requirements, rods.pairs
    message = f"the best of {np.isfinite(whole).sum()} rods that meet all constraints"
    if r.given:
        message = "this rod meets all constraints"
    found = rods.result(_best(whole), DesignStatus.FOUND, message)
    others = []
    for theta in r.theta:
        own = np.where((pairs.theta == theta)[:, None, None], whole, np.inf)
        n, d, k = _best(own)
        if np.isfinite(own[n, d, k]):
            others.append(
                Alternative(
                    theta=theta,
                    eta=float(pairs.eta[n]),
                    diameter=r.diameter[d],
                    length=r.length[k],
                    uncertainty=float(own[n, d, k]),
                )
            )
    return replace(found, alternatives=others, pair_uncertainty=whole.min(axis=(1, 2)))


def _nearest(rods: _Rods) -> Design:
    """Take the rod that violates the constraints least, and say which of them leave none."""
    use = rods.use
    nearest = _best(np.nan_to_num(use.max(axis=0), nan=np.inf))
    found = rods.result(nearest, DesignStatus.NONE, "")
    factors = ", ".join(
        f"{check.name} (by a factor of {check.use:.3g})"
        for check in found.checks
        if check.use > 1.0 + ROUNDING
    )
    if rods.requirements.given:
        message = f"this rod cannot be used: it violates the constraints {factors}"
        return replace(found, message=message)
    alone = [
        limit.name
        for i, limit in enumerate(rods.limits)
        if (np.delete(use, i, axis=0).max(axis=0) <= 1.0 + ROUNDING).any()
    ]
    advice = "no single one of them is the cause"
    if alone:
        advice = f"there would be one without {' or '.join(alone)}"
    message = f"no rod meets all constraints: the closest one violates {factors}; {advice}"
    return replace(found, message=message)
