"""The axes of a study: what each is, which values it may have, and how they are written.

A value is a number, or for a natural curvature the coefficients of a polynomial in s.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NoReturn, TypeAlias

from pydantic import BeforeValidator
from pydantic_core import PydanticCustomError

from vibrissa.decimals import exact, spell

Value: TypeAlias = float | tuple[float, ...]
Values: TypeAlias = tuple[Value, ...]
# Longer axes are typing errors: 10^6 points are three axes of 100.
LONGEST_AXIS = 1_000_000
# Values of an axis, and characters of a wrong one, that a message shows.
SHOWN_VALUES, SHOWN_CHARACTERS = 10, 60


@dataclass(frozen=True, kw_only=True)
class Axis:
    """One axis of the grids, or one number of a section.

    Attributes
    ----------
    name : str
        Key in the study file and column in the tables.
    meaning : str
        What it is, with its unit.
    low, high : float
        Bounds of its values.
    is_open : bool
        Whether the bounds themselves are excluded.
    default : float or None
        Value where the file has no such key; None where it must have one.
    is_polynomial : bool
        Whether a value may be a list of coefficients.
    """

    name: str
    meaning: str
    low: float = -math.inf
    high: float = math.inf
    is_open: bool = False
    default: float | None = None
    is_polynomial: bool = False

    @property
    def allowed(self) -> str:
        """What a value may be, in words."""
        left, right = "()" if self.is_open else "[]"
        low, high = (spell(exact(b)) if math.isfinite(b) else f"{b}" for b in (self.low, self.high))
        interval = f"{left if low != '-inf' else '('}{low}, {high}{right if high != 'inf' else ')'}"
        polynomial = ", or a list of the coefficients of 1, s, s^2, ..." * self.is_polynomial
        return f"a number in {interval}{polynomial}"

    @property
    def forms(self) -> str:
        """How its values may be written, in words."""
        return f"a list, each {self.allowed}; or {{start, stop, step}} with stop included"

    def value(self, written: Any) -> Value:
        """Check one value; a `ValueError` says what is wrong with it."""
        if self.is_polynomial and isinstance(written, list) and written:
            first, *powers = (self._number(coefficient) for coefficient in written)
            while powers and not powers[-1]:
                powers.pop()
            return (first, *powers) if powers else first
        return self._number(written)

    def _number(self, written: Any) -> float:
        try:
            if isinstance(written, bool) or not isinstance(written, int | float | str):
                raise ValueError
            # YAML 1.1, as Snakemake reads it, takes 2e-3 for a text.
            number = float(exact(written))
        except ValueError:
            raise ValueError(f"{shown(written)} is not allowed; allowed: {self.allowed}") from None
        inside = self.low < number < self.high or (
            not self.is_open and number in (self.low, self.high)
        )
        if not inside:
            raise ValueError(f"{shown(written)} is not allowed; allowed: {self.allowed}")
        return number + 0.0  # turns -0.0 into 0.0

    def values(self, written: Any) -> Values:
        """Check the values of an axis; return them without repetition, in increasing order."""
        mistakes: list[Mistake] = []
        found: list[Value] = []
        if isinstance(written, Mapping):
            return self._range(written)
        if not isinstance(written, list) or not written:
            mistakes.append(((), f"{shown(written)} is not allowed; allowed: {self.forms}"))
        else:
            for place, value in enumerate(written):
                try:
                    found.append(self.value(value))
                except ValueError as error:
                    mistakes.append(((place,), str(error)))
        if mistakes:
            refuse(mistakes)
        return tuple(sorted(set(found), key=sortable))

    def _range(self, written: Mapping[str, Any]) -> Values:
        mistakes: list[Mistake] = []
        keys = ("start", "stop", "step")
        if set(written) != set(keys):
            text = f"has the keys {', '.join(map(str, written))}; allowed: start, stop and step"
            refuse([((), text)])
        found: dict[str, Any] = {}
        step = Axis(name="step", meaning="distance of two values", low=0.0, is_open=True)
        for key in keys:
            try:
                found[key] = (step if key == "step" else self)._number(written[key])
            except ValueError as error:
                mistakes.append(((key,), str(error)))
        if not mistakes:
            try:
                return equal_steps(**found)
            except ValueError as error:
                mistakes.append(((), str(error)))
        refuse(mistakes)


# The four numbers of a grid point, and how its rod is mounted (in the paper: 0).
_ALL = (
    Axis(name="theta", meaning="taper factor, diameter of base over tip", low=1.0),
    Axis(name="mu0", meaning="coefficient of static friction", low=0.0, is_open=True),
    Axis(
        name="eta",
        meaning="distance between clamp and surface in units of L",
        low=0.0,
        high=1.0,
        is_open=True,
    ),
    Axis(name="dx0", meaning="step of the clamp in units of L", low=1e-9),
    Axis(
        name="clamp_angle", meaning="inclination of the clamp in rad", low=-1.5, high=1.5, default=0
    ),
    Axis(
        name="clamp_compliance",
        meaning="rotational compliance of the clamp in L/(E*I0)",
        low=0.0,
        default=0,
    ),
    Axis(
        name="curvature",
        meaning="natural curvature of the rod in 1/L",
        low=-10.0,
        high=10.0,
        default=0,
        is_polynomial=True,
    ),
    Axis(
        name="stage_angle",
        meaning="angle of the stage to the surface in rad",
        low=-1.5,
        high=1.5,
        default=0,
    ),
)
AXES: Mapping[str, Axis] = {axis.name: axis for axis in _ALL}
MOUNTING_AXES = tuple(axis.name for axis in _ALL if axis.default is not None)
X1 = Axis(
    name="x1",
    meaning="position of the contact point along the surface in units of L, the clamp at 0",
    low=-1.0,
    high=1.0,
    is_open=True,
)

# Where in a section a mistake is, and what it is.
Mistake: TypeAlias = tuple[tuple[str | int, ...], str]
_RANGE_SCHEMA = dict[str, float]


def refuse(mistakes: list[Mistake]) -> NoReturn:
    """Refuse a part of a study file for one or more mistakes below it."""
    raise PydanticCustomError("mistakes", "mistakes", {"mistakes": mistakes})


def on(name: str) -> BeforeValidator:
    """Return the validator of the values of an axis."""
    axis = AXES[name]
    return BeforeValidator(axis.values, json_schema_input_type=list[Any] | _RANGE_SCHEMA)


def at(axis: Axis) -> BeforeValidator:
    """Return the validator of a single value of an axis."""
    kind: Any = float | list[float] if axis.is_polynomial else float
    return BeforeValidator(axis.value, json_schema_input_type=kind)


def equal_steps(start: float, stop: float, step: float) -> tuple[float, ...]:
    """Return the values from start to stop, both included, in equal steps.

    Decimal arithmetic makes each value the one that a person would write: 0.3, and not
    0.30000000000000004.

    Raises
    ------
    ValueError
        If the stop is not a whole number of steps from the start, or there are more than
        `LONGEST_AXIS` values.
    """
    first, last, by = exact(start), exact(stop), exact(step)
    steps = Fraction(last - first) / Fraction(by)
    if steps >= LONGEST_AXIS:
        raise ValueError(f"has more than {LONGEST_AXIS:,} values")
    if steps < 0 or steps.denominator != 1:
        raise ValueError(
            f"stop {spell(last)} must be start {spell(first)} plus a whole number of steps of "
            f"{spell(by)}"
        )
    return tuple(float(first + i * by) for i in range(int(steps) + 1))


def sortable(value: float | Sequence[float]) -> tuple[float, ...]:
    """Return what values are sorted by: the constant, then the other coefficients."""
    return (value,) if isinstance(value, int | float) else tuple(value)


def spell_value(value: Value) -> str:
    """Spell a value without exponent; of a polynomial ``0.1,-0.3``."""
    return ",".join(spell(exact(number)) for number in sortable(value))


def spell_values(values: Values) -> str:
    """Spell the first values of an axis."""
    more = ", ..." if len(values) > SHOWN_VALUES else ""
    return ", ".join(map(spell_value, values[:SHOWN_VALUES])) + more


def shown(written: object) -> str:
    """Spell a value as it stands in the file, cut where it is long."""
    text = repr(written)
    return text if len(text) <= SHOWN_CHARACTERS else f"{text[:SHOWN_CHARACTERS]}..."
