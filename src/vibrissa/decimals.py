"""Exact decimals: a grid value is what the user wrote, not the binary number next to it."""

from decimal import Decimal
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from vibrissa.taper import FloatArray

# Integers up to here are exact in a double.
EXACT_INTEGER = 2**53


def exact(value: Decimal | float | int | str) -> Decimal:
    """Return the decimal number that a value was written as, in its shortest form.

    Parameters
    ----------
    value : Decimal, float, int or str
        A float stands for the shortest decimal that reads back as it.

    Returns
    -------
    Decimal
        Without trailing zeros, so that equal values have one spelling.

    Raises
    ------
    ValueError
        If the value is not a finite number.
    """
    try:
        number = Decimal(repr(value) if isinstance(value, float) else value)
    except ArithmeticError as error:
        raise ValueError(f"not a number: {value!r}") from error
    if not number.is_finite():
        raise ValueError(f"not a finite number: {value!r}")
    return number.normalize() + 0  # + 0 turns -0 into 0


def spell(value: Decimal) -> str:
    """Plain spelling without exponent, for names and tables: ``0.001``, never ``1E-3``."""
    return format(value, "f")


def step_position(step: NDArray[np.int64], dx0: Decimal) -> FloatArray:
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
    if max(largest, denominator) <= EXACT_INTEGER:
        return step * numerator / denominator  # both exact, so the division rounds once
    return np.array([int(k) * numerator / denominator for k in step.ravel()]).reshape(step.shape)


def last_step_within(x0: FloatArray, dx0: Decimal) -> NDArray[np.int64]:
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

    Notes
    -----
    floor(x0/Δx0) in floating point is wrong where x0 is a multiple of Δx0: 0.3/0.1 falls just
    short of 3. Comparing the correctly rounded positions themselves is not.
    """
    x0 = np.asarray(x0, dtype=float)
    step = np.floor(x0 / float(dx0)).astype(np.int64)
    step += step_position(step + 1, dx0) <= x0
    step -= step_position(step, dx0) > x0
    return step
