"""Settings of an import."""

from contextlib import suppress
from typing import Annotated, Any, Literal, NamedTuple, Self

from pydantic import BeforeValidator, Field, ValidationInfo, model_validator

from vibrissa.errors import ArgumentError
from vibrissa.quantities.keys import Keyed, Positive
from vibrissa.quantities.units import Kind
from vibrissa.sensor.importing.titles import KINDS
from vibrissa.sensor.transducer import CHANNELS

# Options that replace a column missing in the file.
INSTEAD = {"time": "--rate '50 Hz'", "footpoint": "--speed, --from and --to"}


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


Line = Annotated[int, Field(ge=1)]
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
    'force_y=-Fy' turns its sign, 'force_x=Ch1 * 12.5 N/V' converts a signal, 'time=#1' is the first
    column. Repeat for each channel. Columns named time, footpoint, force_x, force_y and moment_z
    need no option."""
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
    title_line: Line | None = None
    """Line of the titles, such as 7. Found by default."""
    unit_line: Line | None = None
    """Line of the units below the titles, such as 8. Found by default."""
    table: str | None = None
    """Sheet of a spreadsheet, group of a TDMS file, or variables of a MATLAB file, if there are
    several."""

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
        if self.speed is not None and any(not place or place.column != "time" for place in places):
            raise ArgumentError(
                "with speed, give the times at which the stage begins to move and stops, as in "
                "--from '2 s' --to '40 s'; if you give --tare, it must be times, too"
            )
        for name in self.made & self.column.keys():
            raise ArgumentError(f"give a column of {name} or {INSTEAD[name]}, not both")
        return self
