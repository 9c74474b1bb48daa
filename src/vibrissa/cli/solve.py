"""``vibrissa solve``: one rod on one surface."""

from typing import Annotated

import typer

from vibrissa import sensor
from vibrissa.cli.options import SETUP, Out, command, hand_out, option
from vibrissa.errors import ArgumentError
from vibrissa.outcomes import Status
from vibrissa.sensor import Setup

EXAMPLE = "Example: `vibrissa solve --theta 2 --eta 0.85 --mu0 0.4 --step 0.001`"


@command("setup", Setup, SETUP, EXAMPLE)
def solve(
    setup: Setup,
    mu0: Annotated[str, option("Coefficient of static friction.", "Task")],
    step: Annotated[str | None, option("Step of the stage: '20 um'.", "Task")] = None,
    output: Out = None,
) -> None:
    """One rod on one surface: onset of slip, clamp reactions and largest strain.

    A tip that locks is a result, too: its status says so. The exit code is 1 if nothing can be
    computed, 2 after an error in the input.
    """
    found = sensor.solve(setup.whisker, mu0, step, _yield_strain(setup))
    nothing = found.onset.status in (Status.FAILED, Status.OUT_OF_REACH)
    hand_out(found, str(found), output)
    if nothing:
        raise typer.Exit(1)


def _yield_strain(setup: Setup) -> float | None:
    if setup.material is None:
        return setup.yield_strain
    if setup.whisker.rod is None:
        raise ArgumentError("with a material, give modulus, diameter and length of the rod")
    # What designs a rod takes a second to load.
    from vibrissa.design.materials import stated_material

    material = stated_material(setup)
    return None if material is None else material.yield_strain
