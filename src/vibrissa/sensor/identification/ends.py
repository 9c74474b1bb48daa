"""The rows before and after a scan: the clamp rests, or the rod does not touch the surface."""

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray

# Number of samples over which the travel of the clamp is compared with its usual travel.
WINDOW = 10
# The clamp rests if it travels less than this part of it.
SLOW_PART = 0.2
# Quantile of travels and of loads that is called usual: the clamp may rest in most samples.
USUAL_QUANTILE = 0.9
# Part of the usual load that counts as no load: only lift-off lowers all channels so far.
NO_LOAD_PART = 0.05
# Least number of samples of a rest, or without load, at an end of a recording.
FEWEST_AT_END = WINDOW


def moving(clamp: FloatArray) -> slice:
    """Find the rows between the rests of the clamp at the beginning and at the end."""
    begin = _rest(clamp)
    return slice(begin, len(clamp) - _rest(clamp[begin:][::-1]))


def _rest(clamp: FloatArray) -> int:
    """Find the last row of the clamp's rest at the beginning; 0 without a rest."""
    if len(clamp) <= 2 * WINDOW:
        return 0
    ways = np.abs(clamp[WINDOW:] - clamp[:-WINDOW])
    moves = ways > SLOW_PART * np.quantile(ways, USUAL_QUANTILE)
    if not moves.any() or moves[0]:
        return 0
    rest = int(np.argmax(moves))
    level = np.median(clamp[: rest + 1])
    jitter = np.abs(clamp[: rest + 1] - level).max()
    # The motion begins in the first fast window, where the clamp leaves the scatter of its rest.
    gone = np.flatnonzero(np.abs(clamp[rest:] - level) > jitter)
    begin = rest + (int(gone[0]) if len(gone) else 0) - 1
    return begin if begin >= FEWEST_AT_END else 0


def touching(loads: FloatArray) -> slice:
    """Find the rows between the unloaded rows at the beginning and at the end."""
    if not len(loads):
        return slice(0, 0)
    size = np.abs(loads)
    free = np.all(size <= NO_LOAD_PART * np.quantile(size, USUAL_QUANTILE, axis=0), axis=1)
    if free.all():
        return slice(0, len(loads))
    return slice(_run(free), len(loads) - _run(free[::-1]))


def _run(free: BoolArray) -> int:
    run = int(np.argmin(free))
    return run if run >= FEWEST_AT_END else 0
