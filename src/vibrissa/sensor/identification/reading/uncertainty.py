"""How well friction is known: every source of uncertainty, propagated to μ0.

The last sticking state of a period is at most one step before the onset. So μ0 is at least |tan α|
in that state, and at most what the tip would have needed one step later. The onset is uniform
within the step, the noise of the readings is normal. The distribution of μ0 that follows is
represented by equally likely values; its mean, deviation and central 95 % are returned.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtri

from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.batch import Batch
from vibrissa.sensor.identification.periods import Placed
from vibrissa.sensor.response.branch import Branch
from vibrissa.sensor.response.height_range import HeightStates

# Part of a distribution that its interval holds, and half the width of that of a normal one.
COVERAGE = 0.95
HALF_WIDTH = float(ndtri(0.5 * (1.0 + COVERAGE)))
# Periods that are computed together, to save memory.
BLOCK = 512
# Equally likely values of onset, noise and common error, spread evenly over three dimensions:
# multiples of the powers of the inverse of the root of x⁴ = x + 1 (Roberts).
VALUES = 1024
EVENLY = 1.2207440846057596 ** -np.arange(1.0, 4.0)


@dataclass(frozen=True, eq=False, kw_only=True)
class Values:
    """Equally likely values by which a distribution is represented, each of shape (k,).

    Attributes
    ----------
    onset : ndarray
        Part of a step, uniform from 0 to 1.
    noise, common : ndarray
        Standard normal.
    ahead : ndarray
        0 or 1: which of the two lags.
    """

    onset: FloatArray
    noise: FloatArray
    common: FloatArray
    ahead: FloatArray

    @classmethod
    def many(cls) -> Self:
        """Spread them evenly."""
        onset, noise, common = (np.arange(1, VALUES + 1)[:, None] * EVENLY % 1.0).T
        return cls(
            onset=onset,
            noise=ndtri(noise),
            common=ndtri(common),
            ahead=np.array([0.0, 1.0] * (VALUES // 2)),
        )

    @classmethod
    def centre(cls) -> Self:
        """Take the middle alone, for what changes little."""
        none = np.zeros(1)
        return cls(onset=none + 0.5, noise=none, common=none, ahead=none + 0.5)


MANY, CENTRE = Values.many(), Values.centre()


@dataclass(frozen=True, eq=False, kw_only=True)
class LastStates(Batch):
    """Last sticking states of n periods, each field an array of shape (n,).

    Attributes
    ----------
    clamp, clamp_gap : ndarray
        Position of the clamp, and its way to the first sample after the slip (L).
    travel, deviation : ndarray
        Displacement x0 in that state and the standard deviation of its error (L).
    gap : ndarray
        By how much x0 grows on that way, with the tip where it is (L): on a stage along the surface
        as much as the clamp moves.
    sign : ndarray
        1 where the clamp moved forward, −1 where backward.
    base : ndarray
        What is added to the friction that the tip needs at the onset.
    lag_low, lag_high : ndarray
        By how much the readings lag behind the clamp (L): by one or the other, equally likely.
    """

    clamp: FloatArray
    clamp_gap: FloatArray
    travel: FloatArray
    deviation: FloatArray
    gap: FloatArray
    sign: FloatArray
    base: FloatArray
    lag_low: FloatArray
    lag_high: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class Summary(Batch):
    """Mean, standard deviation and central 95 % of distributions; NaN where there is none."""

    mean: FloatArray
    deviation: FloatArray
    low: FloatArray
    high: FloatArray


def ratio_deviation(
    fx: ArrayLike, fy: ArrayLike, noise_x: ArrayLike, noise_y: ArrayLike
) -> FloatArray:
    """Propagate the noise of one sample, noise_x and noise_y, to its ratio fx/fy (E·I0/L²)."""
    fx, fy = np.asarray(fx), np.asarray(fy)
    return np.asarray(np.hypot(noise_x / fy, fx * noise_y / fy**2))


def step_deviation(slope: FloatArray, step: FloatArray | float) -> FloatArray:
    """Give the standard deviation of μ0 by the step of the stage, in which the onset is uniform.

    Parameters
    ----------
    slope : ndarray
        Growth of the demand −tan α with x0 at the onset (1/L), constant within a step.
    step : ndarray or float
        Step of the stage (L).

    Returns
    -------
    ndarray
    """
    return np.asarray(np.abs(slope) * step / np.sqrt(12.0))


def friction_of(
    branch: Placed,
    last: LastStates,
    common: FloatArray,
    values: Values = MANY,
) -> Summary:
    """Propagate every source of uncertainty to μ0.

    Parameters
    ----------
    branch : Branch or ObliqueStage
    last : LastStates
        Of n periods.
    common : ndarray, shape (n,)
        Standard deviation of the error of μ0 that all periods share.
    values : Values

    Returns
    -------
    Summary
    """
    parts = []
    for start in range(0, len(last), BLOCK):
        here = slice(start, start + BLOCK)
        part = last.take(here)
        onset = _onsets(part, values)
        states, _ = branch.above(part.clamp[:, None] + part.clamp_gap[:, None] * values.onset)
        parts.append(summary_of(_frictions(states, onset, part, common[here], values)))
    return Summary.concatenate(parts)


def _onsets(last: LastStates, values: Values) -> FloatArray:
    """Equally likely displacements at the onset of slip (L), shape (n, k)."""
    onset = last.travel[:, None] + last.deviation[:, None] * values.noise
    onset += last.gap[:, None] * values.onset
    lag = last.lag_high - last.lag_low
    return np.asarray(onset + last.lag_low[:, None] + lag[:, None] * values.ahead)


def _frictions(
    states: Branch | HeightStates,
    onset: FloatArray,
    last: LastStates,
    common: FloatArray,
    values: Values,
) -> FloatArray:
    """Equally likely values of μ0, shape (n, k); infinite for impossible onsets."""
    # As the tip did slip, the onset is neither past the lock nor beyond the end of pulling.
    possible = (onset > states.x0_pull) & (onset <= states.x0_lock)
    needed = states.demand(np.clip(onset, states.x0_pull, states.x0_lock))
    ratio = needed + last.base[:, None]
    mu0 = last.sign[:, None] * ratio + common[:, None] * values.common
    return np.where(possible & (mu0 > 0.0), mu0, np.inf)


def summary_of(values: FloatArray) -> Summary:
    """Summarise equally likely values, shape (n, k), of which infinite ones do not count."""
    counts = np.isfinite(values).sum(axis=1)
    found = Summary.unknown(len(values))
    tails = 0.5 * (1.0 - COVERAGE), 0.5 * (1.0 + COVERAGE)
    every = values.shape[1]
    whole, part = counts == every, (counts > 0) & (counts < every)
    for rows, quantile in ((whole, np.quantile), (part, np.nanquantile)):
        if rows.any():
            finite = np.where(np.isfinite(values[rows]), values[rows], np.nan)
            low, high = quantile(finite, tails, axis=1, method="hazen")
            mean, deviation = np.nanmean(finite, axis=1), np.nanstd(finite, axis=1)
            found.put(rows, Summary(mean=mean, deviation=deviation, low=low, high=high))
    return found


def common_deviation(effects: FloatArray, shared: FloatArray) -> FloatArray:
    """Give the standard deviation of the error that all periods share.

    Parameters
    ----------
    effects : ndarray, shape (n, k)
        Change of each value per unit of each of k things.
    shared : ndarray, shape (k, k)
        Covariance of the errors of these.

    Returns
    -------
    ndarray, shape (n,)
    """
    return np.asarray(np.sqrt(np.maximum(np.einsum("ni,ij,nj->n", effects, shared, effects), 0.0)))


def least_friction(states: Branch | HeightStates, low: FloatArray, high: FloatArray) -> FloatArray:
    """Bound μ0 from below by the friction with which the tip has stuck in some states.

    Parameters
    ----------
    states : Branch or HeightStates
    low, high : ndarray, shape (n,)
        Displacements of pulled and of pushed states (L), of which is certain that they were
        reached.

    Returns
    -------
    ndarray, shape (n,)
        On a stage along the surface at least μ_lock, up to rounding, from the lock on; NaN where
        the tip cannot have stuck.
    """
    # A stage along the surface has taken the tip past the lock through it; an oblique one perhaps
    # where the lock came to the tip.
    level = isinstance(states, Branch)
    pushed = states.demand(np.clip(high, 0.0, states.x0_lock if level else states.x0_end))
    # Where pulling ends, any friction would be needed.
    pulled = -states.demand(np.clip(low, 0.999 * states.x0_pull, 0.0))
    pushed = np.where(level & (high >= states.x0_lock), states.mu_lock, pushed)
    # Without pulling nothing is known of x0 < 0.
    slipped = (high > states.x0_end) | ((low < states.x0_pull) & (states.x0_pull < 0.0))
    return np.asarray(np.where(slipped, np.nan, np.maximum(0.0, np.maximum(pushed, pulled))))
