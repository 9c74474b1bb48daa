"""Identification of friction with a whisker, in the units of its rod."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.errors import ArgumentError, UndeterminedError
from vibrissa.extras import require
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.given.tolerances import read_tolerances
from vibrissa.sensor.given.values import Given
from vibrissa.sensor.identification.adjusting.adjustment import Adjusted, Prior, Tolerance, adjusted
from vibrissa.sensor.identification.adjusting.priors import Asked, needs_calibration, prior_of
from vibrissa.sensor.identification.adjusting.properties import Bench
from vibrissa.sensor.identification.adjusting.solving import Solver
from vibrissa.sensor.identification.alternatives import alternatives_to
from vibrissa.sensor.identification.calibration import Setup, Unknown, known_setup
from vibrissa.sensor.identification.friction import Periods, PeriodStatus, find_periods
from vibrissa.sensor.identification.misfit.doubts import Doubt, Grade
from vibrissa.sensor.identification.periods import JUMP, Channels
from vibrissa.sensor.identification.recording import (
    Method,
    Recording,
    left_out,
    noise_of,
    read_recording,
    units_of,
)
from vibrissa.sensor.identification.settling import LONG, Told, settled
from vibrissa.sensor.identification.sides import Part, parts_of
from vibrissa.sensor.identification.summary import NAMED, FrictionSummary, summary_of
from vibrissa.sensor.identification.without_rod import (
    TOLERANCES,
    read_ratio,
    read_ratio_tolerances,
)
from vibrissa.sensor.oblique import ObliqueStage
from vibrissa.sensor.quantities import Kind, Quantity, Units, chosen, in_si
from vibrissa.sensor.scanning import TipSide
from vibrissa.sensor.series import Column, Tabular
from vibrissa.sensor.slips import SlipLaw
from vibrissa.sensor.transducer import CHANNELS, Transducer, transducer_of
from vibrissa.sensor.whisker import Progress, Whisker, quiet

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

# An unknown that is known to no better than this part of its tolerance afterwards is not told.
MOST_LEFT = 0.7


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


def _settled(
    whisker: Whisker, recording: Recording, noise: FloatArray | None, told: Told
) -> Recording:
    """Leave out what belongs to slips; on an oblique stage the rod would be solved once more."""
    if whisker.mounting.stage_angle or len(recording) <= LONG:
        return recording
    noise = noise_of(recording.readings) if noise is None else noise
    backward = bool((np.diff(recording.clamp) < 0.0).any())
    channels = Channels.recorded(recording, noise)
    return settled(whisker.response(backward), recording, channels, told, whisker.units)


def _told(recording: Recording, slip_time: str | None, delay: str | None) -> Told:
    """Read times in units of the samples' interval.

    Raises
    ------
    ArgumentError
        If one of them is no time, or the recording does not tell the interval.
    """
    times = {
        what: None if text is None else float(in_si(text, Kind.TIME, what)) / recording.interval
        for what, text in (("slip_time", slip_time), ("delay", delay))
    }
    for what, time in times.items():
        if time is not None and not time >= 0.0:
            raise ArgumentError(f"{what} must not be negative, and needs a column 'time [s]'")
    return Told(slip=times["slip_time"], delay=times["delay"])


def _units(
    whisker: Whisker | None, recording: "Recording | Path | DataFrame", method: Method
) -> Units:
    """Units of the rod; where none is needed and none was given, those of the recording."""
    if whisker is not None and (whisker.rod is not None or method is not Method.RATIO):
        return whisker.units
    return Units() if isinstance(recording, Recording) else units_of(recording)


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
    setup : Setup or None
        Height and offsets, with their covariance if they were estimated; None without a rod.
    units : Units
    tolerances : tuple of Tolerance
        What was adjusted, and how well it is known now.
    covariance : ndarray, shape (k, k)
        Of what remains of their errors, in their order.
    """

    periods: Periods
    setup: Setup | None
    units: Units
    tolerances: tuple[Tolerance, ...] = ()
    covariance: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))

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
        own = periods.deviation**2 - periods.common**2
        if self.setup is None:
            return np.asarray(periods.shifts @ periods.shifts.T + np.diag(own))
        if not self.tolerances:
            return np.diag(own + periods.common**2)
        return np.asarray(periods.effects @ self.covariance @ periods.effects.T + np.diag(own))

    @property
    def shares(self) -> dict[str, float]:
        """Standard deviation of the mean μ0 by each of what is not known exactly, by its name.

        Errors of one may make up for those of another: the squares do not add up.
        """
        known = np.isfinite(self.periods.mu0)
        if not self.tolerances or not known.any():
            return {}
        each = np.abs(self.periods.effects[known].mean(axis=0)) * np.sqrt(np.diag(self.covariance))
        return {one.name: float(size) for one, size in zip(self.tolerances, each, strict=True)}

    def summary(self) -> FrictionSummary:
        """Mean of μ0, how well it is known, and what limits it; prints as a few lines."""
        share = self.shares
        known = sorted(share, key=lambda name: -share[name])[:NAMED]
        causes = (
            f"{cause.spelled(self.units)} (explains {cause.explained:.0%} of the misfit)"
            for cause in self.periods.causes
        )
        unknowns = (*known, "other tolerances") if known else ()
        return summary_of(
            self.periods,
            unknowns=("tolerances, and how the forces curve",) if self.setup is None else unknowns,
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
        footpoint = periods.footpoint * self.units.unit(Kind.LENGTH)
        return {
            "status": Column(periods.status, "", ", ".join(PeriodStatus)),
            "side": Column(periods.side, "", "where the tip is: " + " or ".join(TipSide)),
            "contact": Column(contact, length, "position of the tip"),
            "footpoint": Column(footpoint, length, "position of the clamp in the last sample"),
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
    whisker: Whisker | None,
    recording: "Recording | Path | DataFrame",
    *,
    method: Method | str = Method.FORCES,
    transducer: Transducer | str | None = None,
    noise: str | ArrayLike | None = None,
    step: Quantity | None = None,
    law: SlipLaw | str | None = None,
    kinetic_ratio: Quantity | None = None,
    estimate: Sequence[Unknown | str] = (),
    tolerances: Mapping[str, Quantity] | None = None,
    assume: bool = True,
    slip_time: str | None = None,
    delay: str | None = None,
    progress: Progress = quiet,
) -> Identification:
    """Find the periods of sticking in a recording, and the friction of each.

    Parameters
    ----------
    whisker : Whisker or None
        That was used; its height may be a first guess. The method ``ratio`` needs none, and uses
        nothing but its units. Without it numbers are in SI units, or in those of the recording.
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
    kinetic_ratio : str or number, optional
        μk/μ0, for the spacing with the law ``kinetic`` or ``energy``; ``"0.8 ± 0.03"``.
    estimate : sequence of str
        What is not known, and estimated from the recording: ``eta`` near the given height,
        ``offset`` of all channels, or names of tolerances.
    tolerances : mapping of str to str or number, optional
        Standard deviations of what was given, as in ``{"clamp_angle": "0.5 deg", "modulus":
        "2 %"}``, or ``"exact"``: it is adjusted within them, and within those of the whisker; see
        `vibrissa.sensor.given.tolerances.TOLERABLE`.
    assume : bool
        Whether what nothing is stated about has the tolerance that is assumed for it; otherwise it
        is exact.
    slip_time : str, optional
        How long a slip lasts: ``"10 ms"``. What the readings need to settle is found, too.
    delay : str, optional
        By which the readings lag behind the clamp, as a filter makes them: ``"4 ms"``.
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
    method = chosen(Method, method, "method")
    units = _units(whisker, recording, method)
    sensor = transducer_of(transducer, units)
    given = _noise(noise, sensor, units)
    if method is Method.RATIO:
        if estimate:
            raise ArgumentError(
                "the method ratio cannot estimate anything: give the zeros a tolerance"
            )
        sizes = read_ratio_tolerances(tolerances or {}, units)
        if whisker is not None:
            stated = whisker.tolerances.items()
            sizes = {name: size for name, size in stated if name in TOLERANCES} | sizes
        if not isinstance(recording, Recording):
            recording = read_recording(recording, units, method, sensor)
        periods = read_ratio(recording, given, sizes)
        return Identification(periods=periods, setup=None, units=units)
    if whisker is None:
        raise ArgumentError(
            f"the method {method} needs the rod: give theta and eta, or use the method ratio"
        )
    ratio, whisker = _tolerant(whisker, kinetic_ratio, tolerances or {})
    asked = Asked(
        method=method,
        law=None if law is None else chosen(SlipLaw, law, "law"),
        estimate=tuple(estimate),
        assume=assume,
    )
    if not isinstance(recording, Recording):
        recording = read_recording(recording, units, asked.method, sensor)
    recording = _settled(whisker, recording, given, _told(recording, slip_time, delay))
    fit = _adjusted(whisker, recording, given, sensor, asked, progress)
    size = len(fit.recording)
    periods = find_periods(
        fit.setup,
        fit.recording,
        fit.noise,
        method=method,
        step=None if step is None else float(units.read(step, Kind.LENGTH, "step")),
        law=law,
        kinetic_ratio=ratio,
        alternatives=lambda: alternatives_to(fit.whisker, lambda other: fit.solver.quick(other)[0]),
        doubtful=fit.doubtful,
        units=units,
        progress=lambda done: progress("identifying", done, size),
    )
    return Identification(periods=periods, units=units, **fit.result)


@dataclass(frozen=True, eq=False, kw_only=True)
class _Fitted:
    """A recording, and the rod that it is read with: the given one, or adjusted to it."""

    whisker: Whisker
    solver: Solver
    recording: Recording
    noise: FloatArray | None
    setup: Setup
    prior: Prior
    found: Adjusted | None = None

    @property
    def doubtful(self) -> tuple[tuple[Doubt, str], ...]:
        """Why all periods are in doubt, and what it concerns."""
        if self.found is None:
            return ((Doubt.NOT_ADJUSTED, ""),) if self.prior.tolerances else ()
        return tuple(
            (Doubt.FAR, f"{one.name} ({one.surprise:.1f} standard deviations)")
            for one in self.found.far
        )

    @property
    def result(self) -> dict[str, Any]:
        """What an `Identification` tells of it."""
        if self.found is None:
            return {"setup": self.setup}
        found = self.found
        return {
            "setup": found.told,
            "tolerances": found.tolerances,
            "covariance": found.covariance,
        }


def _adjusted(
    whisker: Whisker,
    recording: Recording,
    given: FloatArray | None,
    transducer: Transducer | None,
    asked: Asked,
    progress: Progress,
) -> _Fitted:
    """Adjust the rod to the recording, as far as it is not exact."""
    clamp = recording.clamp
    solver = Solver(clamp=clamp, backward=bool((np.diff(clamp) < 0.0).any()), pulled=False)
    noise = noise_of(recording.readings) if given is None else given
    calibrated = None
    if unknown := needs_calibration(asked.estimate):
        calibrated = solver.calibrated(whisker, recording, noise, unknown, progress)
        setup = calibrated
    else:
        branch = solver.exact(whisker, progress)
        if isinstance(branch, ObliqueStage):
            recording = _known(branch, recording)
        setup = known_setup(branch, whisker.eta)
    channels = Channels.recorded(recording, noise)
    parts = parts_of(setup, recording, channels) if channels.used else []
    solver = replace(solver, pulled=solver.backward or any(map(_is_pulled, parts)))
    prior = prior_of(whisker, recording, noise, asked, calibrated, swings=len(parts) > 1)
    same = _Fitted(
        whisker=whisker,
        solver=solver,
        recording=recording,
        noise=given,
        setup=setup,
        prior=prior,
    )
    if not (prior.tolerances and channels.used):
        return same
    bench = Bench.of(recording, transducer, whisker.units.channels)
    found = adjusted(whisker, recording, channels, prior, solver, bench)
    if found is None:
        if asked.estimate:
            raise UndeterminedError(
                f"this recording does not tell {' and '.join(sorted(asked.estimate))}: it is too "
                "far from what was given"
            )
        return same
    _check_estimates(found)
    return replace(
        same,
        whisker=found.whisker,
        recording=found.recording,
        noise=None if given is None else found.noise_of(given),
        setup=found.setup,
        found=found,
    )


def _is_pulled(part: Part) -> bool:
    """Whether the clamp pulls the tip in some states."""
    samples = part.samples
    return bool((samples.x0 < -JUMP * samples.deviation).any())


def _check_estimates(found: Adjusted) -> None:
    """Refuse unknowns of which the recording tells little."""
    for one in found.tolerances:
        if one.estimated and one.deviation > MOST_LEFT * one.tolerance:
            raise UndeterminedError(
                f"this recording does not tell {one.name}: give it, or its tolerance"
            )


def _tolerant(
    whisker: Whisker, kinetic_ratio: Quantity | None, tolerances: Mapping[str, Quantity]
) -> tuple[float | None, Whisker]:
    """Read the ratio of the frictions, and give the whisker the tolerances that are stated."""
    ratio, stated = None, dict(tolerances)
    if kinetic_ratio is not None:
        given = Given.read(kinetic_ratio, "kinetic_ratio")
        ratio = float(whisker.units.read(given.value, Kind.NUMBER, "kinetic_ratio"))
        if given.tolerance is not None:
            stated = {"kinetic_ratio": given.tolerance} | stated
    return ratio, whisker.tolerating(read_tolerances(whisker, stated, ratio))
