"""``vibrissa prove``: an onset of slip, or the critical friction coefficient, as a theorem."""

from typing import Annotated

import typer

from vibrissa.cli.options import ALONE, Touch
from vibrissa.errors import ArgumentError
from vibrissa.outcomes import Contact

app = typer.Typer(**ALONE)


@app.command(epilog="Example: `vibrissa prove --theta 2 --mu0 0.4 --eta 0.85`")
def prove(
    theta: Annotated[str, typer.Option(help="Taper: base over tip diameter, at least 1.")],
    eta: Annotated[str, typer.Option(help="Height of the surface above the clamp, in L.")],
    mu0: Annotated[
        str | None,
        typer.Option(help="Coefficient of static friction; without it mu_lock is proved."),
    ] = None,
    contact: Touch = Contact.POINT,
    first: Annotated[
        bool,
        typer.Option(
            "--first",
            help="Prove, too, that no other onset, or maximum, comes before; ten times as long.",
        ),
    ] = False,
) -> None:
    """Prove where one rod slips, or its mu_lock, with an enclosure for each number.

    `0.25 ± 3E-20` means that the true value is not further than 3E-20 from 0.25. The options are
    exact decimals. Needs `pip install 'vibrissa[proof]'`. The exit code is 2 if there is no proof.
    """
    from vibrissa import proof

    found: proof.ProvedOnset | proof.ProvedLock
    if mu0 is None:
        if contact is not Contact.POINT:
            raise ArgumentError("mu_lock is proved in tip contact alone; give --mu0")
        found = proof.lock(theta, eta, first=first)
        typer.echo("Proved: there is a state in which -tan(alpha) is stationary, the only such one")
        typer.echo("near its load, and its numbers lie in these intervals.")
    else:
        found = proof.onset(theta, mu0, eta, contact=contact, first=first)
        typer.echo("Proved: there is a state with alpha = 0 and one with -tan(alpha) = mu0,")
        typer.echo("each the only one near its load, and their numbers lie in these intervals.")
    for name, ball in found.columns().items():
        typer.echo(f"{name:<18} {proof.spelled(ball)}")
    _tell("bent once at alpha = 0, m < 0 along the rod", found.init.bent_once())
    if found.first is not None:
        what = "maximum of -tan(alpha)" if mu0 is None else "onset"
        _tell(f"first {what} on the path from there", found.first)


def _tell(what: str, proved: bool) -> None:
    typer.echo(f"{what}: {'proved' if proved else 'not proved'}")
