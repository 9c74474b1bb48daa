"""``vibrissa import``: from a laboratory's file to a recording that `vibrissa identify` reads."""

from pathlib import Path
from typing import Annotated

import typer

from vibrissa.cli.options import Out, command, hand_out
from vibrissa.quantities import series
from vibrissa.sensor.importing import Settings, import_recording

EXAMPLE = (
    "Example: `vibrissa import lab.txt --column 'force_x=Fx [mN]' --column 'force_y=-Fy' "
    "--column footpoint=x_mm -o recording.csv`"
)


@command({"File": tuple(Settings.model_fields)}, EXAMPLE, "--settings")
def import_(
    file: Annotated[
        Path,
        typer.Argument(
            help="A table: text, Excel, MATLAB, TDMS, .lvm or Parquet; - for standard input."
        ),
    ],
    settings: Settings,
    output: Out,
) -> None:
    """Turn a laboratory's file into a recording for identify; report how it was read.

    Finds encoding, separator, decimal sign, titles and units. Subtracts the mean of the rows before
    the rod touches the surface. Turns the axes, and refers the moment to the clamp. An ambiguous
    file is rejected; the message names the options to add.
    """
    found = import_recording(series.content_of(file), settings, series.name_of(file))
    for line in found.report():
        typer.echo(line, err=True)
    hand_out(found, f"{output}: {len(found.values['footpoint'])} rows", output)
