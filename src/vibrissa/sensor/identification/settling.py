"""Slips that last several samples, and readings that lag behind the clamp.

After a slip the readings may take a while to settle: the tip is in flight, or a low-pass filter
follows. All slips of a recording are laid over one another, with the misfit to the contact before
and to the contact after. Their means tell how many samples belong to neither.

A filter also lags while the tip sticks: its readings are those of the clamp a delay ago. A filter
that passes a constant unchanged has the same delay d for every load that grows evenly, and its
response S to a step tells it: d = ∫ (1 − S) dt (the derivative of its transfer function at 0). A
tip in flight looks the same after the slip, but does not lag.
"""

from dataclasses import dataclass, replace

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.sensor.identification.blocks import Blocks
from vibrissa.sensor.identification.fit import Fit
from vibrissa.sensor.identification.recording import Recording
from vibrissa.sensor.identification.slips import Spans, speed_of

# A period of fewer samples does not show when its readings have settled.
LONG = 20
# Part of a period whose samples have settled, and in which the next slip does not show yet.
MIDDLE = (0.4, 0.8)
# Fewer slips do not tell what they have in common.
FEWEST_SLIPS = 3
# Medians that are so many standard deviations off are not settled, and middles with a larger mean
# square do not tell it; √n times the standard deviation of a median of n normal values.
CLEAR, FITS, OF_MEDIAN = 5.0, 1.5, 1.2533
# Samples after and before a slip that are looked at, and slips.
AFTER, BEFORE, SLIPS = 500, 20, 200
# Blocks on either side of a slip that are looked at first.
BLOCKS = 5


@dataclass(frozen=True, kw_only=True)
class Settling:
    """Samples before and after a slip that belong to it, and the delay that they show (samples)."""

    early: int = 0
    late: int = 0
    delay: float = 0.0


def unsettled(fit: Fit, spans: Spans) -> bool:
    """Tell whether the blocks beside slips between long periods do not fit as the others do."""
    starts, long = fit.forward.blocks.starts, spans.counts >= LONG
    ends = np.append(starts[1:], len(fit.residuals)) - 1
    before, after = ends[:-1][long[:-1]], starts[1:][long[1:]]
    if len(before) < FEWEST_SLIPS or len(after) < FEWEST_SLIPS:
        return False
    beside = [*(before - k for k in range(BLOCKS)), *(after + k for k in range(BLOCKS))]
    off = [
        np.abs(np.median(fit.residuals[rows], axis=0)) * np.sqrt(len(rows)) / OF_MEDIAN
        for rows in beside
    ]
    return bool((np.array(off) > CLEAR).any())


def middles(spans: Spans) -> Spans:
    """Parts of the periods whose samples have settled; short periods as they are."""
    low, high = ((spans.counts * part).astype(int) for part in MIDDLE)
    long = spans.counts >= LONG
    begins = np.where(long, spans.begins + low, spans.begins)
    ends = np.where(long, spans.begins + high, spans.ends)
    return replace(spans, begins=begins, ends=ends)


def settling(fit: Fit, recording: Recording, spans: Spans) -> Settling:
    """Tell how long readings need to settle.

    Parameters
    ----------
    fit : Fit
        To the middles of the periods.
    recording : Recording
    spans : Spans
        The whole periods.
    """
    long = spans.counts >= LONG
    slips = np.flatnonzero(long[:-1] & long[1:] & ~spans.cut[:-1])[:SLIPS]
    usual = float((fit.residuals[fit.kept[fit.forward.blocks.period]] ** 2).mean())
    if len(slips) < FEWEST_SLIPS or usual > FITS:
        return Settling()
    seen = _Slips(fit=fit, recording=recording, slips=slips, spans=spans)
    early, late = seen.count(-1 - np.arange(BEFORE), 0), seen.count(np.arange(AFTER), 1)
    return Settling(early=early, late=late, delay=seen.delay(early, late) if early + late else 0.0)


@dataclass(frozen=True, eq=False, kw_only=True)
class _Slips:
    """Slips between long periods, laid over one another.

    Attributes
    ----------
    fit : Fit
    recording : Recording
    slips : ndarray of int, shape (s,)
        Number of the period that each ends.
    spans : Spans
    """

    fit: Fit
    recording: Recording
    slips: IntArray
    spans: Spans

    def _rows(self, steps: IntArray) -> tuple[IntArray, BoolArray]:
        """Rows beside each slip, and which of them are between the middles beside it."""
        ends, nexts = self.spans.ends[self.slips], self.spans.begins[self.slips + 1]
        low = ends - (self.spans.counts[self.slips] * (1.0 - MIDDLE[1])).astype(int)
        high = nexts + (self.spans.counts[self.slips + 1] * MIDDLE[0]).astype(int)
        rows = self.spans.after[self.slips][:, None] + steps
        there = (rows >= low[:, None]) & (rows <= high[:, None])
        return np.clip(rows, 0, len(self.recording) - 1), there

    def _expected(self, rows: IntArray, later: int) -> FloatArray:
        """Predict readings at rows, with the contact before or after the slip, (*rows, c)."""
        period = np.repeat(self.slips + later, rows.shape[1])
        flat, fit, recording = rows.ravel(), self.fit, self.recording
        blocks = Blocks(
            period=period,
            clamp=recording.clamp[flat],
            readings=recording.readings[flat],
            row=flat.astype(float),
            count=np.ones(len(flat), dtype=int),
        )
        forward = replace(fit.forward, blocks=blocks, speed=speed_of(recording.clamp)[flat])
        loads = forward.loads(fit.p, *forward.states(fit.p, fit.u, fit.heights))
        readings = forward.readings(fit.p, loads, blocks.row)[:, fit.noise.used]
        return np.asarray(readings / fit.noise.reading).reshape(*rows.shape, -1)

    def _measured(self, rows: IntArray) -> FloatArray:
        readings = self.recording.readings[rows][..., self.fit.noise.used]
        return np.asarray(readings / self.fit.noise.reading)

    def count(self, steps: IntArray, later: int) -> int:
        """Count the samples, from the slip on, that do not fit the contact in the mean."""
        rows, there = self._rows(steps)
        miss = self._measured(rows) - self._expected(rows, later)
        number = there.sum(axis=0)
        enough = number >= FEWEST_SLIPS
        seen = np.nanmedian(np.where(there[..., None], miss, np.nan)[:, enough], axis=0)
        off = np.abs(seen) * np.sqrt(number[enough])[:, None] / OF_MEDIAN
        fits = np.ones(len(steps), dtype=bool)
        fits[enough] = (off <= CLEAR).all(axis=1)
        return int(np.argmax(np.append(fits, True)))

    def delay(self, early: int, late: int) -> float:
        """Integrate what the step from one contact to the next still lacks, in samples."""
        rows, there = self._rows(np.arange(-early, late))
        start = self._expected(rows, 0)
        way = self._expected(rows, 1) - start
        gone = self._measured(rows) - start
        known = (way**2).sum(axis=-1)
        there &= known > 0.0
        part = np.divide((gone * way).sum(axis=-1), known, out=np.ones_like(known), where=there)
        lacking = (1.0 - part).sum(axis=0) / np.maximum(there.sum(axis=0), 1)
        return max(float(lacking.sum()), 0.0)
