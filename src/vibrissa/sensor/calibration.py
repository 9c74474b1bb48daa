"""Height and zeros from the recording itself: η, and offsets of the transducer's channels.

While the tip sticks, the reactions run along the rod's branch, whose shape depends on η; an offset
shifts it. All samples of all periods are fitted at once by least squares, with one unknown contact
for each period. The contact of a period enters its samples alone: it is eliminated period by period
(variable projection, with Kaufman's derivative), and what remains are at most four unknowns.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from scipy.optimize import least_squares

from vibrissa.arrays import FloatArray, IntArray
from vibrissa.sensor.heights import Heights
from vibrissa.sensor.response import Branch
from vibrissa.sensor.sticking import MISFIT, fitted, jumps, located, lone_spikes

# Names and order of what may be unknown.
NAMES = ("eta", "force_x", "force_y", "moment_z")
# Slips are found anew with each better fit, until they stay the same.
ROUNDS = 8
# Step in η for derivatives of the branch (L).
STEP = 1e-5
# Squared misfit, in multiples of the usual one, of samples that are left out of a fit.
UNUSUAL = 9.0
# Three standard deviations must lie within the range of η, and within this part of what a channel
# changes up to the lock: only there is the error proportional to the noise.
SIGMAS = 3.0
MOST_OFFSET = 0.5
# Mean squared error, in units of the noise, from which on the model is not that of the recording.
MOST_EXCESS = 2.0


class Unknown(StrEnum):
    """What can be estimated besides the friction.

    Attributes
    ----------
    ETA
        Height of the surface above the clamp.
    OFFSET
        What each channel reads without load.
    """

    ETA = "eta"
    OFFSET = "offset"


@dataclass(frozen=True, eq=False)
class Setup:
    """A rod on a surface, read by a transducer, and how well it is known.

    Attributes
    ----------
    message : str
        Empty, or why the recording does not tell what was asked.
    eta : float
        Height (L).
    offset : ndarray, shape (3,)
        Of fx, fy (E·I0/L²) and m (E·I0/L).
    covariance : ndarray, shape (4, 4)
        Of η and the offsets; 0 for what was given.
    branch : Branch
        At this height.
    displaced : tuple of (Branch, ndarray)
        Branches and offsets one standard deviation away, along each principal axis of the
        covariance: what they change adds up by squares.
    """

    message: str
    eta: float
    offset: FloatArray
    covariance: FloatArray
    branch: Branch
    displaced: tuple[tuple[Branch, FloatArray], ...] = ()

    @property
    def deviation(self) -> FloatArray:
        """Standard deviations of η and the three offsets."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def correlation(self) -> FloatArray:
        """Correlations between them, NaN for what was given."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(self.covariance / np.outer(self.deviation, self.deviation))


def known_setup(branch: Branch, eta: float = float("nan")) -> Setup:
    """Make a setup of which nothing is estimated."""
    return Setup("", eta, np.zeros(3), np.zeros((4, 4)), branch)


def calibrate(
    heights: Heights,
    eta: float,
    clamp: FloatArray,
    readings: FloatArray,
    noise: FloatArray,
    unknown: Sequence[Unknown | str],
) -> Setup:
    """Estimate η, offsets or both from a recording, whatever its friction.

    Parameters
    ----------
    heights : Heights
    eta : float
        Height, or where to begin looking for it (L).
    clamp : ndarray, shape (n,)
        Clamp positions (L).
    readings : ndarray, shape (n, 3)
        fx, fy (E·I0/L²) and m (E·I0/L); a channel with NaN is not used.
    noise : ndarray, shape (3,)
        Standard deviation of one reading of each.
    unknown : sequence of Unknown

    Returns
    -------
    Setup
        With a message if the recording does not tell it.
    """
    asked = {Unknown(name) for name in unknown}
    used = [i for i in range(3) if not np.isnan(readings[:, i]).any()]
    free = [0] if Unknown.ETA in asked else []
    free += [1 + i for i in used] if Unknown.OFFSET in asked else []
    values = np.array([eta, 0.0, 0.0, 0.0])
    if not free:
        return known_setup(heights.at(eta), eta)

    more = (
        "record more periods of sticking, or longer ones on a rougher surface, or give eta and "
        "tare the transducer"
    )

    def nothing(why: str) -> Setup:
        message = f"this recording does not tell {' and '.join(sorted(asked))}: {why}"
        return Setup(message, eta, np.zeros(3), np.full((4, 4), np.nan), heights.at(eta))

    before = np.empty(0, dtype=np.int64)
    fit = None
    for _ in range(ROUNDS):
        branch = heights.at(values[0])
        x0, spread, misfit = located(
            branch, readings[:, used] - values[1:][used], noise[used], used
        )
        keep = misfit <= max(MISFIT, UNUSUAL * float(np.median(misfit)))
        rows = np.flatnonzero(keep)
        rows = rows[~lone_spikes(clamp[rows] - x0[rows], spread[rows])]
        at = clamp[rows] - x0[rows]
        begins = np.append(0, np.flatnonzero(jumps(at, spread[rows])) + 1)
        # A period of few samples is taken up by its contact.
        if len(rows) * len(used) <= 2 * (len(begins) + len(free)):
            return nothing(f"{len(rows)} usable rows in {len(begins)} periods are too few; {more}")
        if np.array_equal(before, begins_in := rows[begins]):
            break
        before = begins_in
        fit = _Fit(heights, clamp[rows], readings[rows], noise, used, free, values, at, begins)
        values = fit.solved()
    assert fit is not None
    excess = float(np.mean(fit.residuals(values[free]) ** 2))
    if excess > MOST_EXCESS:
        return nothing(
            f"the squared errors that remain are {excess:.3g} times those of the noise: rod, "
            "height, units or noise are others than given"
        )
    covariance = np.zeros((4, 4))
    information = fit.information(values)
    # Units of the unknowns differ: compared by what each would be known to alone.
    alone = np.sqrt(np.diag(information))
    if not (alone > 0.0).all() or np.linalg.cond(information / np.outer(alone, alone)) > 1e12:
        return nothing(f"its samples would fit as well with other values; {more}")
    covariance[np.ix_(free, free)] = np.linalg.inv(information)
    deviation = np.sqrt(np.diag(covariance))

    if why := _vague(heights, values, deviation, used):
        return nothing(f"{why}; {more}")
    displaced = tuple(
        (heights.at(moved[0]), moved[1:]) for moved in values + principal_axes(covariance)
    )
    branch = heights.at(values[0])
    return Setup("", float(values[0]), values[1:], covariance, branch, displaced)


def _vague(heights: Heights, values: FloatArray, deviation: FloatArray, used: list[int]) -> str:
    """Say which estimate is too uncertain for its error to be proportional to the noise."""
    low, high = heights.low, heights.high
    room = min(values[0] - low, high - values[0])
    if (deviation[0] > 0.0 and not SIGMAS * deviation[0] < room) or not room > 0.0:
        return (
            f"eta would be {values[0]:.5g} with a standard deviation of {deviation[0]:.2g}, and is "
            f"looked for from {low:.5g} to {high:.5g} (in units of L)"
        )
    branch = heights.at(values[0])
    span = np.ptp(branch(np.linspace(0.0, branch.x0_lock, 101)), axis=0)
    for i in used:
        if not SIGMAS * deviation[1 + i] <= MOST_OFFSET * span[i]:
            return (
                f"the offset of {NAMES[1 + i]} would have a standard deviation of "
                f"{deviation[1 + i] / span[i]:.0%} of what it changes up to the lock"
            )
    return ""


def principal_axes(covariance: FloatArray) -> FloatArray:
    """Vectors of one standard deviation each whose squares add up to the covariance.

    Parameters
    ----------
    covariance : ndarray, shape (k, k)

    Returns
    -------
    ndarray, shape (q, k)
        One row for each axis that is not known exactly.
    """
    scale = np.sqrt(np.diag(covariance))
    safe = np.where(scale > 0.0, scale, 1.0)
    variance, axes = np.linalg.eigh(covariance / np.outer(safe, safe))
    rows = (np.sqrt(np.maximum(variance, 0.0)) * axes).T * scale
    return np.asarray(rows[variance > 1e-14])


@dataclass(eq=False)
class _Fit:
    """Residuals of all samples, each period with its own best contact, over the unknowns."""

    heights: Heights
    clamp: FloatArray
    readings: FloatArray
    noise: FloatArray
    used: list[int]
    free: list[int]
    start: FloatArray
    at: FloatArray
    begins: IntArray

    def __post_init__(self) -> None:
        self.counts = np.diff(np.append(self.begins, len(self.clamp)))

    def _full(self, values: FloatArray) -> FloatArray:
        full = self.start.copy()
        full[self.free] = values
        return full

    def _states(self, full: FloatArray) -> tuple[Branch, FloatArray, FloatArray]:
        """Branch, displacements with the best contacts, and readings without offsets."""
        branch = self.heights.at(full[0])
        readings = (self.readings - full[1:])[:, self.used]
        place, _ = fitted(
            branch, self.clamp, readings, self.noise[self.used], self.used, self.at, self.begins
        )
        x0 = self.clamp - np.repeat(place, self.counts)
        return branch, np.clip(x0, branch.x0_pull, branch.x0_end), readings

    def residuals(self, values: FloatArray) -> FloatArray:
        branch, x0, readings = self._states(self._full(values))
        return np.asarray(((readings - branch(x0)[:, self.used]) / self.noise[self.used]).ravel())

    def jacobian(self, values: FloatArray) -> FloatArray:
        full = self._full(values)
        branch, x0, _ = self._states(full)
        noise = self.noise[self.used]
        columns = np.zeros((len(x0), len(self.used), len(self.free)))
        for j, name in enumerate(self.free):
            if name == 0:
                low = max(full[0] - STEP, self.heights.low)
                high = min(full[0] + STEP, self.heights.high)
                lower, upper = (self.heights.at(eta) for eta in (low, high))
                inside = np.clip(
                    x0, max(lower.x0_pull, upper.x0_pull), min(lower.x0_end, upper.x0_end)
                )
                change = (upper(inside) - lower(inside)) / (high - low)
                columns[:, :, j] = -change[:, self.used] / noise
            else:
                columns[:, self.used.index(name - 1), j] = -1.0 / noise[self.used.index(name - 1)]
        # What a shift of the period's contact explains is taken out.
        shift = branch.slope(x0)[:, self.used] / noise
        known = np.add.reduceat((shift**2).sum(axis=1), self.begins)
        along = np.add.reduceat(np.einsum("nk,nkj->nj", shift, columns), self.begins)
        part = np.repeat(along / known[:, None], self.counts, axis=0)
        columns -= shift[:, :, None] * part[:, None, :]
        return columns.reshape(-1, len(self.free))

    def information(self, full: FloatArray) -> FloatArray:
        """Inverse covariance of the unknowns."""
        jacobian = self.jacobian(full[self.free])
        return np.asarray(jacobian.T @ jacobian)

    def solved(self) -> FloatArray:
        bounds = np.array([[-np.inf, np.inf]] * 4)
        bounds[0] = self.heights.low, self.heights.high
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
