"""Identification of friction with a whisker, in the units of its rod."""

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibrissa.errors import (
    ArgumentError,
    MixedColumnsError,
    NoResponseError,
    RecordingError,
    VibrissaError,
    WrongRodError,
)
from vibrissa.outcomes import Method, chosen
from vibrissa.quantities.units import Units
from vibrissa.sensor.identification.findings import beside
from vibrissa.sensor.identification.mixing import check_columns, table_of_states
from vibrissa.sensor.identification.model import read_model, unfitted
from vibrissa.sensor.identification.parameters import REFUTE_RATIO
from vibrissa.sensor.identification.periods import Check, Grade, Periods, PeriodStatus
from vibrissa.sensor.identification.profile import profile_of
from vibrissa.sensor.identification.ratio import read_ratio
from vibrissa.sensor.identification.recording import (
    FEWEST_SAMPLES,
    Recording,
    as_measured,
    read_recording,
    table_of,
    units_of,
)
from vibrissa.sensor.identification.result import Identification
from vibrissa.sensor.identification.task import Task, in_samples, task_of
from vibrissa.sensor.ringing import DAMPING, ringing_of
from vibrissa.sensor.setup import Setup
from vibrissa.sensor.transducer import transducer_of
from vibrissa.sensor.whisker import Whisker
from vibrissa.wording import counted

if TYPE_CHECKING:
    from pandas import DataFrame

# Part of a misfit above which a quantity that explains it is taken as its only cause.
ONLY_CAUSE_EXPLAINS = 0.9
UNTARED = (
    "the zeros of the forces are not checked: state zero_force_x and zero_force_y, or record rows "
    "before the tip touches"
)
UNCHECKED = (
    "nothing checks mu0, as the rod is not known: a transducer that is turned by some degrees, or "
    "a gain that is wrong by 10 %, would not be noticed"
)


def identify(
    setup: Setup,
    recording: "Recording | Path | str | DataFrame",
    *,
    method: Method | str | None = None,
    slip_time: str | None = None,
    delay: str | None = None,
    profile: bool = False,
) -> Identification:
    """Find the periods of sticking in a recording, and the friction of each.

    Parameters
    ----------
    setup : Setup
        The rod, its clamp and the transducer, with their tolerances. The set-up is fitted within
        the tolerances. The noise is estimated if neither noise nor transducer is stated. If theta
        and eta are not stated, only the method ``ratio`` is possible, and results are in SI units,
        or nondimensional if the recording is.
    recording : Recording, Path, str or DataFrame
        A table needs the columns ``footpoint`` and those that the method uses, each with its unit:
        ``footpoint [mm]``, ``force_x [N]``. A DataFrame may have the units in ``attrs["units"]``.
    method : Method, optional
        Method of estimating friction; default: ``model`` if theta and eta are stated, else
        ``ratio``.
    slip_time : str, optional
        Duration of a slip, ``"10 ms"``; its samples are left out.
    delay : str, optional
        Delay of a low-pass filter, which shows a slip at once but not in full: ``"4 ms"``. Not a
        dead time: shift the readings by that first.
    profile : bool
        Whether to locate the contact point of each sample, too; it needs the rod and all channels.

    Returns
    -------
    Identification

    Raises
    ------
    ArgumentError
        If an argument or a quantity of the set-up is out of range.
    RecordingError
        If the recording cannot be used; the message names the line.
    NoResponseError
        If the response of the whisker is not found.
    """
    problem = _problem(setup, recording, method, slip_time, delay)
    task = problem.task
    whisker = problem.whisker
    if profile and whisker is None:
        raise ArgumentError(
            "the profile needs the rod: give theta and eta, and its size in SI units"
        )
    located = profile_of(task, whisker) if profile and whisker is not None else None
    identification = _answer(problem, None if whisker is None else _by_both(task, whisker))
    return replace(identification, profile=located)


def identify_by(
    setup: Setup, recording: "DataFrame", methods: Sequence[Method]
) -> list[Identification | VibrissaError]:
    """Identify the friction in a recording by several methods.

    Each result is that of `identify`, or the error that it raises. As `identify` compares both
    methods, whichever gives the friction, they are computed once for all.
    """
    results: list[Identification | VibrissaError] = []
    known: list[tuple[Task, _ByBoth]] = []
    for method in methods:
        try:
            problem = _problem(setup, recording, method, None, None)
            both = next((by_both for task, by_both in known if _alike(task, problem.task)), None)
            if both is None and problem.whisker is not None:
                both = _by_both(problem.task, problem.whisker)
                known.append((problem.task, both))
            results.append(_answer(problem, both))
        except VibrissaError as error:
            results.append(error)
    return results


class _Problem(NamedTuple):
    """A recording as a method reads it, the rod that it is compared with, and the set-up."""

    method: Method
    task: Task
    whisker: Whisker | None
    setup: Setup


class _ByBoth(NamedTuple):
    """Friction by each method, or the error that says why there is none."""

    model: Identification | NoResponseError | RecordingError
    ratio: Identification | RecordingError


def _problem(
    setup: Setup,
    recording: "Recording | Path | str | DataFrame",
    method: Method | str | None,
    slip_time: str | None,
    delay: str | None,
) -> _Problem:
    """Read the recording; see `identify` for arguments and errors."""
    whisker = setup.whisker if setup.has_whisker else None
    method = chosen(Method, method or (Method.MODEL if whisker else Method.RATIO), "method")
    if method is Method.MODEL and whisker is None:
        raise ArgumentError(
            f"the method {method} needs the rod: give theta and eta, or use the method ratio"
        )
    source = Path(recording) if isinstance(recording, str) else recording
    table = source if isinstance(source, Recording) else table_of(source, method)
    if whisker is not None and (whisker.rod is not None or method is Method.MODEL):
        units = whisker.units
    else:
        units = Units() if isinstance(table, Recording) else units_of(table)
    sensor = None if setup.transducer is None else transducer_of(setup.transducer, units)
    if isinstance(table, Recording):
        samples = as_measured(table)
    else:
        samples = read_recording(table, units, method, sensor)
    if len(samples) < FEWEST_SAMPLES:
        few = f"too few rows to identify friction from: {counted(len(samples), 'usable row')}"
        raise RecordingError("; ".join((few, *samples.notes)))
    samples = replace(
        samples,
        slip_rows=in_samples(samples, slip_time, "slip_time"),
        delay=in_samples(samples, delay, "delay"),
    )
    # A recording in SI units cannot be compared with a rod whose size is not known.
    if whisker is not None and whisker.units != units:
        whisker = None
    task = task_of(samples, setup, whisker, sensor, units)
    return _Problem(method=method, task=task, whisker=whisker, setup=setup)


def _alike(first: Task, second: Task) -> bool:
    """Whether two methods use the same rows and channels of a recording."""
    same = first.used == second.used and first.recording.notes == second.recording.notes
    return same and np.array_equal(first.recording.line, second.recording.line)


def _answer(problem: _Problem, both: _ByBoth | None) -> Identification:
    """Return the friction by the method of the problem; `both` is None without a rod."""
    task = problem.task
    whisker = problem.whisker
    if whisker is None or both is None:
        answer = _by_ratio_alone(read_ratio(task), task).noted(UNCHECKED)
    else:
        answer = _chosen(both, task, problem.method)
        density = problem.setup.in_si("density")
        answer = answer.noted(*_too_fast(answer.periods, task.recording.interval, whisker, density))
    # The slope of the surface changes the friction by both methods alike.
    return replace(answer, periods=answer.periods.on_slope(answer.slope))


def _too_fast(
    periods: Periods, interval: float, whisker: Whisker, density: float | None
) -> list[str]:
    """Return a note if the rod still rings from a slip when the next one begins."""
    slips = np.flatnonzero(periods.status == PeriodStatus.SLIP)
    if not (len(slips) and np.isfinite(interval) and whisker.curve.pieces):
        return []
    x0 = whisker.curve.onset(float(np.median(periods.mu0[slips])))
    rings = ringing_of(whisker, float(x0), density) if np.isfinite(x0) else None
    between = interval * float(np.median(periods.last[slips] - periods.first[slips] + 1))
    if rings is None or not rings.lasts > between:
        return []
    return [
        f"the stage is too fast: a period of sticking lasts {between:.2g} s, and the rod slips and "
        f"rings for {rings.lasts:.2g} s (first natural frequency {rings.frequencies[0]:.3g} Hz, "
        f"damping ratio {DAMPING:g}); move the stage {math.ceil(rings.lasts / between)} times more "
        "slowly"
    ]


def _by_ratio_alone(ratio: Identification, task: Task) -> Identification:
    """Doubt the friction by the ratio of the forces alone, if the zeros are not known."""
    everywhere = np.full(len(task.spans), task.untared)
    return ratio.doubted(Check(Grade.DOUBTFUL, everywhere, UNTARED))


def _by_both(task: Task, whisker: Whisker) -> _ByBoth:
    """Estimate friction by each of the methods.

    Raises
    ------
    MixedColumnsError
        If columns seem to be mixed up, compared with the rod.
    """
    model: Identification | NoResponseError | RecordingError
    ratio: Identification | RecordingError
    try:
        table = table_of_states(task, whisker)
        check_columns(task, table)
        model = read_model(task, whisker, table)
    except MixedColumnsError:
        raise
    except (NoResponseError, RecordingError) as error:
        model = error
    try:
        ratio = read_ratio(task)
    except RecordingError as error:
        ratio = error
    return _ByBoth(model=model, ratio=ratio)


def _chosen(both: _ByBoth, task: Task, method: Method) -> Identification:
    """Return the friction by one method, compared with the other method if that succeeded."""
    model, ratio = both
    if isinstance(model, VibrissaError):
        if method is Method.MODEL:
            alone = task.both_forces and isinstance(model, NoResponseError | WrongRodError)
            more = "; or use --method ratio, which needs no rod" if alone else ""
            raise type(model)(f"{model}{more}") from model
        if isinstance(ratio, RecordingError):
            raise ratio
        why = f"the forces are no loads of this rod, or cannot be compared with it: {model}"
        return _in_doubt(_by_ratio_alone(ratio, task), why)
    if isinstance(ratio, RecordingError):
        if method is Method.RATIO:
            raise ratio
        why = f"the model of the rod is not compared with the ratio of the forces: {ratio}"
        return _in_doubt(model, why) if task.both_forces else model.noted(why)
    compared = beside(model, ratio)
    chosen = model if method is Method.MODEL else ratio
    apart = "model and ratio of the forces disagree"
    checks = [Check(Grade.DOUBTFUL, compared.off, apart, summed=not compared.agrees)]
    if method is Method.RATIO and _bears_on_ratio(model):
        chosen = replace(chosen, goodness=model.goodness, causes=model.causes)
        checks.append(unfitted(model))
    # The slope of the surface is an error of the friction by the ratio, but not of the difference.
    deviation = np.hypot(compared.deviation, task.slope.errors(compared.ratio))
    return replace(chosen, beside=replace(compared, deviation=deviation)).doubted(*checks)


def _in_doubt(identification: Identification, why: str) -> Identification:
    """Return the result with a reason to doubt all periods."""
    return identification.doubted(
        Check(Grade.DOUBTFUL, np.full(len(identification.periods), True), why)
    )


def _bears_on_ratio(model: Identification) -> bool:
    """Whether a deviation from the given set-up, found by the model, may change the ratio, too."""
    uneven = model.goodness is not None and model.goodness.uneven
    if uneven or any(
        estimate.far and estimate.parameter.of in REFUTE_RATIO for estimate in model.estimates
    ):
        return True
    likely = [cause.parameter.of for cause in model.causes if cause.explained > ONLY_CAUSE_EXPLAINS]
    elsewhere = (of not in REFUTE_RATIO for of in likely)
    return not (model.fits or any(elsewhere))
