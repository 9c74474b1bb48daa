"""A warning where a rod is bent beyond what its material bears."""

import numpy as np
import typer

from vibrissa.design.materials import bears
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.quantities import Kind
from vibrissa.sensor.strain import yields
from vibrissa.sensor.whisker import Whisker


def warn_of_yield(
    whisker: Whisker, end: float, material: str | None = None, yield_strain: float | None = None
) -> None:
    """Warn where the rod yields in a period of sticking, and say where, and from which x0 on.

    Parameters
    ----------
    whisker : Whisker
        Without a rod of some size nothing is known.
    end : float
        Largest displacement x0 of a period (L).
    material : str, optional
        Name of its material; without it, and without a yield strain, it is taken to be the
        strongest of the known ones with such a modulus.
    yield_strain : float, optional
    """
    rod, units = whisker.rod, whisker.units
    if rod is None or not end > 0.0:
        return
    limit, name = bears(rod.youngs_modulus, material, yield_strain)
    slenderness = rod.base_diameter / rod.length
    found = yields(whisker.curve, end, limit / slenderness)
    if found is not None:
        place, x0 = (units.spelled(value, Kind.LENGTH, 3) for value in (found.place, found.x0))
        typer.echo(
            f"warning: the rod yields from x0 = {x0} on: its strain reaches "
            f"{found.strain * slenderness:.2%} at {place} from the clamp, and {name} is elastic "
            f"up to {limit:.2%}. Take a thinner or a longer rod.",
            err=True,
        )


def end_of(whisker: Whisker, mu0: FloatArray) -> float:
    """Where the longest of some periods ends (L): at the onset of slip, or where the tip locks."""
    known = mu0[np.isfinite(mu0)]
    if not len(known):
        return 0.0
    onset = float(whisker.curve.onset(known.max()))
    return onset if np.isfinite(onset) else whisker.curve.x0_lock
