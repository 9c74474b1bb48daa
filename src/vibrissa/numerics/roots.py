"""Roots in brackets, element by element.

SciPy's own search takes a third of a second to import and many evaluations: it is asked only where
Newton's iteration does not converge.
"""

from collections.abc import Callable

import numpy as np

from vibrissa.numerics.arrays import FloatArray

# Most steps of Newton's iteration, and the step, relative to the bracket, whose square is below
# rounding.
NEWTON_STEPS = 12
NEWTON_TOLERANCE = 1e-9


def bracketed_root(
    function: Callable[..., tuple[FloatArray, FloatArray]],
    low: FloatArray,
    high: FloatArray,
    *args: FloatArray,
    guess: FloatArray | None = None,
) -> FloatArray:
    """Find a root in each of some brackets, to rounding error.

    Parameters
    ----------
    function : callable
        Maps places, and for each of them the further arguments, to values and slopes.
    low, high : ndarray, shape (n,)
        Ends of the brackets, between which the values change their sign; an end that is a root up
        to rounding may miss that.
    *args : ndarray, shape (n,)
        Further arguments of the function.
    guess : ndarray, shape (n,), optional
        Where to begin, by default in the middle of the brackets.

    Returns
    -------
    ndarray, shape (n,)
        Within the brackets.
    """
    root, width = 0.5 * (low + high) if guess is None else guess, high - low
    converged = np.zeros(root.shape, dtype=bool)
    for _ in range(NEWTON_STEPS):
        value, slope = function(root, *args)
        with np.errstate(divide="ignore", invalid="ignore"):
            step = value / slope
        converged = np.abs(step) < NEWTON_TOLERANCE * width
        root = np.where(np.isfinite(step), np.clip(root - step, low, high), root)
        if converged.all():
            return root
    lost = ~converged
    rest = low[lost], high[lost], *(arg[lost] for arg in args)
    root[lost] = _searched_root(lambda *a: function(*a)[0], *rest)
    return root


def _searched_root(
    function: Callable[..., FloatArray], low: FloatArray, high: FloatArray, *args: FloatArray
) -> FloatArray:
    """Find roots by Chandrupatla's method, which needs no slopes and no simple roots."""
    from scipy.optimize import elementwise

    result = elementwise.find_root(function, (low, high), args=args)
    at_low = np.abs(function(low, *args)) <= np.abs(function(high, *args))
    return np.where(result.success, result.x, np.where(at_low, low, high))
