"""Samples of a recording on the rod's branch, up to where the rod swings aside.

A round rod whose tip has locked may swing out of its plane and come to rest behind the clamp, as
the mirror image of what it was. What comes after that is not read.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.identification.periods import (
    Channels,
    Partition,
    Placed,
    Samples,
    cut,
    fitted,
    joined_past_lock,
    located,
    lone_spikes,
)
from vibrissa.sensor.identification.recording import MIRROR, Recording
from vibrissa.sensor.identification.seen import Seen

# So many samples in a row show that the rod has swung aside: fewer may be spikes.
ENOUGH = 4


@dataclass(frozen=True, eq=False, kw_only=True)
class Part:
    """Samples of a recording, each located on the rod's branch.

    Attributes
    ----------
    branch : Branch or ObliqueStage
    samples : Samples
        Those that fit the rod as well as most, spikes left out.
    off, lone : Samples
        Those that are not, and spikes.
    """

    branch: Placed
    samples: Samples
    off: Samples
    lone: Samples

    @classmethod
    def of(
        cls,
        branch: Placed,
        recording: Recording,
        channels: Channels,
        progress: Callable[[int], None] = lambda done: None,
    ) -> Self:
        """Locate the samples; leave out what fits much worse than most, and spikes.

        Parameters
        ----------
        branch : Branch or ObliqueStage
        recording : Recording
        channels : Channels
        progress : callable
            Told how many samples are done.
        """
        samples = located(branch, recording, channels, progress)
        off = ~samples.usual
        states = samples.take(~off)
        lone = lone_spikes(states)
        return cls(
            branch=branch,
            samples=states.take(~lone),
            off=samples.take(off),
            lone=states.take(lone),
        )

    def with_all(self) -> Self:
        """Take back what was left out."""
        every = Samples.concatenate([self.samples, self.off, self.lone])
        return replace(self, samples=every.take(np.argsort(every.row)))

    def cut(self, channels: Channels) -> tuple[Partition, FloatArray]:
        """Cut the samples into periods, some of them joined; guess their places (L)."""
        periods = cut(self.samples)
        start = periods.sums(self.samples.place) / periods.counts
        contacts = fitted(self.branch, self.samples, channels, periods, start)
        own = ~joined_past_lock(self.branch, self.samples, channels, periods, contacts)
        return periods.take(own), contacts.place[own]

    def seen(self, channels: Channels) -> Seen:
        """Fit a contact to each period."""
        periods, start = self.cut(channels)
        return Seen.fitted(self.branch, self.samples, channels, periods, start)


def before_swing(branch: Placed, recording: Recording, channels: Channels) -> Recording:
    """Cut a recording where the rod swings aside, and note the line.

    From there on the samples are no states of the rod, and those of its mirror image are; the tip
    has locked before.

    Parameters
    ----------
    branch : Branch or ObliqueStage
    recording : Recording
    channels : Channels

    Returns
    -------
    Recording
        The same if the rod does not swing aside.
    """
    if not branch.swings:
        return recording
    samples = located(branch, recording, channels)
    states, _ = branch.above(samples.clamp)
    usual = samples.usual
    locked = usual & (samples.x0 >= states.x0_lock)
    if not locked.any():
        return recording
    turned = replace(recording, readings=recording.readings * MIRROR)
    behind = located(branch, turned, channels).misfit <= samples.misfit[usual].max()
    behind &= ~usual & (samples.row > int(np.argmax(locked)))
    runs = np.flatnonzero(np.convolve(behind, np.ones(ENOUGH), "valid") == ENOUGH)
    if not len(runs):
        return recording
    end = int(np.flatnonzero(usual[: runs[0]])[-1]) + 1
    note = (
        f"the rod swings aside in line {recording.line[end]}: what follows is not read; begin a "
        "new recording there"
    )
    return replace(recording.take(slice(end)), notes=(*recording.notes, note))
