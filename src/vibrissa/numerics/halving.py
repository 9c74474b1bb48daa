"""Halving the intervals of an axis until straight lines tell what happens between its values.

An interval *is met* if two things hold at the three places that quarter it. The value differs by at
most the tolerance from the straight line between the ends, which is what a reader of a plot draws.
And what happens there is of the same kind as at the ends. An interval that is not met is halved,
unless its halves would be too narrow. One place in the middle would not do: the line through a
curve's inflection passes there. Where there are several values, all of this is asked of each.
"""

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from enum import Enum, auto
from typing import NamedTuple


class Reading(NamedTuple):
    """What is found at a place: values, NaN where there are none, and of which kind it is."""

    values: tuple[float, ...]
    kind: Hashable


class Verdict(Enum):
    """How an interval is."""

    MET = auto()
    SWITCH = auto()  # its ends differ in kind
    UNMET = auto()  # its ends do not, but a line between them does not tell what is between


# Places of an axis, in increasing order, to what is found at each.
Read = Callable[[Sequence[Decimal]], Sequence[Reading]]
Interval = tuple[Decimal, Decimal]


@dataclass(frozen=True, kw_only=True)
class Halved:
    """An axis whose intervals were halved.

    Attributes
    ----------
    added : tuple of Decimal
        Places between those that were given, in increasing order.
    switches, unmet : tuple of (Decimal, Decimal)
        Intervals that are too narrow to be halved: those in which a kind changes into another, and
        those that are not met for another reason.
    """

    added: tuple[Decimal, ...]
    switches: tuple[Interval, ...]
    unmet: tuple[Interval, ...]


def halve(intervals: Sequence[Interval], read: Read, tolerance: float, closest: Decimal) -> Halved:
    """Halve intervals of an axis until each is met, or its halves would be too narrow.

    Parameters
    ----------
    intervals : sequence of (Decimal, Decimal)
        Start and stop of each, in increasing order; they have no more than ends in common.
    read : callable
        Takes places and tells what is found there. It is asked once for each generation of
        intervals.
    tolerance : float
        Largest distance of a value from the straight line between the ends, not negative.
    closest : Decimal
        Least width of a half, positive.

    Returns
    -------
    Halved
    """
    ends = sorted({end for interval in intervals for end in interval})
    known = dict(zip(ends, read(ends), strict=True))
    added: list[Decimal] = []
    left: dict[Verdict, list[Interval]] = {verdict: [] for verdict in Verdict}
    while intervals:
        quarters = sorted({place for each in intervals for place in _quarters(each)} - known.keys())
        known |= zip(quarters, read(quarters), strict=True)
        halves: list[Interval] = []
        for interval in intervals:
            start, stop = interval
            at = (start, *_quarters(interval), stop)
            middle = at[2]
            found = verdict([known[place] for place in at], tolerance)
            if found is not Verdict.MET and middle - start >= closest:
                added.append(middle)
                halves += [(start, middle), (middle, stop)]
            else:
                left[found].append(interval)
        intervals = halves
    return Halved(
        added=tuple(sorted(added)),
        switches=tuple(sorted(left[Verdict.SWITCH])),
        unmet=tuple(sorted(left[Verdict.UNMET])),
    )


def verdict(readings: Sequence[Reading], tolerance: float) -> Verdict:
    """Judge an interval by what is found at its ends and at the places that quarter it.

    Parameters
    ----------
    readings : sequence of Reading
        Five, in the order of their places.
    tolerance : float

    Returns
    -------
    Verdict
    """
    first, *_, last = readings
    if first.kind != last.kind:
        return Verdict.SWITCH
    if any(reading.kind != first.kind for reading in readings):
        return Verdict.UNMET
    steps = len(readings) - 1
    off = (
        abs(value - (start + (stop - start) * i / steps))
        for i, reading in enumerate(readings)
        for value, start, stop in zip(reading.values, first.values, last.values, strict=True)
    )
    # NaN, where nothing has a value, is not larger.
    return Verdict.UNMET if any(distance > tolerance for distance in off) else Verdict.MET


def _quarters(interval: Interval) -> tuple[Decimal, Decimal, Decimal]:
    """Places that quarter an interval."""
    start, stop = interval
    middle = (start + stop) / 2
    return (start + middle) / 2, middle, (middle + stop) / 2
