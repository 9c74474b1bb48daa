"""Reasons to doubt a friction: properties that no recording of sticking and slipping has.

A tip that sticks stays at one place, and every channel fits the rod with its tip there. A slip, by
whatever law it ends, follows the clamp, begins in a state that is loaded in the direction of the
slip, and releases energy. Where the clamp jumps samples are missing, and a few samples may be a
spike.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum, StrEnum

import numpy as np
from scipy.special import chdtrc

from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray, StrArray
from vibrissa.sensor.identification.reading.jumps import LONG, LOST, usual_step
from vibrissa.sensor.identification.seen import Seen
from vibrissa.sensor.transducer import CHANNELS

# Fewer samples than these do not confirm each other.
FEW = 4
# Lines of so many periods are named in a note.
NAMED = 3
# A residual of a lower probability than this is not noise.
UNLIKELY = 1e-9
# Standard deviations by which a slip may seem to go the wrong way, or to gain energy.
CERTAIN = 6.0


class Grade(StrEnum):
    """How much a doubt matters, the least first.

    Attributes
    ----------
    INFORMATION
        The friction stands; something beside it is unusual.
    DOUBTFUL
        The friction may be wrong: look at the readings.
    WRONG
        The readings contradict the friction: do not use it.
    """

    INFORMATION = "information"
    DOUBTFUL = "doubtful"
    WRONG = "wrong"


class Doubt(Enum):
    """Reasons to doubt a friction: the grade of each, and how it is explained.

    Attributes
    ----------
    grade : Grade
    why : str
        For a person; after the name of a channel where one is concerned.
    """

    READ_MISFIT = Grade.WRONG, "does not fit a tip that stays where it is"
    WRONG_WAY = Grade.WRONG, "no slip goes that way"
    GAP_BEFORE = Grade.INFORMATION, "samples are missing before it, or the clamp jumped"
    GAP_AFTER = Grade.DOUBTFUL, "samples are missing after it, or the clamp jumped (measure again)"
    GAP_UNCLEAR = (
        Grade.WRONG,
        "samples are missing after it, or the clamp jumped, and no slip is certain (measure again)",
    )
    TURN = Grade.DOUBTFUL, "the clamp turned beside its end"
    FEW = (
        Grade.WRONG,
        "too few samples: too coarse steps, a spike, or a rest to be cut off (import --from)",
    )
    # If they are a spike, the period before did not end there.
    FEW_AFTER = Grade.DOUBTFUL, "too few samples after it"
    ROUGH = Grade.WRONG, "the forces do not follow a smooth curve: a slip may be hidden"
    SWUNG = Grade.DOUBTFUL, "the rod may have swung aside, and not slipped"
    WHOLE = Grade.DOUBTFUL, "the recording as a whole does not fit the rod"
    BESIDE = Grade.DOUBTFUL, "model and ratio of the forces disagree"
    FAR = Grade.DOUBTFUL, "is by the recording far from what was given, for its tolerance"
    NOT_ADJUSTED = Grade.DOUBTFUL, "the recording is too far from what was given to be adjusted"

    def __init__(self, grade: Grade, why: str) -> None:
        self.grade = grade
        self.why = why


@dataclass(frozen=True, eq=False, kw_only=True)
class Doubted:
    """Which periods one reason to doubt concerns.

    Attributes
    ----------
    doubt : Doubt
    channel : str
        Of which it is, or what else it concerns; empty where it is of none.
    periods : ndarray of bool, shape (p,)
    """

    doubt: Doubt
    channel: str = ""
    periods: BoolArray

    @property
    def why(self) -> str:
        """The reason in words."""
        return f"{self.channel} {self.doubt.why}".lstrip()


def doubts(seen: Seen, noise: FloatArray) -> list[Doubted]:
    """Tell for each reason to doubt a friction which periods it concerns.

    Parameters
    ----------
    seen : Seen
        p periods.
    noise : ndarray, shape (3,)
        Standard deviation of a reading; a channel without noise is not tested.

    Returns
    -------
    list of Doubted
        All reasons, in the same order for all periods.
    """
    samples, periods = seen.samples, seen.periods
    last, first = periods.ends[:-1], periods.begins[1:]
    gap = samples.clamp[first] - samples.clamp[last]
    usual = usual_step(samples.clamp)
    none = np.zeros(1, dtype=bool)
    lost = np.abs(seen.last.clamp_gap[:-1]) > LOST * usual
    came = samples.clamp[last] - samples.clamp[np.maximum(last - FEW, 0)]
    went = samples.clamp[np.minimum(first + FEW, len(samples) - 1)] - samples.clamp[first]
    few = periods.counts < FEW
    misfit = zip(CHANNELS, misfits(seen, noise), strict=True)
    wrong = _wrong_way(seen, gap, usual, lost)
    found = {
        Doubt.WRONG_WAY: np.append(wrong & ~lost, none),
        Doubt.GAP_BEFORE: np.append(none, lost),
        Doubt.GAP_AFTER: np.append(lost & ~wrong, none),
        Doubt.GAP_UNCLEAR: np.append(lost & wrong, none),
        Doubt.TURN: np.append(came * went < 0.0, none),
        Doubt.FEW: few,
        Doubt.FEW_AFTER: np.append(few[1:], none),
    }
    return [Doubted(doubt=Doubt.READ_MISFIT, channel=name, periods=off) for name, off in misfit] + [
        Doubted(doubt=doubt, periods=which) for doubt, which in found.items()
    ]


def misfits(seen: Seen, noise: FloatArray) -> list[BoolArray]:
    """Tell for each channel in which periods it does not fit one contact.

    Parameters
    ----------
    seen : Seen
    noise : ndarray, shape (3,)
        As for `doubts`.

    Returns
    -------
    list of ndarray of bool, shape (p,)
        One for each of the three channels.
    """
    states, samples, periods = seen.states, seen.samples, seen.periods
    x0 = states.clip(seen.x0)
    expected, slope = states(x0), states.slope(x0)
    scale, found = np.where(noise > 0.0, noise, np.inf), []
    for i in range(len(CHANNELS)):
        there = np.isfinite(samples.readings[:, i])
        miss = np.where(there, (samples.readings[:, i] - expected[:, i]) / scale[i], 0.0)
        tilt = np.where(there, slope[:, i] / scale[i], 0.0)
        squares, mixed, tilts, number = (
            periods.sums(values) for values in (miss**2, tilt * miss, tilt**2, there.astype(float))
        )
        # An error of the contact's position moves all samples of a period together.
        squares -= mixed**2 / (tilts + 1.0 / seen.contacts.deviation**2)
        found.append(chdtrc(np.maximum(number, 1.0), squares) < UNLIKELY)
    return found


def _wrong_way(seen: Seen, gap: FloatArray, usual: float, lost: BoolArray) -> BoolArray:
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
    # Where samples are missing the tip may have slipped and the rod have been bent again, to more
    # than a step further: where it is bent as before, it may have been the clamp that jumped.
    further = LONG * usual + CERTAIN * np.hypot(deviation[last], deviation[first])
    several = lost & (way * (x0[first] - x0[last]) > further)
    return np.asarray(backward | unloaded | ((gained > limit * error) & ~several))


def with_reason(grade: StrArray, words: StrArray, reason: Doubted) -> tuple[StrArray, StrArray]:
    """Add a reason to the grades and words of p periods."""
    order = ["", *Grade]
    worse = [order.index(one) < order.index(reason.doubt.grade) for one in grade.tolist()]
    joined = [f"{one}; {reason.why}" if one else reason.why for one in words.tolist()]
    longest = max(map(len, Grade))
    return (
        np.where(reason.periods & worse, reason.doubt.grade.value, grade.astype(f"U{longest}")),
        np.where(reason.periods, np.array(joined), words),
    )


def in_words(reasons: Sequence[Doubted]) -> StrArray:
    """Reasons to doubt each period, separated by semicolons."""
    rows = np.array([one.periods for one in reasons]).T
    return np.array(
        ["; ".join(one.why for one, on in zip(reasons, row, strict=True) if on) for row in rows]
    )


def graded(reasons: Sequence[Doubted]) -> StrArray:
    """Grade of the worst reason to doubt each period; empty where there is none."""
    grades = np.full(len(reasons[0].periods), "", dtype=f"U{max(map(len, Grade))}")
    for grade in Grade:  # a worse one overwrites those before it
        for one in reasons:
            if one.doubt.grade is grade:
                grades[one.periods] = grade
    return grades


def notes_of(
    reasons: Sequence[Doubted], first_line: IntArray, last_line: IntArray
) -> tuple[str, ...]:
    """One line for each reason to doubt, with the lines of the first periods that it concerns."""
    notes = []
    for one in reasons:
        lines = list(zip(first_line[one.periods], last_line[one.periods], strict=True))
        if lines:
            shown = ", ".join(f"{first}-{last}" for first, last in lines[:NAMED])
            more = ", ..." if lines[NAMED:] else ""
            notes.append(
                f"{one.doubt.grade}: {one.why}: {len(lines)} of {len(one.periods)} periods, line "
                f"{shown}{more}"
            )
    return tuple(notes)
