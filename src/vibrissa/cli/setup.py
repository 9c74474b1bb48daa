"""Options that describe a set-up: those that are typed often, and ``--set`` for the others."""

from collections.abc import Callable, Sequence
from inspect import Parameter
from pathlib import Path
from typing import Annotated, Any

import typer

from vibrissa.cli.options import reading_options
from vibrissa.errors import ArgumentError
from vibrissa.outcomes import Contact
from vibrissa.sensor.quantities import Kind
from vibrissa.sensor.setup import TOLERANCES, Setup
from vibrissa.sensor.tolerances import EXACT
from vibrissa.sensor.whisker import Whisker

ROD, MOUNTING, SIGNALS = "Rod", "Mounting", "Signals"
# Keys of a set-up that are options, with the panel in which `--help` shows them.
COMMON = {
    "theta": ROD,
    "eta": ROD,
    "modulus": ROD,
    "diameter": ROD,
    "length": ROD,
    "contact": ROD,
    "clamp_angle": MOUNTING,
    "stage_angle": MOUNTING,
}
# Options of some commands.
FURTHER = {"material": ROD, "transducer": SIGNALS, "noise": SIGNALS}
OTHERS = tuple(name for name in Setup.model_fields if name not in (*COMMON, TOLERANCES, "assume"))

Rod = Annotated[
    Path | None,
    typer.Option(
        "--rod",
        help="Set-up file (.toml). An option takes the place of what stands in it.",
        metavar="<file>",
        rich_help_panel=ROD,
    ),
]
Assignments = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        help=f"Another key of a set-up file; repeat it. {', '.join(OTHERS)}.",
        metavar="<name>=<value>",
        rich_help_panel=MOUNTING,
    ),
]
Tolerances = Annotated[
    list[str] | None,
    typer.Option(
        "--tolerance",
        help="Standard deviation of a quantity: 'modulus=2 %', 'theta=exact'; repeat it. 'exact' "
        "alone: every quantity without a stated tolerance is exact.",
        metavar="<name>=<size>",
        rich_help_panel=SIGNALS,
    ),
]


def setup_option(name: str, panel: str) -> Any:
    """Describe an option by the field of the set-up of that name."""
    field = Setup.model_fields[name]
    other = "list" if name == "noise" else "name"
    kind = next((each for each in field.metadata if isinstance(each, Kind)), other)
    metavar = "|".join(Contact) if field.annotation is Contact else f"<{kind}>"
    return typer.Option(help=field.description, metavar=metavar, rich_help_panel=panel)


def takes_setup(*further: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Give a command the options of a set-up in place of its parameter ``setup``.

    Parameters
    ----------
    *further : str
        Keys of `FURTHER`, or ``tolerances``, that are options of this command.
    """
    panels = COMMON | {name: FURTHER[name] for name in further if name != TOLERANCES}
    types: dict[str, Any] = {"rod": Rod, "assignments": Assignments}
    for name, panel in panels.items():
        types[name] = Annotated[str | None, setup_option(name, panel)]
    if TOLERANCES in further:
        types[TOLERANCES] = Tolerances
    options = [
        Parameter(name, Parameter.KEYWORD_ONLY, default=None, annotation=annotation)
        for name, annotation in types.items()
    ]
    return reading_options("setup", options, read_setup)


def read_setup(
    rod: Path | None = None,
    assignments: Sequence[str] | None = None,
    tolerances: Sequence[str] | None = None,
    **options: Any,
) -> Setup:
    """Read a set-up from the options of a command and its set-up file."""
    given = {name: value for name, value in options.items() if value is not None}
    for name, value in read_pairs(assignments or (), "--set").items():
        if name in given:
            raise ArgumentError(f"{name} is given twice: as an option and with --set")
        given[name] = value
    sizes = [text for text in tolerances or () if text != EXACT]
    given[TOLERANCES] = read_pairs(sizes, "--tolerance")
    if EXACT in (tolerances or ()):
        given["assume"] = False
    return Setup.read(rod, **given)


def read_pairs(given: Sequence[str], option: str) -> dict[str, str]:
    """Read ``name=value`` of each.

    Raises
    ------
    ArgumentError
    """
    pairs: dict[str, str] = {}
    for text in given:
        name, _, value = (part.strip() for part in text.partition("="))
        if not (name and value):
            raise ArgumentError(f"{option} needs name=value, got {text!r}")
        if name in pairs:
            raise ArgumentError(f"{option} {name} is given twice")
        pairs[name] = value
    return pairs


def say_exact(whisker: Whisker, command: str) -> None:
    """Say that a command does not use the tolerances, if there are any."""
    if whisker.tolerances:
        names = ", ".join(whisker.tolerances)
        typer.echo(f"{command} does not use the tolerances of {names}", err=True)
