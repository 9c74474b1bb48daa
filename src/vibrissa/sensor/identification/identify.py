"""Identification of friction with a whisker, in the units of its rod."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from vibrissa.errors import (
    ArgumentError,
    MixedColumnsError,
    NoResponseError,
    RecordingError,
    WrongRodError,
)
from vibrissa.sensor.identification.checks import Check, disagreeing, unfitted, untared
from vibrissa.sensor.identification.compare import beside
from vibrissa.sensor.identification.model import read_model
from vibrissa.sensor.identification.parameters import BEARING
from vibrissa.sensor.identification.ratio import read_ratio
from vibrissa.sensor.identification.recording import (
    Method,
    Recording,
    check_size,
    read_recording,
    units_of,
)
from vibrissa.sensor.identification.result import Identification
from vibrissa.sensor.identification.task import Task, in_samples, task_of
from vibrissa.sensor.quantities import Quantity, Units, chosen
from vibrissa.sensor.transducer import Transducer, transducer_of
from vibrissa.sensor.whisker import Progress, Whisker, quiet

if TYPE_CHECKING:
    from pandas import DataFrame

# A cause that explains this part of a misfit is the one.
MOST = 0.9


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
        The rod and its height, which may be a first guess; None for the method ``ratio``. Without
        it numbers are in SI units, or in those of the recording.
    recording : Recording, Path, str or DataFrame
        A table needs the columns ``footpoint`` and those that the method uses, each with its unit:
        ``footpoint [mm]``, ``force_x [N]``. A DataFrame may have the units in ``attrs["units"]``.
        Columns without a unit are in SI units, or dimensionless if the rod is.
    method : Method, optional
        Method of estimating friction; default: ``model`` with a rod, else ``ratio``.
    transducer : Transducer or str, optional
        The transducer of the recording: its noise and range.
    noise : str or array_like, shape (3,), optional
        Standard deviation of one reading of force_x, force_y and moment_z, as in
        ``"3 mN, 3 mN, 10 uN*m"``. Estimated if neither it nor the transducer is given.
    tolerances : mapping of str to str or number, optional
        Standard deviations of the set-up, as in ``{"clamp_angle": "0.5 deg", "modulus": "2 %"}``,
        or ``"exact"``, beside those of the whisker: the set-up is fitted within them; see
        `vibrissa.sensor.tolerances.TOLERABLE`.
    assume : bool
        Use default tolerances for quantities without a stated one; otherwise they are exact.
    slip_time : str, optional
        Duration of a slip: ``"10 ms"``.
    delay : str, optional
        Delay of the readings, as by a low-pass filter: ``"4 ms"``.
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
    method = chosen(Method, method or (Method.MODEL if whisker else Method.RATIO), "method")
    if method is not Method.RATIO and whisker is None:
        raise ArgumentError(
            f"the method {method} needs the rod: give theta and eta, or use the method ratio"
        )
    recording = Path(recording) if isinstance(recording, str) else recording
    if whisker is not None:
        whisker = whisker.wishing(noise, *(tolerances or {}).values())
    units = _units(whisker, recording, method)
    sensor = None if transducer is None else transducer_of(transducer, units)
    if not isinstance(recording, Recording):
        recording = read_recording(recording, units, method, sensor)
    check_size(len(recording), recording.notes)
    # Without a size of the rod a recording in SI units has nothing to do with it.
    rod = whisker if whisker is not None and whisker.units == units else None
    task = replace(
        task_of(recording, rod, units, sensor, noise, tolerances or {}, assume),
        slip_rows=in_samples(recording, slip_time, "slip_time"),
        delay=in_samples(recording, delay, "delay"),
    )
    progress("reading the recording", 0, 1)
    if rod is not None and method is Method.MODEL:
        found = _by_model(task, rod)
    else:
        found = _by_ratio(task, rod)
    progress("reading the recording", 1, 1)
    # Both readings share the slope of the surface.
    return replace(found, periods=found.periods.on_slope(found.setting.slope))


def _units(
    whisker: Whisker | None, recording: "Recording | Path | DataFrame", method: Method
) -> Units:
    """Units of the rod; without a rod those of the recording."""
    if whisker is not None and (whisker.rod is not None or method is not Method.RATIO):
        return whisker.units
    return Units() if isinstance(recording, Recording) else units_of(recording)


def _by_model(task: Task, whisker: Whisker) -> Identification:
    """Read by the model of the rod, and compare with the ratio where that can be read."""
    try:
        task, slipped, found = read_model(task, whisker)
    except (NoResponseError, WrongRodError) as error:
        if not task.both_forces:
            raise
        text = f"{error}; --method ratio reads the forces without a rod"
        raise type(error)(text) from error
    if not task.both_forces:
        return found
    try:
        return _compared(found, found, read_ratio(task, slipped))
    except RecordingError as error:
        return _noted(found, f"not compared with the ratio of the forces: {error}")


def _by_ratio(task: Task, whisker: Whisker | None) -> Identification:
    """Read by the ratio of the forces, and compare with the model where that can be read."""
    if whisker is None:
        return _alone(task)
    try:
        task, slipped, model = read_model(task, whisker)
    except MixedColumnsError:
        raise
    except (NoResponseError, RecordingError) as error:
        return _noted(_alone(task), f"not compared with the model of the rod: {error}")
    ratio = read_ratio(task, slipped)
    found, of_model = _compared(ratio, model, ratio), model.setting
    # What the model finds other than it was given may bear on the ratio, unless it surely does not.
    far = any(one.far and one.of in BEARING for one in of_model.tolerances)
    elsewhere = any(one.explained > MOST and one.of not in BEARING for one in of_model.causes)
    if not far and (of_model.fits or elsewhere):
        return found
    setting = replace(found.setting, goodness=of_model.goodness, causes=of_model.causes)
    found = replace(found, setting=setting)
    return _doubted(found, unfitted(True, of_model.fits, len(found.periods)))


def _alone(task: Task) -> Identification:
    """Read without a rod."""
    task = task.with_scatter()
    found = read_ratio(task, task.slipped)
    return _doubted(found, untared(len(found.periods))) if task.untared else found


def _compared(
    found: Identification, model: Identification, ratio: Identification
) -> Identification:
    """Doubt the periods of which model and ratio disagree."""
    compared = beside(model, ratio)
    found = _doubted(found, disagreeing(compared.off, not compared.agrees))
    return replace(found, setting=replace(found.setting, beside=compared))


def _doubted(found: Identification, *checks: Check) -> Identification:
    return replace(found, periods=found.periods.doubted(*checks))


def _noted(found: Identification, note: str) -> Identification:
    periods = found.periods
    return replace(found, periods=replace(periods, left_out=(*periods.left_out, note)))
