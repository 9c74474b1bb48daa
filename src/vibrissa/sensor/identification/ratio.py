"""Friction without a rod: the ratio of the forces at the onset of slip, μ0 = |fx/fy|.

A polynomial is fitted to each force over the last samples of a period, and evaluated at the onset.
The degree is the same in all periods: the one with the least error of μ0. In each period the
next higher degree gives another μ0. The variance of this change is the difference of the
variances of both values of μ0 (Hausman). The mean change over the periods is added to each μ0.
The scatter of the changes beyond noise is an error of each period (DerSimonian and Laird).
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.polynomial.legendre import legvander
from scipy.special import chdtrc

from vibrissa.errors import MixedColumnsError, RecordingError
from vibrissa.numerics.arrays import FloatArray, StrArray
from vibrissa.sensor.identification.blocks import Blocks
from vibrissa.sensor.identification.goodness import estimates_of
from vibrissa.sensor.identification.parameters import BEARING, Parameter, ScanRows
from vibrissa.sensor.identification.periods import Check, Grade, PeriodStatus, periods_of
from vibrissa.sensor.identification.propagation import (
    HALF_WIDTH,
    common_deviation,
    variance_between,
)
from vibrissa.sensor.identification.recording import FORCES
from vibrissa.sensor.identification.result import Identification
from vibrissa.sensor.identification.slips import PeriodEnds, check_slips
from vibrissa.sensor.identification.task import Task

# Highest degree that is chosen.
MOST_DEGREE = 6
# Largest change of μ0 by all further degrees, as a part of the change by the next degree. For
# smooth forces the change by each degree is a tenth of that by the degree before.
FURTHER_DEGREES = 0.2
# Error of μ0 that is assumed for a period with too few samples for a degree.
UNREAD_ERROR = 0.1
# Probability of its residuals below which a fit is not used.
UNLIKELY_FIT = 1e-9
# Least ratio of the smallest to the largest eigenvalue of a fit that is determined by its samples;
# with evenly spaced samples it is 1e-3.
LEAST_DETERMINED = 1e-12
# Largest distance of an extrapolation, in lengths of the window.
MOST_BEYOND = 1e3
# Part of a window that is rounding, not a distance.
ROUNDED_PART_OF_WINDOW = 1e-9
# Beginning, middle and end of the step in which the tip slips.
PLACES_IN_STEP = np.array([0.0, 0.5, 1.0])
# Places in a window, from its beginning to the last sample. The tip has locked if the ratio at one
# of them is larger than at the last sample by CERTAIN_DEVIATIONS standard deviations.
PLACES_IN_WINDOW = np.linspace(-1.0, 0.0, 9)
CERTAIN_DEVIATIONS = 6.0
# Least normal force with which the tip presses on the surface, in standard deviations.
PRESSING_DEVIATIONS = 10.0
# If more than this part of the periods end past a lock, the forces may be swapped.
MOST_LOCK = 0.5


@dataclass(frozen=True, eq=False, kw_only=True)
class Onsets:
    """Ratio of the forces at the end of p periods, by polynomials of the same degree in all.

    Attributes
    ----------
    coefficients : ndarray, shape (p, degree + 1, 2)
        Coefficients of Legendre polynomials of 1 + 2·t for fx and fy, where t is −1 at the
        beginning of the window and 0 in the last sample; NaN if a period has too few samples.
    covariance : ndarray, shape (p, degree + 1, degree + 1)
        Covariance of the coefficients of one force, if one reading has the variance 1.
    noise : ndarray, shape (2,)
        Standard deviation of one reading of fx and fy.
    step : ndarray, shape (p, 3)
        t at which the readings, with their lag, show the beginning, the middle and the end of the
        step in which the tip slips.
    chance : ndarray, shape (p,)
        Probability of residuals at least as large as these, if the forces are such polynomials.
    change, between, shared : float
        `change` is the mean over the periods of the change of μ0 from this degree to the next.
        `between` is the variance of this change among the periods, beyond noise. `shared` is the
        standard deviation of the mean; it includes the effect of all further degrees.
    """

    coefficients: FloatArray
    covariance: FloatArray
    noise: FloatArray
    step: FloatArray
    chance: FloatArray
    change: float = 0.0
    between: float = 0.0
    shared: float = UNREAD_ERROR

    def ratio(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Ratio of the forces at k values of t, and its standard deviation, each shape (p, k)."""
        basis = legvander(1.0 + 2.0 * t, self.coefficients.shape[1] - 1)
        fx, fy = np.moveaxis(basis @ self.coefficients, -1, 0)
        spread = np.sqrt(((basis @ self.covariance) * basis).sum(axis=-1))
        # The extrapolated fy may be 0, if the forces are not those of a rod.
        with np.errstate(divide="ignore", invalid="ignore"):
            return fx / fy, spread * deviation_of(fx / fy, fy, self.noise)

    @cached_property
    def _read(self) -> tuple[FloatArray, FloatArray]:
        return self.ratio(self.step)

    @property
    def along(self) -> FloatArray:
        """Friction at start, middle and end of the step in which the tip slips, shape (p, 3)."""
        return self._read[0] + self.change

    @property
    def own(self) -> FloatArray:
        """Standard deviation of μ0 due to noise and a degree that is too low, shape (p,)."""
        return np.asarray(np.hypot(self._read[1][:, 1], np.sqrt(self.between)))

    @property
    def error(self) -> float:
        """Mean square error of μ0 over all periods."""
        by_step = (self.along[:, 2] - self.along[:, 0]) / np.sqrt(12.0)
        own = np.nan_to_num(np.hypot(self.own, by_step), nan=UNREAD_ERROR)
        return float((own**2).mean() + self.shared**2)


def deviation_of(ratio: FloatArray, fy: FloatArray, noise: FloatArray) -> FloatArray:
    """Return the standard deviation of the ratio of one fx to one fy, due to their noise."""
    return np.asarray(np.hypot(noise[0], ratio * noise[1]) / np.abs(fy))


def in_window(blocks: Blocks, ends: PeriodEnds) -> tuple[Blocks, FloatArray]:
    """Select the blocks in a window at the end of each period.

    The window is as long as the travel in the period, but not longer than the median travel.

    Returns
    -------
    window : Blocks
        The selected blocks with the readings fx and fy; where the clamp moves backward, fx has the
        opposite sign. In place of clamp positions they have t: −1 at the beginning of the window, 0
        in the last sample, above 0 where the clamp was beyond its last position and turned back.
    length : ndarray, shape (p,)
        Length of the window (L); negative if the clamp moves backward, 0 if it does not move.
    """
    way = blocks.clamp - ends.clamp[blocks.period]
    length = np.maximum.reduceat(np.abs(way), blocks.starts)
    length = np.minimum(length, np.median(length))
    # Signed, so that the places in the window are negative whichever way the clamp moved.
    length *= np.where(blocks.sums(way) > 0.0, -1.0, 1.0)
    near = np.abs(way) <= np.abs(length)[blocks.period] * (1.0 + ROUNDED_PART_OF_WINDOW)
    # The last block always belongs to the window, even if the clamp turned.
    near[np.append(blocks.starts[1:], len(blocks)) - 1] = True
    window = blocks.take(near)
    size = np.where(length == 0.0, 1.0, length)
    forward = np.column_stack([ends.sign, np.ones(len(ends))])
    return replace(
        window,
        clamp=way[near] / size[window.period],
        readings=window.readings[:, FORCES] * forward[window.period],
    ), length


def fitted_forces(window: Blocks, noise: FloatArray, step: FloatArray, degree: int) -> Onsets:
    """Fit polynomials of a given degree to both forces in each window, by least squares."""
    root = np.sqrt(window.count)[:, None]
    basis = legvander(1.0 + 2.0 * window.clamp, degree) * root
    values = window.readings * root
    information = window.sums(basis[:, :, None] * basis[:, None, :])
    # Different positions do not suffice if they are close together, except for one far away.
    sizes = np.linalg.eigvalsh(information)
    enough = (sizes[:, 0] > LEAST_DETERMINED * sizes[:, -1]) & np.isfinite(step[:, 1])
    information[~enough] = np.eye(degree + 1)
    covariance = np.asarray(np.linalg.inv(information), dtype=float)
    coefficients = covariance @ window.sums(basis[:, :, None] * values[:, None, :])
    miss = (values - (basis[:, :, None] * coefficients[window.period]).sum(axis=1)) / noise
    squares = window.sums((miss**2).sum(axis=1))
    degrees = 2 * (np.bincount(window.period) - degree - 1)
    chance = chdtrc(np.maximum(degrees, 1), squares)
    coefficients[~enough] = np.nan
    return Onsets(
        coefficients=coefficients,
        covariance=covariance,
        noise=noise,
        step=step,
        chance=np.where(enough & (degrees > 0), chance, 1.0),
    )


def read_onsets(task: Task) -> tuple[Onsets, FloatArray]:
    """Estimate the ratio of the forces at each onset of slip, and its standard deviation, (p,).

    Polynomials of a degree n give a ratio. The mean change of the ratio from degree n to n + 1
    is added to it. The degree n with the least error of this sum is used.
    """
    ends = task.ends
    position = task.recording.position
    gap = np.where(task.spans.cut, 0.0, ends.gap)
    window, length = in_window(task.blocks, ends)
    length = np.where(np.abs(gap) < MOST_BEYOND * np.abs(length), length, np.nan)
    step = (task.recording.lag[task.spans.ends] + gap * PLACES_IN_STEP[:, None]).T / length[:, None]
    noise = task.noise[FORCES]
    if position:
        # Noise of the positions acts as noise of the forces, which grow with the position.
        straight = fitted_forces(window, noise, step, 1).coefficients[:, 1]
        growth = np.nanmedian(np.abs(2.0 * straight / length[:, None]), axis=0)
        noise = np.hypot(noise, np.nan_to_num(growth) * position)
    fits = [fitted_forces(window, noise, step, n) for n in range(1, MOST_DEGREE + 2)]
    corrected = [_corrected(low, high) for low, high in pairwise(fits)]
    chosen = min(range(MOST_DEGREE), key=lambda n: corrected[n].error)
    # Many samples refute even a good polynomial: a slip is hidden where none fits of those that
    # have no more coefficients than half of the samples.
    half = int(np.median(np.bincount(window.period))) // 2
    tested = fits[chosen : max(half - 1, chosen + 1)]
    likely = min(tested, key=lambda fit: int((fit.chance <= UNLIKELY_FIT).sum()))
    best = replace(corrected[chosen], chance=likely.chance)
    # The middle of the step in which the tip slips is the mean of two positions.
    way = np.where(gap != 0.0, np.abs(gap), np.inf)
    by_position = np.abs(best.along[:, 2] - best.along[:, 0]) / way * position / np.sqrt(2.0)
    return best, np.hypot(best.own, by_position)


def _corrected(low: Onsets, high: Onsets) -> Onsets:
    """Add to μ0 by `low` the mean change to μ0 by `high`, both in the middle of the step."""
    change = (high.along - low.along)[:, 1]
    variance = high.own**2 - low.own**2
    informative = (variance > 0.0) & (high.chance > UNLIKELY_FIT)
    if not informative.any():
        return low
    change = change[informative]
    variance = variance[informative]
    between, _ = variance_between(change, variance)
    weight = 1.0 / (variance + between)
    mean = float((weight * change).sum() / weight.sum())
    shared = float(np.hypot(weight.sum() ** -0.5, FURTHER_DEGREES * mean))
    return replace(low, change=mean, between=between, shared=shared)


def read_ratio(task: Task) -> Identification:
    """Estimate the friction of the periods of a recording by the ratio of the forces.

    Raises
    ------
    RecordingError
        If a force has no noise, is constant or of the wrong sign, or if the forces seem swapped.
    """
    if not task.both_forces:
        raise RecordingError("the method ratio needs both forces, and a noise above 0 for each")
    forces = task.recording.readings[:, FORCES]
    noise = task.noise[FORCES]
    check_slips(task.recording, task.spans, task.noise)
    check_forces(forces, noise)
    onsets, own = read_onsets(task)
    parameters = [
        parameter
        for parameter in task.parameters
        if parameter.of in BEARING and parameter.deviation > 0.0
    ]
    # The error due to the degree of the polynomials is common to all periods, too.
    mu0 = onsets.along[:, 1]
    effects = np.column_stack(
        [*(_effect(task, mu0, parameter) for parameter in parameters), np.ones(len(mu0))]
    )
    covariance = np.diag([*(parameter.deviation**2 for parameter in parameters), onsets.shared**2])
    common = common_deviation(effects, covariance)
    periods = periods_of(task, onsets.along, own, common, effects)
    status, least = _statuses(onsets, task)
    _check_axes(forces, status)
    hidden = "the forces do not follow a smooth curve: a slip may be hidden"
    against = "the tip cannot slip in this direction"
    return Identification(
        recording=task.recording,
        periods=periods.ended(status, least - HALF_WIDTH * common).doubted(
            Check(Grade.WRONG, onsets.chance <= UNLIKELY_FIT, hidden),
            Check(Grade.WRONG, status == PeriodStatus.BEYOND, against),
        ),
        units=task.units,
        by_model=False,
        estimates=estimates_of(parameters, np.zeros(len(parameters)), covariance[:-1, :-1]),
        covariance=covariance,
        slope=task.slope,
    )


def _effect(task: Task, mu0: FloatArray, parameter: Parameter) -> FloatArray:
    """Change of the friction per unit of a parameter, shape (p,): −(δfx − (fx/fy)·δfy)/fy."""
    ends = task.spans.ends
    if parameter.effect is None:
        return np.zeros(len(ends))
    # A moment that was not recorded is taken as 1, the full scale to which crosstalk refers.
    loads = np.nan_to_num(task.recording.readings[ends], nan=1.0)
    fx, fy, _ = parameter.effect(loads, ScanRows.of(ends, len(task.recording))).T
    return np.nan_to_num(-(task.ends.sign * fx - mu0 * fy) / loads[:, 1])


def check_forces(forces: FloatArray, noise: FloatArray) -> None:
    """Refuse a recording with fx constant, or fy of the wrong sign.

    Raises
    ------
    RecordingError
    """
    if not np.ptp(forces[:, 0]):
        raise RecordingError("force_x has one value in all rows: the channel was not recorded")
    if np.median(forces[:, 1]) > -noise[1]:
        raise RecordingError(
            "force_y is not negative: its sign is wrong, or it was not recorded. It is the load of "
            "the rod on the clamp, negative where the rod presses against the surface"
        )


def _check_axes(forces: FloatArray, status: StrArray) -> None:
    """Refuse a recording of swapped forces: a large ratio that falls in most periods."""
    tangential, normal = np.median(np.abs(forces), axis=0)
    locked = int((status == PeriodStatus.LOCK).sum())
    if locked > max(2, MOST_LOCK * len(status)) and tangential > normal:
        raise MixedColumnsError(
            f"in {locked} of {len(status)} periods force_x / force_y falls until the tip slips: "
            "the columns force_x and force_y seem to be swapped. force_x is along the surface, "
            "force_y normal to the surface"
        )


def _statuses(onsets: Onsets, task: Task) -> tuple[StrArray, FloatArray]:
    """Status of each period, and a lower bound of its μ0."""
    spans = task.spans
    noise = task.noise[FORCES]
    ratio, deviation = onsets.ratio(PLACES_IN_WINDOW)
    # Without enough samples for a polynomial, the last sample alone gives a ratio.
    fx, fy = task.recording.readings[spans.ends][:, FORCES].T
    presses = fy < -PRESSING_DEVIATIONS * noise[1]
    alone = task.ends.sign * fx / np.where(presses, fy, np.nan)
    error = deviation_of(alone, fy, noise)
    fallen = (ratio - ratio[:, -1:]) > CERTAIN_DEVIATIONS * np.hypot(deviation, deviation[:, -1:])
    locked = fallen.any(axis=1) | spans.swung
    curve = ratio - HALF_WIDTH * deviation
    least = np.fmax(alone - HALF_WIDTH * error, curve[:, -1])
    peak = np.max(np.nan_to_num(curve, nan=-np.inf), axis=1)
    status = np.select(
        [
            least < -CERTAIN_DEVIATIONS * error,
            locked,
            spans.cut | spans.opened,
            np.isnan(onsets.along[:, 1]) | ~presses,
        ],
        [PeriodStatus.BEYOND, PeriodStatus.LOCK, PeriodStatus.OPEN, PeriodStatus.UNSURE],
        PeriodStatus.SLIP,
    )
    return status, np.where(locked, np.fmax(least, peak), least)
