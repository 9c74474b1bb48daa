"""The profile under the tip: the contact point of each sample, and how uncertain it is.

The contact point follows from the loads of one sample alone: see `vibrissa.sensor.location`. Noise
is independent from sample to sample; what is not known of the set-up shifts or tilts the profile.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vibrissa.errors import RecordingError
from vibrissa.numerics.arrays import FloatArray, IntArray
from vibrissa.quantities.series import Column, Tabular
from vibrissa.quantities.units import Kind, Units
from vibrissa.sensor.identification.derivatives import moved, scale_of
from vibrissa.sensor.identification.parameters import ScanRows
from vibrissa.sensor.identification.task import Task
from vibrissa.sensor.location import Located, located
from vibrissa.sensor.whisker import Whisker

# Step of the difference quotients of loads, as a part of the largest load of each channel.
LOAD_STEP = 1e-5


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactProfile(Tabular):
    """Contact point of each of n samples; lengths in units of the given rod.

    Attributes
    ----------
    clamp : ndarray, shape (n,)
        Position of the clamp.
    located : Located
        Contact points and contact forces.
    height : ndarray, shape (n,)
        Height of the contact point over the plane at the given height η, positive towards the
        clamp.
    x_deviation, height_deviation : ndarray, shape (n,)
        Standard deviations by noise and tolerances together.
    x_noise, height_noise : ndarray, shape (n,)
        Their parts by noise, which are independent from sample to sample.
    line : ndarray of int, shape (n,)
        Line of each sample in its file.
    units : Units
    """

    clamp: FloatArray
    located: Located
    height: FloatArray
    x_deviation: FloatArray
    height_deviation: FloatArray
    x_noise: FloatArray
    height_noise: FloatArray
    line: IntArray
    units: Units

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.clamp)

    def columns(self) -> dict[str, Column]:
        """Columns by name, with units; they have one row for each sample."""
        unit = self.units.unit(Kind.LENGTH)
        length = self.units.name(Kind.LENGTH)
        force, force_name = self.units.channels[0], self.units.name(Kind.FORCE)
        found = self.located
        both = "standard deviation by noise and tolerances"
        alone = "its part by noise, independent from sample to sample"
        return {
            "footpoint": Column(self.clamp * unit, length, "position of the clamp"),
            "x": Column(found.x * unit, length, "position of the contact point"),
            "height": Column(self.height * unit, length, "height of the contact point over eta"),
            "x_deviation": Column(self.x_deviation * unit, length, both),
            "x_noise": Column(self.x_noise * unit, length, alone),
            "height_deviation": Column(self.height_deviation * unit, length, both),
            "height_noise": Column(self.height_noise * unit, length, alone),
            "s_c": Column(found.s_c * unit, length, "arc length of the contact point"),
            "along": Column(found.along * force, force_name, "contact force along the rod"),
            "across": Column(found.across * force, force_name, "contact force across the rod"),
            "line": Column(self.line, "1", "line of the sample"),
        }


class _Places(NamedTuple):
    """Position of contact points and their height over the plane at η (L of the given rod)."""

    x: FloatArray
    height: FloatArray


def profile_of(task: Task, whisker: Whisker) -> ContactProfile:
    """Locate the contact point of each sample of a recording.

    Raises
    ------
    RecordingError
        If one of the three channels is not used.
    """
    if not np.isfinite(task.noise).all():
        raise RecordingError(
            "the profile needs all three channels, force_x, force_y and moment_z, with a noise "
            "above 0"
        )
    recording = task.recording
    clamp = recording.clamp
    loads = recording.readings
    nothing = dict.fromkeys(task.number, 0.0)
    contact = located(whisker, clamp, loads)
    places = _places(contact, whisker)
    step = LOAD_STEP * np.abs(loads).max(axis=0)
    # Derivatives with respect to the loads, shape (3, 2, n).
    by_load = np.array(
        [
            (np.array(_places(located(whisker, clamp, loads + change), whisker)) - places)
            / change.sum()
            for change in np.diag(step)
        ]
    )
    noise = np.einsum("kcn,k->cn", by_load**2, task.noise**2)
    total = noise.copy()
    for change in _changes(task, whisker, nothing, places, by_load):
        total += change**2
    return ContactProfile(
        clamp=clamp,
        located=contact,
        height=places.height,
        x_deviation=np.sqrt(total[0]),
        height_deviation=np.sqrt(total[1]),
        x_noise=np.sqrt(noise[0]),
        height_noise=np.sqrt(noise[1]),
        line=recording.line,
        units=task.units,
    )


def _places(contact: Located, whisker: Whisker, length: float = 1.0) -> _Places:
    """Positions and heights of contact points of a rod that is `length` times the given one."""
    return _Places(x=contact.x * length, height=(whisker.eta - contact.y) * length)


def _changes(
    task: Task, stated: Whisker, nothing: dict[str, float], places: _Places, by_load: FloatArray
) -> Iterator[FloatArray]:
    """Change of position and height by one standard deviation of each parameter, shape (2, n)."""
    recording = task.recording
    rows = ScanRows.of(np.arange(len(recording)), len(recording))
    for parameter in task.parameters:
        if not parameter.deviation:
            continue
        if parameter.effect is not None:
            # The loads are smaller by what the parameter adds to the readings.
            wrong = parameter.effect(recording.readings, rows)
            yield -parameter.deviation * np.einsum("kcn,nk->cn", by_load, wrong)
            continue
        size = nothing | {parameter.name: parameter.step}
        whisker = moved(stated, size)
        length = 1.0 + size["length"]
        loads = recording.readings * np.array([length**2, length**2, length])
        contact = located(whisker, scale_of(size) * recording.clamp, loads)
        change = np.array(_places(contact, whisker, length)) - np.array(places)
        yield parameter.deviation * (change / parameter.step)
