"""What is adjusted to a recording, and by how much: tolerances stated and assumed."""

import numpy as np

from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.given.tolerances import TOLERABLE, assumed_tolerances
from vibrissa.sensor.identification.adjusting.adjustment import Prior
from vibrissa.sensor.identification.reading.slope import NAME as SLOPE
from vibrissa.sensor.identification.recording import Recording
from vibrissa.sensor.whisker import Whisker

# Channels without which a tolerance changes nothing that was recorded.
NEEDS = {"moment_origin_x": 2, "moment_origin_y": 2}


def prior_of(whisker: Whisker, recording: Recording, noise: FloatArray, assume: bool) -> Prior:
    """Put together what is adjusted.

    Parameters
    ----------
    whisker : Whisker
        With the tolerances that were stated.
    recording : Recording
    noise : ndarray, shape (3,)
        Standard deviation of one reading.
    assume : bool
        Whether what nothing is stated about has the tolerance that is assumed for it.
    """
    assumed = assumed_tolerances(whisker.units, noise) if assume else {}
    sizes = {**assumed, **whisker.tolerances}
    # No reading tells it: it widens what was read.
    sizes.pop(SLOPE, None)
    there = [bool(np.isfinite(column).all()) for column in recording.readings.T]

    def matters(name: str) -> bool:
        channel = NEEDS.get(name, TOLERABLE[name].channel)
        return channel < 0 or there[channel]

    return Prior(
        tolerances={name: size for name, size in sizes.items() if size > 0.0 and matters(name)},
        stated=frozenset(whisker.tolerances),
    )
