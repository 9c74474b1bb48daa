"""Friction from the spacing of slips that end where their energy is used up.

How far such a slip goes depends on the friction on its whole way, not only at its end. So all
periods of a run are read together: μ0 along the surface is taken as a normal process, whose mean,
deviation and correlation length are found from the travels themselves (maximum likelihood). With
the relation between friction and travels linearised at the most probable surface, again and again,
what remains is linear regression with normal errors (Rasmussen and Williams, Gaussian Processes for
Machine Learning, chapter 2).

For the slip from period k − 1 to period k, with r and s the displacements at its end and start:

    T_k = o(μ_k) − r_k,   U(s) − U(r_k) = κ·∫ μ0·|fy| dx,   s = o(μ_{k−1}) + part of a step.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize

from vibrissa.arrays import FloatArray
from vibrissa.sensor.response import Branch

# Periods without which the surface's deviation and correlation length are not found.
FEWEST = 20
# Points on the way of a slip at which friction counts, onsets tabulated, steps of Newton.
WAY = 3
POINTS = 4001
NEWTON_STEPS = 12
# The surface is estimated, then the friction at the linearisation that follows, and so on.
ROUNDS = 3
STEPS = 4
STEP = 1e-5
# Mean squared error of the travels, in units of what surface and steps explain, that is too much.
MOST_EXCESS = 2.0
# Part of its friction from which on a tip that rests pulled may have slipped back.
TURNS = 0.8
# Least friction, and part of the way to where pulling ends, to which iterations are kept.
LEAST = 0.01
ALMOST = 0.98
# First guesses of the deviation of μ0 and its correlation length (L), and how many times larger or
# smaller they may well be.
GUESS = 0.03
FACTOR = 4.5

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(WAY)
NODES, WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS


class Linear(NamedTuple):
    """Travels as a linear function of frictions: predicted, derivatives, covariance of errors."""

    travel: FloatArray
    slopes: FloatArray
    errors: FloatArray


@dataclass(frozen=True, eq=False)
class EnergySlips:
    """Onset and rest of slips by the energy law.

    Attributes
    ----------
    branch : Branch
    kinetic_ratio : float
        μk/μ0.
    """

    branch: Branch
    kinetic_ratio: float

    def __post_init__(self) -> None:
        """Tabulate the onset over μ0."""
        x = np.linspace(0.0, self.branch.x0_lock, POINTS)[:-1]
        object.__setattr__(self, "_x", x)
        object.__setattr__(self, "_need", np.maximum.accumulate(self.branch.demand(x)))

    @property
    def most(self) -> float:
        """Largest friction to which iterations are kept."""
        return float(self._need[int(0.995 * len(self._need))])  # type: ignore[attr-defined]

    def onset(self, mu0: FloatArray) -> FloatArray:
        """Displacement at the onset of slip (L)."""
        return np.interp(mu0, self._need, self._x)  # type: ignore[attr-defined]

    def rest(self, start: FloatArray, mu0: FloatArray) -> FloatArray:
        """Find where slips from `start` end (L), with the mean friction on their way."""
        branch, kinetic = self.branch, self.kinetic_ratio * mu0
        low, high = ALMOST * branch.x0_pull, start - STEP
        x = 2.0 * self.onset(kinetic) - start
        for _ in range(NEWTON_STEPS):
            x = np.clip(x, low, high)
            path = branch.normal_path(start) - branch.normal_path(x)
            left = branch.energy(start) - branch.energy(x) - kinetic * path
            fx, fy, _ = np.moveaxis(branch(x), -1, 0)
            x = x - left / (fx - kinetic * fy)
        return np.clip(x, low, high)

    def linearised(self, mu0: FloatArray, way: FloatArray, gap: FloatArray) -> Linear:
        """Linearise the travels.

        Parameters
        ----------
        mu0 : ndarray, shape (n,)
            Friction of the periods.
        way, gap : ndarray, shape (n − 1,)
            Mean friction on the way of the slips between them; step in which each slip began, at
            any part of it. The step at the onset that ends a period is taken as long as that
            before.

        Returns
        -------
        Linear
            Travels, shape (n − 1,), of the periods but the first.
        """
        m, i = len(way), np.arange(len(way))
        onset = self.onset(mu0)
        steep = (self.onset(mu0 + STEP) - self.onset(mu0 - STEP)) / (2.0 * STEP)
        start = onset[:-1] + 0.5 * gap
        over_start = (self.rest(start + STEP, way) - self.rest(start - STEP, way)) / (2.0 * STEP)
        over_way = (self.rest(start, way + STEP) - self.rest(start, way - STEP)) / (2.0 * STEP)
        slopes = np.zeros((m, 2 * m + 1))
        slopes[i, i + 1] = steep[1:]
        slopes[i, i] = -over_start * steep[:-1]
        slopes[i, m + 1 + i] = -over_way
        # What part of the step had passed at an onset, uniform, enters two travels.
        uniform = gap**2 / 12.0
        errors = np.diag(uniform * (1.0 + over_start**2))
        errors[i[:-1], i[1:]] = errors[i[1:], i[:-1]] = -over_start[1:] * uniform[1:]
        return Linear(onset[1:] - 0.5 * gap - self.rest(start, way), slopes, errors)


def read_travels(
    branch: Branch, kinetic_ratio: float, travel: FloatArray, gap: FloatArray, place: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Find the friction of a run of periods from the clamp's travels.

    Parameters
    ----------
    branch : Branch
    kinetic_ratio : float
        μk/μ0, above 0 and below 1.
    travel : ndarray, shape (n,)
        Of the clamp, forward, from the first to the last sample of each period (L); that of the
        first period is not used.
    gap : ndarray, shape (n,)
        Way of the clamp from there to the first sample after the slip (L).
    place : ndarray, shape (n,)
        Where the contacts are (L), from any point.

    Returns
    -------
    mean, deviation : ndarray, shape (n,)
        Of μ0; NaN beside a slip that may have gone back, or where it is none of this rod.

    Raises
    ------
    numpy.linalg.LinAlgError
        If no surface explains the travels.
    """
    slips = EnergySlips(branch, kinetic_ratio)
    n, step, measured = len(place), gap[:-1], travel[1:]
    # To begin with: the same friction everywhere.
    grid = np.linspace(LEAST, slips.most, 400)
    usual = float(np.median(step))
    start = slips.onset(grid) + 0.5 * usual
    travels = slips.onset(grid) - 0.5 * usual - slips.rest(start, grid)
    level = float(np.median(np.interp(measured, np.maximum.accumulate(travels), grid)))
    values = np.full(2 * n - 1, level)
    guess = np.array([level, np.log(GUESS), np.log(GUESS)])

    for _ in range(ROUNDS):
        linear = slips.linearised(values[:n], values[n:], step)
        points, parts = _averages(slips, place, values, step)
        squares = (points[:, None] - points) ** 2
        rest = measured - linear.travel + linear.slopes @ values

        def covariance(
            guess: FloatArray, parts: FloatArray, squares: FloatArray = squares
        ) -> FloatArray:
            kernel = np.exp(2.0 * guess[1] - 0.5 * squares / np.exp(2.0 * guess[2]))
            return np.asarray(parts @ kernel @ parts.T)

        def unlikely(
            guess: FloatArray,
            linear: Linear = linear,
            rest: FloatArray = rest,
            parts: FloatArray = linear.slopes @ parts,
        ) -> float:
            spread = covariance(guess, parts) + linear.errors
            if not np.isfinite(spread).all():
                raise np.linalg.LinAlgError("the travels cannot be linearised")
            factor = cho_factor(spread, lower=True)
            miss = rest - guess[0] * linear.slopes.sum(axis=1)
            far = (guess[1:] - np.log(GUESS)) / np.log(FACTOR)
            size = np.log(np.diag(factor[0])).sum() + 0.5 * miss @ cho_solve(factor, miss)
            return float(size + 0.5 * far @ far)

        guess = minimize(unlikely, guess, method="L-BFGS-B", options={"maxiter": 12}).x
        for _ in range(STEPS):
            linear = slips.linearised(values[:n], values[n:], step)
            rest = measured - linear.travel + linear.slopes @ values
            prior = covariance(guess, parts)
            spread = linear.slopes @ prior @ linear.slopes.T + linear.errors
            gain = np.linalg.solve(spread, linear.slopes @ prior).T
            found = guess[0] + gain @ (rest - guess[0] * linear.slopes.sum(axis=1))
            values = np.clip(found, LEAST, slips.most)
    miss = measured - slips.linearised(values[:n], values[n:], step).travel
    miss += linear.slopes @ (values - guess[0])
    if not miss @ np.linalg.solve(spread, miss) < MOST_EXCESS * len(miss):
        raise np.linalg.LinAlgError("no surface of one kind explains the travels")
    left = np.diag(prior - gain @ linear.slopes @ prior)
    # The surface's mean is as uncertain as the travels leave it.
    total = linear.slopes.sum(axis=1)
    over_mean = 1.0 - gain @ total
    left = left + over_mean**2 / (total @ np.linalg.solve(spread, total))
    mean, deviation = values[:n].copy(), np.sqrt(np.maximum(left[:n], 0.0))
    # Where a tip rests pulled, and may slip back, the relation does not hold on either side.
    end = slips.rest(slips.onset(mean[:-1]) + 0.5 * step, values[n:])
    back = np.append(False, -branch.demand(end) > TURNS * mean[1:])
    kept = (mean <= LEAST) | (mean >= slips.most)
    near = kept | back | np.append(back[1:], False) | np.append(False, back[:-1])
    mean[near] = deviation[near] = np.nan
    return mean, deviation


def _averages(
    slips: EnergySlips, place: FloatArray, values: FloatArray, step: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Points on the surface, and how frictions at contacts and on the slips' ways average them."""
    n = len(place)
    start = slips.onset(values[: n - 1]) + 0.5 * step
    end = slips.rest(start, values[n:])
    between = place[:-1, None] + np.diff(place)[:, None] * NODES
    normal = np.abs(slips.branch(start[:, None] + (end - start)[:, None] * NODES)[..., 1])
    weight = WEIGHTS * normal
    weight /= weight.sum(axis=1, keepdims=True)
    parts = np.zeros((2 * n - 1, n + between.size))
    parts[:n, :n] = np.eye(n)
    for i in range(n - 1):
        parts[n + i, n + WAY * i : n + WAY * (i + 1)] = weight[i]
    return np.concatenate([place, between.ravel()]), parts
