"""The result of a design: a rod, its uncertainty of μ0, and its constraints."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from vibrissa.design.candidate import Candidate, Limit
from vibrissa.sensor.quantities import Kind
from vibrissa.sensor.tolerances import told

# By this much a limit may be exceeded, as numbers are rounded.
ROUNDING = 1e-9
# A limit counts as used up from here on, as sizes have steps.
USED_UP = 0.9
# Told are tolerances whose halving brings so much, and so many at most.
BRINGS, MOST_PARTS = 0.01, 4


class DesignStatus(StrEnum):
    """Outcome of a design.

    Attributes
    ----------
    FOUND
        A rod meets all constraints; the result is the best one.
    NONE
        No rod meets all constraints; the result is the one that violates them least.
    """

    FOUND = "found"
    NONE = "none"


@dataclass(frozen=True, eq=False, kw_only=True)
class Design:
    """Result of a design: the best rod, its constraints, and the best rods of other tapers.

    Attributes
    ----------
    status : DesignStatus
    message : str
    best : Candidate
    rods : list of Candidate
        All that meet the constraints, the best first.
    """

    status: DesignStatus
    message: str
    best: Candidate
    rods: list[Candidate]

    @property
    def checks(self) -> list[Limit]:
        """Every constraint on the best rod, the most used first."""
        return self.best.checks

    @property
    def alternatives(self) -> list[Candidate]:
        """The best rod of each taper, the best first."""
        first: dict[float, Candidate] = {}
        for rod in self.rods:
            first.setdefault(rod.theta, rod)
        return list(first.values())

    @property
    def active_constraints(self) -> list[str]:
        """Constraints that are nearly used up, or violated if there is no rod; the most first."""
        least = USED_UP if self.status is DesignStatus.FOUND else 1.0 + ROUNDING
        return [check.name for check in self.checks if check.use >= least]

    def __repr__(self) -> str:
        """Format the rod, its uncertainty, its constraints, and the uncertainty of other tapers."""
        blocks = [self._rod(), self._by_mu0(), self._others(), self._limits(), self._first()]
        return "\n\n".join("\n".join(block) for block in blocks if block)

    def _shown(self, value: float, kind: Kind = Kind.LENGTH, digits: int = 3) -> str:
        size, unit = self.best.whisker.units.told(value, kind)
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
            if np.isnan(travel):
                whole, step, noise, tolerances = "the tip locks", "", "", ""
            rows.append((f"{mu0:.4g}", whole, step, noise, tolerances, self._shown(travel)))
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
        for check in self.checks:
            value, bound = (
                self._shown(size, check.kind) for size in (float(check.value), check.bound)
            )
            used = f"{check.use:.0%}" if check.use < 2.0 else f"{check.use:.3g} times"
            rows.append((check.name, value, f"{'<' if check.upper else '>'} {bound}", used))
        return _aligned(rows)

    def _first(self) -> list[str]:
        rows = []
        for one in self.best.parts()[:MOST_PARTS]:
            if one.halved >= BRINGS:
                size, unit = told(one.name, one.size, self.best.whisker.units)
                given = f"{size:.2g} {unit}".strip() + ("" if one.stated else ", default")
                rows.append((one.name, given, f"{one.halved:.0%}"))
        head = "measure first: halving a tolerance lowers the uncertainty by"
        return [head, *_aligned(rows)] if rows else []


def _aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Write rows of a table, with columns below each other."""
    widths = [max(map(len, column)) + 3 for column in zip(*rows, strict=True)]
    return [
        "".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]
