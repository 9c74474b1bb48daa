"""A table of the rod's states at one height, to find the one that is nearest to a reading."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from vibrissa.errors import MixedColumnsError
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.sensor.identification.recording import FORCES, MIRROR, Recording
from vibrissa.sensor.response.branch import Branch
from vibrissa.sensor.transducer import CHANNELS

# Points of the branch.
TABLE = 4001
# So many samples tell whether a mix-up explains the readings, and so many on which side the tip
# begins.
SAMPLED, BEGINNING = 300, 20
# Squared residual, in standard deviations, from which on a sample is not a state of the rod.
MISFIT = 36.0
# The same, in usual ones, where the rod is a little other than given.
UNUSUAL = 9.0
# Squared residuals that are smaller by this factor are much smaller: by 15, what they are of.
MUCH = 225.0
# A smaller mean square is rounding: the readings of a simulation may have no noise.
ROUNDING = 1e-9
# In steady stick-slip the mean step of x0, cut to the steps of the clamp, is not against them.
# Where it is, by this part of a step and so many deviations, one of the two has the other sign.
AGAINST, SURELY = 0.25, 3.0
# By this factor it is in another unit; error of a median, in median deviations over √n.
OTHER_UNIT, MEDIAN = 5.0, 1.86
# A unit of 1/1000, such as mN or N·mm, that was taken for the other.
THOUSAND = 1e3


@dataclass(frozen=True, eq=False, kw_only=True)
class Guide:
    """States of a rod at one height.

    Attributes
    ----------
    branch : Branch
    used : list of int
        Numbers of the channels that are used.
    noise : ndarray, shape (c,)
        Standard deviation of one reading of each.
    """

    branch: Branch
    used: list[int]
    noise: FloatArray

    def weighted(self, readings: FloatArray) -> FloatArray:
        """Channels that are used, in standard deviations, shape (n, c)."""
        return np.asarray(readings[:, self.used] / self.noise)

    @cached_property
    def _table(self) -> tuple[FloatArray, Any]:
        table = np.linspace(self.branch.x0_pull, self.branch.x0_end, TABLE)
        values = self.weighted(self.branch(table))
        if len(self.used) == 1:
            # One channel distinguishes the states only as long as it grows.
            back = np.flatnonzero(np.diff(values[:, 0]) <= 0.0)
            table = table[: int(back[0]) + 1] if len(back) else table
        return table, KDTree(values[: len(table)])

    def nearest(self, readings: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Displacements of the nearest states (L), and the squared misfits to them, each (n,)."""
        table, tree = self._table
        weighted = self.weighted(readings)
        x0 = table[tree.query(weighted)[1]]
        slope = self.weighted(self.branch.slope(x0))
        miss = weighted - self.weighted(self.branch(x0))
        x0 = self.branch.clip(x0 + (slope * miss).sum(axis=1) / (slope**2).sum(axis=1))
        return x0, ((weighted - self.weighted(self.branch(x0))) ** 2).sum(axis=1)

    def spiky(self, readings: FloatArray, lone: BoolArray) -> BoolArray:
        """Keep those lone peaks that are no states of the rod: short periods have peaks, too."""
        rows = np.flatnonzero(lone)
        if len(self.used) == 1 or not len(rows):
            return lone
        some = np.linspace(0, len(readings) - 1, SAMPLED).astype(int)
        usual = float(np.median(self.nearest(readings[some])[1]))
        off = self.nearest(readings[rows])[1] > max(MISFIT, UNUSUAL * usual)
        found = np.zeros(len(readings), dtype=bool)
        found[rows[off]] = True
        return found

    def load(self, readings: FloatArray) -> tuple[FloatArray, float]:
        """Load that tells the displacement, negative as force_x, and its noise (L).

        By both forces, or by the moment alone: the best linear estimate beside the median state.
        """
        channels = [i for i, c in enumerate(self.used) if c in FORCES] or [0]
        channels = channels if len(channels) == len(FORCES) else list(range(len(self.used)))
        middle = np.median(readings, axis=0)[None]
        slope = self.weighted(self.branch.slope(self.nearest(middle)[0]))[0, channels]
        known = float(slope @ slope)
        return -self.weighted(readings)[:, channels] @ slope / known, known**-0.5


def check_columns(guide: Guide, recording: Recording) -> None:
    """Refuse a recording that comes much nearer to the rod if its columns were mixed up.

    Nothing that is known to a tolerance makes up for that: it would be fitted to nonsense.

    Raises
    ------
    MixedColumnsError
        If so; the message names the likeliest mix-up.
    """
    _check_motion(guide, recording)
    some = recording.readings[np.linspace(0, len(recording) - 1, SAMPLED).astype(int)]

    def misfits(mixed: FloatArray) -> FloatArray:
        return guide.nearest(np.nan_to_num(some) @ mixed.T)[1]

    ahead, behind = misfits(np.eye(3)), misfits(np.diag(MIRROR))
    if np.median(ahead[:BEGINNING]) <= np.median(behind[:BEGINNING]):
        # The rod may swing aside later on.
        ahead = np.minimum(ahead, behind)
    given = float(np.median(ahead))
    if given <= MISFIT:
        return
    candidates = dict(_candidates(guide.used))
    least, text = min(
        (float(np.median(misfits(mixed))), text) for text, mixed in candidates.items()
    )
    size = (guide.weighted(np.nan_to_num(some) @ candidates[text].T) ** 2).sum(axis=1)
    # A rod that is quite another one is not near to the readings, however they are mixed.
    if least < min(given, float(np.median(size))) / MUCH:
        raise MixedColumnsError(
            f"the columns seem to be mixed up: {text}. The readings would be "
            f"{np.sqrt(given / max(least, ROUNDING)):.3g} times as near to this rod. Say which is "
            "which with vibrissa import --column, a minus before a title turns the sign: "
            "'moment_z=-Mz'"
        )


def _check_motion(guide: Guide, recording: Recording) -> None:
    """Refuse a recording in which the rod bends against the clamp, or much more or less than it.

    While the tip sticks, the step of x0 is that of the clamp.
    """
    moves = np.append(True, np.diff(recording.clamp) != 0.0)
    some = recording.take(np.flatnonzero(moves)[:SAMPLED])
    x0, misfit = guide.nearest(some.readings)
    there = misfit <= MISFIT
    along = (np.diff(x0) / np.diff(some.clamp))[there[1:] & there[:-1]]
    if len(along) < BEGINNING:
        return
    if np.clip(along, -1.0, 1.0).mean() < -AGAINST - SURELY / np.sqrt(len(along)):
        raise MixedColumnsError(
            "the rod bends against the motion of the clamp: column footpoint has the other sign, "
            "or else force_x and moment_z have. x points in the direction in which the clamp moves "
            "while its position grows"
        )
    ratio = float(np.median(along))
    error = SURELY * MEDIAN * float(np.median(np.abs(along - ratio))) / np.sqrt(len(along))
    if ratio - error > OTHER_UNIT:
        raise MixedColumnsError(
            f"the rod bends by {ratio:.4g} times the way of the clamp from sample to sample: "
            "column footpoint seems to be in a larger unit"
        )
    if error < ratio < 1.0 / OTHER_UNIT - error:
        raise MixedColumnsError(
            f"the clamp moves by {1.0 / ratio:.4g} times what the rod bends from sample to sample: "
            "column footpoint seems to be in a smaller unit, or the tip slips in every step"
        )


def _candidates(used: list[int]) -> Iterator[tuple[str, FloatArray]]:
    """Mix-ups of the channels that are used, with what undoes each, shape (3, 3)."""
    names = [CHANNELS[i] for i in used]
    forces = [i for i in used if i in FORCES]
    swapped = np.eye(3)[[1, 0, 2]]
    for change in (np.eye(3), swapped) if len(forces) == 2 else (np.eye(3),):
        axes = ["force_x and force_y swapped"] if change is swapped else []
        for signs in sorted(product((1.0, -1.0), repeat=len(used)), key=lambda one: -sum(one)):
            other = [name for name, sign in zip(names, signs, strict=True) if sign < 0.0]
            said = axes + ([f"{' and '.join(other)} with the other sign"] if other else [])
            if said:
                each = np.ones(3)
                each[used] = signs
                yield ", ".join(said), np.diag(each) @ change
    alone = [[i] for i in forces] if len(forces) == 2 else []
    for rows in filter(None, [forces, [i for i in used if i not in forces], *alone]):
        for factor, size in ((THOUSAND, "larger"), (1.0 / THOUSAND, "smaller")):
            each = np.ones(3)
            each[rows] = factor
            text = " and ".join(CHANNELS[i] for i in rows)
            yield f"{text} in a unit 1000 times {size}", np.diag(each)
