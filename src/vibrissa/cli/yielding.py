"""A warning where a rod is bent beyond what its material bears."""

import typer

from vibrissa.design import Material
from vibrissa.sensor.quantities import Kind
from vibrissa.sensor.strain import yields
from vibrissa.sensor.whisker import Whisker


def warn_of_yield(whisker: Whisker, end: float, material: Material | None) -> None:
    """Warn if the rod yields in a period of sticking: at which place, and from which x0 on.

    Parameters
    ----------
    end : float
        Largest displacement x0 of a period (L).
    material : Material or None
        None if it is not known.
    """
    if whisker.rod is None or material is None or not end > 0.0:
        return
    slenderness = whisker.rod.base_diameter / whisker.rod.length
    found = yields(whisker.curve, end, material.yield_strain / slenderness)
    if found is None:
        return
    place, x0 = (whisker.units.spelled(one, Kind.LENGTH, 3) for one in (found.place, found.x0))
    typer.echo(
        f"warning: the rod yields from x0 = {x0} on: its strain reaches "
        f"{found.strain * slenderness:.2%} at {place} from the clamp, and {material.name} is "
        f"elastic up to {material.yield_strain:.2%}. Take a thinner or a longer rod.",
        err=True,
    )
