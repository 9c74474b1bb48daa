"""Periods of sticking by the tangential force alone, without a rod.

While the tip sticks, a clamp that moves on meets a force that rises against the motion: sticking
equilibria are stable. Where that force falls, the tip slips. So force_x, counted against the
motion, only rises within a period; a fall from a peak to a trough, by more than noise makes, is a
slip. It may last several samples: those between peak and trough are of neither period. Where
samples are missing the force may have fallen and risen again unseen: a period ends there, too, if
the force has hardly risen over them.
"""

from dataclasses import dataclass

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.numerics.batch import Batch

# A fall by so many standard deviations of one reading is a slip: of 10^5 samples with hardly any
# load from one to the next, one recording in ten shows it by chance.
FALL = 8.0
# Within a slip: a fall from one sample to the next that is none of noise, in standard deviations.
STEP_FALL = 5.0
# A sample this many standard deviations from the mean of its neighbours, which agree, is a spike.
SPIKE = 8.0
# Usual steps from which on a step is longer than usual, and from which on samples were lost.
LONG, LOST = 1.5, 10.0
# Over a longer step a tip that sticks on makes the load rise by more than this part of what it
# usually does; one that slips once or more does not.
STICKS_ON = 0.5


@dataclass(frozen=True, eq=False, kw_only=True)
class Spans(Batch):
    """Periods of sticking as rows of a recording, each field an array of shape (p,).

    Attributes
    ----------
    begins, ends : ndarray of int
        First and last row in which the tip sticks. Rows between two periods are of neither.
    cut : ndarray of bool
        Whether it ends where samples are missing and no slip is seen.
    """

    begins: IntArray
    ends: IntArray
    cut: BoolArray


def spikes(force: FloatArray, noise: float) -> BoolArray:
    """Tell which samples lie far off their neighbours, which agree with each other.

    Parameters
    ----------
    force : ndarray, shape (n,)
    noise : float
        Standard deviation of one reading.

    Returns
    -------
    ndarray of bool, shape (n,)
    """
    lone = np.zeros(len(force), dtype=bool)
    if len(force) > 2:
        apart = np.abs(force[2:] - force[:-2])
        off = np.abs(force[1:-1] - 0.5 * (force[2:] + force[:-2]))
        lone[1:-1] = (off > SPIKE * noise) & (off > 2.0 * apart)
        # Where each sample is off its neighbours the tip slips at every other one.
        lone[1:-1] &= ~(lone[2:] | lone[:-2])
    return lone


def spans_of(clamp: FloatArray, force: FloatArray, noise: float) -> Spans:
    """Find the periods of sticking.

    Parameters
    ----------
    clamp : ndarray, shape (n,)
        Clamp positions.
    force : ndarray, shape (n,)
        Readings of force_x.
    noise : float
        Standard deviation of one of them.

    Returns
    -------
    Spans
        At least one; periods of a single sample, which may as well lie within a slip, are left out.
    """
    falls = np.diff(force) * direction(clamp) / noise
    begins, ends = [0], []
    for peak, trough in _falls(falls):
        large = np.flatnonzero(falls[peak:trough] > STEP_FALL)
        # Noise moves a peak by some samples, but not the large fall between two of them.
        ends.append(peak + int(large[0]) if len(large) else peak)
        begins.append(peak + int(large[-1]) + 1 if len(large) else trough)
    ends.append(len(force) - 1)
    found = _cut(clamp, falls, np.array(begins), np.array(ends))
    several = found.ends > found.begins
    return found.take(several) if several.any() else found


def _cut(clamp: FloatArray, falls: FloatArray, begins: IntArray, ends: IntArray) -> Spans:
    """Cut periods where samples are missing and the load has risen by too little for sticking."""
    steps = np.abs(np.diff(clamp))
    moves = steps > 0.0
    rise = np.median(-falls[moves] / steps[moves]) * steps if moves.any() else steps
    short = rise + falls > np.maximum(FALL, STICKS_ON * rise)
    rows = np.flatnonzero(short & (steps > LONG * usual_step(clamp)))
    # Between two periods lies a slip that is seen.
    last = rows[rows < ends[np.searchsorted(begins, rows, side="right") - 1]]
    ends = np.sort(np.append(ends, last))
    return Spans(begins=np.sort(np.append(begins, last + 1)), ends=ends, cut=np.isin(ends, last))


def usual_step(clamp: FloatArray) -> float:
    """Tell how far the clamp moves from one sample to the next; infinite if it never moves."""
    steps = np.abs(np.diff(clamp))
    return float(np.median(steps[steps > 0.0])) if steps.any() else np.inf


def direction(clamp: FloatArray) -> FloatArray:
    """Tell the direction of the motion in each step: where the clamp rests, that of the one before.

    Parameters
    ----------
    clamp : ndarray, shape (n,)

    Returns
    -------
    ndarray, shape (n − 1,)
        1 forward, −1 backward.
    """
    signs = np.sign(np.diff(clamp))
    moving = np.flatnonzero(signs)
    if not len(moving):
        return np.ones(len(signs))
    before = np.searchsorted(moving, np.arange(len(signs)), side="right") - 1
    return np.asarray(signs[moving[np.maximum(before, 0)]])


def _falls(falls: FloatArray) -> list[tuple[int, int]]:
    """Peak and trough of each fall of the load by more than `FALL`, as rows."""
    found: list[tuple[int, int]] = []
    load = top = bottom = 0.0
    peak = trough = 0
    falling = False
    for row, fall in enumerate(falls.tolist(), start=1):
        load -= fall
        if falling:
            if load < bottom:
                bottom, trough = load, row
            elif load > bottom + FALL:
                found.append((peak, trough))
                falling, top, peak = False, load, row
        elif load >= top:
            top, peak = load, row
        elif load < top - FALL:
            falling, bottom, trough = True, load, row
    return [*found, (peak, trough)] if falling else found
