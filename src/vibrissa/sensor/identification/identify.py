"""Identification of friction with a whisker, in the units of its rod."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.errors import (
    ArgumentError,
    MixedColumnsError,
    NoResponseError,
    RecordingError,
    UnknownNameError,
    WrongRodError,
)
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.sensor.identification.adjusted import FAR, Tolerance, far_of, tolerances_of
from vibrissa.sensor.identification.checks import Check, Grade
from vibrissa.sensor.identification.compare import Beside, Read, beside
from vibrissa.sensor.identification.guide import Guide, check_columns
from vibrissa.sensor.identification.model import Model, Modelled, read_model
from vibrissa.sensor.identification.parameters import BEARING, SLOPE, Parameter, parameters_of
from vibrissa.sensor.identification.ratio import Lag, bearing, check_forces, read_ratio
from vibrissa.sensor.identification.recording import (
    FORCES,
    Method,
    Recording,
    check_size,
    noise_of,
    read_recording,
    units_of,
)
from vibrissa.sensor.identification.result import Identification
from vibrissa.sensor.identification.slips import Slipped, spikes
from vibrissa.sensor.identification.summary import Setting
from vibrissa.sensor.quantities import Kind, Quantity, Units, chosen, in_si
from vibrissa.sensor.tolerances import assumed_tolerances, read_tolerances
from vibrissa.sensor.transducer import CHANNELS, Transducer, transducer_of
from vibrissa.sensor.whisker import Progress, Whisker, quiet

if TYPE_CHECKING:
    from pandas import DataFrame

# Less noise than this, in the rod's own units, is none; readings in units of it can be squared.
LEAST_NOISE = 1e-50
ZEROS = ("zero_force_x", "zero_force_y")
# Distance over which slopes of the surface are alike: in m, and of a rod without a size.
SLOPE_LENGTH, OWN_SLOPE_LENGTH = 5e-3, 0.05
# Tolerances are so many times larger than smaller noise, in units of the rod, that adjustments are
# lost in rounding. With this one the deviation of the friction is good to 0.2 %.
LEAST_ADJUSTED = 5e-8


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
    # Without a rod nothing is adjusted.
    if not units.si and ((values > 0.0) & (values < LEAST_ADJUSTED)).any():
        raise ArgumentError(
            f"noise must be at least {LEAST_ADJUSTED:g} in units of the rod, or 0 for a channel "
            f"that is not used, got {noise!r}"
        )
    return values


def _in_samples(recording: Recording, text: str | None, what: str) -> float | None:
    if text is None:
        return None
    time = float(in_si(text, Kind.TIME, what))
    if time < 0.0:
        raise ArgumentError(f"{what} must not be negative, got {text!r}")
    if np.isnan(recording.interval):
        raise ArgumentError(f"{what} needs a column 'time [s]' in the recording, which has none")
    return time / recording.interval


def _units(
    whisker: Whisker | None, recording: "Recording | Path | DataFrame", method: Method
) -> Units:
    """Units of the rod; where none is needed and none was given, those of the recording."""
    if whisker is not None and (whisker.rod is not None or method is not Method.RATIO):
        return whisker.units
    return Units() if isinstance(recording, Recording) else units_of(recording)


def identify(
    whisker: Whisker | None,
    recording: "Recording | Path | str | DataFrame",
    *,
    method: Method | str | None = None,
    transducer: Transducer | str | None = None,
    noise: str | ArrayLike | None = None,
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
    recording : Recording, Path, str or DataFrame
        A table needs the columns ``footpoint`` and those that the method uses, each with its unit:
        ``footpoint [mm]``, ``force_x [N]``. A DataFrame may have the units in ``attrs["units"]``;
        without a unit a column is in SI units, or in those of the rod if that has none. The notes
        of the periods say what was taken.
    method : Method, optional
        What friction is read from: ``model`` where a rod is given, else ``ratio``.
    transducer : Transducer or str, optional
        That was used: says the noise, and which readings are saturated.
    noise : str or array_like, shape (3,), optional
        Standard deviation of one reading of force_x, force_y and moment_z, as in
        ``"3 mN, 3 mN, 10 uN*m"``. Without it and the transducer it is estimated.
    tolerances : mapping of str to str or number, optional
        Standard deviations of what was given, as in ``{"clamp_angle": "0.5 deg", "modulus":
        "2 %"}``, or ``"exact"``: it is adjusted within them, and within those of the whisker; see
        `vibrissa.sensor.tolerances.TOLERABLE`. Those of the zeros may be in the header of the
        recording, where `vibrissa import` writes them.
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
    NoResponseError
        If the response of the whisker is not found.
    """
    if method is None:
        method = Method.RATIO if whisker is None else Method.MODEL
    method = chosen(Method, method, "method")
    if isinstance(recording, str):
        recording = Path(recording)
    if whisker is not None:
        whisker = whisker.wishing(noise, *(tolerances or {}).values())
    units = _units(whisker, recording, method)
    sensor = None if transducer is None else transducer_of(transducer, units)
    given = _noise(noise, sensor, units)
    if method is not Method.RATIO and whisker is None:
        raise ArgumentError(
            f"the method {method} needs the rod: give theta and eta, or use the method ratio"
        )
    if not isinstance(recording, Recording):
        recording = read_recording(recording, units, method, sensor)
    check_size(len(recording), recording.notes)
    known = checked_noise(noise_of(recording.readings) if given is None else given, recording)
    if whisker is None:
        zeros = {name: size for name, size in recording.zeros.items() if name in BEARING}
        told = {**zeros, **(tolerances or {})}
        sizes, stated = _bearing_tolerances(told, units, known, assume), frozenset(told)
    else:
        zeros = {n: size for n, size in recording.zeros.items() if n not in whisker.tolerances}
        whisker = whisker.tolerating(
            read_tolerances(units, {**zeros, **(tolerances or {})}, whisker)
        )
        assumed = assumed_tolerances(units, known) if assume else {}
        sizes, stated = {**assumed, **whisker.tolerances}, frozenset(whisker.tolerances)
    task = _Task(
        recording=recording,
        noise=known,
        noise_is_given=given is not None,
        full_scale=_full_scale(recording, sensor, units),
        sizes=sizes,
        stated=stated,
        slip_rows=_in_samples(recording, slip_time, "slip_time"),
        delay=_in_samples(recording, delay, "delay"),
        units=units,
        progress=progress,
    )
    if whisker is None or whisker.units != units:
        return task.alone()
    return task.by_model(whisker) if method is Method.MODEL else task.by_ratio(whisker)


def _bearing_tolerances(
    given: Mapping[str, Quantity], units: Units, noise: FloatArray, assume: bool
) -> dict[str, float]:
    """Put together the tolerances that change the ratio of the forces, without a rod."""
    names = (*BEARING, SLOPE)
    for name in given:
        if name not in names:
            raise UnknownNameError(
                f"the method ratio uses no rod: a tolerance is of one of {', '.join(names)}, got "
                f"{name!r}"
            )
    assumed = assumed_tolerances(units, noise) if assume else {}
    return assumed | read_tolerances(units, given)


def _full_scale(recording: Recording, transducer: Transducer | None, units: Units) -> FloatArray:
    """Full scale of the channels: the transducer's, or the largest readings; NaN of none."""
    there = np.isfinite(recording.readings).all(axis=0)
    if transducer is not None:
        return np.where(there, np.array(transducer.limit) / units.channels, np.nan)
    scale = np.abs(np.where(there, recording.readings, 1.0)).max(axis=0)
    return np.where(there, np.where(scale > 0.0, scale, 1.0), np.nan)


def checked_noise(noise: FloatArray, recording: Recording) -> FloatArray:
    """Refuse a recording without any noise, in which slips could not be told from rounding."""
    there = np.isfinite(recording.readings).all(axis=0) & (noise > LEAST_NOISE) & (noise < np.inf)
    forces = there[FORCES].all()
    if not (there[2] or forces):
        raise RecordingError(
            "the readings have no measurable noise: give the noise of one reading, as in "
            "'3 mN, 3 mN, 10 uN*m', or the transducer"
        )
    return np.where(there, noise, np.nan)


@dataclass(frozen=True, eq=False, kw_only=True)
class _Task:
    """A recording to be read, and all that is known of it.

    Attributes
    ----------
    recording : Recording
    noise : ndarray, shape (3,)
        Standard deviation of one reading; NaN of a channel that is not used.
    noise_is_given : bool
        Otherwise it was estimated.
    full_scale : ndarray, shape (3,)
    sizes : mapping of str to float
        Tolerances, in units of the rod, rad, or relative.
    stated : frozenset of str
        Names of those that were stated.
    slip_rows, delay : float or None
        How long a slip lasts, and by how much the readings lag, in samples.
    units : Units
    progress : callable
    """

    recording: Recording
    noise: FloatArray
    noise_is_given: bool
    full_scale: FloatArray
    sizes: Mapping[str, float]
    stated: frozenset[str]
    slip_rows: float | None
    delay: float | None
    units: Units
    progress: Progress

    @cached_property
    def _parameters(self) -> tuple[Parameter, ...]:
        return parameters_of(self.sizes, self.stated, self.full_scale)

    @cached_property
    def _used(self) -> list[int]:
        return np.flatnonzero(np.isfinite(self.noise)).tolist()

    @property
    def _both_forces(self) -> bool:
        return set(FORCES) <= set(self._used)

    @cached_property
    def _lone(self) -> BoolArray:
        """Which samples are lone peaks of a channel."""
        readings = self.recording.readings
        return np.any([spikes(readings[:, i], self.noise[i]) for i in self._used], axis=0)

    def _slipped(self, load: FloatArray, noise: float, spiky: BoolArray) -> Slipped:
        """Find the periods, by a load and its noise."""
        return Slipped.of(self.recording, load, noise, spiky, self.slip_rows or 0.0)

    def _setting(self, tolerances: tuple[Tolerance, ...], covariance: FloatArray) -> Setting:
        length = SLOPE_LENGTH / self.units.unit(Kind.LENGTH) if self.units.si else OWN_SLOPE_LENGTH
        return Setting(
            units=self.units,
            tolerances=tolerances,
            covariance=covariance,
            slope=self.sizes.get(SLOPE, 0.0),
            slope_length=length,
        )

    def _ratio(self, slipped: Slipped, lag: Lag) -> Identification:
        """Read by the ratio of the forces."""
        parameters = bearing(self._parameters)
        tolerances = tuple(
            Tolerance(
                name=one.name,
                of=one.of,
                tolerance=one.deviation,
                adjusted=0.0,
                deviation=one.deviation,
                wave=one.wave,
                stated=one.stated,
            )
            for one in parameters
        )
        covariance = np.diag([one.deviation**2 for one in parameters])
        periods = read_ratio(slipped, self.noise, parameters, self.full_scale, lag)
        setting = self._setting(tolerances, covariance)
        return Identification(periods=periods, setting=setting, by_model=False)

    def alone(self) -> Identification:
        """Read without a rod."""
        recording = self.recording
        if not self._both_forces:
            raise RecordingError("the method ratio needs the noise of both forces, above 0")
        check_forces(recording.readings[:, FORCES], self.noise[FORCES])
        slipped = self._slipped(recording.readings[:, 0], self.noise[0], self._lone)
        found = self._ratio(slipped, Lag(delay=self.delay or 0.0))
        assumed = [name for name in ZEROS if self.sizes.get(name) and name not in self.stated]
        untared = bool(assumed) and not recording.unloaded
        return _on_slope(_doubted(found, _untared(len(found.periods), untared)))

    def _modelled(self, whisker: Whisker) -> Modelled:
        """Read by the model of the rod."""
        recording, mounting = self.recording, whisker.mounting
        middle = 0.5 * (recording.clamp.min() + recording.clamp.max())
        level = replace(
            whisker,
            eta=float(whisker.eta - middle * np.sin(mounting.stage_angle)),
            mounting=replace(mounting, stage_angle=0.0),
        )
        self.progress("solving the rod", 0, 1)
        noise = self.noise[self._used]
        guide = Guide(branch=level.response(False), used=self._used, noise=noise)
        check_columns(guide, recording)
        self.progress("solving the rod", 1, 1)
        model = Model(
            whisker=whisker,
            guide=guide,
            parameters=self._parameters,
            noise=self.noise,
            noise_is_given=self.noise_is_given,
            delay=self.delay or 0.0,
            delay_is_known=self.delay is not None or self.slip_rows is not None,
            units=self.units,
        )
        spiky = guide.spiky(recording.readings, self._lone)
        slipped = self._slipped(*guide.load(recording.readings), spiky)
        return read_model(model, slipped)

    def _of_model(self, read: Modelled) -> Identification:
        fit = read.fit
        setting = replace(
            self._setting(tolerances_of(fit), fit.covariance),
            goodness=read.goodness,
            causes=read.causes,
            far=far_of(fit),
        )
        return Identification(periods=read.periods, setting=setting, by_model=True)

    def by_model(self, whisker: Whisker) -> Identification:
        """Read by the model of the rod, and compare with the ratio where that can be read."""
        try:
            read = self._modelled(whisker)
        except (NoResponseError, WrongRodError) as error:
            if not self._both_forces:
                raise
            text = f"{error}; --method ratio reads the forces without a rod"
            raise type(error)(text) from error
        found = self._of_model(read)
        if not self._both_forces:
            return _on_slope(found)
        try:
            ratio = self._ratio(read.slipped, read.lag)
        except RecordingError as error:
            return _on_slope(_noted(found, f"not compared with the ratio of the forces: {error}"))
        return _on_slope(_compared(found, beside(_read(found), _read(ratio))))

    def by_ratio(self, whisker: Whisker) -> Identification:
        """Read by the ratio of the forces, and compare with the model where that can be read."""
        try:
            read = self._modelled(whisker)
        except MixedColumnsError:
            raise
        except (NoResponseError, RecordingError) as error:
            return _noted(self.alone(), f"not compared with the model of the rod: {error}")
        found, other = self._ratio(read.slipped, read.lag), self._of_model(read)
        found = _compared(found, beside(_read(other), _read(found)))
        far = tuple(one for one in other.setting.far if one.of in BEARING and one.surprise > FAR)
        checks = [one for one in other.periods.checks if one.name == "far" and far]
        found = replace(found, setting=replace(found.setting, far=far))
        return _on_slope(_doubted(found, *checks))


def _read(found: Identification) -> Read:
    return Read(periods=found.periods, tolerances=found.tolerances, covariance=found.covariance)


def _compared(found: Identification, compared: Beside) -> Identification:
    """Doubt the periods of which model and ratio disagree."""
    size = f"{compared.size} " if not compared.agrees else ""
    check = Check(
        name="beside",
        grade=Grade.DOUBTFUL,
        periods=compared.off,
        sentence=f"{size}model and ratio of the forces disagree",
    )
    found = _doubted(found, check)
    return replace(found, setting=replace(found.setting, beside=compared))


def _untared(number: int, untared: bool) -> Check:
    """Doubt a friction without a rod where nothing is known of the zeros."""
    return Check(
        name="tare",
        grade=Grade.DOUBTFUL,
        periods=np.full(number, untared),
        sentence="no reading checks the tare: state zero_force_x and zero_force_y, or record some "
        "rows before the tip touches",
    )


def _doubted(found: Identification, *checks: Check) -> Identification:
    return replace(found, periods=found.periods.doubted(*checks))


def _noted(found: Identification, note: str) -> Identification:
    periods = found.periods
    return replace(found, periods=replace(periods, left_out=(*periods.left_out, note)))


def _on_slope(found: Identification) -> Identification:
    """Widen what was read by the slope of the surface, which both readings share."""
    return replace(found, periods=found.periods.on_slope(found.setting.slope))
