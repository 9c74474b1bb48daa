"""Roots: `bracketed_root` of many functions at once, `sampled_root` of one that takes long.

`first_fall` and `first_integral_fall` find the first roots of piecewise polynomials. A function of
one place whose slope is not known has its root by SciPy's ``brentq``.
"""

from collections.abc import Callable
from math import comb
from typing import TYPE_CHECKING

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.interpolate import BPoly

# Steps of Newton's iteration before bisection begins, and most steps in total; these suffice to
# reach rounding error.
NEWTON_STEPS, MOST_STEPS = 12, 70
# Newton step, relative to the bracket, that ends the iteration: its square is below rounding error.
NEWTON_TOLERANCE = 1e-9
# Newton step, relative to the bracket, that ends the iteration if it is more than half as long as
# the step before: then it is rounding error, which may be large beside a narrow bracket.
ROUNDED_STEP = 1e-6
# Half of the distance over which a function is computed around its approximate root, as a part of a
# bracket.
NEAR_ROOT = 1e-4
# Largest difference of the roots of a cubic and of a line there, if the function has no kink, as a
# part of a bracket.
SMOOTH_DIFFERENCE = 1e-10
# Largest number of cubics that lead to closer samples.
MOST_CUBICS = 3
# Imaginary part below which a root of a polynomial on [0, 1] is taken as real, because rounding
# splits a double root into a complex pair.
REAL_ROOT = 1e-7


def bracketed_root(
    function: Callable[..., tuple[FloatArray, FloatArray]],
    low: FloatArray,
    high: FloatArray,
    *args: FloatArray | IntArray,
    guess: FloatArray | None = None,
) -> FloatArray:
    """Find one root in each bracket, to rounding error.

    Parameters
    ----------
    function : callable
        Maps positions, and the further arguments at each position, to values and slopes.
    low, high : ndarray, shape (n,)
        Ends of the brackets. The values there have opposite signs, or one of them is zero up to
        rounding.
    *args : ndarray, shape (n,)
        Further arguments of the function.
    guess : ndarray, shape (n,), optional
        First approximations of the roots; by default the middle of the brackets.
    """
    root, width = 0.5 * (low + high) if guess is None else guess.copy(), high - low
    below, above, begins = low.copy(), high.copy(), np.empty_like(low)
    lost, before = np.ones(root.shape, dtype=bool), np.full(root.shape, np.inf)
    for step_number in range(MOST_STEPS):
        # A root that was found does not change any more, so that it is independent of the others.
        at = root[lost]
        some = [arg[lost] for arg in args]
        value, slope = function(at, *some)
        with np.errstate(divide="ignore", invalid="ignore"):
            step = value / slope
        length = np.abs(step)
        found = length < NEWTON_TOLERANCE * width[lost]
        if step_number < NEWTON_STEPS:
            found |= (length < ROUNDED_STEP * width[lost]) & (length > 0.5 * before[lost])
            before[lost] = length
        # Where Newton's iteration has not converged, the bracket is halved.
        if step_number >= NEWTON_STEPS:
            if step_number == NEWTON_STEPS:
                begins[lost] = np.sign(function(low[lost], *some)[0])
            short = np.sign(value) == begins[lost]
            below[lost], above[lost] = (
                np.where(short, at, below[lost]),
                np.where(short, above[lost], at),
            )
            halves = ~found
        else:
            halves = ~np.isfinite(step)
        moved = np.clip(at - np.where(halves, 0.0, step), low[lost], high[lost])
        root[lost] = np.where(halves, 0.5 * (below[lost] + above[lost]), moved)
        lost[lost] = ~found
        if not lost.any():
            break
    return root


def sampled_root(
    function: Callable[[FloatArray], FloatArray], places: FloatArray, values: FloatArray, last: int
) -> float:
    """Find the root of a function that falls to zero between two of its samples.

    Where the function is smooth, it is computed once or twice for four places, in place of some
    seven times by Brent's method: a cubic through four samples leads to closer ones.

    Parameters
    ----------
    function : callable
        Maps positions to values.
    places, values : ndarray, shape (n,)
        Samples of the function, in increasing or decreasing order of their places.
    last : int
        Index of the last sample before the root.
    """
    low, high = sorted(places[last : last + 2].tolist())
    width = places[last + 1] - places[last]
    around = slice(max(last - 1, 0), last + 3)
    if not _falls(values[around]):
        around = slice(last, last + 2)
    near = width * NEAR_ROOT * np.array([-1.0, -1.0 / 3.0, 1.0 / 3.0, 1.0])
    reach = abs(width) * NEAR_ROOT
    x, y = places[around], values[around]
    for closer in range(MOST_CUBICS + 1):
        if not _falls(y):
            break
        root = _root_of_cubic(x, y)
        if closer and x.min() <= root <= x.max():
            line = (x[1] * y[2] - x[2] * y[1]) / (y[2] - y[1])
            if abs(root - line) < SMOOTH_DIFFERENCE * (high - low):
                return root
        # The function may not be known beyond its samples.
        middle = np.clip(root, low + reach, high - reach)
        x = np.clip(middle + near, low, high)
        y = function(x)
    from scipy.optimize import brentq  # half a second to load

    return float(brentq(function, low, high, xtol=1e-14))


def _falls(y: FloatArray) -> bool:
    return bool((np.diff(y) < 0.0).all())


def _root_of_cubic(x: FloatArray, y: FloatArray) -> float:
    """Root of a function with an inverse: of the polynomial x(y) through its samples, at y = 0."""
    others = ~np.eye(len(y), dtype=bool)
    ratios = y / (y - y[:, None] + np.eye(len(y)))
    return float(x @ ratios.prod(axis=1, where=others))


def first_reached(rising: FloatArray, which: IntArray, level: FloatArray) -> IntArray:
    """Find where non-decreasing sequences reach given levels, as `numpy.searchsorted` does.

    Parameters
    ----------
    rising : ndarray, shape (n, k)
        Sequences, one in each row.
    which : ndarray of int, shape (m,)
        Row in which each level is sought.
    level : ndarray, shape (m,)
        Levels.

    Returns
    -------
    ndarray of int, shape (m,)
        Index of the first member that is not below the level. It is k if all members are below the
        level, or if the level is NaN.
    """
    count = rising.shape[1]
    below = np.zeros(len(level), dtype=np.int64)
    for bit in reversed(range(count.bit_length())):
        further = below + 2**bit
        reached = rising[which, np.minimum(further, count) - 1] >= level
        below = np.where(~reached & (further <= count), further, below)
    return below


def first_fall(function: "BPoly") -> float:
    """Find where a piecewise polynomial first ceases to be positive; NaN if it stays positive.

    The polynomial may jump to zero or below between two pieces. A zero at its beginning does not
    count if the polynomial rises from there. Nor does a zero at which its sign does not change.
    """
    for piece in np.flatnonzero(function.c.min(axis=0) <= 0.0):
        places, fallen = _parts(function, int(piece))
        if fallen.any():
            return float(places[int(np.argmax(fallen))])
    return float("nan")


def first_integral_fall(rate: "BPoly", part: float) -> float:
    """Find where an integral first falls to a part of its largest value so far; NaN if nowhere.

    Parameters
    ----------
    rate : BPoly
        Derivative of the integral, which begins at 0.
    part : float
        From 0, where the integral falls to 0, to 1, where it first falls.
    """
    if rate.c.min() > 0.0:
        return float("nan")
    integral = rate.antiderivative()
    turning = np.flatnonzero((rate.c.min(axis=0) <= 0.0) & (rate.c.max(axis=0) >= 0.0))
    turns = [_parts(rate, int(piece))[0] for piece in turning]
    places = np.unique(np.concatenate([rate.x, *turns]))
    falls = rate(0.5 * (places[1:] + places[:-1])) <= 0.0
    values = integral(places)
    levels = part * np.maximum.accumulate(values)[:-1]
    (spent,) = np.nonzero(falls & (values[1:] <= levels))
    if not len(spent):
        return float("nan")
    first = int(spent[0])
    low, high = places[[first]], places[[first + 1]]
    if values[first] <= levels[first]:
        return float(low[0])

    def left(place: FloatArray) -> tuple[FloatArray, FloatArray]:
        return integral(place) - levels[first], rate(place)

    return float(bracketed_root(left, low, high)[0])


def _parts(function: "BPoly", piece: int) -> tuple[FloatArray, BoolArray]:
    """Divide a piece of a polynomial at its roots; say for each part whether it is not positive."""
    degree = len(function.c) - 1
    bernstein = function.c[:, piece]
    # Coefficients in powers of the fraction of the piece, highest power first.
    power = [comb(degree, k) * np.diff(bernstein, k)[0] for k in range(degree, -1, -1)]
    roots = np.roots(power)
    real = roots.real[np.abs(roots.imag) < REAL_ROOT]
    fractions = np.concatenate([[0.0], np.sort(real[(real > 0.0) & (real < 1.0)]), [1.0]])
    low, high = function.x[piece : piece + 2]
    falls = np.polyval(power, 0.5 * (fractions[1:] + fractions[:-1])) <= 0.0
    return low + (high - low) * fractions, falls
