"""Times of a clock, such as 10:12:30.5 or 2026-03-12T10:12:30, and counts since 1970."""

import re
from datetime import date
from typing import TYPE_CHECKING

import numpy as np

from vibrissa.errors import RecordingError
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.quantities.series import listed

if TYPE_CHECKING:
    from pandas import Series

DATE = re.compile("[0-9]{1,4}[-./][0-9]{1,2}[-./][0-9]{1,4}")
# Date and zone are optional.
CLOCK = re.compile(
    rf"(?:({DATE.pattern})(?:T|,?\s+))?"
    r"([0-9]{1,2}):([0-9]{2}):([0-9]{2}(?:[.,][0-9]*)?)"
    r"(?:\s*([AaPp])\.?[Mm]\.?)?(?:\s*(?:Z|UTC|GMT|[-+][0-9]{2}:?[0-9]{2}))?"
)
# Order of year, month and day in a date.
ORDERS = {"day/month": (2, 1, 0), "month/day": (2, 0, 1)}
DAY = 86400.0
# Counts of seconds, ms, us and ns since 1970 in the years from 2001 to 2096.
SINCE_1970 = {"s": 1e9, "ms": 1e12, "us": 1e15, "ns": 1e18}
MOST = 4.0


def is_clock(cell: str) -> bool:
    """Whether a cell is the time of a clock."""
    return CLOCK.fullmatch(cell.strip()) is not None


def is_dated(cell: str) -> bool:
    """Whether the time of a clock has a date."""
    parts = CLOCK.fullmatch(cell.strip())
    return parts is not None and parts[1] is not None


def is_date(cell: str) -> bool:
    """Whether a cell is a date without a time."""
    return DATE.fullmatch(cell.strip()) is not None


def unit_since_1970(value: float) -> str:
    """Return the unit of a count since 1970; empty if the value is no such count.

    Examples
    --------
    >>> unit_since_1970(1.78e18)
    'ns'
    """
    units = (unit for unit, least in SINCE_1970.items() if least <= value < MOST * least)
    return next(units, "")


def since_first(cells: "Series[str]", name: str, missing: BoolArray) -> FloatArray:
    """Convert times of a clock to seconds since the first of them.

    Parameters
    ----------
    missing : ndarray of bool
        Rows without a time, whose result is NaN.

    Raises
    ------
    RecordingError
        If a cell is no time of a clock, or it is not certain which part of the dates is the month.
    """
    times = {line: CLOCK.fullmatch(str(cell).strip()) for line, cell in cells[~missing].items()}
    wrong = [line for line, parts in times.items() if parts is None]
    if wrong:
        raise RecordingError(
            listed(
                f"{name}, line {line}: time must be a time such as 10:12:30.5, with or without a "
                f"date, got {str(cells[line])!r}"
                for line in wrong
            )
        )
    parts = [time for time in times.values() if time is not None]
    seconds = np.array([_of_day(*time.group(2, 3, 4, 5)) for time in parts])
    dates = [time[1] or "" for time in parts]
    # Without dates, midnight is where the clock goes back by more than half a day.
    midnights = np.cumsum(np.diff(seconds, prepend=seconds[:1]) < -0.5 * DAY)
    days = _days(dates, name) if all(dates) else midnights
    result = np.full(len(cells), np.nan)
    result[~missing] = (seconds - seconds[:1]) + DAY * (days - days[:1])
    return result


def _of_day(hour: str, minute: str, second: str, half: str | None) -> float:
    """Seconds since midnight."""
    hours = int(hour) % 12 + (12 if half in ("p", "P") else 0) if half else int(hour)
    return 3600.0 * hours + 60.0 * int(minute) + float(second.replace(",", "."))


def _days(dates: list[str], name: str) -> FloatArray:
    """Days since the first date."""
    distinct = list(dict.fromkeys(dates))
    read = {order: _ordinals(distinct, places) for order, places in ORDERS.items()}
    if any("/" not in text for text in distinct):
        del read["month/day"]
    known = [days for days in read.values() if days is not None]
    if not known:
        raise RecordingError(f"{name}: {distinct[0]!r} is no date")
    if any(days != known[0] for days in known):
        raise RecordingError(
            f"{name}: the dates {distinct[0]} to {distinct[-1]} may be day/month or month/day: "
            "write them as 2026-03-12"
        )
    of = dict(zip(distinct, known[0], strict=True))
    return np.array([of[text] for text in dates], dtype=float)


def _ordinals(dates: list[str], places: tuple[int, int, int]) -> list[int] | None:
    """Days since the first date; None if these are no dates in this order of their parts."""
    try:
        days = [_ordinal(text, places) for text in dates]
    except ValueError:
        return None
    return [day - days[0] for day in days]


def _ordinal(text: str, places: tuple[int, int, int]) -> int:
    parts = [int(part) for part in re.split("[-./]", text)]
    if parts[0] > 31:
        return date(*parts).toordinal()
    year, month, day = (parts[place] for place in places)
    return date(year + 2000 if year < 100 else year, month, day).toordinal()
