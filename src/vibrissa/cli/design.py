"""``vibrissa design``: the rod that measures friction best."""

from typing import Annotated, Any

import typer

from vibrissa.cli.options import (
    ALONE,
    AlsoOut,
    Modulus,
    Picture,
    ReadFrom,
    Touch,
    Transducer,
    check_files,
    progress_bars,
    save_picture,
)
from vibrissa.design import MATERIALS, DesignStatus, Requirements, read_requirements
from vibrissa.design import design as find_design
from vibrissa.errors import ArgumentError
from vibrissa.outcomes import Contact
from vibrissa.sensor import Method, series

app = typer.Typer(**ALONE)


def _ranged(what: str, ends: tuple[float, float], unit: float = 1.0, name: str = "") -> Any:
    """Set up an option that is a value or a range."""
    low, high = ends
    default = f"{low / unit:g} to {high / unit:g}{name}"
    return typer.Option(help=f"{what}: a value or a range.", show_default=default)


@app.command(
    epilog="Examples: `vibrissa design --material music-wire --transducer nano17-si-12-0.12 --step "
    "'50 um' --mu0 '0.2 to 0.4'`; a rod that is given is checked: `vibrissa design --material "
    "steel-s235 --diameter '5 mm' --length '100 mm' --theta 2 --eta 0.85 --transducer "
    "nano17-si-12-0.12 --step '50 um' --mu0 '0.2 to 0.4'`",
)
def design(
    step: Annotated[str, typer.Option(help="Step of the stage: '20 um'.")],
    mu0: Annotated[str, typer.Option(help="Friction coefficients to be measured: '0.2 to 0.4'.")],
    material: Annotated[
        str | None, typer.Option(help=f"Material of the rod: {', '.join(MATERIALS)}.")
    ] = None,
    modulus: Modulus = None,
    yield_strain: Annotated[
        float | None,
        typer.Option(
            help="Strain up to which the material is elastic; in units of d0/L without a modulus."
        ),
    ] = None,
    density: Annotated[
        str | None, typer.Option(help="Density of the material: '7800 kg/m^3'.")
    ] = None,
    transducer: Transducer = None,
    noise: Annotated[
        str | None,
        typer.Option(
            help="Standard deviation of one reading of force_x, force_y and moment_z, if there is "
            "no transducer: '3 mN, 3 mN, 10 uN*m'."
        ),
    ] = None,
    range_: Annotated[
        str | None,
        typer.Option(
            "--range",
            help="Largest force_x, force_y and moment_z that are measured, if there is no "
            "transducer.",
        ),
    ] = None,
    method: ReadFrom = Method.FORCES,
    theta: Annotated[str | None, _ranged("Taper", Requirements.theta)] = None,
    eta: Annotated[
        str | None,
        _ranged("Height of the surface in units of the length, or '85 mm'", Requirements.eta),
    ] = None,
    diameter: Annotated[
        str | None, _ranged("Diameter at the clamp", Requirements.diameter, 1e-3, " mm")
    ] = None,
    length: Annotated[
        str | None, _ranged("Length of the rod", Requirements.length, 1e-3, " mm")
    ] = None,
    tip: Annotated[
        str | None,
        typer.Option(
            help="Least diameter of the tip.", show_default=f"{Requirements.tip * 1e3:g} mm"
        ),
    ] = None,
    safety: Annotated[
        float, typer.Option(help="Least ratio of the yield strain to the largest strain.")
    ] = Requirements.safety,
    lock_factor: Annotated[
        float,
        typer.Option(help="Least ratio of the critical friction coefficient to the largest mu0."),
    ] = Requirements.lock_factor,
    steps: Annotated[
        float, typer.Option(help="Least number of steps of the stage in a period of sticking.")
    ] = Requirements.steps,
    weight: Annotated[
        float, typer.Option(help="Largest ratio of the weight of the rod to the normal force.")
    ] = Requirements.weight,
    spacing: Annotated[
        str | None,
        typer.Option(help="Largest clamp travel between two measurements: '5 mm'."),
    ] = None,
    contact: Touch = Contact.POINT,
    output: AlsoOut = None,
    picture: Picture = None,
) -> None:
    """Find the rod that measures friction best, and say what limits it.

    Chooses taper, height, diameter and length. The best rod has the smallest standard deviation of
    mu0 from one period of sticking, at that mu0 of the range where it is largest. It must not
    yield, its tip must not lock, a period must have enough steps, and the forces must be within the
    transducer's range. With one value each for `--theta`, `--eta`, `--diameter` and `--length` that
    rod is checked. Without a material and a modulus everything is nondimensional, and only theta
    and eta are chosen. If no rod keeps to all limits, the one that violates them least is shown,
    and the exit code is 1.
    """
    check_files(output, picture)
    requirements = read_requirements(
        material=material,
        modulus=modulus,
        yield_strain=yield_strain,
        density=density,
        transducer=transducer,
        noise=noise,
        range=range_,
        method=method,
        contact=contact,
        mu0=mu0,
        step=step,
        theta=theta,
        eta=eta,
        diameter=diameter,
        length=length,
        tip=tip,
        safety=safety,
        lock_factor=lock_factor,
        steps=steps,
        weight=weight,
        spacing=spacing,
    )
    found = find_design(requirements, progress_bars())
    if found.status is DesignStatus.FAILED:
        raise ArgumentError(found.message)
    typer.echo(found)
    if output is not None:
        series.write(output, found.columns())
    if picture is not None:
        save_picture(found.plot(), picture)
    if found.status is DesignStatus.NONE:
        raise typer.Exit(1)
