"""One fit of the set-up and of all contacts to all recorded channels, with tolerances as priors.

The parameters p minimise χ²(p) + Σ (p/σ)², where σ are the tolerances and each period has its own
best contact u(p) (variable projection: Golub and Pereyra, 1973). What remains is the covariance
C = (JᵀJ + 1/σ²)⁻¹ with J = ∂(residuals)/∂p. This is Bayes' theorem for normal errors.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares
from scipy.special import chdtrc

from vibrissa.errors import NoResponseError
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.sensor.identification.forward import BEYOND, Forward
from vibrissa.sensor.identification.guide import Guide
from vibrissa.sensor.response.height_range import HIGHEST, LOWEST, HeightRange

# Gauss-Newton steps to the contact of a period, at first and beside one that is known.
FIRST_STEPS, STEPS = 8, 3
# Relative fall of the sum of squares at which the fit ends, the most evaluations of each attempt,
# and what is near to a bound, in tolerances.
SETTLED, EVALUATIONS, NEAR = 1e-5, (8, 8, 30), 0.1
# An inverse variance that is none.
TINY = 1e-300
# A period with residuals of a lower probability than this does not fit by itself, and where fewer
# than this part do not they are left out of the fit of the set-up.
UNLIKELY, MOST_ALONE = 1e-9, 0.5


@dataclass(frozen=True, eq=False, kw_only=True)
class Noise:
    """Noise of the channels that are used, and of the positions.

    Attributes
    ----------
    used : list of int
        Numbers of the channels.
    reading : ndarray, shape (c,)
        Standard deviation of one reading of each.
    position : float
        Standard deviation of one clamp position (L).
    """

    used: list[int]
    reading: FloatArray
    position: float = 0.0

    def weighted(self, values: FloatArray, slope: FloatArray, count: IntArray) -> FloatArray:
        """Values of shape (..., n, 3) in standard deviations, shape (..., n, c).

        An error of a position changes all channels together, along their slope over x0.
        """
        scaled = values[..., self.used] / self.reading * np.sqrt(count)[:, None]
        if not self.position:
            return np.asarray(scaled)
        along = slope[:, self.used] / self.reading
        square = np.maximum((along**2).sum(axis=1), TINY)
        less = (1.0 / np.sqrt(1.0 + self.position**2 * square) - 1.0) / square
        part = (scaled * along).sum(axis=-1) * less
        return np.asarray(scaled + part[..., None] * along)


@dataclass(frozen=True, eq=False, kw_only=True)
class Fit:
    """A set-up p, the contacts u with it, and how the residuals change.

    Attributes
    ----------
    forward : Forward
    noise : Noise
    p : ndarray, shape (k,)
    u : ndarray, shape (p,)
        x0 in the last sample of each period (L).
    kept : ndarray of bool, shape (p,)
        Periods to which the set-up was fitted.
    settled : bool
        Whether the fit has converged; otherwise p is what was given.
    """

    forward: Forward
    noise: Noise
    p: FloatArray
    u: FloatArray
    kept: BoolArray
    settled: bool = True

    @cached_property
    def heights(self) -> HeightRange:
        """The rod at all heights."""
        return self.forward.heights(self.p)[0]

    @cached_property
    def _seen(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Residuals and their slopes over u in standard deviations, and what gave them."""
        forward, blocks = self.forward, self.forward.blocks
        states, x0 = forward.states(self.p, self.u, self.heights)
        slope = forward.loads(self.p, states, x0, 1)
        miss = blocks.readings - forward.readings(
            self.p, forward.loads(self.p, states, x0), blocks.row
        )
        weigh = self.noise.weighted
        return weigh(miss, slope, blocks.count), weigh(slope, slope, blocks.count), slope, x0

    @property
    def residuals(self) -> FloatArray:
        """Residuals in standard deviations, shape (n, c)."""
        return self._seen[0]

    @cached_property
    def known(self) -> FloatArray:
        """Inverse variance of each u for a known set-up, shape (p,)."""
        slope = self._seen[1]
        return np.maximum(self.forward.blocks.sums((slope**2).sum(axis=1)), TINY)

    def contacts(self, steps: int = STEPS) -> "Fit":
        """Find the best u for this p."""
        fit = self
        for _ in range(steps):
            miss, slope, *_ = fit._seen
            step = fit.forward.blocks.sums((miss * slope).sum(axis=1)) / fit.known
            fit = replace(fit, u=fit.u + step)
        return fit

    @cached_property
    def _changes(self) -> tuple[FloatArray, FloatArray]:
        """Change of the readings per unit of each parameter, and that of u, (k, n, c), (p, k)."""
        blocks = self.forward.blocks
        _, slope, of_one, _ = self._seen
        found = self.noise.weighted(self.forward.changes(self.p, self.u), of_one, blocks.count)
        along = -np.stack([blocks.sums((one * slope).sum(axis=1)) for one in found], axis=1)
        along /= self.known[:, None]
        for one, moved in zip(found, along.T, strict=True):
            one += slope * moved[blocks.period][:, None]
        return found, along

    @property
    def changes(self) -> FloatArray:
        """Change of the readings per unit of each parameter, with the best u, shape (k, n, c)."""
        return self._changes[0]

    @property
    def moves(self) -> FloatArray:
        """Change of each u per unit of each parameter, shape (p, k)."""
        return self._changes[1]

    @cached_property
    def _rows(self) -> BoolArray:
        return self.kept[self.forward.blocks.period]

    @cached_property
    def sigma(self) -> FloatArray:
        """Tolerances, shape (k,)."""
        return np.array([one.deviation for one in self.forward.parameters])

    @cached_property
    def free(self) -> BoolArray:
        """Which parameters are not exact, shape (k,)."""
        return self.sigma > 0.0

    @property
    def scores(self) -> FloatArray:
        """Parameters that are not exact, in tolerances, shape (f,)."""
        return np.asarray(self.p[self.free] / self.sigma[self.free])

    def jacobian(self) -> FloatArray:
        """Change of the residuals that are kept per tolerance, shape (f, m)."""
        size, sigma = int(self.free.sum()), self.sigma[self.free]
        return -self.changes[self.free][:, self._rows].reshape(size, -1) * sigma[:, None]

    @cached_property
    def remaining(self) -> FloatArray:
        """Covariance of the errors that remain, in tolerances, shape (f, f)."""
        if not (self.settled and self.free.any()):
            return np.eye(int(self.free.sum()))
        jacobian = self.jacobian()
        return np.asarray(np.linalg.inv(jacobian @ jacobian.T + np.eye(len(jacobian))))

    @property
    def covariance(self) -> FloatArray:
        """Covariance of the errors that remain, shape (f, f)."""
        sigma = self.sigma[self.free]
        return np.asarray(self.remaining * np.outer(sigma, sigma))

    @property
    def penalty(self) -> float:
        """Sum of the squares of p, in tolerances."""
        return float((self.scores**2).sum())

    @cached_property
    def squares(self) -> FloatArray:
        """Sum of the squared residuals of each period, shape (p,)."""
        return self.forward.blocks.sums((self.residuals**2).sum(axis=1))

    @cached_property
    def fits_alone(self) -> BoolArray:
        """Which periods fit one contact by themselves, shape (p,)."""
        blocks = np.bincount(self.forward.blocks.period)
        chance = chdtrc(np.maximum(len(self.noise.used) * blocks - 1, 1), self.squares)
        return np.asarray(chance >= UNLIKELY)


def started(forward: Forward, noise: Noise, guide: Guide) -> Fit:
    """Begin with what was given, and with the states nearest to the readings."""
    found = _started(forward, noise, guide)
    _, x0 = forward.states(found.p, found.u, found.heights)
    least = -BEYOND * float(found.heights.at(found.heights.low).x0_lock)
    if x0.min() < 0.5 * least:
        return found
    return replace(found, forward=replace(forward, pulled=False, _solved={})).contacts()


def _started(forward: Forward, noise: Noise, guide: Guide) -> Fit:
    none = np.zeros(len(forward.parameters))
    heights = forward.heights(none)[0]
    blocks = forward.blocks
    nearest, _ = guide.nearest(blocks.readings)
    # With u = 0 each block has the displacement that it has less than the last sample.
    _, before = forward.states(none, np.zeros(len(forward.ends.clamp)), heights)
    apart = nearest - before
    u = np.array([np.median(of_one) for of_one in np.split(apart, blocks.starts[1:])])
    kept = np.ones(len(u), dtype=bool)
    return Fit(forward=forward, noise=noise, p=none, u=u, kept=kept).contacts(FIRST_STEPS)


def fitted(fit: Fit) -> Fit:
    """Fit the set-up; periods that do not fit by themselves are left out, if they are few."""
    found = _fitted(fit)
    alone = ~found.fits_alone
    if not alone.any() or alone.mean() >= MOST_ALONE:
        return found
    return _fitted(replace(fit, kept=~alone))


def _fitted(start: Fit) -> Fit:
    """Fit the set-up to the periods that are kept; what was given where that fails."""
    free = np.flatnonzero(start.free)
    best, settled = start, not len(free)
    # Steps may go to and fro at a bound: what is at one is held there.
    for evaluations in EVALUATIONS:
        if settled:
            break
        try:
            best, settled = _searched(best, free, evaluations)
        except NoResponseError:
            break
        bounds = np.array([_range(start.forward, k) for k in free.tolist()])
        near = np.abs(best.p[free, None] - bounds) < NEAR * start.sigma[free, None]
        free = free[~near.any(axis=1)]
    return best if settled else replace(start, settled=False)


def _searched(start: Fit, free: IntArray, evaluations: int) -> tuple[Fit, bool]:
    """Search from a set-up for the best sizes of some parameters, and tell whether it settled."""
    seen = {"fit": start}
    sigma, rows = start.sigma[free], int(start._rows.sum()) * len(start.noise.used)

    def at(scores: FloatArray) -> Fit:
        p = start.p.copy()
        p[free] = scores * sigma
        if not np.array_equal(seen["fit"].p, p):
            seen["fit"] = replace(seen["fit"], p=p).contacts()
        return seen["fit"]

    def residuals(scores: FloatArray) -> FloatArray:
        try:
            return np.append(at(scores).residuals[start._rows].ravel(), scores)
        except NoResponseError:
            # The step is made shorter.
            return np.full(rows + len(free), np.inf)

    def jacobian(scores: FloatArray) -> FloatArray:
        columns = at(scores).jacobian()[np.isin(np.flatnonzero(start.free), free)]
        return np.vstack([columns.T, np.eye(len(free))])

    ranges = np.array([_range(start.forward, k) for k in free.tolist()]).T / sigma
    found = least_squares(
        residuals,
        start.p[free] / sigma,
        jacobian,
        bounds=tuple(ranges),
        method="dogbox",
        ftol=SETTLED,
        xtol=SETTLED,
        gtol=None,
        max_nfev=evaluations,
    )
    return at(found.x), bool(found.success)


def _range(forward: Forward, k: int) -> tuple[float, float]:
    """Least and largest size that a parameter can take."""
    whisker = forward.whisker
    return {
        "theta": (1.0 - whisker.theta, np.inf),
        "eta": (LOWEST - whisker.eta, HIGHEST - whisker.eta),
        "clamp_compliance": (-whisker.mounting.clamp_compliance, np.inf),
    }.get(forward.parameters[k].name, (-np.inf, np.inf))
