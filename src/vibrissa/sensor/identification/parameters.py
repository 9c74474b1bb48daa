"""Parameters of the forward model: deviations from the given set-up, 0 as given."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import permutations

import numpy as np

from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.tolerances import TOLERABLE
from vibrissa.sensor.transducer import CHANNELS

# Those that need another rod solved.
OF_ROD = ("theta", "clamp_angle", "clamp_compliance", "curvature")
CREEP, SLOPE = "creep", "surface_slope"
# What changes the ratio of the forces that are read. A surface that is inclined against the
# transducer is a transducer that is turned.
BEARING = (
    "zero_force_x",
    "zero_force_y",
    "drift_force_x",
    "drift_force_y",
    "transducer_angle",
    "crosstalk",
)
# Channels without which a parameter changes nothing that was recorded.
NEEDS = {"moment_origin_x": 2, "moment_origin_y": 2}
# Waves of a drift. What is left out has a deviation of 0.11 of that of the line.
WAVES = 8
# By which part of the loads each channel is larger per unit of a parameter, shape (3, 3): E, d0⁴,
# axes that are turned from x to y, and the moment about a point (a, b), a·fy − b·fx less.
MIXING = {
    "modulus": np.eye(3),
    "diameter": 4.0 * np.eye(3),
    "transducer_angle": np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]),
    "moment_origin_x": np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, -1.0, 0.0]]),
    "moment_origin_y": np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]),
}


@dataclass(frozen=True, eq=False, kw_only=True)
class Parameter:
    """One deviation from the given set-up.

    Attributes
    ----------
    deviation : float
        Standard deviation of its prior, in units of the rod, rad, or relative; 0 if it is exact.
    mixing : ndarray, shape (3, 3), or None
        Part of the loads that the readings show, too.
    drift : bool
        Whether the zero changes over the recording: in a line, or in a wave about it.
    wave : int
        Number of the half waves of a drift; 0 for all else.
    """

    name: str
    of: str
    deviation: float
    stated: bool = True
    mixing: FloatArray | None = None
    channel: int = -1
    drift: bool = False
    wave: int = 0

    @property
    def of_readings(self) -> bool:
        """Whether it changes the readings of the same loads."""
        return self.mixing is not None or self.channel >= 0 or self.of == CREEP

    def zero(self, part: FloatArray) -> FloatArray:
        """Shape of a zero over the recording, of which `part` runs from 0 to 1."""
        if self.wave:
            return np.asarray(np.sin(np.pi * self.wave * part))
        return part if self.drift else np.ones_like(part)


def parameters_of(
    sizes: Mapping[str, float], stated: frozenset[str], full_scale: FloatArray
) -> tuple[Parameter, ...]:
    """Make the parameters of all tolerances, exact quantities included.

    Parameters
    ----------
    full_scale : ndarray, shape (3,)
        Of the channels, of which crosstalk is a part; NaN for one that was not recorded.
    """
    there = np.isfinite(full_scale)
    found: list[Parameter] = []
    for name, one in TOLERABLE.items():
        channel = NEEDS.get(name, one.channel)
        if name == SLOPE or (channel >= 0 and not there[channel]):
            continue
        found += _parts(
            name, sizes.get(name, 0.0), name in stated, np.where(there, full_scale, 1.0)
        )
    return tuple(found)


def _parts(name: str, size: float, stated: bool, full_scale: FloatArray) -> Iterator[Parameter]:
    """Parameters of one tolerance: crosstalk has six, and a drift is a Wiener process."""
    channel = TOLERABLE[name].channel
    if name == "crosstalk":
        for to, source in permutations(range(3), 2):
            mixing = np.zeros((3, 3))
            mixing[to, source] = full_scale[to] / full_scale[source]
            text = f"crosstalk of {CHANNELS[source]} in {CHANNELS[to]}"
            yield Parameter(name=text, of=name, deviation=size, stated=stated, mixing=mixing)
    elif name.startswith("drift_"):
        for wave in range(WAVES + 1):
            yield Parameter(
                name=f"{name}, wave {wave}" if wave else name,
                of=name,
                deviation=size * np.sqrt(2.0) / (np.pi * wave) if wave else size,
                stated=stated,
                channel=channel,
                drift=True,
                wave=wave,
            )
    else:
        mixing_of = MIXING.get(name)
        yield Parameter(
            name=name, of=name, deviation=size, stated=stated, mixing=mixing_of, channel=channel
        )
