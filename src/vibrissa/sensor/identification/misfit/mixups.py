"""What the columns of a recording may have been mixed up with: axes, signs, units."""

from collections.abc import Iterator
from itertools import product

import numpy as np

from vibrissa.errors import MixedColumnsError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.identification.periods import MISFIT, Channels, Placed, located
from vibrissa.sensor.identification.recording import MIRROR, Recording
from vibrissa.sensor.transducer import CHANNELS

# So many samples tell whether a mix-up explains the readings.
SAMPLED = 300
# So many of them tell on which side the tip begins.
BEGINNING = 20
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


def check_columns(branch: Placed, recording: Recording, channels: Channels) -> None:
    """Refuse a recording that comes much nearer to the rod if its columns were mixed up.

    Nothing that is known to a tolerance makes up for that: it would be adjusted to nonsense.

    Parameters
    ----------
    branch : Branch or ObliqueStage
    recording : Recording
    channels : Channels
        All that were recorded.

    Raises
    ------
    MixedColumnsError
        If so; the message names the likeliest mix-up.
    """
    _check_motion(branch, recording, channels)
    some = recording.take(np.unique(np.linspace(0, len(recording) - 1, SAMPLED).astype(int)))

    def misfits(mixed: FloatArray) -> FloatArray:
        return located(branch, some.mixed(mixed), channels).misfit

    def misfit(mixed: FloatArray) -> float:
        return float(np.median(misfits(mixed)))

    def size(mixed: FloatArray) -> float:
        weighted = channels.weighted(some.mixed(mixed).readings)
        return float(np.median((weighted**2).sum(axis=1)))

    ahead, behind = misfits(np.eye(3)), misfits(np.diag(MIRROR))
    if np.median(ahead[:BEGINNING]) <= np.median(behind[:BEGINNING]):
        # The rod may swing aside later on.
        ahead = np.minimum(ahead, behind)
    given = float(np.median(ahead))
    if given <= MISFIT:
        return
    candidates = dict(_candidates(channels))
    least, text = min((misfit(mixed), text) for text, mixed in candidates.items())
    # A rod that is quite another one is not near to the readings, however they are mixed.
    if least < min(given, size(candidates[text])) / MUCH:
        raise MixedColumnsError(
            f"the columns seem to be mixed up: {text}. The readings would be "
            f"{np.sqrt(given / max(least, ROUNDING)):.3g} times as near to this rod. Say which is "
            "which with vibrissa import --column, a minus before a title turns the sign: "
            "'moment_z=-Mz'"
        )


def _check_motion(branch: Placed, recording: Recording, channels: Channels) -> None:
    """Refuse a recording in which the rod bends against the clamp, or much more or less than it.

    While the tip sticks, the step of x0 is that of the clamp.
    """
    moves = np.append(True, np.diff(recording.clamp) != 0.0)
    some = recording.take(np.flatnonzero(moves)[:SAMPLED])
    samples = located(branch, some, channels)
    there = samples.misfit <= MISFIT
    along = (np.diff(samples.x0) / np.diff(some.clamp))[there[1:] & there[:-1]]
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


def _candidates(channels: Channels) -> Iterator[tuple[str, FloatArray]]:
    """Mix-ups of the channels that are used, with what undoes each, shape (3, 3)."""
    used = [CHANNELS[i] for i in channels.used]
    forces = [name for name in used if name.startswith("force")]
    swapped = np.eye(3)[[1, 0, 2]]
    for change in (np.eye(3), swapped) if len(forces) == 2 else (np.eye(3),):
        axes = ["force_x and force_y swapped"] if change is swapped else []
        for signs in sorted(product((1.0, -1.0), repeat=len(used)), key=lambda one: -sum(one)):
            other = [name for name, sign in zip(used, signs, strict=True) if sign < 0.0]
            said = axes + ([f"{' and '.join(other)} with the other sign"] if other else [])
            if said:
                each = np.ones(3)
                each[channels.used] = signs
                yield ", ".join(said), np.diag(each) @ change
    moment = [name for name in used if name not in forces]
    alone = [[name] for name in forces] if len(forces) == 2 else []
    for names in filter(None, [forces, moment, *alone]):
        rows = [CHANNELS.index(name) for name in names]
        for factor, size in ((THOUSAND, "larger"), (1.0 / THOUSAND, "smaller")):
            each = np.ones(3)
            each[rows] = factor
            yield f"{' and '.join(names)} in a unit 1000 times {size}", np.diag(each)
