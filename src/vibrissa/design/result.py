"""The result of a design: a rod, its uncertainty of μ0, and its constraints."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

import numpy as np

from vibrissa.design.candidate import Candidate
from vibrissa.design.limits import Limit
from vibrissa.design.pairs import Pair
from vibrissa.extras import require
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.quantities import Kind
from vibrissa.sensor.series import Column, Tabular
from vibrissa.sensor.tolerances import told

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
class Design(Tabular):
    """Result of a design: the best rod, its constraints, and the best rods of other tapers.

    Attributes
    ----------
    status : DesignStatus
    message : str
    best : Candidate
    rods : list of Candidate
        All that meet the constraints, the best first.
    pairs : list of Pair
        All pairs (θ, η) that were solved.
    """

    status: DesignStatus
    message: str
    best: Candidate
    rods: list[Candidate]
    pairs: list[Pair]

    @property
    def checks(self) -> list[Limit]:
        """Every constraint on the best rod, the most used first."""
        return self.best.checks

    @property
    def mu0(self) -> FloatArray:
        """Friction coefficients of the range, shape (k,)."""
        return self.best.requirements.frictions

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
        parts = (self._of_rod(), self._of_mu0(), self._of_others(), self._of_limits())
        return "\n".join(line for part in (*parts, self._of_tolerances()) for line in part)

    def _shown(self, value: float, kind: Kind = Kind.LENGTH, digits: int = 4) -> str:
        size, unit = self.best.whisker.units.told(value, kind)
        return f"{size:.{digits}g} {unit}".removesuffix(" 1")

    def _of_rod(self) -> Iterator[str]:
        rod = self.best
        shape = f"tip {self._shown(rod.diameter / rod.theta)}" if rod.theta > 1.0 else "cylinder"
        height = self._shown(rod.eta * rod.length)
        yield self.message
        yield (
            f"rod          base {self._shown(rod.diameter)}, {shape} (theta {rod.theta:.4g}), "
            f"length {self._shown(rod.length)}"
        )
        yield f"height       {height} from the clamp to the surface (eta {rod.eta:.4g})"
        yield f"mu_lock      {rod.mu_lock:.4g}"

    def _of_mu0(self) -> Iterator[str]:
        rod = self.best
        yield "\nuncertainty (standard deviation) of mu0 from one period of sticking"
        rows: list[tuple[str, ...]] = [
            ("mu0", "whole", "by step", "by noise", "by tolerances", "clamp travel")
        ]
        columns = (self.mu0, rod.whole, rod.by_step, rod.by_reading, rod.by_tolerances)
        for mu0, *values, travel in zip(*columns, rod.x0_slip, strict=True):
            numbers = [f"{value:.2g}" for value in values]
            if np.isnan(travel):
                numbers = ["the tip locks", "", "", ""]
            rows.append((f"{mu0:.4g}", *numbers, self._shown(travel, digits=3)))
        # Of a single friction all rows are the same.
        yield from _aligned(rows[:2] if self.mu0[0] == self.mu0[-1] else rows)

    def _of_others(self) -> Iterator[str]:
        others = [rod for rod in self.alternatives if rod.theta != self.best.theta]
        if others:
            yield "\nthe best rods of other tapers"
        for rod in others:
            name = "a cylinder" if rod.theta == 1.0 else f"theta {rod.theta:.4g}"
            sizes = (rod.diameter, rod.length, rod.eta * rod.length)
            base, length, height = (self._shown(size, digits=3) for size in sizes)
            more = rod.largest / self.best.largest - 1.0
            yield (
                f"{name:<12} base {base}, length {length}, height {height}: "
                f"uncertainty {rod.largest:.2g}, {more:.0%} more"
            )

    def _of_limits(self) -> Iterator[str]:
        rows = [("\nconstraint", "value", "bound", "used")]
        for check in self.checks:
            value, bound = (
                self._shown(size, check.kind, 3) for size in (float(check.value), check.bound)
            )
            used = f"{check.use:.0%}" if check.use < 2.0 else f"{check.use:.3g} times"
            rows.append((check.name, value, f"{'<' if check.upper else '>'} {bound}", used))
        yield from _aligned(rows)

    def _of_tolerances(self) -> Iterator[str]:
        some = [one for one in self.best.parts() if one.halved >= BRINGS][:MOST_PARTS]
        if some:
            yield "\nmeasure first: halving a tolerance lowers the uncertainty by"
        rows = []
        for one in some:
            size, unit = told(one.name, one.size, self.best.whisker.units)
            given = f"{size:.2g} {unit}".strip()
            rows.append(
                (one.name, given if one.stated else f"{given}, default", f"{one.halved:.0%}")
            )
        yield from _aligned(rows)

    def plot(self) -> "Figure":
        """Draw the uncertainty over μ0, and all pairs (θ, η) that were solved."""
        require("plots", "matplotlib")
        from matplotlib.figure import Figure

        figure, best = Figure(figsize=(9.0, 3.6), layout="constrained"), self.best
        left, right = figure.subplots(1, 2)
        left.plot(self.mu0, best.whole, label="whole")
        left.plot(self.mu0, best.by_step, label="by the step")
        left.plot(self.mu0, best.by_reading, label="by the noise")
        left.plot(self.mu0, best.by_tolerances, label="by the tolerances")
        left.set(xlabel="static friction μ0", ylabel="uncertainty of μ0", ylim=(0.0, None))
        left.legend()
        solved = np.array([(pair.theta, pair.eta) for pair in self.pairs]).T
        right.plot(*solved, ".", color="0.8", label="no rod")
        if self.rods:
            # The best of a pair is drawn last, over the others.
            rods = [(rod.theta, rod.eta, rod.largest) for rod in self.rods[::-1]]
            theta, eta, largest = np.array(rods).T
            dots = right.scatter(theta, eta, c=largest, norm="log", s=18, zorder=2)
            figure.colorbar(dots, ax=right, label="largest uncertainty of μ0")
        right.plot(best.theta, best.eta, "*", color="C3", markersize=12, label="the rod")
        right.legend(loc="lower right")
        right.set(xlabel="taper θ", ylabel="height η / L")
        return figure

    def columns(self) -> dict[str, Column]:
        """One row with units: the rod, its uncertainty and its constraints."""
        rod, units = self.best, self.best.whisker.units
        sizes = {
            "theta": (rod.theta, "1", "taper"),
            "eta": (rod.eta, "L", "height of the surface"),
            "diameter": (rod.diameter, "m", "diameter at the clamp"),
            "tip_diameter": (rod.diameter / rod.theta, "m", "diameter of the tip"),
            "length": (rod.length, "m", "length"),
            "height": (rod.eta * rod.length, "m", "height of the surface"),
            "mu_lock": (rod.mu_lock, "1", "largest friction at which the tip slips"),
            "uncertainty": (rod.largest, "1", "largest standard deviation of mu0 in its range"),
        }
        active = " ".join(self.active_constraints)
        columns = {
            "status": Column([self.status.value], "", "found, or none meets all constraints"),
            "message": Column([self.message], "", "the status in words"),
            "active_constraints": Column([active], "", "constraints that are used up or violated"),
            **{name: Column([value], unit, what) for name, (value, unit, what) in sizes.items()},
        }
        for check in self.checks:
            unit, bound = units.name(check.kind), "largest" if check.upper else "least"
            columns |= {
                f"{check.name}_value": Column([float(check.value)], unit, check.meaning),
                f"{check.name}_bound": Column([check.bound], unit, f"{bound} value allowed"),
                f"{check.name}_use": Column([float(check.use)], "1", "part that is used"),
            }
        return columns


def _aligned(rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Write rows of a table, with columns below each other."""
    widths = [max(map(len, column)) + 3 for column in zip(*rows, strict=True)]
    for row in rows:
        yield "".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip()
