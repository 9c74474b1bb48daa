"""The ends of a recording that are no scan: the clamp rests, or nothing touches the surface."""

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray

# A clamp rests that moves, over so many samples, by less than this part of what it usually does.
WINDOW, SLOW = 10, 0.2
# Part of the ways over a window that are slower than the usual one: a recording may rest long.
USUAL = 0.9
# This part of the load of a usual sample is none: only lift-off takes so much off all channels.
NO_LOAD = 0.05
# Fewer samples than these are no rest and no lift-off.
FEWEST = WINDOW


def moving(clamp: FloatArray) -> slice:
    """Find the part of a recording between the rests of the clamp at its two ends."""
    begin = _rest(clamp)
    return slice(begin, len(clamp) - _rest(clamp[begin:][::-1]))


def _rest(clamp: FloatArray) -> int:
    """Count the samples at the beginning in which the clamp rests, less one."""
    if len(clamp) <= 2 * WINDOW:
        return 0
    ways = np.abs(clamp[WINDOW:] - clamp[:-WINDOW])
    moves = ways > SLOW * np.quantile(ways, USUAL)
    if not moves.any() or moves[0]:
        return 0
    rest = int(np.argmax(moves))
    level = np.median(clamp[: rest + 1])
    jitter = np.abs(clamp[: rest + 1] - level).max()
    # The last window that is slow may reach into the motion, and the next one begins before it.
    gone = np.flatnonzero(np.abs(clamp[rest:] - level) > jitter)
    begin = rest + (int(gone[0]) if len(gone) else 0) - 1
    return begin if begin >= FEWEST else 0


def touching(loads: FloatArray) -> slice:
    """Find the part of a recording between the ends at which no load acts."""
    if not len(loads):
        return slice(0, 0)
    size = np.abs(loads)
    free = np.all(size <= NO_LOAD * np.quantile(size, USUAL, axis=0), axis=1)
    if free.all():
        return slice(0, len(loads))
    return slice(_run(free), len(loads) - _run(free[::-1]))


def _run(free: BoolArray) -> int:
    run = int(np.argmin(free))
    return run if run >= FEWEST else 0
