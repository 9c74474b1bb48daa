"""Published numbers, compared with ours.

Each file in validation/sources has the numbers of one source, as printed there. Exit status 1 if a
number differs from ours by more than its rounding and no reason is known, or if a number agrees
although a reason for its difference is given.
"""

import csv
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from decimal import Decimal
from inspect import cleandoc
from pathlib import Path
from typing import NamedTuple

from validation import published_quantities
from validation.records import write_record
from vibrissa.wording import markdown_table

SOURCES = Path(__file__).parent / "sources"
# How far an exact magnitude may lie below and above a printed one, in units of the last digit.
ROUNDINGS = {
    "exact": (0.0, 0.0),
    "nearest": (0.5, 0.5),
    # Rounded to one more digit first, and then again.
    "twice": (0.55, 0.55),
    # Some numbers of a table are rounded, others have their further digits cut off.
    "nearest or cut": (0.5, 1.0),
}


class Number(NamedTuple):
    """A published number: a line in the file of its source.

    Attributes
    ----------
    quantity : str
        Name of a function of `published_quantities`.
    argument, argument_rounding, value, rounding : str
        Argument and value as printed, and how each was rounded (a key of `ROUNDINGS`).
    digit : str
        Size of one unit in the last digit of the value, if the printed text does not show it.
    place : str
        Place in the source.
    known_difference : str
        Reason why the value differs from ours; empty for nearly all numbers.
    """

    quantity: str
    argument: str
    argument_rounding: str
    value: str
    digit: str
    rounding: str
    place: str
    known_difference: str


class Source(NamedTuple):
    """A source: its title, notes (citation, and how it was read), and its numbers."""

    title: str
    notes: str
    numbers: list[Number]


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """A published number, compared with ours.

    Attributes
    ----------
    number : Number
    ours : float
    allowed : tuple of float
        Smallest and largest difference, ours minus published, that rounding explains.
    """

    number: Number
    ours: float
    allowed: tuple[float, float]

    @property
    def difference(self) -> float:
        """Our number minus the published one."""
        return self.ours - float(self.number.value)

    @property
    def agrees(self) -> bool:
        """Whether the rounding of the source explains the difference."""
        least, largest = self.allowed
        return least <= self.difference <= largest

    @property
    def expected(self) -> bool:
        """Whether the number agrees, or differs for a known reason."""
        return self.agrees != bool(self.number.known_difference)


def read_source(path: Path) -> Source:
    """Read a source: lines that begin with # are its title (the first) and its notes."""
    lines = path.read_text(encoding="utf-8").splitlines()
    title, *notes = (line[1:].strip() for line in lines if line.startswith("#"))
    rows = csv.DictReader(line for line in lines if not line.startswith("#"))
    return Source(title, "\n".join(notes), [Number(**row) for row in rows])


def read_sources() -> list[Source]:
    """Read all sources."""
    return [read_source(path) for path in sorted(SOURCES.glob("*.csv"))]


def bounds(text: str, rounding: str, digit: str = "") -> tuple[float, float]:
    """Return the smallest and the largest exact number that is printed as `text`."""
    last = Decimal(digit) if digit else Decimal(1).scaleb(Decimal(text).as_tuple().exponent)
    below, above = (share * float(last) for share in ROUNDINGS[rounding])
    value = float(text)
    return (value - below, value + above) if value >= 0.0 else (value - above, value + below)


def compare(number: Number) -> Comparison:
    """Compute our number, and compare it with the published one.

    If the argument is rounded, too, our number is also computed for the smallest and the largest
    exact argument, and assumed to be monotonic in between.
    """
    quantity = getattr(published_quantities, number.quantity)
    ours = quantity(Decimal(number.argument))
    at_ends = [ours]
    if number.argument_rounding != "exact":
        ends = bounds(number.argument, number.argument_rounding)
        at_ends += [quantity(Decimal(repr(end))) for end in ends]
    low, high = bounds(number.value, number.rounding, number.digit)
    value = float(number.value)
    allowed = (low - value - (max(at_ends) - ours), high - value + (ours - min(at_ends)))
    return Comparison(number=number, ours=ours, allowed=allowed)


def summary(compared: Sequence[tuple[Source, Sequence[Comparison]]]) -> str:
    """Count the verdicts of each source, and of all sources."""
    everything = [comparison for _, comparisons in compared for comparison in comparisons]
    parts = [(source.title, comparisons) for source, comparisons in compared]
    rows = []
    for title, comparisons in [*parts, ("**all**", everything)]:
        agree = sum(comparison.agrees for comparison in comparisons)
        rows.append([title, *map(str, (len(comparisons), agree, len(comparisons) - agree))])
    return markdown_table(["source", "numbers", "agree", "differ"], rows)


def section(source: Source, comparisons: Sequence[Comparison]) -> Iterator[str]:
    """Yield title and notes of a source, and a table of its numbers for each quantity."""
    yield f"\n## {source.title}\n\n{source.notes}"
    head = ["argument", "published", "ours", "difference", "allowed", "verdict", "place"]
    for name in dict.fromkeys(comparison.number.quantity for comparison in comparisons):
        what, _, mapping = cleandoc(getattr(published_quantities, name).__doc__).partition("\n")
        rows = [cells(one) for one in comparisons if one.number.quantity == name]
        yield f"\n**{what}**\n{mapping}\n\n{markdown_table(head, rows)}"
    for reason in sorted({one.number.known_difference for one in comparisons} - {""}):
        yield f"\nWhere it differs: {reason}."


def cells(comparison: Comparison) -> list[str]:
    """Format a comparison as the cells of a row."""
    number = comparison.number
    # Two digits more than the source has.
    digits = len(Decimal(number.value).as_tuple().digits) + 2
    least, largest = comparison.allowed
    return [
        number.argument,
        number.value,
        f"{comparison.ours:#.{digits}g}",
        f"{comparison.difference:+.2e}",
        f"{least:+.2e} … {largest:+.2e}",
        "agrees" if comparison.agrees else "**differs**",
        number.place,
    ]


def main() -> int:
    """Compare all numbers, write the record, and print those that are not as expected."""
    compared = [(source, [compare(n) for n in source.numbers]) for source in read_sources()]
    sections = [part for one in compared for part in section(*one)]
    write_record("published", __doc__, "\n".join([summary(compared), *sections]))
    print(summary(compared))
    unexpected = [one for _, comparisons in compared for one in comparisons if not one.expected]
    for one in unexpected:
        verdict = "agrees, which was not expected" if one.agrees else "differs"
        print(f"{verdict}: {one.number.quantity}", *cells(one), sep=" | ", file=sys.stderr)
    return 1 if unexpected else 0
