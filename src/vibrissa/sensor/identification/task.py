"""Inputs of an identification: recording, noise, tolerances, set-up."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.errors import ArgumentError, RecordingError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.identification.blocks import Blocks, condensed
from vibrissa.sensor.identification.parameters import BEARING, SLOPE, Parameter, parameters_of
from vibrissa.sensor.identification.recording import FORCES, Recording, noise_of
from vibrissa.sensor.identification.slips import Slipped, slipped
from vibrissa.sensor.identification.slope import Slope
from vibrissa.sensor.quantities import Kind, Quantity, Units
from vibrissa.sensor.tolerances import assumed_tolerances, read_tolerances
from vibrissa.sensor.transducer import CHANNELS, Transducer
from vibrissa.sensor.whisker import Whisker

# Less noise than this, in the rod's own units, is none; with less than the second the fit would be
# lost in rounding: it counts as that much.
LEAST_NOISE, LEAST_FITTED = 1e-50, 5e-8
# Distance over which slopes of the surface are alike: in m, and of a rod without a size.
SLOPE_LENGTH, OWN_SLOPE_LENGTH = 5e-3, 0.05
ZEROS = tuple(f"zero_{name}" for name in CHANNELS)


@dataclass(frozen=True, eq=False, kw_only=True)
class Task:
    """Inputs of an identification: a recording, noise and tolerances.

    Attributes
    ----------
    noise : ndarray, shape (3,)
        Standard deviation of one reading; NaN of a channel that is not used.
    full_scale : ndarray, shape (3,)
        Of the channels: the transducer's, or the largest readings; NaN of none.
    sizes : mapping of str to float
        Tolerances, in units of the rod, rad, or relative.
    slip_rows, delay : float
        How long a slip lasts at least, and by how much the readings lag, in samples.
    """

    recording: Recording
    noise: FloatArray
    noise_is_given: bool
    full_scale: FloatArray
    sizes: Mapping[str, float]
    stated: frozenset[str]
    units: Units
    slip_rows: float = 0.0
    delay: float = 0.0

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Parameters: deviations from the given set-up."""
        return parameters_of(self.sizes, self.stated, self.full_scale)

    @property
    def slope(self) -> Slope:
        """Tolerance of the local slope of the surface."""
        units = self.units
        length = SLOPE_LENGTH / units.unit(Kind.LENGTH) if units.si else OWN_SLOPE_LENGTH
        return Slope(deviation=self.sizes.get(SLOPE, 0.0), length=length)

    @property
    def used(self) -> list[int]:
        """Numbers of the channels that are used."""
        return np.flatnonzero(np.isfinite(self.noise)).tolist()

    @property
    def both_forces(self) -> bool:
        """Whether both forces are used."""
        return set(FORCES) <= set(self.used)

    @property
    def untared(self) -> bool:
        """Whether the zeros of the forces are unknown."""
        assumed = [name for name in ZEROS[:2] if self.sizes.get(name) and name not in self.stated]
        return bool(assumed) and not self.recording.air_rows

    def tared(self) -> "Task":
        """Take the mean of the rows in air as zero, unless the zero is stated."""
        recording, sizes = self.recording, dict(self.sizes)
        own = [i for i in self.used if sizes.get(ZEROS[i]) and ZEROS[i] not in self.stated]
        if not (own and recording.air_rows):
            return self
        zeros = np.zeros(len(CHANNELS))
        for i in own:
            zeros[i] = recording.air[i]
            sizes[ZEROS[i]] = float(self.noise[i] / np.sqrt(recording.air_rows))
        recording = replace(recording, readings=recording.readings - zeros)
        recording = recording.noted("the means of the rows without load are the zeros")
        return replace(self, recording=recording, sizes=sizes)

    @cached_property
    def slipped(self) -> Slipped:
        """The recording with its slips."""
        return slipped(self.recording, self.noise, self.slip_rows)

    @cached_property
    def blocks(self) -> Blocks:
        """The recording condensed."""
        return condensed(self.slipped.recording, self.slipped.spans)

    @property
    def position(self) -> float:
        """Standard deviation of one clamp position (L)."""
        return self.slipped.position


def task_of(
    recording: Recording,
    whisker: Whisker | None,
    units: Units,
    transducer: Transducer | None,
    noise: str | ArrayLike | None,
    tolerances: Mapping[str, Quantity],
    assume: bool,
) -> Task:
    """Collect the inputs of an identification.

    Raises
    ------
    ArgumentError
        If an argument is out of range or no such quantity.
    RecordingError
        If the readings have no measurable noise.
    """
    given = _noise(noise, transducer, units)
    known = _measurable(noise_of(recording.readings) if given is None else given, recording)
    assumed = assumed_tolerances(units, known) if assume else {}
    of_whisker: Mapping[str, float] = {}
    read = read_tolerances(units, tolerances, whisker)
    if whisker is not None:
        known, of_whisker = np.maximum(known, LEAST_FITTED), whisker.tolerances
    elif needless := [name for name in tolerances if name not in (*BEARING, SLOPE)]:
        read = {name: size for name, size in read.items() if name not in needless}
        recording = recording.noted(f"the ratio of the forces does not use: {', '.join(needless)}")
    stated = {**read_tolerances(units, recording.zeros, whisker), **of_whisker, **read}
    task = Task(
        recording=recording,
        noise=known,
        noise_is_given=given is not None,
        full_scale=_full_scale(recording, transducer, units),
        sizes={**assumed, **stated},
        stated=frozenset(stated),
        units=units,
    )
    return task.tared()


def _noise(
    noise: str | ArrayLike | None, transducer: Transducer | None, units: Units
) -> FloatArray | None:
    """Nondimensional noise of the three channels; None if it is to be estimated."""
    if transducer is not None:
        if noise is not None:
            raise ArgumentError("give the noise or the transducer, not both")
        noise = transducer.deviation
        values = np.array(noise) / units.channels
    elif noise is None:
        return None
    elif isinstance(noise, str):
        values = units.read_channels(noise, "noise")
    else:
        values = np.asarray(noise, dtype=float)
    if values.shape != (len(CHANNELS),):
        raise ArgumentError(f"noise needs three values, got {noise!r}")
    if not ((values >= 0.0).all() and values.any()):
        raise ArgumentError(f"noise must be three values, none negative, not all 0, got {noise!r}")
    return values


def _full_scale(recording: Recording, transducer: Transducer | None, units: Units) -> FloatArray:
    there = np.isfinite(recording.readings).all(axis=0)
    if transducer is not None:
        return np.where(there, np.array(transducer.limit) / units.channels, np.nan)
    scale = np.abs(np.where(there, recording.readings, 1.0)).max(axis=0)
    return np.where(there, np.where(scale > 0.0, scale, 1.0), np.nan)


def _measurable(noise: FloatArray, recording: Recording) -> FloatArray:
    """Refuse a recording without noise, where slips and rounding look alike."""
    there = np.isfinite(recording.readings).all(axis=0) & (noise > LEAST_NOISE) & (noise < np.inf)
    if not (there[2] or there[FORCES].all()):
        raise RecordingError(
            "the readings have no measurable noise: give the noise of one reading, as in "
            "'3 mN, 3 mN, 10 uN*m', or the transducer"
        )
    return np.where(there, noise, np.nan)


def in_samples(recording: Recording, text: str | None, what: str) -> float:
    """Read a time as a number of samples; 0 where none is given."""
    if text is None:
        return 0.0
    time = Kind.TIME.read(text, what)
    if time < 0.0:
        raise ArgumentError(f"{what} must not be negative, got {text!r}")
    if np.isnan(recording.interval):
        raise ArgumentError(f"{what} needs a column 'time [s]' in the recording, which has none")
    return time / recording.interval
