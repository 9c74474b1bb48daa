"""The set-up of a measurement: rod, mounting and transducer, each quantity with its tolerance.

In a TOML file a line is ``name = number`` or ``name = "value ± tolerance unit"``.
"""

from collections.abc import Iterator
from decimal import Decimal
from functools import cached_property
from numbers import Real
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    ValidationInfo,
    field_validator,
    model_validator,
)

from vibrissa.errors import ArgumentError
from vibrissa.mechanics.mounting import Mounting
from vibrissa.outcomes import Contact, RodSection
from vibrissa.sensor.keys import read_model
from vibrissa.sensor.quantities import (
    Kind,
    Measured,
    Quantity,
    Units,
    channels_of,
    chosen,
    read_rod,
    wished_units,
)
from vibrissa.sensor.tolerances import check_name, read_tolerances
from vibrissa.sensor.whisker import Whisker

TOLERANCES = "tolerances"
# Each pair describes one property: an option takes the place of either in the file.
EITHER = (
    ("clamp_compliance", "clamp_stiffness"),
    ("transducer", "noise"),
    ("material", "yield_strain"),
)


class Setup(BaseModel):
    """Rod, mounting and transducer, as they were stated; see `Setup.read`.

    Numbers without a unit are nondimensional: lengths in units of the rod's length. An angle other
    than 0 has a unit.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)

    theta: Annotated[Measured | None, Kind.NUMBER] = Field(
        None, description="Taper, base over tip diameter: '2 ± 0.02'."
    )
    eta: Annotated[Measured | None, Kind.LENGTH] = Field(
        None, description="Height of the surface above the clamp: 0.85 or '85 ± 0.1 mm'."
    )
    modulus: Annotated[Measured | None, Kind.STRESS] = Field(
        None, description="Young's modulus: '210 ± 5 GPa'."
    )
    diameter: Annotated[Measured | None, Kind.LENGTH] = Field(
        None, description="Diameter at the clamp: '1 mm ± 0.5 %'."
    )
    length: Annotated[Measured | None, Kind.LENGTH] = Field(
        None, description="Length of the rod: '100 mm'."
    )
    contact: Contact = Field(
        Contact.POINT,
        description="point: the rod touches with its tip alone; line: it may lie flat.",
    )
    section: RodSection = Field(
        RodSection.ROUND,
        description="round: the rod may buckle out of its plane; planar: a strip stays in it.",
    )
    clamp_angle: Annotated[Measured, Kind.ANGLE] = Field(
        Measured(0), description="Inclination of the clamp, positive backward: '2 deg'."
    )
    clamp_compliance: Annotated[Measured | None, Kind.COMPLIANCE] = Field(
        None,
        description="Rotational compliance of the clamp: '0.05 rad/(N*m)'; a number without a "
        "unit is in L/(E*I0).",
    )
    clamp_stiffness: Annotated[Measured | None, Kind.STIFFNESS] = Field(
        None,
        description="In place of clamp_compliance its inverse: '20 N*m/rad'. Without either the "
        "clamp is rigid.",
    )
    curvature: Annotated[Measured, Kind.CURVATURE] = Field(
        Measured(0),
        description="Natural curvature, negative away from the surface: '-2 m^-1'. 'a, b, c' are "
        "coefficients of the powers of s/L.",
    )
    stage_angle: Annotated[Measured, Kind.ANGLE] = Field(
        Measured(0), description="Angle of the stage to the surface: '1 deg'."
    )
    transducer: str | None = Field(
        None, description="Transducer, such as nano17-si-12-0.12, or a file (.toml)."
    )
    noise: str | None = Field(
        None,
        description="Standard deviations of the noise in force_x, force_y and moment_z: "
        "'3 mN, 3 mN, 10 uN*m'.",
    )
    material: str | None = Field(
        None, description="Material of the rod, such as music-wire, or a file (.toml)."
    )
    yield_strain: float | None = Field(
        None, gt=0.0, description="Yield strain, without a modulus in units of d0/L."
    )
    density: Annotated[Measured | None, Kind.DENSITY] = Field(
        None, description="Density of the material: '7800 kg/m^3'."
    )
    assume: bool = Field(
        True, description="Whether quantities without a stated tolerance have the default one."
    )
    tolerances: dict[str, Quantity] = Field(
        default_factory=dict, description="Standard deviations of further quantities."
    )

    @classmethod
    def read(cls, path: Path | str | None = None, **options: Any) -> Self:
        """Read a set-up from a TOML file, from options, or from both.

        Raises
        ------
        ArgumentError
            With a line for each key or value that is not allowed.

        Examples
        --------
        >>> setup = Setup.read(theta=2, eta="85 ± 0.1 mm", modulus="210 GPa", diameter="1 mm",
        ...                    length="100 mm")
        >>> print(f"{setup.whisker.eta} ± {setup.whisker.tolerances['eta']:.3f}")
        0.85 ± 0.001
        """
        return read_model(cls, path, options, EITHER)

    @field_validator("*", mode="before")
    @classmethod
    def _read_field(cls, value: Any, info: ValidationInfo) -> Any:
        name = str(info.field_name)
        field = cls.model_fields[name]
        if name in ("assume", TOLERANCES):
            return value
        if isinstance(value, bool) or not isinstance(value, str | Real | Decimal):
            raise ArgumentError(f"{name} is a number or a text in quotes, got {value!r}")
        if field.annotation in (Contact, RodSection):
            return chosen(field.annotation, str(value), name)
        kind = next((each for each in field.metadata if isinstance(each, Kind)), None)
        if kind is None:
            return value
        measured = Measured.read(str(value), name)
        if name == "curvature" and "," in str(measured.value):
            for part in str(measured.value).split(","):
                Measured(part).check(Kind.NUMBER, name)
        else:
            measured.check(kind, name)
        return measured

    @field_validator(TOLERANCES)
    @classmethod
    def _check_names(cls, tolerances: dict[str, Quantity]) -> dict[str, Quantity]:
        for name in tolerances:
            check_name(name)
        return tolerances

    @model_validator(mode="after")
    def _check_together(self) -> Self:
        if self.clamp_compliance is not None and self.clamp_stiffness is not None:
            raise ArgumentError("give clamp_compliance or clamp_stiffness, not both")
        if self.noise is not None:
            for part, kind in channels_of(self.noise, "noise"):
                Measured(part).check(kind, "noise")
        return self

    def stated(self) -> dict[str, Any]:
        """Keys of a set-up file with the same content."""
        return {
            name: (value.text if value.tolerance else value.value)
            if isinstance(value, Measured)
            else value
            for name, value in self
            if name in self.model_fields_set
        }

    @cached_property
    def whisker(self) -> Whisker:
        """The whisker, with the tolerances that were stated.

        Raises
        ------
        ArgumentError
            If taper or height is missing, or the values do not fit each other.
        """
        if self.theta is None or self.eta is None:
            name = "theta" if self.theta is None else "eta"
            raise ArgumentError(f"{name} is not given: neither as an option nor in a set-up file")
        modulus, diameter, length = (
            None if one is None else str(one.value)
            for one in (self.modulus, self.diameter, self.length)
        )
        rod = read_rod(modulus, diameter, length)
        lengths = [each.value for each in (self.length, self.eta, self.diameter) if each]
        units = Units(rod, wished_units([Kind.LENGTH], *lengths))
        whisker = Whisker(
            theta=float(units.read(self.theta.value, Kind.NUMBER, "theta")),
            eta=_height(units, self.eta.value),
            contact=self.contact,
            section=self.section,
            rod=rod,
            mounting=self._mounting(units),
            wished=units.wished,
        )
        stated = {**dict(self._tolerances(units)), **self.tolerances}
        whisker = whisker.tolerating(read_tolerances(units, stated, whisker))
        return whisker.wishing(self.noise, *self.tolerances.values())

    def _mounting(self, units: Units) -> Mounting:
        def read(measured: Measured | None, kind: Kind, name: str) -> float:
            return 0.0 if measured is None else float(units.read(measured.value, kind, name))

        compliance = read(self.clamp_compliance, Kind.COMPLIANCE, "clamp_compliance")
        if (stiffness := self.clamp_stiffness) is not None:
            compliance = 1.0 / float(
                units.read_positive(stiffness.value, Kind.STIFFNESS, "clamp_stiffness")
            )
        powers = str(self.curvature.value).split(",")
        curvature = (
            read(self.curvature, Kind.CURVATURE, "curvature")
            if len(powers) == 1
            else tuple(map(float, powers))
        )
        return Mounting(
            clamp_angle=read(self.clamp_angle, Kind.ANGLE, "clamp_angle"),
            clamp_compliance=compliance,
            curvature=curvature,
            stage_angle=read(self.stage_angle, Kind.ANGLE, "stage_angle"),
        )

    def _tolerances(self, units: Units) -> Iterator[tuple[str, str]]:
        """Tolerances that are written with their values."""
        for name, measured in self:
            if not isinstance(measured, Measured) or measured.tolerance is None:
                continue
            if name == "clamp_stiffness":
                yield "clamp_compliance", _relative(units, measured)
            else:
                yield name, measured.tolerance


def _height(units: Units, eta: Quantity) -> float:
    """Height of the surface (L); a rod with a length must reach it."""
    height = float(units.read(eta, Kind.LENGTH, "eta"))
    if units.rod is not None and not 0.0 < height < 1.0:
        raise ArgumentError(
            f"eta must lie between 0 and the length of the rod, {units.spelled(1.0, Kind.LENGTH)}: "
            f"write a height with its unit, as in '85 mm', got {eta!r}"
        )
    return height


def _relative(units: Units, stiffness: Measured) -> str:
    """Relative tolerance of a compliance, from that of the stiffness: both are equal."""
    tolerance = str(stiffness.tolerance)
    if tolerance.endswith("%"):
        return tolerance
    size, value = (
        units.read(each, Kind.STIFFNESS, "clamp_stiffness") for each in (tolerance, stiffness.value)
    )
    return f"{100 * size / value} %"
