"""How well friction can be read: each source of uncertainty in one function.

A period's last sticking state is at most one step before the onset: μ0 is that state's |tan α| or
more, up to what one more step would have needed. The onset is taken as uniform within the step;
with the normal noise of the readings this makes a distribution of μ0, represented by equally likely
values, of which mean, deviation and the central 95 % are returned.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import norm

from vibrissa.arrays import FloatArray
from vibrissa.sensor.response import Branch

# Equally likely values of onset, noise, beginning and common error, evenly spread, that make a
# distribution: multiples of the powers of the inverse of the root of x⁵ = x + 1 (Roberts).
VALUES = 1024
EVENLY = 1.1673039782614187 ** -np.arange(1.0, 5.0)
COVERAGE = 0.95

_U, _Z, _V, _W = ((np.arange(1, VALUES + 1)[:, None] * EVENLY) % 1.0).T
ONSET, NOISE, BEGINNING, COMMON = _U, norm.ppf(_Z), _V, norm.ppf(_W)


# Periods looked at together: what that takes of memory stays small.
BLOCK = 512


class LastStates(NamedTuple):
    """Last sticking states of n periods, each field an array of shape (n,).

    Attributes
    ----------
    travel, deviation : ndarray
        Displacement x0 there, or for the spacing the clamp's travel since the slip before, and the
        standard deviation of its error (L).
    gap : ndarray
        Way of the clamp from there to the first sample after the slip (L).
    early : ndarray
        The same at the slip before (L): for the spacing, otherwise 0.
    sign : ndarray
        1 where the clamp moved forward, −1 where backward.
    base, ratio_deviation : ndarray
        What is added to the ratio of forces that the rod needs at the onset, and the standard
        deviation of its error.
    """

    travel: FloatArray
    deviation: FloatArray
    gap: FloatArray
    early: FloatArray
    sign: FloatArray
    base: FloatArray
    ratio_deviation: FloatArray


class Summary(NamedTuple):
    """Mean, standard deviation and central 95 % of a distribution; NaN where there is none."""

    mean: FloatArray
    deviation: FloatArray
    low: FloatArray
    high: FloatArray


def ratio_deviation(
    fx: ArrayLike, fy: ArrayLike, noise_x: ArrayLike, noise_y: ArrayLike
) -> FloatArray:
    """Propagate the noise of one sample to its ratio fx/fy: its standard deviation.

    Parameters
    ----------
    fx, fy : array_like
        Forces (E·I0/L²).
    noise_x, noise_y : array_like
        Their standard deviations (E·I0/L²).

    Returns
    -------
    ndarray
    """
    fx, fy = np.asarray(fx), np.asarray(fy)
    return np.asarray(np.hypot(noise_x / fy, fx * noise_y / fy**2))


def step_deviation(slope: FloatArray, step: FloatArray | float) -> FloatArray:
    """Give the standard deviation of μ0 by the step: the onset is uniform in it.

    Parameters
    ----------
    slope : ndarray
        Growth of the demand −tan α with x0 at the onset (1/L).
    step : ndarray or float
        Step of the stage (L).

    Returns
    -------
    ndarray
        What `identify` states for a step along which the demand is straight.
    """
    return np.asarray(np.abs(slope) * step / np.sqrt(12.0))


def information(slope: FloatArray, noise: FloatArray) -> FloatArray:
    """Tell how much samples say of the contact's position: its inverse variance, which adds up.

    Parameters
    ----------
    slope : ndarray, shape (..., k)
        Derivatives of the k channels with respect to x0.
    noise : ndarray, shape (k,)
        Standard deviations of one reading.

    Returns
    -------
    ndarray, shape (...)
        In units of L⁻².
    """
    return np.asarray(((slope / noise) ** 2).sum(axis=-1))


def contact_deviation(information: FloatArray) -> FloatArray:
    """Convert what is known of a contact (L⁻²) to the standard deviation of its position (L)."""
    return np.asarray(1.0 / np.sqrt(information))


def onsets(x_last: FloatArray, deviation: FloatArray, gap: FloatArray) -> FloatArray:
    """Equally likely onsets of slip.

    Parameters
    ----------
    x_last, deviation : ndarray, shape (n,)
        Last sticking states (L) and the standard deviation of their error.
    gap : ndarray, shape (n,)
        Way of the clamp from there to the first sample after the slip; the onset is uniform in it.

    Returns
    -------
    ndarray, shape (n, VALUES)
    """
    return x_last[:, None] + deviation[:, None] * NOISE + gap[:, None] * ONSET


def missed_beginnings(early: FloatArray, step: float) -> FloatArray:
    """Travel that a lossy recording does not show: a slip may have ended at any step of a gap.

    Parameters
    ----------
    early : ndarray, shape (n,)
        Way of the clamp from the last sample before the slip to the first after it (L).
    step : float
        Step of the stage (L).

    Returns
    -------
    ndarray, shape (n, VALUES)
        Equally likely (L).
    """
    steps = np.maximum(1.0, np.round(np.abs(early) / step))[:, None]
    return np.sign(early)[:, None] * np.floor(BEGINNING * steps) * step


def frictions(
    branch: Branch,
    onset: FloatArray,
    sign: FloatArray,
    base: FloatArray,
    deviation: FloatArray,
    common: FloatArray,
) -> FloatArray:
    """Equally likely values of μ0.

    Parameters
    ----------
    branch : Branch
    onset : ndarray, shape (n, VALUES)
        Onsets of slip (L).
    sign : ndarray, shape (n,)
        1 where the clamp moved forward, −1 where backward.
    base, deviation : ndarray, shape (n,)
        What is added to the ratio that the rod needs at the onset, and the standard deviation of
        its error.
    common : ndarray, shape (n,)
        Standard deviation of the error of μ0 that all periods share.

    Returns
    -------
    ndarray, shape (n, VALUES)
        Infinite where there is none: the tip did slip, which excludes onsets past the lock, or
        where the surface would have to hold it.
    """
    possible = (onset > branch.x0_pull) & (onset <= branch.x0_lock)
    needed = branch.demand(np.clip(onset, branch.x0_pull, branch.x0_lock))
    mu0 = sign[:, None] * (needed + base[:, None] + deviation[:, None] * NOISE)
    mu0 += common[:, None] * COMMON
    return np.where(possible & (mu0 > 0.0), mu0, np.inf)


def friction_of(
    branch: Branch,
    last: LastStates,
    common: FloatArray,
    step: float = 1.0,
    onset_of: Callable[[FloatArray, slice], FloatArray] = lambda travel, periods: travel,
) -> Summary:
    """Propagate every source of uncertainty to μ0.

    Parameters
    ----------
    branch : Branch
    last : LastStates
        Of n periods.
    common : ndarray, shape (n,)
        Standard deviation of the error of μ0 that all periods share.
    step : float
        Step of the stage (L), where a beginning was missed.
    onset_of : callable
        Maps travels of a slice of the periods to displacements at the onset, for the spacing.

    Returns
    -------
    Summary
        Arrays of shape (n,).
    """
    parts = []
    for start in range(0, len(last.sign), BLOCK):
        here = slice(start, start + BLOCK)
        part = LastStates(*(values[here] for values in last))
        travel = onsets(part.travel, part.deviation, part.gap)
        travel += missed_beginnings(part.early, step)
        onset = onset_of(travel, here)
        parts.append(
            summary(
                frictions(branch, onset, part.sign, part.base, part.ratio_deviation, common[here])
            )
        )
    return Summary(*(np.concatenate(values) for values in zip(*parts, strict=True)))


def common_deviation(mean: FloatArray, displaced: Sequence[FloatArray]) -> FloatArray:
    """Add up what all periods share: its standard deviation.

    Parameters
    ----------
    mean : ndarray, shape (n,)
        Of each period.
    displaced : sequence of ndarray
        The same with the rod's setup one standard deviation away, along each principal axis.

    Returns
    -------
    ndarray, shape (n,)
    """
    squares = sum(((np.asarray(moved) - mean) ** 2 for moved in displaced), np.zeros(len(mean)))
    return np.sqrt(np.nan_to_num(squares))


def least_friction(
    branch: Branch, x_low: FloatArray, x_high: FloatArray, deviation: FloatArray
) -> FloatArray:
    """Bound μ0 from below by what sticking has needed so far.

    Parameters
    ----------
    branch : Branch
    x_low, x_high : ndarray, shape (n,)
        Least and largest displacement at which the tip stuck (L).
    deviation : ndarray, shape (n,)
        Standard deviation of their common error (L).

    Returns
    -------
    ndarray, shape (n,)
        Lower end of the central 95 %; μ_lock, up to rounding, from the lock on.
    """
    margin = norm.ppf(0.5 * (1.0 + COVERAGE)) * deviation
    pushed = branch.demand(np.clip(x_high - margin, 0.0, branch.x0_lock))
    # Where pulling ends, any friction would be needed.
    pulled = -branch.demand(np.clip(x_low + margin, 0.999 * branch.x0_pull, 0.0))
    pushed = np.where(x_high - margin >= branch.x0_lock, branch.mu_lock, pushed)
    return np.asarray(np.maximum(0.0, np.maximum(pushed, pulled)))


def normal_summary(branch: Branch, mean: FloatArray, deviation: FloatArray) -> Summary:
    """Summarise normal distributions of μ0, whose intervals end where this rod can slip."""
    margin = norm.ppf(0.5 * (1.0 + COVERAGE)) * deviation
    low, high = np.maximum(mean - margin, 0.0), np.minimum(mean + margin, branch.mu_lock)
    return Summary(mean, deviation, low, high)


def summary(draws: FloatArray) -> Summary:
    """Summarise equally likely values.

    Parameters
    ----------
    draws : ndarray, shape (n, VALUES)
        Infinite values do not count.

    Returns
    -------
    Summary
        Arrays of shape (n,).
    """
    draws = np.sort(draws, axis=1)
    count = np.isfinite(draws).sum(axis=1)
    safe = np.maximum(count, 1)
    finite = np.where(np.isfinite(draws), draws, 0.0)
    mean = finite.sum(axis=1) / safe
    deviation = np.sqrt(np.maximum(0.0, (finite**2).sum(axis=1) / safe - mean**2))

    def quantile(part: float) -> FloatArray:
        rank = np.clip(part * safe - 0.5, 0.0, safe - 1.0)
        below = np.floor(rank).astype(np.int64)
        above = np.minimum(below + 1, safe - 1)
        row = np.arange(len(draws))
        weight = rank - below
        return np.asarray(draws[row, below] * (1.0 - weight) + draws[row, above] * weight)

    tail = 0.5 * (1.0 - COVERAGE)
    with np.errstate(invalid="ignore"):
        result = Summary(mean, deviation, quantile(tail), quantile(1.0 - tail))
    for values in result:
        values[count == 0] = np.nan
    return result
