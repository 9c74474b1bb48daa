"""Reasons to doubt a friction: properties that no recording of sticking and slipping has.

A tip that sticks stays at one place, and every channel fits the rod with its tip there. A slip, by
whatever law it ends, follows the clamp, begins in a state that is loaded in the direction of the
slip, and releases energy. Where the clamp jumps samples are missing, and a few samples may be a
spike.
"""

import numpy as np
from scipy.special import chdtrc

from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray, StrArray
from vibrissa.sensor.identification.seen import Seen
from vibrissa.sensor.transducer import CHANNELS

# Fewer samples than these do not confirm each other.
FEW = 4
# Usual steps from which on a step is longer than usual, and from which on samples were lost.
LONG, LOST = 1.5, 10.0
# Lines of so many periods are named in a note.
NAMED = 3
# A residual of a lower probability than this is not noise.
UNLIKELY = 1e-9
# Standard deviations by which a slip may seem to go the wrong way, or to gain energy.
CERTAIN = 6.0


def doubts(seen: Seen, noise: FloatArray) -> dict[str, BoolArray]:
    """Tell for each reason to doubt a friction which periods it concerns.

    Parameters
    ----------
    seen : Seen
        p periods.
    noise : ndarray, shape (3,)
        Standard deviation of a reading; a channel without noise is not tested.

    Returns
    -------
    dict of str to ndarray of bool, shape (p,)
    """
    found = misfits(seen, noise)
    samples, periods = seen.samples, seen.periods
    last, first = periods.ends[:-1], periods.begins[1:]
    gap = samples.clamp[first] - samples.clamp[last]
    steps = np.abs(np.diff(samples.clamp))
    usual = float(np.median(steps[steps > 0.0])) if steps.any() else np.inf
    none = np.zeros(1, dtype=bool)

    wrong = _wrong_way(seen, gap, usual)
    found["no slip goes that way"] = np.append(wrong, none)
    lost = np.abs(gap) > LOST * usual
    found["samples are missing beside it, or the clamp jumped"] = np.append(lost, none) | np.append(
        none, lost
    )
    came = samples.clamp[last] - samples.clamp[np.maximum(last - FEW, 0)]
    went = samples.clamp[np.minimum(first + FEW, len(samples) - 1)] - samples.clamp[first]
    found["the clamp turned beside its end"] = np.append(came * went < 0.0, none)
    few = periods.counts < FEW
    found["too few samples"] = few
    # If they are a spike, the period before did not end there.
    found["too few samples after it"] = np.append(few[1:], none)
    return found


def misfits(seen: Seen, noise: FloatArray) -> dict[str, BoolArray]:
    """Tell for each channel in which periods it does not fit one contact.

    Parameters
    ----------
    seen : Seen
    noise : ndarray, shape (3,)
        As for `doubts`.

    Returns
    -------
    dict of str to ndarray of bool, shape (p,)
    """
    states, samples, periods = seen.states, seen.samples, seen.periods
    x0 = states.clip(seen.x0)
    expected, slope = states(x0), states.slope(x0)
    found = {}
    for i, name in enumerate(CHANNELS):
        there = np.isfinite(samples.readings[:, i]) & (noise[i] > 0.0)
        miss = np.where(there, (samples.readings[:, i] - expected[:, i]) / noise[i], 0.0)
        tilt = np.where(there, slope[:, i] / noise[i], 0.0)
        squares, mixed, tilts, number = (
            periods.sums(values) for values in (miss**2, tilt * miss, tilt**2, there.astype(float))
        )
        # An error of the contact's position moves all samples of a period together.
        squares -= mixed**2 / (tilts + 1.0 / seen.contacts.deviation**2)
        chance = chdtrc(np.maximum(number, 1.0), squares)
        found[f"{name} does not fit a tip that stays where it is"] = chance < UNLIKELY
    return found


def _wrong_way(seen: Seen, gap: FloatArray, usual: float) -> BoolArray:
    """Tell which periods but the last end with a slip that no slip law allows."""
    start, x0, deviation = seen.samples.start, seen.samples.x0, seen.samples.deviation
    last, first = seen.periods.ends[:-1], seen.periods.begins[1:]
    way = np.where(gap == 0.0, np.sign(x0[last]), np.sign(gap))
    backward = way * np.diff(seen.contacts.place) <= 0.0
    unloaded = way * (x0[last] + start[first] - start[last]) < CERTAIN * deviation[last]
    # The clamp rests while the tip slips: the energy is that at the height after it.
    states, _ = seen.branch.above(seen.samples.clamp[first])
    before, after = (states.clip(x0[rows]) for rows in (last, first))
    gained = states.energy(after) - states.energy(before)
    error = np.hypot(states(before)[:, 0] * deviation[last], states(after)[:, 0] * deviation[first])
    # Over a longer step the slip must be certain, or it was the clamp that jumped.
    limit = np.where(np.abs(gap) > LONG * usual, -CERTAIN, CERTAIN)
    return np.asarray(backward | unloaded | (gained > limit * error))


def in_words(reasons: dict[str, BoolArray]) -> StrArray:
    """Reasons to doubt each period, separated by semicolons."""
    rows = np.array(list(reasons.values())).T
    return np.array(["; ".join(np.array(list(reasons))[row]) for row in rows])


def notes_of(
    reasons: dict[str, BoolArray], first_line: IntArray, last_line: IntArray
) -> tuple[str, ...]:
    """One line for each reason to doubt, with the lines of the first periods that it concerns."""
    notes = []
    for why, periods in reasons.items():
        lines = list(zip(first_line[periods], last_line[periods], strict=True))
        if lines:
            shown = ", ".join(f"{first}-{last}" for first, last in lines[:NAMED])
            more = ", ..." if lines[NAMED:] else ""
            notes.append(
                f"in doubt, {why}: {len(lines)} of {len(periods)} periods, line {shown}{more}"
            )
    return tuple(notes)
