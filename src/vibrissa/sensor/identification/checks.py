"""Reasons to doubt a friction, with their messages and the periods that they concern."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray, StrArray
from vibrissa.sensor.identification.slips import LOST, Spans, usual_step

# Fewer samples than these do not confirm each other.
FEW = 4
# Lines of so many periods are named in a note.
NAMED = 3


class Grade(StrEnum):
    """Severity of a doubt, ascending.

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


@dataclass(frozen=True, eq=False, kw_only=True)
class Check:
    """A reason to doubt a friction."""

    grade: Grade
    periods: BoolArray
    sentence: str
    summed: bool = False
    coarse: bool = False


def checks_of_spans(clamp: FloatArray, spans: Spans) -> list[Check]:
    """Check the way of the clamp and the number of samples."""
    ends, usual = spans.ends, usual_step(clamp)
    gap = clamp[spans.after] - clamp[ends]
    lost = spans.cut | (np.abs(gap) > LOST * usual)
    came = clamp[ends] - clamp[np.maximum(ends - FEW, spans.begins)]
    went = clamp[np.minimum(spans.after + FEW, len(clamp) - 1)] - clamp[spans.after]
    turned = came * np.where(went == 0.0, gap, went) < 0.0
    few = spans.counts < FEW
    coarse = bool(np.median(spans.counts) < 2 * FEW)
    return [
        Check(
            grade=Grade.DOUBTFUL,
            periods=(lost | turned) & ~spans.passes,
            sentence="samples are missing after it, or the clamp jumped or turned (measure again)",
        ),
        # Where most periods have few samples only a finer recording helps.
        Check(
            grade=Grade.WRONG,
            periods=few & coarse,
            sentence=f"fewer than {FEW} samples in a period: sample more finely",
            summed=True,
            coarse=True,
        ),
        Check(
            grade=Grade.WRONG,
            periods=few & (not coarse),
            sentence="too few samples: a spike, or a rest to be cut off (import --from)",
        ),
        # If they are a spike, the period before did not end there. The last one may be cut short.
        Check(
            grade=Grade.DOUBTFUL,
            periods=np.append(few[1:-1], [False, False])[: len(few)] & (not coarse),
            sentence="too few samples after it",
        ),
    ]


def rough(periods: BoolArray) -> Check:
    """Doubt forces that are not smooth."""
    why = "the forces do not follow a smooth curve: a slip may be hidden"
    return Check(grade=Grade.WRONG, periods=periods, sentence=why)


def backward(periods: BoolArray) -> Check:
    """Doubt slips that do not follow the clamp."""
    return Check(
        grade=Grade.WRONG, periods=periods, sentence="the tip cannot slip in this direction"
    )


def misfit(channel: str, periods: BoolArray) -> Check:
    """Doubt periods that do not fit the rod by themselves."""
    why = f"{channel} does not fit a tip that stays where it is; after slow slips state --slip-time"
    return Check(grade=Grade.WRONG, periods=periods, sentence=why)


def unfitted(settled: bool, fits: bool, number: int) -> Check:
    """Grade all periods as doubtful if the recording does not fit the given set-up."""
    why = "the recording does not fit the set-up"
    if not settled:
        why = "the recording is too far from the given set-up to be fitted"
    elif fits:
        why = "a given value is far off for its tolerance"
    return Check(grade=Grade.DOUBTFUL, periods=np.full(number, True), sentence=why, summed=settled)


def untared(number: int) -> Check:
    """Grade friction without a rod as doubtful if the zeros are unknown."""
    why = (
        "no reading checks the tare: state zero_force_x and zero_force_y, or record some rows "
        "before the tip touches"
    )
    return Check(grade=Grade.DOUBTFUL, periods=np.full(number, True), sentence=why)


def disagreeing(periods: BoolArray, all_together: bool) -> Check:
    """Doubt periods of which model and ratio of the forces disagree."""
    why = "model and ratio of the forces disagree"
    return Check(grade=Grade.DOUBTFUL, periods=periods, sentence=why, summed=all_together)


def grades(checks: Sequence[Check], number: int) -> StrArray:
    """Grade of the worst doubt of each of so many periods; empty where there is none."""
    found = np.full(number, "", dtype=f"U{max(map(len, Grade))}")
    for grade in Grade:  # a worse one overwrites those before it
        for one in checks:
            if one.grade is grade:
                found[one.periods] = grade
    return found


def sentences(checks: Sequence[Check], number: int) -> StrArray:
    """Doubts of each of so many periods, separated by semicolons."""
    return np.array(
        ["; ".join(one.sentence for one in checks if one.periods[i]) for i in range(number)],
        dtype=str,
    )


def notes_of(checks: Sequence[Check], first: IntArray, last: IntArray) -> tuple[str, ...]:
    """One line for each doubt, with the lines of the first periods that it concerns."""
    notes = []
    for one in checks:
        if one.summed or not one.periods.any():
            continue
        text = f"{one.grade}: {one.sentence}"
        if not one.periods.all():
            lines = zip(first[one.periods], last[one.periods], strict=True)
            shown = [f"{begin}-{end}" for begin, end in lines]
            more = ", ..." if shown[NAMED:] else ""
            text += f": {len(shown)} of {len(one.periods)} periods, line "
            text += ", ".join(shown[:NAMED]) + more
        notes.append(text)
    return tuple(notes)
