"""Reasons to doubt a friction: one list, each with the periods that it concerns.

A tip that sticks stays at one place, and every channel fits the rod with its tip there. A slip
follows the clamp and begins in a state that is loaded in its direction. Where the clamp jumps
samples are missing, and a few samples may be a spike.
"""

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
    """A reason to doubt a friction.

    Attributes
    ----------
    name : str
    grade : Grade
    periods : ndarray of bool, shape (p,)
        Which it concerns.
    sentence : str
        Of which and why, for a person.
    """

    name: str
    grade: Grade
    periods: BoolArray
    sentence: str


def checks_of_spans(clamp: FloatArray, spans: Spans) -> list[Check]:
    """Check the way of the clamp and the number of samples."""
    ends, usual = spans.ends, usual_step(clamp)
    gap = clamp[spans.after] - clamp[ends]
    lost = (spans.cut | (np.abs(gap) > LOST * usual)) & ~spans.passes
    came = clamp[ends] - clamp[np.maximum(ends - FEW, spans.begins)]
    went = clamp[np.minimum(spans.after + FEW, len(clamp) - 1)] - clamp[spans.after]
    few = spans.counts < FEW
    # Where most periods have few samples only a finer recording helps.
    coarse = np.full(len(few), np.median(spans.counts) < 2 * FEW)
    return [
        Check(
            name="gap",
            grade=Grade.DOUBTFUL,
            periods=lost,
            sentence="samples are missing after it, or the clamp jumped (measure again)",
        ),
        Check(
            name="turn",
            grade=Grade.DOUBTFUL,
            periods=(came * np.where(went == 0.0, gap, went) < 0.0) & ~spans.passes,
            sentence="the clamp turned beside its end",
        ),
        Check(
            name="coarse",
            grade=Grade.WRONG,
            periods=few & coarse,
            sentence=f"fewer than {FEW} samples in a period: sample more finely",
        ),
        Check(
            name="few",
            grade=Grade.WRONG,
            periods=few & ~coarse,
            sentence="too few samples: a spike, or a rest to be cut off (import --from)",
        ),
        # If they are a spike, the period before did not end there.
        Check(
            name="few after",
            grade=Grade.DOUBTFUL,
            periods=np.append(few[1:], False) & ~coarse,
            sentence="too few samples after it",
        ),
    ]


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
        if one.name == "coarse":  # the summary says it
            continue
        lines = list(zip(first[one.periods], last[one.periods], strict=True))
        if lines:
            shown = ", ".join(f"{begin}-{end}" for begin, end in lines[:NAMED])
            more = ", ..." if lines[NAMED:] else ""
            notes.append(
                f"{one.grade}: {one.sentence}: {len(lines)} of {len(one.periods)} periods, line "
                f"{shown}{more}"
            )
    return tuple(notes)
