"""What was found in a recording: friction of its periods, in the units of the rod."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from vibrissa.extras import require
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.identification.adjusting.adjustment import Tolerance
from vibrissa.sensor.identification.friction import Periods, PeriodStatus
from vibrissa.sensor.identification.misfit.beside import Beside
from vibrissa.sensor.identification.misfit.doubts import Grade
from vibrissa.sensor.identification.reading.slope import alike, slope_errors
from vibrissa.sensor.identification.setup import Setup
from vibrissa.sensor.identification.summary import EXPLAINS, NAMED, FrictionSummary, summary_of
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
    setup : Setup or None
        None without a rod.
    units : Units
    beside : Beside or None
        The friction by the ratio of the forces; None where both forces and a rod are not given.
    tolerances : tuple of Tolerance
        What was adjusted, and how well it is known now.
    covariance : ndarray, shape (k, k)
        Of what remains of their errors, in their order.
    slope, slope_length : float
        Standard deviation of the slope of the surface (rad), and over which distance it is alike
        (L).
    far : tuple of Tolerance
        What is by the recording far from what was given, the farthest first.
    """

    periods: Periods
    setup: Setup | None
    units: Units
    beside: Beside | None = None
    tolerances: tuple[Tolerance, ...] = ()
    covariance: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    slope: float = 0.0
    slope_length: float = np.inf
    far: tuple[Tolerance, ...] = ()

    @property
    def correlation(self) -> FloatArray:
        """Correlations of what remains, shape (k, k)."""
        deviation = np.sqrt(np.diag(self.covariance))
        return np.asarray(self.covariance / np.outer(deviation, deviation))

    @property
    def of_periods(self) -> FloatArray:
        """Covariance of the errors of μ0 of all p periods, shape (p, p).

        Tolerances make those of different periods depend on each other.
        """
        periods = self.periods
        error = slope_errors(np.nan_to_num(periods.mu0), self.slope)
        place = periods.footpoint
        slopes = np.outer(error, error) * alike(place, place, self.slope_length)
        own = np.diag(periods.deviation**2 - periods.common**2 - error**2) + slopes
        if self.setup is None:
            return np.asarray(periods.shifts @ periods.shifts.T + own)
        if not self.tolerances:
            return np.asarray(own + np.diag(periods.common**2))
        return np.asarray(periods.effects @ self.covariance @ periods.effects.T + own)

    def summary(self) -> FrictionSummary:
        """Mean of μ0, how well it is known, and what limits it; prints as a few lines."""
        causes = (
            f"{cause.spelled(self.units)} (explains {cause.explained:.0%} of the misfit)"
            for cause in self.periods.causes
            if cause.explained >= EXPLAINS
        )
        return summary_of(
            self.periods,
            unknowns=("how the forces curve",) if self.setup is None else (),
            tolerances=tuple(one.of for one in self.tolerances),
            covariance=self.covariance,
            slope=self.slope,
            slope_length=self.slope_length,
            causes=tuple(causes)[:NAMED],
            beside=self.beside,
            far=self._far(),
        )

    def _far(self) -> tuple[str, ...]:
        """Say without what the recording would not fit, what to do, and what may stand for it."""
        if not self.far:
            return ()
        first, *others = self.far
        asked = f"{first.moved(self.units)}: measure it again, or give it a wider tolerance"
        stand_for = ", ".join(one.name for one in others)
        return (asked, f"Others that may stand for it: {stand_for}.") if others else (asked,)

    def __repr__(self) -> str:
        """Say what `summary` says."""
        return str(self.summary())

    def plot(self) -> "Figure":
        """Draw the friction with its interval over the position of the tip."""
        require("plots", "matplotlib")
        from vibrissa.sensor import plots

        return plots.friction_map(self.periods, self.units)

    @property
    def _by_ratio(self) -> tuple[FloatArray, FloatArray]:
        """Friction by the ratio of the forces and its deviation, NaN where it was not read."""
        if self.setup is None:
            return self.periods.mu0, self.periods.deviation
        if self.beside is None:
            none = np.full(len(self.periods), np.nan)
            return none, none
        return self.beside.ratio, self.beside.deviation

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
