"""The rod file: a set-up written down once, in TOML, for all commands and for Python.

Its keys are the options of the commands, with ``_`` for ``-``, and their values are written like
theirs. The table ``tolerances`` has a size for each name in
`vibrissa.sensor.given.tolerances.TOLERABLE`.
"""

import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any, Self

from vibrissa.errors import ArgumentError, UnknownNameError
from vibrissa.files import write_atomically
from vibrissa.sensor.given.tolerances import TOLERABLE, read_tolerances
from vibrissa.sensor.quantities import Kind, Quantity
from vibrissa.sensor.whisker import Whisker

# Keys of the whisker, as of `Whisker.read`; and how it is read.
OF_WHISKER = (
    "theta",
    "eta",
    "contact",
    "section",
    "modulus",
    "diameter",
    "length",
    "clamp_angle",
    "clamp_compliance",
    "clamp_stiffness",
    "curvature",
    "stage_angle",
)
OF_READING = ("transducer", "noise")
# What the material bears, and what it weighs: for `solve` and `design`.
OF_MATERIAL = ("material", "yield_strain", "density")
TOLERANCES = "tolerances"
# Of each pair one is given: an option takes the place of the other in the file.
EITHER = (
    {"clamp_compliance", "clamp_stiffness"},
    {"transducer", "noise"},
    {"material", "yield_strain"},
)


@dataclass(frozen=True, eq=False, kw_only=True)
class RodFile:
    """A set-up.

    Attributes
    ----------
    whisker : Whisker
        With the tolerances that were stated.
    reading : dict
        ``transducer`` and ``noise``, as far as they are given: arguments of
        `vibrissa.sensor.identify`.
    material : dict
        ``material``, ``yield_strain`` and ``density``, as far as they are given.
    """

    whisker: Whisker
    reading: dict[str, Any]
    material: dict[str, Any]

    @classmethod
    def read(cls, path: Path | str) -> Self:
        """Read a file.

        Raises
        ------
        ArgumentError
            If there is no such file, or it has a key or a value that is not allowed.
        """
        return cls.of(keys_of(path))

    @classmethod
    def of(cls, keys: Mapping[str, Any]) -> Self:
        """Read what the keys of a file say.

        Raises
        ------
        ArgumentError
            If a value is missing or not allowed.
        """
        for name in ("theta", "eta"):
            if name not in keys:
                raise ArgumentError(f"{name} is not given: neither as an option nor in a rod file")
        whisker = Whisker.read(**{name: keys[name] for name in OF_WHISKER if name in keys})
        reading = {name: keys[name] for name in OF_READING if name in keys}
        material = {name: keys[name] for name in OF_MATERIAL if name in keys}
        if "yield_strain" in material:
            strain = whisker.units.read(material["yield_strain"], Kind.NUMBER, "yield_strain")
            material["yield_strain"] = float(strain)
        stated: dict[str, Quantity] = dict(keys.get(TOLERANCES, {}))
        whisker = whisker.tolerating(read_tolerances(whisker.units, stated, whisker))
        return cls(
            whisker=whisker.wishing(reading.get("noise"), *stated.values()),
            reading=reading,
            material=material,
        )


def write(path: Path, keys: Mapping[str, Any], comment: str) -> None:
    """Write a rod file.

    Parameters
    ----------
    path : Path
    keys : mapping
        As `keys_of` gives them.
    comment : str
        For the first line.
    """
    tables = {name: value for name, value in keys.items() if isinstance(value, Mapping)}
    lines = [f"# {comment}", "", *_lines({n: v for n, v in keys.items() if n not in tables})]
    for name, table in tables.items():
        if table:
            lines += ["", f"[{name}]", *_lines(table)]
    with write_atomically(path) as temporary:
        temporary.write_text("\n".join([*lines, ""]), encoding="utf-8")


def _lines(keys: Mapping[str, Any]) -> list[str]:
    # Numbers and texts are written in TOML as they are in JSON.
    return [f"{name} = {json.dumps(value, ensure_ascii=False)}" for name, value in keys.items()]


def with_options(keys: Mapping[str, Any], options: Mapping[str, Any]) -> dict[str, Any]:
    """Put options in the place of what a file says; those that are None were not given."""
    given = {name: value for name, value in options.items() if value is not None}
    instead = {name for pair in EITHER if pair & given.keys() for name in pair}
    kept = {name: value for name, value in keys.items() if name not in instead}
    tolerances = {**keys.get(TOLERANCES, {}), **given.pop(TOLERANCES, {})}
    return {**kept, **given, TOLERANCES: tolerances}


def keys_of(path: Path | str) -> dict[str, Any]:
    """Read the keys of a rod file and their values.

    Raises
    ------
    ArgumentError
        If it cannot be read; the message names the line, or the key and what is allowed.
    """
    path = Path(path)
    if path.suffix.lower() in (".yaml", ".yml"):
        raise ArgumentError(
            f"{path}: a rod file is written in TOML, as in theta = 2 (not theta: 2), and named "
            "setup.toml"
        )
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise ArgumentError(f"no such rod file: {path}") from None
    except OSError as error:
        raise ArgumentError(f"{path} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise ArgumentError(f"{path} is not a text in UTF-8: save it as UTF-8") from None
    try:
        found = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ArgumentError(
            f"{path}: {error}; write name = number, with a decimal point, or "
            'name = "value unit", in quotes'
        ) from None
    for name, value in found.items():
        _check_key(str(path), name, (*OF_WHISKER, *OF_READING, *OF_MATERIAL, TOLERANCES))
        if name != TOLERANCES:
            _check_value(str(path), name, value)
    tolerances = found.get(TOLERANCES, {})
    if not isinstance(tolerances, dict):
        raise ArgumentError(f"{path}: {TOLERANCES} is a table: [{TOLERANCES}], then name = size")
    for name, value in tolerances.items():
        _check_key(f"{path}: [{TOLERANCES}]", name, tuple(TOLERABLE))
        _check_value(f"{path}: [{TOLERANCES}]", name, value)
    return found


def _check_key(where: str, name: str, allowed: tuple[str, ...]) -> None:
    if name not in allowed:
        near = get_close_matches(name, allowed, 1)
        raise UnknownNameError(
            f"{where}: there is no key {name}; did you mean {near[0]}?"
            if near
            else f"{where}: there is no key {name}; there are {', '.join(allowed)}"
        )


def _check_value(where: str, name: str, value: Any) -> None:
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        raise ArgumentError(f"{where}: {name} is a number or a text in quotes, got {value!r}")
