"""Slips that lock to a texture: after how many slips and waves their places repeat."""

from typing import NamedTuple

import numpy as np

from vibrissa.numerics.arrays import FloatArray

# Largest number of slips after which places may repeat, and how well they do (wavelengths).
MOST_SLIPS, REPEATED = 6, 0.03
# Fewest distances that are compared.
COMPARED = 3


class Locking(NamedTuple):
    """Slips whose places repeat: after a number of slips, which pass a number of waves."""

    slips: int
    waves: int


def locking_of(places: FloatArray, wavelength: float) -> Locking | None:
    """Return the least number of slips after which places repeat on waves; None without any.

    Parameters
    ----------
    places : ndarray, shape (n,)
        Places at which the tip rests after its slips, in their order (L), without the first ones,
        which depend on where the scan starts.
    wavelength : float
        Wavelength along the scan (L).

    Examples
    --------
    >>> print(locking_of(np.array([0.0, 0.4, 1.0, 1.4, 2.0, 2.4]), 1.0))
    Locking(slips=2, waves=1)
    """
    for slips in range(1, MOST_SLIPS + 1):
        ways = (places[slips:] - places[:-slips]) / wavelength
        if len(ways) < COMPARED:
            return None
        waves = round(float(ways.mean()))
        if waves and np.abs(ways - waves).max() < REPEATED:
            return Locking(slips=slips, waves=waves)
    return None
