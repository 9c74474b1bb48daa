"""The options of a whisker, which several commands have: its rod, height, contact and mounting."""

import inspect
from collections.abc import Callable
from functools import wraps
from typing import Annotated, Any

import typer

from vibrissa.cli.options import Modulus, Section, Touch
from vibrissa.outcomes import Contact, RodSection
from vibrissa.sensor import Whisker

Theta = Annotated[float, typer.Option(help="Taper: base over tip diameter, at least 1.")]
Eta = Annotated[str, typer.Option(help="Height of the surface above the clamp: 0.85, or '85 mm'.")]
Diameter = Annotated[str | None, typer.Option(help="Diameter of the rod at the clamp: '1 mm'.")]
Length = Annotated[str | None, typer.Option(help="Length of the rod: '100 mm'.")]
ClampAngle = Annotated[
    str,
    typer.Option(
        help="Inclination of the clamp: '2 deg', or in rad; positive where the rod leans back."
    ),
]
ClampCompliance = Annotated[
    str | None,
    typer.Option(help="Turn of the clamp per moment: '0.05 rad/(N*m)', or in L/(E*I0)."),
]
ClampStiffness = Annotated[
    str | None, typer.Option(help="Its inverse: '20 N*m/rad'. Without either the clamp is rigid.")
]
Curvature = Annotated[
    str,
    typer.Option(
        help="Natural curvature of the rod: '-2 m^-1', or in 1/L; negative where the rod turns "
        "away from the surface. 'a, b, c' are the coefficients of the powers of s, in units of L."
    ),
]
StageAngle = Annotated[
    str,
    typer.Option(
        help="Angle of the stage to the surface: '1 deg', or in rad; positive where it approaches."
    ),
]


def read_whisker(
    *,
    theta: Theta,
    eta: Eta,
    contact: Touch = Contact.POINT,
    section: Section = RodSection.ROUND,
    modulus: Modulus = None,
    diameter: Diameter = None,
    length: Length = None,
    clamp_angle: ClampAngle = "0",
    clamp_compliance: ClampCompliance = None,
    clamp_stiffness: ClampStiffness = None,
    curvature: Curvature = "0",
    stage_angle: StageAngle = "0",
) -> Whisker:
    """Read a whisker from the options of a command."""
    return Whisker.read(**locals())


def takes_whisker(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the options of `read_whisker` in place of its parameter ``whisker``.

    Parameters
    ----------
    command : callable

    Returns
    -------
    callable
    """
    parameters = dict(inspect.signature(command).parameters)
    options = inspect.signature(read_whisker).parameters

    @wraps(command)
    def run(**values: Any) -> None:
        whisker = read_whisker(**{name: values.pop(name) for name in options})
        command(whisker=whisker, **values)

    # Typer reads the options of a command from its signature and its annotations.
    del parameters["whisker"]
    own = {n: p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for n, p in parameters.items()}
    every = {**options, **own}
    run.__dict__["__signature__"] = inspect.Signature(list(every.values()))
    run.__annotations__ = {name: option.annotation for name, option in every.items()}
    return run
