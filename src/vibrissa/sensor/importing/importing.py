"""Import of a laboratory's file: the recording, and a report of how it was read."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vibrissa.errors import RecordingError
from vibrissa.numerics.arrays import BoolArray, IntArray
from vibrissa.sensor.identification.ends import FEWEST
from vibrissa.sensor.importing.layout import Layout, decoded, layout_of
from vibrissa.sensor.importing.preparing import (
    Values,
    Zero,
    about_clamp,
    turned,
    unloaded,
    zeros_of,
)
from vibrissa.sensor.importing.settings import Place, Settings
from vibrissa.sensor.importing.titles import KINDS, FileColumn, columns_of
from vibrissa.sensor.quantities import Units, wished_units
from vibrissa.sensor.series import Column, Tabular, check_file, listed, numbers, split
from vibrissa.sensor.transducer import CHANNELS
from vibrissa.wording import counted

DESCRIPTIONS = {
    "time": "time",
    "footpoint": "position of the clamp",
    "force_x": "clamp force along the surface",
    "force_y": "clamp force normal to the surface",
    "moment_z": "clamp moment",
}
# Later times are those of a clock (s): they are counted from the first row.
CLOCK = 1e8


@dataclass(frozen=True, eq=False, kw_only=True)
class Imported(Tabular):
    """A recording from a laboratory's file.

    Attributes
    ----------
    values : dict of str to ndarray
        In SI units; NaN where a value is missing.
    zeros : dict of str to Zero
        Readings without load, which were subtracted from the channels.
    notes : tuple of str
        What was found in the file and done with it.
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
            name: Column(self.values[name], kind.si, DESCRIPTIONS[name])
            for name, kind in KINDS.items()
            if name in self.values
        }

    def header(self) -> dict[str, str]:
        """Zeros as ``310.254 ± 0.27 mN``; `vibrissa identify` reads their errors."""
        header = {}
        for name, zero in self.zeros.items():
            value, _ = self.units.told(zero.value, KINDS[name])
            if zero.deviation:  # else all readings were alike, and the error is not known
                error = self.units.spelled(zero.deviation, KINDS[name], 2)
                header[f"zero_{name}"] = f"{value:.6g} ± {error}"
        return header


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
        If it cannot be read as a recording, or in more than one way; a line for each error.
    """
    name = "standard input" if isinstance(source, bytes) else str(source)
    if isinstance(source, Path):
        check_file(source)
    text = decoded(source if isinstance(source, bytes) else source.read_bytes(), name)
    layout = layout_of(text, name, settings.separator, settings.decimal, settings.titles)
    found, values = _read(layout, name, settings)
    values = _with_time(values, settings, name, layout.rows.index.to_numpy())
    if settings.turn:
        values = turned(values, settings.turn)
    if any(settings.moment_origin):
        values = about_clamp(values, settings.moment_origin)
    kept = _inside(values, settings.begin, settings.end)
    if not kept.any():
        raise RecordingError(f"{name}: no row is left between --from and --to")
    zeros = _zeros(values, settings, kept)
    values = {
        key: (each - zeros[key].value if key in zeros else each)[kept]
        for key, each in values.items()
    }
    outside = int(np.count_nonzero(~kept))
    units = [f"1 {one.unit}" for one in found.values()]
    if settings.speed is not None:
        values["footpoint"] = settings.speed * (values["time"] - values["time"][0])
    return Imported(
        values=values,
        zeros=zeros,
        notes=(
            *layout.notes,
            *(f"{target}: {one.note}" for target, one in found.items()),
            *(["footpoint: speed times the time since --from"] if settings.speed else []),
            *_missing_values(values),
            *([f"outside --from and --to: {counted(outside, 'row')}"] if outside else []),
        ),
        units=Units(si=True, wished=wished_units(*units)),
    )


def _read(layout: Layout, name: str, settings: Settings) -> tuple[dict[str, FileColumn], Values]:
    """Read the columns of a recording in SI units; all errors are reported together."""
    cells = split(layout.rows, name, layout.sign)
    replaced = {"time": settings.rate, "footpoint": settings.speed}
    made = {target for target, given in replaced.items() if given is not None}
    wanted = [target for target in KINDS if target not in made]
    found, errors = columns_of(layout, cells.shape[1], wanted, settings.column)
    errors += _lacking({*found, *made, *settings.column}, settings)
    if "time" in found and cells[found["time"].number].str.contains(":").any():
        clock = found.pop("time")
        errors.append(f"column {clock.title} has times of day: add --rate, as in --rate '50 Hz'")
    if errors:
        there = ", ".join(layout.titles) or f"no titles, columns #1 to #{cells.shape[1]}"
        errors.append(f"the columns are: {there} (--titles names another line of titles)")
    errors = [f"{name}: {error}" for error in errors]
    labels = {f"{one.title} ({target})": cells[one.number] for target, one in found.items()}
    try:
        read = numbers(labels, name, layout.notation)
    except RecordingError as error:
        errors.append(str(error))
    if errors:
        raise RecordingError("\n".join(errors))
    values = (one.factor * each for one, each in zip(found.values(), read.values(), strict=True))
    return found, dict(zip(found, values, strict=True))


def _lacking(there: set[str], settings: Settings) -> list[str]:
    """Columns that the settings need and the file lacks."""
    places = [*(settings.tare or ()), settings.begin, settings.end]
    needs = {
        "the tare, --from or --to": {place.column for place in places if place},
        "speed": {"time"} if settings.speed is not None else set(),
        "turn": {"force_x", "force_y"} if settings.turn else set(),
        "moment_origin": set(CHANNELS) if any(settings.moment_origin) else set(),
    }
    errors = [
        f"{what} needs the column {target}: add --column '{target}=...'"
        + " or --rate '50 Hz'" * (target == "time")
        for what, needed in needs.items()
        for target in sorted(needed - there)
    ]
    if not there & set(CHANNELS):
        errors.append(
            f"none of {', '.join(CHANNELS)} is there: say which column is which, as in "
            '--column "force_x=Fz [mN]"'
        )
    if "footpoint" not in there:
        errors.append(
            "the clamp position is missing: say which column it is, as in --column "
            "'footpoint=x [mm]', or add --speed, --from and --to"
        )
    return errors


def _with_time(values: Values, settings: Settings, name: str, line: IntArray) -> Values:
    """Give each sample its time, by the rate or as recorded.

    Raises
    ------
    RecordingError
        If time was recorded and does not increase.
    """
    if settings.rate is not None:
        size = len(next(iter(values.values())))
        return {"time": np.arange(size) / settings.rate, **values}
    if "time" not in values:
        return values
    time = values["time"]
    late = line[1:][~(np.diff(time) > 0.0)]
    if len(late):
        raise RecordingError(
            listed(
                f"{name}, line {each}: time does not increase; --rate replaces it" for each in late
            )
        )
    return values | {"time": time - time[0] if time[0] > CLOCK else time}


def _inside(values: Values, begin: Place | None, end: Place | None) -> BoolArray:
    """Select the samples between two places."""
    rows = np.ones(len(next(iter(values.values()))), dtype=bool)
    if begin is not None:
        rows &= np.maximum.accumulate(values[begin.column] >= begin.value)
    if end is not None:
        after = values[end.column] > end.value
        rows &= ~np.minimum.accumulate(after[::-1])[::-1]
    return rows


def _zeros(values: Values, settings: Settings, kept: BoolArray) -> dict[str, Zero]:
    """Find the zeros in the given window, or in rows that are certainly without load."""
    if settings.tare is not None:
        begin, end = settings.tare
        where = values[begin.column]
        return zeros_of(values, (where >= begin.value) & (where <= end.value))
    first = int(np.argmax(kept)) if settings.begin is not None else None
    free = unloaded(values, first)
    return zeros_of(values, np.arange(len(kept)) < free) if free >= FEWEST else {}


def _missing_values(values: Values) -> list[str]:
    counts = {name: int(np.isnan(each).sum()) for name, each in values.items()}
    return [f"{name} is missing in {counted(n, 'row')}" for name, n in counts.items() if n]
