"""A warning where a rod is bent beyond what its material bears."""

import numpy as np
import typer

from vibrissa.design import Material
from vibrissa.numerics.arrays import FloatArray
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
    if found is not None:
        place, x0 = (
            whisker.units.spelled(value, Kind.LENGTH, 3) for value in (found.place, found.x0)
        )
        typer.echo(
            f"warning: the rod yields from x0 = {x0} on: its strain reaches "
            f"{found.strain * slenderness:.2%} at {place} from the clamp, and {material.name} is "
            f"elastic up to {material.yield_strain:.2%}. Take a thinner or a longer rod.",
            err=True,
        )


def end_of(whisker: Whisker, mu0: FloatArray) -> float:
    """Where the longest of some periods ends (L): at the onset of slip, or where the tip locks."""
    known = mu0[np.isfinite(mu0)]
    if not len(known):
        return 0.0
    onset = float(whisker.curve.onset(known.max()))
    return onset if np.isfinite(onset) else whisker.curve.x0_lock
