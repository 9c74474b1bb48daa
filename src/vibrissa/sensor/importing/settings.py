"""What is told of a file: in options, or in a YAML file that holds the whole import."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, NamedTuple, Self

from vibrissa.errors import ArgumentError, UnknownNameError
from vibrissa.extras import require
from vibrissa.sensor.importing.layout import Separator
from vibrissa.sensor.quantities import Kind, chosen, in_si
from vibrissa.sensor.transducer import CHANNELS

# What a recording has.
NAMES = ("time", "footpoint", *CHANNELS)
DECIMALS = (".", ",")
SOURCE = re.compile(r"(.*?)\s*(?:\[([^\[\]]*)\])?")


class Source(NamedTuple):
    """A column of the file that becomes one of the recording.

    Attributes
    ----------
    title : str
        As given, with the unit and the sign if there are any; or ``#3``, the third column.
    name : str
        Without them.
    unit : str
        Empty where the file tells it.
    sign : float
        −1 where the column has the opposite sign.
    """

    title: str
    name: str
    unit: str
    sign: float


class Window(NamedTuple):
    """A part of a recording, by the time or by the clamp position, in SI units."""

    kind: Kind
    low: float
    high: float

    @property
    def column(self) -> str:
        """Column in which it lies."""
        return "time" if self.kind is Kind.TIME else "footpoint"


@dataclass(frozen=True, kw_only=True)
class Settings:
    """What is told of a file; what is None is found, or there is none.

    Attributes
    ----------
    encoding : str or None
        As Python names it.
    separator : Separator or None
    decimal : str or None
        ``.`` or ``,``.
    titles : int or None
        Line of the titles; 0 if there are none.
    columns : mapping of str to Source
        By the name in the recording; others are those of the file that have such a name.
    turn : float
        By which the transducer's axes are turned from x to y (rad).
    moment_origin : tuple of float
        Point about which the moments are, from the clamp (m).
    tare : tuple of Window
        Without load.
    speed, rate : float or None
        Of the stage (m/s), of the samples (Hz).
    begin, end : Window or None
        First and last sample to be kept; found by default.
    """

    encoding: str | None = None
    separator: Separator | None = None
    decimal: str | None = None
    titles: int | None = None
    columns: Mapping[str, Source]
    turn: float = 0.0
    moment_origin: tuple[float, float] = (0.0, 0.0)
    tare: tuple[Window, ...] = ()
    speed: float | None = None
    rate: float | None = None
    begin: Window | None = None
    end: Window | None = None

    @classmethod
    def read(
        cls,
        *,
        encoding: str | None = None,
        separator: str | None = None,
        decimal: str | None = None,
        titles: int | None = None,
        columns: Mapping[str, str] | None = None,
        turn: str | None = None,
        moment_origin: str | None = None,
        tare: Sequence[str] = (),
        speed: str | None = None,
        rate: str | None = None,
        begin: str | None = None,
        end: str | None = None,
    ) -> Self:
        """Read settings from quantities with units.

        Parameters
        ----------
        encoding, separator, decimal, titles
            As the attributes.
        columns : mapping of str to str
            As in ``{"force_x": "Fz [mN]", "force_y": "-Fy"}``.
        turn : str
            ``"90 deg"``.
        moment_origin : str
            ``"1 mm, 0 mm"``.
        tare : sequence of str
            Each ``"0 s, 2 s"`` or ``"0 mm, 1 mm"``.
        speed, rate : str
            ``"0.1 mm/s"``, ``"50 Hz"``.
        begin, end : str
            A time or a clamp position: ``"2 s"``.

        Raises
        ------
        ArgumentError
            If one of them is no such thing.
        """
        if decimal is not None and decimal not in DECIMALS:
            raise ArgumentError(f"decimal must be '.' or ',', got {decimal!r}")
        return cls(
            encoding=encoding,
            separator=None if separator is None else chosen(Separator, separator, "separator"),
            decimal=decimal,
            titles=titles,
            columns={name: source_of(name, text) for name, text in (columns or {}).items()},
            turn=0.0 if turn is None else float(in_si(turn, Kind.ANGLE, "turn")),
            moment_origin=_point(moment_origin),
            tare=tuple(_window(text) for text in tare),
            speed=_positive(speed, Kind.SPEED, "speed"),
            rate=_positive(rate, Kind.RATE, "rate"),
            begin=_end(begin, "from"),
            end=_end(end, "to"),
        )


def source_of(name: str, text: str) -> Source:
    """Read a column of the file, such as ``-Fz [mN]``.

    Raises
    ------
    ArgumentError
        If a recording has no column of that name, or there is no text.
    """
    if name not in NAMES:
        raise ArgumentError(f"column must be one of {', '.join(NAMES)}, got {name!r}")
    given = text.strip()
    parts = SOURCE.fullmatch(given.removeprefix("-").strip())
    if parts is None or not parts[1]:
        raise ArgumentError(f"column {name} needs the title of a column, got {text!r}")
    sign = -1.0 if given.startswith("-") else 1.0
    return Source(title=given, name=parts[1], unit=(parts[2] or "").strip(), sign=sign)


def _positive(text: str | None, kind: Kind, what: str) -> float | None:
    if text is None:
        return None
    value = float(in_si(text, kind, what))
    if not value > 0.0:
        raise ArgumentError(f"{what} must be positive, got {text!r}")
    return value


def _point(text: str | None) -> tuple[float, float]:
    if text is None:
        return 0.0, 0.0
    parts = text.split(",")
    if len(parts) != 2:
        raise ArgumentError(f"moment_origin needs two lengths, got {text!r}")
    x, y = (float(in_si(part, Kind.LENGTH, "moment_origin")) for part in parts)
    return x, y


def _place(text: str, what: str) -> tuple[Kind, float]:
    """Read a time or a clamp position."""
    for kind in (Kind.TIME, Kind.LENGTH):
        try:
            return kind, float(in_si(text, kind, what))
        except ArgumentError:
            continue
    raise ArgumentError(f"{what} must be a time or a clamp position with its unit, got {text!r}")


def _end(text: str | None, what: str) -> Window | None:
    if text is None:
        return None
    kind, value = _place(text, what)
    return Window(kind, value, value)


def _window(text: str) -> Window:
    parts = text.split(",")
    if len(parts) != 2:
        raise ArgumentError(f"tare needs two times or two clamp positions, got {text!r}")
    (kind, low), (other, high) = (_place(part, "tare") for part in parts)
    if other is not kind or not low < high:
        raise ArgumentError(f"tare must go from a time to a later one, got {text!r}")
    return Window(kind, low, high)


def read_file(path: Path) -> dict[str, Any]:
    """Read what a YAML file tells of an import, as arguments of `Settings.read`.

    Parameters
    ----------
    path : Path

    Returns
    -------
    dict

    Raises
    ------
    ArgumentError
        If it is no such file; the message names the key.
    """
    require("tables", "yaml")
    import yaml

    try:
        given = yaml.safe_load(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ArgumentError(f"{path}: there is no such file") from None
    except OSError as error:
        raise ArgumentError(f"{path} cannot be read: {error.strerror}") from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        said = " ".join(str(error).split())
        raise ArgumentError(f"{path}: not a YAML file: {said}") from None
    if not isinstance(given, dict):
        raise ArgumentError(f"{path}: must hold keys such as columns, got {given!r}")
    return {key: _checked(path, key, value) for key, value in _renamed(path, given).items()}


# What the options are called where Python has a word of its own.
WORDS = {"from": "begin", "to": "end"}
KEYS = tuple(
    {"begin": "from", "end": "to"}.get(field.name, field.name) for field in fields(Settings)
)


def _renamed(path: Path, given: Mapping[Any, Any]) -> dict[str, Any]:
    unknown = [str(key) for key in given if key not in KEYS]
    if unknown:
        raise UnknownNameError(
            f"{path}: {unknown[0]} is no setting of an import; there are {', '.join(KEYS)}"
        )
    return {WORDS.get(key, key): value for key, value in given.items()}


def _checked(path: Path, key: str, value: Any) -> Any:
    """Check the type of a value; one tare window may stand alone."""
    if key == "columns":
        if isinstance(value, dict) and all(isinstance(text, str) for text in value.values()):
            return value
        raise ArgumentError(f"{path}: columns must hold one title for each name, got {value!r}")
    if key == "tare":
        windows = [value] if isinstance(value, str) else value
        if isinstance(windows, list) and all(isinstance(text, str) for text in windows):
            return windows
        raise ArgumentError(f"{path}: tare must be one or more texts such as '0 s, 2 s'")
    wanted = int if key == "titles" else str
    if not isinstance(value, wanted) or isinstance(value, bool):
        kind = "a number" if wanted is int else "a text"
        raise ArgumentError(f"{path}: {key} must be {kind}, got {value!r}")
    return value
