"""``vibrissa import``: from a laboratory's file to a recording that `vibrissa identify` reads."""

from inspect import Parameter
from pathlib import Path
from typing import Annotated, Any

import typer

from vibrissa.cli import ALONE, HELP
from vibrissa.cli.options import Out, reading_options
from vibrissa.cli.setup import read_pairs
from vibrissa.sensor import series
from vibrissa.sensor.importing import Settings, import_recording
from vibrissa.sensor.importing.layout import Separator
from vibrissa.sensor.series import STANDARD

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
    found = import_recording(series.content_of(file), settings, series.name_of(file))
    series.write(output, found.columns(), found.header())
    for line in found.report():
        typer.echo(line, err=True)
    rows = len(next(iter(found.values.values())))
    typer.echo(f"{output}: {rows} rows", err=output == STANDARD)
