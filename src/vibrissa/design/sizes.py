"""The size of a rod of given θ and η: the smallest standard deviation of μ0 within the limits.

Limits are straight lines over ln d0 and ln L (`vibrissa.design.limits`). The standard deviation is
a sum of powers, so it is convex in these logarithms, and it falls as d0 grows. So the best rod is
as thick as the limits allow, and only its length is sought.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np
from scipy.optimize import linprog

from vibrissa.design.limits import HUGE, Line, limits_of
from vibrissa.design.pairs import Pairs
from vibrissa.design.requirements import Requirements
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.numerics.batch import Batch
from vibrissa.sensor.identification.reading.uncertainty import step_deviation

# Lengths among which the best is sought, twice: in the whole range and around the best of those.
LENGTHS = 129
# By this much, in logarithms, a limit may be exceeded, so that a rod that was found keeps to its
# limits when it is solved again.
ROUNDING = 1e-6


@dataclass(frozen=True, eq=False, kw_only=True)
class Deviations(Batch):
    """Standard deviation of μ0 from one period of sticking, by its sources.

    Attributes
    ----------
    by_step, by_reading : ndarray, shape (..., k)
        By the step of the stage and by the noise of the readings, for each friction coefficient;
        NaN where the tip locks.
    """

    by_step: FloatArray
    by_reading: FloatArray

    @property
    def total(self) -> FloatArray:
        """Both, added in quadrature."""
        return np.hypot(self.by_step, self.by_reading)

    @property
    def largest(self) -> FloatArray:
        """Largest of all friction coefficients, shape (...)."""
        return np.asarray(self.total.max(axis=-1))


def deviations(
    requirements: Requirements, pairs: Pairs, diameter: FloatArray, length: FloatArray
) -> Deviations:
    """Compute the standard deviation of μ0 from one period of sticking that begins at α = 0.

    Parameters
    ----------
    requirements : Requirements
    pairs : Pairs
        n pairs (θ, η).
    diameter, length : ndarray, shape (n, ...)
        Sizes of rods of each pair (m).

    Returns
    -------
    Deviations
        Of shape (n, ..., k).

    Notes
    -----
    What `identify` states, which reads all channels in all samples of the period; the sum over them
    is taken as an integral.
    """
    r = requirements
    # One axis for the pairs, those of the sizes, one for the friction coefficients.
    others = (1,) * (length.ndim - 1)
    slope = pairs.demand_slope.reshape(len(pairs), *others, -1)
    information = pairs.information.reshape(len(pairs), *others, *pairs.information.shape[1:])
    diameter, length = diameter[..., None], length[..., None]
    force = r.rigidity * diameter**4 / length**2
    step = r.step / length
    by_step = step_deviation(slope, step)
    units = np.stack([force, force, force * length], axis=-1)
    known = (information * (units / np.array(r.noise)) ** 2).sum(axis=-1)
    with np.errstate(divide="ignore"):  # a period of no length tells nothing
        by_reading = np.abs(slope) * np.sqrt(step / known)
    return Deviations(by_step=by_step, by_reading=by_reading)


@dataclass(frozen=True, eq=False, kw_only=True)
class Sizes(Batch):
    """The best size of a rod for each of n pairs (θ, η).

    Attributes
    ----------
    diameter, length : ndarray, shape (n,)
        In m.
    cost : ndarray, shape (n,)
        What is least for this size.
    """

    diameter: FloatArray
    length: FloatArray
    cost: FloatArray


def best_sizes(requirements: Requirements, pairs: Pairs) -> Sizes:
    """Sizes with the smallest standard deviation of μ0 within the limits.

    Parameters
    ----------
    requirements : Requirements
    pairs : Pairs
        n pairs (θ, η).

    Returns
    -------
    Sizes
        The cost is the standard deviation at that μ0 where it is largest. Where no size keeps to
        all limits it is infinite, and the sizes are NaN.
    """
    lines = [limit.line for limit in limits_of(requirements, pairs)]
    low, high, possible = _lengths(lines)
    part = np.linspace(0.0, 1.0, LENGTHS)
    rows = np.arange(len(pairs))
    for _ in range(2):
        log_length = low[:, None] + (high - low)[:, None] * part
        log_diameter = _largest_diameter(lines, log_length)
        cost = deviations(requirements, pairs, np.exp(log_diameter), np.exp(log_length)).largest
        best = np.argmin(np.nan_to_num(cost, nan=np.inf), axis=1)
        low = log_length[rows, np.maximum(best - 1, 0)]
        high = log_length[rows, np.minimum(best + 1, LENGTHS - 1)]
    cost, log_diameter, log_length = (x[rows, best] for x in (cost, log_diameter, log_length))
    possible &= np.isfinite(cost)
    return Sizes(
        diameter=np.where(possible, np.exp(log_diameter), np.nan),
        length=np.where(possible, np.exp(log_length), np.nan),
        cost=np.where(possible, cost, np.inf),
    )


def _largest_diameter(lines: Sequence[Line], log_length: FloatArray) -> FloatArray:
    """Logarithms of the largest diameters that keep to all limits, for lengths of shape (n, m)."""
    bounds = (
        -(line.constant[:, None] + line.q * log_length) / line.p for line in lines if line.p > 0
    )
    return reduce(np.minimum, bounds, np.full(log_length.shape, HUGE))


def _lengths(lines: Sequence[Line]) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Least and largest ln L for which a diameter keeps to all limits, and whether there are any.

    Notes
    -----
    By Fourier and Motzkin, ln d0 is eliminated: each lower bound on it, which depends on ln L, must
    be below each upper bound.
    """
    conditions = [(line.constant, float(line.q)) for line in lines if line.p == 0]
    conditions += [
        (upper.constant / upper.p - lower.constant / lower.p, upper.q / upper.p - lower.q / lower.p)
        for upper in lines
        for lower in lines
        if upper.p > 0 > lower.p
    ]
    n = len(lines[0].constant)
    low, high, possible = np.full(n, -np.inf), np.full(n, np.inf), np.ones(n, dtype=bool)
    for constant, slope in conditions:
        if slope == 0.0:
            possible &= constant <= ROUNDING
        elif slope > 0.0:
            high = np.minimum(high, -constant / slope)
        else:
            low = np.maximum(low, -constant / slope)
    possible &= low <= high + ROUNDING
    # Where nothing is possible the length is not used.
    high = np.maximum(low, high)
    return np.clip(low, -HUGE, HUGE), np.clip(high, -HUGE, HUGE), possible


def nearest_sizes(requirements: Requirements, pairs: Pairs) -> Sizes:
    """Sizes within their ranges that violate the limits least.

    Parameters
    ----------
    requirements : Requirements
    pairs : Pairs
        n pairs (θ, η).

    Returns
    -------
    Sizes
        The cost is the logarithm of the largest factor by which a limit is violated.
    """
    limits = limits_of(requirements, pairs)
    lines = [limit.line for limit in limits]
    # Unknown are ln d0, ln L and the violation that all limits but those to sizes may have.
    matrix = [
        [line.p, line.q, 0.0 if limit.size else -1.0]
        for limit, line in zip(limits, lines, strict=True)
    ]
    results = []
    for constants in np.stack([line.constant for line in lines], axis=1):
        found = linprog([0.0, 0.0, 1.0], A_ub=matrix, b_ub=-constants, bounds=(None, None))
        results.append([np.nan, np.nan, np.inf] if found.x is None else found.x)
    log_diameter, log_length, cost = np.array(results).T
    return Sizes(diameter=np.exp(log_diameter), length=np.exp(log_length), cost=cost)
