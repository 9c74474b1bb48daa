"""The result of a design: a rod, its standard deviation of μ0, and what limits it."""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING, Any

import numpy as np

from vibrissa.design.limits import Check
from vibrissa.design.pairs import Pairs
from vibrissa.design.requirements import FRICTIONS, Requirements
from vibrissa.design.sizes import Deviations
from vibrissa.design.telling import lines
from vibrissa.extras import require
from vibrissa.mechanics.rod import Rod
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.given.rod_file import TOLERANCES
from vibrissa.sensor.given.tolerances import read_tolerances
from vibrissa.sensor.quantities import Kind, Units
from vibrissa.sensor.series import Column, Tabular
from vibrissa.sensor.whisker import Whisker

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from vibrissa.design.tolerances import ToleranceLimits


class DesignStatus(StrEnum):
    """Outcome of a design.

    Attributes
    ----------
    FOUND
        A rod that keeps to all limits: the best of them.
    NONE
        No rod keeps to all limits: the one that violates them least.
    FAILED
        No rod could be solved; the message says why.
    """

    FOUND = "found"
    NONE = "none"
    FAILED = "failed"


# A smaller taper is none: wire as it is bought.
CYLINDER = 1.05


def _unknown() -> FloatArray:
    return np.full(FRICTIONS, np.nan)


@dataclass(frozen=True, eq=False, kw_only=True)
class Design(Tabular):
    """The best rod, what limits it, and what would help.

    Attributes
    ----------
    status : DesignStatus
    message : str
        The status in words.
    requirements : Requirements
    theta, eta, diameter, length : float
        The rod (m); NaN if none was solved.
    mu_lock : float
        Critical friction coefficient.
    x0_slip : ndarray, shape (k,)
        Clamp travel in a period of sticking (m), for each friction coefficient `mu0`; NaN where the
        tip locks.
    deviations : Deviations
        Standard deviation of μ0 from one period, of shape (k,).
    checks : list of Check
        Every limit of the rod.
    active_constraints : list of str
        Limits that are used up, or violated if there is no rod, the most first; `theta` or `eta`
        where the best is at an end of the range.
    relaxed : dict
        Largest standard deviation of μ0 with half the noise, half the step, or twice the room at an
        active constraint.
    any_size : Design or None
        The best rod of any diameter, where this one is of a stock size.
    pairs : Pairs or None
        All pairs (θ, η) that were solved.
    pair_deviation : ndarray, shape (n,)
        Standard deviation of μ0 with the best size of each pair; infinite where no size keeps to
        all limits.
    """

    status: DesignStatus
    message: str
    requirements: Requirements
    theta: float = np.nan
    eta: float = np.nan
    diameter: float = np.nan
    length: float = np.nan
    mu_lock: float = np.nan
    x0_slip: FloatArray = field(default_factory=_unknown)
    deviations: Deviations = field(default_factory=lambda: Deviations.unknown(FRICTIONS))
    checks: list[Check] = field(default_factory=list)
    active_constraints: list[str] = field(default_factory=list)
    relaxed: dict[str, float] = field(default_factory=dict)
    any_size: "Design | None" = None
    pairs: Pairs | None = None
    pair_deviation: FloatArray = field(default_factory=lambda: np.empty(0))

    @property
    def mu0(self) -> FloatArray:
        """Friction coefficients of the range, shape (k,)."""
        return self.requirements.frictions

    @property
    def deviation(self) -> float:
        """Standard deviation of μ0 at that μ0 of the range where it is largest."""
        return float(self.deviations.largest)

    @property
    def rod(self) -> Rod | None:
        """The rod, which has a size if the requirements have a modulus."""
        if self.requirements.modulus is None:
            return None
        return Rod(self.requirements.modulus, self.diameter, self.length)

    @property
    def units(self) -> Units:
        """Units of the results; a workshop thinks in millimetres."""
        return Units(self.rod, {Kind.LENGTH: "mm", **self.requirements.wished})

    @property
    def is_cylinder(self) -> bool:
        """Whether a rod without taper does."""
        return self.theta < CYLINDER

    def __repr__(self) -> str:
        """Say the rod, its standard deviations, its limits, and what would help."""
        return "\n".join(lines(self))

    def tolerances(self) -> "ToleranceLimits":
        """Tell which tolerance limits μ0 where its uncertainty is largest, and by how much."""
        from vibrissa.design.tolerances import tolerance_limits

        whisker = Whisker(
            theta=self.theta,
            eta=self.eta,
            contact=self.requirements.contact,
            rod=self.rod,
            wished=self.units.wished,
        )
        stated = read_tolerances(whisker.units, self.requirements.tolerances, whisker)
        mu0 = float(self.mu0[np.argmax(self.deviations.total)])
        return tolerance_limits(self.requirements, whisker.tolerating(stated), mu0, self.deviation)

    def rod_file(self) -> dict[str, Any]:
        """Give the rod as the keys of a rod file, with which other commands go on.

        Returns
        -------
        dict
            As `vibrissa.sensor.given.rod_file.write` takes it.
        """
        asked = self.requirements
        keys: dict[str, Any] = {"theta": self.theta, "eta": self.eta, "contact": str(asked.contact)}
        units = ("", "", "")
        if asked.modulus is not None:
            keys["modulus"] = f"{1e-9 * asked.modulus:.10g} GPa"
            keys["diameter"] = f"{1e3 * self.diameter:.10g} mm"
            keys["length"] = f"{1e3 * self.length:.10g} mm"
            units = (" N", " N", " N*m")
        if "material" not in asked.carried and np.isfinite(asked.yield_strain):
            keys["yield_strain"] = asked.yield_strain
        if asked.density is not None:
            keys["density"] = f"{asked.density:.10g} kg/m^3"
        if "transducer" not in asked.carried:
            noise = zip(asked.noise, units, strict=True)
            keys["noise"] = ", ".join(f"{value:.10g}{unit}" for value, unit in noise)
        return {**keys, **asked.carried, TOLERANCES: dict(asked.tolerances)}

    def plot(self) -> "Figure":
        """Draw the standard deviation over μ0, and all pairs (θ, η) that were solved."""
        require("plots", "matplotlib")
        from vibrissa.design import plots

        return plots.design(self)

    def columns(self) -> dict[str, Column]:
        """One row with units: the rod, its limits, and what would help."""
        length, number = self.units.name(Kind.LENGTH), self.units.name(Kind.NUMBER)
        active = " ".join(self.active_constraints)
        columns = {
            "status": Column([self.status.value], "", "found, or none keeps to all limits"),
            "message": Column([self.message], "", "the status in words"),
            "active_constraints": Column([active], "", "limits that are used up or violated"),
            "theta": Column([self.theta], number, "taper"),
            "eta": Column([self.eta], "L", "height of the surface"),
            "diameter": Column([self.diameter], length, "diameter at the clamp"),
            "tip_diameter": Column([self.diameter / self.theta], length, "diameter of the tip"),
            "length": Column([self.length], length, "length"),
            "height": Column([self.eta * self.length], length, "height of the surface"),
            "mu_lock": Column([self.mu_lock], number, "largest friction at which the tip slips"),
            "deviation": Column(
                [self.deviation], number, "largest standard deviation of mu0 in its range"
            ),
        }
        for check in self.checks:
            columns |= self._limit_columns(check)
        what = "largest standard deviation of mu0 with half the noise or step, or twice the limit"
        for name, deviation in self.relaxed.items():
            columns[f"relaxed_{name}"] = Column([deviation], number, what)
        return columns

    def _limit_columns(self, check: Check) -> dict[str, Column]:
        unit, bound = self.units.name(check.kind), "largest" if check.upper else "least"
        return {
            f"{check.name}_value": Column([check.value], unit, check.meaning),
            f"{check.name}_bound": Column([check.bound], unit, f"{bound} value allowed"),
            f"{check.name}_use": Column([check.use], "1", "part of the limit that is used"),
        }
