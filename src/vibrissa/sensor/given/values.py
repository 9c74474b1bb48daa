"""What a person gives: a value, and perhaps its tolerance, as in ``"210 ± 5 GPa"``."""

import re
from dataclasses import dataclass
from typing import Self

from vibrissa.errors import ArgumentError
from vibrissa.sensor.quantities import NUMBER_AND_UNIT, PLUS_MINUS, Quantity

# "(210 ± 5) GPa": the unit is that of both.
BRACKETS = re.compile(r"\(([^()]*)\)\s*(.*)")
# A number and its unit, either of which may be wrong: that is told where it is read.
PARTS = re.compile(r"(\S*\d\S*)\s*(.*)")


@dataclass(frozen=True, kw_only=True)
class Given:
    """A quantity that was given.

    Attributes
    ----------
    value : str or number
    tolerance : str or None
        Its standard deviation, with a unit or in per cent; None where none was given.
    """

    value: Quantity
    tolerance: str | None = None

    @classmethod
    def read(cls, given: Quantity, what: str) -> Self:
        """Split ``"210 ± 5 GPa"``, ``"210 GPa +/- 2 %"`` or ``"(210 ± 5) GPa"``.

        Parameters
        ----------
        given : str or number
        what : str
            How a message names it.

        Raises
        ------
        ArgumentError
            If there is more than one tolerance, or one that cannot be read for sure.
        """
        if not isinstance(given, str) or not (found := PLUS_MINUS.findall(given)):
            return cls(value=given)
        if len(found) > 1:
            raise ArgumentError(f"{what} has one tolerance at most, got {given!r}")
        text, shared = given.strip(), ""
        if (inside := BRACKETS.fullmatch(text)) is not None:
            text, shared = inside[1], inside[2]
        value, tolerance = (part.strip() for part in PLUS_MINUS.split(text))
        if not value or not tolerance:
            raise ArgumentError(f"{what} is given as '210 ± 5 GPa', got {given!r}")
        if tolerance.startswith("-"):
            raise ArgumentError(f"the tolerance of {what} must not be negative, got {given!r}")
        if shared:
            return cls(value=f"{value} {shared}", tolerance=f"{tolerance} {shared}")
        unit, with_unit = (NUMBER_AND_UNIT.fullmatch(part) for part in (value, tolerance))
        alone = with_unit is None and (own := PARTS.fullmatch(tolerance)) and not own[2]
        if unit is not None and alone and not tolerance.endswith("%"):
            raise ArgumentError(
                f"the tolerance of {what} needs a unit, as in '{value} ± {tolerance} {unit[2]}', "
                f"got {given!r}"
            )
        # "210 ± 5 GPa": the unit of the tolerance is that of the value, too.
        if unit is None and with_unit is not None:
            value = f"{value} {with_unit[2]}"
        return cls(value=value, tolerance=tolerance)
