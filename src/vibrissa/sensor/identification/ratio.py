"""Reading without a rod: the ratio of the forces at the onset of slip, μ0 = |fx/fy|.

A polynomial is fitted to each force over the last samples of a period, and read at the onset.
All periods share its degree: that with the least error. The mean change of μ0 by the next degree,
whose variance is the difference of the two variances (Hausman), is added to μ0; what scatters
beyond noise is an error of each period (DerSimonian and Laird).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.polynomial.legendre import legvander
from scipy.special import chdtrc

from vibrissa.errors import MixedColumnsError, RecordingError
from vibrissa.numerics.arrays import FloatArray, StrArray
from vibrissa.numerics.batch import Batch
from vibrissa.sensor.identification.blocks import Blocks
from vibrissa.sensor.identification.goodness import estimates_of
from vibrissa.sensor.identification.parameters import BEARING, Parameter
from vibrissa.sensor.identification.periods import Check, Grade, PeriodStatus, periods_of
from vibrissa.sensor.identification.recording import FORCES, MOMENT
from vibrissa.sensor.identification.result import Identification
from vibrissa.sensor.identification.slips import Ends, Slipped
from vibrissa.sensor.identification.task import Task
from vibrissa.sensor.identification.uncertainty import (
    HALF_WIDTH,
    common_deviation,
    ratio_deviation,
    summary_of,
    variance_between,
)

# Highest degree that is chosen.
MOST_DEGREE = 6
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
# The step to the slip: its beginning, middle and end.
STEP = np.array([0.0, 0.5, 1.0])
# Places in a window, from its beginning to the last sample, where the ratio is looked at, and by
# how many standard deviations it has been larger there if the tip has locked.
PLACES = np.linspace(-1.0, 0.0, 9)
CERTAIN = 6.0
# A normal force of fewer standard deviations is none.
PRESSES = 10.0
# From more than this part of the periods on that end past a lock forces are swapped.
MOST_LOCK = 0.5


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
    step : ndarray, shape (p, 3)
        Beginning, middle and end of the step to the slip, in windows from the last sample; later
        by what the readings lag.
    length : ndarray, shape (p,)
        Of the windows.
    chance : ndarray, shape (p,)
        Probability of such residuals, or larger ones, if the forces are such polynomials.
    """

    coefficients: FloatArray
    covariance: FloatArray
    noise: tuple[float, float]
    step: FloatArray
    length: FloatArray
    chance: FloatArray

    def ratio(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Ratio of the forces and its standard deviation at places, each of shape (p, k)."""
        basis = legvander(1.0 + 2.0 * t, self.coefficients.shape[1] - 1)
        fx, fy = np.moveaxis(basis @ self.coefficients, -1, 0)
        spread = np.sqrt(((basis @ self.covariance) * basis).sum(axis=-1))
        # A recording that is not of this rod may lead a straight line through fy = 0.
        with np.errstate(divide="ignore", invalid="ignore"):
            return fx / fy, spread * ratio_deviation(fx, fy, *self.noise)

    @cached_property
    def along(self) -> tuple[FloatArray, FloatArray]:
        """Ratio and its deviation over the step to the slip, shape (p, 3)."""
        return self.ratio(self.step)


@dataclass(frozen=True, eq=False, kw_only=True)
class Onsets:
    """Ratio of the forces at the onset of slip, of p periods.

    Attributes
    ----------
    along : ndarray, shape (p, 3)
        Friction at the beginning, in the middle and at the end of the step.
    own : ndarray, shape (p,)
        Standard deviation of its error by noise, and by what a degree that is too low changes from
        period to period.
    """

    fits: ForceFits
    along: FloatArray
    own: FloatArray
    shared: float

    @property
    def error(self) -> float:
        """Mean square of all errors."""
        by_step = (self.along[:, 2] - self.along[:, 0]) / np.sqrt(12.0)
        own = np.nan_to_num(np.hypot(self.own, by_step), nan=UNREAD)
        return float((own**2).mean() + self.shared**2)


def in_window(blocks: Blocks, ends: Ends) -> tuple[Blocks, FloatArray, FloatArray]:
    """Take the last samples of each period, within the usual way of the clamp.

    Returns
    -------
    place : ndarray, shape (n,)
        Clamp position from the last sample, in lengths of the window: −1 to 0, above 0 where the
        clamp had been further and turned.
    length : ndarray, shape (p,)
        Of the window, negative where the clamp moves backward; 0 where it does not move.
    """
    way = blocks.clamp - ends.clamp[blocks.period]
    length = np.maximum.reduceat(np.abs(way), blocks.starts)
    length = np.minimum(length, np.median(length))
    # Signed, so that the places in the window are negative whichever way the clamp moved.
    length *= np.where(blocks.sums(way) > 0.0, -1.0, 1.0)
    near = np.abs(way) <= np.abs(length)[blocks.period] * (1.0 + ROUNDING)
    # The last one is there even of a clamp that turned.
    near[np.append(blocks.starts[1:], len(blocks)) - 1] = True
    blocks, way = blocks.take(near), way[near]
    size = length[blocks.period]
    return blocks, np.divide(way, size, out=np.zeros_like(way), where=size != 0.0), length


def fitted_forces(
    window: tuple[Blocks, FloatArray, FloatArray],
    noise: FloatArray,
    ends: Ends,
    lag: FloatArray,
    degree: int,
) -> ForceFits:
    """Fit polynomials to the forces in windows, by least squares."""
    blocks, place, length = window
    root = np.sqrt(blocks.count)[:, None]
    basis = legvander(1.0 + 2.0 * place, degree) * root
    values = blocks.readings[:, :2] * root
    information = blocks.sums(basis[:, :, None] * basis[:, None, :])
    # Positions that are different, but next to each other beside one that is far off, do not do.
    sizes = np.linalg.eigvalsh(information)
    enough = (sizes[:, 0] > LEAST_TOLD * sizes[:, -1]) & (length != 0.0)
    enough &= np.abs(ends.gap) < MOST_BEYOND * np.abs(length)
    information[~enough] = np.eye(degree + 1)
    covariance = np.asarray(np.linalg.inv(information), dtype=float)
    coefficients = covariance @ blocks.sums(basis[:, :, None] * values[:, None, :])
    miss = (values - (basis[:, :, None] * coefficients[blocks.period]).sum(axis=1)) / noise
    squares = blocks.sums((miss**2).sum(axis=1))
    degrees = 2 * (np.bincount(blocks.period) - degree - 1)
    coefficients[~enough] = np.nan
    chance = np.where(degrees > 0, chdtrc(np.maximum(degrees, 1), squares), 1.0)
    size = np.where(enough, length, np.nan)
    return ForceFits(
        coefficients=coefficients,
        covariance=covariance,
        noise=(float(noise[0]), float(noise[1])),
        step=(lag[:, None] + ends.gap[:, None] * STEP) / size[:, None],
        length=size,
        chance=np.where(enough, chance, 1.0),
    )


def read_onsets(
    blocks: Blocks, noise: FloatArray, ends: Ends, lag: FloatArray, position: float
) -> Onsets:
    """Read the ratio of the forces at the onset of slip that ends each period."""
    window = in_window(blocks, ends)
    # Noise of the positions is one of the forces, too: by how they grow with the clamp.
    straight = fitted_forces(window, noise, ends, lag, 1)
    growth = np.abs(2.0 * straight.coefficients[:, 1] / straight.length[:, None])
    if position:
        noise = np.hypot(noise, np.nan_to_num(np.nanmedian(growth, axis=0)) * position)
    fits = [fitted_forces(window, noise, ends, lag, n) for n in range(1, MOST_DEGREE + 2)]
    candidates = [_corrected(low, high, ends.sign) for low, high in pairwise(fits)]
    best = min(candidates, key=lambda one: one.error)
    # The middle of the step to the slip lies between two positions.
    way = np.where(ends.gap != 0.0, ends.gap, np.inf)
    by_position = (
        np.abs(best.along[:, 2] - best.along[:, 0]) / np.abs(way) * position / np.sqrt(2.0)
    )
    return replace(best, own=np.hypot(best.own, by_position))


def _corrected(low: ForceFits, high: ForceFits, sign: FloatArray) -> Onsets:
    """Correct one degree by the mean change of the next."""
    (along, spread), (higher, wider) = low.along, high.along
    # In the middle of the step.
    change, own = sign * (higher - along)[:, 1], spread[:, 1]
    variance = wider[:, 1] ** 2 - own**2
    told = (variance > 0.0) & (high.chance > UNLIKELY)
    along = sign[:, None] * along
    shared = UNREAD
    if told.any():
        change, variance = change[told], variance[told]
        between, _ = variance_between(change, variance)
        weight = 1.0 / (variance + between)
        mean = float((weight * change).sum() / weight.sum())
        along, own = along + mean, np.hypot(own, np.sqrt(between))
        shared = float(np.hypot(weight.sum() ** -0.5, REST * mean))
    return Onsets(fits=low, along=along, own=own, shared=shared)


def read_ratio(task: Task) -> Identification:
    """Read the friction of the periods of a recording.

    Raises
    ------
    RecordingError
        If the forces are none, press the other way, seem to be swapped, or have no noise.
    """
    if not task.both_forces:
        raise RecordingError("the method ratio needs the noise of both forces, above 0")
    slipped = task.slipped
    recording, spans, ends = slipped.recording, slipped.spans, slipped.ends
    forces, noise = recording.readings[:, FORCES], task.noise[FORCES]
    check_forces(forces, noise)
    ends = replace(ends, gap=np.where(spans.cut, 0.0, ends.gap))
    onsets = read_onsets(task.blocks, noise, ends, task.delay * ends.speed, slipped.position)
    parameters = [one for one in task.parameters if one.of in BEARING and one.deviation > 0.0]
    # How the forces curve is an error of all periods, too.
    effects = _effects(slipped, onsets, parameters, task.full_scale[MOMENT])
    effects = np.column_stack([effects, np.ones(len(spans))])
    covariance = np.diag([*(one.deviation**2 for one in parameters), onsets.shared**2])
    common = common_deviation(effects, covariance)
    found = summary_of(onsets.along, np.hypot(onsets.own, common))
    status, least = _statuses(onsets, slipped, noise)
    _check_axes(forces, status)
    periods = periods_of(slipped, status, found, least - HALF_WIDTH * common, common, effects)
    hidden = "the forces do not follow a smooth curve: a slip may be hidden"
    against = "the tip cannot slip in this direction"
    return Identification(
        periods=periods.doubted(
            Check(Grade.WRONG, onsets.fits.chance <= UNLIKELY, hidden),
            Check(Grade.WRONG, status == PeriodStatus.BEYOND, against),
        ),
        units=task.units,
        by_model=False,
        estimates=estimates_of(parameters, np.zeros(len(parameters)), covariance[:-1, :-1]),
        covariance=covariance,
        slope=task.slope,
    )


def _effects(
    slipped: Slipped, onsets: Onsets, parameters: Sequence[Parameter], moment: float
) -> FloatArray:
    """Change of the friction per unit of each parameter, shape (p, k): −(δfx − (fx/fy)·δfy)/fy."""
    ends, recording = slipped.spans.ends, slipped.recording
    loads = recording.readings[ends].copy()
    # A moment that was not recorded is taken as that of full scale, of which crosstalk is a part.
    whole = np.nan_to_num(moment, nan=1.0)
    loads[:, MOMENT] = np.nan_to_num(loads[:, MOMENT], nan=whole)
    sign, last = slipped.ends.sign, slipped.last
    ratio = sign * onsets.along[:, 1]
    found = np.zeros((len(ends), len(parameters)))
    for column, one in zip(found.T, parameters, strict=True):
        if one.effect is not None:
            fx, fy, _ = one.effect(loads, ends[:, None] / last, last).T
            column[:] = -sign * (fx - ratio * fy) / loads[:, 1]
    return np.nan_to_num(found)


def check_forces(forces: FloatArray, noise: FloatArray) -> None:
    """Refuse a recording in which a force is missing or has the wrong sign.

    Raises
    ------
    RecordingError
    """
    if not np.ptp(forces[:, 0]):
        raise RecordingError("force_x has one value in all rows: the channel was not recorded")
    if np.median(forces[:, 1]) > -noise[1]:
        raise RecordingError(
            "force_y is not negative: it is the load of the rod on the clamp, which is negative "
            "where the rod presses against the surface"
        )


def _check_axes(forces: FloatArray, status: StrArray) -> None:
    """Refuse a recording of swapped forces: their ratio falls in most periods, from a large one."""
    tangential, normal = np.median(np.abs(forces), axis=0)
    locked = int((status == PeriodStatus.LOCK).sum())
    if locked > max(2, MOST_LOCK * len(status)) and tangential > normal:
        raise MixedColumnsError(
            f"in {locked} of {len(status)} periods force_x over force_y falls until the tip slips: "
            "the columns force_x and force_y seem to be swapped. force_x is along the surface, "
            "force_y normal to it"
        )


def _statuses(onsets: Onsets, slipped: Slipped, noise: FloatArray) -> tuple[StrArray, FloatArray]:
    """Status of each period, and the least friction with which its tip stuck."""
    spans, sign = slipped.spans, slipped.ends.sign
    ratio, deviation = onsets.fits.ratio(np.tile(PLACES, (len(spans), 1)))
    ratio = sign[:, None] * ratio
    # Where too few samples make a curve, the last one alone tells.
    fx, fy = slipped.recording.readings[spans.ends][:, FORCES].T
    presses = fy < -PRESSES * noise[1]
    alone = sign * fx / np.where(presses, fy, np.nan)
    error = np.hypot(noise[0], alone * noise[1]) / np.abs(fy)
    fallen = (ratio - ratio[:, -1:]) > CERTAIN * np.hypot(deviation, deviation[:, -1:])
    locked = fallen.any(axis=1) | slipped.spans.swung
    curve = ratio - HALF_WIDTH * deviation
    least = np.fmax(alone - HALF_WIDTH * error, curve[:, -1])
    peak = np.max(np.nan_to_num(curve, nan=-np.inf), axis=1)
    status = np.select(
        [
            least < -CERTAIN * error,
            locked,
            spans.cut | spans.opened,
            np.isnan(onsets.along[:, 1]) | ~presses,
        ],
        [PeriodStatus.BEYOND, PeriodStatus.LOCK, PeriodStatus.OPEN, PeriodStatus.UNSURE],
        PeriodStatus.SLIP,
    )
    return status, np.where(locked, np.fmax(least, peak), least)
