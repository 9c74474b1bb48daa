"""``vibrissa solve``: one rod on one surface."""

from typing import Annotated

import typer

from vibrissa import sensor
from vibrissa.cli.options import ALONE, AlsoOut, Picture, check_files, save_picture
from vibrissa.cli.whisker import say_exact, takes_whisker
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
    say_exact(whisker, "solve")
    found = sensor.solve(whisker, mu0, step)
    typer.echo(found)
    if output is not None:
        series.write(output, found.columns())
    status = found.onset.status
    if picture is not None:
        save_picture(found.plot(), picture)
    if status in (Status.FAILED, Status.OUT_OF_REACH):
        raise typer.Exit(1)
