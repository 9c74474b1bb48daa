"""Bounds on how a rod is made, which the study file and the solver share."""

from collections.abc import Sequence

import numpy as np

from vibrissa.errors import ArgumentError

# Largest number of coefficients of a stiffening.
MOST_POWERS = 8
# Coefficients up to this size are left out where the least stiffness is sought.
TINY = 1e-17


def check_stiffening(powers: Sequence[float]) -> None:
    """Refuse coefficients of s, s², … for which 1 + c1·s + c2·s² + … is not positive on the rod.

    Raises
    ------
    ArgumentError
        With the place on the rod, 0 ≤ s ≤ 1, where the stiffness is least.

    Examples
    --------
    >>> check_stiffening([0.5, -0.2])
    """
    if len(powers) > MOST_POWERS:
        raise ArgumentError(
            f"stiffening must have at most {MOST_POWERS} coefficients, got {len(powers)}"
        )
    # Coefficients that cannot change the stiffness by rounding would spoil the roots.
    stiffness = np.polynomial.Polynomial([1.0, *powers]).trim(TINY)
    turns = stiffness.deriv().roots()
    inside = turns.real[(np.abs(turns.imag) < 1e-6) & (turns.real > 0.0) & (turns.real < 1.0)]
    places = np.append(inside, 1.0)
    values = stiffness(places)
    least = int(values.argmin())
    if not values[least] > 0.0:
        raise ArgumentError(
            "stiffening must leave the stiffness positive on the whole rod: 1 + c1*s + c2*s^2 + "
            f"... is {values[least]:.4g} at s = {places[least]:.4g} L, got "
            f"{', '.join(f'{power:g}' for power in powers)}"
        )


def check_bore(bore: float, theta: float) -> None:
    """Refuse a bore that is not narrower than the tip: the rod would have no wall there.

    Parameters
    ----------
    bore : float
        Diameter of the bore (d0).

    Raises
    ------
    ArgumentError
    """
    if not 0.0 <= bore * theta < 1.0:
        raise ArgumentError(
            "bore must be at least 0 and below the diameter of the tip, 1/theta = "
            f"{1.0 / theta:.4g} d0, got {bore!r}"
        )
