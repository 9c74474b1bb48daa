"""Result of an identification: friction of the periods, in the units of the rod."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from vibrissa.extras import require
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.identification.checks import Check, Grade
from vibrissa.sensor.identification.compare import Beside
from vibrissa.sensor.identification.goodness import Cause, Goodness, Tolerance
from vibrissa.sensor.identification.periods import Periods, PeriodStatus
from vibrissa.sensor.identification.slope import Slope
from vibrissa.sensor.identification.summary import FrictionSummary, summary_of
from vibrissa.sensor.quantities import Kind, Units
from vibrissa.sensor.series import Column, Tabular

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False, kw_only=True)
class Identification(Tabular):
    """Friction of the periods of a recording, in the units of the rod.

    Attributes
    ----------
    periods : Periods
        Nondimensional.
    by_model : bool
        Whether they were read by the model of the rod, and not by the ratio of the forces.
    tolerances : tuple of Tolerance
        Quantities with a tolerance, and their estimates.
    covariance : ndarray, shape (k, k)
        Of the remaining errors of `tolerances`, and without a rod of how the forces curve.
    slope : Slope
        Tolerance of the local slope of the surface.
    goodness : Goodness or None
        Whether the recording as a whole fits the given set-up; None without a rod.
    causes : tuple of Cause
        What may be other than it was given, if it does not, or only far off.
    beside : Beside or None
        The model of the rod beside the ratio of the forces.
    """

    periods: Periods
    units: Units
    by_model: bool
    tolerances: tuple[Tolerance, ...]
    covariance: FloatArray
    slope: Slope
    goodness: Goodness | None = None
    causes: tuple[Cause, ...] = ()
    beside: Beside | None = None

    def summary(self) -> FrictionSummary:
        """Mean of μ0, how well it is known, and what limits it; prints as a few lines."""
        return summary_of(self)

    @property
    def fits(self) -> bool:
        """Whether the recording fits what was given, as far as is known."""
        return self.goodness is None or self.goodness.fits

    def noted(self, note: str) -> "Identification":
        """Add a note."""
        left_out = (*self.periods.left_out, note)
        return replace(self, periods=replace(self.periods, left_out=left_out))

    def doubted(self, *checks: Check) -> "Identification":
        """Add reasons to doubt."""
        return replace(self, periods=self.periods.doubted(*checks))

    def __repr__(self) -> str:
        """Text of `summary`."""
        return str(self.summary())

    def plot(self) -> "Figure":
        """Draw the friction with its interval over the position of the tip."""
        require("plots", "matplotlib")
        from vibrissa.sensor import plots

        return plots.friction_map(self.periods, self.units)

    def columns(self) -> dict[str, Column]:
        """One row for each period, with units."""
        periods, unit = self.periods, self.units.unit(Kind.LENGTH)
        length, none = self.units.name(Kind.LENGTH), np.full(len(periods), np.nan)
        ratio, deviation = none, none
        if not self.by_model:
            ratio, deviation = periods.mu0, periods.deviation
        elif self.beside is not None:
            ratio, deviation = self.beside.ratio, self.beside.deviation
        clamp = "position of the clamp in the last sample"
        return {
            "status": Column(periods.status, "", ", ".join(PeriodStatus)),
            "contact": Column(periods.contact * unit, length, "position of the tip"),
            "footpoint": Column(periods.footpoint * unit, length, clamp),
            "mu0": Column(periods.mu0, "1", "static friction there"),
            "deviation": Column(periods.deviation, "1", "its standard deviation"),
            "low": Column(periods.low, "1", "lower end of its central 95 %"),
            "high": Column(periods.high, "1", "upper end of its central 95 %"),
            "common": Column(periods.common, "1", "part of it that all periods share"),
            "by_step": Column(periods.by_step, "1", "part of it by the step of the stage"),
            "mu0_ratio": Column(ratio, "1", "static friction by the ratio of forces"),
            "deviation_ratio": Column(deviation, "1", "its standard deviation"),
            "first_line": Column(periods.first_line, "1", "line of the first sample"),
            "last_line": Column(periods.last_line, "1", "line of the last sample"),
            "grade": Column(periods.grade, "", f"{', '.join(Grade)}; empty without a doubt"),
            "doubt": Column(periods.doubt, "", "what speaks against its friction, in words"),
        }
