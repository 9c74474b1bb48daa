"""Units: conversion of texts with a unit to nondimensional numbers, and of results to SI units.

Nondimensional lengths are in units of L, forces in E·I0/L², moments in E·I0/L.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from enum import StrEnum
from functools import cache
from tokenize import TokenError
from typing import TYPE_CHECKING, Any, NamedTuple, Self, TypeVar

import numpy as np

from vibrissa.decimals import exact
from vibrissa.errors import ArgumentError
from vibrissa.mechanics.rod import Rod
from vibrissa.numerics.arrays import FloatArray

if TYPE_CHECKING:
    import pint

# A number in units of the rod, or text such as "50 um".
Quantity = str | float | Decimal

Choice = TypeVar("Choice", bound=StrEnum)


class Kind(StrEnum):
    """Physical kind of a quantity.

    Attributes
    ----------
    si, own : str
        SI unit, and nondimensional unit, such as ``E*I0/L``; empty if there is none.
    """

    si: str
    own: str

    def __new__(cls, text: str, si: str, own: str = "") -> Self:
        """Make a member with its units."""
        kind = str.__new__(cls, text)
        kind._value_, kind.si, kind.own = text, si, own
        return kind

    LENGTH = "length", "m", "L"
    FORCE = "force", "N", "E*I0/L^2"
    MOMENT = "moment", "N*m", "E*I0/L"
    ANGLE = "angle", "rad"
    COMPLIANCE = "compliance", "rad/(N*m)", "L/(E*I0)"
    CURVATURE = "curvature", "m^-1", "1/L"
    STRAIN = "strain", "1", "d0/L"
    STRESS = "stress", "Pa"
    DENSITY = "density", "kg/m^3"
    TIME = "time", "s"
    SPEED = "speed", "m/s"
    RATE = "rate", "Hz"
    NUMBER = "number", "1", "1"

    def read(self, text: str, what: str) -> float:
        """Convert a text such as ``"50 um"`` to SI units; only a `NUMBER` needs no unit.

        Raises
        ------
        ArgumentError
            If the text is no quantity of this kind.
        """
        return float(in_si(text, self, what))


# Kinds of the channels force_x, force_y and moment_z of a transducer.
CHANNEL_KINDS = (Kind.FORCE, Kind.FORCE, Kind.MOMENT)
# Kinds of quantities that are printed in the units of the input.
MEASURED = (Kind.LENGTH, Kind.FORCE, Kind.MOMENT)
# Sizes of usual units, each of one kind, in SI units. Only for other units Pint is loaded, which
# takes half a second.
USUAL = {
    Kind.LENGTH: {"m": "1", "cm": "0.01", "mm": "0.001", "um": "0.000001", "µm": "0.000001"},
    Kind.FORCE: {"N": "1", "mN": "0.001", "uN": "0.000001"},
    Kind.MOMENT: {"N*m": "1", "mN*m": "0.001", "N*mm": "0.001", "mN*mm": "0.000001"}
    | {"uN*m": "0.000001", "uN*mm": "0.000000001"},
    Kind.ANGLE: {"rad": "1", "mrad": "0.001", "deg": "0.01745329251994329576923690768"},
    Kind.STRESS: {"Pa": "1", "MPa": "1000000", "GPa": "1000000000"},
    Kind.DENSITY: {"kg/m^3": "1"},
    Kind.TIME: {"s": "1", "ms": "0.001"},
    Kind.SPEED: {"m/s": "1", "mm/s": "0.001"},
    Kind.RATE: {"Hz": "1", "kHz": "1000"},
}
# Range of accepted magnitudes, whose products and squares neither overflow nor vanish.
LEAST, MOST = Decimal("1e-60"), Decimal("1e60")

# Products, quotients and powers of names, such as kg/(m*s^2). Only such texts are passed to Pint.
_NAME = r"(?:[^\W\d_]|°)\w*(?:(?:\*\*|\^)-?[1-9])?"
_UNIT = rf"{_NAME}(?:[*/·() ]+{_NAME})*\)?"
# The sign of a product in a unit of a moment: N-m, N.m, in-lbf.
_MOMENT = re.compile(r"(?<=[A-Za-z])[-.⋅](?=[A-Za-z])")
# An exponent, as in 1e3, is no unit.
NUMBER_AND_UNIT = re.compile(
    r"([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]{1,5})?)"
    rf"\s*((?![eE][-+]?[0-9]+$){_UNIT})"
)
_LAST_UNIT = re.compile(rf"[\d.]\s*({_UNIT})$")
DECIMAL_COMMA = re.compile(r"\d,\d")
# Signs between a value and its tolerance.
PLUS_MINUS = re.compile(r"±|\+/-|\+-")
# "(210 ± 5) GPa": the unit is that of both.
_BRACKETS = re.compile(r"\(([^()]*)\)(.*)")
# "85.0(1) mm": the last digits are uncertain by those in brackets.
_SHORTHAND = re.compile(r"([-+\d.]+\(\d+\)(?:[eE][-+]?\d+)?)(.*)", re.ASCII)


@cache
def _registry() -> "pint.UnitRegistry[Any]":
    # Loaded on first use, with a file of definitions: bare numbers do not need it.
    import pint

    registry: pint.UnitRegistry[Any] = pint.UnitRegistry(non_int_type=Decimal)
    # Moments are often written without a sign between the units.
    registry.define("Nm = newton * meter")
    registry.define("Nmm = newton * millimeter")
    registry.define("Ncm = newton * centimeter")
    registry.define("kp = 9.80665 newton")
    return registry


@cache
def unit_size(unit: str, kind: Kind) -> Decimal:
    """Size of a unit in SI units, exact as a decimal; 0 if it is no unit of this kind."""
    unit = _MOMENT.sub("*", unit)
    if any(unit in sizes for sizes in USUAL.values()):
        return Decimal(USUAL.get(kind, {}).get(unit, 0))
    from pint import PintError

    if re.fullmatch(_UNIT, unit) is None:
        return Decimal(0)
    registry, wanted = _registry(), "" if kind is Kind.NUMBER else kind.si
    try:
        bases = {registry.get_base_units(registry.parse_units(one))[1] for one in (unit, wanted)}
        size = registry.Quantity(Decimal(1), unit).to(wanted).magnitude
    except (PintError, TokenError, TypeError, ValueError, ArithmeticError):
        # An unknown unit, one with an offset or a logarithm, an open bracket, or an overflow.
        return Decimal(0)
    return Decimal(size) if len(bases) == 1 else Decimal(0)


@cache
def unit_ratio(unit: str, other: str) -> Decimal:
    """Size of a unit in another unit of any kind; 0 if they measure different quantities.

    Examples
    --------
    >>> print(f"{unit_ratio('V', 'mV'):f}")
    1000
    """
    from pint import PintError

    if not all(re.fullmatch(_UNIT, one) for one in (unit, other)):
        return Decimal(0)
    try:
        return Decimal(_registry().Quantity(Decimal(1), unit).to(other).magnitude)
    except (PintError, TokenError, TypeError, ValueError, ArithmeticError):
        return Decimal(0)


def is_unit(text: str) -> bool:
    """Whether a text is a unit, of whatever kind."""
    return unit_ratio(text, text) != 0


class Measured(NamedTuple):
    """A quantity and its tolerance, as texts.

    Attributes
    ----------
    tolerance : str or None
        Standard deviation, with a unit or in per cent; None where none was stated.
    """

    value: Quantity
    tolerance: str | None = None

    @property
    def written(self) -> Quantity:
        """Value and tolerance as one text that `read` accepts, as in ``210 GPa ± 5 GPa``."""
        return self.value if self.tolerance is None else f"{self.value} ± {self.tolerance}"

    @classmethod
    def read(cls, given: Quantity) -> Self:
        """Split ``"210 ± 5 GPa"``, ``"210 GPa +/- 2 %"``, ``"(210 ± 5) GPa"`` or ``"85.0(1) mm"``.

        If only one of value and tolerance has a unit, it is the unit of both.

        Examples
        --------
        >>> Measured.read("(210 ± 5) GPa")
        Measured(value='210 GPa', tolerance='5 GPa')
        """
        text = PLUS_MINUS.sub("±", str(given)).strip()
        if short := _SHORTHAND.fullmatch(text):
            from uncertainties import ufloat_fromstr  # a quarter of a second to load

            number = ufloat_fromstr(short[1])
            text = f"{number.nominal_value!r} ± {number.std_dev!r}{short[2]}"
        elif brackets := _BRACKETS.fullmatch(text):
            text = brackets[1] + brackets[2]
        value, sign, tolerance = (part.strip() for part in text.partition("±"))
        if not sign:
            return cls(given)
        if is_number(value) and (unit := NUMBER_AND_UNIT.fullmatch(tolerance)):
            value = f"{value} {unit[2]}"
        elif is_number(tolerance) and (unit := _LAST_UNIT.search(value)):
            tolerance = f"{tolerance} {unit[1]}"
        return cls(value, tolerance)

    def check(self, kind: Kind, what: str) -> None:
        """Refuse a value or a tolerance that is no quantity of this kind.

        Raises
        ------
        ArgumentError
        """
        SI_UNITS.read(self.value, kind, what)
        if self.tolerance is not None and not self.tolerance.endswith("%"):
            SI_UNITS.read(self.tolerance, kind, f"the tolerance of {what}")


def is_number(value: Quantity) -> bool:
    """Whether a quantity has no unit."""
    try:
        exact(value)
    except ValueError:
        return False
    return True


def in_si(text: str, kind: Kind, what: str) -> Decimal:
    """Convert a text such as ``"50 um"`` to SI units, exactly, as a decimal.

    Raises
    ------
    ArgumentError
        If the text is no quantity of this kind.

    Examples
    --------
    >>> print(in_si("85 mm", Kind.LENGTH, "eta"))
    0.085
    """
    if kind is Kind.NUMBER and is_number(text):
        return _checked(exact(text), what)
    parts = NUMBER_AND_UNIT.fullmatch(text.strip())
    size = unit_size(parts[2], kind) if parts else Decimal(0)
    if parts is None or not size:
        article = "an" if kind is Kind.ANGLE else "a"
        unit = "" if kind is Kind.NUMBER else f" with a unit such as {kind.si}"
        hint = "; write a decimal point, not a comma" if DECIMAL_COMMA.search(text) else ""
        hint = "; write a single value" if set("±,") & set(text) and not hint else hint
        raise ArgumentError(f"{what} must be {article} {kind}{unit}, got {text!r}{hint}")
    return _checked(Decimal(parts[1]) * size, what)


def _checked(value: Decimal, what: str) -> Decimal:
    if value and not LEAST < abs(value) < MOST:
        raise ArgumentError(
            f"{what} must be 0, or lie between {LEAST} and {MOST} in magnitude, got {value:.3g}"
        )
    return value


def range_of(text: str) -> tuple[str, str]:
    """Split ``"20 to 200 mm"`` into ``"20 mm"`` and ``"200 mm"``; a single value is both ends.

    Examples
    --------
    >>> range_of("0.2 to 0.4")
    ('0.2', '0.4')
    """
    low, to, high = (part.strip() for part in text.partition(" to "))
    if not to:
        return low, low
    if is_number(low) and (unit := NUMBER_AND_UNIT.fullmatch(high)):
        low = f"{low} {unit[2]}"
    return low, high


def channels_of(text: str, what: str) -> list[tuple[str, Kind]]:
    """Split ``"3 mN, 3 mN, 10 uN*m"`` into three texts, each with the kind of its channel.

    Raises
    ------
    ArgumentError
        If there are not three values.
    """
    parts = text.split(",")
    if len(parts) != len(CHANNEL_KINDS):
        raise ArgumentError(
            f"{what} needs three values, of force_x, force_y and moment_z, got {text!r}"
        )
    return list(zip(parts, CHANNEL_KINDS, strict=True))


def channels_in_si(text: str, what: str) -> list[float]:
    """Convert ``"3 mN, 3 mN, 10 uN*m"`` to SI units; each value needs its unit.

    Raises
    ------
    ArgumentError
        If there are not three values, or one of them is no force or moment.
    """
    return [kind.read(part, what) for part, kind in channels_of(text, what)]


def wished_units(*given: object) -> dict[Kind, str]:
    """Choose output units: for each kind of quantity the first unit of this kind in `given`.

    Parameters
    ----------
    *given : object
        Arguments of the user. Texts such as ``"85 ± 0.1 mm"`` or ``"3 mN, 3 mN, 10 uN*m"`` have
        units; other arguments have none.
    """
    texts = [part for text in given if isinstance(text, str) for part in text.split(",")]
    found = [_LAST_UNIT.search(text.strip()) for text in texts]
    units = [one[1] for one in found if one]
    wished = {kind: [unit for unit in units if unit_size(unit, kind)] for kind in MEASURED}
    return {kind: known[0] for kind, known in wished.items() if known}


@dataclass(frozen=True)
class Units:
    """Conversion between the user's units and nondimensional quantities.

    Attributes
    ----------
    rod : Rod or None
        The rod. If there is none, numbers are nondimensional unless `si` is true.
    si : bool
        Whether numbers are in SI units if there is no rod.
    wished : dict of Kind to str
        For each kind of quantity the unit of printed results; SI units for a kind without one.
        Tables have the units that `name` returns.
    """

    rod: Rod | None = None
    wished: Mapping[Kind, str] = field(default_factory=dict, compare=False)
    si: bool = False

    def displayed(self, value: float, kind: Kind) -> tuple[float, str]:
        """Convert a value from the unit of tables to the user's unit; return value and unit."""
        if self.nondimensional or kind not in self.wished:
            return value, self.name(kind)
        unit = self.wished[kind]
        return value / float(unit_size(unit, kind)), unit

    def spelled(self, value: float, kind: Kind, digits: int = 6) -> str:
        """Format a nondimensional value in the user's unit, as in ``"26.3 mm"``."""
        size, name = self.displayed(value * self.unit(kind), kind)
        return f"{size:.{digits}g} {name}".removesuffix(" 1")

    def unit(self, kind: Kind) -> float:
        """Return the SI value of the nondimensional unit of this kind."""
        if self.rod is None:
            return 1.0
        return {
            Kind.LENGTH: self.rod.length_unit,
            Kind.FORCE: self.rod.force_unit,
            Kind.MOMENT: self.rod.moment_unit,
            Kind.COMPLIANCE: 1.0 / self.rod.moment_unit,
            Kind.CURVATURE: 1.0 / self.rod.length_unit,
            Kind.STRAIN: self.rod.base_diameter / self.rod.length,
        }.get(kind, 1.0)

    @property
    def channels(self) -> FloatArray:
        """SI values of the nondimensional units of force_x, force_y and moment_z, shape (3,)."""
        return np.array([self.unit(kind) for kind in CHANNEL_KINDS])

    def name(self, kind: Kind) -> str:
        """Name of the unit that tables have for this kind of quantity."""
        return kind.own if self.nondimensional else kind.si

    @property
    def nondimensional(self) -> bool:
        """Whether numbers are nondimensional: there is no rod, and `si` is false."""
        return self.rod is None and not self.si

    def read(self, value: Quantity, kind: Kind, what: str) -> Decimal:
        """Convert a quantity to a nondimensional value; a bare number is nondimensional already.

        Raises
        ------
        ArgumentError
            If the quantity is not of this kind, or has a unit although no rod is given.
        """
        if is_number(value):
            if kind is Kind.ANGLE and exact(value):  # neither degrees nor radians are assumed
                raise ArgumentError(f"{what} needs a unit: '{value} deg' or '{value} rad'")
            return _checked(exact(value), what)
        number = in_si(str(value), kind, what)
        return _checked(number / self._exact_unit(kind, f"{what} = {value!r}"), what)

    def read_positive(self, value: Quantity, kind: Kind, what: str) -> Decimal:
        """Convert a quantity as `read` does; refuse values that are not positive."""
        number = self.read(value, kind, what)
        if not number > 0:
            raise ArgumentError(f"{what} must be positive, got {value!r}")
        return number

    def read_channels(self, text: str, what: str) -> FloatArray:
        """Convert ``"3 mN, 3 mN, 10 uN*m"`` to nondimensional force_x, force_y and moment_z.

        Raises
        ------
        ArgumentError
            If there are not three values, or one of them is no force or moment.
        """
        values = channels_of(text, what)
        return np.array([float(self.read(part, kind, what)) for part, kind in values])

    def column_factor(self, unit: str, kind: Kind, what: str) -> float:
        """Return the factor that converts a column in this unit to nondimensional values."""
        if unit.replace("**", "^").replace(" ", "") == kind.own:
            return 1.0
        return float(in_si(f"1 {unit}", kind, what) / self._exact_unit(kind, what))

    def _exact_unit(self, kind: Kind, what: str) -> Decimal:
        if self.nondimensional and kind is not Kind.ANGLE:
            raise ArgumentError(
                f"{what} has a unit, but the rod is not given: give modulus, diameter and length"
            )
        return exact(self.unit(kind))


# Conversion of quantities with a unit to SI units.
SI_UNITS = Units(si=True)
