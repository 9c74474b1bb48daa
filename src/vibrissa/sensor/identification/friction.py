"""Friction of each period from a fit of the model, with every source of uncertainty."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray, StrArray
from vibrissa.sensor.identification.fit import Fit
from vibrissa.sensor.identification.periods import Periods, PeriodStatus
from vibrissa.sensor.identification.slips import Slipped
from vibrissa.sensor.identification.uncertainty import (
    BLOCK,
    COMMON,
    HALF_WIDTH,
    NOISE,
    ONSET,
    Summary,
    common_deviation,
    step_deviation,
    summary_of,
)
from vibrissa.sensor.response.height_range import HeightStates

MIDDLE = np.array([0.5])


@dataclass(frozen=True, eq=False, kw_only=True)
class Onsets:
    """The last sticking states of p periods, and what they tell of friction.

    Attributes
    ----------
    fit : Fit
    sign : ndarray, shape (p,)
        1 where the clamp moves forward as the tip slips, −1 where backward.
    """

    fit: Fit
    sign: FloatArray

    @classmethod
    def of(cls, fit: Fit, slipped: Slipped) -> "Onsets":
        """Take the direction in which the clamp moves at the end of each period."""
        return cls(fit=fit, sign=slipped.signs)

    @property
    def level(self) -> bool:
        """Whether the stage was given as level."""
        return not self.fit.forward.whisker.mounting.stage_angle

    @cached_property
    def own(self) -> FloatArray:
        """Standard deviation of x0 in the last sample for a known set-up, shape (p,)."""
        return np.hypot(self.fit.known**-0.5, self.fit.noise.position)

    @cached_property
    def _middle(self) -> tuple[HeightStates, FloatArray]:
        """States in the middle of the step to the slip, shape (p, 1)."""
        fit = self.fit
        return fit.forward.onset(fit.p, fit.u[:, None], fit.heights, MIDDLE)

    def _demand(self, states: HeightStates, x0: FloatArray) -> FloatArray:
        return np.asarray(self.sign * states.demand(states.clip(x0))[:, 0])

    @cached_property
    def effects(self) -> FloatArray:
        """Change of μ0 per unit of each parameter that is not exact, shape (p, k)."""
        fit, forward = self.fit, self.fit.forward
        before = self._demand(*self._middle)
        found = np.empty((len(fit.u), int(fit.free.sum())))
        for column, k in enumerate(np.flatnonzero(fit.free).tolist()):
            other, step = forward.moved(fit.p, k), forward.step(k)
            u = fit.u + step * fit.moves[:, k]
            heights = fit.heights if not forward.of_rod(k) else forward.heights(other)[0]
            after = self._demand(*forward.onset(other, u[:, None], heights, MIDDLE))
            found[:, column] = (after - before) / step
        return found

    @cached_property
    def common(self) -> FloatArray:
        """Standard deviation of μ0 by what all periods share, shape (p,)."""
        return common_deviation(self.effects, self.fit.covariance)

    @cached_property
    def by_step(self) -> FloatArray:
        """Standard deviation of μ0 by the step of the stage, shape (p,)."""
        states, x0 = self._middle
        slope = states.demand_slope(states.clip(x0))[:, 0]
        return step_deviation(slope, self.fit.forward.ends.gap)

    def friction(self) -> Summary:
        """Distribution of μ0 in each period."""
        fit, parts = self.fit, []
        for start in range(0, len(fit.u), BLOCK):
            here = slice(start, start + BLOCK)
            u = fit.u[here, None] + self.own[here, None] * NOISE
            ends = fit.forward.ends.take(here)
            states, x0 = fit.forward.onset(fit.p, u, fit.heights, ONSET, ends)
            # As the tip did slip, the onset is neither past the lock nor beyond the end of pulling.
            possible = (x0 > states.x0_pull) & (x0 <= states.x0_lock)
            needed = states.demand(np.clip(x0, states.x0_pull, states.x0_lock))
            mu0 = self.sign[here, None] * needed + self.common[here, None] * COMMON
            parts.append(summary_of(np.where(possible & (mu0 > 0.0), mu0, np.inf)))
        return Summary.concatenate(parts)

    @cached_property
    def least(self) -> tuple[FloatArray, BoolArray]:
        """Least friction with which the tip can have stuck, and whether it stuck past the lock."""
        fit, margin = self.fit, HALF_WIDTH * self.own
        blocks = fit.forward.blocks
        of_ends = fit.forward.onset(fit.p, fit.u[:, None], fit.heights, np.zeros(1))
        of_blocks = fit.forward.states(fit.p, fit.u, fit.heights)
        found, locked = [], []
        for (states, x0), wide in ((of_blocks, margin[blocks.period]), (of_ends, margin[:, None])):
            found.append(_least_friction(states, x0 + wide, x0 - wide, self.level))
            locked.append(x0 - wide >= states.x0_lock)
        starts = blocks.starts
        return (
            np.maximum(np.maximum.reduceat(found[0], starts), found[1][:, 0]),
            np.logical_or.reduceat(locked[0], starts) | locked[1][:, 0],
        )

    @cached_property
    def mu_lock(self) -> FloatArray:
        """Largest friction at which a pushed tip slips at the end of each period, shape (p,)."""
        return self._middle[0].mu_lock[:, 0]


def _least_friction(
    states: HeightStates, low: FloatArray, high: FloatArray, level: bool
) -> FloatArray:
    """Bound μ0 from below by the friction with which the tip has stuck in some states.

    Parameters
    ----------
    states : HeightStates
    low, high : ndarray
        Displacements of pulled and of pushed states (L), of which is certain that they were
        reached.
    level : bool
        A level stage has taken the tip past the lock through it; an oblique one perhaps where the
        lock came to the tip.

    Returns
    -------
    ndarray
        NaN where the tip cannot have stuck.
    """
    pushed = states.demand(np.clip(high, 0.0, states.x0_lock if level else states.x0_end))
    # Where pulling ends, any friction would be needed.
    pulled = -states.demand(np.clip(low, 0.999 * states.x0_pull, 0.0))
    pushed = np.where(level & (high >= states.x0_lock), states.mu_lock, pushed)
    slipped = (high > states.x0_end) | (low < states.x0_pull)
    return np.asarray(np.where(slipped, np.nan, np.maximum(0.0, np.maximum(pushed, pulled))))


def read_periods(fit: Fit, slipped: Slipped) -> Periods:
    """Read the friction of the periods."""
    onsets = Onsets.of(fit, slipped)
    spans, recording, found = slipped.spans, slipped.recording, onsets.friction()
    status = _statuses(onsets, found, slipped)
    known, unknown = status == PeriodStatus.SLIP, status == PeriodStatus.BEYOND
    least, common = onsets.least[0], onsets.common
    least = np.where(status == PeriodStatus.LOCK, np.minimum(least, onsets.mu_lock), least)
    least = np.maximum(least - HALF_WIDTH * common, 0.0)
    empty = np.full(len(spans), "")
    return Periods(
        status=status,
        first=slipped.row[spans.begins],
        last=slipped.row[spans.ends],
        first_line=recording.line[spans.begins],
        last_line=recording.line[spans.ends],
        contact=fit.forward.contact(fit.p, fit.u, fit.heights),
        footpoint=recording.clamp[spans.ends],
        mu0=np.where(known, found.mean, np.nan),
        deviation=np.where(known, found.deviation, np.nan),
        low=np.where(known, found.low, np.where(unknown, np.nan, least)),
        high=np.where(known, found.high, np.nan),
        common=common,
        by_step=np.where(known, onsets.by_step, np.nan),
        shared=np.zeros(len(spans)),
        effects=onsets.effects,
        grade=empty,
        doubt=empty,
        left_out=recording.notes,
    )


def _statuses(onsets: Onsets, found: Summary, slipped: Slipped) -> StrArray:
    """Tell what is known about each period."""
    (least, past), spans = onsets.least, slipped.spans
    opened = spans.passes.copy()
    opened[-1] = True
    # Pulled back from past the lock a tip slips after all, but not pushed on.
    locked = slipped.swung | (past & (opened | (onsets.sign > 0.0)))
    # A tip that slipped when pushed has not stuck to more than that when it was pulled.
    never = np.isnan(least) | (~(locked | opened) & (onsets.sign > 0.0) & (least > onsets.mu_lock))
    return np.select(
        [never, locked, opened, np.isnan(found.mean)],
        [PeriodStatus.BEYOND, PeriodStatus.LOCK, PeriodStatus.OPEN, PeriodStatus.BEYOND],
        PeriodStatus.SLIP,
    )
