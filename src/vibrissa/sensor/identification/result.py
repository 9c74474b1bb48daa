"""Result of an identification: friction of the periods, by one method or by both."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from vibrissa.numerics.arrays import FloatArray
from vibrissa.quantities.series import Column, Tabular
from vibrissa.quantities.units import Kind
from vibrissa.sensor.identification.findings import Findings
from vibrissa.sensor.identification.friction_summary import FrictionSummary, summary_of
from vibrissa.sensor.identification.periods import Check, Grade, PeriodStatus
from vibrissa.sensor.identification.profile import ContactProfile
from vibrissa.sensor.identification.recording import Recording


class Residuals(NamedTuple):
    """Residuals of the fit of the model to n blocks of consecutive samples.

    Attributes
    ----------
    clamp : ndarray, shape (n,)
        Mean clamp position of each block (L).
    values : ndarray, shape (n, c)
        Residuals of the channels that were used, in their standard deviations.
    channels : tuple of str
        Names of these channels.
    """

    clamp: FloatArray
    values: FloatArray
    channels: tuple[str, ...]


@dataclass(frozen=True, eq=False, kw_only=True)
class Identification(Findings, Tabular):
    """Friction of the periods of a recording, and whether the recording fits the set-up.

    It has the attributes of `Findings`, and these:

    Attributes
    ----------
    recording : Recording
        The samples that were used.
    by_model : bool
        Whether friction was estimated by the model of the rod, not by the ratio of the forces.
    profile : ContactProfile or None
        Contact point of each sample; None unless it was asked for.
    residuals : Residuals or None
        Residuals of the fit of the model; None if friction was estimated by the ratio.
    """

    recording: Recording
    by_model: bool
    profile: ContactProfile | None = None
    residuals: Residuals | None = None

    def summary(self) -> FrictionSummary:
        """Mean of μ0, its uncertainty, and the tolerances that cause most of it, as a few lines."""
        return summary_of(self)

    def noted(self, *notes: str) -> "Identification":
        """Return a copy with more notes on the periods."""
        left_out = (*self.periods.left_out, *notes)
        return replace(self, periods=replace(self.periods, left_out=left_out))

    def doubted(self, *checks: Check) -> "Identification":
        """Return a copy to which checks are added: reasons to doubt some periods."""
        return replace(self, periods=self.periods.doubted(*checks))

    def __repr__(self) -> str:
        """Text of `summary`."""
        return str(self.summary())

    def columns(self) -> dict[str, Column]:
        """Columns of the table of friction, which has one row for each period."""
        periods = self.periods
        unit = self.units.unit(Kind.LENGTH)
        length = self.units.name(Kind.LENGTH)
        none = np.full(len(periods), np.nan)
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
            "mu0": Column(periods.mu0, "1", "static friction"),
            "deviation": Column(periods.deviation, "1", "standard deviation of mu0"),
            "low": Column(periods.low, "1", "lower end of the 95 % interval of mu0"),
            "high": Column(periods.high, "1", "upper end of the 95 % interval of mu0"),
            "common": Column(periods.common, "1", "part of deviation common to all periods"),
            "by_step": Column(periods.by_step, "1", "part of deviation due to the stage's step"),
            "mu0_ratio": Column(ratio, "1", "static friction by the ratio of forces"),
            "deviation_ratio": Column(deviation, "1", "standard deviation of mu0_ratio"),
            "first_line": Column(periods.first_line, "1", "line of the first sample"),
            "last_line": Column(periods.last_line, "1", "line of the last sample"),
            "grade": Column(periods.grade, "", f"{', '.join(Grade)}; empty if not doubted"),
            "doubt": Column(periods.doubt, "", "why mu0 is in doubt, in words"),
        }
