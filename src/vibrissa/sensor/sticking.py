"""Samples on the rod's branch, and the periods of sticking that they make.

Each sample of the clamp reactions lies on the branch, which gives its x0. Clamp position minus x0
is constant while the tip sticks and jumps where it slips.
"""

import numpy as np
from scipy.spatial import KDTree

from vibrissa.arrays import BoolArray, FloatArray, IntArray
from vibrissa.sensor.response import Branch
from vibrissa.sensor.uncertainty import contact_deviation, information

# A jump of this many standard deviations is a slip: by chance one of 10^9 samples shows it.
JUMP = 6.0
# Points of the branch among which the nearest to a sample is sought, before Newton's step.
TABLE = 4001
NEWTON_STEPS = 4


def located(
    branch: Branch, readings: FloatArray, noise: FloatArray, used: list[int]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Find the state of the rod that is nearest to each sample.

    Parameters
    ----------
    branch : Branch
    readings : ndarray, shape (n, k)
        Of the channels that are used.
    noise : ndarray, shape (k,)
        Standard deviation of one reading.
    used : list of int
        Numbers of the channels: 0 for fx, 1 for fy, 2 for m.

    Returns
    -------
    x0, deviation, misfit : ndarray, shape (n,)
        Displacement and its standard deviation (L), squared misfit in standard deviations.
    """
    table = np.linspace(branch.x0_pull, branch.x0_lock, TABLE)
    values = branch(table)[:, used]
    if used == [2]:
        # One channel tells states apart only as long as it grows.
        back = np.flatnonzero(np.diff(values[:, 0]) <= 0.0)
        stop = int(back[0]) + 1 if len(back) else TABLE
        table, values = table[:stop], values[:stop]
    _, nearest = KDTree(values / noise).query(readings / noise)
    x0 = table[nearest]
    inside = (table[0], table[-1])
    for _ in range(2):
        slope = branch.slope(x0)[:, used]
        miss = (readings - branch(x0)[:, used]) / noise
        known = information(slope, noise)
        x0 = np.clip(x0 + (slope / noise * miss).sum(axis=1) / known, *inside)
    miss = (readings - branch(x0)[:, used]) / noise
    return x0, contact_deviation(known), (miss**2).sum(axis=1)


def jumps(at: FloatArray, deviation: FloatArray, apart: int = 1) -> BoolArray:
    """Whether the contact differs between samples that are so many rows apart."""
    allowed = JUMP * np.hypot(deviation[apart:], deviation[:-apart])
    return np.asarray(np.abs(at[apart:] - at[:-apart]) > allowed)


def lone_spikes(at: FloatArray, deviation: FloatArray) -> BoolArray:
    """Whether a sample jumps away and the next one back to where it was."""
    lone = np.zeros(len(at), dtype=bool)
    if len(at) > 2:
        one = jumps(at, deviation)
        lone[1:-1] = one[:-1] & one[1:] & ~jumps(at, deviation, 2)
    return lone


def fitted(
    branch: Branch,
    clamp: FloatArray,
    readings: FloatArray,
    noise: FloatArray,
    used: list[int],
    start: FloatArray,
    begins: IntArray,
) -> tuple[FloatArray, FloatArray]:
    """Fit one contact to all samples of each period, by least squares.

    Parameters
    ----------
    branch : Branch
    clamp : ndarray, shape (n,)
        Clamp positions (L).
    readings, noise, used
        As for `located`.
    start : ndarray, shape (n,)
        Clamp position minus x0 of each sample (L), whose means are the first guess.
    begins : ndarray of int, shape (p,)
        First sample of each period.

    Returns
    -------
    place, deviation : ndarray, shape (p,)
        Clamp position at α = 0 for this contact, and its standard deviation (L).
    """
    counts = np.diff(np.append(begins, len(clamp)))
    place = np.add.reduceat(start, begins) / counts
    for _ in range(NEWTON_STEPS):
        x0 = np.clip(clamp - np.repeat(place, counts), branch.x0_pull, branch.x0_end)
        slope = branch.slope(x0)[:, used]
        miss = (readings - branch(x0)[:, used]) / noise
        known = np.add.reduceat(information(slope, noise), begins)
        place = place - np.add.reduceat((slope / noise * miss).sum(axis=1), begins) / known
    return place, contact_deviation(known)
