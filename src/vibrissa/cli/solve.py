"""``vibrissa solve``: one rod on one surface."""

from typing import Annotated

import typer

from vibrissa import sensor
from vibrissa.cli.options import ALONE, AlsoOut, Picture, check_files, save_picture, say
from vibrissa.cli.whisker import say_exact, takes_whisker
from vibrissa.design.materials import material as material_named
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
    material: Annotated[
        str | None,
        typer.Option(help="Material, of which the largest strain is told as a part of its yield."),
    ] = None,
    yield_strain: Annotated[
        float | None,
        typer.Option(help="Its yield strain instead; in units of d0/L without a modulus."),
    ] = None,
    output: AlsoOut = None,
    picture: Picture = None,
) -> None:
    """One rod on one surface: onset of slip, clamp reactions and largest strain.

    A tip that locks is a result, too: its status says so. The exit code is 1 if nothing can be
    computed, 2 after a mistake in the input.
    """
    check_files(output, picture)
    say_exact(whisker, "solve")
    if material is not None:
        if yield_strain is not None:
            raise ArgumentError("give the material or its yield strain, not both")
        if whisker.rod is None:
            raise ArgumentError("a material needs the rod: give modulus, diameter and length")
        yield_strain = (
            material_named(material).with_modulus(whisker.rod.youngs_modulus).yield_strain
        )
    found = sensor.solve(whisker, mu0, step, yield_strain)
    say(found, output)
    if output is not None:
        series.write(output, found.columns())
    status = found.onset.status
    if status in (Status.FAILED, Status.OUT_OF_REACH):
        if picture is not None:
            typer.echo(f"{picture} is not drawn: there is no state to be shown", err=True)
        raise typer.Exit(1)
    if picture is not None:
        save_picture(found.plot(), picture)
