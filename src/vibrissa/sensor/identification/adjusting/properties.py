"""What a tolerance is of, as a change: of the whisker, of or of what is read.

A tolerance may have several components, each of which is adjusted: those of crosstalk are its six
entries. The zero of a channel drifts as a Wiener process: a straight line over the recording, and
sine waves about it with deviations that fall with their number (Wiener's series).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import permutations
from typing import Any, Self, TypeVar

import numpy as np

from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.given.tolerances import TOLERABLE
from vibrissa.sensor.identification.recording import Recording
from vibrissa.sensor.transducer import CHANNELS, Transducer
from vibrissa.sensor.whisker import Whisker

# Waves of a drift. What is left out has a deviation of 0.11 of that of the line.
WAVES = 8

_Readings = TypeVar("_Readings", bound=Recording)


@dataclass(frozen=True, kw_only=True)
class Property:
    """Something that may be larger than it was given.

    Attributes
    ----------
    whisker : callable
        Maps a whisker and a size to the whisker of which it is larger by so much.
    recording : callable
        Maps a recording and a size to what it would be without an error of that size.
    """

    whisker: Callable[[Whisker, float], Whisker] = lambda whisker, size: whisker
    recording: Callable[[Any, float], Any] = lambda recording, size: recording


def _zero(channel: int) -> Property:
    def corrected(recording: _Readings, size: float) -> _Readings:
        return recording.without(size * np.eye(3)[channel])

    return Property(recording=corrected)


def _mixing(*rows: Sequence[float]) -> Property:
    """Make a property of size p by which readings are (1 + p·rows) times the true ones."""

    def corrected(recording: _Readings, size: float) -> _Readings:
        error = size * np.array(rows, dtype=float)
        return recording.mixed(np.asarray(np.linalg.inv(np.eye(3) + error)))

    return Property(recording=corrected)


def _moved(recording: _Readings, size: float) -> _Readings:
    return replace(recording, clamp=recording.clamp * (1.0 + size))


def _in_longer_rod(recording: _Readings, size: float) -> _Readings:
    """Nondimensional recording of a rod whose length is larger."""
    ratio = 1.0 + size
    scaled = recording.readings * np.array([ratio**2, ratio**2, ratio])
    return replace(recording, readings=scaled, clamp=recording.clamp / ratio)


def _mounted(name: str) -> Callable[[Whisker, float], Whisker]:
    def changed(whisker: Whisker, size: float) -> Whisker:
        given: Any = getattr(whisker.mounting, name)
        first, *others = np.atleast_1d(np.asarray(given, dtype=float)).tolist()
        value: Any = (first + size, *others) if others else first + size
        return replace(whisker, mounting=replace(whisker.mounting, **{name: value}))

    return changed


_NONE = (0.0, 0.0, 0.0)
PROPERTIES = {
    "theta": Property(whisker=lambda one, size: replace(one, theta=one.theta + size)),
    "eta": Property(whisker=lambda one, size: replace(one, eta=one.eta + size)),
    "clamp_angle": Property(whisker=_mounted("clamp_angle")),
    "clamp_compliance": Property(whisker=_mounted("clamp_compliance")),
    "curvature": Property(whisker=_mounted("curvature")),
    "stage_angle": Property(whisker=_mounted("stage_angle")),
    # Of E, and of d0⁴.
    "modulus": _mixing((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "diameter": _mixing((4, 0, 0), (0, 4, 0), (0, 0, 4)),
    "length": Property(
        whisker=lambda one, size: replace(one, eta=one.eta / (1.0 + size)),
        recording=_in_longer_rod,
    ),
    "zero_force_x": _zero(0),
    "zero_force_y": _zero(1),
    "zero_moment_z": _zero(2),
    # Axes that are turned from x to y.
    "transducer_angle": _mixing((0, 1, 0), (-1, 0, 0), _NONE),
    # The moment about a point (a, b) is that about the clamp less a·fy − b·fx.
    "moment_origin_x": _mixing(_NONE, _NONE, (0, -1, 0)),
    "moment_origin_y": _mixing(_NONE, _NONE, (1, 0, 0)),
    "stage_scale": Property(recording=_moved),
}
# Those that need another rod solved.
OF_ROD = ("theta", "eta", "clamp_angle", "clamp_compliance", "curvature", "stage_angle", "length")
# Those that change nothing of the rod but its height.
OF_HEIGHT = ("eta", "length", "stage_angle")


@dataclass(frozen=True, eq=False, kw_only=True)
class Bench:
    """What a recording was made with.

    Attributes
    ----------
    full_scale : ndarray, shape (3,)
        Of the channels, nondimensional: the transducer's, or the largest readings.
    first, last : int
        Lines between which it was recorded.
    """

    full_scale: FloatArray
    first: int
    last: int

    @classmethod
    def of(
        cls, recording: Recording, transducer: Transducer | None, channel_units: FloatArray
    ) -> Self:
        """Make that of a recording."""
        if transducer is None:
            readings = np.where(np.isfinite(recording.readings), recording.readings, 0.0)
            scale = np.abs(readings).max(axis=0)
            scale = np.where(scale > 0.0, scale, 1.0)
        else:
            scale = np.array(transducer.limit) / channel_units
        first, last = int(recording.line[0]), int(recording.line[-1])
        return cls(full_scale=scale, first=first, last=max(last, first + 1))

    def part(self, recording: Recording) -> FloatArray:
        """Part of the recording, from 0 to 1, at which each sample was made."""
        return np.asarray((recording.line - self.first) / (self.last - self.first))


@dataclass(frozen=True, eq=False, kw_only=True)
class Component:
    """A property that is adjusted for a tolerance.

    Attributes
    ----------
    name : str
    of : str
        Name of the tolerance.
    property : Property
    weight : float
        Its deviation, in those of the tolerance.
    wave : int
        Number of the wave of a drift; 0 for all else.
    """

    name: str
    of: str
    property: Property
    weight: float = 1.0
    wave: int = 0


def components_of(name: str, bench: Bench) -> list[Component]:
    """Components of a tolerance.

    Parameters
    ----------
    name : str
        One of `TOLERABLE`.
    bench : Bench

    Returns
    -------
    list of Component
    """
    if name == "crosstalk":
        return [_crosstalk(i, j, bench) for i, j in permutations(range(3), 2)]
    if name.startswith("drift_"):
        channel = TOLERABLE[name].channel
        return [_drift(name, channel, wave, bench) for wave in range(WAVES + 1)]
    return [Component(name=name, of=name, property=PROPERTIES[name])]


def _crosstalk(to: int, source: int, bench: Bench) -> Component:
    rows = np.zeros((3, 3))
    rows[to, source] = bench.full_scale[to] / bench.full_scale[source]
    name = f"crosstalk of {CHANNELS[source]} in {CHANNELS[to]}"
    return Component(name=name, of="crosstalk", property=_mixing(*rows.tolist()))


def _drift(name: str, channel: int, wave: int, bench: Bench) -> Component:
    def corrected(recording: _Readings, size: float) -> _Readings:
        part = bench.part(recording)
        shape = np.sin(np.pi * wave * part) if wave else part
        return recording.without(size * shape[:, None] * np.eye(3)[channel])

    said = f"{name}, wave {wave}" if wave else name
    weight = np.sqrt(2.0) / (np.pi * wave) if wave else 1.0
    return Component(
        name=said, of=name, property=Property(recording=corrected), weight=weight, wave=wave
    )


def with_sizes(whisker: Whisker, components: Sequence[Component], sizes: FloatArray) -> Whisker:
    """Make properties of a whisker larger."""
    for one, size in zip(components, sizes, strict=True):
        whisker = one.property.whisker(whisker, float(size))
    return whisker


def without_errors(
    recording: _Readings, components: Sequence[Component], sizes: FloatArray
) -> _Readings:
    """Take errors of such sizes off a recording."""
    for one, size in zip(components, sizes, strict=True):
        recording = one.property.recording(recording, float(size))
    return recording
