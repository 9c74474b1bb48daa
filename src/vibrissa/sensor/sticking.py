"""Samples on the rod's branch, and the periods of sticking that they make.

Each sample of the clamp reactions lies on the branch, which gives its x0. Clamp position minus x0
is constant while the tip sticks and jumps where it slips.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from vibrissa.arrays import BoolArray, FloatArray, IntArray
from vibrissa.sensor.response import Branch
from vibrissa.sensor.uncertainty import contact_deviation, information

# A jump of this many standard deviations is a slip: by chance one of 10^9 samples shows it.
JUMP = 6.0
# Squared misfit, in standard deviations, from which on a sample is not a state of the rod.
MISFIT = 36.0
# Points of the branch among which the nearest to a sample is sought, before Newton's step.
TABLE = 4001
NEWTON_STEPS = 4
# Samples located together, before it is told how many are done.
BLOCK = 20000


def located(
    branch: Branch,
    readings: FloatArray,
    noise: FloatArray,
    used: list[int],
    progress: Callable[[int], None] = lambda done: None,
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
    progress : callable
        Told how many samples are done.

    Returns
    -------
    x0, deviation, misfit : ndarray, shape (n,)
        Displacement and its standard deviation (L), squared misfit in standard deviations.
    """
    table = np.linspace(branch.x0_pull, branch.x0_end, TABLE)
    values = branch(table)[:, used]
    if used == [2]:
        # One channel tells states apart only as long as it grows.
        back = np.flatnonzero(np.diff(values[:, 0]) <= 0.0)
        stop = int(back[0]) + 1 if len(back) else TABLE
        table, values = table[:stop], values[:stop]

    def nearest(rows: IntArray, tree: Any) -> None:
        """Start at the nearest state of the table; two steps of Gauss and Newton."""
        read = readings[rows] / noise
        x = table[tree.query(read)[1]]
        for _ in range(2):
            slope = branch.slope(x)[:, used]
            known[rows] = information(slope, noise)
            miss = read - branch(x)[:, used] / noise
            x = np.clip(x + (slope / noise * miss).sum(axis=1) / known[rows], table[0], table[-1])
        x0[rows] = x
        misfit[rows] = ((read - branch(x)[:, used] / noise) ** 2).sum(axis=1)

    x0, known, misfit = np.empty((3, len(readings)))
    before = KDTree(values[: int(np.searchsorted(table, branch.x0_lock)) + 1] / noise)
    whole = KDTree(values / noise)
    for start in range(0, len(readings), BLOCK):
        rows = np.arange(start, min(start + BLOCK, len(readings)))
        nearest(rows, before)
        # Past the lock the branch may come near to states before it: only what is none of those.
        past = rows[misfit[rows] > MISFIT]
        if len(past):
            nearest(past, whole)
        progress(int(rows[-1]) + 1)
    return x0, contact_deviation(known), misfit


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


def same_contact(
    branch: Branch,
    clamp: FloatArray,
    readings: FloatArray,
    noise: FloatArray,
    used: list[int],
    begins: IntArray,
    place: FloatArray,
    deviation: FloatArray,
) -> IntArray:
    """Tell which periods go on with the contact of one before, which has passed its lock.

    Past the lock one channel may turn back and show a slip where there is none.

    Parameters
    ----------
    branch, clamp, readings, noise, used, begins
        As for `fitted`.
    place, deviation : ndarray, shape (p,)
        What it returns.

    Returns
    -------
    ndarray of int, shape (p,)
        Number of the period whose contact each has, its own as a rule.
    """
    owner = np.arange(len(begins))
    for i in range(1, len(begins)):
        own, row = owner[i - 1], begins[i]
        if clamp[row - 1] - place[own] > branch.x0_lock:
            x0 = clamp[row] - place[own]
            if branch.x0_pull < x0 < branch.x0_end:
                blur = np.hypot(noise, branch.slope(x0)[used] * deviation[own])
                miss = (readings[row] - branch(x0)[used]) / blur
                if (miss**2).sum() < MISFIT:
                    owner[i] = own
    return owner
