"""Search for the rod with the least uncertainty of friction, among rods that can be made."""

from dataclasses import replace
from itertools import product

import numpy as np

from vibrissa.design.candidate import Candidate
from vibrissa.design.limits import limits_of
from vibrissa.design.pairs import Pairs, survey
from vibrissa.design.requirements import Requirements
from vibrissa.design.result import Design, DesignStatus
from vibrissa.errors import NoResponseError
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
        If they give all four sizes of a rod, only that rod is checked.
    progress : callable
        Called with the current step, the number of solved pairs (θ, η), and their total.

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
    pairs = _solved(requirements, progress)
    limits = limits_of(requirements, pairs, requirements.diameter, requirements.length)
    shape = (len(pairs), len(requirements.diameter), len(requirements.length))
    use = np.array([np.broadcast_to(limit.use, shape) for limit in limits])
    possible = np.argwhere(use.max(axis=0) <= 1.0 + ROUNDING)
    rods = [_candidate(requirements, pairs, *at) for at in possible.tolist()]
    rods.sort(key=lambda rod: rod.largest)
    if rods:
        message = f"the best of {len(rods)} rods that meet all constraints"
        if requirements.given:
            message = "this rod meets all constraints"
        return Design(
            status=DesignStatus.FOUND, message=message, best=rods[0], rods=rods, pairs=pairs
        )
    nearest = np.nanargmin(use.max(axis=0))
    found = Design(
        status=DesignStatus.NONE,
        message="",
        best=_candidate(requirements, pairs, *map(int, np.unravel_index(nearest, shape))),
        rods=rods,
        pairs=pairs,
    )
    without = {
        limit.name: bool((np.delete(use, i, axis=0).max(axis=0) <= 1.0 + ROUNDING).any())
        for i, limit in enumerate(limits)
    }
    return replace(found, message=_violated(found, [name for name in without if without[name]]))


def _solved(r: Requirements, progress: Progress) -> Pairs:
    """Solve all pairs (θ, η); leave out pairs without a solution."""
    theta, eta = np.array(list(product(r.theta, r.eta))).T
    parts, failures = [], []
    for some in slices(len(theta), PAIRS_AT_ONCE):
        solved, messages = survey(theta[some], eta[some], r.frictions, r.setup.contact)
        parts += [] if solved is None else [solved]
        failures += messages
        progress("solving", min(some.stop, len(theta)), len(theta))
    if not parts:
        raise NoResponseError(f"no such rod could be solved: {failures[0]}")
    return Pairs.concatenate(parts)


def _candidate(r: Requirements, pairs: Pairs, n: int, d: int, k: int) -> Candidate:
    """Take one rod of all, by its indices."""
    pair = pairs.take(slice(n, n + 1))
    return Candidate(requirements=r, pair=pair, diameter=r.diameter[d], length=r.length[k])


def _violated(found: Design, alone: list[str]) -> str:
    """Name the constraints that a rod violates, and each without which a rod would exist."""
    factors = ", ".join(
        f"{check.name} (by a factor of {check.use:.3g})"
        for check in found.checks
        if check.use > 1.0 + ROUNDING
    )
    if found.best.requirements.given:
        return f"this rod cannot be used: it violates the constraints {factors}"
    advice = "no single one of them is the cause"
    if alone:
        advice = f"there would be one without {' or '.join(alone)}"
    return f"no rod meets all constraints: the closest one violates {factors}; {advice}"
