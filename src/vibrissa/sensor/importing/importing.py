"""Import of a laboratory's file: the recording, and a report of how it was read."""

from contextlib import suppress
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vibrissa.errors import ArgumentError, RecordingError
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.quantities.series import Column, Tabular, listed
from vibrissa.quantities.units import Units, wished_units
from vibrissa.sensor.importing.clock import since_first
from vibrissa.sensor.importing.columns import FileColumn, find_column
from vibrissa.sensor.importing.layout import Layout
from vibrissa.sensor.importing.numbers import is_missing, values_of
from vibrissa.sensor.importing.programs import layout_in
from vibrissa.sensor.importing.settings import INSTEAD, Place, Settings
from vibrissa.sensor.importing.tare import FEWEST_READINGS, Zero, recorded, tare_of
from vibrissa.sensor.importing.titles import KINDS
from vibrissa.sensor.transducer import CHANNELS
from vibrissa.wording import counted

NO_TARE = (
    "no tare: readings without load are taken as 0; if the rod was free for a while, add --tare, "
    "as in --tare '0 s, 2 s'"
)
# Times since 1970 (s) are counted from the first row.
LONG_AGO = 1e8
# Parts by which a stated rate, and the way by a stated speed, may differ from the file's.
RATE_ERROR = 0.01
WAY_ERROR = 0.05
# Number of lines that may be titles in a message.
MOST_TITLES = 3

Values = dict[str, FloatArray]


class Rate(NamedTuple):
    """A rate (Hz), and the part by which it may be wrong."""

    value: float
    error: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Imported(Tabular):
    """A recording from a laboratory's file.

    Attributes
    ----------
    values : dict of str to ndarray
        Columns in SI units; NaN where a value is missing.
    zeros : dict of str to Zero
        Mean readings without load, which were subtracted from the channels.
    notes : tuple of str
        What was found in the file, and how it was converted.
    units : Units
        Units of the printed zeros: those of the file.
    """

    values: Values
    zeros: dict[str, Zero]
    notes: tuple[str, ...]
    units: Units

    def columns(self) -> dict[str, Column]:
        """Columns as `vibrissa identify` reads them."""
        return {
            name: Column(self.values[name], kind.si, name)
            for name, kind in KINDS.items()
            if name in self.values
        }

    def header(self) -> dict[str, str]:
        """Zeros of the channels, as in ``zero_force_x``: ``310.254 ± 0.27 mN``.

        `vibrissa identify` takes the tolerances of the zeros from this header.
        """
        header = {}
        for name, zero in self.zeros.items():
            value, unit = self.units.displayed(zero.value, KINDS[name])
            # If all readings were alike, the error is not known.
            error = self.units.displayed(zero.deviation, KINDS[name])[0]
            more = f" ± {error:.2g}" if error else ""
            header[f"zero_{name}"] = f"{value:.6g}{more} {unit}"
        return header

    def report(self) -> tuple[str, ...]:
        """Lines on how the file was read, and on its zeros."""
        zeros = [
            f"{name} = {text}, mean of {counted(zero.rows, 'row')}, subtracted"
            for (name, text), zero in zip(self.header().items(), self.zeros.values(), strict=True)
        ]
        drifts = [
            f"{name} changes by {self._spelled(zero.change, name)} to the other side of the scan: "
            "a steady change is subtracted; if it jumped, cut the recording there by --from, --to"
            for name, zero in self.zeros.items()
            if zero.change
        ]
        return (*self.notes, *(zeros or [NO_TARE]), *drifts)

    def _spelled(self, value: float, name: str) -> str:
        size, unit = self.units.displayed(value, KINDS[name])
        return f"{size:.3g} {unit}"


def import_recording(data: bytes, settings: Settings, name: str = "the file") -> Imported:
    """Read a laboratory's file.

    Parameters
    ----------
    data : bytes
        Content of the file.
    settings : Settings
    name : str
        Name of the file in messages.

    Returns
    -------
    Imported

    Raises
    ------
    RecordingError
        If the file is no recording, its columns or decimal sign are ambiguous, a setting
        contradicts the file, or the stated tare has too few readings or contains load; the message
        has a line for each error.
    """
    layout = layout_in(data, name, settings)
    columns = _columns(layout, name, settings)
    values = _values(columns, layout, name, settings.rate)
    if settings.turn:
        values = turned(values, settings.turn)
    if any(settings.moment_origin):
        values = about_clamp(values, settings.moment_origin)
    kept = _inside(values, settings.from_, settings.to)
    if not kept.any():
        raise RecordingError(f"{name}: no row is left between --from and --to; {_extent(values)}")
    window = None if settings.tare is None else _inside(values, *settings.tare)
    _check_tare(window, values, name)
    tare = tare_of(values, kept, window, name, lambda rows: _spelled(rows, values))
    values = {
        key: (each - tare.offsets[key] if key in tare.offsets else each)[kept]
        for key, each in values.items()
    }
    notes = [*layout.notes, *(f"{target}: {column.note}" for target, column in columns.items())]
    if settings.speed is not None:
        values["footpoint"] = settings.speed * (values["time"] - values["time"][0])
        notes.append("footpoint: speed times the time since --from")
        _check_speed(values, kept, layout, name)
    missing = {key: int(np.isnan(each).sum()) for key, each in values.items()}
    notes += [f"{key} is missing in {counted(n, 'row')}" for key, n in missing.items() if n]
    if not kept.all():
        notes.append(f"outside --from and --to: {counted(int((~kept).sum()), 'row')}")
    few = ", ".join(channel for channel in recorded(values) if channel not in tare.zeros)
    if few and tare.zeros:
        notes.append(f"no zero for {few}: fewer than {FEWEST_READINGS} readings without load")
    units = Units(
        si=True, wished=wished_units(*(f"1 {column.unit}" for column in columns.values()))
    )
    return Imported(values=values, zeros=tare.zeros, notes=(*notes, *tare.notes), units=units)


def _columns(layout: Layout, name: str, settings: Settings) -> dict[str, FileColumn]:
    """Find the columns of a recording; all errors are reported together."""
    columns: dict[str, FileColumn] = {}
    errors = []
    unknown = False
    for target in [kind for kind in KINDS if kind not in settings.made]:
        source = settings.column.get(target, target)
        try:
            column = find_column(layout, target, source)
        except ArgumentError as error:
            errors.append(str(error))
            continue
        if column is not None:
            columns[target] = column
        elif target in settings.needed:
            unknown = True
            errors.append(
                f"there is no column {source}: choose the column of {target}, as in --column "
                f"'{target}=title [{KINDS[target].si}]'"
                + (f"; if the file has none, give {INSTEAD[target]}" if target in INSTEAD else "")
            )
    if not {*columns, *settings.column} & set(CHANNELS):
        unknown = True
        errors.append(
            f"no column is named {', '.join(CHANNELS)}: choose their columns, as in --column "
            "'force_x=title [N]'"
        )
    if errors:
        if unknown:
            errors.append(_other_titles(layout))
        titles = ", ".join(layout.titles)
        errors.append(
            f"the columns of the table from line {layout.cells.index[0]} on are: {titles}"
        )
        raise RecordingError("\n".join(f"{name}: {error}" for error in errors))
    return columns


def _other_titles(layout: Layout) -> str:
    """Name the ways to choose a column whose title was not found."""
    lines = [
        f"line {line}: {', '.join(cells)}"
        for line, cells in layout.heads.items()
        if list(cells) != list(layout.titles)
    ]
    option = "if the titles are in another line, add its number, as in --title-line 7"
    other = f"{option} ({'; '.join(lines[-MOST_TITLES:])}); " if lines else ""
    return f"{other}#1 is the first column, whatever its title"


def _values(
    columns: dict[str, FileColumn], layout: Layout, name: str, rate: float | None
) -> Values:
    """Read columns in SI units."""
    cells = {target: layout.cells.iloc[:, column.number] for target, column in columns.items()}
    plain = {target: each for target, each in cells.items() if not columns[target].in_parts}
    read = values_of(plain, name, layout.signs)
    values = {target: columns[target].factor * each for target, each in read.items()}
    if rate is not None:
        _check_rate(rate, layout, name)
        return {"time": layout.samples / rate, **values}
    if "time" in columns:
        column = columns["time"]
        time = _time(column, layout, name) if column.in_parts else values["time"]
        _check_time(time, layout, name)
        values = values | {"time": time - time[0] if time[0] > LONG_AGO else time}
    return values


def _time(column: FileColumn, layout: Layout, name: str) -> FloatArray:
    """Read the times of a clock, or seconds and nanoseconds, in seconds since the first."""
    cells = layout.cells.iloc[:, column.number]
    if not column.clock:
        parts = {"seconds": cells, "nanoseconds": layout.cells.iloc[:, column.beside]}
        read = values_of(parts, name, layout.signs)
        # Differences first: seconds since 1970 have no digits left for nanoseconds.
        whole = read["seconds"] - np.fmin.reduce(read["seconds"])
        time = whole + 1e-9 * read["nanoseconds"]
        return np.asarray(column.factor * (time - np.fmin.reduce(time)))
    missing = np.array([is_missing(str(cell).strip()) for cell in cells])
    if column.beside is not None:
        dates = layout.cells.iloc[:, column.beside].astype(str).str.strip()
        cells = dates + " " + cells.astype(str).str.strip()
    return column.factor * since_first(cells, name, missing)


def _check_time(time: FloatArray, layout: Layout, name: str) -> None:
    wrong = {"is missing": np.isnan(time), "does not increase": np.diff(time, prepend=-np.inf) <= 0}
    for what, late in wrong.items():
        if late.any():
            why = f"time {what}; correct the times, or give --rate instead"
            lines = layout.cells.index[late]
            raise RecordingError(listed(f"{name}, line {line}: {why}" for line in lines))


def _check_rate(rate: float, layout: Layout, name: str) -> None:
    """Refuse a rate that contradicts all increasing times of the file."""
    rates = {}
    for number, title in enumerate(layout.titles, 1):
        with suppress(ArgumentError, RecordingError):
            column = find_column(layout, "time", f"#{number}")
            if column is not None:
                rates[title] = _rate_of(column, layout, name)
    known = {title: by_column for title, by_column in rates.items() if by_column is not None}
    agrees = [abs(rate / by_column.value - 1.0) <= by_column.error for by_column in known.values()]
    if known and not any(agrees):
        title, by_column = next(iter(known.items()))
        raise RecordingError(
            f"{name}: --rate is {rate:g} Hz, but by the column {title} it is "
            f"{by_column.value:.4g} Hz: leave out --rate, and choose the column, as in --column "
            f"'time={title}'"
        )


def _rate_of(column: FileColumn, layout: Layout, name: str) -> "Rate | None":
    """Mean rate of the times in a column; None if they do not increase."""
    if column.in_parts:
        time = _time(column, layout, name)
    else:
        cells = {"time": layout.cells.iloc[:, column.number]}
        time = column.factor * values_of(cells, name, layout.signs)["time"]
    steps = np.diff(time)
    if not len(steps) or not (steps >= 0.0).all() or time[-1] == time[0]:
        return None
    way = time[-1] - time[0]
    # A clock may be coarse.
    error = RATE_ERROR + 2.0 * np.median(steps[steps > 0.0]) / way
    samples = layout.samples[-1] - layout.samples[0]
    return Rate(float(samples / way), float(error))


def _check_speed(values: Values, kept: BoolArray, layout: Layout, name: str) -> None:
    """Refuse a speed that contradicts the clamp positions of the file."""
    with suppress(ArgumentError):
        column = find_column(layout, "footpoint", "footpoint")
        if column is None:
            return
        cells = {"footpoint": layout.cells.iloc[:, column.number]}
        clamp = column.factor * values_of(cells, name, layout.signs)["footpoint"][kept]
        ways = [float(np.ptp(each[np.isfinite(each)])) for each in (clamp, values["footpoint"])]
        if abs(ways[1] - ways[0]) > WAY_ERROR * ways[0]:
            raise RecordingError(
                f"{name}: by --speed the clamp moves by {1e3 * ways[1]:.4g} mm from --from to "
                f"--to, but by the column {column.title} by {1e3 * ways[0]:.4g} mm: leave out "
                "--speed"
            )


def _check_tare(window: BoolArray | None, values: Values, name: str) -> None:
    """Refuse a window of a tare that has too few readings of a channel."""
    if window is None:
        return
    few = [
        channel
        for channel in recorded(values)
        if np.isfinite(values[channel][window]).sum() < FEWEST_READINGS
    ]
    if few:
        raise RecordingError(
            f"{name}: the tare has fewer than {FEWEST_READINGS} readings of {', '.join(few)}; "
            f"{_extent(values)}"
        )


def _extent(values: Values) -> str:
    """First and last time and clamp position of the file."""
    rows = np.ones(len(next(iter(values.values()))), dtype=bool)
    every = {"times": "time", "clamp positions": "footpoint"}
    ends = {
        what: _spelled(rows, {column: values[column]}).replace(", ", " to ")
        for what, column in every.items()
        if column in values
    }
    return ", ".join(f"the {what} of the file are {text}" for what, text in ends.items())


def _spelled(rows: BoolArray, values: Values) -> str:
    """First and last time of rows, or else clamp positions, as in ``0 s, 1.4 s``."""
    column, unit, size = ("time", "s", 1.0) if "time" in values else ("footpoint", "mm", 1e-3)
    known = values[column][rows & np.isfinite(values[column])] / size
    return f"{known[0]:.6g} {unit}, {known[-1]:.6g} {unit}" if len(known) else "no row"


def _inside(values: Values, begin: Place | None, end: Place | None) -> BoolArray:
    """Select the samples from the first at one place to the first beyond another."""
    rows = np.ones(len(next(iter(values.values()))), dtype=bool)
    if begin is not None:
        rows &= np.maximum.accumulate(_way_to(begin, values) >= 0.0)
    if end is not None:
        rows &= ~np.maximum.accumulate(rows & (_way_to(end, values) > 0.0))
    return rows


def _way_to(place: Place, values: Values) -> FloatArray:
    """Distance of the samples from a place, positive beyond it in the first motion's direction."""
    column = values[place.column]
    known = column[~np.isnan(column)]
    way = known[np.abs(known - known[0]).argmax()] - known[0] if len(known) else 1.0
    return np.asarray((1.0 if way >= 0.0 else -1.0) * (column - place.value))


def turned(values: Values, angle: float) -> Values:
    """Convert the forces of the file to the axes of the clamp.

    Parameters
    ----------
    angle : float
        Angle by which the file's axes are turned against those of the clamp, positive from x to y
        (rad).
    """
    x, y = values["force_x"], values["force_y"]
    cos, sin = np.cos(angle), np.sin(angle)
    return values | {"force_x": cos * x - sin * y, "force_y": sin * x + cos * y}


def about_clamp(values: Values, origin: tuple[float, float]) -> Values:
    """Convert the moment of the file to the moment about the clamp: m = m(a, b) + a·fy − b·fx.

    Parameters
    ----------
    origin : tuple of float
        Point (a, b) about which the file's moment is taken, measured from the clamp (m).
    """
    a, b = origin
    moment = values["moment_z"] + a * values["force_y"] - b * values["force_x"]
    return values | {"moment_z": moment}
