"""The options of a whisker, which several commands have: its rod, height, contact and mounting."""

import inspect
from collections.abc import Callable, Sequence
from functools import wraps
from pathlib import Path
from typing import Annotated, Any

import typer

from vibrissa.cli.options import MaybeSection, MaybeTouch, Modulus
from vibrissa.errors import ArgumentError
from vibrissa.sensor.given.rod_file import (
    OF_MATERIAL,
    OF_READING,
    TOLERANCES,
    RodFile,
    keys_of,
    with_options,
)
from vibrissa.sensor.given.tolerances import EXACT
from vibrissa.sensor.whisker import Whisker

RodOption = Annotated[
    Path | None,
    typer.Option(
        "--rod", help="Rod file (.toml) that holds the set-up; an option overrides what it says."
    ),
]
Theta = Annotated[
    str | None, typer.Option(help="Taper: base over tip diameter, at least 1. '2 ± 0.02'.")
]
Eta = Annotated[
    str | None,
    typer.Option(help="Height of the surface above the clamp: 0.85, '85 mm', '85 ± 0.1 mm'."),
]
Diameter = Annotated[str | None, typer.Option(help="Diameter of the rod at the clamp: '1 mm'.")]
Length = Annotated[str | None, typer.Option(help="Length of the rod: '100 mm'.")]
ClampAngle = Annotated[
    str | None,
    typer.Option(
        help="Inclination of the clamp: '2 deg', or in rad; positive where the rod leans back.",
        show_default="0",
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
    str | None,
    typer.Option(
        help="Natural curvature of the rod: '-2 m^-1', or in 1/L; negative where the rod turns "
        "away from the surface. 'a, b, c' are the coefficients of the powers of s, in units of L.",
        show_default="0",
    ),
]
StageAngle = Annotated[
    str | None,
    typer.Option(
        help="Angle of the stage to the surface: '1 deg', or in rad; positive where it approaches.",
        show_default="0",
    ),
]


Tolerances = Annotated[
    list[str] | None,
    typer.Option(
        "--tolerance",
        help="Standard deviation of something given, as in 'clamp_angle=0.5 deg', 'modulus=2 %', "
        "'theta=exact'; repeat it. 'exact' alone: of all that nothing is stated about.",
    ),
]


def read_setup(
    *,
    rod: RodOption = None,
    theta: Theta = None,
    eta: Eta = None,
    contact: MaybeTouch = None,
    section: MaybeSection = None,
    modulus: Modulus = None,
    diameter: Diameter = None,
    length: Length = None,
    clamp_angle: ClampAngle = None,
    clamp_compliance: ClampCompliance = None,
    clamp_stiffness: ClampStiffness = None,
    curvature: Curvature = None,
    stage_angle: StageAngle = None,
    **reading: Any,
) -> RodFile:
    """Read a set-up from the options of a command, and from its rod file."""
    options = {**locals(), **reading}
    del options["rod"], options["reading"]
    return RodFile.of(with_options({} if rod is None else keys_of(rod), options))


def read_pairs(given: Sequence[str]) -> dict[str, str]:
    """Read ``name=size`` of each tolerance."""
    pairs = [text.partition("=") for text in given]
    for text, (name, _, size) in zip(given, pairs, strict=True):
        if not (name.strip() and size.strip()):
            raise ArgumentError(f"a tolerance is given as name=size, got {text!r}")
    names = [name.strip() for name, _, _ in pairs]
    for name in names:
        if names.count(name) > 1:
            raise ArgumentError(f"the tolerance of {name} is given twice")
    return {name.strip(): size.strip() for name, _, size in pairs}


def takes_whisker(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the options of `read_setup` in place of its parameter ``whisker``.

    What else a rod file may hold, such as the transducer, goes to the command's own options.

    Parameters
    ----------
    command : callable
        Where its parameter may be None, theta and eta may be left out; then it is None, and the
        tolerances are given to the command as they are.

    Returns
    -------
    callable
    """
    parameters = dict(inspect.signature(command).parameters)
    options = dict(inspect.signature(read_setup).parameters)
    del options["reading"]
    own = [name for name in (*OF_READING, *OF_MATERIAL) if name in parameters]
    needless = parameters["whisker"].default is None

    @wraps(command)
    def run(**values: Any) -> None:
        if needless and values["rod"] is None and None in (values["theta"], values["eta"]):
            command(whisker=None, **{n: v for n, v in values.items() if n not in options})
            return
        asked = {name: values.pop(name) for name in options}
        asked |= {name: values[name] for name in own}
        if TOLERANCES in values:
            asked[TOLERANCES] = read_pairs(
                [text for text in values[TOLERANCES] or () if text != EXACT]
            )
        setup = read_setup(**asked)
        said = setup.reading | setup.material
        values |= {name: said.get(name) for name in own}
        command(whisker=setup.whisker, **values)

    # Typer reads the options of a command from its signature and its annotations.
    del parameters["whisker"]
    every = {n: p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for n, p in parameters.items()}
    every = {**options, **every}
    run.__dict__["__signature__"] = inspect.Signature(list(every.values()))
    run.__annotations__ = {name: option.annotation for name, option in every.items()}
    return run


def say_exact(whisker: Whisker, command: str) -> None:
    """Say that a command takes what is given as exact, if it has tolerances."""
    if whisker.tolerances:
        names = ", ".join(whisker.tolerances)
        typer.echo(f"{command} takes all as exact: no tolerance is used ({names})", err=True)
