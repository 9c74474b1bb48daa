"""Recordings in which a round rod swings aside: cut into parts with the tip on one side each.

Behind the clamp the rod is the mirror image of what it was. So a part in which it is there is
mirrored, too (clamp position, force_x and moment_z change their signs), and is then the recording
of a tip ahead that is pulled back.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.sensor.identification.calibration import Setup
from vibrissa.sensor.identification.periods import (
    JUMP,
    MISFIT,
    Channels,
    Partition,
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
    """Samples with the tip on one side of the clamp, mirrored where it is behind.

    Attributes
    ----------
    side : int
        1 where the tip is ahead of the clamp, −1 where it is behind.
    setup : Setup
        Mirrored likewise.
    samples : Samples
        Those that are states of the rod, spikes left out.
    off, lone : Samples
        Those that are not, and spikes.
    swung : bool
        Whether it begins where the rod swings aside.
    """

    side: int
    setup: Setup
    samples: Samples
    off: Samples
    lone: Samples
    swung: bool

    @classmethod
    def of(cls, side: int, setup: Setup, samples: Samples) -> Self:
        """Leave out what is no state of the rod, and spikes."""
        off = samples.misfit > MISFIT
        states = samples.take(~off)
        lone = lone_spikes(states)
        return cls(
            side=side,
            setup=setup,
            samples=states.take(~lone),
            off=samples.take(off),
            lone=states.take(lone),
            swung=bool(samples.row[0] > 0),
        )

    def with_all(self) -> Self:
        """Take back what was left out."""
        every = Samples.concatenate([self.samples, self.off, self.lone])
        return replace(self, samples=every.take(np.argsort(every.row)))

    def only(self, kept: BoolArray) -> Self:
        """Keep some of the samples."""
        return replace(self, samples=self.samples.take(kept))

    def cut(self, channels: Channels) -> tuple[Partition, FloatArray]:
        """Cut the samples into periods, some of them joined; guess their places (L)."""
        branch = self.setup.branch
        # Past the lock the place is the one that the period has before; after a swing, later.
        order = slice(None, None, -1 if self.swung else 1)
        samples = self.samples.take(order)
        periods, without = cut(samples), samples.without(self.setup.offset)
        start = periods.sums(samples.place) / periods.counts
        contacts = fitted(branch, without, channels, periods, start)
        own = ~joined_past_lock(branch, without, channels, periods, contacts)
        periods, place = periods.take(own), contacts.place[own]
        return (periods.reversed() if self.swung else periods), place[order]

    def seen(self, channels: Channels) -> Seen:
        """Fit a contact to each period."""
        periods, start = self.cut(channels)
        without = self.samples.without(self.setup.offset)
        return Seen.fitted(self.setup.branch, without, channels, periods, start)


def parts_of(
    setup: Setup,
    recording: Recording,
    channels: Channels,
    progress: Callable[[int], None] = lambda done: None,
) -> list[Part]:
    """Locate the samples on the rod's branch, and cut them where the rod swings aside.

    Parameters
    ----------
    setup : Setup
    recording : Recording
        It begins with the tip ahead of the clamp.
    channels : Channels
    progress : callable
        Told how many samples are done.

    Returns
    -------
    list of Part
        One, unless the rod swings aside.
    """
    parts, side, first = [], 1, 0
    samples = located(setup.branch, recording, channels, setup.offset, progress)
    while (swing := _swing(side, setup, samples, channels)) is not None:
        before = Part.of(side, setup, samples.take(slice(swing.begin)))
        between = samples.take(slice(swing.begin, swing.end))
        parts.append(replace(before, off=Samples.concatenate([before.off, between])))
        side, first = -side, first + swing.end
        setup, rest = setup.mirrored(), recording.take(slice(first, None))
        rest = rest if side > 0 else rest.mirrored()
        samples = located(setup.branch, rest, channels, setup.offset)
        samples.row[:] += first
    return [*parts, Part.of(side, setup, samples)]


class _Swing(NamedTuple):
    """Samples in which the rod may swing aside: from `begin` to before `end`."""

    begin: int
    end: int


def _swing(side: int, setup: Setup, samples: Samples, channels: Channels) -> _Swing | None:
    """Find where the rod swings aside; None if it does not.

    The tip locks, and once the clamp has passed under it the samples are those of the same contact
    on the other side. A real rod may swing a little later: then there are samples in between.
    """
    part = Part.of(side, setup, samples)
    states, _ = setup.branch.above(part.samples.clamp)
    if not (setup.branch.swings and (part.samples.x0 >= states.x0_lock).any()):
        return None
    seen = part.seen(channels)
    for period in np.flatnonzero(seen.locked):
        place, deviation = seen.contacts.place[period], seen.contacts.deviation[period]
        later = samples.row > seen.samples.row[seen.periods.begins[period]]
        there = later & _trails(setup, samples, channels, place, deviation)
        runs = np.flatnonzero(np.convolve(there, np.ones(ENOUGH), "valid") == ENOUGH)
        if len(runs):
            states, start = setup.branch.above(samples.clamp)
            passed = later & (start - place > states.x0_end + JUMP * deviation)
            begins = np.flatnonzero(passed[: runs[0]])
            return _Swing(begin=int(np.append(begins, runs[0])[0]), end=int(runs[0]))
    return None


def _trails(
    setup: Setup, samples: Samples, channels: Channels, place: float, deviation: float
) -> BoolArray:
    """Tell which samples are those of one contact after the rod has swung aside."""
    used, (states, start) = channels.used, setup.branch.above(samples.clamp)
    x0 = start - place
    past = x0 - states.x0_end
    over = past > 0.0
    # The tail that lies on the surface turns about the contact point, at the height of the swing.
    after = max(int(np.argmax(over)), 1)
    around = slice(after - 1, after + 1)
    tails = np.broadcast_to(states.x1_init - states.x0_end, x0.shape)
    tail = np.interp(0.0, past[around], tails[around])
    behind = 2.0 * (states.x1_init - tail) - x0
    possible = over & (behind > states.x0_pull)
    behind = states.clip(behind)
    blur = np.hypot(channels.noise, states.slope(behind)[:, used] * deviation)
    expected = setup.offset + states(behind) * MIRROR
    miss = (samples.readings - expected)[:, used] / blur
    return np.asarray(possible & ((miss**2).sum(axis=1) < MISFIT))
