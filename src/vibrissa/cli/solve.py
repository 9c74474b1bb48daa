"""``vibrissa solve``: one rod on one surface."""

from typing import Annotated

import typer

from vibrissa import sensor
from vibrissa.cli.options import ALONE, AlsoOut, Picture, check_files, shown
from vibrissa.cli.whisker import takes_whisker
from vibrissa.errors import ArgumentError
from vibrissa.outcomes import Status
from vibrissa.sensor import series

app = typer.Typer(**ALONE)


@app.command(epilog="Example: `vibrissa solve --theta 2 --eta 0.85 --mu0 0.4 --step 0.001`")
@takes_whisker
def solve(
    whisker: sensor.Whisker,
    mu0: Annotated[str, typer.Option(help="Coefficient of static friction.")],
    step: Annotated[str | None, typer.Option(help="Step of the stage: '20 um'.")] = None,
    output: AlsoOut = None,
    picture: Picture = None,
) -> None:
    """One rod on one surface: onset of slip, clamp reactions and largest strain.

    A tip that locks is a result, too: its status says so. The exit code is 1 if nothing can be
    computed, 2 after a mistake in the input.
    """
    check_files(output, picture)
    found = sensor.solve(whisker, mu0, step)
    columns = found.columns()
    for name, column in columns.items():
        typer.echo(f"{name:<12} {shown(column)}")
    if output is not None:
        series.write(output, columns)
    status = found.onset.status
    if picture is not None:
        from vibrissa.cli import plots

        if status is not Status.SLIP:
            raise ArgumentError(f"no picture of a rod with status {status}")
        plots.save(plots.shapes(whisker, found), picture)
    if status in (Status.FAILED, Status.OUT_OF_REACH):
        raise typer.Exit(1)
