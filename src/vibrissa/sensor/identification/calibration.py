"""Height and sensor bias from the recording itself: η, and the offset of each channel.

While the tip sticks, the reactions run along the rod's branch, whose shape depends on η; an offset
shifts it. All samples of all periods are fitted at once by least squares, with one unknown contact
for each period. The contact of a period affects only its own samples, so that it is eliminated
period by period (variable projection, with Kaufman's derivative); at most four unknowns remain.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Self

import numpy as np
from scipy.optimize import least_squares

from vibrissa.errors import UndeterminedError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.identification.alternatives import Alternative
from vibrissa.sensor.identification.periods import (
    Channels,
    Partition,
    Placed,
    Samples,
    cut,
    fitted,
    located,
    lone_spikes,
)
from vibrissa.sensor.identification.recording import MIRROR, Recording
from vibrissa.sensor.quantities import OWN_UNITS, Kind, Units, chosen
from vibrissa.sensor.response.branch import Branch
from vibrissa.sensor.response.height_range import HeightStates
from vibrissa.sensor.response.heights import Heights
from vibrissa.sensor.simulation.oblique import ObliqueHeights
from vibrissa.sensor.transducer import CHANNELS

# The unknowns: their names, and where they stand in a vector of them.
NAMES = ("eta", *CHANNELS)
ETA, OFFSETS = 0, slice(1, 4)
# Slips are found anew with each better fit, until they stay the same.
ROUNDS = 8
# Step in η for derivatives of the branch (L).
STEP = 1e-5
# The error is proportional to the noise only if this many standard deviations lie within the range
# of η, and within this part of what a channel changes up to the lock.
SIGMAS = 3.0
MOST_OFFSET = 0.5
# Mean squared residual, in units of the noise, from which on the model does not fit the recording.
MOST_EXCESS = 2.0
# Condition number from which on unknowns cannot be told apart.
SINGULAR = 1e12
# Part of an axis of unit length that is more than rounding.
COUNTS = 0.1
ADVICE = (
    "record more periods of sticking, or longer ones on a surface of higher friction, or give eta "
    "and tare the transducer"
)


class Unknown(StrEnum):
    """What can be estimated besides the friction.

    Attributes
    ----------
    ETA
        Height of the surface above the clamp.
    OFFSET
        Reading of each channel without load.
    """

    ETA = "eta"
    OFFSET = "offset"


@dataclass(frozen=True, eq=False, kw_only=True)
class Setup:
    """A rod at a height, read by a transducer, and how well both are known.

    Attributes
    ----------
    eta : float
        Height (L).
    offset : ndarray, shape (3,)
        Of fx, fy (E·I0/L²) and m (E·I0/L).
    covariance : ndarray, shape (4, 4)
        Of η and the offsets; 0 for what was given.
    branch : Branch or ObliqueStage
        At this height.
    displaced : tuple of Alternative
        What is not known exactly, each of k things a little larger.
    shared : ndarray, shape (k, k) or None
        Covariance of their errors; None where they are independent and their deviations are 1.
    penalty : float
        Sum of the squares, in tolerances, by which what was given has been adjusted.
    fitted : int
        Number of values that were fitted without a tolerance.
    """

    eta: float
    offset: FloatArray
    covariance: FloatArray
    branch: Placed
    displaced: tuple[Alternative, ...] = ()
    shared: FloatArray | None = None
    penalty: float = 0.0
    fitted: int = 0

    def mirrored(self) -> Self:
        """Give the setup of the mirrored recording, see `Recording.mirrored`."""
        displaced = tuple(other.mirrored() for other in self.displaced)
        branch = self.branch.mirrored()
        return replace(self, branch=branch, offset=self.offset * MIRROR, displaced=displaced)

    @property
    def deviation(self) -> FloatArray:
        """Standard deviations of η and the three offsets."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def correlation(self) -> FloatArray:
        """Correlations between them, NaN for what was given."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(self.covariance / np.outer(self.deviation, self.deviation))


def known_setup(branch: Placed, eta: float = float("nan")) -> Setup:
    """Make a setup of which nothing is estimated."""
    return Setup(eta=eta, offset=np.zeros(3), covariance=np.zeros((4, 4)), branch=branch)


def calibrate(
    heights: Heights | ObliqueHeights,
    eta: float,
    recording: Recording,
    noise: FloatArray,
    unknown: Sequence[Unknown | str],
    units: Units = OWN_UNITS,
) -> Setup:
    """Estimate η, offsets or both from a recording, whatever its friction.

    Parameters
    ----------
    heights : Heights or ObliqueHeights
    eta : float
        Height, or where to begin looking for it (L).
    recording : Recording
        A channel with NaN is not used.
    noise : ndarray, shape (3,)
        Standard deviation of one reading of each channel.
    unknown : sequence of Unknown
    units : Units
        In which messages tell heights.

    Returns
    -------
    Setup

    Raises
    ------
    UndeterminedError
        If the recording does not determine it; the message says what to do.
    """
    asked = {chosen(Unknown, name, "what to estimate") for name in unknown}
    used = [i for i in range(3) if not np.isnan(recording.readings[:, i]).any()]
    free = [ETA] if Unknown.ETA in asked else []
    free += [1 + i for i in used] if Unknown.OFFSET in asked else []
    if not free:
        return known_setup(heights.at(eta), eta)
    channels = Channels(used=used, noise=noise[used])
    try:
        fit, values = _settled(heights, eta, recording, channels, free)
        covariance = _covariance(fit, values)
        _check_range(heights, values, covariance, used, units)
    except UndeterminedError as error:
        what = " and ".join(sorted(asked))
        raise UndeterminedError(f"this recording does not tell {what}: {error}") from None
    moved = values + principal_axes(covariance)
    return Setup(
        eta=float(values[ETA]),
        offset=values[OFFSETS],
        covariance=covariance,
        branch=heights.at(values[ETA]),
        fitted=len(free),
        displaced=tuple(
            Alternative(
                name="calibration",
                step=1.0,
                corrected=_without(other[OFFSETS] - values[OFFSETS]),
                branch=heights.at(other[ETA]),
            )
            for other in moved
        ),
    )


def _without(offset: FloatArray) -> Callable[[Samples, float], Samples]:
    return lambda samples, size: samples.without(size * offset)


def _settled(
    heights: Heights | ObliqueHeights,
    eta: float,
    recording: Recording,
    channels: Channels,
    free: list[int],
) -> tuple["_Fit", FloatArray]:
    """Fit the unknowns, and find the slips anew with each better fit until they stay the same."""
    values = np.array([eta, 0.0, 0.0, 0.0])
    begins = np.empty(0, dtype=np.int64)
    for _ in range(ROUNDS):
        samples, periods = _usual_samples(heights.at(values[ETA]), values, recording, channels)
        # A period of few samples is used up by its contact.
        if len(samples) * len(channels.used) <= 2 * (len(periods) + len(free)):
            raise UndeterminedError(
                f"{len(samples)} usable rows in {len(periods)} periods are too few; {ADVICE}"
            )
        if np.array_equal(begins, samples.row[periods.begins]):
            break
        begins = samples.row[periods.begins]
        fit = _Fit(
            heights=heights,
            samples=samples,
            channels=channels,
            periods=periods,
            free=free,
            start=values,
        )
        values = fit.solved()
    return fit, values


def _usual_samples(
    branch: Placed, values: FloatArray, recording: Recording, channels: Channels
) -> tuple[Samples, Partition]:
    """Take the samples that fit the branch as well as most, and cut them into periods."""
    samples = located(branch, recording, channels, values[OFFSETS])
    samples = samples.take(samples.usual)
    samples = samples.take(~lone_spikes(samples))
    return samples, cut(samples)


def _covariance(fit: "_Fit", values: FloatArray) -> FloatArray:
    """Covariance of the unknowns at the best fit, shape (4, 4)."""
    excess = float(np.mean(fit.residuals(values[fit.free]) ** 2))
    if excess > MOST_EXCESS:
        raise UndeterminedError(
            f"the squared errors that remain are {excess:.3g} times those of the noise: the rod, "
            "height, units or noise that were given do not match the recording, or it goes on long "
            "after the rod has swung aside: cut it there"
        )
    jacobian = fit.jacobian(values[fit.free])
    information = jacobian.T @ jacobian
    # Units of the unknowns differ: each is compared with how well it would be known alone.
    alone = np.sqrt(np.diag(information))
    singular = not (alone > 0.0).all()
    if singular or np.linalg.cond(information / np.outer(alone, alone)) > SINGULAR:
        raise UndeterminedError(f"its samples would fit as well with other values; {ADVICE}")
    covariance = np.zeros((len(NAMES), len(NAMES)))
    covariance[np.ix_(fit.free, fit.free)] = np.linalg.inv(information)
    return covariance


def _check_range(
    heights: Heights | ObliqueHeights,
    values: FloatArray,
    covariance: FloatArray,
    used: list[int],
    units: Units,
) -> None:
    """Refuse an estimate that is too uncertain for its error to be proportional to the noise."""

    def told(height: float, digits: int) -> str:
        return units.spelled(height, Kind.LENGTH, digits)

    low, high = heights.low, heights.high
    eta, room = values[ETA], min(values[ETA] - low, high - values[ETA])
    deviation = np.sqrt(np.diag(covariance))
    if (deviation[ETA] > 0.0 and not SIGMAS * deviation[ETA] < room) or not room > 0.0:
        raise UndeterminedError(
            f"eta would be {told(eta, 5)} with a standard deviation of {told(deviation[ETA], 2)}, "
            f"and is looked for from {told(low, 5)} to {told(high, 5)}; {ADVICE}"
        )
    branch = heights.at(eta).level
    span = np.ptp(branch(np.linspace(0.0, branch.x0_lock, 101)), axis=0)
    part = deviation[OFFSETS] / span
    for i in used:
        if not SIGMAS * part[i] <= MOST_OFFSET:
            raise UndeterminedError(
                f"the offset of {CHANNELS[i]} would have a standard deviation of {part[i]:.0%} of "
                f"what it changes up to the lock; {ADVICE}"
            )


def principal_axes(covariance: FloatArray) -> FloatArray:
    """Vectors of one standard deviation each whose squares add up to the covariance.

    Parameters
    ----------
    covariance : ndarray, shape (k, k)

    Returns
    -------
    ndarray, shape (q, k)
        One row for each axis that is not known exactly; of its first part that counts, each is
        positive, so that rounding does not turn it.
    """
    scale = np.sqrt(np.diag(covariance))
    safe = np.where(scale > 0.0, scale, 1.0)
    variance, axes = np.linalg.eigh(covariance / np.outer(safe, safe))
    first = [axis[np.abs(axis) > COUNTS][0] for axis in axes.T]
    axes = axes * np.sign(first)
    rows = (np.sqrt(np.maximum(variance, 0.0)) * axes).T * scale
    return np.asarray(rows[variance > 1e-14])


@dataclass(frozen=True, eq=False, kw_only=True)
class _Fit:
    """Least squares over the unknowns that are free; each period has its own best contact.

    Attributes
    ----------
    heights : Heights or ObliqueHeights
    samples : Samples
    channels : Channels
    periods : Partition
    free : list of int
        Numbers of the unknowns that are free.
    start : ndarray, shape (4,)
        First guess of all unknowns.
    """

    heights: Heights | ObliqueHeights
    samples: Samples
    channels: Channels
    periods: Partition
    free: list[int]
    start: FloatArray

    def _full(self, values: FloatArray) -> FloatArray:
        """All unknowns, of which some are free."""
        full = self.start.copy()
        full[self.free] = values
        return full

    def _samples(self, full: FloatArray) -> tuple[Samples, FloatArray]:
        """Give the samples without offsets, and the place of the best contact of each."""
        branch, periods = self.heights.at(full[ETA]), self.periods
        _, start = branch.above(self.samples.clamp)
        samples = replace(self.samples.without(full[OFFSETS]), start=start)
        guess = periods.sums(samples.place) / periods.counts
        contacts = fitted(branch, samples, self.channels, periods, guess)
        return samples, periods.spread(contacts.place)

    def _states(self, eta: float, place: FloatArray) -> tuple[Branch | HeightStates, FloatArray]:
        """States of the samples' contacts at a height, and their displacements (L)."""
        states, start = self.heights.at(eta).above(self.samples.clamp)
        return states, start - place

    def residuals(self, values: FloatArray) -> FloatArray:
        """Residuals of all readings, in standard deviations."""
        full = self._full(values)
        samples, place = self._samples(full)
        states, x0 = self._states(full[ETA], place)
        return self.channels.weighted(samples.readings - states(states.clip(x0))).ravel()

    def jacobian(self, values: FloatArray) -> FloatArray:
        """Differentiate the residuals with respect to the unknowns that are free."""
        full = self._full(values)
        _, place = self._samples(full)
        states, x0 = self._states(full[ETA], place)
        used, noise = self.channels.used, self.channels.noise
        columns = np.zeros((len(x0), len(used), len(self.free)))
        for j, unknown in enumerate(self.free):
            if unknown == ETA:
                columns[:, :, j] = -self.channels.weighted(self._slope_in_eta(full[ETA], place))
            else:
                channel = used.index(unknown - 1)
                columns[:, channel, j] = -1.0 / noise[channel]
        # The part that a shift of the period's contact explains is removed.
        shift = self.channels.weighted(states.slope(states.clip(x0)))
        known = self.periods.sums((shift**2).sum(axis=1))
        along = self.periods.sums(np.einsum("nk,nkj->nj", shift, columns))
        columns -= shift[:, :, None] * self.periods.spread(along / known[:, None])[:, None, :]
        return columns.reshape(-1, len(self.free))

    def _slope_in_eta(self, eta: float, place: FloatArray) -> FloatArray:
        """Differentiate the reactions with respect to η, by a central difference."""
        low, high = max(eta - STEP, self.heights.low), min(eta + STEP, self.heights.high)
        lower, below = self._states(low, place)
        upper, above = self._states(high, place)
        # Both within what is known of both.
        below, above = (lower.clip(upper.clip(x0)) for x0 in (below, above))
        return (upper(above) - lower(below)) / (high - low)

    def solved(self) -> FloatArray:
        """Best values of all unknowns, shape (4,)."""
        bounds = np.array([[-np.inf, np.inf]] * len(NAMES))
        bounds[ETA] = self.heights.low, self.heights.high
        found = least_squares(
            self.residuals,
            self.start[self.free],
            self.jacobian,
            bounds=tuple(bounds[self.free].T),
            x_scale="jac",
            loss="soft_l1",
            f_scale=3.0,
        )
        return self._full(found.x)
