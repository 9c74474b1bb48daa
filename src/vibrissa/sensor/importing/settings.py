"""Settings of an import: options, or the keys of a TOML file."""

from typing import Annotated, Any, Literal, NamedTuple, Self

from pydantic import BeforeValidator, Field, ValidationInfo, model_validator

from vibrissa.errors import ArgumentError
from vibrissa.sensor.importing.layout import KINDS
from vibrissa.sensor.keys import Keyed
from vibrissa.sensor.quantities import Kind
from vibrissa.sensor.transducer import CHANNELS


class Place(NamedTuple):
    """A place in a recording: a time (s) or a clamp position (m)."""

    column: str
    value: float


def _place(text: Any, info: ValidationInfo) -> Place:
    for column in ("time", "footpoint"):
        try:
            return Place(column, KINDS[column].read(str(text), column))
        except ArgumentError:
            continue
    name = str(info.field_name).strip("_")
    raise ArgumentError(f"{name} must be a time or a clamp position with its unit, got {text!r}")


def _two(text: Any, info: ValidationInfo) -> list[str]:
    parts = str(text).split(",")
    if len(parts) != 2:
        raise ArgumentError(f"{info.field_name} must be two values, as in '0 s, 2 s', got {text!r}")
    return parts


At = Annotated[Place, BeforeValidator(_place)]
Length = Annotated[float, Kind.LENGTH]


class Settings(Keyed):
    """Settings of an import; None: found in the file, or absent.

    Examples
    --------
    >>> Settings.read(column={"force_x": "-Fz [mN]"}, tare="0 s, 2 s").tare
    (Place(column='time', value=0.0), Place(column='time', value=2.0))
    """

    column: dict[str, str] = Field(default_factory=dict)
    """Column of the file for a channel, with its unit if the file has none: 'force_x=Fz [mN]',
    'force_y=-Fy' with the other sign, 'time=#1' for the first one. Repeat it. Columns named time,
    footpoint, force_x, force_y and moment_z are found."""
    turn: Annotated[float, Kind.ANGLE] = 0.0
    """Angle by which the file's axes are turned from x to y: '90 deg'."""
    moment_origin: Annotated[tuple[Length, Length], BeforeValidator(_two)] = (0.0, 0.0)
    """Point about which the moment acts, from the clamp: '1 mm, 0 mm'."""
    tare: Annotated[tuple[At, At] | None, BeforeValidator(_two)] = None
    """Window without load, whose mean is the zero: '0 s, 2 s'. By default the rows before the rod
    is lowered, if the clamp rests then."""
    speed: Annotated[float | None, Field(gt=0.0), Kind.SPEED] = None
    """Speed of the stage, if its position is missing: '0.1 mm/s'."""
    rate: Annotated[float | None, Field(gt=0.0), Kind.RATE] = None
    """Samples in a second, if the time is missing: '50 Hz'."""
    from_: At | None = Field(None, alias="from")
    """First sample to take, by time or clamp position: '2 s'. With --speed, when the stage begins
    to move."""
    to: At | None = None
    """Last sample to take: '40 s'. With --speed, when the stage stops."""
    decimal: Literal[".", ","] | None = None
    """Decimal sign, '.' or ','. Found by default."""

    @property
    def made(self) -> set[str]:
        """Columns that are not taken from the file."""
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
        ends = [place.column for place in (self.from_, self.to) if place is not None]
        if self.speed is not None and ends != ["time", "time"]:
            raise ArgumentError(
                "speed needs the times at which the stage begins to move and stops: add --from and "
                "--to, as in --from '2 s' --to '40 s'"
            )
        return self
