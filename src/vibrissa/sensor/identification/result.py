"""Result of an identification: friction of the periods, in the units of the rod."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vibrissa.extras import require
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.identification.checks import Grade
from vibrissa.sensor.identification.goodness import Tolerance
from vibrissa.sensor.identification.periods import Periods, PeriodStatus
from vibrissa.sensor.identification.summary import FrictionSummary, Setting, summary_of
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
    setting : Setting
        What they have in common.
    by_model : bool
        Whether they were read by the model of the rod, and not by the ratio of the forces.
    """

    periods: Periods
    setting: Setting
    by_model: bool

    @property
    def units(self) -> Units:
        """Units of the results."""
        return self.setting.units

    @property
    def tolerances(self) -> tuple[Tolerance, ...]:
        """Quantities with a tolerance, and their estimates."""
        return self.setting.tolerances

    @property
    def covariance(self) -> FloatArray:
        """Covariance of the remaining errors of `tolerances`, shape (k, k)."""
        return self.setting.covariance

    def summary(self) -> FrictionSummary:
        """Mean of μ0, how well it is known, and what limits it; prints as a few lines."""
        return summary_of(self.periods, self.setting)

    def __repr__(self) -> str:
        """Text of `summary`."""
        return str(self.summary())

    def plot(self) -> "Figure":
        """Draw the friction with its interval over the position of the tip."""
        require("plots", "matplotlib")
        from vibrissa.sensor import plots

        return plots.friction_map(self.periods, self.units)

    @property
    def _by_ratio(self) -> tuple[FloatArray, FloatArray]:
        """Friction by the ratio of the forces and its deviation, NaN where it was not read."""
        if not self.by_model:
            return self.periods.mu0, self.periods.deviation
        if self.setting.beside is None:
            none = np.full(len(self.periods), np.nan)
            return none, none
        return self.setting.beside.ratio, self.setting.beside.deviation

    def columns(self) -> dict[str, Column]:
        """One row for each period, with units."""
        periods, length = self.periods, self.units.name(Kind.LENGTH)
        contact = periods.contact * self.units.unit(Kind.LENGTH)
        footpoint = periods.footpoint * self.units.unit(Kind.LENGTH)
        return {
            "status": Column(periods.status, "", ", ".join(PeriodStatus)),
            "contact": Column(contact, length, "position of the tip"),
            "footpoint": Column(footpoint, length, "position of the clamp in the last sample"),
            "mu0": Column(periods.mu0, "1", "static friction there"),
            "deviation": Column(periods.deviation, "1", "its standard deviation"),
            "low": Column(periods.low, "1", "lower end of its central 95 %"),
            "high": Column(periods.high, "1", "upper end of its central 95 %"),
            "common": Column(periods.common, "1", "part of it that all periods share"),
            "by_step": Column(periods.by_step, "1", "part of it by the step of the stage"),
            "mu0_ratio": Column(self._by_ratio[0], "1", "static friction by the ratio of forces"),
            "deviation_ratio": Column(self._by_ratio[1], "1", "its standard deviation"),
            "first_line": Column(periods.first_line, "1", "line of the first sample"),
            "last_line": Column(periods.last_line, "1", "line of the last sample"),
            "grade": Column(periods.grade, "", f"{', '.join(Grade)}; empty without a doubt"),
            "doubt": Column(periods.doubt, "", "what speaks against its friction, in words"),
        }
