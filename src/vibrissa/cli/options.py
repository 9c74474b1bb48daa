"""Options of the commands: files, and the fields of the pydantic model that a command reads."""

import os
from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import Annotated, Any, get_origin

import typer
from pydantic.fields import FieldInfo

from vibrissa.cli.app import HELP
from vibrissa.cli.screen import say
from vibrissa.errors import ArgumentError
from vibrissa.quantities.series import ENDINGS, STANDARD, Tabular, check_ending, write
from vibrissa.quantities.units import Kind
from vibrissa.sensor.setup import TOLERANCES, Setup
from vibrissa.sensor.tolerances import EXACT

# Panels of `--help`, each with the names of the fields that are its options.
Panels = Mapping[str, Sequence[str]]

# Fields of a set-up that have an option; `--set` takes the others.
SETUP: Panels = {
    "Rod": ("theta", "eta", "modulus", "diameter", "length", "contact", "material"),
    "Mounting": ("clamp_angle", "stage_angle"),
}


def option(text: str, panel: str | None, *names: str, **more: Any) -> Any:
    """Make an option with a help text; the help lists the option in a panel."""
    return typer.Option(*names, help=" ".join(text.split()), rich_help_panel=panel, **more)


_TABLE = "Table to write: .csv or .parquet; - for standard output."
Out = Annotated[Path | None, option(_TABLE, "Output", "--output", "-o")]


def command(
    panels: Panels, epilog: str, file: str = "--rod", endings: Sequence[str] = ENDINGS
) -> Callable[[Callable[..., None]], Any]:
    """Return a decorator that turns a function into a command.

    One parameter of the function must be annotated with a class: a pydantic model with a method
    ``read(path, **fields)``. The command has options for fields of the model in place of this
    parameter. It checks the output path before anything is computed.

    Parameters
    ----------
    panels : mapping of str to sequence of str
        For each panel of the help, fields of the model or of a `Setup` that become options.
    epilog : str
        Examples, printed below the help.
    file : str
        Name of the option for a TOML file with these fields as keys.
    endings : sequence of str
        File name endings allowed for ``--output``.
    """

    def decorate(function: Callable[..., None]) -> Any:
        own = dict(signature(function).parameters)
        (parameter,) = [name for name, one in own.items() if isinstance(one.annotation, type)]
        model = own.pop(parameter).annotation
        fields = Setup.model_fields | model.model_fields
        options = _options(panels, fields, file)

        @wraps(function)
        def run(**values: Any) -> None:
            _check_output(values, endings)
            given = {name: values.pop(name) for name in options}
            function(**{parameter: _read(model, fields, **given)}, **values)

        # Typer reads the options of a command from its signature and its annotations.
        every = [one.replace(kind=Parameter.KEYWORD_ONLY) for one in (own | options).values()]
        run.__dict__["__signature__"] = Signature(every)
        run.__annotations__ = {one.name: one.annotation for one in every}
        app = typer.Typer(add_completion=False, rich_markup_mode="markdown")
        app.command(function.__name__.strip("_"), context_settings=HELP, epilog=epilog)(run)
        return typer.main.get_command(app)

    return decorate


def _options(panels: Panels, fields: Mapping[str, FieldInfo], file: str) -> dict[str, Parameter]:
    """Make an option for each field and for the file; for a set-up, also ``--set``."""
    types = {
        name: _annotation(name, fields[name], panel) for panel in panels for name in panels[panel]
    }
    required = {name for name in types if fields[name].is_required()}
    text = "A file (.toml) with these options as keys. An option overrides its key."
    types["path"] = Annotated[Path | None, option(text, None, file)]
    if file == "--rod":
        others = [one for one in Setup.model_fields if one not in (*types, TOLERANCES, "assume")]
        text = f"Another key of the file, as name=value (repeatable): {', '.join(others)}."
        types["assignments"] = Annotated[list[str] | None, option(text, "Mounting", "--set")]
    return {
        name: Parameter(
            name,
            Parameter.KEYWORD_ONLY,
            annotation=annotation,
            default=Parameter.empty if name in required else None,
        )
        for name, annotation in types.items()
    }


def _annotation(name: str, field: FieldInfo, panel: str) -> Any:
    """Make the annotation of an option from its field; pydantic validates the value."""
    # A default in SI units is not shown: the text of the field has it in a usual unit.
    measured = any(isinstance(mark, Kind) and mark is not Kind.NUMBER for mark in field.metadata)
    shown = str(field.default) if isinstance(field.default, str | float) and not measured else False
    written = f"--{(field.alias or name).replace('_', '-')}"
    if get_origin(field.annotation) is dict:  # repeatable, with one key each time
        pairs = option(f"{field.description}", panel, written.removesuffix("s"))
        return Annotated[list[str] | None, pairs]
    return Annotated[str | None, option(f"{field.description}", panel, written, show_default=shown)]


def _read(
    model: Any,
    fields: Mapping[str, FieldInfo],
    path: Path | None,
    assignments: Sequence[str] | None = None,
    **options: Any,
) -> Any:
    """Read a model from the options of a command and a file."""
    given: dict[str, Any] = {}
    for name, value in options.items():
        if isinstance(value, list):
            given[name] = _pairs([text for text in value if text != EXACT], name)
        elif value is not None:
            given[fields[name].alias or name] = value
    if EXACT in (options.get(TOLERANCES) or ()):
        given["assume"] = False
    return model.read(path, **(given | _pairs(assignments or (), "set")))


def _pairs(given: Sequence[str], name: str) -> dict[str, str]:
    """Read pairs ``name=value``."""
    option, pairs = f"--{name.removesuffix('s')}", {}
    for text in given:
        key, _, value = (part.strip() for part in text.partition("="))
        if not (key and value):
            raise ArgumentError(f"{option} needs name=value, got {text!r}")
        if key in pairs:
            raise ArgumentError(f"{option} {key} is given twice")
        pairs[key] = value
    return pairs


def _check_output(values: Mapping[str, Any], endings: Sequence[str]) -> None:
    """Refuse an output path that cannot be written, or that is an input."""
    output = values.get("output")
    if output is None:
        return
    check_ending(output, endings)
    if output == STANDARD:
        return
    if output.is_dir() or not os.access(output.parent, os.W_OK):
        raise ArgumentError(
            f"{output} cannot be written: it must be a file in a folder that can be written to"
        )
    others = [value for name, value in values.items() if name != "output"]
    if output.resolve() in {Path(one).resolve() for one in others if isinstance(one, Path | str)}:
        raise ArgumentError(f"{output} is an input: give the output another name")


def hand_out(found: Tabular, text: str, output: Path | None) -> None:
    """Print a text, and write a result as a table if an output path is given."""
    if output is not None:
        write(output, found)
    say(text, err=output == STANDARD)
