"""A warning where a rod is bent beyond what its material bears."""

import numpy as np
import typer

from vibrissa.design.materials import bears
from vibrissa.errors import ArgumentError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.quantities import Kind
from vibrissa.sensor.strain import yields
from vibrissa.sensor.whisker import Whisker


def elastic_limit(
    whisker: Whisker, material: str | None, yield_strain: float | None
) -> tuple[float, str]:
    """Look up the strain up to which a rod is elastic, and of what it is that.

    Without a material and a yield strain it is that of the strongest known material with the
    modulus of the rod; infinite where the rod has no size.

    Raises
    ------
    ArgumentError
        If both are given, or the material is not one of the rod.
    """
    if material is not None and yield_strain is not None:
        raise ArgumentError("give the material or its yield strain, not both")
    if whisker.rod is None:
        return float("inf"), ""
    return bears(whisker.rod.youngs_modulus, material, yield_strain)


def warn_of_yield(whisker: Whisker, end: float, limit: tuple[float, str]) -> None:
    """Warn where the rod yields in a period of sticking, and say where, and from which x0 on.

    Parameters
    ----------
    whisker : Whisker
    end : float
        Largest displacement x0 of a period (L).
    limit : (float, str)
        As from `elastic_limit`.
    """
    strain, name = limit
    if whisker.rod is None or not end > 0.0 or strain == float("inf"):
        return
    slenderness = whisker.rod.base_diameter / whisker.rod.length
    found = yields(whisker.curve, end, strain / slenderness)
    if found is not None:
        place, x0 = (
            whisker.units.spelled(value, Kind.LENGTH, 3) for value in (found.place, found.x0)
        )
        typer.echo(
            f"warning: the rod yields from x0 = {x0} on: its strain reaches "
            f"{found.strain * slenderness:.2%} at {place} from the clamp, and {name} is elastic "
            f"up to {strain:.2%}. Take a thinner or a longer rod.",
            err=True,
        )


def end_of(whisker: Whisker, mu0: FloatArray) -> float:
    """Where the longest of some periods ends (L): at the onset of slip, or where the tip locks."""
    known = mu0[np.isfinite(mu0)]
    if not len(known):
        return 0.0
    onset = float(whisker.curve.onset(known.max()))
    return onset if np.isfinite(onset) else whisker.curve.x0_lock
