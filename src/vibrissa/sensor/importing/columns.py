"""Which columns of a file are those of a recording, with their units and signs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from vibrissa.errors import RecordingError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.importing.layout import Layout
from vibrissa.sensor.importing.notation import Notation, numbers_of
from vibrissa.sensor.importing.settings import NAMES, Source
from vibrissa.sensor.importing.units import Title, size_of, title_of, unit_size, usual
from vibrissa.sensor.quantities import CHANNEL_KINDS, MEASURED, SI, Kind, Units, wished_units
from vibrissa.sensor.transducer import CHANNELS

KINDS = dict(zip(NAMES, (Kind.TIME, Kind.LENGTH, *CHANNEL_KINDS), strict=True))


@dataclass(frozen=True, eq=False, kw_only=True)
class Columns:
    """Columns of a recording, as they stand in a file.

    Attributes
    ----------
    values : dict of str to ndarray
        In SI units; NaN where a value is missing.
    notation : Notation
        Of the numbers.
    said : tuple of str
        What was taken for what.
    units : Units
        In which messages tell values: those of the file.
    """

    values: dict[str, FloatArray]
    notation: Notation
    said: tuple[str, ...]
    units: Units


@dataclass(frozen=True, kw_only=True)
class _Column:
    """A column of the file: its number from 0, title, unit as told, and as the file tells it."""

    number: int
    title: str
    unit: str
    unit_in_file: str
    sign: float


def columns_of(
    layout: Layout,
    name: str,
    sources: Mapping[str, Source],
    decimal: str | None = None,
    without: Sequence[str] = (),
) -> Columns:
    """Read the columns of a recording from a table of text.

    Parameters
    ----------
    layout : Layout
    name : str
        Of the file, for messages.
    sources : mapping of str to Source
        Where the file's titles are others.
    decimal : str, optional
        The decimal sign; found by default.
    without : sequence of str
        Columns of the recording that are made in another way.

    Returns
    -------
    Columns

    Raises
    ------
    RecordingError
        If a column is missing, there are several, or a cell is no number.
    ArgumentError
        If a unit is missing or wrong.
    """
    found = _found(layout, name, sources, without)
    if not set(found) & set(CHANNELS):
        raise RecordingError(
            f"{name}: none of {', '.join(CHANNELS)} is there: say which column is which, as in "
            f'--column "force_x=Fz [mN]". {_there(layout)}'
        )
    cells = {one.title: [row[one.number] for row in layout.rows] for one in found.values()}
    place = [f"{name}, line {line}" for line in layout.line]
    numbers = numbers_of(cells, place, decimal)
    values, said, units = {}, [], []
    for target, one in found.items():
        unit = one.unit or one.unit_in_file
        what = f"{name}: column {one.title}"
        if not unit:
            raise RecordingError(
                f"{what} has no unit: give it, as in "
                f'--column "{target}={one.title} [{SI[KINDS[target]]}]"'
            )
        size = one.sign * unit_size(unit, KINDS[target], what)
        values[target] = numbers.columns[one.title] * size
        said.append(_said(target, one))
        units.append(f"1 {usual(unit)}")
    return Columns(
        values=values,
        notation=numbers.notation,
        said=tuple(said),
        units=Units(si=True, wished=wished_units(MEASURED, *units)),
    )


def _said(target: str, one: _Column) -> str:
    unit = one.unit or one.unit_in_file
    other = f", although the file says {one.unit_in_file}"
    sign = "minus " if one.sign < 0.0 else ""
    return f"{target}: {sign}{one.title} in {unit}" + other * (
        bool(one.unit and one.unit_in_file) and one.unit != one.unit_in_file
    )


def _found(
    layout: Layout, name: str, sources: Mapping[str, Source], without: Sequence[str]
) -> dict[str, _Column]:
    titles = [title_of(title) for title in layout.titles]
    found = {}
    for target in NAMES:
        if target in without:
            continue
        source = sources.get(target, Source(target, target, "", 1.0))
        numbers = _numbers(layout, titles, source)
        if len(numbers) > 1:
            raise RecordingError(f"{name}: several columns are called {source.name}: say #number")
        if not numbers:
            if target in sources:
                raise RecordingError(f"{name}: there is no column {source.title}. {_there(layout)}")
            continue
        number, sign = numbers[0]
        found[target] = _Column(
            number=number,
            title=layout.titles[number] if titles else f"#{number + 1}",
            unit=source.unit,
            unit_in_file=_unit_in_file(layout, name, target, number, told=bool(source.unit)),
            sign=sign,
        )
    return found


def _unit_in_file(layout: Layout, name: str, target: str, number: int, *, told: bool) -> str:
    """Find the unit of a column, by its title or the line of units; empty if neither has one.

    Raises
    ------
    RecordingError
        If they differ and the unit was not told.
    """
    title = layout.titles[number] if number < len(layout.titles) else ""
    unit = layout.units[number].strip("[]() ") if layout.units else ""
    units = [each for each in (title_of(title).unit, unit) if each]
    good = [each for each in units if size_of(each, KINDS[target]) is not None]
    if len({size_of(each, KINDS[target]) for each in good}) > 1 and not told:
        raise RecordingError(
            f"{name}: column {title} is in {units[0]} by its title, but in {units[1]} by line "
            f'{layout.unit_line}: give the unit, as in --column "{target}={title_of(title).name} '
            f'[{units[1]}]"'
        )
    return next(iter([*good, *units]), "")


def _numbers(layout: Layout, titles: Sequence[Title], source: Source) -> list[tuple[int, float]]:
    """Columns that a source may be, each with the sign: as a whole title, as a name, by number."""
    whole = [(i, 1.0) for i, title in enumerate(layout.titles) if title == source.title]
    if whole:
        return whole
    number = source.name.removeprefix("#")
    if source.name.startswith("#") and number.isdecimal():
        width = len(layout.rows[0])
        return [(int(number) - 1, source.sign)] if 0 < int(number) <= width else []
    same = [i for i, title in enumerate(titles) if title.name == source.name]
    alike = [i for i, t in enumerate(titles) if t.name.casefold() == source.name.casefold()]
    return [(i, source.sign) for i in same or alike]


def _there(layout: Layout) -> str:
    if layout.titles:
        return (
            f"There are in line {layout.title_line}: {', '.join(layout.titles)} (--titles names "
            "another line)"
        )
    return f"There are no titles, and columns #1 to #{len(layout.rows[0])}"
