"""The axes of a study: their meaning, allowed values and notation."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Annotated, Any, TypeAlias

from pydantic import BeforeValidator, Field

from vibrissa.decimals import exact, spell
from vibrissa.study.sections import Mistakes

Value: TypeAlias = float | tuple[float, ...]
Values: TypeAlias = tuple[Value, ...]
# Longer axes are typing errors: 10^6 points are three axes of 100.
LONGEST_AXIS = 1_000_000
# Values of an axis, and characters of a wrong one, that a message shows.
SHOWN_VALUES, SHOWN_CHARACTERS = 10, 60


@dataclass(frozen=True)
class Axis:
    """One axis of the grids, or one number of a section.

    Attributes
    ----------
    name : str
        Key in the study file and column in the tables.
    meaning : str
        Meaning and unit.
    is_open : bool
        Whether the bounds themselves are excluded.
    default : float or None
        Value where the file has no such key; None where it must have one.
    powers : bool
        Whether a value may be a list of coefficients of 1, s, s², ...
    """

    name: str
    meaning: str
    low: float = -math.inf
    high: float = math.inf
    is_open: bool = False
    default: float | None = None
    powers: bool = False

    @property
    def allowed(self) -> str:
        """What a value may be, in words."""
        low, high = (spell(exact(b)) if math.isfinite(b) else str(b) for b in (self.low, self.high))
        left = "(" if self.is_open or math.isinf(self.low) else "["
        right = ")" if self.is_open or math.isinf(self.high) else "]"
        coefficients = ", or a list of the coefficients of 1, s, s^2, ..." * self.powers
        return f"a number in {left}{low}, {high}{right}{coefficients}"

    @property
    def forms(self) -> str:
        """How its values may be written, in words."""
        return f"a list, each {self.allowed}; or {{start, stop, step}} with stop included"

    def number(self, written: Any) -> float:
        """Check one number; a `ValueError` reports what is allowed."""
        # YAML 1.1, as Snakemake reads it, takes 2e-3 for a text; a flag is a number to Python.
        is_number = isinstance(written, int | float | str) and not isinstance(written, bool)
        try:
            number = float(written) if is_number else math.nan
        except (ValueError, OverflowError):
            number = math.nan
        ends = () if self.is_open else (self.low, self.high)
        inside = self.low < number < self.high or number in ends
        if not inside or math.isinf(number):
            raise ValueError(f"{shown(written)} is not allowed; allowed: {self.allowed}")
        return number + 0.0  # turns -0.0 into 0.0

    def value(self, written: Any) -> Value:
        """Check one value, a number or coefficients without the zeros at their end."""
        if not (self.powers and isinstance(written, list) and written):
            return self.number(written)
        first, *powers = map(self.number, written)
        while powers and not powers[-1]:
            powers.pop()
        return (first, *powers) if powers else first

    def values(self, written: Any) -> Values:
        """Check the values of an axis; return them without repetition, in increasing order."""
        mistakes = Mistakes()
        if isinstance(written, Mapping):
            if set(written) != {"start", "stop", "step"}:
                keys = ", ".join(map(str, written))
                raise ValueError(f"has the keys {keys}; allowed: start, stop and step")
            axes = {"start": self, "stop": self, "step": _STEP}
            ends = {key: mistakes.check(key, axes[key].number, written[key]) for key in axes}
            mistakes.refuse()
            return equal_steps(**ends)
        if not isinstance(written, list) or not written:
            raise ValueError(f"{shown(written)} is not allowed; allowed: {self.forms}")
        found = [mistakes.check(place, self.value, one) for place, one in enumerate(written)]
        mistakes.refuse()
        return tuple(sorted(set(found), key=sortable))


_STEP = Axis("step", "distance of two values", low=0.0, is_open=True)
# The four numbers of a grid point, and how its rod is mounted (in the paper: 0).
_ALL = (
    Axis("theta", "taper factor, diameter of base over tip", low=1.0),
    Axis("mu0", "coefficient of static friction", low=0.0, is_open=True),
    Axis("eta", "distance between clamp and surface in units of L", 0.0, 1.0, is_open=True),
    Axis("dx0", "step of the clamp in units of L", low=1e-9),
    Axis("clamp_angle", "inclination of the clamp in rad", -1.5, 1.5, default=0),
    Axis("clamp_compliance", "rotational compliance of the clamp in L/(E*I0)", 0.0, default=0),
    Axis("curvature", "natural curvature of the rod in 1/L", -10.0, 10.0, default=0, powers=True),
    Axis("stage_angle", "angle of the stage to the surface in rad", -1.5, 1.5, default=0),
)
AXES: Mapping[str, Axis] = {axis.name: axis for axis in _ALL}
MOUNTING_AXES = tuple(axis.name for axis in _ALL if axis.default is not None)
_X1 = "position of the contact point along the surface in units of L, the clamp at 0"
X1 = Axis("x1", _X1, -1.0, 1.0, is_open=True)


def on(name: str) -> BeforeValidator:
    """Return the validator of the values of an axis."""
    axis = AXES[name]
    written = Field(description=f"{axis.meaning}: {axis.forms}")
    schema = Annotated[list[Any] | dict[str, float], written]
    return BeforeValidator(axis.values, json_schema_input_type=schema)


def at(axis: Axis) -> BeforeValidator:
    """Return the validator of a single value of an axis."""
    schema = Annotated[float, Field(description=f"{axis.meaning}: {axis.allowed}")]
    return BeforeValidator(axis.value, json_schema_input_type=schema)


def equal_steps(start: float, stop: float, step: float) -> tuple[float, ...]:
    """Return the values from start to stop, both included, in equal steps of exact decimals.

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
    """Sort key of a value: its constant, then the other coefficients."""
    return (value,) if isinstance(value, int | float) else tuple(value)


def spell_value(value: Value) -> str:
    """Spell a value without exponent; of a polynomial ``0.1,-0.3``."""
    return ",".join(spell(exact(number)) for number in sortable(value))


def spell_values(values: Values) -> str:
    """Spell the first values of an axis."""
    more = ", ..." if len(values) > SHOWN_VALUES else ""
    return ", ".join(map(spell_value, values[:SHOWN_VALUES])) + more


def shown(written: object) -> str:
    """Format a value as in the file, shortened if it is long."""
    text = repr(written)
    return text if len(text) <= SHOWN_CHARACTERS else f"{text[:SHOWN_CHARACTERS]}..."
