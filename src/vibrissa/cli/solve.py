"""``vibrissa solve``: one rod on one surface."""

from typing import Annotated

import typer

from vibrissa import sensor
from vibrissa.cli.options import (
    ALONE,
    AlsoOut,
    ClampAngle,
    ClampCompliance,
    ClampStiffness,
    Curvature,
    Diameter,
    Eta,
    Length,
    Modulus,
    Picture,
    StageAngle,
    Theta,
    Touch,
    check_files,
    shown,
)
from vibrissa.errors import ArgumentError
from vibrissa.outcomes import Contact, Status
from vibrissa.sensor import series

app = typer.Typer(**ALONE)


@app.command(epilog="Example: `vibrissa solve --theta 2 --eta 0.85 --mu0 0.4 --step 0.001`")
def solve(
    theta: Theta,
    eta: Eta,
    mu0: Annotated[str, typer.Option(help="Coefficient of static friction.")],
    step: Annotated[str | None, typer.Option(help="Step of the stage: '20 um'.")] = None,
    contact: Touch = Contact.POINT,
    modulus: Modulus = None,
    diameter: Diameter = None,
    length: Length = None,
    clamp_angle: ClampAngle = "0",
    clamp_compliance: ClampCompliance = None,
    clamp_stiffness: ClampStiffness = None,
    curvature: Curvature = "0",
    stage_angle: StageAngle = "0",
    output: AlsoOut = None,
    picture: Picture = None,
) -> None:
    """One rod on one surface: onset of slip, clamp reactions and largest strain.

    A tip that locks is a result, too: its status says so. The exit code is 1 if nothing can be
    computed, 2 after a mistake in the input.
    """
    check_files(output, picture)
    whisker = sensor.Whisker.read(
        theta,
        eta,
        contact=contact,
        modulus=modulus,
        diameter=diameter,
        length=length,
        clamp_angle=clamp_angle,
        clamp_compliance=clamp_compliance,
        clamp_stiffness=clamp_stiffness,
        curvature=curvature,
        stage_angle=stage_angle,
    )
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
