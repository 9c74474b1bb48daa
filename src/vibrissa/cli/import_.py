"""``vibrissa import``: from a laboratory's file to a recording that `vibrissa identify` reads."""

import sys
from inspect import Parameter
from pathlib import Path
from typing import Annotated, Any

import typer

from vibrissa.cli import ALONE, HELP
from vibrissa.cli.options import Out, reading_options
from vibrissa.cli.setup import read_pairs
from vibrissa.sensor import series
from vibrissa.sensor.importing import Imported, Settings, import_recording
from vibrissa.sensor.importing.layout import Separator
from vibrissa.sensor.series import STANDARD
from vibrissa.wording import counted

app = typer.Typer(**ALONE)

# Types of the options that are no text.
TYPES: dict[str, Any] = {"column": list[str], "separator": Separator, "titles": int}


def _option(name: str) -> Parameter:
    """Describe an option by the field of the settings of that name."""
    field = Settings.model_fields[name]
    option = typer.Option(f"--{(field.alias or name).replace('_', '-')}", help=field.description)
    annotation: Any = Annotated[TYPES.get(name, str) | None, option]
    return Parameter(name, Parameter.KEYWORD_ONLY, default=None, annotation=annotation)


def read_settings(settings_file: Path | None, **options: Any) -> Settings:
    """Read settings from the options of the command and a file."""
    options["column"] = read_pairs(options["column"] or (), "--column") or None
    names = {name: field.alias or name for name, field in Settings.model_fields.items()}
    return Settings.read(settings_file, **{names[name]: one for name, one in options.items()})


FILE = Parameter(
    "settings_file",
    Parameter.KEYWORD_ONLY,
    default=None,
    annotation=Annotated[
        Path | None,
        typer.Option(
            "--settings",
            help="A TOML file with these options as keys. An option overrides its key.",
        ),
    ],
)


@app.command(
    "import",
    context_settings=HELP,
    epilog="Example: `vibrissa import lab.txt --column 'force_x=Fz [mN]' --column 'force_y=-Fy' "
    "--column footpoint=x_mm -o recording.csv`",
)
@reading_options("settings", [FILE, *map(_option, Settings.model_fields)], read_settings)
def import_(
    file: Annotated[Path, typer.Argument(help="A text file with a table; - for standard input.")],
    settings: Settings,
    output: Out,
) -> None:
    """Make a recording for identify from a laboratory's file, and report how it was read.

    Finds encoding, separator, decimal sign, titles, units and the rows without load before the rod
    is lowered, whose mean is subtracted. Turns axes, and moves the moment to the clamp. Ambiguous
    files are rejected, with the options to add.
    """
    source = sys.stdin.buffer.read() if file == STANDARD else file
    found = import_recording(source, settings)
    series.write(output, found.columns(), found.header())
    _report(found, output)


def _report(found: Imported, output: Path) -> None:
    """Report what was read; beside the table if that goes to standard output."""
    for text in found.notes:
        typer.echo(text, err=True)
    header = found.header()
    for name, text in header.items():
        size = counted(found.zeros[name.removeprefix("zero_")].rows, "row")
        typer.echo(f"{name} = {text}, mean of {size}, subtracted", err=True)
    rows = len(next(iter(found.values.values())))
    typer.echo(f"{output}: {rows} rows", err=output == STANDARD)
    if not header:
        typer.echo(
            "no tare: readings without load are taken as 0; if the rod was free for a while, add "
            "--tare, as in --tare '0 s, 2 s'",
            err=True,
        )
