"""Inputs of an identification: recording, noise, tolerances, set-up."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from vibrissa.errors import ArgumentError, RecordingError
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.quantities.units import CHANNEL_KINDS, Kind, Units
from vibrissa.sensor.identification.blocks import Blocks, condensed
from vibrissa.sensor.identification.holds import rounding
from vibrissa.sensor.identification.noise import noise_of
from vibrissa.sensor.identification.parameters import (
    BEARING,
    SLOPE,
    Parameter,
    ScanRows,
    parameters_of,
)
from vibrissa.sensor.identification.recording import FORCES, Recording
from vibrissa.sensor.identification.slips import PeriodEnds, Spans, ends_of, find_slips
from vibrissa.sensor.identification.slope import Slope
from vibrissa.sensor.setup import Setup
from vibrissa.sensor.tolerances import assumed_tolerances, read_tolerances
from vibrissa.sensor.transducer import CHANNELS, Transducer
from vibrissa.sensor.whisker import Whisker

# Least noise that is not 0, in units of the rod.
LEAST_NOISE = 1e-50
# Least noise of a fit, to which smaller noise is raised, as rounding would spoil the fit.
LEAST_FITTED = 5e-8
# Readings of a recording that does not fit are noisier than stated if their scatter exceeds the
# stated noise by this factor: chi2 is then 1.4 by the noise alone.
NOISIER = 1.2
# Correlation length of the slope of the surface (m).
SLOPE_LENGTH = 5e-3
# The same for a rod without a size (L).
OWN_SLOPE_LENGTH = 0.05
ZEROS = tuple(f"zero_{name}" for name in CHANNELS)


@dataclass(frozen=True, eq=False, kw_only=True)
class Task:
    """Inputs of an identification: a recording, its noise, and the tolerances of the set-up.

    Attributes
    ----------
    recording : Recording
        The recording without lone spikes, up to where the rod buckles laterally.
    spans : Spans
        The periods of sticking, as rows of `recording`.
    row : ndarray of int
        For each row of `recording`, its number in the recording as it was read.
    noise : ndarray, shape (3,)
        Standard deviation of one reading of each channel; NaN for a channel that is not used.
    noise_is_given : bool
        Whether the user stated the noise or the transducer; else it is estimated from the readings.
    parameters : tuple of Parameter
        Possible deviations of the rod, its position and the readings from the given set-up.
    slope : Slope
        Tolerance of the local slope of the surface.
    """

    recording: Recording
    spans: Spans
    row: IntArray
    noise: FloatArray
    noise_is_given: bool
    parameters: tuple[Parameter, ...]
    slope: Slope
    units: Units

    @cached_property
    def number(self) -> dict[str, int]:
        """Index of each parameter in `parameters`, by its name."""
        return {parameter.name: k for k, parameter in enumerate(self.parameters)}

    def sizes_of(self, p: FloatArray) -> dict[str, float]:
        """Return the values `p`, which are in the order of `parameters`, by parameter name."""
        return dict(zip(self.number, p.tolist(), strict=True))

    @cached_property
    def sigma(self) -> FloatArray:
        """Tolerances of the k parameters, shape (k,); 0 if exact."""
        return np.array([parameter.deviation for parameter in self.parameters])

    @cached_property
    def free(self) -> BoolArray:
        """Whether each parameter is fitted (true) or exact (false), shape (k,)."""
        return self.sigma > 0.0

    @property
    def used(self) -> list[int]:
        """Indices of the channels that are used."""
        return np.flatnonzero(np.isfinite(self.noise)).tolist()

    def weighted(self, values: FloatArray) -> FloatArray:
        """Take the c used channels of values (..., 3), divided by their noise, shape (..., c)."""
        return np.asarray(values[..., self.used] / self.noise[self.used])

    @property
    def both_forces(self) -> bool:
        """Whether both forces are used."""
        return set(FORCES) <= set(self.used)

    @property
    def untared(self) -> bool:
        """Whether the zeros of the forces are unknown."""
        unstated = [
            parameter.of in ZEROS[:2] and parameter.deviation > 0.0 and not parameter.stated
            for parameter in self.parameters
        ]
        return any(unstated) and not self.recording.air_rows

    def noisier(self) -> Iterator[str]:
        """Write a note on each channel whose readings scatter more than its stated noise allows."""
        scatter = noise_of(self.recording.readings, self.recording.clamp)
        for i in np.flatnonzero(scatter > NOISIER * self.noise):
            more, stated = (
                self.units.spelled(noise[i], CHANNEL_KINDS[i], 2) for noise in (scatter, self.noise)
            )
            yield f"{CHANNELS[i]} scatters from reading to reading by {more}; stated is {stated}"

    @cached_property
    def ends(self) -> PeriodEnds:
        """Position, travel and direction of the clamp at the end of each period."""
        return ends_of(self.recording, self.spans)

    @cached_property
    def blocks(self) -> Blocks:
        """Means of consecutive samples of each period."""
        return condensed(self.recording, self.spans)

    @cached_property
    def shown(self) -> FloatArray:
        """Clamp position at which the readings of each of n blocks arose (L), shape (n,).

        Readings may be delayed, as by a filter.
        """
        return self.blocks.clamp - self.recording.lag[self.blocks.row.astype(int)]

    @property
    def rows(self) -> ScanRows:
        """Mean rows of n blocks."""
        return ScanRows.of(self.blocks.row, len(self.recording))


def task_of(
    recording: Recording,
    setup: Setup,
    whisker: Whisker | None,
    transducer: Transducer | None,
    units: Units,
) -> Task:
    """Collect the inputs of an identification.

    Parameters
    ----------
    whisker : Whisker or None
        The whisker of the set-up; None if the recording is not compared with it.
    transducer : Transducer or None
        The transducer of the set-up.
    units : Units
        Units of the recording.

    Raises
    ------
    ArgumentError
        If a tolerance is out of range.
    RecordingError
        If the readings have no measurable noise.
    """
    errors = _errors_of_readings(recording, _noise(setup, transducer, units))
    # A reading is at least as uncertain as its resolution.
    known = _measurable(np.maximum(errors.scatter, errors.rounded), recording)
    recording = recording.noted(*_coarse(errors.rounded > errors.scatter, errors.rounded, units))
    assumed = assumed_tolerances(units, known) if setup.assume else {}
    if whisker is not None:
        read = whisker.tolerances
        known = np.maximum(known, LEAST_FITTED)
    else:
        read = read_tolerances(units, setup.tolerances)
        if needless := [name for name in read if name not in (*BEARING, SLOPE)]:
            read = {name: size for name, size in read.items() if name not in needless}
            recording = recording.noted(
                f"the ratio of the forces does not use the tolerance of {', '.join(needless)}"
            )
    values = {} if whisker is None else whisker.values
    stated = {**read_tolerances(units, recording.zeros, values), **read}
    recording, zeros = _tared(recording, known, {**assumed, **stated}, stated)
    sizes = {**assumed, **stated, **zeros}
    stated = {**stated, **zeros}
    in_periods = find_slips(recording, known)
    full_scale = _full_scale(in_periods.recording, transducer, units)
    return Task(
        recording=in_periods.recording,
        spans=in_periods.spans,
        row=in_periods.row,
        # Successive readings that are rounded alike have the same error: their mean is no better.
        noise=np.hypot(known, errors.rounded * np.sqrt(errors.lasts - 1.0)),
        noise_is_given=errors.is_given,
        parameters=parameters_of(sizes, frozenset(stated), full_scale, whisker),
        slope=Slope(deviation=sizes.get(SLOPE, 0.0), length=slope_length(units)),
        units=units,
    )


class _ErrorsOfReadings(NamedTuple):
    """Errors of one reading of each of the three channels, dimensionless.

    Attributes
    ----------
    scatter : ndarray, shape (3,)
        Standard deviation of the noise, stated or estimated.
    rounded : ndarray, shape (3,)
        Standard deviation of the rounding; 0 in a channel that is not used.
    lasts : ndarray, shape (3,)
        Number of rows that a rounded reading lasts.
    is_given : bool
        Whether the noise is stated.
    """

    scatter: FloatArray
    rounded: FloatArray
    lasts: FloatArray
    is_given: bool


def _errors_of_readings(recording: Recording, stated_noise: FloatArray | None) -> _ErrorsOfReadings:
    """Estimate the rounding of the readings and, if no noise is stated, their noise."""
    rounded, lasts = np.array([rounding(channel) for channel in recording.readings.T]).T
    if stated_noise is None:
        scatter = noise_of(recording.readings, recording.clamp)
        return _ErrorsOfReadings(scatter=scatter, rounded=rounded, lasts=lasts, is_given=False)
    # A channel whose stated noise is 0 is not used.
    rounded = np.where(stated_noise > 0.0, rounded, 0.0)
    return _ErrorsOfReadings(scatter=stated_noise, rounded=rounded, lasts=lasts, is_given=True)


def slope_length(units: Units) -> float:
    """Return the correlation length of the slope of the surface (L)."""
    return OWN_SLOPE_LENGTH if units.nondimensional else SLOPE_LENGTH / units.unit(Kind.LENGTH)


def _tared(
    recording: Recording, noise: FloatArray, sizes: dict[str, float], stated: Mapping[str, float]
) -> tuple[Recording, dict[str, float]]:
    """Subtract the mean of the rows without load as the zero, unless the zero is stated.

    Return the tolerances of these zeros, too. A zero drifts on the way to the first row of the
    scan, from where the drift of the scan counts.
    """
    used = np.flatnonzero(np.isfinite(noise)).tolist()
    own = [i for i in used if sizes.get(ZEROS[i]) and ZEROS[i] not in stated]
    if not (own and recording.air_rows):
        return recording, {}
    zeros = np.zeros(len(CHANNELS))
    drifts = np.array([sizes.get(f"drift_{name}", 0.0) for name in CHANNELS])
    variance = noise**2 / recording.air_rows + drifts**2 * recording.air_way
    zeros[own] = np.array(recording.air)[own]
    recording = replace(recording, readings=recording.readings - zeros)
    recording = recording.noted(
        "the zeros of the channels are the means of their readings without load"
    )
    return recording, {ZEROS[i]: float(np.sqrt(variance[i])) for i in own}


def _coarse(coarse: BoolArray, rounded: FloatArray, units: Units) -> Iterator[str]:
    """Write a note on each channel whose resolution is coarser than its noise."""
    for i in np.flatnonzero(coarse):
        step, error = (
            units.spelled(size, CHANNEL_KINDS[i], 2)
            for size in (np.sqrt(12.0) * rounded[i], rounded[i])
        )
        yield (
            f"{CHANNELS[i]} has a resolution of {step}, coarser than its noise: a reading is taken "
            f"as uncertain by {error}"
        )


def _noise(setup: Setup, transducer: Transducer | None, units: Units) -> FloatArray | None:
    """Return the stated noise of the three channels, nondimensional; None if none is stated."""
    if transducer is not None:
        return transducer.deviation / units.channels
    return None if setup.noise is None else units.read_channels(setup.noise, "noise")


def _full_scale(recording: Recording, transducer: Transducer | None, units: Units) -> FloatArray:
    """Full scale of each channel: the transducer's limit, or the largest reading; NaN if absent."""
    scale = np.abs(recording.readings).max(axis=0)
    if transducer is not None:
        return np.where(np.isnan(scale), np.nan, np.array(transducer.limit) / units.channels)
    return np.where(scale == 0.0, 1.0, scale)


def _measurable(noise: FloatArray, recording: Recording) -> FloatArray:
    """Return the noise, with NaN for channels that cannot be used.

    A recording without measurable noise is refused, as slips and rounding look alike in it.
    """
    there = np.isfinite(recording.readings).all(axis=0) & (noise > LEAST_NOISE) & (noise < np.inf)
    if not (there[2] or there[FORCES].all()):
        raise RecordingError(
            "the readings have no measurable noise: give the noise of one reading, as in "
            "'3 mN, 3 mN, 10 uN*m', or the transducer"
        )
    return np.where(there, noise, np.nan)


def in_samples(recording: Recording, text: str | None, what: str) -> float:
    """Convert a time, such as ``"50 ms"``, to a number of samples; 0 without a time."""
    if text is None:
        return 0.0
    time = Kind.TIME.read(text, what)
    if time < 0.0:
        raise ArgumentError(f"{what} must not be negative, got {text!r}")
    if np.isnan(recording.interval):
        raise ArgumentError(f"{what} needs a column 'time [s]' in the recording, which has none")
    return time / recording.interval
