"""Titles with units as laboratories write them, and which of them are columns of a recording."""

import re
from collections.abc import Mapping, Sequence
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
# Titles of the time, if no column is called so.
TIMES = ("t", "zeit", "timestamp", "elapsed time", "x_value")
# In a row of units: none, or of what a recording does not have.
NO_UNIT = ("", "-", "1", "%", "V", "mV", "°C", "K")
# Fz [mN], Fz (mN), Fz / mN, Fz in mN; Fz_mN and Fz mN if that is a unit of what it must measure.
TITLE = re.compile(
    r"(?P<name>.*?)\s*(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>[^()]*)\)|/\s*(?P<per>\S+)"
    r"|\bin\s+(?P<word>\S+))"
)
ENDING = re.compile(r"(?P<name>.+)[_ ](?P<unit>[^\s_]+)")
SOURCE = re.compile(r"(?P<sign>-?)\s*(?P<name>.*?)\s*(?:\[(?P<unit>[^\[\]]*)\])?")


class Title(NamedTuple):
    """Name of a column and its unit; empty if there is none."""

    name: str
    unit: str


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


def title_of(text: str, kind: Kind) -> Title:
    """Take a title apart.

    Examples
    --------
    >>> title_of("Fx_mN", Kind.FORCE)
    Title(name='Fx', unit='mN')
    """
    if parts := TITLE.fullmatch(text):
        unit = parts["square"] or parts["round"] or parts["per"] or parts["word"] or ""
        return Title(parts["name"], unit.strip())
    parts = ENDING.fullmatch(text)
    if parts and size_of(parts["unit"], kind):
        return Title(parts["name"], parts["unit"])
    return Title(text, "")


def size_of(unit: str, kind: Kind) -> float:
    """Size of a unit in SI units; 0 if it is not a unit of this kind."""
    return float(unit_size(unit, kind))


def is_unit(cell: str) -> bool:
    """Whether a cell is a unit of a channel, or a mark for "no unit"."""
    unit = cell.strip("[]() ")
    return unit in NO_UNIT or any(size_of(unit, kind) for kind in set(KINDS.values()))


def columns_of(
    layout: "Layout", width: int, targets: Sequence[str], sources: Mapping[str, str]
) -> tuple[dict[str, FileColumn], list[str]]:
    """Find the column of each channel in a file.

    Parameters
    ----------
    sources : mapping of str to str
        Columns by these names: ``-Fz [mN]``, or ``#3`` for the third one. Others are those of the
        file that have such a name.
    """
    columns, errors = {}, []
    for target in targets:
        source = sources.get(target, target)
        try:
            number = _number(layout.titles, width, source, KINDS[target])
            if number is None and target == "time" and target not in sources:
                named = [title_of(title, Kind.TIME).name.lower() for title in layout.titles]
                number = next((n for n, name in enumerate(named) if name in TIMES), None)
            if number is not None:
                columns[target] = _column(layout, number, target, source)
            elif target in sources:
                errors.append(f"there is no column {source}")
        except ArgumentError as error:
            errors.append(str(error))
    return columns, errors


def _number(titles: Sequence[str], width: int, source: str, kind: Kind) -> int | None:
    """Find the number of the column that an option names: by title, name, or number."""
    name = _parts(source)[1].name
    if re.fullmatch("#[0-9]+", name):
        return int(name[1:]) - 1 if 0 < int(name[1:]) <= width else None
    names = [title_of(title, kind).name for title in titles]
    folded = [each.casefold() for each in names]
    for there, wanted in (
        (titles, source),
        (titles, name),
        (names, name),
        (folded, name.casefold()),
    ):
        found = [number for number, each in enumerate(there) if each == wanted]
        if len(found) > 1:
            raise ArgumentError(f"several columns are called {name}: give its number, as in #1")
        if found:
            return found[0]
    return None


def _parts(source: str) -> tuple[float, Title]:
    """Sign, name and unit of an option --column such as ``-Fz [mN]``."""
    sign, name, unit = SOURCE.fullmatch(source.strip()).groups(default="")  # type: ignore[union-attr]
    return -1.0 if sign else 1.0, Title(name, unit.strip())


def _column(layout: "Layout", number: int, target: str, source: str) -> FileColumn:
    """Read the unit of a column: from the option, its title, or the row of units."""
    kind, (sign, told) = KINDS[target], _parts(source)
    title = layout.titles[number] if layout.titles else f"#{number + 1}"
    name, unit = title_of(title, kind)
    below = layout.units[number].strip("[]() ") if layout.units else ""
    if not told.unit and unit and below and size_of(unit, kind) != size_of(below, kind):
        raise ArgumentError(
            f"column {title} has another unit in the row of units, {below}: add the right one, as "
            f'in --column "{target}={name} [{below}]"'
        )
    unit = told.unit or unit or below
    if not unit:
        raise ArgumentError(
            f'column {title} has no unit: add it, as in --column "{target}={name} [{kind.si}]"'
        )
    size = size_of(unit, kind)
    if not size:
        raise ArgumentError(
            f"column {title} must have a unit of {kind}, such as {kind.si}, got {unit!r}"
        )
    whole = layout.titles and source in layout.titles  # its sign is a part of the title
    return FileColumn(number, title, unit, size if whole else sign * size)
