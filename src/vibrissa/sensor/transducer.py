"""Force-torque transducers: from clamp reactions to readings, in SI units.

force_x is the transducer's Fx, force_y its Fz (along the unbent rod), moment_z its moment about the
normal of the plane of bending.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, ValidationInfo, model_validator

from vibrissa.errors import ArgumentError
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.quantities.keys import Card, NotNegative, Positive, Presets
from vibrissa.quantities.units import Units, channels_in_si

CHANNELS = ("force_x", "force_y", "moment_z")
Sizes = tuple[NotNegative, NotNegative, NotNegative]


def _in_si(text: Any, info: ValidationInfo) -> Any:
    return channels_in_si(text, str(info.field_name)) if isinstance(text, str) else text


class Transducer(Card):
    """A force-torque transducer.

    Each attribute below has three values: for force_x (N), force_y (N) and moment_z (N·m).

    Attributes
    ----------
    limit : tuple of float
        Largest magnitude of a reading.
    resolution : tuple of float
        Step of a reading; 0 if readings are not rounded.
    noise : tuple of float
        Standard deviation of the normal noise of one reading; by default one step.
    """

    limit: Annotated[tuple[Positive, Positive, Positive], BeforeValidator(_in_si)]
    resolution: Annotated[Sizes, BeforeValidator(_in_si)]
    noise: Annotated[Sizes, BeforeValidator(_in_si)]

    @model_validator(mode="before")
    @classmethod
    def _default_noise(cls, given: Mapping[str, Any]) -> Mapping[str, Any]:
        return {"noise": given.get("resolution", ""), **given}

    def measured(self, reactions: FloatArray, generator: np.random.Generator) -> FloatArray:
        """Simulate the readings of a series of clamp reactions.

        Parameters
        ----------
        reactions : ndarray, shape (n, 3)
            Columns force_x, force_y and moment_z of the clamp reactions, in SI units.
        generator : numpy.random.Generator
            Source of the noise.

        Returns
        -------
        ndarray, shape (n, 3)
            Readings in SI units with noise, clipped to the limits and rounded to the resolution.
        """
        limit, step = np.array(self.limit), np.array(self.resolution)
        reading = reactions + generator.standard_normal(reactions.shape) * self.noise
        reading = np.clip(reading, -limit, limit)
        counts = np.round(reading / np.where(step > 0.0, step, 1.0))
        return np.where(step > 0.0, counts * step, reading)

    def saturated(self, readings: FloatArray) -> BoolArray:
        """Whether each reading is at a limit of its channel, to within one step of resolution."""
        return np.asarray(np.abs(readings) >= np.array(self.limit) - self.resolution)

    @property
    def deviation(self) -> FloatArray:
        """Standard deviation of a reading: noise, and rounding to the resolution, shape (3,)."""
        return np.asarray(np.sqrt(np.square(self.noise) + np.square(self.resolution) / 12.0))


def transducer_of(transducer: Transducer | str, units: Units) -> Transducer:
    """Return the transducer, or the one that a text names; refuse nondimensional units."""
    if units.nondimensional:
        raise ArgumentError("with a transducer, give modulus, diameter and length of the rod")
    return preset(transducer) if isinstance(transducer, str) else transducer


PRESETS = Presets(Transducer, Path(__file__).with_name("transducers.toml"))


def preset(name: str) -> Transducer:
    """Return a transducer by its name.

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
    return Transducer.named(name, PRESETS)
