"""Identification of friction with a whisker, in the units of its rod."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.errors import ArgumentError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.given.tolerances import assumed_tolerances, read_tolerances, told
from vibrissa.sensor.identification.adjusting.properties import Bench
from vibrissa.sensor.identification.both import (
    WithoutRod,
    WithRod,
    model_beside_ratio,
    ratio_beside_model,
)
from vibrissa.sensor.identification.preparing.settling import Told
from vibrissa.sensor.identification.reading.carried import Carried, bearing_tolerances
from vibrissa.sensor.identification.reading.slope import LENGTH, OWN_LENGTH, on_a_slope
from vibrissa.sensor.identification.reading.slope import NAME as SLOPE
from vibrissa.sensor.identification.recording import (
    Method,
    Recording,
    check_size,
    noise_of,
    read_recording,
    units_of,
)
from vibrissa.sensor.identification.result import Identification
from vibrissa.sensor.quantities import Kind, Quantity, Units, chosen, in_si
from vibrissa.sensor.transducer import CHANNELS, Transducer, transducer_of
from vibrissa.sensor.whisker import Progress, Whisker, quiet

if TYPE_CHECKING:
    from pandas import DataFrame

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


def _told(recording: Recording, slip_time: str | None, delay: str | None) -> Told:
    """Read times in units of the samples' interval.

    Raises
    ------
    ArgumentError
        If one of them is no time, or the recording does not tell the interval.
    """
    return Told(
        slip=_in_samples(recording, slip_time, "slip_time"),
        delay=_in_samples(recording, delay, "delay"),
    )


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
    sensor = transducer_of(transducer, units)
    given = _noise(noise, sensor, units)
    if method is not Method.RATIO and whisker is None:
        raise ArgumentError(
            f"the method {method} needs the rod: give theta and eta, or use the method ratio"
        )
    if not isinstance(recording, Recording):
        recording = read_recording(recording, units, method, sensor)
    check_size(len(recording), recording.notes)
    known = noise_of(recording.readings) if given is None else given
    if whisker is None:
        sizes = bearing_tolerances(tolerances or {}, units, known, assume)
        stated = frozenset(tolerances or {})
    else:
        whisker = whisker.tolerating(read_tolerances(units, tolerances or {}, whisker))
        assumed = assumed_tolerances(units, known) if assume else {}
        sizes, stated = {**assumed, **whisker.tolerances}, frozenset(whisker.tolerances)
    errors = Carried.of(sizes, Bench.of(recording, sensor, units.channels))
    alone = WithoutRod(recording=recording, noise=given, errors=errors, stated=stated, units=units)
    if whisker is None or whisker.units != units:
        return _on_a_slope(_with_tare_note(alone.read()), sizes)
    with_rod = WithRod(
        whisker=whisker,
        recording=recording,
        noise=given,
        transducer=sensor,
        assume=assume,
        told=_told(recording, slip_time, delay),
        units=units,
        progress=progress,
    )
    if method is Method.RATIO:
        return _on_a_slope(ratio_beside_model(alone, with_rod), sizes)
    return _on_a_slope(model_beside_ratio(with_rod, alone), sizes)


def _with_tare_note(found: Identification) -> Identification:
    """Say that nothing checks the tare, where nobody has stated how well the zeros are known."""
    zeros = [one for one in found.tolerances if one.of.startswith("zero_") and not one.stated]
    if not zeros:
        return found
    size, unit = told(zeros[0].of, zeros[0].tolerance, found.units)
    note = (
        f"no reading checks the tare: the zeros of both forces are taken to be right to ± "
        f"{size:.2g} {unit}. If they were not tared in air, this friction is wrong; state "
        "zero_force_x and zero_force_y"
    )
    notes = (*found.periods.notes, note)
    return replace(found, periods=replace(found.periods, notes=notes))


def _on_a_slope(found: Identification, sizes: Mapping[str, float]) -> Identification:
    """Widen what was read by the slope of the surface, which both readings share."""
    slope, units = sizes.get(SLOPE, 0.0), found.units
    length = LENGTH / units.unit(Kind.LENGTH) if units.si else OWN_LENGTH
    periods = on_a_slope(found.periods, slope)
    return replace(found, periods=periods, slope=slope, slope_length=length)
