"""Slips that last several samples, and readings that a filter smears over them.

After a slip the readings may take a while to settle: the tip is in flight, or a low-pass filter
follows. All slips of a recording are laid over one another, with the misfit to the contact before
and to the contact after. Their means tell how many samples belong to neither; these are left out.

A filter also lags while the tip sticks: its readings are those of the clamp a delay ago. A filter
that passes a constant unchanged has the same delay d for every load that grows evenly, and its
response S to a step tells it: d = ∫ (1 − S) dt (the derivative of its transfer function at 0). A
tip in flight looks the same after the slip, but does not lag. Unless it is told which of them it
is, either may be.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from scipy.ndimage import uniform_filter1d

from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.sensor.identification.periods import (
    MISFIT,
    Channels,
    Partition,
    Placed,
    cut,
    fitted,
    located,
)
from vibrissa.sensor.identification.recording import Recording, Slipping, left_out
from vibrissa.sensor.quantities import Kind, Units

# A period of fewer samples does not show when its readings have settled.
LONG = 20
# Part of a period whose samples have settled, and in which the next slip does not show yet.
MIDDLE = (0.4, 0.8)
# Fewer slips do not tell what they have in common.
FEWEST_SLIPS = 3
# Mean squares that are so many standard deviations larger than those in the middle of the periods
# are not settled.
CLEAR = 5.0
# A smaller mean square is rounding: the readings of a simulation may have no noise.
ROUNDING = 1e-9
# Samples before and after a slip that are looked at.
BEFORE, AFTER = 5, 500
# Samples over which the way of the clamp is averaged.
STEPS = 9


@dataclass(frozen=True, kw_only=True)
class Told:
    """What is known of slips and filter, in samples; None where it is not.

    Attributes
    ----------
    slip : float or None
        How long a slip lasts.
    delay : float or None
        By which the readings lag.
    """

    slip: float | None = None
    delay: float | None = None


def settled(
    branch: Placed, recording: Recording, channels: Channels, told: Told, units: Units
) -> Recording:
    """Leave out what belongs to slips, and say by how much the readings may lag.

    Parameters
    ----------
    branch : Branch or ObliqueStage
    recording : Recording
    channels : Channels
        All that were recorded.
    told : Told
    units : Units
        In which the notes name lengths.

    Returns
    -------
    Recording
        The same if slips are instantaneous, or fewer than `FEWEST_SLIPS` are seen.
    """
    slips = _Slips.of(branch, recording, channels)
    early, late, delay = 0, 0, 0.0
    if slips is not None:
        early, late = slips.unsettled()
        delay = slips.delay(early, late) if early + late else 0.0
        late = late if told.slip is None else max(late, int(np.ceil(told.slip)))
        # Of a slip that takes a while the first sample may not show it.
        early = max(early, 1) if late else early
    low, high = 0.0, 0.0 if told.slip is not None else delay
    if told.delay is not None:
        low = high = told.delay
    if not (early or late or high):
        return recording
    way, kept = np.full(len(recording), np.nan), np.ones(len(recording), dtype=bool)
    if slips is not None:
        for first, end in slips.spans():
            last = first - 1 - early
            way[last] = recording.clamp[first] - recording.clamp[last]
            kept[last + 1 : min(first + late, end)] = False
    step = uniform_filter1d(np.gradient(recording.clamp), STEPS, mode="nearest")
    slipping = Slipping(way=way, lag_low=low * step, lag_high=high * step)
    notes = left_out(recording.line[~kept], "the readings have not settled after a slip")
    if high:
        usual = float(np.median(np.abs(step)))
        sizes = (units.spelled(lag * usual, Kind.LENGTH, 3) for lag in dict.fromkeys((low, high)))
        notes += (f"the readings lag behind the clamp by {' or '.join(sizes)}",)
    return replace(recording, slipping=slipping, notes=recording.notes + notes).take(kept)


@dataclass(frozen=True, eq=False, kw_only=True)
class _Slips:
    """Slips between long periods, each by its rows in the recording.

    Attributes
    ----------
    first : ndarray of int, shape (s,)
        First row that does not fit the contact before.
    low, high : ndarray of int, shape (s,)
        Rows at the end of the middle of the period before, and at the beginning of that of the
        period after.
    before, after : ndarray, shape (s,)
        Places of these contacts (L).
    usual : float
        Mean squared misfit in the middles of the periods.
    regular : ndarray of bool, shape (s,)
        Whether the tip comes to the contact after as soon as after most slips. Where a short period
        lies between, it rests at a third place first.
    """

    branch: Placed
    recording: Recording
    channels: Channels
    first: IntArray
    low: IntArray
    high: IntArray
    before: FloatArray
    after: FloatArray
    usual: float
    regular: BoolArray

    @classmethod
    def of(cls, branch: Placed, recording: Recording, channels: Channels) -> Self | None:
        """Find the slips; None if they are too few."""
        samples = located(branch, recording, channels)
        states = samples.take(samples.misfit <= MISFIT)
        if not len(states):
            return None
        periods = cut(states)
        long = np.flatnonzero(periods.counts >= LONG)
        if len(long) <= FEWEST_SLIPS:
            return None
        begins, counts = periods.begins[long], periods.counts[long]
        low, high = (begins + (counts * part).astype(int) for part in MIDDLE)
        middle = states.take(
            np.concatenate([np.arange(a, b) for a, b in zip(low, high, strict=True)])
        )
        parts = Partition(begins=np.cumsum(high - low) - (high - low), size=len(middle))
        start = parts.sums(middle.place) / parts.counts
        contacts = fitted(branch, middle, channels, parts, start)
        expected = _expected(branch, middle.clamp, channels, parts.spread(contacts.place))
        misfit = ((channels.weighted(middle.readings) - expected) ** 2).sum(axis=-1)
        usual = max(float(misfit.mean()), ROUNDING)
        before = states.row[high[:-1] - 1]
        found = cls(
            branch=branch,
            recording=recording,
            channels=channels,
            first=before,
            low=before,
            high=states.row[low[1:]],
            before=contacts.place[:-1],
            after=contacts.place[1:],
            usual=usual,
            regular=np.ones(len(long) - 1, dtype=bool),
        )
        return found._begun()

    def _begun(self) -> Self | None:
        """Find where each slip begins."""
        rows, there = self._rows(self.low, np.arange(1, AFTER + 1))
        off = there & (self._misfit(rows, self.before) > MISFIT)
        first = self.low + 1 + np.argmax(off, axis=1)
        near = off.any(axis=1)
        found = replace(
            self,
            first=first[near],
            low=self.low[near],
            high=self.high[near],
            before=self.before[near],
            after=self.after[near],
        )
        found = replace(found, regular=found._arrived())
        return found if found.regular.sum() >= FEWEST_SLIPS else None

    def _arrived(self) -> BoolArray:
        """Tell which slips have come to their contact by the time at which most have."""
        rows, there = self._rows(self.first, np.arange(AFTER))
        off = there & (self._misfit(rows, self.after) > MISFIT)
        few = 2 * off.sum(axis=0) < there.sum(axis=0)
        return ~off[:, int(np.argmax(np.append(few, True)[:AFTER]))]

    def spans(self) -> list[tuple[int, int]]:
        """List the first row of each slip and a row that has settled; the last may end nowhere."""
        found = list(zip(self.first.tolist(), self.high.tolist(), strict=True))
        rows = np.arange(self.high[-1], len(self.recording))
        off = np.flatnonzero(self._misfit(rows[None], self.after[-1:])[0] > MISFIT)
        return [*found, (int(rows[off[0]]), len(self.recording))] if len(off) else found

    def _rows(self, begin: IntArray, steps: IntArray) -> tuple[IntArray, BoolArray]:
        """Rows from those at which something begins, and which are between the two middles."""
        rows = begin[:, None] + steps
        there = (rows >= self.low[:, None]) & (rows <= self.high[:, None])
        return np.clip(rows, 0, len(self.recording) - 1), there

    def _expected(self, rows: IntArray, place: FloatArray) -> FloatArray:
        """Give the loads at rows with the contact of each slip, in standard deviations."""
        return _expected(self.branch, self.recording.clamp[rows], self.channels, place[:, None])

    def _misfit(self, rows: IntArray, place: FloatArray) -> FloatArray:
        """Squared misfit of rows with the contact of each slip."""
        read = self.channels.weighted(self.recording.readings[rows])
        return np.asarray(((read - self._expected(rows, place)) ** 2).sum(axis=-1))

    def unsettled(self) -> tuple[int, int]:
        """Count the samples before and after `first` that fit neither contact."""
        return (
            self._count(-np.arange(1, BEFORE + 1), self.before),
            self._count(np.arange(AFTER), self.after),
        )

    def _count(self, steps: IntArray, place: FloatArray) -> int:
        rows, there = self._rows(self.first, steps)
        there &= self.regular[:, None]
        number = there.sum(axis=0)
        mean = np.where(there, self._misfit(rows, place), 0.0).sum(axis=0) / np.maximum(number, 1)
        spread = np.sqrt(2.0 / np.maximum(number * len(self.channels.used), 1))
        fits = (mean <= self.usual * (1.0 + CLEAR * spread)) | (number < FEWEST_SLIPS)
        return int(np.argmax(np.append(fits, True)))

    def delay(self, early: int, late: int) -> float:
        """Integrate what the step from one contact to the next still lacks, in samples."""
        rows, there = self._rows(self.first, np.arange(-early, late))
        there &= self.regular[:, None]
        start = self._expected(rows, self.before)
        way = self._expected(rows, self.after) - start
        gone = self.channels.weighted(self.recording.readings[rows]) - start
        known = (way**2).sum(axis=-1)
        there &= known > 0.0
        part = np.divide((gone * way).sum(axis=-1), known, out=np.ones_like(known), where=there)
        lacking = (1.0 - part).sum(axis=0) / np.maximum(there.sum(axis=0), 1)
        return max(float(lacking.sum()), 0.0)


def _expected(
    branch: Placed, clamp: FloatArray, channels: Channels, place: FloatArray
) -> FloatArray:
    """Give the loads at clamp positions with a contact at a place, in standard deviations."""
    states, start = branch.above(clamp)
    return channels.weighted(states(states.clip(start - place)))
