"""The rods of a chunk, and their solution."""

from collections.abc import Mapping, Sequence
from functools import cache
from itertools import product
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from vibrissa.mechanics.mounting import Mounting
from vibrissa.outcomes import Contact, RodSection, Solver
from vibrissa.sticking.curve import StickingCurve
from vibrissa.study.axes import MOUNTING_AXES, Values

# Values of a rod by axis; dx0 is None where one solution serves all steps of the clamp.
RodAxes: TypeAlias = Mapping[str, Any]


class SolverSettings(NamedTuple):
    """What a study solves its rods with, and what it computes at each point of a grid or scan.

    Attributes
    ----------
    method : Solver
    contact : Contact
    section : RodSection
    frequencies : int
        Number of natural frequencies at each onset of slip, or at each step of a scan.
    """

    method: Solver
    contact: Contact
    section: RodSection
    frequencies: int = 0


def rods_of(axes: Mapping[str, Values], by_step: bool) -> list[RodAxes]:
    """List the rods of a chunk in the order of its rows; `by_step`: one rod for each Δx0."""
    order = ("eta", "theta", *MOUNTING_AXES, "dx0")
    values: list[Sequence[Any]] = [
        axes[axis] if by_step or axis != "dx0" else (None,) for axis in order
    ]
    return [dict(zip(order, one, strict=True)) for one in product(*values)]


def solve(
    rods: Sequence[RodAxes], solver: SolverSettings, retract: bool = False
) -> list[StickingCurve]:
    """Solve the equilibrium paths of some rods, and print the status of each.

    With `retract`, also the states in which the clamp is pulled back, as scans may need them.
    """
    # Only the solver in use is imported.
    if solver.method is Solver.COLLOCATION:
        from vibrissa.sticking.solving.collocation import solve_curves

        theta, eta = np.array([(rod["theta"], rod["eta"]) for rod in rods]).T
        # Rods with equal mountings share one object.
        mounted = cache(lambda *values: Mounting(**dict(zip(MOUNTING_AXES, values, strict=True))))
        mountings = [mounted(*(rod[axis] for axis in MOUNTING_AXES)) for rod in rods]
        curves = solve_curves(theta, eta, solver.contact, mountings, solver.section, retract)
    else:
        from vibrissa.sticking.solving.shooting import solve_curve

        curves = [
            solve_curve(rod["theta"], rod["eta"], rod["dx0"], section=solver.section)
            for rod in rods
        ]
    for rod, curve in zip(rods, curves, strict=True):
        shown = " ".join(f"{axis} {value}" for axis, value in rod.items() if value)
        print(f"{shown}: {curve.status}, residual {curve.residual:.1e} {curve.message}".rstrip())
    return curves
