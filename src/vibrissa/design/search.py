"""The choice of the rod that measures friction best, among those that one can buy or turn."""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from vibrissa.design.limits import Limit, limits_of
from vibrissa.design.pairs import Pairs, survey
from vibrissa.design.requirements import Requirements
from vibrissa.design.result import Alternative, Design, DesignStatus
from vibrissa.design.uncertainty import parts_of, uncertainties
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
    found, failures = _solved(requirements, progress)
    if found is None:
        message = f"no such rod could be solved: {failures[0]}"
        return Design(status=DesignStatus.FAILED, message=message, requirements=requirements)
    candidates = _Candidates.of(requirements, found)
    if candidates.possible.any():
        whole = candidates.uncertainty()
        if np.isfinite(whole).any():
            return _found(candidates, whole)
    return _nearest(candidates)


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
class _Candidates:
    """All rods: n pairs (θ, η), d diameters and l lengths.

    Attributes
    ----------
    requirements : Requirements
    pairs : Pairs
    diameter, length : ndarray, shape (d,) and (l,)
    limits : list of Limit
    use : ndarray, shape (limits, n, d, l)
        Part of each limit that is used.
    """

    requirements: Requirements
    pairs: Pairs
    diameter: FloatArray
    length: FloatArray
    limits: list[Limit]
    use: FloatArray

    @classmethod
    def of(cls, r: Requirements, pairs: Pairs) -> "_Candidates":
        """Compare all rods with all limits."""
        diameter, length = np.array(r.diameter), np.array(r.length)
        limits = limits_of(r, pairs, diameter, length)
        shape = (len(pairs), len(diameter), len(length))
        use = np.array([np.broadcast_to(limit.use, shape) for limit in limits])
        return cls(
            requirements=r, pairs=pairs, diameter=diameter, length=length, limits=limits, use=use
        )

    @property
    def possible(self) -> FloatArray:
        """Which rods meet all constraints, shape (n, d, l)."""
        return np.asarray(self.use.max(axis=0) <= 1.0 + ROUNDING)

    def uncertainty(self) -> FloatArray:
        """Largest uncertainty of μ0 of each rod; infinite where a constraint is violated."""
        found = np.full(self.use.shape[1:], np.inf)
        possible = self.possible
        for n in np.flatnonzero(possible.any(axis=(1, 2))):
            d, length = np.nonzero(possible[n])
            sizes = self.diameter[d], self.length[length]
            known = uncertainties(self.requirements, self.pairs.take(np.array([n])), *sizes)
            found[n, d, length] = np.nan_to_num(known.largest, nan=np.inf)
        return found

    def result(self, at: tuple[np.intp, ...], status: DesignStatus, message: str) -> Design:
        """Put together what is known of one rod."""
        n, d, k = at
        r, pair = self.requirements, self.pairs.take(np.array([n]))
        diameter, length = self.diameter[[d]], self.length[[k]]
        known = uncertainties(r, pair, diameter, length).take(0)
        checks = [limit.at(at, self.use.shape[1:]) for limit in self.limits]
        parts = []
        if np.isfinite(known.whole).all():
            worst = int(np.argmax(known.whole))
            parts = parts_of(r, pair, diameter, length, worst, float(known.whole[worst]))
        return Design(
            status=status,
            message=message,
            requirements=r,
            theta=float(pair.theta[0]),
            eta=float(pair.eta[0]),
            diameter=float(diameter[0]),
            length=float(length[0]),
            mu_lock=float(pair.mu_lock[0]),
            x0_slip=pair.x0_slip[0] * length[0],
            uncertainty=known,
            checks=sorted(checks, key=lambda check: -float(f"{check.use:.3g}")),
            parts=parts,
            pairs=self.pairs,
        )


def _found(candidates: _Candidates, whole: FloatArray) -> Design:
    """Take the best rod, and the best of each taper beside it."""
    r, pairs = candidates.requirements, candidates.pairs
    count = int(np.isfinite(whole).sum())
    message = f"the best of {count} rods that meet all constraints"
    best = np.unravel_index(np.argmin(whole), whole.shape)
    if r.given:
        message = "this rod meets all constraints"
    found = candidates.result(best, DesignStatus.FOUND, message)
    others = []
    for theta in r.theta:
        own = np.where((pairs.theta == theta)[:, None, None], whole, np.inf)
        n, d, length = np.unravel_index(np.argmin(own), own.shape)
        if np.isfinite(own[n, d, length]):
            others.append(
                Alternative(
                    theta=theta,
                    eta=float(pairs.eta[n]),
                    diameter=float(candidates.diameter[d]),
                    length=float(candidates.length[length]),
                    uncertainty=float(own[n, d, length]),
                )
            )
    return replace(found, alternatives=others, pair_uncertainty=whole.min(axis=(1, 2)))


def _nearest(candidates: _Candidates) -> Design:
    """Take the rod that violates the constraints least, and say which of them leave none."""
    use = candidates.use
    worst = np.nan_to_num(use.max(axis=0), nan=np.inf)
    at = np.unravel_index(np.argmin(worst), worst.shape)
    found = candidates.result(at, DesignStatus.NONE, "")
    violated = [check for check in found.checks if check.use > 1.0 + ROUNDING]
    factors = ", ".join(f"{check.name} (by a factor of {check.use:.3g})" for check in violated)
    if candidates.requirements.given:
        message = f"this rod cannot be used: it violates the constraints {factors}"
        return replace(found, message=message)
    alone = [
        limit.name
        for i, limit in enumerate(candidates.limits)
        if (np.delete(use, i, axis=0).max(axis=0) <= 1.0 + ROUNDING).any()
    ]
    advice = "no single one of them is the cause"
    if alone:
        advice = f"there would be one without {' or '.join(alone)}"
    message = f"no rod meets all constraints: the closest one violates {factors}; {advice}"
    return replace(found, message=message)
