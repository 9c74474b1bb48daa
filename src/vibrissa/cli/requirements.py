"""The options of a design: what a rod is to measure, with what, and within which limits."""

import inspect
from collections.abc import Callable
from functools import wraps
from typing import Annotated, Any

import typer

from vibrissa.cli.options import MaybeTouch, Modulus, Transducer, check_not_read
from vibrissa.cli.whisker import RodOption, Tolerances, read_pairs
from vibrissa.design.materials import MATERIALS
from vibrissa.design.requirements import Requirements
from vibrissa.sensor.given.tolerances import EXACT


def _chosen(what: str, default: str) -> Any:
    """Set up an option that is a value, a list or a range."""
    return typer.Option(help=f"{what}: a value, a list or a range.", show_default=default)


def _default(name: str) -> Any:
    """Look up the default of a requirement."""
    return Requirements.model_fields[name].default


def read_options(
    *,
    step: Annotated[str, typer.Option(help="Step of the stage: '20 um'.")],
    mu0: Annotated[str, typer.Option(help="Friction coefficients to be measured: '0.2 to 0.4'.")],
    material: Annotated[
        str | None, typer.Option(help=f"Material of the rod: {', '.join(MATERIALS)}.")
    ] = None,
    modulus: Modulus = None,
    yield_strain: Annotated[
        float | None,
        typer.Option(help="Strain up to which the material is elastic."),
    ] = None,
    density: Annotated[
        str | None, typer.Option(help="Density of the material: '7800 kg/m^3'.")
    ] = None,
    transducer: Transducer = None,
    noise: Annotated[
        str | None,
        typer.Option(
            help="Standard deviation of one reading of force_x, force_y and moment_z, if there is "
            "no transducer: '3 mN, 3 mN, 10 uN*m'."
        ),
    ] = None,
    range_: Annotated[
        str | None,
        typer.Option(
            "--range",
            help="Largest force_x, force_y and moment_z that are measured, if there is no "
            "transducer.",
        ),
    ] = None,
    theta: Annotated[str | None, _chosen("Taper", "1 to 10, as it is turned")] = None,
    eta: Annotated[
        str | None,
        _chosen("Height of the surface in units of the length, or '85 mm'", "0.5 to 0.98"),
    ] = None,
    diameter: Annotated[
        str | None, _chosen("Diameter at the clamp", "0.1 to 10 mm, as it is sold")
    ] = None,
    length: Annotated[str | None, _chosen("Length of the rod", "20 to 200 mm")] = None,
    tip: Annotated[
        str | None,
        typer.Option(help="Least diameter of the tip.", show_default="0.1 mm"),
    ] = None,
    safety: Annotated[
        float, typer.Option(help="Least ratio of the yield strain to the largest strain.")
    ] = _default("safety"),
    lock_factor: Annotated[
        float,
        typer.Option(help="Least ratio of the critical friction coefficient to the largest mu0."),
    ] = _default("lock_factor"),
    steps: Annotated[
        float, typer.Option(help="Least number of steps of the stage in a period of sticking.")
    ] = _default("steps"),
    weight: Annotated[
        float, typer.Option(help="Largest ratio of the weight of the rod to the normal force.")
    ] = _default("weight"),
    load: Annotated[
        float, typer.Option(help="Largest part of the transducer's range that is used.")
    ] = _default("load"),
    spacing: Annotated[
        str | None,
        typer.Option(help="Largest clamp travel between two measurements: '5 mm'."),
    ] = None,
    contact: MaybeTouch = None,
    rod: RodOption = None,
    tolerances: Tolerances = None,
) -> Requirements:
    """Read requirements from the options of a command, and from its rod file."""
    asked: dict[str, Any] = {**locals(), "range": range_, "assume": EXACT not in (tolerances or ())}
    del asked["range_"], asked["rod"]
    asked["tolerances"] = read_pairs([text for text in tolerances or () if text != EXACT])
    return Requirements.read(rod, **asked)


def takes_requirements(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the options of `read_options` in place of its parameter ``requirements``.

    Parameters
    ----------
    command : callable

    Returns
    -------
    callable
    """
    options = inspect.signature(read_options).parameters
    own = dict(inspect.signature(command).parameters)
    del own["requirements"]

    @wraps(command)
    def run(**values: Any) -> None:
        read = (values[name] for name in ("rod", "material", "transducer"))
        check_not_read(values.get("output"), *read)
        requirements = read_options(**{name: values.pop(name) for name in options})
        command(requirements=requirements, **values)

    # Typer reads the options of a command from its signature and its annotations.
    every = [*options.values()]
    every += [option.replace(kind=inspect.Parameter.KEYWORD_ONLY) for option in own.values()]
    run.__dict__["__signature__"] = inspect.Signature(every)
    run.__annotations__ = {option.name: option.annotation for option in every}
    return run
