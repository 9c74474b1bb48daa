"""``vibrissa solve``: one rod on one surface."""

from typing import Annotated

import typer

from vibrissa import sensor
from vibrissa.cli.options import SETUP, Out, command, hand_out, option
from vibrissa.cli.warnings import density_of, material_of, warn, with_modulus
from vibrissa.outcomes import Status
from vibrissa.sensor import Setup

EXAMPLE = "Example: `vibrissa solve --theta 2 --eta 0.85 --mu0 0.4 --step 0.001`"


@command(SETUP, EXAMPLE)
def solve(
    setup: Setup,
    mu0: Annotated[str, option("Coefficient of static friction.", "Task")],
    step: Annotated[str | None, option("Step of the stage: '20 um'.", "Task")] = None,
    output: Out = None,
) -> None:
    """One rod on one surface: onset of slip, clamp reactions and largest strain.

    With a material or a density, also the natural frequencies of the rod while its tip sticks.

    Self-locking is a result, too: its status is `lock`. The exit code is 1 if nothing can be
    computed, 2 after an error in the input.
    """
    setup = with_modulus(setup)
    whisker, material = setup.whisker, material_of(setup)
    found = sensor.solve(whisker, mu0, step, density_of(setup, material))
    hand_out(found, str(found), output)
    if found.onset.status in (Status.FAILED, Status.OUT_OF_REACH):
        raise typer.Exit(1)
    warn(whisker, found.onset.x0_slip, material)
