"""Columns of a recording: which column of the file is which, and in which unit."""

import re
from typing import NamedTuple

from vibrissa.errors import ArgumentError
from vibrissa.quantities.units import Kind, is_number, unit_ratio, unit_size
from vibrissa.sensor.importing.clock import is_clock, is_date, is_dated, unit_since_1970
from vibrissa.sensor.importing.layout import Layout
from vibrissa.sensor.importing.numbers import is_missing
from vibrissa.sensor.importing.titles import (
    KINDS,
    NamedUnit,
    Stated,
    ending_of,
    stated_in,
    title_of,
    unit_named,
)

# Endings that may be an index: F_N may be a normal force, x_m a mean.
INDEX = re.compile("[mN]")
# Whole seconds of a time, and the nanoseconds beside them, as in ROS: stamp.sec, stamp.nanosec.
SECONDS = re.compile(r"(.*?)sec(?:ond)?s?", re.IGNORECASE)
NANOSECONDS = re.compile(r"(.*?)n(?:ano)?_?sec(?:ond)?s?", re.IGNORECASE)
# Units of signals that a factor converts.
VOLT = "V"


class FileColumn(NamedTuple):
    """A column of a file: its number from 0, title, unit, and the factor to SI units.

    Attributes
    ----------
    remark : str
        What the user should check, or how the unit was understood.
    clock : bool
        Whether the cells are times of a clock.
    beside : int or None
        Number of the column that completes the time: nanoseconds, or the dates of a clock.
    """

    number: int
    title: str
    unit: str
    factor: float
    remark: str = ""
    clock: bool = False
    beside: int | None = None

    @property
    def in_parts(self) -> bool:
        """Whether the cells are times of a clock, or need the column beside them."""
        return self.clock or self.beside is not None

    @property
    def note(self) -> str:
        """How the column is read, as in ``minus Fz in mN``."""
        sign = "minus " if self.factor < 0.0 else ""
        return f"{sign}{self.title} in {self.unit}{self.remark}"


def find_column(layout: Layout, target: str, source: str) -> FileColumn | None:
    """Find the column that `source` names, with its unit; None if there is no such column.

    Parameters
    ----------
    target : str
        Name of the quantity: time, footpoint, force_x, force_y or moment_z.
    source : str
        Name of the file's column: ``force_x``, ``-Fz [mN]``, or ``#3`` for the third.

    Raises
    ------
    ArgumentError
        If several columns have this name, or the unit is missing, is no unit of the quantity, or
        contradicts the file.
    """
    kind = KINDS[target]
    stated = stated_in(source)
    number = _number_of(layout, target, source, stated)
    if number is None:
        return None
    title = layout.titles[number]
    sign = -stated.factor if stated.minus else stated.factor
    if stated.per:
        return _scaled(layout, number, kind, stated, sign)
    if target == "time" and not stated.unit and (clock := _clock(layout, number)):
        return clock._replace(factor=sign * clock.factor)
    unit = _unit_of(layout, number, target, stated)
    times = f", times {stated.factor:g}" if stated.factor != 1.0 else ""
    return FileColumn(number, title, unit.name, sign * unit.size, times + unit.remark)


def _number_of(layout: Layout, target: str, source: str, stated: Stated) -> int | None:
    """Find the number of a column by its title, with or without the unit, or by its place."""
    kind = KINDS[target]
    name = stated.title.casefold()
    titles = enumerate(layout.titles)
    numbers = [number for number, title in titles if title == source]
    if not numbers:
        numbers = [
            number
            for number, title in enumerate(layout.titles)
            if name
            in {
                title.casefold(),
                title_of(title, kind)[0].casefold(),
                ending_of(title, kind)[0].casefold(),
                f"#{number + 1}",
            }
        ]
    if len(numbers) > 1:
        raise ArgumentError(
            f"several columns are called {stated.title}: choose one by its place in the file; "
            f"{target}=#2 is the second column"
        )
    return numbers[0] if numbers else None


def _clock(layout: Layout, number: int) -> FileColumn | None:
    """Return a column of times of a clock, or of seconds since 1970 or beside nanoseconds.

    Return None if it is none of these.
    """
    title = layout.titles[number]
    first = layout.first_value(number)
    if is_clock(first):
        dates = None if is_dated(first) else _dates_beside(layout)
        of = "" if dates is None else f" with the dates in {layout.titles[dates]}"
        remark = f" (times of a clock{of}), from the first row"
        return FileColumn(number, title, "s", 1.0, remark, clock=True, beside=dates)
    nanoseconds = _nanoseconds_beside(layout, number)
    if nanoseconds is not None:
        remark = f" plus {layout.titles[nanoseconds]} in ns, from the first row"
        return FileColumn(number, title, "s", 1.0, remark, beside=nanoseconds)
    if any(_units_in_file(layout, number, Kind.TIME)) or not is_number(first.replace(",", ".")):
        return None
    unit = unit_since_1970(float(first.replace(",", ".")))
    if not unit:
        return None
    remark = f" since 1970, from the first row (no unit in the file; {first} is a time in {unit})"
    return FileColumn(number, title, unit, float(unit_size(unit, Kind.TIME)), remark)


def _dates_beside(layout: Layout) -> int | None:
    """Find the only column of dates; None if there is none, or several."""
    places = range(len(layout.titles))
    dated = [place for place in places if is_date(layout.first_value(place))]
    return dated[0] if len(dated) == 1 else None


def _nanoseconds_beside(layout: Layout, number: int) -> int | None:
    """Find the column of the nanoseconds that belong to a column of whole seconds."""
    own = SECONDS.fullmatch(layout.titles[number])
    if own is None or NANOSECONDS.fullmatch(layout.titles[number]):
        return None
    others = [NANOSECONDS.fullmatch(title) for title in layout.titles]
    places = [place for place, other in enumerate(others) if other and other[1] == own[1]]
    return places[0] if len(places) == 1 else None


def _units_in_file(layout: Layout, number: int, kind: Kind) -> list[str]:
    """Units in the title and in the row below it; texts in brackets may be remarks."""
    above = title_of(layout.titles[number], kind)[1]
    below = layout.units[number].strip("[](){} ")
    return [unit for unit in (above, below) if not is_missing(unit)]


def _unit_of(layout: Layout, number: int, target: str, stated: Stated) -> NamedUnit:
    """Find the unit of a column; the option and the file must not contradict each other."""
    kind = KINDS[target]
    title = layout.titles[number]
    texts = _units_in_file(layout, number, kind)
    units = [unit for unit in (unit_named(text, kind) for text in texts) if unit]
    option = f'--column "{target}={stated.title} [{kind.si}]"'
    if stated.unit:
        unit = unit_named(stated.unit, kind)
        if unit is None:
            raise _no_unit(title, kind, stated.unit)
        others = [text for text in texts if _is_other(text, kind)]
        if (units and unit.size not in [known.size for known in units]) or (others and not units):
            raise ArgumentError(
                f"column {title} is in {' or '.join(texts)} by the file, but in {stated.unit} by "
                f"the option: leave out the unit; if the file is wrong, convert by a factor, as in "
                f'--column "{target}={stated.title} * 0.001"'
                + (f' or "{target}={stated.title} * 2.5 {kind.si}/{texts[0]}"' if others else "")
            )
        return unit
    if len({known.size for known in units}) > 1:
        raise ArgumentError(
            f"column {title} is in {' and '.join(texts)} by the file: state which, as in {option}"
        )
    if units:
        return units[0]
    if texts:
        raise _no_unit(title, kind, texts[-1])
    ending = ending_of(title, kind)[1]
    unit = unit_named(ending, kind) if ending else None
    if unit is None:
        raise ArgumentError(f"column {title} has no unit: add it, as in {option}")
    if INDEX.fullmatch(ending):
        remark = f"? The ending may be no unit: if so, state the unit, as in {option}"
        return unit._replace(remark=remark)
    return unit


def _no_unit(title: str, kind: Kind, text: str) -> ArgumentError:
    factor = f"; convert a voltage by a factor, as in Ch1 * 2.5 {kind.si}/V"
    return ArgumentError(
        f"column {title} must have a unit of {kind}, such as {kind.si}, got {text!r}"
        + (factor if unit_ratio(text, VOLT) else "")
    )


def _is_other(text: str, kind: Kind) -> bool:
    """Whether a text is a unit of a signal, or of another column of recordings."""
    kinds = set(KINDS.values()) - {kind}
    return bool(unit_ratio(text, VOLT)) or any(unit_size(text, other) for other in kinds)


def _scaled(layout: Layout, number: int, kind: Kind, stated: Stated, factor: float) -> FileColumn:
    """Return a column with a factor such as 12.5 N/V."""
    title = layout.titles[number]
    name, _, per = (part.strip() for part in stated.per.partition("/"))
    unit = unit_named(name, kind)
    if unit is None:
        raise ArgumentError(
            f"the factor of column {title} must be in {kind.si} per unit of the column, as in "
            f"{stated.factor:g} {kind.si}/V, got {stated.per!r}"
        )
    own = [stated.unit] if stated.unit else _units_in_file(layout, number, kind)
    ratio = 1.0
    if own:
        ratio = 1.0 if own[0] == per else float(unit_ratio(own[0], per or "1"))
        if not ratio:
            raise ArgumentError(
                f"column {title} is in {own[0]} by the file, but its factor is {stated.per}"
            )
    remark = f", times {stated.factor:g} {stated.per}"
    return FileColumn(number, title, unit.name, factor * unit.size * ratio, remark)
