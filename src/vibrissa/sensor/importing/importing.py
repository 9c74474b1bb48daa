"""Import of a laboratory's file: settings, the recording, and a report of how it was read."""

from contextlib import suppress
from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from pydantic import BeforeValidator, Field, ValidationInfo, model_validator

from vibrissa.errors import ArgumentError, RecordingError
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.quantities.keys import Keyed, Positive
from vibrissa.quantities.series import Column, Tabular, listed, numbers
from vibrissa.quantities.units import Kind, Units, wished_units
from vibrissa.sensor.identification.ends import FEWEST, moving, touching
from vibrissa.sensor.identification.recording import noise_of
from vibrissa.sensor.importing.layout import KINDS, FileColumn, Layout, decoded, layout_of
from vibrissa.sensor.transducer import CHANNELS
from vibrissa.wording import counted

# Options that replace a column missing in the file.
INSTEAD = {"time": "--rate '50 Hz'", "footpoint": "--speed, --from and --to"}
NO_TARE = (
    "no tare: readings without load are taken as 0; if the rod was free for a while, add --tare, "
    "as in --tare '0 s, 2 s'"
)
# Errors of successive readings may be correlated (filter, hum). With enough readings, the error of
# their mean is therefore estimated from the means of this number of blocks.
BLOCKS, FEWEST_IN_BLOCKS = 20, 100
# Least number of readings for a zero and its error.
FEWEST_READINGS = 3
# A change of a reading by this many standard deviations is a load: noise exceeds it once in 10^6.
CHANGED = 5.0
# Least change at the first touch, as a part of the usual load in motion; part of the rows before
# this change whose mean is the zero.
LOADED, TAKEN = 0.3, 0.8

Values = dict[str, FloatArray]


class Place(NamedTuple):
    """A place in a recording: a time (s) or a clamp position (m)."""

    column: str
    value: float


def _place(text: Any, info: ValidationInfo) -> Place:
    for column in ("time", "footpoint"):
        with suppress(ArgumentError):
            return Place(column, KINDS[column].read(str(text), column))
    name = str(info.field_name).strip("_")
    raise ArgumentError(f"{name!r} must be a time or a clamp position with its unit, got {text!r}")


def _two(text: Any, info: ValidationInfo, example: str = "0 s, 2 s") -> list[str]:
    parts = str(text).split(",")
    if len(parts) != 2:
        name = info.field_name
        raise ArgumentError(f"{name} must be two values, as in {example!r}, got {text!r}")
    return parts


def _lengths(text: Any, info: ValidationInfo) -> list[float]:
    parts = _two(text, info, "0 mm, -20 mm")
    return [Kind.LENGTH.read(part, str(info.field_name)) for part in parts]


At = Annotated[Place, BeforeValidator(_place)]


class Settings(Keyed):
    """Settings of an import; those that are None are found in the file, or not used.

    Examples
    --------
    >>> Settings.read(column={"force_x": "-Fx [mN]"}, tare="0 s, 2 s").tare
    (Place(column='time', value=0.0), Place(column='time', value=2.0))
    """

    column: dict[str, str] = Field(default_factory=dict)
    """Column of the file for a channel, with its unit if the file has none: 'force_x=Fx [mN]';
    'force_y=-Fy' turns its sign, 'time=#1' is the first column. Repeat for each channel. Columns
    named time, footpoint, force_x, force_y and moment_z need no option."""
    turn: Annotated[float, Kind.ANGLE] = 0.0
    """Angle by which the file's axes are turned from x to y: '90 deg'."""
    moment_origin: Annotated[tuple[float, float], BeforeValidator(_lengths)] = (0.0, 0.0)
    """Point to which the file's moment refers, from the clamp: '1 mm, 0 mm'."""
    tare: Annotated[tuple[At, At] | None, BeforeValidator(_two)] = None
    """Window without load, whose mean is the zero: '0 s, 2 s'. By default the rows before the rod
    touches the surface, if the clamp rests then."""
    speed: Annotated[Positive | None, Kind.SPEED] = None
    """Speed of the stage, if its position is missing: '0.1 mm/s'."""
    rate: Annotated[Positive | None, Kind.RATE] = None
    """Samples per second, if the time is missing: '50 Hz'."""
    from_: At | None = Field(None, alias="from")
    """First sample to take, by time or clamp position: '2 s'. With --speed: the time at which the
    stage begins to move."""
    to: At | None = None
    """Last sample to take: '40 s'. With --speed: the time at which the stage stops."""
    decimal: Literal[".", ","] | None = None
    """Decimal sign, '.' or ','. Found by default."""

    @property
    def made(self) -> set[str]:
        """Columns that are computed from `rate` or `speed`, not taken from the file."""
        replaced = {"time": self.rate, "footpoint": self.speed}
        return {name for name, given in replaced.items() if given is not None}

    @property
    def needed(self) -> set[str]:
        """Columns that must be in the file."""
        places = [*(self.tare or ()), self.from_, self.to]
        needed = {"footpoint", *self.column, *(place.column for place in places if place)}
        if self.turn:
            needed |= {"force_x", "force_y"}
        if any(self.moment_origin):
            needed |= set(CHANNELS)
        return needed - self.made

    @model_validator(mode="after")
    def _check_together(self) -> Self:
        if unknown := self.column.keys() - KINDS.keys():
            raise ArgumentError(f"column must be one of {', '.join(KINDS)}, got {unknown.pop()!r}")
        places = [self.from_, self.to, *(self.tare or ())]
        if self.speed is not None and any(not one or one.column != "time" for one in places):
            raise ArgumentError(
                "with speed, give the times at which the stage begins to move and stops, as in "
                "--from '2 s' --to '40 s'; if you give --tare, it must be times, too"
            )
        for name in self.made & self.column.keys():
            raise ArgumentError(f"give a column of {name} or {INSTEAD[name]}, not both")
        return self


class Zero(NamedTuple):
    """Mean reading of a channel without load, standard error of the mean, number of readings."""

    value: float
    deviation: float
    rows: int


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
            value, unit = self.units.told(zero.value, KINDS[name])
            # If all readings were alike, the error is not known.
            error = self.units.told(zero.deviation, KINDS[name])[0]
            more = f" ± {error:.2g}" if error else ""
            header[f"zero_{name}"] = f"{value:.6g}{more} {unit}"
        return header

    def report(self) -> tuple[str, ...]:
        """Lines on how the file was read, and on its zeros."""
        zeros = [
            f"{name} = {text}, mean of {counted(zero.rows, 'row')}, subtracted"
            for (name, text), zero in zip(self.header().items(), self.zeros.values(), strict=True)
        ]
        return (*self.notes, *(zeros or [NO_TARE]))


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
        If the file is no recording, its columns or decimal sign are ambiguous, or the stated tare
        has too few readings; the message has a line for each error.
    """
    text = decoded(data, name)
    layout = layout_of(text, name, settings.decimal)
    found = _columns(layout, name, settings)
    values = _values(found, layout, name, settings.rate)
    if settings.turn:
        values = turned(values, settings.turn)
    if any(settings.moment_origin):
        values = about_clamp(values, settings.moment_origin)
    kept = _inside(values, settings.from_, settings.to)
    if not kept.any():
        raise RecordingError(f"{name}: no row is left between --from and --to")
    zeros = _zeros(values, settings, kept)
    values = {
        key: (each - zeros[key].value if key in zeros else each)[kept]
        for key, each in values.items()
    }
    few = ", ".join(one for one in _recorded(values) if one not in zeros)
    if few and settings.tare is not None:
        raise RecordingError(f"{name}: the tare has fewer than {FEWEST_READINGS} readings of {few}")
    notes = [*layout.notes, *(f"{target}: {one.note}" for target, one in found.items())]
    if settings.speed is not None:
        values["footpoint"] = settings.speed * (values["time"] - values["time"][0])
        notes.append("footpoint: speed times the time since --from")
    missing = {key: int(np.isnan(each).sum()) for key, each in values.items()}
    notes += [f"{key} is missing in {counted(n, 'row')}" for key, n in missing.items() if n]
    if not kept.all():
        notes.append(f"outside --from and --to: {counted(int((~kept).sum()), 'row')}")
    if few and zeros:
        notes.append(f"no zero for {few}: fewer than {FEWEST_READINGS} readings without load")
    units = Units(si=True, wished=wished_units(*(f"1 {one.unit}" for one in found.values())))
    return Imported(values=values, zeros=zeros, notes=tuple(notes), units=units)


def _columns(layout: Layout, name: str, settings: Settings) -> dict[str, FileColumn]:
    """Find the columns of a recording; all errors are reported together."""
    found, errors = {}, []
    for target in [one for one in KINDS if one not in settings.made]:
        source = settings.column.get(target, target)
        try:
            one = layout.column(target, source)
        except ArgumentError as error:
            errors.append(str(error))
            continue
        if one is not None:
            found[target] = one
        elif target in settings.needed:
            errors.append(
                f"there is no column {source}: choose the column of {target}, as in --column "
                f"'{target}=title [{KINDS[target].si}]'"
                + (f"; if the file has none, give {INSTEAD[target]}" if target in INSTEAD else "")
            )
    if not {*found, *settings.column} & set(CHANNELS):
        errors.append(
            f"no column is named {', '.join(CHANNELS)}: choose their columns, as in --column "
            "'force_x=title [N]'"
        )
    if errors:
        begin, titles = layout.cells.index[0], ", ".join(layout.titles)
        errors.append(f"the columns of the table from line {begin} on are: {titles}")
        raise RecordingError("\n".join(f"{name}: {error}" for error in errors))
    return found


def _values(found: dict[str, FileColumn], layout: Layout, name: str, rate: float | None) -> Values:
    """Read columns in SI units."""
    cells = {target: layout.cells[one.number] for target, one in found.items()}
    read = numbers(cells, name, layout.decimal)
    values = {target: found[target].factor * each for target, each in read.items()}
    if rate is not None:
        return {"time": layout.samples / rate, **values}
    time = values.get("time", np.empty(0))
    wrong = {"is missing": np.isnan(time), "does not increase": np.diff(time, prepend=-np.inf) <= 0}
    for what, late in wrong.items():
        if late.any():
            why = f"time {what}; correct the times, or give --rate instead"
            lines = layout.cells.index[late]
            raise RecordingError(listed(f"{name}, line {line}: {why}" for line in lines))
    return values


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


def _zeros(values: Values, settings: Settings, kept: BoolArray) -> dict[str, Zero]:
    """Find the zeros in the given window, or in rows that are certainly without load."""
    if settings.tare is not None:
        return zeros_of(values, _inside(values, *settings.tare))
    free = unloaded(values, len(kept) if settings.from_ is None else int(np.argmax(kept)))
    return zeros_of(values, np.arange(len(kept)) < free) if free >= FEWEST else {}


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


def zeros_of(values: Values, rows: BoolArray) -> dict[str, Zero]:
    """Find the mean reading of each channel in rows without load, and the error of this mean.

    A channel that has too few readings in these rows is left out.
    """
    found = {}
    for name in _recorded(values):
        readings = values[name][rows]
        readings = readings[~np.isnan(readings)]
        if len(readings) >= FEWEST_READINGS:
            blocks = BLOCKS if len(readings) >= FEWEST_IN_BLOCKS else len(readings)
            means = np.array([part.mean() for part in np.array_split(readings, blocks)])
            error = means.std(ddof=1) / np.sqrt(blocks) if np.ptp(readings) else 0.0
            found[name] = Zero(float(readings.mean()), float(error), len(readings))
    return found


def _recorded(values: Values) -> list[str]:
    """List the channels that have a reading in some row."""
    return [name for name in CHANNELS if np.isfinite(values.get(name, np.nan)).any()]


def unloaded(values: Values, begin: int) -> int:
    """Count the rows at the beginning that are certainly without load; 0 if none is certain.

    Parameters
    ----------
    begin : int
        First row that was asked for, which is before the clamp moves unless footpoint was recorded;
        without such a row the number of rows.
    """
    channel = next((name for name in ("force_y", "moment_z") if name in values), None)
    if channel is None:
        return 0
    clamp = values.get("footpoint", np.zeros(len(values[channel])))
    rows = np.flatnonzero(np.isfinite(values[channel] + clamp))
    readings, begin = values[channel][rows], int(np.searchsorted(rows, begin))
    if "footpoint" in values:
        begin = min(begin, moving(clamp[rows]).start)
    if not FEWEST < begin < len(readings) - FEWEST:
        return 0
    load = readings - np.median(readings[:FEWEST])
    moved = load[begin:]
    moved = moved[touching(moved[:, None])]
    usual = np.median(moved)
    changed = int(np.argmax(np.abs(load) > CHANGED * noise_of(readings[:, None])))
    if usual == 0.0 or not changed < begin:
        return 0
    # A rod that touches the surface from the beginning only relaxes: its load changes less.
    lowered = np.median(load[changed:begin]) / usual > LOADED
    pressed = np.quantile(moved / usual, 0.05) > LOADED
    return int(rows[int(TAKEN * changed)]) if lowered and pressed else 0
