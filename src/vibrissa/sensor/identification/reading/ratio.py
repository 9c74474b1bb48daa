"""Friction as the ratio of the forces at the onset of slip, without a model of the rod.

At the onset the tip mobilises all its friction, μ0 = |fx/fy|. One sample there is noisy, and it is
up to one step too early. While the tip sticks the rod is elastic: each force is a smooth function
of the clamp position. So a polynomial of low degree is fitted to each force over the last samples
of the period, and its value at the onset, within the step after the last sticking sample, is taken.

Degree and window are chosen for all periods together. The next degree changes μ0 by δ in each
period; as the smaller fit is contained in the larger one, the variance of δ is the difference of
their variances (Hausman). So the mean of δ over all periods, with its own error, tells how far the
degree is off: it is added to μ0. Its own error, and a part of it for all higher degrees, are an
error that all periods share; by how much δ differs from period to period more than by noise is an
error of each (the random effects of a meta-analysis: DerSimonian and Laird). Of all degrees and
windows the one with the least error is taken.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.polynomial.legendre import legvander
from scipy.special import chdtrc

from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.sensor.identification.reading.jumps import Spans, direction
from vibrissa.sensor.identification.reading.uncertainty import (
    BLOCK,
    MANY,
    Summary,
    ratio_deviation,
    summary_of,
)

# Highest degree, and how often the window, at first a whole period, is halved at most.
MOST_DEGREE = 4
HALVINGS = 3
# A degree that suffices for a whole period, however long.
WHOLE_DEGREE = 9
# What all higher degrees change at most, as a part of what the next one does: for smooth forces
# each changes a tenth of what the one before does.
REST = 0.2
# A period with too few samples for a degree counts as such an error of μ0.
UNREAD = 0.1
# A fit with residuals of a lower probability than this tells nothing.
UNLIKELY = 1e-9
# Least over largest eigenvalue of a fit that its samples determine; 1e-3 if evenly spaced.
LEAST_TOLD = 1e-12
# Lengths of the window up to which a fit is asked for what is beyond it.
MOST_BEYOND = 1e3
# Parts of a window that are no distance.
ROUNDING = 1e-9
# Nodes and weights for a mean over the step.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
NODES, WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS


@dataclass(frozen=True, eq=False, kw_only=True)
class ForceFits:
    """Polynomials of one degree, fitted to the forces at the end of p periods.

    Attributes
    ----------
    coefficients : ndarray, shape (p, degree + 1, 2)
        Of Legendre polynomials of 1 + 2·t, with t from −1 at the beginning of the window to 0 in
        the last sample, for fx and fy; NaN where a period has too few samples.
    covariance : ndarray, shape (p, degree + 1, degree + 1)
        Of the coefficients, for a reading of variance 1.
    noise : ndarray, shape (2,)
        Standard deviation of one reading of each force.
    gap : ndarray, shape (p,)
        Way of the clamp to the next sample, in windows; negative where it turned back.
    chance : ndarray, shape (p,)
        Probability of such residuals, or larger ones, if the forces are such polynomials.
    """

    coefficients: FloatArray
    covariance: FloatArray
    noise: FloatArray
    gap: FloatArray
    chance: FloatArray

    @property
    def degree(self) -> int:
        """Degree of the polynomials."""
        return self.coefficients.shape[1] - 1

    def forces(self, t: FloatArray) -> FloatArray:
        """Give the forces fx and fy at places of shape (p, k), shape (2, p, k)."""
        basis = legvander(1.0 + 2.0 * t, self.degree)
        return np.asarray(np.moveaxis(basis @ self.coefficients, -1, 0))

    def ratio(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Ratio of the forces and its standard deviation at places, each of shape (p, k)."""
        basis = legvander(1.0 + 2.0 * t, self.degree)
        fx, fy = self.forces(t)
        spread = np.sqrt(((basis @ self.covariance) * basis).sum(axis=-1))
        # A recording that is not of this rod may lead a straight line through fy = 0.
        with np.errstate(divide="ignore", invalid="ignore"):
            return fx / fy, spread * ratio_deviation(fx, fy, *self.noise)

    @cached_property
    def mean(self) -> tuple[FloatArray, FloatArray]:
        """Mean ratio over the step of the onset, and the deviation by noise, shape (p,)."""
        ratio, deviation = self.ratio(self.gap[:, None] * NODES)
        return ratio @ WEIGHTS, deviation @ WEIGHTS

    @cached_property
    def by_step(self) -> FloatArray:
        """Standard deviation of the ratio by the step, in which the onset is uniform, (p,)."""
        ratio, _ = self.ratio(self.gap[:, None] * NODES)
        return np.asarray(np.sqrt((ratio - self.mean[0][:, None]) ** 2 @ WEIGHTS))

    @property
    def deviation(self) -> FloatArray:
        """Standard deviation of the ratio at the onset, by noise and step, shape (p,)."""
        return np.hypot(self.mean[1], self.by_step)

    def part(self, here: slice) -> "ForceFits":
        """Fits of some of the periods."""
        return ForceFits(
            coefficients=self.coefficients[here],
            covariance=self.covariance[here],
            noise=self.noise,
            gap=self.gap[here],
            chance=self.chance[here],
        )


@dataclass(frozen=True, kw_only=True)
class Correction:
    """What a degree that is too low changes in the ratio at the onset.

    Attributes
    ----------
    mean : float
        Over all periods; it is added. NaN where no period tells it.
    common : float
        Standard deviation of its error, which all periods share.
    own : float
        Standard deviation of what differs from period to period.
    """

    mean: float
    common: float
    own: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Onsets:
    """Ratio of the forces at the onset of slip, of p periods.

    Attributes
    ----------
    fits : ForceFits
        Of the degree and window with the least error.
    correction : Correction
        Of this degree.
    sign : ndarray, shape (p,)
        Of the ratio, by the direction in which the clamp moves when the tip slips.
    smooth : ndarray of bool, shape (p,)
        Whether the forces are smooth in the period and towards its end: no slip is hidden in it.
    """

    fits: ForceFits
    correction: Correction
    sign: FloatArray
    smooth: BoolArray

    @property
    def own(self) -> FloatArray:
        """Standard deviation of the error that is a period's own, shape (p,)."""
        return np.hypot(self.fits.deviation, self.correction.own)

    def summary(self, common: FloatArray) -> Summary:
        """Propagate step, noise and common error to μ0.

        Parameters
        ----------
        common : ndarray, shape (p,)
            Standard deviation of the error that all periods share, that of the correction included.

        Returns
        -------
        Summary
        """
        parts, further = [], np.hypot(common, self.correction.own)
        for start in range(0, len(self.sign), BLOCK):
            here = slice(start, start + BLOCK)
            fits, sign = self.fits.part(here), self.sign[here, None]
            ratio, deviation = fits.ratio(fits.gap[:, None] * MANY.onset)
            values = sign * ratio + self.correction.mean + deviation * MANY.noise
            values += further[here, None] * MANY.common
            parts.append(summary_of(np.where(values > 0.0, values, np.inf)))
        return Summary.concatenate(parts)


@dataclass(frozen=True, eq=False, kw_only=True)
class Windows:
    """Last samples of p periods.

    Attributes
    ----------
    period, row : ndarray of int, shape (n,)
        Of each sample in a window: its period, and its row in the recording.
    place : ndarray, shape (n,)
        Clamp position from the last sample, in lengths of the window: −1 to 0, above 0 where the
        clamp had been further and turned.
    length : ndarray, shape (p,)
        Of the window, negative where the clamp moves backward; 0 where it does not move.
    positions : ndarray of int, shape (p,)
        Different clamp positions in it.
    """

    period: IntArray
    row: IntArray
    place: FloatArray
    length: FloatArray
    positions: IntArray

    @classmethod
    def of(cls, clamp: FloatArray, spans: Spans, part: float) -> "Windows":
        """Take the last samples of each period, within a way of the clamp from the last one.

        The way is a part of that of most periods: as long in each of them, so that one degree suits
        all.
        """
        counts = spans.ends - spans.begins + 1
        period = np.repeat(np.arange(len(counts)), counts)
        row = np.arange(len(period)) + np.repeat(spans.begins - np.cumsum(counts) + counts, counts)
        way = clamp[row] - clamp[spans.ends][period]
        starts = np.cumsum(counts) - counts
        # Signed, so that the places in the window are negative whichever way the clamp moved.
        length = np.maximum.reduceat(np.abs(way), starts)
        length = np.minimum(length, part * np.median(length))
        length *= np.where(np.add.reduceat(way, starts) > 0.0, -1.0, 1.0)
        near = np.abs(way) <= np.abs(length)[period] * (1.0 + ROUNDING)
        period, row, way = period[near], row[near], way[near]
        moves = length[period] != 0.0
        place = np.divide(way, length[period], out=np.zeros_like(way), where=moves)
        order = np.lexsort((place, period))
        new = np.diff(place[order], prepend=-np.inf) > ROUNDING
        new |= np.diff(period[order], prepend=-1) != 0
        return cls(
            period=period,
            row=row,
            place=place,
            length=length,
            positions=np.bincount(period[order][new], minlength=len(counts)),
        )


def fitted_forces(
    windows: Windows, forces: FloatArray, noise: FloatArray, gap: FloatArray, degree: int
) -> ForceFits:
    """Fit polynomials to the forces in windows, by least squares.

    Parameters
    ----------
    windows : Windows
        Of p periods.
    forces : ndarray, shape (n, 2)
        fx and fy of all samples of the recording.
    noise : ndarray, shape (2,)
    gap : ndarray, shape (p,)
        Way of the clamp from the last sample to the next one.
    degree : int

    Returns
    -------
    ForceFits
    """
    size = len(gap)
    starts = np.searchsorted(windows.period, np.arange(size))
    basis = legvander(1.0 + 2.0 * windows.place, degree)
    values = forces[windows.row]
    information = np.add.reduceat(basis[:, :, None] * basis[:, None, :], starts)
    # Positions that are different, but next to each other beside one that is far off, do not do.
    sizes = np.linalg.eigvalsh(information)
    enough = (windows.positions > degree) & (sizes[:, 0] > LEAST_TOLD * sizes[:, -1])
    enough &= np.abs(gap) < MOST_BEYOND * np.abs(windows.length)
    information[~enough] = np.eye(degree + 1)
    covariance = np.linalg.inv(information)
    products = np.add.reduceat(basis[:, :, None] * values[:, None, :], starts)
    coefficients = covariance @ products
    miss = (values - (basis[:, :, None] * coefficients[windows.period]).sum(axis=1)) / noise
    squares = np.add.reduceat((miss**2).sum(axis=1), starts)
    degrees = 2 * (np.bincount(windows.period, minlength=size) - degree - 1)
    coefficients[~enough] = np.nan
    chance = np.where(degrees > 0, chdtrc(np.maximum(degrees, 1), squares), 1.0)
    return ForceFits(
        coefficients=coefficients,
        covariance=covariance,
        noise=noise,
        gap=np.divide(gap, windows.length, out=np.zeros(size), where=enough),
        chance=np.where(enough, chance, 1.0),
    )


def read_onsets(clamp: FloatArray, forces: FloatArray, noise: FloatArray, spans: Spans) -> Onsets:
    """Read the ratio of the forces at the onset of slip that ends each period.

    Parameters
    ----------
    clamp : ndarray, shape (n,)
    forces : ndarray, shape (n, 2)
        fx and fy.
    noise : ndarray, shape (2,)
        Standard deviation of one reading of each.
    spans : Spans
        p periods.

    Returns
    -------
    Onsets
    """
    after = np.minimum(spans.ends + 1, len(clamp) - 1)
    gap = np.where(spans.cut, 0.0, clamp[after] - clamp[spans.ends])
    sign = np.where(gap == 0.0, direction(clamp)[spans.ends - 1], np.sign(gap))
    whole = fitted_forces(Windows.of(clamp, spans, np.inf), forces, noise, gap, WHOLE_DEGREE)
    candidates = []
    for halving in range(HALVINGS + 1):
        windows = Windows.of(clamp, spans, 0.5**halving)
        fits = [
            fitted_forces(windows, forces, noise, gap, degree)
            for degree in range(1, MOST_DEGREE + 2)
        ]
        candidates += [
            Onsets(
                fits=low,
                correction=_correction(low, high, sign),
                sign=sign,
                smooth=np.minimum(low.chance, whole.chance) > UNLIKELY,
            )
            for low, high in pairwise(fits)
        ]

    def error(found: Onsets) -> float:
        own = np.nan_to_num(found.own, nan=UNREAD)
        return float((own**2).mean() + found.correction.common**2)

    told = [found for found in candidates if np.isfinite(found.correction.mean)]
    return min(told, key=error, default=candidates[0])


def _correction(low: ForceFits, high: ForceFits, sign: FloatArray) -> Correction:
    """Compare a degree with the next one."""
    change = sign * (high.mean[0] - low.mean[0])
    variance = high.mean[1] ** 2 - low.mean[1] ** 2
    told = (variance > 0.0) & (high.chance > UNLIKELY)
    if not told.any():
        return Correction(mean=np.nan, common=np.nan, own=np.nan)
    change, weight = change[told], 1.0 / variance[told]
    mean = (weight * change).sum() / weight.sum()
    excess = (weight * (change - mean) ** 2).sum() - (len(weight) - 1)
    free = weight.sum() - (weight**2).sum() / weight.sum()
    between = max(excess / free, 0.0) if free > 0.0 else 0.0
    weight = 1.0 / (variance[told] + between)
    mean = float((weight * change).sum() / weight.sum())
    return Correction(
        mean=mean,
        common=float(np.hypot(weight.sum() ** -0.5, REST * mean)),
        own=float(np.sqrt(between)),
    )
