"""Units: texts with a unit are read to nondimensional numbers; results are in SI units.

Nondimensional are lengths in units of L, forces in E·I0/L², moments in E·I0/L.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from enum import StrEnum
from functools import cache
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
    """What a quantity measures."""

    LENGTH = "length"
    FORCE = "force"
    MOMENT = "moment"
    ANGLE = "angle"
    COMPLIANCE = "compliance"
    STIFFNESS = "stiffness"
    CURVATURE = "curvature"
    STRESS = "stress"
    DENSITY = "density"
    TIME = "time"
    SPEED = "speed"
    RATE = "rate"
    NUMBER = "number"


SI = {
    Kind.LENGTH: "m",
    Kind.FORCE: "N",
    Kind.MOMENT: "N*m",
    Kind.ANGLE: "rad",
    Kind.COMPLIANCE: "rad/(N*m)",
    Kind.STIFFNESS: "N*m/rad",
    Kind.CURVATURE: "m^-1",
    Kind.STRESS: "Pa",
    Kind.DENSITY: "kg/m^3",
    Kind.TIME: "s",
    Kind.SPEED: "m/s",
    Kind.RATE: "Hz",
    Kind.NUMBER: "1",
}
# Usual units, for which pint is not asked: it takes half a second to load. In SI units.
USUAL: dict[Kind, dict[str, str]] = {
    Kind.LENGTH: {"m": "1", "cm": "1e-2", "mm": "1e-3", "um": "1e-6", "µm": "1e-6", "nm": "1e-9"},
    Kind.FORCE: {"N": "1", "mN": "1e-3", "uN": "1e-6"},
    # Without a sign between, as many write, pint reads something else.
    Kind.MOMENT: {
        **{"N*m": "1", "N*mm": "1e-3", "mN*m": "1e-3", "uN*m": "1e-6", "mN*mm": "1e-6"},
        **{"Nm": "1", "Nmm": "1e-3", "mNm": "1e-3", "uNm": "1e-6", "µNm": "1e-6", "mNmm": "1e-6"},
    },
    Kind.STRESS: {"Pa": "1", "MPa": "1e6", "GPa": "1e9"},
    Kind.DENSITY: {"kg/m^3": "1", "g/cm^3": "1e3"},
}
# Smaller and larger magnitudes are refused: products and squares of the others are numbers.
LEAST, MOST = Decimal("1e-60"), Decimal("1e60")
# How the units of nondimensional columns are written.
OWN = {
    Kind.LENGTH: "L",
    Kind.FORCE: "E*I0/L^2",
    Kind.MOMENT: "E*I0/L",
    Kind.COMPLIANCE: "L/(E*I0)",
    Kind.CURVATURE: "1/L",
    Kind.NUMBER: "1",
}
# What the channels force_x, force_y and moment_z of a transducer measure.
CHANNEL_KINDS = (Kind.FORCE, Kind.FORCE, Kind.MOMENT)
# What a recording and its tolerances are told in, in the units that were given.
MEASURED = (Kind.LENGTH, Kind.FORCE, Kind.MOMENT)

# An exponent, as in 1e3, is no unit.
NUMBER_AND_UNIT = re.compile(
    r"([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]{1,5})?)"
    r"\s*((?![eE][-+]?[0-9]+$)(?:[^\W\d_]|°).*)"
)
DECIMAL_COMMA = re.compile(r"\d,\d")
# Between a value and its tolerance.
PLUS_MINUS = re.compile(r"±|\+/-|\+-")
# "(210 ± 5) GPa": the unit is that of both.
_BRACKETS = re.compile(r"\(([^()]*)\)\s*(.*)")
# "85.0(1) mm": the last digits are uncertain by those in brackets.
_SHORTHAND = re.compile(r"([-+\d.]+\(\d+\)(?:[eE][-+]?\d+)?)\s*(.*)", re.ASCII)
_LAST_UNIT = re.compile(r"[\d.]\s*([^\W\d].*)$")
# Products, quotients and powers of names, such as kg/(m*s^2). Pint gets nothing else to read.
_NAME = r"[A-Za-zµμÅ°][A-Za-z0-9_]*[²³]?(?:(?:\*\*|\^)-?[1-9][0-9]?)?"
_NEXT = r"\s*[*/·\s]\s*"
_PRODUCT = rf"{_NAME}(?:{_NEXT}{_NAME})*"
_PART = rf"(?:{_NAME}|\(\s*{_PRODUCT}\s*\))"
UNIT = re.compile(rf"{_PART}(?:{_NEXT}{_PART})*")


@cache
def _registry() -> "pint.UnitRegistry[Any]":
    # Loaded on first use, with a file of definitions: bare numbers do not need it.
    import pint

    return pint.UnitRegistry(non_int_type=Decimal)


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
    def text(self) -> str:
        """Value and tolerance in the notation of `read`."""
        return f"{self.value}" if self.tolerance is None else f"{self.value} ± {self.tolerance}"

    @classmethod
    def read(cls, given: Quantity, what: str) -> Self:
        """Split ``"210 ± 5 GPa"``, ``"210 GPa +/- 2 %"``, ``"(210 ± 5) GPa"`` or ``"85.0(1) mm"``.

        Raises
        ------
        ArgumentError
            If there is more than one tolerance, or one that cannot be read for sure.

        Examples
        --------
        >>> Measured.read("(210 ± 5) GPa", "modulus")
        Measured(value='210 GPa', tolerance='5 GPa')
        """
        text = given.strip() if isinstance(given, str) else ""
        if (short := _SHORTHAND.fullmatch(text)) is not None:
            return cls._of_shorthand(short[1], short[2])
        inside = _BRACKETS.fullmatch(text)
        text, shared = (inside[1], f" {inside[2]}") if inside else (text, "")
        value, *tolerances = (part.strip() for part in PLUS_MINUS.split(text))
        if not tolerances:
            return cls(given)
        if len(tolerances) > 1:
            raise ArgumentError(f"{what} has one tolerance at most, got {given!r}")
        (tolerance,) = tolerances
        if not value or not tolerance:
            raise ArgumentError(f"{what} is written as '210 ± 5 GPa', got {given!r}")
        if tolerance.startswith("-"):
            raise ArgumentError(f"the tolerance of {what} must not be negative, got {given!r}")
        if shared:
            return cls(value + shared, tolerance + shared)
        unit, own_unit = (NUMBER_AND_UNIT.fullmatch(part) for part in (value, tolerance))
        if unit is not None and is_number(tolerance):
            raise ArgumentError(
                f"the tolerance of {what} needs a unit, as in '{value} ± {tolerance} {unit[2]}', "
                f"got {given!r}"
            )
        # "210 ± 5 GPa": the unit of the tolerance is that of the value.
        if unit is None and own_unit is not None:
            value = f"{value} {own_unit[2]}"
        return cls(value, tolerance)

    @classmethod
    def _of_shorthand(cls, number: str, unit: str) -> Self:
        from uncertainties import ufloat_fromstr  # a quarter of a second to load

        uncertain = ufloat_fromstr(number)
        parts = (repr(uncertain.nominal_value), repr(uncertain.std_dev))
        value, tolerance = (f"{part} {unit}".strip() for part in parts)
        return cls(value, tolerance)

    def check(self, kind: Kind, what: str) -> None:
        """Refuse what does not measure a kind, or has no number."""
        _read_number(self.value, kind, what)
        if self.tolerance is not None:
            size, of = self.tolerance, f"the tolerance of {what}"
            _read_number(size.removesuffix("%"), Kind.NUMBER if "%" in size else kind, of)


def is_number(value: Quantity) -> bool:
    """Whether a quantity has no unit."""
    try:
        exact(value.strip() if isinstance(value, str) else value)
    except ValueError:
        return False
    return True


def _read_number(value: Quantity, kind: Kind, what: str) -> tuple[Decimal, bool]:
    """Read a bare number, or the value in SI units of a quantity; and whether it has a unit."""
    if is_number(value):
        number = exact(value.strip() if isinstance(value, str) else value)
        if kind is Kind.ANGLE and number:  # of degrees and radians neither is the rule
            raise ArgumentError(f"{what} needs a unit: '{value} deg' or '{value} rad'")
        return _checked(number, what), False
    return in_si(str(value), kind, what), True


def in_si(text: str, kind: Kind, what: str) -> Decimal:
    """Value in SI units of a quantity such as ``"50 um"``, exact as a decimal.

    Raises
    ------
    ArgumentError
        If it is not such a quantity.

    Examples
    --------
    >>> print(in_si("85 mm", Kind.LENGTH, "eta"))
    0.085
    """
    if PLUS_MINUS.search(text):
        raise ArgumentError(f"{what} takes no tolerance, got {text!r}")
    parts = NUMBER_AND_UNIT.fullmatch(text.strip())
    article = "an" if kind is Kind.ANGLE else "a"
    unit = "" if kind is Kind.NUMBER else f" with a unit such as {SI[kind]}"
    comma = "; write a decimal point, not a comma" if DECIMAL_COMMA.search(text) else ""
    refusal = ArgumentError(f"{what} must be {article} {kind}{unit}, got {text!r}{comma}")
    if parts is None or UNIT.fullmatch(parts[2]) is None:
        raise refusal
    if usual := USUAL.get(kind, {}).get(parts[2]):
        return _checked(Decimal(parts[1]) * Decimal(usual), what)
    registry, wished = _registry(), "" if kind is Kind.NUMBER else SI[kind]
    from pint import PintError

    try:
        wanted, units = (registry.parse_units(unit) for unit in (wished, parts[2]))
        _, base = registry.get_base_units(units)
        if base != registry.get_base_units(wanted)[1]:
            raise refusal
        value = Decimal(registry.Quantity(Decimal(parts[1]), units).to(wanted).magnitude)
    except (PintError, TypeError, ValueError, ArithmeticError):
        # An unknown unit, one with an offset or a logarithm, one with a number, or an overflow.
        raise refusal from None
    return _checked(value, what)


def _checked(value: Decimal, what: str) -> Decimal:
    if value and not LEAST < abs(value) < MOST:
        raise ArgumentError(f"{what} must have a size from {LEAST} to {MOST}, got {value:.3g}")
    return value


def chosen(kind: type[Choice], value: str, what: str) -> Choice:
    """Look up a choice by its name.

    Raises
    ------
    ArgumentError
        If it is none of them.
    """
    if value not in tuple(kind):
        raise ArgumentError(f"{what} must be one of {', '.join(kind)}, got {value!r}")
    return kind(value)


def range_of(text: str) -> tuple[str, str]:
    """Split ``"20 to 200 mm"`` into its ends, ``"20 mm"`` and ``"200 mm"``; one value is both.

    Examples
    --------
    >>> range_of("0.2 to 0.4")
    ('0.2', '0.4')
    """
    low, to, high = (part.strip() for part in text.partition(" to "))
    if not to:
        return low, low
    unit = NUMBER_AND_UNIT.fullmatch(high)
    if unit is not None and NUMBER_AND_UNIT.fullmatch(low) is None:
        low = f"{low} {unit[2]}"
    return low, high


def channels_of(text: str, what: str) -> list[tuple[str, Kind]]:
    """Split ``"3 mN, 3 mN, 10 uN*m"`` into the values of force_x, force_y and moment_z.

    Raises
    ------
    ArgumentError
        If there are not three values.
    """
    parts = text.split(",")
    if len(parts) != len(CHANNEL_KINDS):
        raise ArgumentError(f"{what} needs three values, got {text!r}")
    return list(zip(parts, CHANNEL_KINDS, strict=True))


def read_rod(modulus: str | None, diameter: str | None, length: str | None) -> Rod | None:
    """Read a rod from ``"210 GPa"``, ``"1 mm"`` and ``"100 mm"``; None if nothing is given.

    Raises
    ------
    ArgumentError
        If one of them is missing or no such quantity.
    """
    given = {"modulus": modulus, "diameter": diameter, "length": length}
    missing = [name for name, text in given.items() if text is None]
    if len(missing) == len(given):
        return None
    if modulus is None or diameter is None or length is None:
        raise ArgumentError(
            f"a rod needs modulus, diameter and length: {', '.join(missing)} missing"
        )
    return Rod(
        float(in_si(modulus, Kind.STRESS, "modulus")),
        float(in_si(diameter, Kind.LENGTH, "diameter")),
        float(in_si(length, Kind.LENGTH, "length")),
    )


def wished_units(kinds: Iterable[Kind], *given: object) -> dict[Kind, str]:
    """Choose the units of the output: for each kind of quantity the first usual unit of the input.

    Parameters
    ----------
    *given : object
        Arguments of the user. Texts such as ``"85 ± 0.1 mm"`` or ``"3 mN, 3 mN, 10 uN*m"`` have
        units; other arguments have none.
    """
    texts = [part for text in given if isinstance(text, str) for part in text.split(",")]
    units = [found[1] for text in texts if (found := _LAST_UNIT.search(text.strip()))]
    wished = {kind: [unit for unit in units if unit in USUAL[kind]] for kind in kinds}
    return {kind: known[0] for kind, known in wished.items() if known}


@dataclass(frozen=True)
class Units:
    """Conversion between the user's units and dimensionless quantities.

    Attributes
    ----------
    rod : Rod or None
        Without one everything is nondimensional.
    si : bool
        Without a rod: numbers are in SI units, and not nondimensional.
    wished : dict of Kind to str
        For each kind of quantity the unit of printed results; SI units for a kind without one.
        Tables are always in SI units.
    """

    rod: Rod | None = None
    wished: Mapping[Kind, str] = field(default_factory=dict, compare=False)
    si: bool = False

    def told(self, value: float, kind: Kind) -> tuple[float, str]:
        """Value in the user's unit, and the name of that unit."""
        if self.nondimensional or kind not in self.wished:
            return value, self.name(kind)
        unit = self.wished[kind]
        return value / float(USUAL[kind][unit]), unit

    def spelled(self, value: float, kind: Kind, digits: int = 6) -> str:
        """Format a dimensionless value in the user's unit, as in ``"26.3 mm"``."""
        told, name = self.told(value * self.unit(kind), kind)
        return f"{told:.{digits}g} {name}".removesuffix(" 1")

    def unit(self, kind: Kind) -> float:
        """Return the dimensionless unit in SI units."""
        if kind in (Kind.NUMBER, Kind.ANGLE) or self.rod is None:
            return 1.0
        return {
            Kind.LENGTH: self.rod.length_unit,
            Kind.FORCE: self.rod.force_unit,
            Kind.MOMENT: self.rod.moment_unit,
            Kind.COMPLIANCE: 1.0 / self.rod.moment_unit,
            Kind.STIFFNESS: self.rod.moment_unit,
            Kind.CURVATURE: 1.0 / self.rod.length_unit,
        }[kind]

    @property
    def channels(self) -> FloatArray:
        """Units of force_x, force_y and moment_z in SI units, shape (3,)."""
        return np.array([self.unit(kind) for kind in CHANNEL_KINDS])

    def name(self, kind: Kind) -> str:
        """Name of the unit in which columns are written."""
        return OWN[kind] if self.nondimensional else SI[kind]

    @property
    def nondimensional(self) -> bool:
        """Whether no size in SI units is known."""
        return self.rod is None and not self.si

    def read(self, value: Quantity, kind: Kind, what: str) -> Decimal:
        """Nondimensional value of a quantity: a bare number is nondimensional already.

        Raises
        ------
        ArgumentError
            If it is no such quantity, or has a unit and there is no rod to relate it to.
        """
        number, has_unit = _read_number(value, kind, what)
        if has_unit:
            number = exact(number) / self._exact_unit(kind, f"{what} = {value!r}")
        return _checked(number, what)

    def read_positive(self, value: Quantity, kind: Kind, what: str) -> Decimal:
        """Nondimensional value of a quantity above 0, as `read` gives it.

        Raises
        ------
        ArgumentError
            If it is no such quantity, or is not above 0.
        """
        number = self.read(value, kind, what)
        if not number > 0:
            raise ArgumentError(f"{what} must be positive, got {value!r}")
        return number

    def read_channels(self, text: str, what: str) -> FloatArray:
        """Nondimensional values of ``"3 mN, 3 mN, 10 uN*m"``: force_x, force_y and moment_z.

        Raises
        ------
        ArgumentError
            If there are not three values, or one of them is no such quantity.
        """
        values = channels_of(text, what)
        return np.array([float(self.read(part, kind, what)) for part, kind in values])

    def column_factor(self, unit: str, kind: Kind, what: str) -> float:
        """Nondimensional value of one unit of a column."""
        if unit.replace("**", "^").replace(" ", "") == OWN.get(kind):
            return 1.0
        return float(in_si(f"1 {unit}", kind, what)) / float(self._exact_unit(kind, what))

    def _exact_unit(self, kind: Kind, what: str) -> Decimal:
        if self.nondimensional and kind is not Kind.ANGLE:
            raise ArgumentError(
                f"{what} has a unit, but the rod is not given: give modulus, diameter and length"
            )
        return exact(self.unit(kind))
