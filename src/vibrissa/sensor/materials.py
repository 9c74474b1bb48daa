"""Materials of which a rod can be made: stiffness, and the strain up to which it stays elastic.

The rod of the model is linear and elastic, so that the strain here is where that ends: a yield
stress over Young's modulus for metals, the beginning of the plateau for superelastic ones, the
proportional limit for polymers, and breaking for brittle ones.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Material:
    """A material.

    Attributes
    ----------
    name, source : str
        What it is and where its figures stand.
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
                raise ValueError(f"{name} of a material must be a positive number, got {value!r}")


# Minimum strengths, so that the yield strains are on the safe side.
MATERIALS = {
    "steel-s235": Material(
        "structural steel S235",
        "EN 10025-2, table 7: yield strength 235 MPa up to 16 mm; EN 1993-1-1: E = 210 GPa; "
        "matmatch.com: 7850 kg/m³",
        210e9,
        235e6 / 210e9,
        7850.0,
    ),
    "stainless-304": Material(
        "stainless steel 304, annealed",
        "ASTM A213: 0.2 % yield strength 205 MPa; engineersedge.com, modulus of spring materials: "
        "E = 28e6 psi; alloywire.com: 8000 kg/m³",
        193e9,
        205e6 / 193e9,
        8000.0,
    ),
    "stainless-302-wire": Material(
        "stainless spring wire 302/304, cold drawn, up to 2 mm",
        "ASTM A313: tensile strength at least 246 ksi (1696 MPa) at 2 mm; elastic limit 65 % of "
        "it and E = 193 GPa: Shigley's Mechanical Engineering Design, table 10-5; 8000 kg/m³",
        193e9,
        0.65 * 1696e6 / 193e9,
        8000.0,
    ),
    "music-wire": Material(
        "music wire ASTM A228, up to 2 mm",
        "tensile strength at least 1840 MPa at 2 mm (NCEES FE Reference Handbook: 2060/d^0.163); "
        "elastic limit 65 % of it and E = 200 GPa: Shigley's Mechanical Engineering Design, "
        "table 10-5; makeitfrom.com: 7800 kg/m³",
        200e9,
        0.65 * 1840e6 / 200e9,
        7800.0,
    ),
    "nitinol": Material(
        "superelastic nickel-titanium, elastic up to its plateau",
        "Special Metals SMC-017: upper plateau 379 MPa, 6500 kg/m³; sma-inc.com, selected "
        "properties of NiTi: E about 83 GPa in austenite. It recovers up to 8 %, but it is linear "
        "up to the plateau only",
        83e9,
        379e6 / 83e9,
        6500.0,
    ),
    "carbon-rod": Material(
        "pultruded carbon fibre in epoxy; brittle",
        "goodwinds.com, material specifications: flexural modulus 127 GPa, flexural strength "
        "1.37 GPa, 1500 kg/m³, each a minimum",
        127e9,
        1.37e9 / 127e9,
        1500.0,
    ),
    "glass-rod": Material(
        "pultruded glass fibre in polyester",
        "tencom.com, pultruded rods: flexural modulus up to 41.4 GPa, least bend diameter 80 times "
        "the rod's, 2000 kg/m³",
        41.4e9,
        1.0 / 80.0,
        2000.0,
    ),
    "nylon-66": Material(
        "polyamide 66 with 2.5 % of water; creeps",
        "plastics.toray, mechanical properties of Amilan: proportional limit 0.5 %, E = 1.5 GPa; "
        "Quadrant Nylon 101: 1150 kg/m³",
        1.5e9,
        0.005,
        1150.0,
    ),
}


def material(name: str) -> Material:
    """Look up a material by its name.

    Raises
    ------
    ValueError
        If there is none.
    """
    if name.lower() not in MATERIALS:
        raise ValueError(f"material must be one of {', '.join(MATERIALS)}, got {name!r}")
    return MATERIALS[name.lower()]
