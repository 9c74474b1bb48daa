"""Friction by the model of the rod and by the ratio of the forces, each beside the other."""

from dataclasses import dataclass, replace

import numpy as np

from vibrissa.errors import (
    MixedColumnsError,
    NoResponseError,
    RecordingError,
    WrongRodError,
)
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.sensor.identification.adjusting.adjustment import FAR, Tolerance
from vibrissa.sensor.identification.adjusting.fit import fit_rod
from vibrissa.sensor.identification.alternatives import alternatives_to
from vibrissa.sensor.identification.friction import Periods, find_periods
from vibrissa.sensor.identification.misfit.beside import Beside, Read, beside
from vibrissa.sensor.identification.misfit.doubts import Doubt, Doubted, notes_of, with_reason
from vibrissa.sensor.identification.preparing.settling import Told
from vibrissa.sensor.identification.reading.carried import BEARING, Carried
from vibrissa.sensor.identification.recording import FORCES, Recording
from vibrissa.sensor.identification.result import Identification
from vibrissa.sensor.identification.without_rod import read_ratio
from vibrissa.sensor.quantities import Units
from vibrissa.sensor.transducer import Transducer
from vibrissa.sensor.whisker import Progress, Whisker


@dataclass(frozen=True, eq=False, kw_only=True)
class WithoutRod:
    """A recording that is read by the ratio of its forces.

    Attributes
    ----------
    recording : Recording
    noise : ndarray, shape (3,), or None
        Standard deviation of one reading; None if it is to be estimated.
    errors : Carried
    stated : frozenset of str
        Names of the tolerances that were stated.
    units : Units
    """

    recording: Recording
    noise: FloatArray | None
    errors: Carried
    stated: frozenset[str]
    units: Units

    @property
    def possible(self) -> bool:
        """Whether both forces were recorded."""
        return not np.isnan(self.recording.readings[:, FORCES]).any()

    def read(self) -> Identification:
        """Read the friction, with those tolerances that change the ratio."""
        tolerances = tuple(
            Tolerance(
                name=one.name,
                of=one.of,
                tolerance=float(size),
                adjusted=0.0,
                deviation=float(size),
                wave=one.wave,
                stated=one.of in self.stated,
            )
            for one, size in zip(self.errors.components, self.errors.sizes, strict=True)
        )
        return Identification(
            periods=read_ratio(self.recording, self.noise, self.errors),
            setup=None,
            units=self.units,
            tolerances=tolerances,
            covariance=np.diag(self.errors.sizes**2),
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class WithRod:
    """A recording that is read with a model of the rod.

    Attributes
    ----------
    whisker : Whisker
        With its tolerances.
    recording : Recording
    noise : ndarray, shape (3,), or None
        Standard deviation of one reading; None if it is to be estimated.
    transducer : Transducer or None
    assume : bool
        Whether what nothing is stated about has the tolerance that is assumed for it.
    told : Told
    units : Units
    progress : callable
    """

    whisker: Whisker
    recording: Recording
    noise: FloatArray | None
    transducer: Transducer | None
    assume: bool
    told: Told
    units: Units
    progress: Progress

    def read(self) -> Identification:
        """Adjust the rod, and read the friction with it."""
        given = self.noise, self.transducer, self.assume, self.progress
        fit = fit_rod(self.whisker, self.recording, *given)
        kept = fit.settled(self.recording, self.told)
        if kept is not self.recording:
            fit = fit_rod(self.whisker, kept, *given)
        size, solver = len(fit.recording), fit.solver
        periods = find_periods(
            fit.setup,
            fit.recording,
            fit.noise,
            alternatives=lambda: alternatives_to(fit.whisker, lambda one: solver.quick(one)[0]),
            doubtful=fit.doubtful,
            units=self.units,
            progress=lambda done: self.progress("identifying", done, size),
        )
        return Identification(periods=periods, units=self.units, **fit.result)


def model_beside_ratio(model: WithRod, ratio: WithoutRod) -> Identification:
    """Read by the model of the rod, and compare with the ratio where that can be read.

    Raises
    ------
    WrongRodError, NoResponseError
        If the model cannot be read; the message offers the ratio.
    """
    try:
        found = model.read()
    except (NoResponseError, WrongRodError) as error:
        if not ratio.possible:
            raise
        raise type(error)(f"{error}; --method ratio reads the forces without a rod") from error
    if not ratio.possible:
        return found
    try:
        other = ratio.read()
    except RecordingError as error:
        return _noted(found, f"not compared with the ratio of the forces: {error}")
    compared = beside(_read(found), _read(other))
    return replace(_doubted(found, compared, compared.off), beside=compared)


def ratio_beside_model(ratio: WithoutRod, model: WithRod) -> Identification:
    """Read by the ratio of the forces, and compare with the model where that can be read.

    Raises
    ------
    MixedColumnsError
        If the model tells that the columns are mixed up.
    """
    found = ratio.read()
    try:
        other = model.read()
    except MixedColumnsError:
        raise
    except (NoResponseError, RecordingError) as error:
        return _noted(found, f"not compared with the model of the rod: {error}")
    compared = beside(_read(other), _read(found))
    lines = other.periods.last_line[compared.off]
    found = _doubted(found, compared, np.isin(found.periods.last_line, lines))
    every = np.ones(len(found.periods), dtype=bool)
    for one in other.tolerances:
        if one.of in BEARING and not one.wave and one.surprise > FAR:
            said = f"{one.name} ({one.surprise:.1f} standard deviations)"
            found = _with(found, Doubted(doubt=Doubt.FAR, channel=said, periods=every))
            found = replace(found, far=(*found.far, one))
    return replace(found, beside=compared)


def _read(found: Identification) -> Read:
    return Read(periods=found.periods, tolerances=found.tolerances, covariance=found.covariance)


def _doubted(found: Identification, compared: Beside, off: BoolArray) -> Identification:
    """Doubt the periods that disagree."""
    size = compared.size if not compared.agrees else ""
    return _with(found, Doubted(doubt=Doubt.BESIDE, channel=size, periods=off))


def _with(found: Identification, reason: Doubted) -> Identification:
    periods = found.periods
    grade, doubt = with_reason(periods.grade, periods.doubt, reason)
    notes = notes_of([reason], periods.first_line, periods.last_line)
    changed: Periods = replace(periods, grade=grade, doubt=doubt, notes=(*periods.notes, *notes))
    return replace(found, periods=changed)


def _noted(found: Identification, note: str) -> Identification:
    return replace(found, periods=replace(found.periods, notes=(*found.periods.notes, note)))
