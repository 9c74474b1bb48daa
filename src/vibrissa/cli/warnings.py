"""Warnings if a rod yields, or passes through the surface."""

from typing import TYPE_CHECKING

from vibrissa.cli.screen import say
from vibrissa.errors import ArgumentError
from vibrissa.outcomes import Contact
from vibrissa.quantities.units import Kind, Measured
from vibrissa.sensor.onset import largest_strain
from vibrissa.sensor.setup import Setup
from vibrissa.sensor.whisker import Whisker

if TYPE_CHECKING:
    from vibrissa.design.materials import Material


def material_of(setup: Setup) -> "Material | None":
    """Return the likely material of a rod; None if no modulus is stated or no preset is similar.

    Raises
    ------
    ArgumentError
        If a material is stated without a modulus, or if there is no such material.
    """
    if setup.modulus is not None:
        # The package `design` takes a second to load.
        from vibrissa.design.materials import likely_material

        return likely_material(setup)
    if setup.material is not None:
        raise ArgumentError("with a material, give modulus, diameter and length of the rod")
    return None


def with_modulus(setup: Setup) -> Setup:
    """Return the set-up with the modulus of its material, if it states a size but no modulus.

    Raises
    ------
    ArgumentError
        If there is no such material.
    """
    if setup.material is None or setup.modulus or not (setup.diameter or setup.length):
        return setup
    from vibrissa.design.materials import MATERIALS, Material

    modulus = Material.named(setup.material, MATERIALS).modulus
    return setup.model_copy(update={"modulus": Measured(f"{modulus:g} Pa")})


def density_of(setup: Setup, material: "Material | None") -> float | None:
    """Return the density that is stated, or that of the stated material (kg/m³); else None."""
    stated = setup.in_si("density")
    if stated is not None or setup.material is None or material is None:
        return stated
    return material.density


def warn(whisker: Whisker, end: float, material: "Material | None", begin: float = 0.0) -> None:
    """Warn if the rod passes through the surface or yields in a period of sticking.

    Parameters
    ----------
    begin, end : float
        Least and largest displacement x0 of the periods (L); `end` is NaN if it is not known.
        Displacements beyond the ends of the whisker's sticking curve are cut off there.
    material : Material or None
        None if the material is unknown.
    """
    touch = whisker.curve.x0_touch
    if whisker.contact == Contact.POINT and touch <= end:
        say(
            f"warning: from x0 = {whisker.units.spelled(touch, Kind.LENGTH, 3)} on the rod passes "
            "through the surface; give --contact line, in which it lies down.",
            err=True,
        )
    if whisker.rod is None or material is None or not end >= 0.0:
        return
    curve = whisker.response.curve if begin < 0.0 else whisker.curve
    most = largest_strain(curve, min(end, curve.x0_end), max(begin, curve.x0_pull))
    # The yield strain is that of the material at the clamp: elsewhere the stress decides.
    strain = float(most.stress[0]) * whisker.units.unit(Kind.STRAIN)
    if strain > material.yield_strain:
        place = whisker.units.spelled(float(most.place[0]), Kind.LENGTH, 3)
        say(
            f"warning: the rod yields: its strain reaches {strain:.2%} at {place} from the clamp, "
            f"and {material.name} is elastic up to {material.yield_strain:.2%}. Take a thinner or "
            "a longer rod.",
            err=True,
        )
