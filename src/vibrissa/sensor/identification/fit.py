"""A set-up and the contact points of all periods, with the residuals of the recorded channels."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.scanning.stage import Held
from vibrissa.sensor.identification.forward import ForwardModel, forward_models
from vibrissa.sensor.identification.task import Task
from vibrissa.sensor.whisker import Whisker

# Number of Gauss-Newton steps by which u is fitted to the readings of an unknown contact point.
FIRST_STEPS = 8
# Least weight, an inverse variance.
LEAST_WEIGHT = 1e-300


@dataclass(frozen=True, eq=False, kw_only=True)
class Fit:
    """A set-up, and x0 in each period's last sample, beside the readings of a recording.

    In shapes, k is the number of parameters, f that of parameters which are not exact, n that of
    blocks of samples, c that of used channels, and p that of periods.

    Attributes
    ----------
    u : ndarray, shape (p,)
        x0 in the last sample of each period (L).
    kept : ndarray of bool, shape (p,)
        Periods to which the set-up is fitted.
    """

    model: ForwardModel
    u: FloatArray
    kept: BoolArray

    @property
    def task(self) -> Task:
        """Recording, noise and tolerances."""
        return self.model.task

    @property
    def p(self) -> FloatArray:
        """Deviations of the parameters from the given set-up, shape (k,)."""
        return self.model.p

    @property
    def scores(self) -> FloatArray:
        """Deviations p of the parameters that are not exact, over their tolerances, shape (f,)."""
        free = self.task.free
        return np.asarray(self.p[free] / self.task.sigma[free])

    @property
    def bounds(self) -> FloatArray:
        """Least and largest allowed p/σ, shape (2, f)."""
        task = self.task
        low, high = np.array([(parameter.low, parameter.high) for parameter in task.parameters]).T
        if self.model.heights.x0_touch <= self.u.max():
            # A rod that is curved towards the surface arches over it before its tip is level.
            curvature = task.number["curvature"]
            given = self.model.given.mounting.coefficients[0]
            high[curvature] = min(high[curvature], max(0.0, -given))
        return np.asarray(np.stack([low, high])[:, task.free] / task.sigma[task.free])

    @cached_property
    def rows(self) -> BoolArray:
        """Whether each block belongs to a period to which the set-up is fitted, shape (n,)."""
        return self.kept[self.task.blocks.period]

    @cached_property
    def held(self) -> Held:
        """States of the rod in all blocks of samples, and their displacements x0 (L)."""
        return self.model.states(self.u)

    @cached_property
    def _load_slope(self) -> FloatArray:
        """Derivatives of the loads with respect to x0, shape (n, 3)."""
        return self.model.loads(*self.held, order=1)

    def weighted(self, values: FloatArray) -> FloatArray:
        """Divide values (..., n, 3) of the blocks by their noise; return c channels, (..., n, c).

        Noise of the clamp position acts as noise of the readings in the direction of their slope.
        """
        position = self.task.recording.position
        count = self.task.blocks.count
        scaled = self.task.weighted(values) * np.sqrt(count)[:, None]
        if not position:
            return scaled
        along = self.task.weighted(self._load_slope)
        square = np.maximum((along**2).sum(axis=1), LEAST_WEIGHT)
        less = (1.0 / np.sqrt(1.0 + position**2 * square) - 1.0) / square
        part = (scaled * along).sum(axis=-1) * less
        return np.asarray(scaled + part[..., None] * along)

    @cached_property
    def slope(self) -> FloatArray:
        """Derivatives of the readings with respect to x0, in standard deviations, shape (n, c)."""
        return self.weighted(self._load_slope)

    @cached_property
    def residuals(self) -> FloatArray:
        """Residuals of the readings, in their standard deviations, shape (n, c)."""
        readings = self.model.readings(self.model.loads(*self.held))
        return self.weighted(self.task.blocks.readings - readings)

    @cached_property
    def known(self) -> FloatArray:
        """Inverse variance of x0 in each period's last sample, for a known set-up, shape (p,)."""
        return np.maximum(self.task.blocks.sums((self.slope**2).sum(axis=1)), LEAST_WEIGHT)

    def with_contacts(self, steps: int) -> "Fit":
        """Fit x0 in the last sample of each period, for this set-up, by Gauss-Newton steps."""
        fit = self
        for _ in range(steps):
            step = fit.task.blocks.sums((fit.residuals * fit.slope).sum(axis=1)) / fit.known
            fit = replace(fit, u=fit.u + step)
        return fit


def started(task: Task, whisker: Whisker, nearest: FloatArray) -> Fit:
    """Start at the given set-up, with x0 from the states nearest to the readings."""
    (model,) = forward_models(task, whisker, np.zeros(len(task.parameters)), keep=True)
    periods = len(task.spans)
    # With u = 0 the x0 of a block is its difference from the x0 of the last sample.
    apart = np.split(nearest - model.states(np.zeros(periods)).x0, task.blocks.starts[1:])
    u = np.array([np.median(of_one) for of_one in apart])
    fit = Fit(model=model, u=u, kept=np.ones(periods, dtype=bool))
    return fit.with_contacts(FIRST_STEPS)
