"""Titles with units as laboratories write them, and which of them are columns of a recording."""

import re
from typing import TYPE_CHECKING, NamedTuple

from vibrissa.errors import ArgumentError
from vibrissa.sensor.quantities import CHANNEL_KINDS, Kind, unit_size
from vibrissa.sensor.transducer import CHANNELS

if TYPE_CHECKING:
    from vibrissa.sensor.importing.layout import Layout

# Columns of a recording and what they measure.
KINDS = {
    "time": Kind.TIME,
    "footpoint": Kind.LENGTH,
    **dict(zip(CHANNELS, CHANNEL_KINDS, strict=True)),
}
# In a row of units: none, or of what a recording does not have.
NO_UNIT = ("", "-", "1", "%", "V", "mV", "°C", "K")
# Fz [mN], Fz (mN), Fz / mN, Fz in mN; Fz_mN and Fz mN if that is a unit of what it must measure.
TITLE = re.compile(
    r"(?P<name>.*?)\s*(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>[^()]*)\)|/\s*(?P<per>\S+)"
    r"|\bin\s+(?P<word>\S+))"
)
ENDING = re.compile(r"(.+)[_ ]([^\s_]+)")
# The column of an option: -Fz [mN].
SOURCE = re.compile(r"(-?)\s*(.*?)\s*(?:\[([^\[\]]*)\])?")


class FileColumn(NamedTuple):
    """A column of a file: its number from 0, title, unit, and the factor to SI units."""

    number: int
    title: str
    unit: str
    factor: float

    @property
    def note(self) -> str:
        """Report of how the column is read."""
        return f"{'minus ' * (self.factor < 0.0)}{self.title} in {self.unit}"


def title_of(text: str, kind: Kind) -> tuple[str, str]:
    """Split a title into the name of a column and its unit, which is empty if there is none.

    Examples
    --------
    >>> title_of("Fx_mN", Kind.FORCE)
    ('Fx', 'mN')
    """
    if parts := TITLE.fullmatch(text):
        unit = parts["square"] or parts["round"] or parts["per"] or parts["word"] or ""
        return parts["name"], unit.strip()
    parts = ENDING.fullmatch(text)
    return (parts[1], parts[2]) if parts and unit_size(parts[2], kind) else (text, "")


def is_unit(cell: str) -> bool:
    """Whether a cell is a unit of a channel, or a mark for "no unit"."""
    unit = cell.strip("[]() ")
    return unit in NO_UNIT or any(unit_size(unit, kind) for kind in KINDS.values())


def column_of(layout: "Layout", target: str, source: str) -> FileColumn | None:
    """Find the column of a channel in a file, and its unit; None if there is none.

    Parameters
    ----------
    source : str
        What it is called: ``force_x``, ``-Fz [mN]``, or ``#3`` for the third one.

    Raises
    ------
    ArgumentError
        If several columns are called so, or its unit is missing or measures something else.
    """
    kind = KINDS[target]
    sign, name, told = SOURCE.fullmatch(source.strip()).groups(default="")  # type: ignore[union-attr]
    found = [number for number, title in enumerate(layout.titles) if title == source]
    found = found or [
        number
        for number, title in enumerate(layout.titles)
        if name.casefold() in (title.casefold(), title_of(title, kind)[0].casefold())
    ]
    if re.fullmatch("#[0-9]+", name):
        found = [number for number in range(layout.cells.shape[1]) if name == f"#{number + 1}"]
    if len(found) > 1:
        raise ArgumentError(f"several columns are called {name}: give its number, as in #1")
    if not found:
        return None
    title = layout.titles[found[0]] if layout.titles else name
    below = layout.units[found[0]].strip("[]() ") if layout.units else ""
    unit = told.strip() or title_of(title, kind)[1] or below
    if not unit:
        raise ArgumentError(
            f'column {title} has no unit: add it, as in --column "{target}={name} [{kind.si}]"'
        )
    size = float(unit_size(unit, kind))
    if not size:
        raise ArgumentError(
            f"column {title} must have a unit of {kind}, such as {kind.si}, got {unit!r}"
        )
    return FileColumn(found[0], title, unit, -size if sign else size)
