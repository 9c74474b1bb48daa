"""The options of a design: what a rod is to measure, with what, and within which limits."""

from inspect import signature
from typing import Annotated, Any

import typer

from vibrissa.cli.options import reading_options
from vibrissa.cli.setup import ROD, SIGNALS, Rod, Tolerances, read_pairs, setup_option
from vibrissa.design.materials import MATERIALS
from vibrissa.design.requirements import Requirements
from vibrissa.sensor.tolerances import EXACT

TASK, LIMITS = "Task", "Limits"


def _option(text: str, metavar: str, panel: str, default: str | bool = True, name: str = "") -> Any:
    names = (name,) if name else ()
    return typer.Option(
        *names, help=text, metavar=f"<{metavar}>", rich_help_panel=panel, show_default=default
    )


def _chosen(what: str, default: str) -> Any:
    """Describe an option that is a value, a list or a range."""
    return _option(f"{what}: a value, a list or a range.", "range", ROD, default)


def _default(name: str) -> Any:
    """Look up the default of a requirement."""
    return Requirements.model_fields[name].default


def read_options(
    *,
    step: Annotated[str, _option("Step of the stage: '20 um'.", "length", TASK)],
    mu0: Annotated[
        str, _option("Friction coefficients to be measured: '0.2 to 0.4'.", "range", TASK)
    ],
    material: Annotated[
        str | None, _option(f"Material: {', '.join(MATERIALS)}, or a file .toml.", "name", ROD)
    ] = None,
    modulus: Annotated[str | None, setup_option("modulus", ROD)] = None,
    yield_strain: Annotated[
        float | None,
        _option("Strain up to which the material is elastic.", "number", ROD),
    ] = None,
    density: Annotated[str | None, setup_option("density", ROD)] = None,
    transducer: Annotated[str | None, setup_option("transducer", SIGNALS)] = None,
    noise: Annotated[str | None, setup_option("noise", SIGNALS)] = None,
    range_: Annotated[
        str | None,
        _option(
            "Largest force_x, force_y and moment_z that are measured, without a transducer.",
            "list",
            SIGNALS,
            name="--range",
        ),
    ] = None,
    theta: Annotated[str | None, _chosen("Taper", "1 to 10, as it is turned")] = None,
    eta: Annotated[
        str | None,
        _chosen("Height in units of the length, or '85 mm'", "0.5 to 0.98"),
    ] = None,
    diameter: Annotated[
        str | None, _chosen("Diameter at the clamp", "0.1 to 10 mm, as it is sold")
    ] = None,
    length: Annotated[str | None, _chosen("Length of the rod", "20 to 200 mm")] = None,
    tip: Annotated[
        str | None,
        _option("Least diameter of the tip.", "length", LIMITS, default="0.1 mm"),
    ] = None,
    safety: Annotated[
        float, _option("Least ratio of yield strain to largest strain.", "number", LIMITS)
    ] = _default("safety"),
    lock_factor: Annotated[
        float, _option("Least ratio of mu_lock to the largest mu0.", "number", LIMITS)
    ] = _default("lock_factor"),
    steps: Annotated[
        float, _option("Least number of steps in a period of sticking.", "number", LIMITS)
    ] = _default("steps"),
    weight: Annotated[
        float, _option("Largest ratio of the rod's weight to the normal force.", "number", LIMITS)
    ] = _default("weight"),
    load: Annotated[
        float, _option("Largest part of the transducer's range that is used.", "number", LIMITS)
    ] = _default("load"),
    spacing: Annotated[
        str | None,
        _option("Largest clamp travel between two measurements: '5 mm'.", "length", LIMITS),
    ] = None,
    contact: Annotated[str | None, setup_option("contact", ROD)] = None,
    rod: Rod = None,
    tolerances: Tolerances = None,
) -> Requirements:
    """Read requirements from the options of a command and its set-up file."""
    asked: dict[str, Any] = {**locals(), "range": range_, "assume": EXACT not in (tolerances or ())}
    del asked["range_"], asked["rod"]
    sizes = [text for text in tolerances or () if text != EXACT]
    asked["tolerances"] = read_pairs(sizes, "--tolerance")
    return Requirements.read(rod, **asked)


takes_requirements = reading_options(
    "requirements", [*signature(read_options).parameters.values()], read_options
)
