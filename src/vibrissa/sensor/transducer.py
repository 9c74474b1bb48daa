"""From clamp reactions to the readings of a force-torque transducer, in SI units.

The transducer sits under the clamp with its axis along the unbent rod. The model's force_x is its
Fx, force_y its Fz (along the axis) and moment_z its moment about the axis normal to the plane.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vibrissa.errors import ArgumentError
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.sensor.cards import is_card, read_card
from vibrissa.sensor.quantities import Units, channels_of, in_si

CHANNELS = ("force_x", "force_y", "moment_z")


@dataclass(frozen=True, kw_only=True)
class Transducer:
    """A transducer; triples are for force_x (N), force_y (N) and moment_z (N·m).

    Attributes
    ----------
    name, source : str
        What it is and where its values are published.
    limit : tuple of float
        Largest magnitude that it measures.
    resolution : tuple of float
        Step of its reading; 0 for none.
    noise : tuple of float
        Standard deviation of the normal noise of one reading.
    drift : tuple of float
        Standard deviation of the change of its zero from one reading to the next.
    crosstalk : float
        Part of the other channels' reactions, relative to full scale, that each channel shows too.
    """

    name: str
    source: str
    limit: tuple[float, float, float]
    resolution: tuple[float, float, float]
    noise: tuple[float, float, float]
    drift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    crosstalk: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what no transducer has."""
        for name in ("limit", "resolution", "noise", "drift"):
            values = getattr(self, name)
            if not (np.all(np.asarray(values) >= 0.0) and np.all(np.isfinite(values))):
                raise ArgumentError(f"{name} of a transducer must not be negative, got {values!r}")
        if not (min(self.limit) > 0.0 and abs(self.crosstalk) < 1.0):
            raise ArgumentError("a transducer has a limit above 0 and a crosstalk below 1")

    def measured(self, reactions: FloatArray, generator: np.random.Generator) -> FloatArray:
        """Simulate the readings of a series of clamp reactions.

        Parameters
        ----------
        reactions : ndarray, shape (n, 3)
            In SI units.
        generator : numpy.random.Generator
            For the noise.

        Returns
        -------
        ndarray, shape (n, 3)
            Clipped to the limits and rounded to the resolution.
        """
        limit, step = np.array(self.limit), np.array(self.resolution)
        relative = reactions / limit
        others = relative.sum(axis=1, keepdims=True) - relative
        reading = reactions + self.crosstalk * others * limit
        walk = generator.standard_normal(reactions.shape) * self.drift
        reading += np.cumsum(walk, axis=0) + generator.standard_normal(reactions.shape) * self.noise
        reading = np.clip(reading, -limit, limit)
        counts = np.round(reading / np.where(step > 0.0, step, 1.0))
        return np.where(step > 0.0, counts * step, reading)

    def saturated(self, readings: FloatArray) -> BoolArray:
        """Whether each reading is at a limit, to within its resolution."""
        return np.asarray(np.abs(readings) >= np.array(self.limit) - self.resolution)

    @property
    def deviation(self) -> tuple[float, float, float]:
        """Standard deviation of a reading: noise, and rounding, uniform within a step."""
        x, y, z = np.sqrt(np.square(self.noise) + np.square(self.resolution) / 12.0).tolist()
        return x, y, z


_NANO17 = (1.0 / 320.0, 1.0 / 320.0, 1e-3 / 64.0)
_AXIA80 = (0.1, 0.1, 1.0 / 200.0)
_HEX_E = (0.2, 0.8, 0.01)
# Where a sheet has no noise, one step of the resolution is taken, which is what manufacturers call
# resolvable. A Mini40 at rest had 1.2 to 2.2 steps.
PRESETS = {
    "nano17-si-12-0.12": Transducer(
        name="ATI Nano17 SI-12-0.12",
        source="ATI Industrial Automation, product page of the Nano17, calibration SI-12-0.12: "
        "Fx, Fy 12 N, Fz 17 N (12 N is taken), moments 120 N*mm; resolution 1/320 N and 1/64 N*mm",
        limit=(12.0, 12.0, 0.12),
        resolution=_NANO17,
        noise=_NANO17,
    ),
    "mini40-si-40-2": Transducer(
        name="ATI Mini40 SI-40-2",
        source="ATI Industrial Automation, product page of the Mini40, calibration SI-40-2, Net "
        "or DAQ: Fx, Fy 40 N, Fz 120 N, moments 2 N*m; resolution 1/100, 1/50 N and 1/4000 N*m. "
        "Noise: measured by a laboratory on one of them at rest, 0.015 and 0.03 N, 0.0005 N*m",
        limit=(40.0, 120.0, 2.0),
        resolution=(0.01, 0.02, 1.0 / 4000.0),
        noise=(0.015, 0.03, 0.0005),
    ),
    "axia80-si-200-8": Transducer(
        name="ATI Axia80-M20 SI-200-8",
        source="ATI Industrial Automation, product page of the Axia80-M20, calibration SI-200-8: "
        "Fx, Fy 200 N, Fz 360 N, moments 8 N*m; resolution 1/10 N and 1/200 N*m",
        limit=(200.0, 360.0, 8.0),
        resolution=_AXIA80,
        noise=_AXIA80,
    ),
    "onrobot-hex-e": Transducer(
        name="OnRobot HEX-E QC",
        source="OnRobot, data sheet HEX-E/H QC, v1.5: 200 N, Tx and Ty 10 N*m; noise-free "
        "resolution 0.2 N in Fx and Fy, 0.8 N in Fz, 0.010 N*m",
        limit=(200.0, 200.0, 10.0),
        resolution=_HEX_E,
        noise=_HEX_E,
    ),
}


def transducer_of(given: Transducer | str | None, units: Units) -> Transducer | None:
    """Look up a transducer. It reads forces in N, so that the rod has to be known."""
    if given is not None and units.nondimensional:
        raise ArgumentError("a transducer needs the rod: give modulus, diameter and length")
    return preset(given) if isinstance(given, str) else given


def preset(name: str) -> Transducer:
    """Look up a preset by its name, or read a file of one's own: ``"my.toml"``.

    Parameters
    ----------
    name : str
        Of a preset, or of a file that ends with ``.toml``.

    Returns
    -------
    Transducer

    Raises
    ------
    ArgumentError
        If there is none.
    """
    if is_card(name):
        return _read(Path(name))
    if name.lower() not in PRESETS:
        raise ArgumentError(
            f"transducer must be one of {', '.join(PRESETS)}, or a file .toml, got {name!r}"
        )
    return PRESETS[name.lower()]


def _read(path: Path) -> Transducer:
    """Read a transducer from a file; without a noise it is one step of the resolution."""
    card = read_card(path, ("limit", "resolution"), ("name", "source", "noise"))

    def channels(key: str) -> tuple[float, float, float]:
        parts = channels_of(card[key], f"{path}: {key}")
        x, y, z = (float(in_si(text.strip(), kind, f"{path}: {key}")) for text, kind in parts)
        return x, y, z

    resolution = channels("resolution")
    return Transducer(
        name=card.get("name", path.stem),
        source=card.get("source", str(path)),
        limit=channels("limit"),
        resolution=resolution,
        noise=channels("noise") if "noise" in card else resolution,
    )
