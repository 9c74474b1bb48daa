"""From clamp reactions to the readings of a force-torque transducer, in SI units.

force_x is its Fx, force_y its Fz (along the unbent rod), moment_z that about the plane's normal.
"""

import tomllib
from collections.abc import Mapping
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
    """A force-torque transducer; triples are force_x (N), force_y (N), moment_z (N·m).

    Attributes
    ----------
    name, source : str
        Description, and the source of the values.
    limit : tuple of float
        Largest magnitude that it measures.
    resolution : tuple of float
        Step of its reading; 0 for none.
    noise : tuple of float
        Standard deviation of the normal noise of one reading.
    """

    name: str
    source: str
    limit: tuple[float, float, float]
    resolution: tuple[float, float, float]
    noise: tuple[float, float, float]

    def __post_init__(self) -> None:
        """Refuse values that no transducer has."""
        for name in ("limit", "resolution", "noise"):
            values = getattr(self, name)
            if not (np.all(np.asarray(values) >= 0.0) and np.all(np.isfinite(values))):
                raise ArgumentError(f"{name} of a transducer must not be negative, got {values!r}")
        if not min(self.limit) > 0.0:
            raise ArgumentError(f"limit of a transducer must be positive, got {self.limit!r}")

    def measured(self, reactions: FloatArray, generator: np.random.Generator) -> FloatArray:
        """Simulate the readings of a series of clamp reactions.

        Parameters
        ----------
        reactions : ndarray, shape (n, 3)
            In SI units.

        Returns
        -------
        ndarray, shape (n, 3)
            Clipped to the limits and rounded to the resolution.
        """
        limit, step = np.array(self.limit), np.array(self.resolution)
        # Half of the draws is left out: a seed gives the readings that it always gave.
        reading = reactions + generator.standard_normal((2, *reactions.shape))[1] * self.noise
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


def transducer_of(given: Transducer | str, units: Units) -> Transducer:
    """Look up a transducer. It reads forces in N, so that the rod has to be known."""
    if units.nondimensional:
        raise ArgumentError("with a transducer, give modulus, diameter and length of the rod")
    return preset(given) if isinstance(given, str) else given


def preset(name: str) -> Transducer:
    """Return a transducer by the name of a preset or the path of a file.

    Parameters
    ----------
    name : str
        Name of a preset, or path of a TOML file.

    Returns
    -------
    Transducer

    Raises
    ------
    ArgumentError
        If there is no such preset or file.
    """
    if is_card(name):
        path = Path(name)
        keys = ("limit", "resolution"), ("name", "source", "noise")
        return _of_card(read_card(path, *keys), path.stem, name)
    if name.lower() not in PRESETS:
        raise ArgumentError(
            f"transducer must be one of {', '.join(PRESETS)}, or a file .toml, got {name!r}"
        )
    return PRESETS[name.lower()]


def _of_card(card: Mapping[str, str], name: str, where: str) -> Transducer:
    """Read a transducer from texts; without a noise it is one step of the resolution."""

    def channels(key: str) -> tuple[float, float, float]:
        parts = channels_of(card[key], f"{where}: {key}")
        x, y, z = (float(in_si(text.strip(), kind, f"{where}: {key}")) for text, kind in parts)
        return x, y, z

    return Transducer(
        name=card.get("name", name),
        source=card.get("source", where),
        limit=channels("limit"),
        resolution=channels("resolution"),
        noise=channels("noise" if "noise" in card else "resolution"),
    )


_FILE = Path(__file__).with_name("transducers.toml")
PRESETS = {
    name: _of_card(card, name, _FILE.name)
    for name, card in tomllib.loads(_FILE.read_text(encoding="utf-8")).items()
}
