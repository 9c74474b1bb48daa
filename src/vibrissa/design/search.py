"""Search for the rod with the least uncertainty of friction, among rods that can be made."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import product

import numpy as np

from vibrissa.design.candidate import Candidate, limits_of
from vibrissa.design.pairs import survey
from vibrissa.design.requirements import Requirements
from vibrissa.quantities.units import Kind
from vibrissa.sensor.tolerances import displayed

# Relative excess over a bound that is allowed, for rounding.
ROUNDING = 1e-9
# Constraints are active from this use on: sizes come in steps, so that few rods reach a bound.
USED_UP = 0.9
# A tolerance is printed if halving it lowers the uncertainty by this part.
BRINGS = 0.01
# Largest number of tolerances that are printed.
MOST_PARTS = 4


class DesignStatus(StrEnum):
    """Outcome of a design.

    Attributes
    ----------
    FOUND
        A rod meets all constraints; the result is the best one.
    NONE
        No rod meets all constraints; the result is the rod that violates them least.
    """

    FOUND = "found"
    NONE = "none"


@dataclass(frozen=True, eq=False, kw_only=True)
class Design:
    """Result of a design: the best rod, and all rods that meet the constraints.

    Attributes
    ----------
    status : DesignStatus
    message : str
        Number of rods that meet all constraints, or the constraints that the best rod violates.
    best : Candidate
        The best rod; if no rod meets all constraints, the one that violates them least.
    rods : list of Candidate
        All rods that meet the constraints, the best first.
    """

    status: DesignStatus
    message: str
    best: Candidate
    rods: list[Candidate]

    @property
    def alternatives(self) -> list[Candidate]:
        """The best rod of each taper, the best first."""
        first: dict[float, Candidate] = {}
        for rod in self.rods:
            first.setdefault(rod.theta, rod)
        return list(first.values())

    @property
    def active_constraints(self) -> list[str]:
        """Names of the constraints that limit the best rod, those with the largest use first.

        A constraint is named if its use (`Limit.use`, 100 % at the bound) is 90 % or more. If no
        rod meets all constraints, those above 100 % are named.
        """
        least = USED_UP if self.status is DesignStatus.FOUND else 1.0 + ROUNDING
        return [check.name for check in self.best.checks if check.use >= least]

    def __repr__(self) -> str:
        """Format the rod, its uncertainty, its constraints, and the uncertainty of other tapers."""
        blocks = [self._rod(), self._by_mu0(), self._others(), self._limits(), self._first()]
        return "\n\n".join("\n".join(block) for block in blocks if block)

    def _shown(self, value: float, kind: Kind = Kind.LENGTH, digits: int = 3) -> str:
        size, unit = self.best.whisker.units.displayed(value, kind)
        return f"{size:.{digits}g} {unit}".removesuffix(" 1")

    def _rod(self) -> list[str]:
        rod = self.best
        base, tip, length, height = (
            self._shown(size, digits=4)
            for size in (rod.diameter, rod.diameter / rod.theta, rod.length, rod.eta * rod.length)
        )
        shape = f"tip {tip}" if rod.theta > 1.0 else "cylinder"
        return [
            self.message,
            f"rod          base {base}, {shape} (theta {rod.theta:.4g}), length {length}",
            f"height       {height} from the clamp to the surface (eta {rod.eta:.4g})",
            f"mu_lock      {rod.mu_lock:.4g}",
        ]

    def _by_mu0(self) -> list[str]:
        rod = self.best
        rows = [("mu0", "whole", "by step", "by noise", "by tolerances", "clamp travel")]
        parts = zip(rod.whole, rod.by_step, rod.by_reading, rod.by_tolerances, strict=True)
        for mu0, values, travel in zip(rod.requirements.frictions, parts, rod.x0_slip, strict=True):
            whole, step, noise, tolerances = (f"{value:.2g}" for value in values)
            length = self._shown(travel)
            if np.isnan(travel):
                whole, step, noise, tolerances, length = "the tip locks", "", "", "", ""
            rows.append((f"{mu0:.4g}", whole, step, noise, tolerances, length))
        return [
            "uncertainty (standard deviation) of mu0 from one period of sticking",
            *_aligned(rows),
        ]

    def _others(self) -> list[str]:
        rows = []
        for rod in self.alternatives:
            if rod.theta != self.best.theta:
                name = "a cylinder" if rod.theta == 1.0 else f"theta {rod.theta:.4g}"
                sizes = (rod.diameter, rod.length, rod.eta * rod.length)
                base, length, height = (self._shown(size) for size in sizes)
                more = f"{rod.largest / self.best.largest - 1.0:.0%} more"
                rows.append((name, base, length, height, f"{rod.largest:.2g}", more))
        head = ("", "base", "length", "height", "uncertainty", "")
        return ["the best rods of other tapers", *_aligned([head, *rows])] if rows else []

    def _limits(self) -> list[str]:
        rows = [("constraint", "value", "bound", "used")]
        for check in self.best.checks:
            value, bound = (
                self._shown(size, check.kind) for size in (float(check.value), check.bound)
            )
            used = f"{check.use:.0%}" if check.use < 2.0 else f"{check.use:.3g} times"
            rows.append((check.name, value, f"{'<' if check.upper else '>'} {bound}", used))
        known = self.best.requirements.material.density is not None
        return _aligned(rows) + ([] if known else ["weight       not checked: give the density"])

    def _first(self) -> list[str]:
        rows = []
        for part in self.best.parts()[:MOST_PARTS]:
            if part.halved >= BRINGS:
                size, unit = displayed(part.name, part.size, self.best.whisker.units)
                given = f"{size:.2g} {unit}".strip() + ("" if part.stated else ", default")
                rows.append((part.name, given, f"{part.halved:.0%}"))
        head = "measure first: halving a tolerance lowers the uncertainty by"
        return [head, *_aligned(rows)] if rows else []


def _aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Format rows of a table as lines with aligned columns."""
    widths = [max(map(len, column)) + 3 for column in zip(*rows, strict=True)]
    return [
        "".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]


def design(requirements: Requirements) -> Design:
    """Find the rod that measures friction best, and the constraints that limit it.

    The best rod measures μ0 with the smallest uncertainty in one period of sticking. This
    uncertainty is due to noise, step and tolerances. It depends on μ0; the largest uncertainty in
    the range of μ0 counts.

    Parameters
    ----------
    requirements : Requirements
        If theta, eta, diameter and length have a single value each, this rod is only checked.

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
    >>> print(f"{result.status}: {result.active_constraints}")
    none: ['moment_z', 'force_y', 'force_x', 'strain']
    """
    r = requirements
    theta, eta = np.array(list(product(r.tapers, r.eta))).T
    pairs = survey(theta, eta, r.frictions, r.setup.contact, r.mounting)
    sizes = np.array(r.diameter)[:, None], np.array(r.length)
    shape = (len(r.diameter), len(r.length))
    limits = [limits_of(r, pair, *sizes) for pair in pairs]
    # Use of each limit; axes: pair, limit, diameter, length.
    use = np.array([[np.broadcast_to(limit.use, shape) for limit in of_pair] for of_pair in limits])
    most = use.max(axis=1)

    def rod(n: int, d: int, k: int) -> Candidate:
        return Candidate(requirements=r, pair=pairs[n], diameter=r.diameter[d], length=r.length[k])

    rods = [rod(*at) for at in np.argwhere(most <= 1.0 + ROUNDING).tolist()]
    if rods:
        rods.sort(key=lambda candidate: candidate.largest)
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
    """Write which constraints the rod violates, and dropping which single one would allow a rod."""
    factors = ", ".join(
        f"{check.name} (by a factor of {check.use:.3g})"
        for check in nearest.checks
        if check.use > 1.0 + ROUNDING
    )
    if nearest.requirements.given:
        return f"this rod cannot be used: it violates the constraints {factors}"
    advice = "more than one of them must be relaxed"
    if alone:
        advice = f"dropping {' or '.join(alone)} would allow a rod"
    return f"no rod meets all constraints: the closest one violates {factors}; {advice}"
