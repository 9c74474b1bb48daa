"""Samples on the rod's branch, and the periods of sticking that they form.

Each sample of the clamp reactions lies on the branch, which gives its x0. The clamp position minus
x0 is the clamp position at α = 0 for the contact point of this sample, called its place here: it is
constant while the tip sticks and jumps where the tip slips. On an oblique stage each sample lies on
the branch of its own height, and its place is the contact point itself; see `Placed`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from scipy.spatial import KDTree

from vibrissa.numerics.arrays import BoolArray, FloatArray, Index, IntArray
from vibrissa.numerics.batch import Batch
from vibrissa.sensor.identification.recording import MOMENT, Recording
from vibrissa.sensor.response.branch import Branch
from vibrissa.sensor.stage import ObliqueStage

# States of a rod by the position of its clamp, on a stage along the surface or an oblique one.
Placed = Branch | ObliqueStage

# A jump of this many standard deviations is a slip: by chance one of 10^9 samples shows it.
JUMP = 6.0
# Squared residual, in standard deviations, from which on a sample is not a state of the rod.
MISFIT = 36.0
# Samples whose squared residual is larger than this many times the usual one are left out of a fit.
UNUSUAL = 9.0
# Points of the branch among which the nearest to a sample is sought, before Newton's steps.
TABLE = 4001
NEAREST_STEPS = 2
CONTACT_STEPS = 4
# Less noise than this, in the rod's own units, is none; readings in units of it can be squared.
LEAST_NOISE = 1e-50
# Samples that are located together, before progress is told.
BLOCK = 20000


@dataclass(frozen=True, eq=False, kw_only=True)
class Channels:
    """Channels that are used, and their noise.

    Attributes
    ----------
    used : list of int
        Numbers of the channels: 0 for fx, 1 for fy, 2 for m.
    noise : ndarray, shape (k,)
        Standard deviation of one reading of each.
    """

    used: list[int]
    noise: FloatArray

    @classmethod
    def recorded(cls, recording: Recording, noise: FloatArray) -> Self:
        """All channels that were recorded and have a noise."""
        there = np.isfinite(recording.readings).all(axis=0)
        used = np.flatnonzero(there & (noise > LEAST_NOISE) & (noise < np.inf))
        return cls(used=used.tolist(), noise=noise[used])

    def weighted(self, values: FloatArray) -> FloatArray:
        """Values of the channels that are used, in standard deviations, shape (..., k)."""
        return np.asarray(values[..., self.used] / self.noise)


@dataclass(frozen=True, eq=False, kw_only=True)
class Samples(Recording):
    """Samples of a recording, each with the state of the rod nearest to it.

    Attributes
    ----------
    row : ndarray of int, shape (n,)
        Number of the sample in the recording.
    x0, deviation : ndarray, shape (n,)
        Displacement and its standard deviation (L).
    misfit : ndarray, shape (n,)
        Squared residual, in standard deviations.
    start : ndarray, shape (n,)
        Place of a contact with x0 = 0 (L); see `Branch.above`.
    """

    row: IntArray
    x0: FloatArray
    deviation: FloatArray
    misfit: FloatArray
    start: FloatArray

    @property
    def place(self) -> FloatArray:
        """Place of the contact of each sample (L)."""
        return self.start - self.x0

    @property
    def usual(self) -> BoolArray:
        """Whether each sample fits as well as most, so that it may take part in a fit."""
        limit = max(MISFIT, UNUSUAL * float(np.median(self.misfit)))
        return np.asarray(self.misfit <= limit)


@dataclass(frozen=True, eq=False, kw_only=True)
class Partition:
    """Samples cut into periods.

    Attributes
    ----------
    begins : ndarray of int, shape (p,)
        First sample of each period.
    size : int
        Number of samples.
    """

    begins: IntArray
    size: int

    def __len__(self) -> int:
        """Return the number of periods."""
        return len(self.begins)

    @property
    def counts(self) -> IntArray:
        """Number of samples of each period."""
        return np.diff(self.begins, append=self.size)

    @property
    def ends(self) -> IntArray:
        """Last sample of each period."""
        return self.begins + self.counts - 1

    def sums(self, values: FloatArray) -> FloatArray:
        """Add up the values of the samples of each period, along the first axis."""
        return np.asarray(np.add.reduceat(values, self.begins))

    def spread(self, values: FloatArray) -> FloatArray:
        """Repeat the value of each period for its samples."""
        return np.repeat(values, self.counts, axis=0)

    def take(self, index: Index) -> "Partition":
        """Keep some of the beginnings: the other periods go to the one before."""
        return Partition(begins=self.begins[index], size=self.size)


@dataclass(frozen=True, eq=False, kw_only=True)
class Contacts(Batch):
    """One contact point for each period.

    Attributes
    ----------
    place, deviation : ndarray, shape (p,)
        Place of this contact, and its standard deviation (L).
    """

    place: FloatArray
    deviation: FloatArray


def located(
    branch: Placed,
    recording: Recording,
    channels: Channels,
    progress: Callable[[int], None] = lambda done: None,
) -> Samples:
    """Find the state of the rod that is nearest to each sample.

    Parameters
    ----------
    branch : Branch or ObliqueStage
    recording : Recording
    channels : Channels
    progress : callable
        Told how many samples are done.

    Returns
    -------
    Samples
    """
    size = len(recording)
    weighted = channels.weighted(recording.readings)
    found = Samples(
        clamp=recording.clamp,
        readings=recording.readings,
        line=recording.line,
        notes=recording.notes,
        interval=recording.interval,
        slipping=recording.slipping,
        excess=recording.excess,
        row=np.arange(size),
        x0=np.empty(size),
        deviation=np.empty(size),
        misfit=np.empty(size),
        start=branch.above(recording.clamp)[1],
    )
    done = 0
    for guide, near in branch.guides(recording.clamp):
        table = np.linspace(guide.x0_pull, guide.x0_end, TABLE)
        values = channels.weighted(guide(table))
        if channels.used == [MOMENT]:
            # The moment alone distinguishes the states only as long as it grows.
            back = np.flatnonzero(np.diff(values[:, 0]) <= 0.0)
            stop = int(back[0]) + 1 if len(back) else TABLE
            table, values = table[:stop], values[:stop]
        before_lock = KDTree(values[: int(np.searchsorted(table, guide.x0_lock)) + 1])
        whole = KDTree(values)
        for start in range(0, len(near), BLOCK):
            rows = near[start : start + BLOCK]
            _locate(found, rows, branch, channels, weighted, table, before_lock)
            # Past the lock the branch may come near to states before it: only what is none of
            # those.
            past = rows[found.misfit[rows] > MISFIT]
            if len(past):
                _locate(found, past, branch, channels, weighted, table, whole)
            done += len(rows)
            progress(done)
    return found


def _locate(
    samples: Samples,
    rows: IntArray,
    branch: Placed,
    channels: Channels,
    weighted: FloatArray,
    table: FloatArray,
    tree: Any,
) -> None:
    """Find the nearest state of some samples: the nearest of a table, then Gauss-Newton steps."""
    read, (states, _) = weighted[rows], branch.above(samples.clamp[rows])
    x0, known = states.clip(table[tree.query(read)[1]]), np.empty(0)
    for _ in range(NEAREST_STEPS):
        slope = channels.weighted(states.slope(x0))
        # Inverse variance of x0: it adds up over channels, and over samples of one contact.
        known = (slope**2).sum(axis=1)
        miss = read - channels.weighted(states(x0))
        x0 = np.clip(x0 + (slope * miss).sum(axis=1) / known, table[0], table[-1])
        x0 = states.clip(x0)
    samples.x0[rows] = x0
    samples.deviation[rows] = 1.0 / np.sqrt(known)
    samples.misfit[rows] = ((read - channels.weighted(states(x0))) ** 2).sum(axis=1)


def cut(samples: Samples) -> Partition:
    """Cut samples into periods of sticking: one begins where the contact jumps."""
    begins = np.flatnonzero(_jumps(samples)) + 1
    return Partition(begins=np.append(0, begins), size=len(samples))


def _jumps(samples: Samples, apart: int = 1) -> BoolArray:
    """Whether the contact differs between samples that are so many rows apart."""
    place, deviation = samples.place, samples.deviation
    allowed = JUMP * np.hypot(deviation[apart:], deviation[:-apart])
    return np.asarray(np.abs(place[apart:] - place[:-apart]) > allowed)


def lone_spikes(samples: Samples) -> BoolArray:
    """Whether a sample jumps away and the next one back to where it was."""
    lone = np.zeros(len(samples), dtype=bool)
    one = _jumps(samples)
    lone[1:-1] = one[:-1] & one[1:] & ~_jumps(samples, 2)
    return lone


def fitted(
    branch: Placed,
    samples: Samples,
    channels: Channels,
    periods: Partition,
    start: FloatArray,
    steps: int = CONTACT_STEPS,
) -> Contacts:
    """Fit one contact to all samples of each period, by least squares.

    Parameters
    ----------
    branch : Branch or ObliqueStage
    samples : Samples
        Of n samples, without offsets.
    channels : Channels
    periods : Partition
        Of p periods.
    start : ndarray, shape (p,)
        First guess of their places (L).
    steps : int
        Gauss-Newton steps.

    Returns
    -------
    Contacts
    """
    place, known = start, np.empty(0)
    states, _ = branch.above(samples.clamp)
    for _ in range(steps):
        x0 = states.clip(samples.start - periods.spread(place))
        slope = channels.weighted(states.slope(x0))
        miss = channels.weighted(samples.readings - states(x0))
        known = periods.sums((slope**2).sum(axis=1))
        place = place - periods.sums((slope * miss).sum(axis=1)) / known
    return Contacts(place=place, deviation=1.0 / np.sqrt(known))


def joined_past_lock(
    branch: Placed, samples: Samples, channels: Channels, periods: Partition, contacts: Contacts
) -> BoolArray:
    """Tell which periods go on with the contact of the one before, which has passed its lock.

    Past the lock one channel may turn back and show a slip where there is none.

    Parameters
    ----------
    branch, samples, channels, periods
        As for `fitted`.
    contacts : Contacts
        Of p periods.

    Returns
    -------
    ndarray of bool, shape (p,)
    """
    joined = np.zeros(len(periods), dtype=bool)
    own = 0
    for i, row in enumerate(periods.begins[1:], start=1):
        place, deviation = contacts.place[own], contacts.deviation[own]
        before, _ = branch.above(samples.clamp[row - 1])
        states, _ = branch.above(samples.clamp[row])
        x0 = samples.start[row] - place
        past = samples.start[row - 1] - place > before.x0_lock
        if past and states.x0_pull < x0 < states.x0_end:
            blur = np.hypot(channels.noise, states.slope(x0)[channels.used] * deviation)
            miss = (samples.readings[row] - states(x0))[channels.used] / blur
            joined[i] = (miss**2).sum() < MISFIT
        own = own if joined[i] else i
    return joined
