"""Materials of rods: stiffness, and the strain up to which they stay elastic.

It is the yield strain of metals, the beginning of the plateau of superelastic metals, the
proportional limit of polymers, and fracture of brittle materials.
"""

from pathlib import Path
from typing import Annotated, Self

from vibrissa.errors import ArgumentError
from vibrissa.sensor.keys import Card, Positive
from vibrissa.sensor.quantities import Kind
from vibrissa.sensor.setup import Setup

# A modulus that was measured is that of a material up to this factor.
OTHER = 1.5
# A rod of which the modulus alone is known is made of a material whose modulus differs less.
ALIKE = 0.1


class Material(Card):
    """A material.

    Attributes
    ----------
    modulus : float
        Young's modulus (Pa).
    yield_strain : float
        Strain up to which the material is linear and elastic.
    density : float or None
        In kg/m³.
    """

    modulus: Annotated[Positive, Kind.STRESS]
    yield_strain: Positive
    density: Annotated[Positive | None, Kind.DENSITY] = None

    def with_modulus(self, modulus: float) -> Self:
        """Give the same material with a measured modulus; it yields at the same stress.

        Raises
        ------
        ArgumentError
            If the modulus is that of another material.
        """
        if not 1.0 / OTHER < modulus / self.modulus < OTHER:
            raise ArgumentError(
                f"modulus = {modulus / 1e9:.4g} GPa is not that of {self.name} "
                f"({self.modulus / 1e9:.4g} GPa): leave out modulus, or give modulus and "
                "yield_strain instead of the material"
            )
        strain = self.yield_strain * self.modulus / modulus
        return self.model_copy(update={"modulus": modulus, "yield_strain": strain})


MATERIALS = Material.presets(Path(__file__).with_name("materials.toml"))


def stated_material(setup: Setup) -> Material | None:
    """Give the material that a set-up names, or whose modulus and yield strain it states.

    A stated modulus or density takes the place of that of a named material.

    Raises
    ------
    ArgumentError
        If material and yield strain are given, or the modulus does not fit the material.
    """
    modulus, density = setup.in_si("modulus"), setup.in_si("density")
    stated = {} if density is None else {"density": density}
    if setup.material is None:
        if modulus is None or setup.yield_strain is None:
            return None
        stated |= {"modulus": modulus, "yield_strain": setup.yield_strain}
        return Material.validated({"name": "its material", "source": "", **stated})
    if setup.yield_strain is not None:
        raise ArgumentError("give the material or its yield strain, not both")
    found = Material.named(setup.material, MATERIALS)
    found = found if modulus is None else found.with_modulus(modulus)
    return Material.validated(dict(found) | stated)


def likely_material(setup: Setup) -> Material | None:
    """Give the stated material, or else the strongest one with about the stated modulus."""
    found = stated_material(setup)
    modulus = setup.in_si("modulus")
    if found is not None or modulus is None:
        return found
    alike = [one for one in MATERIALS.values() if abs(one.modulus / modulus - 1.0) < ALIKE]
    strongest = max(alike, key=lambda one: one.yield_strain, default=None)
    return strongest and strongest.model_copy(update={"name": f"even {strongest.name}"})
