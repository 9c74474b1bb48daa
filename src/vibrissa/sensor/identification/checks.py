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


@dataclass(frozen=True, eq=False)
class Check:
    """A reason to doubt a friction; `summed` if the summary says it, `coarse` if nothing else."""

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
    # If few samples are a spike, the period before did not end there. The last may be cut short.
    before = np.append(few[1:-1], [False, False])[: len(few)]
    finer = f"fewer than {FEW} samples in a period: sample more finely"
    jumped = "samples are missing after it, or the clamp jumped or turned (measure again)"
    spike = "too few samples: a spike, or a rest to be cut off (import --from)"
    return [
        Check(Grade.DOUBTFUL, (lost | turned) & ~spans.passes, jumped),
        # Where most periods have few samples only a finer recording helps.
        Check(Grade.WRONG, few & coarse, finer, summed=True, coarse=True),
        Check(Grade.WRONG, few & (not coarse), spike),
        Check(Grade.DOUBTFUL, before & (not coarse), "too few samples after it"),
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
