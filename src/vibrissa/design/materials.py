"""Materials of rods: Young's modulus, and the yield strain, up to which they are linear elastic.

The yield strain of a superelastic metal is the start of its plateau, that of a polymer the
proportional limit, and that of a brittle material the strain at fracture.
"""

from pathlib import Path
from typing import Annotated, Self

from vibrissa.errors import ArgumentError
from vibrissa.quantities.keys import Card, Positive, Presets
from vibrissa.quantities.units import Kind
from vibrissa.sensor.setup import Setup

# A measured modulus may differ from that of the named material by less than this factor.
OTHER = 1.5
# Without a named material, its modulus may differ from the measured one by less than this part.
ALIKE = 0.1


class Material(Card):
    """A linear elastic material, in SI units.

    Attributes
    ----------
    modulus : float
        Young's modulus (Pa).
    yield_strain : float
        Strain up to which the material is linear elastic.
    density : float or None
        Density (kg/m³).
    largest : float or None
        Largest diameter of which the yield strain is known (m).
    """

    modulus: Annotated[Positive, Kind.STRESS]
    yield_strain: Positive
    density: Annotated[Positive | None, Kind.DENSITY] = None
    largest: Annotated[Positive | None, Kind.LENGTH] = None

    def with_modulus(self, modulus: float) -> Self:
        """Return a copy with a measured modulus and the same yield stress.

        Raises
        ------
        ArgumentError
            If the two moduli differ by a factor of 1.5 or more.
        """
        if not 1.0 / OTHER < modulus / self.modulus < OTHER:
            raise ArgumentError(
                f"modulus = {modulus / 1e9:.4g} GPa is far from {self.modulus / 1e9:.4g} GPa, that "
                f"of {self.name!r}: leave out modulus, or give modulus and yield_strain instead of "
                "the material"
            )
        strain = self.yield_strain * self.modulus / modulus
        return self.model_copy(update={"modulus": modulus, "yield_strain": strain})


MATERIALS = Presets(Material, Path(__file__).with_name("materials.toml"))
"""Materials by name, such as ``music-wire``."""


def stated_material(setup: Setup) -> Material | None:
    """Return the material that a set-up names or gives by modulus and yield strain; else None.

    A stated modulus or density replaces that of the named material.

    Raises
    ------
    ArgumentError
        If both a material and a yield strain are stated, or the modulus does not fit the material.
    """
    modulus = setup.in_si("modulus")
    density = setup.in_si("density")
    stated = {} if density is None else {"density": density}
    if setup.material is None:
        if modulus is None or setup.yield_strain is None:
            return None
        stated |= {"modulus": modulus, "yield_strain": setup.yield_strain}
        return Material.validated({"name": "its material", "source": "", **stated})
    if setup.yield_strain is not None:
        raise ArgumentError("give the material or its yield strain, not both")
    material = Material.named(setup.material, MATERIALS)
    material = material if modulus is None else material.with_modulus(modulus)
    return Material.validated(dict(material) | stated)


def likely_material(setup: Setup) -> Material | None:
    """Return the stated material, or a preset of similar modulus; None if there is neither.

    Of several presets, the one with the largest yield strain is returned.
    """
    stated = stated_material(setup)
    modulus = setup.in_si("modulus")
    if stated is not None or modulus is None:
        return stated
    alike = [
        material for material in MATERIALS.values() if abs(material.modulus / modulus - 1.0) < ALIKE
    ]
    strongest = max(alike, key=lambda material: material.yield_strain, default=None)
    return strongest and strongest.model_copy(update={"name": f"even {strongest.name}"})
