"""What the columns of a recording may have been mixed up with: axes, signs, units."""

from collections.abc import Iterator
from itertools import product

import numpy as np

from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.identification.calibration import Setup
from vibrissa.sensor.identification.periods import MISFIT, Channels, located
from vibrissa.sensor.identification.recording import Recording
from vibrissa.sensor.transducer import CHANNELS

# So many samples tell whether a mix-up explains the readings.
SAMPLED = 300
# Squared residuals that are smaller by this factor are much smaller.
MUCH = 100.0
# A unit of 1/1000, such as mN or N·mm, that was taken for the other.
THOUSAND = 1e3


def mixups(
    setup: Setup, recording: Recording, channels: Channels, most_off: float
) -> tuple[str, ...]:
    """Tell with which mix-ups the readings would be states of the rod, the best first.

    Parameters
    ----------
    setup : Setup
    recording : Recording
        That does not fit the rod.
    channels : Channels
    most_off : float
        Part of the samples that may still be none.

    Returns
    -------
    tuple of str
        Also those with which the readings come much nearer to the rod.
    """
    some = recording.take(np.unique(np.linspace(0, len(recording) - 1, SAMPLED).astype(int)))

    def misfit(mixed: FloatArray) -> FloatArray:
        return located(setup.branch, some.mixed(mixed), channels, setup.offset).misfit

    limit = float(np.median(misfit(np.eye(3)))) / MUCH
    found = []
    for text, mixed in _candidates(channels):
        off = misfit(mixed)
        usual = float(np.median(off))
        if (off > MISFIT).mean() <= most_off or usual < limit:
            found.append((usual, text))
    return tuple(text for _, text in sorted(found))


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
    units = [(forces, range(2)), ([name for name in used if name not in forces], range(2, 3))]
    for names, rows in units:
        for factor, size in ((THOUSAND, "larger"), (1.0 / THOUSAND, "smaller")):
            if names:
                each = np.ones(3)
                each[list(rows)] = factor
                yield f"{' and '.join(names)} in a unit 1000 times {size}", np.diag(each)
