"""Materials of which a rod can be made: stiffness, and the strain up to which it stays elastic.

The rod of the model is linear elastic. So the yield strain is where linearity ends: the yield
stress over Young's modulus for metals, the beginning of the plateau for superelastic metals, the
proportional limit for polymers, and fracture for brittle materials.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

from vibrissa.errors import ArgumentError
from vibrissa.sensor.cards import is_card, read_card
from vibrissa.sensor.quantities import Kind, Units, in_si

# A modulus that was measured is that of a material up to this factor.
OTHER = 1.5
# A rod of which the modulus alone is known is made of a material whose modulus differs less.
ALIKE = 0.1


@dataclass(frozen=True, kw_only=True)
class Material:
    """A material.

    Attributes
    ----------
    name, source : str
        What it is and where its values are published.
    modulus : float
        Young's modulus (Pa).
    yield_strain : float
        Strain up to which it is linear and elastic.
    density : float
        In kg/m³.
    """

    name: str
    source: str
    modulus: float
    yield_strain: float
    density: float

    def __post_init__(self) -> None:
        """Refuse what no material has."""
        for name in ("modulus", "yield_strain", "density"):
            value = getattr(self, name)
            if not 0.0 < value < float("inf"):
                raise ArgumentError(
                    f"{name} of a material must be positive and finite, got {value!r}"
                )

    @classmethod
    def read(cls, card: Mapping[str, Any], name: str, where: str) -> Self:
        """Read a material from the texts of a file."""
        density = card["density"]
        if isinstance(density, str):
            density = float(in_si(density, Kind.DENSITY, f"{where}: density"))
        return cls(
            name=card.get("name", name),
            source=card.get("source", where),
            modulus=float(in_si(card["modulus"], Kind.STRESS, f"{where}: modulus")),
            yield_strain=float(
                Units().read(card["yield_strain"], Kind.NUMBER, f"{where}: yield_strain")
            ),
            density=density,
        )

    def with_modulus(self, modulus: float) -> Self:
        """Give the same material with a modulus that was measured; it yields at the same stress.

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


_PRESETS = Path(__file__).with_name("materials.toml")
MATERIALS = {
    name: Material.read(card, name, str(_PRESETS.name))
    for name, card in tomllib.loads(_PRESETS.read_text(encoding="utf-8")).items()
}


def material(name: str) -> Material:
    """Look up a material by its name, or read a file of one's own: ``"my.toml"``.

    Raises
    ------
    ArgumentError
        If there is none.
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


def bears(
    modulus: float, material_name: str | None = None, yield_strain: float | None = None
) -> tuple[float, str]:
    """Look up the strain up to which a rod is elastic, and of what it is that.

    Without a material and a yield strain it is that of the strongest material with such a modulus;
    infinite if there is none.
    """
    if yield_strain is not None:
        return yield_strain, "its material"
    if material_name is not None:
        found = material(material_name).with_modulus(modulus)
        return found.yield_strain, found.name
    alike = [one for one in MATERIALS.values() if abs(one.modulus / modulus - 1.0) < ALIKE]
    if not alike:
        return float("inf"), "no known material"
    found = max(alike, key=lambda one: one.yield_strain)
    return found.yield_strain, f"even {found.name}"
