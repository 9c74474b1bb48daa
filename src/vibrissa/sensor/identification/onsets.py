"""The ratio of the forces at the onset of slip, without a model of the rod.

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
from vibrissa.numerics.batch import Batch
from vibrissa.sensor.identification.blocks import Blocks
from vibrissa.sensor.identification.uncertainty import (
    BLOCK,
    COMMON,
    NOISE,
    ONSET,
    Summary,
    ratio_deviation,
    summary_of,
    variance_between,
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
# Part of a window over which a slope is taken.
NEAR = 1e-3
# Nodes and weights for a mean over the step.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
NODES, WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS


@dataclass(frozen=True, eq=False, kw_only=True)
class ForceFits(Batch):
    """Polynomials of one degree, fitted to the forces at the end of p periods.

    Attributes
    ----------
    coefficients : ndarray, shape (p, degree + 1, 2)
        Of Legendre polynomials of 1 + 2·t, with t from −1 at the beginning of the window to 0 in
        the last sample, for fx and fy; NaN where a period has too few samples.
    covariance : ndarray, shape (p, degree + 1, degree + 1)
        Of the coefficients, for a reading of variance 1.
    noise : tuple of float
        Standard deviation of one reading of each force.
    lag, gap, position : ndarray, shape (p,)
        In windows: way of the clamp by which the readings lag, and to the next sample (negative
        where it turned back), and the standard deviation of its position.
    length : ndarray, shape (p,)
        Of the windows.
    chance : ndarray, shape (p,)
        Probability of such residuals, or larger ones, if the forces are such polynomials.
    """

    coefficients: FloatArray
    covariance: FloatArray
    noise: tuple[float, float]
    lag: FloatArray
    gap: FloatArray
    position: FloatArray
    length: FloatArray
    chance: FloatArray

    @property
    def degree(self) -> int:
        """Degree of the polynomials."""
        return self.coefficients.shape[1] - 1

    def forces(self, t: FloatArray) -> FloatArray:
        """Give the forces fx and fy at places of shape (p, k), shape (2, p, k)."""
        basis = legvander(1.0 + 2.0 * t, self.degree)
        return np.asarray(np.moveaxis(basis @ self.coefficients, -1, 0))

    @property
    def growth(self) -> FloatArray:
        """Slope of the forces over the place of the clamp, of polynomials of degree 1, (p, 2)."""
        # The first sample is a window before the last one.
        return np.asarray(2.0 * self.coefficients[:, 1] / self.length[:, None])

    def ratio(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Ratio of the forces and its standard deviation at places, each of shape (p, k)."""
        basis = legvander(1.0 + 2.0 * t, self.degree)
        fx, fy = self.forces(t)
        spread = np.sqrt(((basis @ self.covariance) * basis).sum(axis=-1))
        # A recording that is not of this rod may lead a straight line through fy = 0.
        with np.errstate(divide="ignore", invalid="ignore"):
            return fx / fy, spread * ratio_deviation(fx, fy, *self.noise)

    @cached_property
    def mean(self) -> FloatArray:
        """Mean ratio over the step of the onset, shape (p,)."""
        return np.asarray(self.ratio(self.within(NODES))[0] @ WEIGHTS)

    @cached_property
    def by_noise(self) -> FloatArray:
        """Standard deviation of the mean ratio by noise, shape (p,)."""
        return np.asarray(self.ratio(self.within(NODES))[1] @ WEIGHTS)

    @cached_property
    def by_step(self) -> FloatArray:
        """Standard deviation of the ratio by the step, in which the onset is uniform, (p,)."""
        ratio, _ = self.ratio(self.within(NODES))
        return np.asarray(np.sqrt((ratio - self.mean[:, None]) ** 2 @ WEIGHTS))

    @cached_property
    def slope(self) -> FloatArray:
        """Change of the ratio per window at the last sample, shape (p,)."""
        near = self.lag[:, None] + np.array([-NEAR, NEAR])
        return np.asarray(np.diff(self.ratio(near)[0])[:, 0] / (2.0 * NEAR))

    @property
    def deviation(self) -> FloatArray:
        """Standard deviation of the ratio at the onset, by noise and step, shape (p,)."""
        by_position = self.slope * self.position
        return np.asarray(np.hypot(np.hypot(self.by_noise, by_position), self.by_step))

    def within(self, part: FloatArray) -> FloatArray:
        """Places in the window at parts of the step, shape (p, k)."""
        return self.lag[:, None] + self.gap[:, None] * part


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
            fits, sign = self.fits.take(here), self.sign[here, None]
            ratio, deviation = fits.ratio(fits.within(ONSET))
            deviation = np.hypot(deviation, (fits.slope * fits.position)[:, None])
            values = sign * ratio + self.correction.mean + deviation * NOISE
            values += further[here, None] * COMMON
            parts.append(summary_of(np.where(values > 0.0, values, np.inf)))
        return Summary.concatenate(parts)


@dataclass(frozen=True, eq=False, kw_only=True)
class Ends:
    """How p periods end.

    Attributes
    ----------
    clamp, gap : ndarray, shape (p,)
        Clamp position in the last sample, and its way to the first sample after the slip.
    sign : ndarray, shape (p,)
        1 where the clamp moves forward as the tip slips, −1 where backward.
    lag : ndarray, shape (p,)
        Way of the clamp by which the readings lag.
    position : float
        Standard deviation of a clamp position.
    """

    clamp: FloatArray
    gap: FloatArray
    sign: FloatArray
    lag: FloatArray
    position: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Windows:
    """Last samples of p periods.

    Attributes
    ----------
    blocks : Blocks
        Those in a window.
    place : ndarray, shape (n,)
        Clamp position from the last sample, in lengths of the window: −1 to 0, above 0 where the
        clamp had been further and turned.
    length : ndarray, shape (p,)
        Of the window, negative where the clamp moves backward; 0 where it does not move.
    positions : ndarray of int, shape (p,)
        Different clamp positions in it.
    """

    blocks: Blocks
    place: FloatArray
    length: FloatArray
    positions: IntArray

    @classmethod
    def of(cls, blocks: Blocks, ends: Ends, part: float) -> "Windows":
        """Take the last samples of each period, within a way of the clamp from the last one.

        The way is a part of that of most periods: as long in each of them, so that one degree suits
        all.
        """
        way = blocks.clamp - ends.clamp[blocks.period]
        # Signed, so that the places in the window are negative whichever way the clamp moved.
        length = np.maximum.reduceat(np.abs(way), blocks.starts)
        length = np.minimum(length, part * np.median(length))
        length *= np.where(blocks.sums(way) > 0.0, -1.0, 1.0)
        near = np.abs(way) <= np.abs(length)[blocks.period] * (1.0 + ROUNDING)
        # The last one is there even of a clamp that turned.
        near[np.append(blocks.starts[1:], len(blocks)) - 1] = True
        blocks, way = blocks.take(near), way[near]
        period = blocks.period
        moves = length[period] != 0.0
        place = np.divide(way, length[period], out=np.zeros_like(way), where=moves)
        order = np.lexsort((place, period))
        new = np.diff(place[order], prepend=-np.inf) > ROUNDING
        new |= np.diff(period[order], prepend=-1) != 0
        positions = np.bincount(period[order][new], minlength=len(length))
        return cls(blocks=blocks, place=place, length=length, positions=positions)


def fitted_forces(windows: Windows, noise: FloatArray, ends: Ends, degree: int) -> ForceFits:
    """Fit polynomials to the forces in windows, by least squares.

    Parameters
    ----------
    windows : Windows
        Of p periods.
    noise : ndarray, shape (2,)
        Standard deviation of one reading of each force.
    ends : Ends
    degree : int
    """
    blocks, gap, length = windows.blocks, ends.gap, windows.length
    root = np.sqrt(blocks.count)[:, None]
    basis = legvander(1.0 + 2.0 * windows.place, degree) * root
    values = blocks.readings[:, :2] * root
    information = blocks.sums(basis[:, :, None] * basis[:, None, :])
    # Positions that are different, but next to each other beside one that is far off, do not do.
    sizes = np.linalg.eigvalsh(information)
    enough = (windows.positions > degree) & (sizes[:, 0] > LEAST_TOLD * sizes[:, -1])
    enough &= np.abs(gap) < MOST_BEYOND * np.abs(length)
    information[~enough] = np.eye(degree + 1)
    covariance = np.asarray(np.linalg.inv(information), dtype=float)
    coefficients = covariance @ blocks.sums(basis[:, :, None] * values[:, None, :])
    miss = (values - (basis[:, :, None] * coefficients[blocks.period]).sum(axis=1)) / noise
    squares = blocks.sums((miss**2).sum(axis=1))
    degrees = 2 * (np.bincount(blocks.period) - degree - 1)
    coefficients[~enough] = np.nan
    chance = np.where(degrees > 0, chdtrc(np.maximum(degrees, 1), squares), 1.0)

    def in_windows(way: FloatArray) -> FloatArray:
        return np.divide(way, length, out=np.zeros(len(gap)), where=enough)

    return ForceFits(
        coefficients=coefficients,
        covariance=covariance,
        noise=(float(noise[0]), float(noise[1])),
        lag=in_windows(ends.lag),
        gap=in_windows(gap),
        position=np.abs(in_windows(np.full(len(gap), ends.position))),
        length=np.where(enough, length, np.nan),
        chance=np.where(enough, chance, 1.0),
    )


def read_onsets(blocks: Blocks, noise: FloatArray, ends: Ends) -> Onsets:
    """Read the ratio of the forces at the onset of slip that ends each period.

    Parameters
    ----------
    blocks : Blocks
        Of p periods.
    noise : ndarray, shape (2,)
        Standard deviation of one reading of each force.
    ends : Ends
    """
    # Noise of the positions is one of the forces, too: by how they grow with the clamp.
    straight = fitted_forces(Windows.of(blocks, ends, np.inf), noise, ends, 1)
    growth = np.nanmedian(np.abs(straight.growth), axis=0)
    noise = np.hypot(noise, np.nan_to_num(growth) * ends.position)
    whole = fitted_forces(Windows.of(blocks, ends, np.inf), noise, ends, WHOLE_DEGREE)
    candidates = []
    for halving in range(HALVINGS + 1):
        windows = Windows.of(blocks, ends, 0.5**halving)
        fits = [fitted_forces(windows, noise, ends, degree) for degree in range(1, MOST_DEGREE + 2)]
        candidates += [
            Onsets(
                fits=low,
                correction=_correction(low, high, ends.sign),
                sign=ends.sign,
                smooth=np.minimum(low.chance, whole.chance) > UNLIKELY,
            )
            for low, high in pairwise(fits)
        ]

    def error(found: Onsets) -> float:
        own = np.nan_to_num(found.own, nan=UNREAD)
        return float((own**2).mean() + found.correction.common**2)

    known = [found for found in candidates if np.isfinite(found.correction.mean)]
    return min(known, key=error, default=candidates[0])


def _correction(low: ForceFits, high: ForceFits, sign: FloatArray) -> Correction:
    """Compare a degree with the next one."""
    change = sign * (high.mean - low.mean)
    variance = high.by_noise**2 - low.by_noise**2
    told = (variance > 0.0) & (high.chance > UNLIKELY)
    if not told.any():
        return Correction(mean=np.nan, common=np.nan, own=np.nan)
    change, variance = change[told], variance[told]
    between, _ = variance_between(change, variance)
    weight = 1.0 / (variance + between)
    mean = float((weight * change).sum() / weight.sum())
    return Correction(
        mean=mean,
        common=float(np.hypot(weight.sum() ** -0.5, REST * mean)),
        own=float(np.sqrt(between)),
    )
