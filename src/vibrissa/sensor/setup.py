"""The set-up of a measurement: rod, mounting and transducer, each quantity with its tolerance.

In a TOML file a line is ``name = number`` or ``name = "value ± tolerance unit"``.
"""

from dataclasses import replace
from decimal import Decimal
from functools import cached_property
from numbers import Real
from typing import Annotated, Any, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from vibrissa.errors import ArgumentError
from vibrissa.mechanics.mounting import Mounting
from vibrissa.mechanics.rod import Rod
from vibrissa.outcomes import Contact, RodSection
from vibrissa.quantities.keys import Keyed, Positive
from vibrissa.quantities.units import (
    SI_UNITS,
    Kind,
    Measured,
    Quantity,
    Units,
    is_number,
    wished_units,
)
from vibrissa.sensor.tolerances import check_name, read_tolerances
from vibrissa.sensor.whisker import Whisker

TOLERANCES = "tolerances"
MOUNTING = ("clamp_angle", "clamp_compliance", "curvature", "bore", "stage_angle")
STIFFENING = "stiffening"


class Setup(Keyed):
    """Rod, mounting and transducer as the user states them, made by `Setup.read`.

    A quantity is a number, or a text with a unit, a tolerance or both: ``"85 ± 0.1 mm"``.
    Numbers without a unit are nondimensional: lengths in units of the rod's length. An angle other
    than 0 needs a unit.

    Examples
    --------
    >>> setup = Setup.read(theta=2, eta="85 ± 0.1 mm", modulus="210 GPa", diameter="1 mm",
    ...                    length="100 mm")
    >>> print(f"{setup.whisker.eta} ± {setup.whisker.tolerances['eta']:.3f}")
    0.85 ± 0.001
    """

    either = (("transducer", "noise"), ("material", "yield_strain"))

    theta: Annotated[Measured | None, Kind.NUMBER] = None
    """Taper, base over tip diameter: '2 ± 0.02'."""
    eta: Annotated[Measured | None, Kind.LENGTH] = None
    """Height of the surface above the clamp at position 0: 0.85 or '85 ± 0.1 mm'."""
    modulus: Annotated[Measured | None, Kind.STRESS] = None
    """Young's modulus: '210 ± 5 GPa'."""
    diameter: Annotated[Measured | None, Kind.LENGTH] = None
    """Diameter at the clamp: '1 mm ± 0.5 %'."""
    length: Annotated[Measured | None, Kind.LENGTH] = None
    """Length of the rod: '100 mm'."""
    contact: Contact = Contact.POINT
    """point: the rod touches with its tip alone; line: it may lie flat."""
    section: RodSection = RodSection.ROUND
    """round: the rod may buckle out of its plane; planar: a strip stays in it."""
    clamp_angle: Annotated[Measured, Kind.ANGLE] = Measured(0)
    """Inclination of the clamp, positive if it leans against the motion: '2 deg'."""
    clamp_compliance: Annotated[Measured, Kind.COMPLIANCE] = Measured(0)
    """Rotational compliance of the clamp: '0.05 rad/(N*m)'; a number without a unit is in
    L/(E*I0)."""
    curvature: Annotated[Measured, Kind.CURVATURE] = Measured(0)
    """Natural curvature, negative if the unloaded rod bends in the direction of motion:
    '-2 m^-1'."""
    stiffening: Annotated[Measured, Kind.NUMBER] = Measured(0)
    """Change c1 of Young's modulus along the rod, E(s)/E(0) = 1 + c1*s: '0.15 ± 0.05'; or c1, c2,
    ... in 1 + c1*s + c2*s^2 + ...: '0.3, -0.1'."""
    bore: Annotated[Measured, Kind.NUMBER] = Measured(0)
    """Diameter of a bore over that of the base: 0.4."""
    stage_angle: Annotated[Measured, Kind.ANGLE] = Measured(0)
    """Angle of the stage to the surface, positive if the clamp approaches it: '1 deg'."""
    transducer: str | None = None
    """Transducer, such as nano17-si-12-0.12, or a file (.toml)."""
    noise: str | None = None
    """Standard deviations of the noise in force_x, force_y and moment_z: '3 mN, 3 mN, 10 uN*m'."""
    material: str | None = None
    """Material of the rod, such as music-wire, or a file (.toml)."""
    yield_strain: Positive | None = None
    """Yield strain; if no modulus is given, in units of d0/L."""
    density: Annotated[Measured | None, Kind.DENSITY] = None
    """Density of the material: '7800 kg/m^3'."""
    assume: bool = True
    """Whether quantities without a stated tolerance have the default tolerance."""
    tolerances: dict[str, Quantity] = Field(default_factory=dict)
    """Standard deviation of a quantity: 'modulus=2 %', 'theta=exact'."""

    @field_validator("*", mode="before")
    @classmethod
    def _read_text(cls, value: Any, info: ValidationInfo) -> Any:
        name = str(info.field_name)
        kind = cls.kinds().get(name)
        if kind is None:
            return value
        if name == STIFFENING:
            return _stiffening(value)
        allowed = isinstance(value, str | Real | Decimal) and not isinstance(value, bool)
        if not allowed:
            raise ArgumentError(f"{name} must be a number or a text in quotes, got {value!r}")
        measured = Measured.read(value)
        measured.check(kind, name)
        return measured

    @field_validator("noise")
    @classmethod
    def _check_noise(cls, noise: str | None) -> str | None:
        if noise is not None:
            sizes = SI_UNITS.read_channels(noise, "noise")
            if min(sizes) < 0.0 or not any(sizes):
                raise ArgumentError(f"noise must be at least 0, and not all 0, got {noise!r}")
        return noise

    @field_validator(TOLERANCES)
    @classmethod
    def _check_names(cls, tolerances: dict[str, Quantity]) -> dict[str, Quantity]:
        for name in tolerances:
            check_name(name)
        return tolerances

    @model_validator(mode="after")
    def _check_both(self) -> Self:
        if self.noise is not None and self.transducer is not None:
            raise ArgumentError("give the noise or the transducer, not both")
        return self

    def stated(self) -> dict[str, Any]:
        """Keys and values that were given, in the notation of a set-up file."""
        return {
            name: _written(name, value) if isinstance(value, Measured) else value
            for name, value in self
            if name in self.model_fields_set
        }

    def in_si(self, name: str) -> float | None:
        """Value of the quantity `name` in SI units; None if it was not given.

        Raises
        ------
        ArgumentError
            If the quantity was given without a unit.
        """
        measured = getattr(self, name)
        return None if measured is None else self.kinds()[name].read(str(measured.value), name)

    @cached_property
    def rod(self) -> Rod | None:
        """The rod in SI units; None without modulus, diameter and length.

        Raises
        ------
        ArgumentError
            If only one or two of these three are given, or one of them has no unit.
        """
        sizes = {name: self.in_si(name) for name in ("modulus", "diameter", "length")}
        missing = [name for name, size in sizes.items() if size is None]
        if len(missing) == len(sizes):
            return None
        if missing:
            raise ArgumentError(
                f"a rod needs modulus, diameter and length; missing: {', '.join(missing)}"
            )
        bore = float(Kind.NUMBER.read(str(self.bore.value), "bore"))
        solid = Rod(*(size for size in sizes.values() if size is not None))
        return replace(solid, bore=bore)

    @property
    def has_whisker(self) -> bool:
        """Whether a whisker is described: theta, eta or both are stated."""
        return self.theta is not None or self.eta is not None

    @cached_property
    def whisker(self) -> Whisker:
        """The whisker, with the tolerances that were given.

        Raises
        ------
        ArgumentError
            If theta or eta is missing, if the height is not below the length of the rod, if a
            quantity has a unit but modulus, diameter or length is missing, or if a tolerance is out
            of range.
        """
        if self.theta is None or self.eta is None:
            name = "theta" if self.theta is None else "eta"
            raise ArgumentError(f"{name} is not given: neither as an option nor in a set-up file")
        lengths = [
            measured.value
            for measured in (self.length, self.eta, self.diameter)
            if measured is not None
        ]
        units = Units(self.rod, wished_units(*lengths, self.noise, *self.tolerances.values()))
        eta = self._read("eta", units)
        if self.rod is not None and not 0.0 < eta < 1.0:
            bare = is_number(self.eta.value)
            hint = ". A height in mm needs its unit, as in '85 mm'" if bare else ""
            raise ArgumentError(
                "eta must lie between 0 and the length of the rod, "
                f"{units.spelled(1.0, Kind.LENGTH)}, got {self.eta.value!r}{hint}"
            )
        whisker = Whisker(
            theta=self._read("theta", units),
            eta=eta,
            contact=self.contact,
            section=self.section,
            rod=self.rod,
            mounting=Mounting(
                **{name: self._read(name, units) for name in MOUNTING},
                stiffening=_powers(self.stiffening),
            ),
            wished=units.wished,
        )
        written = {name: getattr(self, name) for name in self.kinds()}
        stated = {
            name: measured.tolerance
            for name, measured in written.items()
            if measured and measured.tolerance
        }
        sizes = read_tolerances(units, stated | self.tolerances, whisker.values)
        return replace(whisker, tolerances=sizes)

    def _read(self, name: str, units: Units) -> float:
        return float(units.read(getattr(self, name).value, self.kinds()[name], name))


def _stiffening(value: Any) -> Measured:
    """Read the coefficients of the modulus: the first one may have a tolerance."""
    texts = value if isinstance(value, list) else str(value).split(",")
    first, *others = (Measured.read(str(text).strip()) for text in texts or [""])
    for power in (first, *others):
        power.check(Kind.NUMBER, STIFFENING)
    if any(power.tolerance for power in others):
        raise ArgumentError(f"{STIFFENING}: only c1 may have a tolerance, got {value!r}")
    values = ", ".join(str(power.value).strip() for power in (first, *others))
    read = Measured(values if others else first.value, first.tolerance)
    Mounting(stiffening=_powers(read))
    return read


def _written(name: str, measured: Measured) -> Quantity:
    """Write a quantity and its tolerance, which is that of the first coefficient of the modulus."""
    first, comma, others = str(measured.value).partition(",")
    if name != STIFFENING or not comma:
        return measured.written
    return f"{Measured(first, measured.tolerance).written},{others}"


def _powers(stiffening: Measured) -> tuple[float, ...]:
    """Coefficients c1, c2, … of the modulus."""
    texts = str(stiffening.value).split(",")
    return tuple(float(Kind.NUMBER.read(text, STIFFENING)) for text in texts)
