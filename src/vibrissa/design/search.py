"""Search for the rod with the least uncertainty of friction, among rods that can be made."""

from collections.abc import Sequence
from itertools import product

import numpy as np

from vibrissa.design.candidate import Candidate, limits_of
from vibrissa.design.pairs import survey
from vibrissa.design.requirements import Requirements
from vibrissa.design.result import ROUNDING, Design, DesignStatus


def design(requirements: Requirements) -> Design:
    """Find the rod that measures friction best, and its active constraints.

    The best rod has the smallest uncertainty of μ0 from one period of sticking, random and by the
    tolerances, at that μ0 of the range where it is largest.

    Parameters
    ----------
    requirements : Requirements
        If they give all four sizes of a rod, only that rod is checked.

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
    r = requirements
    theta, eta = np.array(list(product(r.theta, r.eta))).T
    pairs = survey(theta, eta, r.frictions, r.setup.contact)
    sizes = np.array(r.diameter)[:, None], np.array(r.length)
    shape = (len(r.diameter), len(r.length))
    limits = [limits_of(r, pair, *sizes) for pair in pairs]
    # Part of each limit that is used: by pair, limit, diameter and length.
    use = np.array([[np.broadcast_to(one.use, shape) for one in some] for some in limits])
    most = use.max(axis=1)

    def rod(n: int, d: int, k: int) -> Candidate:
        return Candidate(requirements=r, pair=pairs[n], diameter=r.diameter[d], length=r.length[k])

    rods = [rod(*at) for at in np.argwhere(most <= 1.0 + ROUNDING).tolist()]
    if rods:
        rods.sort(key=lambda one: one.largest)
        message = "the only rod that meets all constraints"
        if len(rods) > 1:
            message = f"the best of {len(rods)} rods that meet all constraints"
        if r.given:
            message = "this rod meets all constraints"
        return Design(status=DesignStatus.FOUND, message=message, best=rods[0], rods=rods)
    nearest = rod(*map(int, np.unravel_index(np.nanargmin(most), most.shape)))
    alone = [
        limit.name
        for i, limit in enumerate(limits[0])
        if (np.delete(use, i, axis=1).max(axis=1) <= 1.0 + ROUNDING).any()
    ]
    message = _violated(nearest, alone)
    return Design(status=DesignStatus.NONE, message=message, best=nearest, rods=[])


def _violated(nearest: Candidate, alone: Sequence[str]) -> str:
    """Name the constraints that a rod violates, and each without which a rod would exist."""
    factors = ", ".join(
        f"{check.name} (by a factor of {check.use:.3g})"
        for check in nearest.checks
        if check.use > 1.0 + ROUNDING
    )
    if nearest.requirements.given:
        return f"this rod cannot be used: it violates the constraints {factors}"
    advice = "no single one of them is the cause"
    if alone:
        advice = f"there would be one without {' or '.join(alone)}"
    return f"no rod meets all constraints: the closest one violates {factors}; {advice}"
