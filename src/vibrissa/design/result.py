"""The result of a design: a rod, its uncertainty of μ0, and what limits it."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING, Any

import numpy as np

from vibrissa.design.limits import Limit
from vibrissa.design.pairs import Pairs
from vibrissa.design.requirements import Requirements
from vibrissa.design.uncertainty import TolerancePart, Uncertainty
from vibrissa.extras import require
from vibrissa.mechanics.rod import Rod
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.quantities import Kind, Units
from vibrissa.sensor.series import Column, Tabular
from vibrissa.sensor.setup import TOLERANCES
from vibrissa.sensor.tolerances import told

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# A limit counts as used up from here on, as sizes have steps.
USED_UP = 0.9
# Told are tolerances whose halving brings so much, and so many at most.
BRINGS, MOST_PARTS = 0.01, 4


class DesignStatus(StrEnum):
    """Outcome of a design.

    Attributes
    ----------
    FOUND
        A rod that meets all constraints: the best of them.
    NONE
        No rod meets all constraints: the one that violates them least.
    """

    FOUND = "found"
    NONE = "none"


@dataclass(frozen=True, kw_only=True)
class Alternative:
    """The best rod of one taper, and its largest uncertainty of μ0; sizes in m."""

    theta: float
    eta: float
    diameter: float
    length: float
    uncertainty: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Design(Tabular):
    """The best rod, what limits it, and what other tapers cost.

    Attributes
    ----------
    status : DesignStatus
    message : str
        The status in words.
    requirements : Requirements
    theta, eta, diameter, length : float
        The rod (m).
    mu_lock : float
        Critical friction coefficient.
    x0_slip : ndarray, shape (k,)
        Clamp travel in a period of sticking (m), for each friction coefficient `mu0`; NaN where the
        tip locks.
    uncertainty : Uncertainty
        Standard deviation of μ0 from one period, by its sources, of shape (k,).
    checks : list of Limit
        Every constraint, the most used first.
    parts : list of TolerancePart
        What each tolerance costs where the uncertainty is largest; what to measure first.
    pairs : Pairs
        All pairs (θ, η) that were solved.
    alternatives : list of Alternative
        The best rod of each taper.
    pair_uncertainty : ndarray, shape (n,)
        Uncertainty of μ0 with the best size of each pair; infinite where there is none.
    """

    status: DesignStatus
    message: str
    requirements: Requirements
    theta: float
    eta: float
    diameter: float
    length: float
    mu_lock: float
    x0_slip: FloatArray
    uncertainty: Uncertainty
    checks: list[Limit]
    parts: list[TolerancePart]
    pairs: Pairs
    alternatives: list[Alternative] = field(default_factory=list)
    pair_uncertainty: FloatArray = field(default_factory=lambda: np.empty(0))

    @property
    def mu0(self) -> FloatArray:
        """Friction coefficients of the range, shape (k,)."""
        return self.requirements.frictions

    @property
    def largest(self) -> float:
        """Uncertainty of μ0 at that μ0 of the range where it is largest."""
        return self.uncertainty.largest

    @property
    def active_constraints(self) -> list[str]:
        """Constraints that are nearly used up, or violated if there is no rod; the most first."""
        least = USED_UP if self.status is DesignStatus.FOUND else 1.0 + 1e-9
        return [check.name for check in self.checks if check.use >= least]

    @property
    def rod(self) -> Rod:
        """The rod."""
        return Rod(self.requirements.modulus, self.diameter, self.length)

    @property
    def units(self) -> Units:
        """Units of the results: millimetres."""
        return Units(self.rod, {Kind.LENGTH: "mm", **self.requirements.wished})

    def __repr__(self) -> str:
        """Tell the rod, its uncertainty, what limits it, and what other tapers cost."""
        parts = (self._of_rod(), self._of_mu0(), self._of_others(), self._of_limits())
        return "\n".join(line for part in (*parts, self._of_tolerances()) for line in part)

    def _shown(self, value: float, kind: Kind, digits: int = 4) -> str:
        size, unit = self.units.told(value, kind)
        return f"{size:.{digits}g} {unit}".removesuffix(" 1")

    def _of_rod(self) -> Iterator[str]:
        lengths = (self.diameter, self.diameter / self.theta, self.length, self.eta * self.length)
        base, tip, length, height = (self._shown(x, Kind.LENGTH) for x in lengths)
        yield self.message
        shape = "cylinder" if self.theta == 1.0 else f"tip {tip}"
        yield f"rod          base {base}, {shape} (theta {self.theta:.4g}), length {length}"
        yield f"height       {height} from the clamp to the surface (eta {self.eta:.4g})"
        yield f"mu_lock      {self.mu_lock:.4g}"

    def _of_mu0(self) -> Iterator[str]:
        known = self.uncertainty
        yield "\nuncertainty (standard deviation) of mu0 from one period of sticking"
        yield "mu0         whole     by step   by noise  by tolerances  clamp travel"
        rows = zip(
            *(self.mu0, known.whole, known.by_step, known.by_reading, known.by_tolerances),
            self.x0_slip,
            strict=True,
        )
        # Of a single friction all rows are the same.
        for mu0, *values, travel in list(rows)[: 1 if self.mu0[0] == self.mu0[-1] else None]:
            if np.isnan(travel):
                yield f"{mu0:<11.4g} the tip locks"
                continue
            whole, step, noise, tolerances = (f"{value:.2g}" for value in values)
            yield (
                f"{mu0:<11.4g} {whole:<9} {step:<9} {noise:<9} {tolerances:<14} "
                f"{self._shown(travel, Kind.LENGTH, 3)}"
            )

    def _of_others(self) -> Iterator[str]:
        others = [one for one in self.alternatives if one.theta != self.theta]
        if others:
            yield "\nthe best rods of other tapers"
        for one in sorted(others, key=lambda one: one.uncertainty):
            name = "a cylinder" if one.theta == 1.0 else f"theta {one.theta:.4g}"
            sizes = (one.diameter, one.length, one.eta * one.length)
            base, length, height = (self._shown(x, Kind.LENGTH, 3) for x in sizes)
            more = one.uncertainty / self.largest - 1.0
            yield (
                f"{name:<12} base {base}, length {length}, height {height}: "
                f"uncertainty {one.uncertainty:.2g}, {more:.0%} more"
            )

    def _of_limits(self) -> Iterator[str]:
        yield "\nconstraint   value         bound           used"
        for check in self.checks:
            value, bound = (
                self._shown(x, check.kind, 3) for x in (float(check.value), check.bound)
            )
            used = f"{check.use:.0%}" if check.use < 2.0 else f"{check.use:.3g} times"
            yield f"{check.name:<12} {value:<13} {'<' if check.upper else '>'} {bound:<13} {used}"

    def _of_tolerances(self) -> Iterator[str]:
        some = [one for one in self.parts if one.halved >= BRINGS][:MOST_PARTS]
        if some:
            yield "\nmeasure first: halving a tolerance lowers the uncertainty by"
        for one in some:
            size, unit = told(one.name, one.size, self.units)
            given = f"{f'{size:.2g} {unit}'.strip()}{'' if one.stated else ', default'}"
            yield f"{one.name:<18}{given:<26}{one.halved:.0%}"

    def rod_file(self) -> dict[str, Any]:
        """Give the rod as the keys of a set-up file, with which other commands go on."""
        asked = self.requirements
        keys: dict[str, Any] = {
            "theta": self.theta,
            "eta": self.eta,
            "contact": str(asked.contact),
            "modulus": f"{1e-9 * asked.modulus:.10g} GPa",
            "diameter": f"{1e3 * self.diameter:.10g} mm",
            "length": f"{1e3 * self.length:.10g} mm",
        }
        if "material" not in asked.carried and np.isfinite(asked.yield_strain):
            keys["yield_strain"] = asked.yield_strain
        if asked.density is not None:
            keys["density"] = f"{asked.density:.10g} kg/m^3"
        if "transducer" not in asked.carried:
            noise = zip(asked.noise, ("N", "N", "N*m"), strict=True)
            keys["noise"] = ", ".join(f"{value:.10g} {unit}" for value, unit in noise)
        return {**keys, **asked.carried, TOLERANCES: dict(asked.tolerances)}

    def plot(self) -> "Figure":
        """Draw the uncertainty over μ0, and all pairs (θ, η) that were solved."""
        require("plots", "matplotlib")
        from vibrissa.design import plots

        return plots.design(self)

    def columns(self) -> dict[str, Column]:
        """One row with units: the rod, its uncertainty and its constraints."""
        length, number = self.units.name(Kind.LENGTH), self.units.name(Kind.NUMBER)
        active = " ".join(self.active_constraints)
        columns = {
            "status": Column([self.status.value], "", "found, or none meets all constraints"),
            "message": Column([self.message], "", "the status in words"),
            "active_constraints": Column([active], "", "constraints that are used up or violated"),
            "theta": Column([self.theta], number, "taper"),
            "eta": Column([self.eta], "L", "height of the surface"),
            "diameter": Column([self.diameter], length, "diameter at the clamp"),
            "tip_diameter": Column([self.diameter / self.theta], length, "diameter of the tip"),
            "length": Column([self.length], length, "length"),
            "height": Column([self.eta * self.length], length, "height of the surface"),
            "mu_lock": Column([self.mu_lock], number, "largest friction at which the tip slips"),
            "uncertainty": Column(
                [self.largest], number, "largest standard deviation of mu0 in its range"
            ),
        }
        for check in self.checks:
            unit, bound = self.units.name(check.kind), "largest" if check.upper else "least"
            columns |= {
                f"{check.name}_value": Column([float(check.value)], unit, check.meaning),
                f"{check.name}_bound": Column([check.bound], unit, f"{bound} value allowed"),
                f"{check.name}_use": Column([float(check.use)], "1", "part that is used"),
            }
        return columns
