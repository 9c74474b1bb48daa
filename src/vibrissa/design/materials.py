"""Materials of rods: stiffness, and the strain up to which they stay elastic.

That is the yield strain of metals, the beginning of the plateau of superelastic metals, the
proportional limit of polymers, and fracture of brittle materials.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Self

from vibrissa.errors import ArgumentError
from vibrissa.sensor.cards import is_card, read_card
from vibrissa.sensor.quantities import Kind, Units, in_si
from vibrissa.sensor.setup import Setup

# A modulus that was measured is that of a material up to this factor.
OTHER = 1.5
# A rod of which the modulus alone is known is made of a material whose modulus differs less.
ALIKE = 0.1


@dataclass(frozen=True)
class Material:
    """A material.

    Attributes
    ----------
    name, source : str
        Description, and the source of the values.
    modulus : float
        Young's modulus (Pa).
    yield_strain : float
        Strain up to which it is linear and elastic.
    density : float or None
        In kg/m³.
    """

    name: str
    source: str
    modulus: float
    yield_strain: float
    density: float | None

    def __post_init__(self) -> None:
        """Refuse values that no material has."""
        for name in ("modulus", "yield_strain", "density"):
            value = getattr(self, name)
            if value is not None and not 0.0 < value < float("inf"):
                raise ArgumentError(
                    f"{name} of a material must be positive and finite, got {value!r}"
                )

    @classmethod
    def read(cls, card: Mapping[str, str], name: str, where: str) -> Self:
        """Read a material from the texts of a file."""
        strain = Units().read(card["yield_strain"], Kind.NUMBER, f"{where}: yield_strain")
        return cls(
            name=card.get("name", name),
            source=card.get("source", where),
            modulus=float(in_si(card["modulus"], Kind.STRESS, f"{where}: modulus")),
            yield_strain=float(strain),
            density=float(in_si(card["density"], Kind.DENSITY, f"{where}: density")),
        )

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
                f"({self.modulus / 1e9:.4g} GPa): give the material, or its modulus and yield "
                "strain"
            )
        return replace(
            self, modulus=modulus, yield_strain=self.yield_strain * self.modulus / modulus
        )


_FILE = Path(__file__).with_name("materials.toml")
MATERIALS = {
    name: Material.read(card, name, _FILE.name)
    for name, card in tomllib.loads(_FILE.read_text(encoding="utf-8")).items()
}


def material(name: str) -> Material:
    """Look up a material by its name, or read a file of one's own: ``"my.toml"``.

    Raises
    ------
    ArgumentError
        If there is no such material or file.
    """
    if is_card(name):
        path = Path(name)
        keys = ("modulus", "yield_strain", "density")
        return Material.read(read_card(path, keys, ("name", "source")), path.stem, name)
    if name.lower() not in MATERIALS:
        raise ArgumentError(
            f"material must be one of {', '.join(MATERIALS)}, or a file .toml, got {name!r}"
        )
    return MATERIALS[name.lower()]


def stated_material(setup: Setup) -> Material | None:
    """Give the material that a set-up names, or whose modulus and yield strain it states.

    A stated modulus or density takes the place of that of a named material.

    Raises
    ------
    ArgumentError
        If both are given, or the modulus is not that of the material.
    """
    modulus, density = setup.in_si("modulus"), setup.in_si("density")
    if setup.material is None:
        if modulus is None or setup.yield_strain is None:
            return None
        return Material("its material", "", modulus, setup.yield_strain, density)
    if setup.yield_strain is not None:
        raise ArgumentError("give the material or its yield strain, not both")
    found = material(setup.material)
    found = found if modulus is None else found.with_modulus(modulus)
    return found if density is None else replace(found, density=density)


def likely_material(setup: Setup) -> Material | None:
    """Give the stated material, or else the strongest one with the modulus that is stated."""
    found = stated_material(setup)
    modulus = setup.in_si("modulus")
    if found is not None or modulus is None:
        return found
    alike = [one for one in MATERIALS.values() if abs(one.modulus / modulus - 1.0) < ALIKE]
    strongest = max(alike, key=lambda one: one.yield_strain, default=None)
    return strongest and replace(strongest, name=f"even {strongest.name}")
