"""A laboratory's file as a recording, and what was taken from it."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vibrissa.errors import ArgumentError, RecordingError
from vibrissa.numerics.arrays import FloatArray, IntArray
from vibrissa.sensor.identification.ends import moving, touching
from vibrissa.sensor.importing.columns import KINDS, columns_of
from vibrissa.sensor.importing.decoding import decoded
from vibrissa.sensor.importing.layout import Layout, layout_of
from vibrissa.sensor.importing.onset import Motion, moving_by_readings
from vibrissa.sensor.importing.preparing import (
    Values,
    Zero,
    about_clamp,
    inside,
    turned,
    with_time,
    zeros_of,
)
from vibrissa.sensor.importing.settings import NAMES, Settings, Window
from vibrissa.sensor.quantities import SI, Units
from vibrissa.sensor.series import Column, Tabular
from vibrissa.sensor.transducer import CHANNELS
from vibrissa.wording import counted

WORDS = {
    "time": "time",
    "footpoint": "position of the clamp",
    "force_x": "clamp force along the surface",
    "force_y": "clamp force normal to the surface",
    "moment_z": "clamp moment",
}
# What a stage without a recorded position is taken to do.
STEADY = "the clamp position is the speed times the time since the first sample that is kept"

UNTARED = "no tare: readings without load are taken as 0"


@dataclass(frozen=True, eq=False, kw_only=True)
class Imported(Tabular):
    """A recording from a laboratory's file.

    Attributes
    ----------
    values : dict of str to ndarray
        In SI units; NaN where a value is missing.
    zeros : dict of str to Zero
        What was taken off the channels.
    said : tuple of str
        What was found in the file and taken from it.
    units : Units
        In which messages tell values: those of the file.
    """

    values: Values
    zeros: dict[str, Zero]
    said: tuple[str, ...]
    units: Units

    def columns(self) -> dict[str, Column]:
        """Columns as `vibrissa identify` reads them."""
        return {
            name: Column(self.values[name], SI[KINDS[name]], WORDS[name])
            for name in NAMES
            if name in self.values
        }


def import_recording(source: Path | bytes, settings: Settings) -> Imported:
    """Read a laboratory's file.

    Parameters
    ----------
    source : Path or bytes
        The file, or what is in it.
    settings : Settings

    Returns
    -------
    Imported

    Raises
    ------
    RecordingError
        If it cannot be read as a recording, or in more than one way; the message names the line.
    ArgumentError
        If a setting does not fit the file or another setting.
    """
    name = "the input" if isinstance(source, bytes) else str(source)
    _check(settings)
    data = source if isinstance(source, bytes) else _bytes_of(source)
    text = decoded(data, name, settings.encoding)
    layout = layout_of(text.text, name, settings.separator, settings.titles)
    made = [target for target, given in _made(settings).items() if given is not None]
    columns = columns_of(layout, name, settings.columns, settings.decimal, made)
    place = [f"{name}, line {line}" for line in layout.line]
    values = with_time(columns.values, settings.rate, place)
    values = about_clamp(turned(values, settings.turn), settings.moment_origin)
    zeros = zeros_of(values, settings.tare)
    values = {
        key: each - zeros[key].value if key in zeros else each for key, each in values.items()
    }
    scan = _scan(values, settings, name)
    kept, why = _kept(values, scan.rows, settings, name)
    values = _with_clamp({key: each[kept] for key, each in values.items()}, settings, name)
    found = f"{text.encoding}, separator {layout.separator}, {columns.notation.spelled}"
    return Imported(
        values={key: values[key] for key in NAMES if key in values},
        zeros=zeros,
        units=columns.units,
        said=(
            f"read as {found}, {_where(layout)}",
            *columns.said,
            *([STEADY] if settings.speed is not None else []),
            *_begin(scan, settings, layout.line),
            *(_spelled(key, zero, columns.units) for key, zero in zeros.items()),
            *([] if zeros else [UNTARED]),
            *_left_out(layout.line[kept], layout, why),
            *_missing(values),
        ),
    )


def _made(settings: Settings) -> dict[str, float | None]:
    """Columns that are made from something else."""
    return {"time": settings.rate, "footpoint": settings.speed}


def _check(settings: Settings) -> None:
    for (name, given), other in zip(_made(settings).items(), ("rate", "speed"), strict=True):
        if given is not None and name in settings.columns:
            raise ArgumentError(f"give the {other} or the column {name}, not both")


def _bytes_of(path: Path) -> bytes:
    if not path.is_file():
        raise RecordingError(f"{path}: there is no such file")
    return path.read_bytes()


def _where(layout: Layout) -> str:
    head = f"titles in line {layout.title_line}" if layout.titles else "no titles"
    units = f", units in line {layout.unit_line}" if layout.units else ""
    return f"{head}{units}, {counted(len(layout.rows), 'row')} from line {layout.line[0]} on"


def _begin(scan: Motion, settings: Settings, lines: IntArray) -> list[str]:
    """Say where the stage begins to move, if the readings have told it."""
    if settings.begin is not None or scan.spread == 0:
        return []
    return [
        f"by the readings the stage begins to move in line {lines[scan.rows.start]}, or up to "
        f"{counted(scan.spread, 'line')} before: if you know when, give --from"
    ]


def _kept(values: Values, found: slice, settings: Settings, name: str) -> tuple[slice, str]:
    """Find which rows are kept, of a scan, and say why the others are not."""
    begin, end = settings.begin, settings.end
    first = found.start if begin is None else _row(values, begin, "from")
    stop = found.stop if end is None else _row(values, end, "to", last=True)
    if first >= stop:
        raise RecordingError(f"{name}: no row is left between from and to")
    given = begin is not None, end is not None
    return slice(first, stop), {
        (True, True): "as given",
        (False, False): "the clamp rests, or no force acts",
    }.get(given, "as given, or the clamp rests, or no force acts")


def _row(values: Values, window: Window, what: str, last: bool = False) -> int:
    """Find the first row from a time or position on, or the one after the last up to it."""
    inside(values, window, what)
    where = values[window.column]
    if last:
        rows = np.flatnonzero(where <= window.high)
        return int(rows[-1]) + 1 if len(rows) else 0
    rows = np.flatnonzero(where >= window.low)
    return int(rows[0]) if len(rows) else len(where)


def _scan(values: Values, settings: Settings, name: str) -> Motion:
    """Find the rows in which the clamp moves and the rod touches the surface."""
    size = len(next(iter(values.values())))
    there = ~np.isnan(np.stack(list(values.values()))).any(axis=0)
    rows = np.flatnonzero(there)
    both = settings.begin is not None and settings.end is not None
    if both or len(rows) == 0:
        return Motion(slice(0, size), 0)
    rows = rows[touching(_readings(values)[rows])]
    if settings.speed is None and "footpoint" in values:
        kept = Motion(moving(values["footpoint"][rows]), 0)
    else:
        kept = moving_by_readings(_readings(values)[rows], name)
    rows = rows[kept.rows]
    # Rows that miss a value stay at an end where nothing was cut.
    begin = 0 if rows[0] == np.flatnonzero(there)[0] else int(rows[0])
    end = size if rows[-1] == np.flatnonzero(there)[-1] else int(rows[-1]) + 1
    return Motion(slice(begin, end), kept.spread)


def _readings(values: Values) -> FloatArray:
    return np.stack([values[channel] for channel in CHANNELS if channel in values], axis=1)


def _with_clamp(values: Values, settings: Settings, name: str) -> Values:
    """Give each sample its clamp position, by the speed or as recorded."""
    if settings.speed is None:
        if "footpoint" not in values:
            raise RecordingError(
                f"{name}: the clamp position is missing: say which column it is, "
                "--column 'footpoint=...', or give --speed '1 mm/s'"
            )
        return values
    if "time" not in values:
        raise ArgumentError("speed needs the column time, or the rate")
    return values | {"footpoint": settings.speed * (values["time"] - values["time"][0])}


def _spelled(name: str, zero: Zero, units: Units) -> str:
    value, _ = units.told(zero.value, KINDS[name])
    deviation = units.spelled(zero.deviation, KINDS[name], 2)
    return (
        f"zero of {name}: {value:.6g} ± {deviation} by {counted(zero.samples, 'sample')}, taken off"
    )


def _left_out(kept: IntArray, layout: Layout, why: str) -> list[str]:
    """Say which lines are left out at the ends."""
    parts = []
    if kept[0] > layout.line[0]:
        parts.append(f"lines {layout.line[0]} to {kept[0] - 1}")
    if kept[-1] < layout.line[-1]:
        parts.append(f"lines {kept[-1] + 1} to {layout.line[-1]}")
    said = [f"left out, {why}: {' and '.join(parts)}"] if parts else []
    for reason, lines in layout.left_out.items():
        some = ", ".join(map(str, lines[:5])) + ", ..." * (len(lines) > 5)
        said.append(f"left out, {reason}: line {some}")
    return said


def _missing(values: Values) -> list[str]:
    counts = {name: int(np.isnan(each).sum()) for name, each in values.items()}
    return [f"{name} is missing in {counted(n, 'row')}" for name, n in counts.items() if n]
