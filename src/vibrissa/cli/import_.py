"""``vibrissa import``: from a laboratory's file to a recording that `vibrissa identify` reads."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from vibrissa.cli import ALONE, HELP
from vibrissa.cli.options import Out, check_files, check_not_read
from vibrissa.errors import ArgumentError
from vibrissa.sensor import series
from vibrissa.sensor.importing import Imported, Settings, import_recording
from vibrissa.sensor.importing.columns import KINDS
from vibrissa.sensor.importing.layout import Separator
from vibrissa.sensor.importing.settings import read_file
from vibrissa.sensor.series import STANDARD

app = typer.Typer(**ALONE)


@app.command(
    "import",
    context_settings=HELP,
    epilog="Example: `vibrissa import lab.txt --column 'force_x=Fz [mN]' --column 'force_y=-Fy' "
    "--speed '0.1 mm/s' -o recording.csv`",
)
def import_(
    file: Annotated[Path, typer.Argument(help="A text file with a table; - for standard input.")],
    output: Out,
    settings: Annotated[
        Path | None,
        typer.Option(help="A YAML file with these options as keys. An option overrides its key."),
    ] = None,
    column: Annotated[
        list[str] | None,
        typer.Option(
            help="Which column of the file is which, with its unit if the file has none: "
            "'force_x=Fz [mN]', 'force_y=-Fy' with the other sign, 'time=#1' for the first one. "
            "Repeat it. Columns that are called time, footpoint, force_x, force_y and moment_z are "
            "found."
        ),
    ] = None,
    turn: Annotated[
        str | None,
        typer.Option(help="Angle by which the file's axes are turned from x to y: '90 deg'."),
    ] = None,
    moment_origin: Annotated[
        str | None,
        typer.Option(help="Point about which the moment is, from the clamp: '1 mm, 0 mm'."),
    ] = None,
    tare: Annotated[
        list[str] | None,
        typer.Option(help="Window without load, whose mean is the zero: '0 s, 2 s'. Repeat it."),
    ] = None,
    speed: Annotated[
        str | None,
        typer.Option(help="Speed of the stage, if its position is missing: '0.1 mm/s'."),
    ] = None,
    rate: Annotated[
        str | None, typer.Option(help="Samples in a second, if the time is missing: '50 Hz'.")
    ] = None,
    begin: Annotated[
        str | None,
        typer.Option("--from", help="First sample to take, by time or clamp position: '2 s'."),
    ] = None,
    end: Annotated[str | None, typer.Option("--to", help="Last sample to take: '40 s'.")] = None,
    encoding: Annotated[
        str | None, typer.Option(help="Encoding of the file, such as latin-1. It is found.")
    ] = None,
    separator: Annotated[
        Separator | None, typer.Option(help="What separates the columns. It is found.")
    ] = None,
    decimal: Annotated[
        str | None, typer.Option(help="Decimal sign, '.' or ','. It is found.")
    ] = None,
    titles: Annotated[
        int | None,
        typer.Option(min=0, help="Line of the titles; 0 for none. It is found."),
    ] = None,
) -> None:
    """Make a recording for identify from a laboratory's file, and say what was read.

    Finds encoding, separator, decimal sign, lines before the titles and a row of units. Takes
    zeros off, turns axes, moves the moment to the clamp, and leaves out rest and lift-off at the
    ends. What may be read in two ways is refused.
    """
    check_files(output, None)
    check_not_read([output], [file, settings])
    told = {
        "encoding": encoding,
        "separator": separator,
        "decimal": decimal,
        "titles": titles,
        "turn": turn,
        "moment_origin": moment_origin,
        "tare": tare,
        "speed": speed,
        "rate": rate,
        "begin": begin,
        "end": end,
    }
    given = {} if settings is None else read_file(settings)
    given |= {name: value for name, value in told.items() if value is not None}
    given["columns"] = given.get("columns", {}) | _columns(column or ())
    source = sys.stdin.buffer.read() if file == STANDARD else file
    found = import_recording(source, Settings.read(**given))
    series.write(output, found.columns())
    _say(found, output)


def _columns(given: Sequence[str]) -> dict[str, str]:
    """Read ``name=title`` of each."""
    pairs = [text.partition("=") for text in given]
    for text, (_, equals, _) in zip(given, pairs, strict=True):
        if not equals:
            raise ArgumentError(f"a column is given as name=title, got {text!r}")
    names = [name.strip() for name, _, _ in pairs]
    for name in names:
        if names.count(name) > 1:
            raise ArgumentError(f"the column {name} is given twice")
    return {name.strip(): title for name, _, title in pairs}


def _say(found: Imported, output: Path) -> None:
    """Say what was taken; beside the table if that goes to standard output."""
    for text in found.said:
        typer.echo(text, err=True)
    rows = len(next(iter(found.values.values())))
    typer.echo(f"{output}: {rows} rows", err=output == STANDARD)
    if found.zeros:
        options = " ".join(
            f'--tolerance "zero_{name}={found.units.spelled(zero.deviation, KINDS[name], 2)}"'
            for name, zero in found.zeros.items()
        )
        typer.echo(f"for identify, the zeros are known to: {options}", err=True)
