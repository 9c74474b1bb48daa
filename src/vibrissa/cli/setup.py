"""Options that are fields of a model: of a `Setup`, or of the `Requirements` of a design."""

from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from functools import partial
from inspect import Parameter
from pathlib import Path
from typing import Annotated, Any, get_origin

import typer
from pydantic.fields import FieldInfo

from vibrissa.cli.options import option, reading_options
from vibrissa.errors import ArgumentError
from vibrissa.sensor.quantities import Kind
from vibrissa.sensor.setup import TOLERANCES, Setup
from vibrissa.sensor.tolerances import EXACT
from vibrissa.sensor.whisker import Whisker

Command = Callable[..., None]
# Panels in which `--help` shows options, each with names of fields.
Panels = Mapping[str, Sequence[str]]

ROD, MOUNTING, SIGNALS = "Rod", "Mounting", "Signals"
# Fields of a set-up that are typed often; `--set` has the others.
SIZES = ("theta", "eta", "modulus", "diameter", "length", "contact")
ANGLES = ("clamp_angle", "stage_angle")

# What fields are that measure nothing.
METAVARS = {"noise": "list", "material": "name", "transducer": "name"}

Rod = Annotated[
    Path | None,
    option("Set-up file (.toml). An option overrides its key.", "<file>", ROD),
]
Tolerances = Annotated[
    list[str] | None,
    option(
        "Standard deviation of a quantity: 'modulus=2 %', 'theta=exact'; repeat it. 'exact' alone: "
        "every quantity without a stated tolerance is exact.",
        *("<name>=<size>", SIGNALS, "--tolerance"),
    ),
]


def takes(
    parameter: str, model: Any, panels: Panels, tolerances: bool = False, *endings: str
) -> Callable[[Command], Command]:
    """Give a command options in place of one parameter, a model that is read from them.

    Parameters
    ----------
    parameter : str
    model : type
        With a method ``read(path, **fields)``.
    panels : mapping of str to sequence of str
        Fields of the model and of a `Setup` that are options, by panel.
    tolerances : bool
        Whether tolerances are an option, too.
    *endings : str
        Further ones of the option ``--output``.
    """
    fields = Setup.model_fields | model.model_fields
    names = [name for some in panels.values() for name in some]
    others = [one for one in Setup.model_fields if one not in (*names, TOLERANCES, "assume")]
    types: dict[str, Any] = {"rod": Rod, "assignments": _assignments(others)}
    for panel, some in panels.items():
        types |= {name: _annotation(name, fields[name], panel) for name in some}
    if tolerances:
        types[TOLERANCES] = Tolerances
    options = [
        Parameter(
            name,
            Parameter.KEYWORD_ONLY,
            annotation=annotation,
            default=Parameter.empty if name in names and fields[name].is_required() else None,
        )
        for name, annotation in types.items()
    ]

    return reading_options(parameter, options, partial(_read, model), *endings)


def _assignments(others: Sequence[str]) -> Any:
    text = f"Another key of a set-up file; repeat it. {', '.join(others)}."
    return Annotated[list[str] | None, option(text, "<name>=<value>", MOUNTING, "--set")]


def _annotation(name: str, field: FieldInfo, panel: str) -> Any:
    """Describe an option by its field; pydantic validates its value."""
    default = field.default if isinstance(field.default, str | float) else None
    shown = str(default) if default not in (None, float("inf")) else False
    typed = option(str(field.description), _metavar(name, field), panel, show_default=shown)
    return Annotated[str | None, typed]


def _metavar(name: str, field: FieldInfo) -> str:
    if isinstance(field.annotation, type) and issubclass(field.annotation, Enum):
        return "|".join(field.annotation)
    kind = next((mark for mark in field.metadata if isinstance(mark, Kind)), None)
    other = "range" if get_origin(field.annotation) is tuple else Kind.NUMBER
    return f"<{METAVARS.get(name, kind or other)}>"


def _read(
    model: Any,
    rod: Path | None,
    assignments: Sequence[str] | None,
    tolerances: Sequence[str] | None = None,
    **options: Any,
) -> Any:
    """Read a model from the options of a command and its set-up file."""
    given = {name: value for name, value in options.items() if value is not None}
    for name, value in read_pairs(assignments or (), "--set").items():
        if name in given:
            raise ArgumentError(f"{name} is given twice: as an option and with --set")
        given[name] = value
    sizes = [text for text in tolerances or () if text != EXACT]
    given[TOLERANCES] = read_pairs(sizes, "--tolerance")
    if EXACT in (tolerances or ()):
        given["assume"] = False
    return model.read(rod, **given)


def read_pairs(given: Sequence[str], option: str) -> dict[str, str]:
    """Read pairs ``name=value``.

    Raises
    ------
    ArgumentError
    """
    pairs: dict[str, str] = {}
    for text in given:
        name, _, value = (part.strip() for part in text.partition("="))
        if not (name and value):
            raise ArgumentError(f"{option} needs name=value, got {text!r}")
        if name in pairs:
            raise ArgumentError(f"{option} {name} is given twice")
        pairs[name] = value
    return pairs


def say_exact(whisker: Whisker, command: str) -> None:
    """Report that a command ignores the tolerances, if some were given."""
    if whisker.tolerances:
        names = ", ".join(whisker.tolerances)
        typer.echo(f"{command} does not use the tolerances of {names}", err=True)
