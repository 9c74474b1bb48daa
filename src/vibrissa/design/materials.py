"""Materials of which a rod can be made: stiffness, and the strain up to which it stays elastic.

The rod of the model is linear elastic. So the yield strain is where linearity ends: the yield
stress over Young's modulus for metals, the beginning of the plateau for superelastic metals, the
proportional limit for polymers, and fracture for brittle materials.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Self

from vibrissa.errors import ArgumentError
from vibrissa.sensor.cards import is_card, read_card
from vibrissa.sensor.quantities import Kind, Units, in_si

# A modulus that was measured is that of a material up to this factor.
OTHER = 1.5


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


# Minimum strengths, so that the yield strains are on the safe side.
MATERIALS = {
    "steel-s235": Material(
        name="structural steel S235",
        source="EN 10025-2, table 7: yield strength 235 MPa up to 16 mm; EN 1993-1-1: E = 210 GPa; "
        "matmatch.com: 7850 kg/m³",
        modulus=210e9,
        yield_strain=235e6 / 210e9,
        density=7850.0,
    ),
    "stainless-304": Material(
        name="stainless steel 304, annealed",
        source="ASTM A213: 0.2 % yield strength 205 MPa; engineersedge.com, modulus of spring "
        "materials: E = 28e6 psi; alloywire.com: 8000 kg/m³",
        modulus=193e9,
        yield_strain=205e6 / 193e9,
        density=8000.0,
    ),
    "stainless-302-wire": Material(
        name="stainless spring wire 302/304, cold drawn, up to 2 mm",
        source="ASTM A313: tensile strength at least 246 ksi (1696 MPa) at 2 mm; elastic limit 65 "
        "% of it and E = 193 GPa: Shigley's Mechanical Engineering Design, table 10-5; 8000 kg/m³",
        modulus=193e9,
        yield_strain=0.65 * 1696e6 / 193e9,
        density=8000.0,
    ),
    "music-wire": Material(
        name="music wire ASTM A228, up to 2 mm",
        source="tensile strength at least 1840 MPa at 2 mm (NCEES FE Reference Handbook: "
        "2060/d^0.163); elastic limit 65 % of it and E = 200 GPa: Shigley's Mechanical Engineering "
        "Design, table 10-5; makeitfrom.com: 7800 kg/m³",
        modulus=200e9,
        yield_strain=0.65 * 1840e6 / 200e9,
        density=7800.0,
    ),
    "nitinol": Material(
        name="superelastic nickel-titanium, elastic up to its plateau",
        source="Special Metals SMC-017: upper plateau 379 MPa, 6500 kg/m³; sma-inc.com, selected "
        "properties of NiTi: E about 83 GPa in austenite. It recovers up to 8 %, but it is linear "
        "up to the plateau only",
        modulus=83e9,
        yield_strain=379e6 / 83e9,
        density=6500.0,
    ),
    "carbon-rod": Material(
        name="pultruded carbon fibre in epoxy; brittle",
        source="goodwinds.com, material specifications: flexural modulus 127 GPa, flexural "
        "strength 1.37 GPa, 1500 kg/m³, each a minimum",
        modulus=127e9,
        yield_strain=1.37e9 / 127e9,
        density=1500.0,
    ),
    "glass-rod": Material(
        name="pultruded glass fibre in polyester",
        source="tencom.com, pultruded rods: flexural modulus up to 41.4 GPa, least bend diameter "
        "80 times the rod's, 2000 kg/m³",
        modulus=41.4e9,
        yield_strain=1.0 / 80.0,
        density=2000.0,
    ),
    "nylon-66": Material(
        name="polyamide 66 with 2.5 % of water; creeps",
        source="plastics.toray, mechanical properties of Amilan: proportional limit 0.5 %, E = 1.5 "
        "GPa; Quadrant Nylon 101: 1150 kg/m³",
        modulus=1.5e9,
        yield_strain=0.005,
        density=1150.0,
    ),
    # From here on: half of the least tensile strength over the largest modulus of those that were
    # published, as no proportional limit is.
    "pla-printed": Material(
        name="polylactic acid, printed from filament; creeps",
        source="additive.tools, PLA: E 3 to 4 GPa; tensile strength 35 to 45 MPa across the layers "
        "(upright), 50 to 65 MPa along them; 1220 to 1260 kg/m³",
        modulus=3.5e9,
        yield_strain=0.5 * 35e6 / 4e9,
        density=1240.0,
    ),
    "petg-printed": Material(
        name="PETG, printed from filament; creeps",
        source="additive.tools, PETG: E 2 to 3 GPa; tensile strength 25 to 38 MPa across the "
        "layers (upright), 44 to 56 MPa along them; 1250 to 1290 kg/m³",
        modulus=2.5e9,
        yield_strain=0.5 * 25e6 / 3e9,
        density=1270.0,
    ),
    "pa12-sls": Material(
        name="polyamide 12, laser sintered (EOS PA 2200); creeps",
        source="EOS, PA 2200 Speed 1.0: tensile modulus 1600 MPa in the layers, 1550 MPa across "
        "them; tensile strength 48 and 42 MPa; 930 kg/m³",
        modulus=1.6e9,
        yield_strain=0.5 * 42e6 / 1.6e9,
        density=930.0,
    ),
    "resin-standard": Material(
        name="standard resin, printed by stereolithography (Formlabs Clear and Black V5); brittle",
        source="Formlabs, product pages of Clear and Black Resin V5 in July 2026: flexural modulus "
        "2700 and 2750 MPa, tensile strength 60 and 61 MPa; 1110 kg/m³ as a liquid",
        modulus=2.75e9,
        yield_strain=0.5 * 60e6 / 2.75e9,
        density=1110.0,
    ),
    "resin-tough": Material(
        name="tough resin, printed by stereolithography (Formlabs Tough 2000 V2); creeps",
        source="Formlabs, product page of Tough 2000 Resin V2 in July 2026: flexural modulus 1701 "
        "MPa, tensile strength 40.4 MPa; 1030 kg/m³ as a liquid",
        modulus=1.701e9,
        yield_strain=0.5 * 40.4e6 / 1.701e9,
        density=1030.0,
    ),
    "pom": Material(
        name="acetal homopolymer, machined or drawn; creeps",
        source="Margolis, Engineering Plastics Handbook (2006), table 5.5: tensile and flexural "
        "modulus 3.0 GPa, tensile strength 72 MPa; 1410 kg/m³",
        modulus=3.0e9,
        yield_strain=0.5 * 72e6 / 3.0e9,
        density=1410.0,
    ),
}


def material(name: str) -> Material:
    """Look up a material by its name, or read a file of one's own: ``"my.toml"``.

    Raises
    ------
    ArgumentError
        If there is none.
    """
    if is_card(name):
        return _read(Path(name))
    if name.lower() not in MATERIALS:
        raise ArgumentError(
            f"material must be one of {', '.join(MATERIALS)}, or a file .toml, got {name!r}"
        )
    return MATERIALS[name.lower()]


def _read(path: Path) -> Material:
    """Read a material from a file."""
    card = read_card(path, ("modulus", "yield_strain", "density"), ("name", "source"))

    return Material(
        name=card.get("name", path.stem),
        source=card.get("source", str(path)),
        modulus=float(in_si(card["modulus"], Kind.STRESS, f"{path}: modulus")),
        yield_strain=float(
            Units().read(card["yield_strain"], Kind.NUMBER, f"{path}: yield_strain")
        ),
        density=float(in_si(card["density"], Kind.DENSITY, f"{path}: density")),
    )
