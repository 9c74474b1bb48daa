"""A made-up rod whose loads grow evenly, and periods of which nothing else matters."""

import numpy as np

from vibrissa.sensor.identification.friction import Periods, PeriodStatus
from vibrissa.sensor.identification.periods import Channels, Contacts, Partition, Samples
from vibrissa.sensor.identification.seen import Seen

# Change of fx, fy and m per displacement.
SLOPES = np.array([-2.0, 0.5, 4.0])


class Straight:
    """Loads of (−2, 1/2, 4)·x0 beside fy = −1, and an energy of x0²; the lock is at 1/2.

    The place of a contact is the position of the clamp at which x0 = 0.
    """

    x0_pull, x0_lock, x0_end, mu_lock, x1_init, swings = -0.5, 0.5, 0.8, 1.0, 1.0, False

    def above(self, clamp):
        return self, np.array(clamp, dtype=float)

    def guides(self, clamp):
        yield self, np.arange(len(clamp))

    def clip(self, x0):
        return np.clip(x0, self.x0_pull, self.x0_end)

    def __call__(self, x0):
        return np.multiply.outer(x0, SLOPES) + np.array([0.0, -1.0, 0.0])

    def slope(self, x0):
        return np.broadcast_to(SLOPES, (*np.shape(x0), 3))

    def energy(self, x0):
        return np.square(x0)

    def demand(self, x0):
        return 2.0 * np.asarray(x0)

    def mirrored(self):
        return self


ALL = Channels(used=[0, 1, 2], noise=np.array([0.1, 0.2, 0.4]))


def sampled(clamp, x0, branch=None, deviation=0.01, **more):
    """Samples with these displacements, without noise."""
    clamp, x0 = np.array(clamp, dtype=float), np.array(x0, dtype=float)
    size, branch = len(clamp), branch or Straight()
    known = {
        "clamp": clamp,
        "readings": branch(x0),
        "line": np.arange(size) + 2,
        "row": np.arange(size),
        "x0": x0,
        "deviation": np.full(size, deviation),
        "misfit": np.zeros(size),
        "start": branch.above(clamp)[1],
    }
    return Samples(**known | more)


def seen_of(samples, begins, channels=ALL, deviation=0.01, branch=None):
    """Periods of samples, each with the contact of its first one."""
    place = samples.place[begins]
    return Seen(
        branch=branch or Straight(),
        samples=samples,
        channels=channels,
        periods=Partition(begins=np.array(begins), size=len(samples)),
        contacts=Contacts(place=place, deviation=np.full(len(place), deviation)),
    )


def periods_of(mu0, noise, by_step, shifts=None, effects=None):
    """Periods that slipped, with errors by noise, step and what all share."""
    p = len(mu0)
    shifts = np.zeros((p, 0)) if shifts is None else np.asarray(shifts, dtype=float)
    common = np.linalg.norm(shifts, axis=1)
    noise, by_step = noise * np.ones(p), by_step * np.ones(p)
    row = np.arange(p)
    return Periods(
        status=np.full(p, PeriodStatus.SLIP),
        first=row,
        last=row,
        first_line=row,
        last_line=row,
        contact=row / p,
        footpoint=row / p,
        mu0=np.asarray(mu0, dtype=float),
        deviation=np.sqrt(noise**2 + by_step**2 + common**2),
        low=np.full(p, np.nan),
        high=np.full(p, np.nan),
        common=common,
        by_step=by_step,
        effects=np.zeros((p, 0)) if effects is None else np.asarray(effects, dtype=float),
        shifts=shifts,
        grade=np.full(p, "", dtype="U11"),
        doubt=np.full(p, ""),
    )
