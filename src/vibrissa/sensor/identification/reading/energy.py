"""Friction from the spacing of slips that end where their energy is dissipated.

How far such a slip goes depends on the friction along its whole way, not only at its end. So all
periods of a run are read together: μ0 along the surface is taken as a normal process, whose mean,
deviation and correlation length are found from the travels themselves (maximum likelihood). The
relation between friction and travels is linearised at the most probable surface, repeatedly; what
remains is linear regression with normal errors (Rasmussen and Williams, Gaussian Processes for
Machine Learning, chapter 2).

For the slip from period k − 1 to period k, with r and s the displacements at its end and start:

    T_k = o(μ_k) − r_k,   U(s) − U(r_k) = κ·∫ μ0·|fy| dx,   s = o(μ_{k−1}) + part of a step.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize

from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.identification.reading.spacing import onset_table
from vibrissa.sensor.response.branch import Branch

# Fewer periods do not determine the surface's deviation and correlation length.
FEWEST = 20
# Points on the way of a slip at which friction counts, Newton steps for a rest.
WAY = 3
NEWTON_STEPS = 12
# So often the surface is estimated, and each time the friction and the linearisation at it.
ROUNDS = 3
STEPS = 4
# Most iterations of the optimiser in a round.
ITERATIONS = 12
# Step in displacements (L) and frictions for derivatives.
STEP = 1e-5
# Mean squared residual of the travels, in units of what surface and steps explain, that is refused.
MOST_EXCESS = 2.0
# A pulled tip at rest that mobilises more than this part of its friction may have slipped back.
TURNS = 0.8
# Bounds of the iterations: least friction, part of all onsets, part of the way to the end of
# pulling.
LEAST = 0.01
MOST_ONSET = 0.995
ALMOST = 0.98
# First guess of the deviation of μ0 and of its correlation length (L), and the factor by which they
# may well be larger or smaller.
GUESS = 0.03
FACTOR = 4.5

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(WAY)
NODES, WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS


@dataclass(frozen=True, eq=False, kw_only=True)
class Linear:
    """Travels as a linear function of frictions.

    Attributes
    ----------
    travel : ndarray, shape (m,)
        At the frictions where it was linearised (L).
    slopes : ndarray, shape (m, 2·m + 1)
        Derivatives with respect to the frictions of the periods and of the slips.
    errors : ndarray, shape (m, m)
        Covariance of the travels by the stage's steps.
    """

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

    @cached_property
    def _onsets(self) -> tuple[FloatArray, FloatArray]:
        """Table of the onset over μ0."""
        return onset_table(self.branch, self.branch.x0_lock)

    @property
    def most(self) -> float:
        """Upper bound of the friction in iterations."""
        mu0, _ = self._onsets
        return float(mu0[int(MOST_ONSET * len(mu0))])

    def onset(self, mu0: FloatArray) -> FloatArray:
        """Displacement at the onset of slip (L)."""
        return np.interp(mu0, *self._onsets)

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
        way : ndarray, shape (n − 1,)
            Mean friction on the way of the slips between them.
        gap : ndarray, shape (n,)
            Step of the stage that ends each period, in which its slip began (L).

        Returns
        -------
        Linear
            Travels, shape (n − 1,), of the periods but the first.
        """
        m, i = len(way), np.arange(len(way))
        onset = self.onset(mu0)
        steep = (self.onset(mu0 + STEP) - self.onset(mu0 - STEP)) / (2.0 * STEP)
        start = onset[:-1] + 0.5 * gap[:-1]
        over_start = (self.rest(start + STEP, way) - self.rest(start - STEP, way)) / (2.0 * STEP)
        over_way = (self.rest(start, way + STEP) - self.rest(start, way - STEP)) / (2.0 * STEP)
        slopes = np.zeros((m, 2 * m + 1))
        slopes[i, i + 1] = steep[1:]
        slopes[i, i] = -over_start * steep[:-1]
        slopes[i, m + 1 + i] = -over_way
        # The part of the step that had passed at an onset is uniform, and enters two travels: of
        # the period that it ends, and of the next one.
        enters = np.zeros((m, m + 1))
        enters[i, i + 1], enters[i, i] = 1.0, -over_start
        errors = enters * (gap**2 / 12.0) @ enters.T
        travel = onset[1:] - 0.5 * gap[1:] - self.rest(start, way)
        return Linear(travel=travel, slopes=slopes, errors=errors)


@dataclass(frozen=True, eq=False, kw_only=True)
class _Process:
    """Normal process with a Gaussian correlation.

    Attributes
    ----------
    mean : float
    log_deviation, log_length : float
        Logarithms of its standard deviation and of its correlation length (L).
    """

    mean: float
    log_deviation: float
    log_length: float

    @classmethod
    def of(cls, values: FloatArray) -> Self:
        """Name the values of an optimiser."""
        mean, log_deviation, log_length = values.tolist()
        return cls(mean=mean, log_deviation=log_deviation, log_length=log_length)

    def covariance(self, squares: FloatArray, parts: FloatArray) -> FloatArray:
        """Covariance of averages over points, from the squares of the points' distances (L²)."""
        kernel = np.exp(2.0 * self.log_deviation - 0.5 * squares / np.exp(2.0 * self.log_length))
        return np.asarray(parts @ kernel @ parts.T)


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
        Positions of the contacts (L), from any origin.

    Returns
    -------
    mean, deviation : ndarray, shape (n,)
        Of μ0; NaN beside a slip that may have gone back, where the rod cannot have it, and
        everywhere if no surface of one kind explains the travels.
    """
    slips = EnergySlips(branch, kinetic_ratio)
    try:
        values, deviation = _regressed(slips, place, travel[1:], gap)
    except np.linalg.LinAlgError:
        unknown = np.full(len(place), np.nan)
        return unknown, unknown
    n = len(place)
    mean, deviation = values[:n].copy(), deviation[:n]
    # Where a tip rests pulled, and may slip back, the relation does not hold on either side.
    end = slips.rest(slips.onset(mean[:-1]) + 0.5 * gap[:-1], values[n:])
    back = np.append(False, -branch.demand(end) > TURNS * mean[1:])
    at_bound = (mean <= LEAST) | (mean >= slips.most)
    doubtful = at_bound | back | np.append(back[1:], False) | np.append(False, back[:-1])
    mean[doubtful] = deviation[doubtful] = np.nan
    return mean, deviation


def _regressed(
    slips: EnergySlips, place: FloatArray, measured: FloatArray, gap: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Most probable frictions at n contacts, then on the n − 1 slips, and their deviations.

    Raises
    ------
    numpy.linalg.LinAlgError
        If no surface explains the travels.
    """
    n = len(place)
    values = np.full(2 * n - 1, _level(slips, measured, float(np.median(gap))))
    process = _Process(
        mean=float(values[0]), log_deviation=float(np.log(GUESS)), log_length=float(np.log(GUESS))
    )
    for _ in range(ROUNDS):
        points, parts = _averages(slips, place, values, gap)
        squares = (points[:, None] - points) ** 2
        linear = slips.linearised(values[:n], values[n:], gap)
        rest = measured - linear.travel + linear.slopes @ values
        process = _most_likely(process, linear, rest, squares, parts)
        prior = process.covariance(squares, parts)
        for _ in range(STEPS):
            linear = slips.linearised(values[:n], values[n:], gap)
            rest = measured - linear.travel + linear.slopes @ values
            spread = linear.slopes @ prior @ linear.slopes.T + linear.errors
            gain = np.linalg.solve(spread, linear.slopes @ prior).T
            found = process.mean + gain @ (rest - process.mean * linear.slopes.sum(axis=1))
            values = np.clip(found, LEAST, slips.most)
    miss = measured - slips.linearised(values[:n], values[n:], gap).travel
    miss += linear.slopes @ (values - process.mean)
    if not miss @ np.linalg.solve(spread, miss) < MOST_EXCESS * len(miss):
        raise np.linalg.LinAlgError("no surface of one kind explains the travels")
    variance = np.diag(prior - gain @ linear.slopes @ prior)
    # The surface's mean is as uncertain as the travels leave it.
    total = linear.slopes.sum(axis=1)
    over_mean = 1.0 - gain @ total
    variance = variance + over_mean**2 / (total @ np.linalg.solve(spread, total))
    return values, np.sqrt(np.maximum(variance, 0.0))


def _level(slips: EnergySlips, measured: FloatArray, step: float) -> float:
    """Friction that the median travel has on a surface with the same friction everywhere."""
    grid = np.linspace(LEAST, slips.most, 400)
    onset = slips.onset(grid)
    travels = onset - 0.5 * step - slips.rest(onset + 0.5 * step, grid)
    return float(np.median(np.interp(measured, np.maximum.accumulate(travels), grid)))


def _most_likely(
    process: _Process,
    linear: Linear,
    rest: FloatArray,
    squares: FloatArray,
    parts: FloatArray,
) -> _Process:
    """Find the process under which the travels, linear in the frictions, are most likely."""
    of_travels, sums = linear.slopes @ parts, linear.slopes.sum(axis=1)

    def unlikely(guess: FloatArray) -> float:
        spread = _Process.of(guess).covariance(squares, of_travels) + linear.errors
        if not np.isfinite(spread).all():
            raise np.linalg.LinAlgError("the travels cannot be linearised")
        factor = cho_factor(spread, lower=True)
        miss = rest - guess[0] * sums
        far = (guess[1:] - np.log(GUESS)) / np.log(FACTOR)
        size = np.log(np.diag(factor[0])).sum() + 0.5 * miss @ cho_solve(factor, miss)
        return float(size + 0.5 * far @ far)

    start = np.array([process.mean, process.log_deviation, process.log_length])
    options = {"maxiter": ITERATIONS}
    return _Process.of(minimize(unlikely, start, method="L-BFGS-B", options=options).x)


def _averages(
    slips: EnergySlips, place: FloatArray, values: FloatArray, gap: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Points on the surface, and the weights of their friction at each contact and in each slip."""
    n = len(place)
    start = slips.onset(values[: n - 1]) + 0.5 * gap[:-1]
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
