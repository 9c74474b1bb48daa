"""``vibrissa design``: the rod that measures friction best."""

from pathlib import Path
from typing import Annotated

import typer

from vibrissa.cli.options import command, option
from vibrissa.design import DesignStatus, Requirements
from vibrissa.design import design as find_design
from vibrissa.quantities.keys import write_keys
from vibrissa.sensor.setup import TOLERANCES

PANELS = {
    "Task": ("step", "mu0", "speed"),
    "Rod": (
        "material",
        "modulus",
        "yield_strain",
        "density",
        "theta",
        "eta",
        "diameter",
        "length",
        "contact",
    ),
    "Signals": ("transducer", "noise", TOLERANCES),
    "Limits": ("tip", "safety", "steps", "load", "spacing"),
}
Out = Annotated[
    Path | None, option("Set-up file (.toml) to write: the best rod.", "Output", "--output", "-o")
]
EXAMPLES = (
    "Examples: `vibrissa design --material music-wire --transducer nano17-si-12-0.12 --step "
    "'50 um' --mu0 '0.2 to 0.4'`; to check a given rod: `vibrissa design --material "
    "steel-s235 --diameter '5 mm' --length '100 mm' --theta 2 --eta 0.85 --transducer "
    "nano17-si-12-0.12 --step '50 um' --mu0 '0.2 to 0.4'`"
)


@command(PANELS, EXAMPLES, endings=(".toml",))
def design(requirements: Requirements, output: Out = None) -> None:
    """Find the rod that measures friction best, and the constraints that limit it.

    Chooses taper, height, diameter and length among rods that can be bought, cut and turned. The
    best rod measures mu0 with the smallest uncertainty in one period of sticking. This uncertainty
    depends on mu0; the largest one in the range of mu0 counts. The rod must not yield, its tip
    must not lock, a period must have enough steps, and the loads must leave a margin of the
    transducer's range. Give one value each for `--theta`, `--eta`, `--diameter` and `--length` to
    check that rod. `-o rod.toml` writes the best rod as a set-up file. If no rod meets all
    constraints, the rod that violates them least is shown, and the exit code is 1.
    """
    found = find_design(requirements)
    typer.echo(str(found))
    if found.status is DesignStatus.NONE:
        if output is not None:
            typer.echo(f"{output} is not written: the rod violates constraints", err=True)
        raise typer.Exit(1)
    if output is not None:
        write_keys(output, found.best.setup.stated(), f"vibrissa design: {found.message}")
