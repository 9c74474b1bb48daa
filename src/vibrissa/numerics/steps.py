"""The step grid: footpoint displacements that are whole multiples of an exact Δx0."""

from decimal import Decimal
from fractions import Fraction

import numpy as np

from vibrissa.errors import ArgumentError
from vibrissa.numerics.arrays import FloatArray, IntArray

# Integers up to here are exact in a double.
EXACT_INTEGER = 2**53


def step_position(step: IntArray, dx0: Decimal) -> FloatArray:
    """Footpoint displacement step·Δx0, rounded once.

    Parameters
    ----------
    step : ndarray of int
        Numbers of steps.
    dx0 : Decimal
        Step size, in units of L.

    Returns
    -------
    ndarray
        The double nearest to the exact product, as in 3·0.1 = 0.3.
    """
    numerator, denominator = Fraction(dx0).as_integer_ratio()
    step = np.asarray(step, dtype=np.int64)
    largest = int(np.abs(step).max(initial=0)) * numerator
    if max(largest, numerator, denominator) <= EXACT_INTEGER:
        return step * numerator / denominator  # both exact, so the division rounds once
    return np.array([int(k) * numerator / denominator for k in step.ravel()]).reshape(step.shape)


def last_step_within(x0: FloatArray, dx0: Decimal) -> IntArray:
    """Largest number of steps whose displacement does not exceed `x0`.

    Parameters
    ----------
    x0 : ndarray
        Displacements, not negative, in units of L.
    dx0 : Decimal
        Step size, in units of L.

    Returns
    -------
    ndarray of int

    Raises
    ------
    ArgumentError
        If there are more steps than a double can count.

    Notes
    -----
    floor(x0/Δx0) in floating point is wrong where x0 is a multiple of Δx0: 0.3/0.1 falls just
    short of 3. Comparing the correctly rounded positions themselves is not.
    """
    x0 = np.asarray(x0, dtype=float)
    if np.any(x0 > EXACT_INTEGER * float(dx0)):
        raise ArgumentError(f"dx0 = {dx0} is too small a step for displacements up to {x0.max():g}")
    step = np.floor(x0 / float(dx0)).astype(np.int64)
    step += step_position(step + 1, dx0) <= x0
    step -= step_position(step, dx0) > x0
    return step
