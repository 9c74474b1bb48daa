"""Identification of friction with a whisker, in the units of its rod."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.errors import ArgumentError
from vibrissa.extras import require
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.identification.alternatives import alternatives_to
from vibrissa.sensor.identification.calibration import (
    NAMES,
    Setup,
    Unknown,
    calibrate,
    known_setup,
)
from vibrissa.sensor.identification.friction import Periods, PeriodStatus, find_periods
from vibrissa.sensor.identification.misfit.doubts import Grade
from vibrissa.sensor.identification.periods import Channels, Placed
from vibrissa.sensor.identification.recording import (
    Method,
    Recording,
    left_out,
    noise_of,
    read_recording,
)
from vibrissa.sensor.identification.summary import NAMED, FrictionSummary, summary_of
from vibrissa.sensor.identification.tolerances import Tolerance, adjusted, read_tolerances
from vibrissa.sensor.oblique import ObliqueHeights, ObliqueStage
from vibrissa.sensor.quantities import Kind, Quantity, Units, chosen
from vibrissa.sensor.response.heights import NODES, Heights
from vibrissa.sensor.scanning import TipSide
from vibrissa.sensor.series import Column, Tabular
from vibrissa.sensor.slips import SlipLaw
from vibrissa.sensor.transducer import CHANNELS, Transducer, transducer_of
from vibrissa.sensor.whisker import Progress, Whisker, quiet

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame


def _noise(
    noise: str | ArrayLike | None, transducer: Transducer | None, units: Units
) -> FloatArray | None:
    """Nondimensional noise of the three channels; None if it is to be estimated."""
    if transducer is not None:
        if noise is not None:
            raise ArgumentError("give the noise or the transducer, not both")
        return np.array(transducer.deviation) / units.channels
    if noise is None:
        return None
    if isinstance(noise, str):
        return units.read_channels(noise, "noise")
    values = np.asarray(noise, dtype=float)
    if values.shape != (len(CHANNELS),):
        raise ArgumentError(f"noise needs three values, got {noise!r}")
    return values


def _known(stage: ObliqueStage, recording: Recording) -> Recording:
    """Take the samples at heights at which the rod has a response, and note the others."""
    known = stage.covers(recording.clamp)
    why = "; ".join(filter(None, (stage.heights.below, stage.heights.above)))
    notes = recording.notes + left_out(
        recording.line[~known], f"no response at this height ({why})"
    )
    return replace(recording, notes=notes).take(known)


@dataclass(frozen=True, eq=False, kw_only=True)
class Identification(Tabular):
    """Friction of the periods of a recording, in the units of the rod.

    Attributes
    ----------
    periods : Periods
        Nondimensional.
    setup : Setup
        Height and offsets, with their covariance if they were estimated.
    units : Units
    tolerances : tuple of Tolerance
        What was adjusted, and how well it is known now.
    """

    periods: Periods
    setup: Setup
    units: Units
    tolerances: tuple[Tolerance, ...] = ()

    def summary(self) -> FrictionSummary:
        """Mean of μ0, how well it is known, and what limits it; prints as a few lines."""
        known = [name for name, free in zip(NAMES, self.setup.deviation > 0.0, strict=True) if free]
        causes = (
            f"{cause.spelled(self.units)} (explains {cause.explained:.0%} of the misfit)"
            for cause in self.periods.causes
        )
        return summary_of(
            self.periods,
            unknowns=(*known, *(one.name for one in self.tolerances)),
            causes=(self.periods.mixed or tuple(causes))[:NAMED],
        )

    def __repr__(self) -> str:
        """Say what `summary` says."""
        return str(self.summary())

    def plot(self) -> "Figure":
        """Draw the friction with its interval over the position of the tip."""
        require("plots", "matplotlib")
        from vibrissa.sensor import plots

        return plots.friction_map(self.periods, self.units)

    def columns(self) -> dict[str, Column]:
        """One row for each period, with units."""
        periods, length = self.periods, self.units.name(Kind.LENGTH)
        contact = periods.contact * self.units.unit(Kind.LENGTH)
        return {
            "status": Column(periods.status, "", ", ".join(PeriodStatus)),
            "side": Column(periods.side, "", "where the tip is: " + " or ".join(TipSide)),
            "contact": Column(contact, length, "position of the tip"),
            "mu0": Column(periods.mu0, "1", "static friction there"),
            "deviation": Column(periods.deviation, "1", "its standard deviation"),
            "low": Column(periods.low, "1", "lower end of its central 95 %"),
            "high": Column(periods.high, "1", "upper end of its central 95 %"),
            "common": Column(periods.common, "1", "part of it that all periods share"),
            "by_step": Column(periods.by_step, "1", "part of it by the step of the stage"),
            "first_line": Column(periods.first_line, "1", "line of the first sample"),
            "last_line": Column(periods.last_line, "1", "line of the last sample"),
            "grade": Column(periods.grade, "", f"{', '.join(Grade)}; empty without a doubt"),
            "doubt": Column(periods.doubt, "", "what speaks against its friction, in words"),
        }


def identify(
    whisker: Whisker,
    recording: "Recording | Path | DataFrame",
    *,
    method: Method | str = Method.FORCES,
    transducer: Transducer | str | None = None,
    noise: str | ArrayLike | None = None,
    step: Quantity | None = None,
    law: SlipLaw | str | None = None,
    kinetic_ratio: float | None = None,
    estimate: Sequence[Unknown | str] = (),
    tolerances: Mapping[str, Quantity] | None = None,
    progress: Progress = quiet,
) -> Identification:
    """Find the periods of sticking in a recording, and the friction of each.

    Parameters
    ----------
    whisker : Whisker
        That was used; its height may be a first guess.
    recording : Recording, Path or DataFrame
        A table needs the columns ``footpoint`` and those that the method uses, each with its unit:
        ``footpoint [mm]``, ``force_x [N]``. A DataFrame may have the units in ``attrs["units"]``;
        without a unit a column is in SI units, or in those of the rod if that has none. The notes
        of the periods say what was taken.
    method : Method
        What friction is read from.
    transducer : Transducer or str, optional
        That was used: says the noise, and which readings are saturated.
    noise : str or array_like, shape (3,), optional
        Standard deviation of one reading of force_x, force_y and moment_z, as in
        ``"3 mN, 3 mN, 10 uN*m"``. Without it and the transducer it is estimated.
    step : str or number, optional
        Step of the stage, which the spacing needs if samples were lost.
    law : SlipLaw, optional
        Where slips end, for the spacing; without it bounds are found that hold for all laws.
    kinetic_ratio : float, optional
        μk/μ0, for the spacing with the law ``kinetic`` or ``energy``.
    estimate : sequence of Unknown
        What is not known of height and offsets, and estimated from the recording.
    tolerances : mapping of str to str or number, optional
        Standard deviations of what was given, as in ``{"clamp_angle": "0.5 deg", "modulus":
        "2 %"}``: it is adjusted within them; see `PROPERTIES`.
    progress : callable

    Returns
    -------
    Identification

    Raises
    ------
    ArgumentError
        If an argument is out of range or no such quantity.
    RecordingError
        If the recording cannot be used; the message names the line.
    UndeterminedError
        If the recording does not determine what is to be estimated.
    NoResponseError
        If the response of the whisker is not found.
    """
    if tolerances and estimate:
        raise ArgumentError("give eta or the zeros a tolerance, or estimate them: not both")
    units = whisker.units
    sensor = transducer_of(transducer, units)
    given = _noise(noise, sensor, units)
    if not isinstance(recording, Recording):
        recording = read_recording(recording, units, chosen(Method, method, "method"), sensor)
    positions = recording.clamp
    backward = bool((np.diff(positions) < 0.0).any())

    def solved(other: Whisker) -> Placed:
        if other.mounting.stage_angle:
            return other.stage(positions, backward)
        return other.response(backward)

    oblique = bool(whisker.mounting.stage_angle)
    if estimate:
        heights: Heights | ObliqueHeights
        if oblique:
            heights = whisker.stages(recording.clamp, backward, progress)
        else:
            heights = whisker.heights(
                backward, lambda done: progress("solving the rod", done, NODES + 1)
            )
        known = noise_of(recording.readings) if given is None else given
        setup = calibrate(heights, whisker.eta, recording, known, estimate)
    elif oblique:
        stage = whisker.stage(recording.clamp, backward, progress)
        recording = _known(stage, recording)
        setup = known_setup(stage, whisker.eta)
    else:
        setup = known_setup(whisker.response(backward), whisker.eta)
    fitted: tuple[Tolerance, ...] = ()
    if tolerances:
        known = noise_of(recording.readings) if given is None else given
        deviations = read_tolerances(whisker, tolerances)
        channels = Channels.recorded(recording, known)
        found = adjusted(whisker, recording, channels, deviations, solved)
        setup, recording, whisker = found.setup, found.recording, found.whisker
        fitted = found.tolerances
        given = None if given is None else found.noise_of(given)
    size = len(recording)
    periods = find_periods(
        setup,
        recording,
        given,
        method=method,
        step=None if step is None else float(units.read(step, Kind.LENGTH, "step")),
        law=law,
        kinetic_ratio=kinetic_ratio,
        alternatives=lambda: alternatives_to(whisker, solved),
        units=units,
        progress=lambda done: progress("identifying", done, size),
    )
    return Identification(periods=periods, setup=setup, units=units, tolerances=fitted)
