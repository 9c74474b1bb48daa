"""Parameters of the forward model: deviations from the given set-up, where all of them are 0."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import permutations
from typing import NamedTuple, Self

import numpy as np

from vibrissa.mechanics.taper import MOST_TAPER, modulus
from vibrissa.numerics.arrays import FloatArray, IntArray
from vibrissa.scanning.response_over_eta import FARTHEST, NEAREST
from vibrissa.scanning.rods import MountedRod
from vibrissa.sensor.tolerances import TOLERABLE
from vibrissa.sensor.transducer import CHANNELS
from vibrissa.sensor.whisker import Whisker

# Parameters whose change needs another rod solved.
OF_ROD = ("theta", "clamp_angle", "clamp_compliance", "curvature", "stiffening")
# Parameters of the mounting.
OF_MOUNTING = (*OF_ROD[1:], "stage_angle")
CREEP = "creep"
SLOPE = "surface_slope"
# Quantities that change the measured ratio of the forces. An inclination of the surface against the
# transducer has the same effect as a turn of the transducer.
BEARING = (
    "zero_force_x",
    "zero_force_y",
    "drift_force_x",
    "drift_force_y",
    "transducer_angle",
    "crosstalk",
)
# If the recording refutes one of these quantities, the ratio of the forces is in doubt: a stage at
# an angle to the surface may be a surface at an angle to the transducer.
REFUTE_RATIO = (*BEARING, "stage_angle", SLOPE)
# Numbers of the channels without which a parameter has no effect on the recording.
NEEDED_CHANNEL = {"moment_origin_x": 2, "moment_origin_y": 2}
# Step of a difference quotient, in units of the parameter.
PARAMETER_STEP = 1e-4
# Step for the height, as a part of the gap between the surface and an upright rod.
STEP_IN_GAP = 1e-3
# Largest values that are tried for a set-up: angle (rad), curvature (1/L), radius of the tip (L).
MOST_ANGLE = 0.25 * np.pi
MOST_CURVED = 5.0
ROUNDEST = 0.02
# Least part of a given size or scale that is tried.
LEAST_SCALE = 0.1
# Largest part of the modulus that is taken away, and of the tip that is bored.
LEAST_WALL = 0.95
# Places along the rod at which the modulus is compared (L).
MODULUS_PLACES = np.linspace(0.01, 1.0, 100)
# Number of half waves of a drift. All further half waves have 0.11 of the line's deviation.
DRIFT_WAVES = 8
# Matrices that, times the loads, are the change of the readings per unit of a parameter: E, d0⁴,
# axes turned from x to y, and the moment about a point (a, b), which is smaller by a·fy − b·fx.
MIXING = {
    "modulus": np.eye(3),
    "diameter": 4.0 * np.eye(3),
    "transducer_angle": np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]),
    "moment_origin_x": np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, -1.0, 0.0]]),
    "moment_origin_y": np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]),
}


class ScanRows(NamedTuple):
    """Rows of a scan, for errors that change from the first to the last of them.

    Attributes
    ----------
    part : ndarray, shape (..., 1)
        Part of the scan before each row, from 0 in the first to 1 in the last.
    last : int
        Index of the last row.
    """

    part: FloatArray
    last: int

    @classmethod
    def of(cls, row: FloatArray | IntArray, count: int) -> Self:
        """Take the rows with these indices, shape (n,), of a scan of `count` rows."""
        last = max(count - 1, 1)  # it is a divisor
        return cls(part=row[:, None] / last, last=last)


# Change of the readings per unit of a parameter, shape (..., 3), as a function of the loads, shape
# (..., 3), and of their rows.
Effect = Callable[[FloatArray, ScanRows], FloatArray]


@dataclass(frozen=True, eq=False, kw_only=True)
class Parameter:
    """A parameter of the forward model: one deviation from the given set-up.

    Attributes
    ----------
    of : str
        Name in `TOLERABLE` of the quantity that deviates. Crosstalk and drifts have several
        parameters each.
    deviation : float
        Standard deviation of the prior, set by the tolerance: in units of the rod, in rad, or
        relative; 0 if exact.
    effect : callable, optional
        Function `Effect`: change of the readings per unit of the parameter, at the same loads.
        None if the parameter changes the loads.
    wave : int
        Number of half waves of a drift over the recording; 0 for other parameters.
    low, high : float
        Least and largest value.
    step : float
        Step of the difference quotient of a parameter that changes the loads.
    """

    name: str
    of: str
    deviation: float
    stated: bool = True
    effect: Effect | None = None
    wave: int = 0
    low: float = -np.inf
    high: float = np.inf
    step: float = PARAMETER_STEP

    @property
    def of_zero(self) -> bool:
        """Whether the parameter changes the zero of a channel, whatever the loads are."""
        return TOLERABLE[self.of].channel >= 0


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """Range of a parameter, and the step of its difference quotient; see `Parameter`."""

    low: float = -np.inf
    high: float = np.inf
    step: float = PARAMETER_STEP


def ranges_of(rod: MountedRod | None) -> dict[str, Bounds]:
    """Return the ranges of parameters whose values are bounded, by the quantity that deviates.

    Without a rod, only parameters of the transducer are used, and no value is fitted.
    """
    if rod is None:
        return {}
    mounting = rod.mounting
    scale = Bounds(low=LEAST_SCALE - 1.0)
    # The tip of a tube is thicker than its bore.
    thinnest = min(MOST_TAPER, LEAST_WALL / mounting.bore) if mounting.bore else MOST_TAPER
    # The modulus stays positive: its change c1·s may take a part of it away.
    least = np.min(modulus(MODULUS_PLACES, mounting.making) / MODULUS_PLACES)
    return {
        "theta": Bounds(low=1.0 - rod.theta, high=thinnest - rod.theta),
        # Downwards, as forces are singular where the rod is upright.
        "eta": Bounds(
            low=NEAREST - rod.eta,
            high=FARTHEST - rod.eta,
            step=-STEP_IN_GAP * (1.0 - rod.eta),
        ),
        "clamp_angle": Bounds(
            low=-MOST_ANGLE - mounting.clamp_angle, high=MOST_ANGLE - mounting.clamp_angle
        ),
        "stage_angle": Bounds(
            low=-MOST_ANGLE - mounting.stage_angle, high=MOST_ANGLE - mounting.stage_angle
        ),
        "clamp_compliance": Bounds(low=-mounting.clamp_compliance),
        # A rod that lies on the surface has no neighbour that is curved towards the surface.
        "curvature": Bounds(low=-MOST_CURVED, high=MOST_CURVED, step=-PARAMETER_STEP),
        "stiffening": Bounds(low=-LEAST_WALL * float(least)),
        "tip_radius": Bounds(low=0.0, high=min(ROUNDEST, rod.eta - NEAREST)),
        "transducer_angle": Bounds(low=-MOST_ANGLE, high=MOST_ANGLE),
        "modulus": scale,
        "diameter": scale,
        "length": scale,
        "stage_scale": scale,
    }


def parameters_of(
    sizes: Mapping[str, float],
    stated: frozenset[str],
    full_scale: FloatArray,
    whisker: Whisker | None = None,
) -> tuple[Parameter, ...]:
    """Make the parameters of all quantities that can have a tolerance, also if they are exact.

    Parameters
    ----------
    whisker : Whisker, optional
        The given set-up, from which the parameters deviate.
    full_scale : ndarray, shape (3,)
        Full scale of the channels, for crosstalk; NaN for a channel that was not recorded.
    """
    there = np.isfinite(full_scale)
    ranges = ranges_of(whisker)
    unbounded = Bounds()
    channels = {
        name: NEEDED_CHANNEL.get(name, quantity.channel) for name, quantity in TOLERABLE.items()
    }
    each = (
        Parameter(
            name=name,
            of=name,
            deviation=sizes.get(name, 0.0),
            stated=name in stated,
            **vars(ranges.get(name, unbounded)),
        )
        for name, channel in channels.items()
        if name != SLOPE and (channel < 0 or there[channel])
    )
    scale = np.where(there, full_scale, 1.0)
    return tuple(part for parameter in each for part in _parts(parameter, scale))


def _parts(parameter: Parameter, full_scale: FloatArray) -> Iterator[Parameter]:
    """Split a parameter: crosstalk into six, a (Brownian) drift into a line and half waves."""
    channel = TOLERABLE[parameter.of].channel
    if parameter.of == "crosstalk":
        for to, source in permutations(range(3), 2):
            matrix = np.zeros((3, 3))
            matrix[to, source] = full_scale[to] / full_scale[source]
            name = f"crosstalk of {CHANNELS[source]} in {CHANNELS[to]}"
            yield replace(parameter, name=name, effect=_mixed(matrix))
    elif parameter.of.startswith("drift_"):
        yield replace(parameter, effect=_zero(channel, np.asarray))
        for wave in range(1, DRIFT_WAVES + 1):
            name = f"{parameter.of}, wave {wave}"
            part = np.sqrt(2.0) / (np.pi * wave)
            effect = _zero(channel, _half_waves(wave))
            yield replace(
                parameter, name=name, deviation=part * parameter.deviation, effect=effect, wave=wave
            )
    elif channel >= 0:
        yield replace(parameter, effect=_zero(channel, np.ones_like))
    elif parameter.of == CREEP:
        yield replace(parameter, effect=_creeping)
    elif parameter.of in MIXING:
        yield replace(parameter, effect=_mixed(MIXING[parameter.of]))
    else:
        yield parameter


def _mixed(matrix: FloatArray) -> Effect:
    """Effect that adds a matrix times the loads to the readings."""
    return lambda loads, rows: loads @ matrix.T


def _zero(channel: int, shape: Callable[[FloatArray], FloatArray]) -> Effect:
    """Effect of a zero that follows `shape` over the recording."""
    return lambda loads, rows: shape(rows.part) * np.eye(3)[channel]


def _half_waves(number: int) -> Callable[[FloatArray], FloatArray]:
    return lambda part: np.sin(np.pi * number * part)


def _creeping(loads: FloatArray, rows: ScanRows) -> FloatArray:
    return np.asarray(-loads * np.log10(1.0 + rows.part * rows.last))
