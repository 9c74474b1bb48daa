"""What a recording of sticking and slipping cannot look like: reasons to doubt a friction.

A tip that sticks stays at one place, and every channel fits the rod with its tip there. A slip,
by whatever law it ends, goes the way the clamp moves, from a state in which that strains the rod,
and releases energy. Where the clamp jumps samples are missing, and a few samples may be a spike.
"""

import numpy as np
from scipy.stats import chi2

from vibrissa.arrays import FloatArray, IntArray
from vibrissa.sensor.response import Branch
from vibrissa.sensor.transducer import CHANNELS

# Fewer samples than these do not confirm each other.
FEW = 4
# Usual steps from which on a step is longer than usual, and from which on samples were lost.
LONG, LOST = 1.5, 10.0
# Chance of a misfit from which on it is none of the noise.
UNLIKELY = 1e-9
# Standard deviations by which a slip may seem to go the wrong way, or to gain energy.
CERTAIN = 6.0


def doubts(
    branch: Branch,
    clamp: FloatArray,
    readings: FloatArray,
    noise: FloatArray,
    x0: FloatArray,
    spread: FloatArray,
    place: FloatArray,
    place_spread: FloatArray,
    begins: IntArray,
) -> list[str]:
    """Say for each period why its friction is in doubt.

    Parameters
    ----------
    branch : Branch
    clamp : ndarray, shape (n,)
        Clamp positions (L).
    readings : ndarray, shape (n, 3)
        fx, fy (E·I0/L²) and m (E·I0/L); NaN where missing.
    noise : ndarray, shape (3,)
        Standard deviation of a reading; a channel without one is not looked at.
    x0, spread : ndarray, shape (n,)
        Displacement of each sample (L) and its standard deviation.
    place, place_spread : ndarray, shape (periods,)
        Clamp position minus x0 in each period (L) and its standard deviation.
    begins : ndarray of int, shape (periods,)
        First sample of each.

    Returns
    -------
    list of str
        Empty where there is no doubt.
    """
    counts = np.diff(np.append(begins, len(clamp)))
    ends = begins + counts - 1
    inside = np.clip(clamp - np.repeat(place, counts), branch.x0_pull, branch.x0_end)
    why: list[list[str]] = [[] for _ in counts]
    expected, slope = branch(inside), branch.slope(inside)
    for i, name in enumerate(CHANNELS):
        there = np.isfinite(readings[:, i]) & (noise[i] > 0.0)
        miss = np.where(there, (readings[:, i] - expected[:, i]) / noise[i], 0.0)
        tilt = np.where(there, slope[:, i] / noise[i], 0.0)
        squares, mixed, tilts, number = (
            np.add.reduceat(x, begins) for x in (miss**2, tilt * miss, tilt**2, there.astype(float))
        )
        # Where the tip is is known to so much only, which moves all samples together.
        squares -= mixed**2 / (tilts + 1.0 / place_spread**2)
        chance = chi2.sf(squares, np.maximum(number, 1.0))
        for period in np.flatnonzero(chance < UNLIKELY):
            why[period].append(f"{name} does not fit a tip that stays where it is")

    last, first = ends[:-1], begins[1:]
    gap = clamp[first] - clamp[last]
    way = np.where(gap == 0.0, np.sign(x0[last]), np.sign(gap))
    back = way * np.diff(place) <= 0.0
    before, after = (np.clip(x0[rows], branch.x0_pull, branch.x0_end) for rows in (last, first))
    unsure = np.hypot(branch(before)[:, 0] * spread[last], branch(after)[:, 0] * spread[first])
    gained = branch.energy(after) - branch.energy(before)
    unloaded = way * (x0[last] + gap) < CERTAIN * spread[last]
    moved = np.abs(np.diff(clamp))
    usual = np.median(moved[moved > 0.0]) if moved.any() else np.inf
    # Over a longer step the slip must be seen, or it was the clamp that jumped.
    certain = np.where(np.abs(gap) > LONG * usual, -CERTAIN, CERTAIN)
    for period in np.flatnonzero(back | unloaded | (gained > certain * unsure)):
        why[period].append("no slip goes that way")

    for period in np.flatnonzero(np.abs(gap) > LOST * usual):
        for beside in (period, period + 1):
            why[beside].append("samples are missing beside it, or the clamp jumped")
    came = clamp[last] - clamp[np.maximum(last - FEW, 0)]
    went = clamp[np.minimum(first + FEW, len(clamp) - 1)] - clamp[first]
    for period in np.flatnonzero(came * went < 0.0):
        why[period].append("the clamp turned beside its end")

    for period in np.flatnonzero(counts < FEW):
        why[period].append("too few samples")
        # Where they are spikes the period before did not end there.
        if period:
            why[period - 1].append("too few samples after it")
    return ["; ".join(dict.fromkeys(reasons)) for reasons in why]
