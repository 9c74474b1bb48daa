"""Slips that lock to a texture: after how many slips and waves their places repeat."""

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from vibrissa.errors import ArgumentError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.scanning.response import States

# Largest number of slips after which places may repeat, and how well they do (wavelengths).
MOST_SLIPS, SAME_PLACE = 6, 0.03
# Fewest distances that are compared.
FEWEST_DISTANCES = 3
# Part of a scan that is left out, as its first slips depend on where it starts.
TRANSIENT_PART = 0.3
# Number of displacements at which a mobilised friction is sought.
BRACKETING_DISPLACEMENTS = 257


class Locking(NamedTuple):
    """Slips whose places repeat: after a number of slips, which pass a number of waves."""

    slips: int
    waves: int


def settled_rests(clamp: FloatArray, places: FloatArray) -> FloatArray:
    """Return the places at which the tip rests, without those in the first part of a scan.

    Parameters
    ----------
    clamp, places : ndarray, shape (n,)
        Position of the clamp in each slip, and place at which the tip rests after it, in the order
        of the slips; empty without slips (L).

    Returns
    -------
    ndarray
        Places after the slips with the clamp beyond `TRANSIENT_PART` times its last position.

    Examples
    --------
    >>> print(settled_rests(np.array([0.1, 0.3, 0.5]), np.array([0.5, 0.7, 0.9])))
    [0.7 0.9]
    """
    return places[clamp > TRANSIENT_PART * clamp.max(initial=0.0)]


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
        distances = (places[slips:] - places[:-slips]) / wavelength
        if len(distances) < FEWEST_DISTANCES:
            return None
        waves = round(float(distances.mean()))
        if waves and np.abs(distances - waves).max() < SAME_PLACE:
            return Locking(slips=slips, waves=waves)
    return None


def travel_on_slope(states: States, mu0: float, slope: float, mu_rest: float = 0.0) -> float:
    """Travel of the clamp between slips after which the tip rests on the same slope again (L).

    One slip for each wave is possible if the travel on one of its slopes is the wavelength.

    Parameters
    ----------
    states : States
        States of the rod at its distance from the places of rest.
    slope : float
        Slope h' of the surface there.
    mu_rest : float
        |T/N| at which a slip ends: 0 by the law ``free``, κ·μ0 by ``kinetic``.

    Raises
    ------
    ArgumentError
        If the tip is self-locking on this slope, or the rod has no state in which the slip ends.

    Examples
    --------
    >>> from vibrissa.scanning.response import responses
    >>> from vibrissa.scanning.rods import MountedRod
    >>> (response,) = responses([MountedRod(theta=2.0, eta=0.85)])
    >>> print(f"{travel_on_slope(response, 0.3, 0.0):.6f}")
    0.026336
    >>> print(f"{travel_on_slope(response, 0.3, -0.04):.6f}")
    0.021428
    """

    def reached(mu: float) -> float:
        wanted = np.tan(np.arctan(mu) + np.arctan(slope))
        # At the end of pulling the normal force may vanish.
        x0 = np.linspace(float(states.x0_pull), float(states.x0_lock), BRACKETING_DISPLACEMENTS)
        below = states.demand(x0) < wanted
        rises = np.flatnonzero(below[:-1] & ~below[1:])
        if not len(rises):
            raise ArgumentError(
                f"on a slope of {slope:g} the rod has no state with |T/N| = {mu:g} before it locks"
            )
        between = x0[rises[-1] : rises[-1] + 2]
        return float(brentq(lambda at: float(states.demand(at)) - wanted, *between))

    return reached(mu0) - reached(mu_rest)
