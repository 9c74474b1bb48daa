"""Friction of each period from a fit of the model, with every source of uncertainty."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.sensor.identification.fit import Fit
from vibrissa.sensor.identification.periods import Periods, PeriodStatus, periods_of
from vibrissa.sensor.identification.slips import Slipped
from vibrissa.sensor.identification.uncertainty import HALF_WIDTH, common_deviation, summary_of
from vibrissa.sensor.response.heights import HeightStates


@dataclass(frozen=True, eq=False, kw_only=True)
class Onsets:
    """The last sticking states of p periods, and friction with its uncertainty there.

    Attributes
    ----------
    position : float
        Standard deviation of one clamp position (L).
    """

    fit: Fit
    position: float

    @property
    def _sign(self) -> FloatArray:
        return self.fit.forward.ends.sign

    @cached_property
    def own(self) -> FloatArray:
        """Standard deviation of x0 for a known set-up, shape (p,)."""
        forward = self.fit.forward
        # Behind a filter the beginning of a slip is hidden in noise, for up to its delay.
        late = forward.delay * np.abs(forward.ends.speed) / np.sqrt(12.0)
        return np.sqrt(1.0 / self.fit.known + self.position**2 / 2.0 + late**2)

    @cached_property
    def _states(self) -> tuple[HeightStates, FloatArray]:
        """States at the beginning, in the middle and at the end of the step, shape (p, 3)."""
        return self.fit.forward.onset(self.fit.p, self.fit.u, self.fit.heights)

    def _needed(self, states: HeightStates, x0: FloatArray) -> FloatArray:
        """Friction required to stick in states; none beyond the lock."""
        x0 = np.clip(x0, states.x0_pull, states.x0_lock)
        return np.asarray(self._sign[:, None] * states.demand(x0))

    @cached_property
    def along(self) -> FloatArray:
        """Friction at the beginning, in the middle and at the end of the step, shape (p, 3).

        NaN where the tip cannot have slipped: it is past the lock, or loaded against the motion.
        """
        states, x0 = self._states
        needed = self._needed(states, x0)
        wide = HALF_WIDTH * self.own
        first, last = np.sort(x0, axis=1)[:, [0, -1]].T
        possible = (last + wide > states.x0_pull[:, 1]) & (first - wide < states.x0_lock[:, 1])
        against = needed.max(axis=1) < -HALF_WIDTH * self.by_noise
        return np.where((possible & ~against)[:, None], needed, np.nan)

    @cached_property
    def by_noise(self) -> FloatArray:
        """Standard deviation of μ0 by noise, shape (p,)."""
        states, x0 = self._states
        x0 = np.clip(x0, states.x0_pull, states.x0_lock)
        return np.asarray(np.abs(states.demand_slope(x0)[:, 1]) * self.own)

    @cached_property
    def effects(self) -> FloatArray:
        """Change of μ0 per unit of each parameter that is not exact, shape (p, k)."""
        found = [self._effect(k) for k in np.flatnonzero(self.fit.free).tolist()]
        return np.stack(found, axis=1) if found else np.empty((len(self.fit.u), 0))

    def _effect(self, k: int) -> FloatArray:
        """Change of μ0 per unit of one parameter, shape (p,)."""
        fit, forward = self.fit, self.fit.forward
        other, step = forward.moved(fit.p, k), forward.step(k)
        u = fit.u + step * fit.moves[:, k]
        heights = forward.heights(other)[0] if forward.of_rod(k) else fit.heights
        before = self._needed(*self._states)[:, 1]
        after = self._needed(*forward.onset(other, u, heights))[:, 1]
        return np.asarray((after - before) / step)

    def by_height(self) -> tuple[FloatArray, FloatArray]:
        """Change of μ0 by the height of each tip on the surface, and its standard deviation."""
        fit = self.fit
        if not (fit.slope.deviation and fit.settled):
            return np.zeros(len(fit.u)), np.zeros(len(fit.u))
        height, variance = fit.heights_of_tips
        allowed = fit.slope.rise(np.ptp(fit.forward.ends.clamp))
        effect, part = self._effect(fit.forward.number["eta"]), allowed / (allowed + variance)
        return effect * part * height, np.abs(effect) * np.sqrt(part * variance)

    @cached_property
    def least(self) -> tuple[FloatArray, BoolArray]:
        """Least friction with which the tip can have stuck, and whether it stuck past the lock.

        NaN where a state is none of the rod.
        """
        fit, period = self.fit, self.fit.forward.blocks.period
        states, x0 = fit.forward.states(fit.p, fit.u, fit.heights)
        wide = HALF_WIDTH * self.own[period]
        none = (x0 - wide > states.x0_end) | (x0 + wide < states.x0_pull)
        # Pushed states need at least what those a little before them do.
        x0 = np.where(x0 > 0.0, np.maximum(x0 - wide, 0.0), np.minimum(x0 + wide, 0.0))
        needed = np.abs(states.demand(states.clip(x0)))
        starts = fit.forward.blocks.starts
        return (
            np.maximum.reduceat(np.where(none, np.nan, needed), starts),
            np.logical_or.reduceat(x0 >= states.x0_lock, starts),
        )


def read_periods(fit: Fit, slipped: Slipped) -> Periods:
    """Read the friction of the periods."""
    onsets, spans = Onsets(fit=fit, position=slipped.position), slipped.spans
    common = common_deviation(onsets.effects, fit.covariance)
    by_height, left = onsets.by_height()
    along = onsets.along + by_height[:, None]
    found = summary_of(along, np.hypot(np.hypot(onsets.by_noise, left), common))
    least, past = onsets.least
    least = least + by_height
    opened = spans.opened
    # Pulled back from past the lock a tip slips after all, but not pushed on.
    locked = slipped.swung | (past & (opened | (fit.forward.ends.sign > 0.0)))
    # A tip that has stuck with more friction than that at which it slipped did not slip.
    more = ~locked & ~opened & (least - HALF_WIDTH * common > found.high)
    status = np.select(
        [np.isnan(least) | more, locked, opened, np.isnan(found.mean)],
        [PeriodStatus.BEYOND, PeriodStatus.LOCK, PeriodStatus.OPEN, PeriodStatus.BEYOND],
        PeriodStatus.SLIP,
    )
    least = least - HALF_WIDTH * common
    periods = periods_of(slipped, status, found, least, common, onsets.effects)
    return replace(periods, contact=fit.forward.contact(fit.p, fit.u, fit.heights))
