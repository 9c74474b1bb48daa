"""Periods of sticking as one setup shows them: what the friction is read from."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.sensor.identification.alternatives import Alternative
from vibrissa.sensor.identification.periods import (
    Channels,
    Contacts,
    Partition,
    Placed,
    Samples,
    fitted,
)
from vibrissa.sensor.identification.reading.uncertainty import (
    HALF_WIDTH,
    LastStates,
    least_friction,
)
from vibrissa.sensor.response.branch import Branch
from vibrissa.sensor.response.height_range import HeightStates


@dataclass(frozen=True, eq=False, kw_only=True)
class Seen:
    """Periods of sticking as one setup shows them.

    Attributes
    ----------
    branch : Branch or ObliqueStage
    samples : Samples
        Without offsets.
    channels : Channels
    periods : Partition
        Of p periods.
    contacts : Contacts
    """

    branch: Placed
    samples: Samples
    channels: Channels
    periods: Partition
    contacts: Contacts

    @classmethod
    def fitted(
        cls,
        branch: Placed,
        samples: Samples,
        channels: Channels,
        periods: Partition,
        start: FloatArray,
    ) -> Self:
        """Fit the contacts, from a first guess of their places; see `periods.fitted`."""
        samples = replace(samples, start=branch.above(samples.clamp)[1])
        contacts = fitted(branch, samples, channels, periods, start)
        return cls(
            branch=branch, samples=samples, channels=channels, periods=periods, contacts=contacts
        )

    @cached_property
    def last(self) -> LastStates:
        """Last sticking state of each period, by its contact alone."""
        start, clamp, ends = self.samples.start, self.samples.clamp, self.periods.ends
        after = np.minimum(ends + 1, len(clamp) - 1)
        none = np.zeros(len(ends))
        clamp_gap, lag_low, lag_high = clamp[after] - clamp[ends], none, none
        slipping = self.samples.slipping
        if slipping is not None:
            way = slipping.way[ends]
            clamp_gap = np.where(np.isnan(way), clamp_gap, way)
            lag_low, lag_high = slipping.lag_low[ends], slipping.lag_high[ends]
        x0 = start[ends] - self.contacts.place
        gap = self.branch.above(clamp[ends] + clamp_gap)[1] - start[ends]
        return LastStates(
            clamp=clamp[ends],
            clamp_gap=clamp_gap,
            travel=x0,
            deviation=self.contacts.deviation,
            gap=gap,
            sign=np.where(gap == 0.0, np.sign(x0), np.sign(gap)),
            base=none if self.samples.excess is None else self.samples.excess[ends],
            lag_low=lag_low,
            lag_high=lag_high,
        )

    @cached_property
    def states(self) -> Branch | HeightStates:
        """States at the clamp positions of all samples."""
        return self.branch.above(self.samples.clamp)[0]

    @cached_property
    def ending(self) -> Branch | HeightStates:
        """States at the last clamp position of each period."""
        return self.branch.above(self.samples.clamp[self.periods.ends])[0]

    @cached_property
    def x0(self) -> FloatArray:
        """Displacement of each sample from the contact of its period (L)."""
        return self.samples.start - self.periods.spread(self.contacts.place)

    @cached_property
    def residuals(self) -> FloatArray:
        """Residuals of the channels that are used, in standard deviations, shape (n, k)."""
        expected = self.states(self.states.clip(self.x0))
        return self.channels.weighted(self.samples.readings - expected)

    def by(self, channels: Channels) -> Self:
        """See the same periods by other channels."""
        place = self.contacts.place
        return self.fitted(self.branch, self.samples, channels, self.periods, place)

    def without_noise(self) -> Self:
        """See the same periods with the same contacts as if the readings had no error."""
        contacts = replace(self.contacts, deviation=np.zeros(len(self.periods)))
        channels = replace(self.channels, noise=np.zeros(len(self.channels.noise)))
        return replace(self, contacts=contacts, channels=channels)

    def only(self, kept: BoolArray) -> Self:
        """See some of the periods, of p."""
        samples = self.samples.take(np.repeat(kept, self.periods.counts))
        counts = self.periods.counts[kept]
        periods = Partition(begins=np.cumsum(counts) - counts, size=len(samples))
        return replace(self, samples=samples, periods=periods, contacts=self.contacts.take(kept))

    def as_if(self, other: Alternative) -> Self:
        """See the same periods as if something were other than given.

        The contacts move along, so that the displacements stay the same in the mean of a period.
        """
        branch = self.branch if other.branch is None else other.branch
        samples = other.undone(self.samples)
        samples = replace(samples, start=branch.above(samples.clamp)[1])
        moved = self.periods.sums(samples.start - self.samples.start) / self.periods.counts
        contacts = replace(self.contacts, place=self.contacts.place + moved)
        return replace(self, branch=branch, samples=samples, contacts=contacts)

    @cached_property
    def exact(self) -> Self:
        """The same with readings without noise of all channels, for what is told to first order.

        A fit to a change that contains the noise would be biased by it.
        """
        inside = self.states.clip(self.x0)
        return replace(self, samples=replace(self.samples, readings=self.states(inside), x0=inside))

    def effect_of(self, other: Alternative) -> FloatArray:
        """Change of the readings per unit of an alternative, in standard deviations, shape (n, k).

        To first order; without what a shift of the contacts explains.
        """
        exact = self.exact
        before = 0.0 if other.base is None else exact.as_if(other.before).residuals
        change = (before - exact.as_if(other).residuals) / other.step
        shift = self._shift
        along = self.periods.sums((shift * change).sum(axis=1))
        known = self.periods.sums((shift**2).sum(axis=1))
        # Where no reading tells the contact, none is shifted.
        along = np.divide(along, known, out=np.zeros_like(along), where=known > 0.0)
        return np.asarray(change - shift * self.periods.spread(along)[:, None])

    @cached_property
    def _shift(self) -> FloatArray:
        """Change of the readings per shift of the contact, in standard deviations, shape (n, k)."""
        return self.channels.weighted(self.states.slope(self.states.clip(self.x0)))

    def nearby(self, other: Alternative) -> Self:
        """See the periods without noise as if something were a little other, with its contacts."""
        seen = self.exact.as_if(other)
        contacts = fitted(
            seen.branch, seen.samples, seen.channels, seen.periods, seen.contacts.place, steps=1
        )
        return replace(seen, contacts=contacts)

    @cached_property
    def _margin(self) -> FloatArray:
        """Half the width of the central 95 % of each sample's displacement (L)."""
        return HALF_WIDTH * self.periods.spread(self.contacts.deviation)

    @cached_property
    def least(self) -> FloatArray:
        """Least friction with which the tip can have stuck so far."""
        needed = least_friction(self.states, self.x0 + self._margin, self.x0 - self._margin)
        return np.asarray(np.maximum.reduceat(needed, self.periods.begins))

    @property
    def locked(self) -> BoolArray:
        """Whether the tip has stuck past the lock."""
        past = self.x0 - self._margin >= self.states.x0_lock
        return np.asarray(np.logical_or.reduceat(past, self.periods.begins))
