"""What may be other than it was given: the rod, its clamp and height, the transducer, the stage."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from vibrissa.errors import NoResponseError
from vibrissa.sensor.identification.periods import Placed, Samples
from vibrissa.sensor.identification.recording import Recording
from vibrissa.sensor.quantities import Kind, Units
from vibrissa.sensor.response.branch import Branch
from vibrissa.sensor.whisker import Whisker

# Change of each property by which its effect is told (in units of the rod, rad, or relative).
STEP = 1e-3
# The forces are singular at η = 1: there it is this part of 1 − η, downwards.
STEP_IN_GAP = 1e-2
# The same scale of all loads as the modulus has.
AS_MODULUS = ("diameter",)

_Readings = TypeVar("_Readings", bound=Recording)


@dataclass(frozen=True, kw_only=True)
class Property:
    """Something that may be larger than it was given.

    Attributes
    ----------
    kind : Kind
        What it measures; NUMBER also where it is relative.
    whisker : callable
        Maps a whisker and a size to the whisker of which it is larger by so much.
    recording : callable
        Maps a recording and a size to what it would be without an error of that size.
    """

    kind: Kind
    whisker: Callable[[Whisker, float], Whisker] = lambda whisker, size: whisker
    recording: Callable[[Any, float], Any] = lambda recording, size: recording


def _zero(channel: int, kind: Kind) -> Property:
    def corrected(recording: _Readings, size: float) -> _Readings:
        return recording.without(size * np.eye(3)[channel])

    return Property(kind=kind, recording=corrected)


def _mixing(kind: Kind, *rows: tuple[float, float, float]) -> Property:
    """Make a property of size p by which readings are (1 + p·rows) times the true ones."""

    def corrected(recording: _Readings, size: float) -> _Readings:
        error = size * np.array(rows, dtype=float)
        return recording.mixed(np.asarray(np.linalg.inv(np.eye(3) + error)))

    return Property(kind=kind, recording=corrected)


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
    "theta": Property(
        kind=Kind.NUMBER, whisker=lambda one, size: replace(one, theta=one.theta + size)
    ),
    "eta": Property(kind=Kind.LENGTH, whisker=lambda one, size: replace(one, eta=one.eta + size)),
    "clamp_angle": Property(kind=Kind.ANGLE, whisker=_mounted("clamp_angle")),
    "clamp_compliance": Property(kind=Kind.COMPLIANCE, whisker=_mounted("clamp_compliance")),
    "curvature": Property(kind=Kind.CURVATURE, whisker=_mounted("curvature")),
    "stage_angle": Property(kind=Kind.ANGLE, whisker=_mounted("stage_angle")),
    # Of E, and of d0⁴.
    "modulus": _mixing(Kind.NUMBER, (1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "diameter": _mixing(Kind.NUMBER, (4, 0, 0), (0, 4, 0), (0, 0, 4)),
    "length": Property(
        kind=Kind.NUMBER,
        whisker=lambda one, size: replace(one, eta=one.eta / (1.0 + size)),
        recording=_in_longer_rod,
    ),
    "zero_force_x": _zero(0, Kind.FORCE),
    "zero_force_y": _zero(1, Kind.FORCE),
    "zero_moment_z": _zero(2, Kind.MOMENT),
    # Axes that are turned from x to y.
    "transducer_angle": _mixing(Kind.ANGLE, (0, 1, 0), (-1, 0, 0), _NONE),
    # The moment about a point (a, b) is that about the clamp less a·fy − b·fx.
    "moment_origin_x": _mixing(Kind.LENGTH, _NONE, _NONE, (0, -1, 0)),
    "moment_origin_y": _mixing(Kind.LENGTH, _NONE, _NONE, (1, 0, 0)),
    "stage_scale": Property(kind=Kind.NUMBER, recording=_moved),
}
# Those that are parts of the value that was given, and those that need another rod solved.
RELATIVE = ("modulus", "diameter", "length", "stage_scale")
OF_ROD = ("theta", "eta", "clamp_angle", "clamp_compliance", "curvature", "stage_angle", "length")


def told(name: str, size: float, units: Units) -> tuple[float, str]:
    """Give a size of a property in a person's unit, and this unit."""
    kind = PROPERTIES[name].kind
    if name in RELATIVE:
        return 100.0 * size, "%"
    if kind is Kind.ANGLE:
        return float(np.rad2deg(size)), "deg"
    return size * units.unit(kind), "" if kind is Kind.NUMBER else units.name(kind)


@dataclass(frozen=True, eq=False, kw_only=True)
class Alternative:
    """A rod, transducer or stage that is other than it was given.

    Attributes
    ----------
    name : str
        Of the property that is larger.
    step : float
        By how much it is larger.
    corrected : callable
        Maps samples to what they would have been without that error of transducer or stage.
    branch : Branch, ObliqueStage or None
        Of the rod that has the property; None where it is the same rod.
    """

    name: str
    step: float
    corrected: Callable[[Samples], Samples] = lambda samples: samples
    branch: Placed | None = None

    def mirrored(self) -> "Alternative":
        """Give the same for the mirrored recording, see `Recording.mirrored`."""
        return replace(
            self,
            corrected=lambda samples: self.corrected(samples.mirrored()).mirrored(),
            branch=None if self.branch is None else self.branch.mirrored(),
        )


def _undone(one: Property, size: float) -> Callable[[Samples], Samples]:
    return lambda samples: one.recording(samples, size)


def alternative(
    name: str, size: float, whisker: Whisker, solved: Callable[[Whisker], Placed]
) -> Alternative:
    """Make the alternative of which a property is larger.

    Parameters
    ----------
    name : str
        One of `PROPERTIES`.
    size : float
        By how much it is larger.
    whisker : Whisker
        That was given.
    solved : callable
        Solves a whisker.

    Raises
    ------
    NoResponseError
        If the other rod has no response.
    """
    one = PROPERTIES[name]
    other = one.whisker(whisker, size)
    return Alternative(
        name=name,
        step=size,
        corrected=_undone(one, size),
        branch=None if other == whisker else solved(other),
    )


def of_readings() -> Iterator[Alternative]:
    """Make every property a little larger that does not change the rod."""
    for name, one in PROPERTIES.items():
        if name not in (*OF_ROD, *AS_MODULUS):
            yield Alternative(name=name, step=STEP, corrected=_undone(one, STEP))


def alternatives_to(whisker: Whisker, solved: Callable[[Whisker], Placed]) -> Iterator[Alternative]:
    """Make every property a little larger, one at a time.

    Parameters
    ----------
    whisker : Whisker
        That was given.
    solved : callable
        Solves a whisker; NoResponseError where it has no such response.

    Yields
    ------
    Alternative
    """
    given = solved(whisker)
    yield from of_readings()
    for name in OF_ROD:
        size = -STEP_IN_GAP * (1.0 - whisker.eta) if name == "eta" else STEP
        if name == "stage_angle" and isinstance(given, Branch):
            # Of an oblique stage the rod would be solved at many heights.
            continue
        try:
            found = alternative(name, size, whisker, solved)
        except NoResponseError:
            continue
        yield found
        if name == "eta" and isinstance(given, Branch) and isinstance(found.branch, Branch):
            yield _inclined(given, found.branch, size)


def _inclined(given: Branch, other: Branch, step: float) -> Alternative:
    """Incline a level stage so that it approaches the surface: the height falls along the scan.

    Parameters
    ----------
    given : Branch
        At the height that was given.
    other : Branch
        At a height that is larger by `step` (L).
    step : float
    """

    def corrected(samples: Samples) -> Samples:
        x0 = other.clip(given.clip(samples.x0))
        # The contact stays where it is, but the place from which displacements count moves.
        moved = (other.x1_init - given.x1_init) * given.slope(x0)
        per_height = (other(x0) - given(x0) + moved) / step
        return samples.without(-STEP * samples.clamp[:, None] * per_height)

    return Alternative(name="stage_angle", step=STEP, corrected=corrected)
