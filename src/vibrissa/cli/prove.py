"""``vibrissa prove``: an onset of slip as a theorem."""

from typing import Annotated

import typer

from vibrissa.cli.options import ALONE

app = typer.Typer(**ALONE)


@app.command(epilog="Example: `vibrissa prove --theta 2 --mu0 0.4 --eta 0.85`")
def prove(
    theta: Annotated[str, typer.Option(help="Taper: base over tip diameter, at least 1.")],
    mu0: Annotated[str, typer.Option(help="Coefficient of static friction.")],
    eta: Annotated[str, typer.Option(help="Height of the surface above the clamp, in L.")],
    first: Annotated[
        bool,
        typer.Option(
            "--first", help="Prove, too, that no other onset comes before; ten times as long."
        ),
    ] = False,
) -> None:
    """Prove where one rod slips, in tip contact, with an enclosure for each number.

    `0.25 ± 3E-20` means that the true value is not further than 3E-20 from 0.25. The options are
    exact decimals. Needs `pip install 'vibrissa[proof]'`. The exit code is 2 if there is no proof.
    """
    from vibrissa import proof

    found = proof.onset(theta, mu0, eta, first=first)
    typer.echo("Proved: there is a state with alpha = 0 and one with -tan(alpha) = mu0,")
    typer.echo("each the only one near its load, and their numbers lie in these intervals.")
    for name, ball in found.columns().items():
        typer.echo(f"{name:<18} {proof.spelled(ball)}")
    once = "m < 0 along the rod" if found.bent_once else "not proved"
    typer.echo(f"bent once at alpha = 0: {once}")
    if first:
        typer.echo(
            f"first onset on the path from there: {'proved' if found.first else 'not proved'}"
        )
