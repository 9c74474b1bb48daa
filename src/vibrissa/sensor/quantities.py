"""Units at the border: text with a unit in, nondimensional numbers inside, SI out.

Nondimensional are lengths in units of L, forces in E·I0/L², moments in E·I0/L.
"""

import re
from dataclasses import dataclass
from decimal import Decimal
from enum import StrEnum
from functools import cache
from typing import Any

import pint

from vibrissa.decimals import exact
from vibrissa.units import Rod


class Kind(StrEnum):
    """What a quantity measures."""

    LENGTH = "length"
    FORCE = "force"
    MOMENT = "moment"
    STRESS = "stress"
    TIME = "time"
    DENSITY = "density"
    NUMBER = "number"


SI = {
    Kind.LENGTH: "m",
    Kind.FORCE: "N",
    Kind.MOMENT: "N*m",
    Kind.STRESS: "Pa",
    Kind.TIME: "s",
    Kind.DENSITY: "kg/m^3",
    Kind.NUMBER: "1",
}
# How the units of nondimensional columns are written.
OWN = {Kind.LENGTH: "L", Kind.FORCE: "E*I0/L^2", Kind.MOMENT: "E*I0/L", Kind.NUMBER: "1"}

NUMBER_AND_UNIT = re.compile(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([^\W\d_].*)")


@cache
def _registry() -> pint.UnitRegistry[Any]:
    # Filled on first use: it reads a file of definitions.
    return pint.UnitRegistry(non_int_type=Decimal)


def in_si(text: str, kind: Kind, what: str) -> Decimal:
    """Value in SI units of a quantity such as ``"50 um"``, exact as a decimal.

    Parameters
    ----------
    text : str
        Number and unit.
    kind : Kind
        What it must measure.
    what : str
        How a message names it.

    Returns
    -------
    Decimal

    Raises
    ------
    ValueError
        If it is no such quantity.
    """
    parts = NUMBER_AND_UNIT.fullmatch(text.strip())
    try:
        if parts is None:
            raise ValueError
        registry = _registry()
        quantity = registry.Quantity(Decimal(parts[1]), registry.parse_units(parts[2]))
        value = Decimal(quantity.to(SI[kind].replace("1", "")).magnitude)
        if not value.is_finite():
            raise ValueError
        return value
    # Pint has no common error for text that is no unit.
    except Exception:
        raise ValueError(
            f"{what} must be a {kind} with a unit such as {SI[kind]}, got {text!r}"
        ) from None


def range_of(text: str) -> tuple[str, str]:
    """Split ``"20 to 200 mm"`` into its ends, ``"20 mm"`` and ``"200 mm"``; one value is both."""
    low, to, high = (part.strip() for part in text.partition(" to "))
    if not to:
        return low, low
    unit = NUMBER_AND_UNIT.fullmatch(high)
    if unit is not None and NUMBER_AND_UNIT.fullmatch(low) is None:
        low = f"{low} {unit[2]}"
    return low, high


@dataclass(frozen=True)
class Units:
    """Between a person's units and those of the computation.

    Attributes
    ----------
    rod : Rod or None
        Without one everything is nondimensional.
    """

    rod: Rod | None = None

    def unit(self, kind: Kind) -> float:
        """Give the unit of the computation in SI units."""
        if kind is Kind.NUMBER or self.rod is None:
            return 1.0
        return {
            Kind.LENGTH: self.rod.length_unit,
            Kind.FORCE: self.rod.force_unit,
            Kind.MOMENT: self.rod.moment_unit,
        }[kind]

    def name(self, kind: Kind) -> str:
        """Name of the unit in which columns are written."""
        return OWN[kind] if self.rod is None else SI[kind]

    def read(self, text: str, kind: Kind, what: str) -> Decimal:
        """Nondimensional value of a text: a bare number is nondimensional already.

        Raises
        ------
        ValueError
            If the text is no such quantity, or has a unit and there is no rod to relate it to.
        """
        try:
            value = exact(text.strip())
        except ValueError:
            return exact(in_si(text, kind, what)) / self._exact_unit(kind, f"{what} = {text!r}")
        return value

    def column_factor(self, unit: str, kind: Kind, what: str) -> float:
        """Nondimensional value of one unit of a column."""
        if unit.replace("**", "^").replace(" ", "") == OWN.get(kind):
            return 1.0
        return float(in_si(f"1 {unit}", kind, what)) / float(self._exact_unit(kind, what))

    def _exact_unit(self, kind: Kind, what: str) -> Decimal:
        if self.rod is None:
            raise ValueError(
                f"{what} has a unit, but the rod is not given: give modulus, diameter and length"
            )
        return exact(self.unit(kind))
