"""The axes of a study: their meaning, allowed values and notation."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import AfterValidator, BeforeValidator, Field, FiniteFloat, PlainSerializer

from vibrissa.decimals import exact, spell
from vibrissa.limits import MOST_POWERS, check_stiffening
from vibrissa.outcomes import SlipLaw
from vibrissa.study.sections import Section

Value: TypeAlias = float | tuple[float, ...]
Values: TypeAlias = tuple[Value, ...]
# Largest number of values of an axis; a longer axis is taken for a typing error.
LONGEST_AXIS = 1_000_000
# Largest number of values that a text lists; of a longer axis it has the first and the last.
LISTED = 10


def _no_flag(written: Any) -> Any:
    """Refuse true and false, which are numbers to Python."""
    if isinstance(written, bool):
        raise ValueError(f"{written} is not allowed: input should be a number")
    return written


def _trimmed(coefficients: list[float]) -> Value:
    """Drop trailing zero coefficients; return a constant polynomial as a number."""
    first, *powers = coefficients
    while powers and not powers[-1]:
        powers.pop()
    return (first, *powers) if powers else first


def _positive(powers: list[float]) -> list[float]:
    """Refuse a modulus that is not positive on the whole rod."""
    check_stiffening(powers)
    return powers


def in_list(written: Any) -> Any:
    """Return a list unchanged, and put any other value into a list."""
    return written if isinstance(written, list) else [written]


_NO_FLAG = BeforeValidator(_no_flag)
_Number: TypeAlias = Annotated[FiniteFloat, _NO_FLAG]
# The largest taper is that of `vibrissa.mechanics.taper`.
Theta: TypeAlias = Annotated[FiniteFloat, Field(ge=1, le=50), _NO_FLAG]
Eta: TypeAlias = Annotated[FiniteFloat, Field(gt=0, lt=1), _NO_FLAG]
_Positive: TypeAlias = Annotated[FiniteFloat, Field(gt=0), _NO_FLAG]
_NotNegative: TypeAlias = Annotated[FiniteFloat, Field(ge=0), _NO_FLAG]
_Step: TypeAlias = Annotated[FiniteFloat, Field(ge=1e-9), _NO_FLAG]
_Angle: TypeAlias = Annotated[FiniteFloat, Field(ge=-1.5, le=1.5), _NO_FLAG]
_Coefficient: TypeAlias = Annotated[FiniteFloat, Field(ge=-10, le=10), _NO_FLAG]
_Polynomial: TypeAlias = Annotated[
    list[_Coefficient],
    Field(min_length=1),
    BeforeValidator(in_list, json_schema_input_type=_Coefficient | list[_Coefficient]),
    AfterValidator(_trimmed),
]
_Power: TypeAlias = Annotated[FiniteFloat, Field(ge=-1000, le=1000), _NO_FLAG]
_Stiffening: TypeAlias = Annotated[
    list[_Power],
    Field(min_length=1, max_length=MOST_POWERS),
    BeforeValidator(in_list, json_schema_input_type=_Power | list[_Power]),
    AfterValidator(_positive),
    AfterValidator(_trimmed),
]
_Bore: TypeAlias = Annotated[FiniteFloat, Field(ge=0, lt=1), _NO_FLAG]


class Range(Section):
    """Equally spaced values of an axis."""

    start: _Number = Field(description="first value")
    stop: _Number = Field(description="last value, a whole number of steps from the first")
    step: _Positive = Field(description="distance between two values")

    @property
    def values(self) -> list[float]:
        """Values from start to stop, both included, computed in exact decimals."""
        first, last, by = exact(self.start), exact(self.stop), exact(self.step)
        steps = Fraction(last - first) / Fraction(by)
        if steps >= LONGEST_AXIS:
            raise ValueError(f"has more than {LONGEST_AXIS:,} values")
        if steps < 0 or steps.denominator != 1:
            raise ValueError(
                f"stop {spell(last)} must be start {spell(first)} plus a whole number of steps of "
                f"{spell(by)}"
            )
        return [float(first + i * by) for i in range(int(steps) + 1)]


def _expanded(written: Any) -> Any:
    """Return the values of a range as a list, and put a single value into a list."""
    if isinstance(written, Mapping):
        return Range.model_validate(written).values
    return in_list(written)


@dataclass(frozen=True)
class Axis:
    """An axis of a grid. As a type annotation it validates the axis's values in a study file.

    Attributes
    ----------
    meaning : str
        Meaning, unit and allowed values.
    number : type
        Type of one value, with its bounds.
    """

    meaning: str
    number: Any

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Accept a value, a list of values or a range; order the values."""
        values = list[self.number]  # type: ignore[name-defined]
        written = BeforeValidator(_expanded, json_schema_input_type=self.number | values | Range)
        ordered = AfterValidator(lambda found: tuple(sorted(set(found), key=sortable)))
        some = Annotated[values, Field(min_length=1), written, ordered]
        described = Field(description=self.meaning)
        return handler.generate_schema(Annotated[some, PlainSerializer(list), described])


# The four parameters of a grid point, then those of its rod's mounting (0 in the paper).
AXES: Mapping[str, Axis] = {
    "theta": Axis("taper factor, diameter of base over tip, from 1 to 50", Theta),
    "mu0": Axis("coefficient of static friction, above 0", _Positive),
    "eta": Axis("distance between clamp and surface in units of L, between 0 and 1", Eta),
    "dx0": Axis("step of the clamp in units of L, from 1e-9", _Step),
    "clamp_angle": Axis("inclination of the clamp in rad, from -1.5 to 1.5", _Angle),
    "clamp_compliance": Axis(
        "rotational compliance of the clamp in L/(E*I0), from 0", _NotNegative
    ),
    "curvature": Axis(
        "natural curvature of the rod in 1/L, from -10 to 10, or a list of the coefficients of "
        "1, s, s^2, ...",
        _Polynomial,
    ),
    "stiffening": Axis(
        "change of Young's modulus along the rod, E(s)/E(0) = 1 + c1*s + c2*s^2 + ..., positive on "
        "the whole rod: c1 from -1000 to 1000, or a list of c1, c2, ...",
        _Stiffening,
    ),
    "bore": Axis("diameter of a bore in units of that of the base, from 0 to below 1/theta", _Bore),
    "stage_angle": Axis("angle of the stage to the surface in rad, from -1.5 to 1.5", _Angle),
}
# All other axes of a grid are properties of the mounting.
MOUNTING_AXES = tuple(axis for axis in AXES if axis not in ("theta", "mu0", "eta", "dx0"))
# Axes whose values may be polynomials, and the columns of their further coefficients.
POWERS = {axis: f"{axis}_powers" for axis in ("curvature", "stiffening")}
# Columns of the mounting.
MOUNTING_COLUMNS = (*MOUNTING_AXES, *POWERS.values())
# Columns of natural frequencies, in a study that asks for them.
FREQUENCIES = ("frequency_1", "frequency_2")

_Law: TypeAlias = Literal[tuple(law.value for law in SlipLaw)]  # type: ignore[valid-type]
_Ratio: TypeAlias = Annotated[FiniteFloat, Field(gt=0, le=1), _NO_FLAG]
_Seed: TypeAlias = Annotated[int, Field(strict=True, ge=0), _NO_FLAG]
_Wall: TypeAlias = Annotated[FiniteFloat, Field(gt=0, le=1.569), _NO_FLAG]
# Further axes of scans. A scan has no value of an axis that has no effect on it.
FRICTION_AXES: dict[str, Axis] = {
    "mean": Axis("mean of a random friction coefficient, above 0", _Positive),
    "deviation": Axis("standard deviation of a random friction coefficient", _NotNegative),
    "correlation": Axis(
        "distance in units of L at which the correlation of a random friction coefficient has "
        "fallen to exp(-1/2)",
        _Positive,
    ),
    "seed": Axis("whole number from 0 that fixes a random surface", _Seed),
}
# Each begins with the name of its section in the study file, if it has one: `wave: {amplitude: 1}`.
TEXTURE_AXES: dict[str, Axis] = {
    "wave_amplitude": Axis("amplitude of a wave in units of L, from 0", _NotNegative),
    "wave_wavelength": Axis("length of a wave in units of L, above 0", _Positive),
    "wave_phase": Axis("phase of a wave at x = 0 in rad", _Number),
    "grooves_width": Axis("width of a groove in units of L, above 0", _Positive),
    "grooves_depth": Axis("depth of a groove in units of L, above 0", _Positive),
    "grooves_pitch": Axis("distance of grooves in units of L, above their width", _Positive),
    "grooves_wall": Axis("inclination of the walls of grooves in rad, up to 1.569", _Wall),
    "rough_deviation": Axis("standard deviation of random heights in units of L", _NotNegative),
    "rough_correlation": Axis(
        "distance in units of L at which the correlation of random heights has fallen to exp(-1/2)",
        _Positive,
    ),
    "rough_seed": Axis("whole number from 0 that fixes random heights", _Seed),
    "lay": Axis("angle in rad between the motion and the direction across the grooves", _Angle),
    "tip_radius": Axis("radius of a ball at the tip in units of L, from 0", _NotNegative),
}
SURFACE_AXES: dict[str, Axis] = FRICTION_AXES | TEXTURE_AXES
LAW_AXES: dict[str, Axis] = {
    "law": Axis("slip law, which says where a slip ends: " + ", ".join(SlipLaw), _Law),
    "kinetic_ratio": Axis(
        "kinetic over static friction, above 0 and at most 1; the law free has none", _Ratio
    ),
    "damping": Axis(
        "damping ratio of the rod's vibration, from 0; the law damped alone has one", _NotNegative
    ),
}


def sortable(value: float | str | Sequence[float]) -> tuple[Any, ...]:
    """Return the coefficients of a value as its sort key; a number has one coefficient."""
    return (value,) if isinstance(value, int | float | str) else tuple(value)


def spell_value(value: Value | str) -> str:
    """Format a value without exponent; a polynomial as in ``0.1,-0.3``; a name as it is."""
    if isinstance(value, str):
        return value
    return ",".join(spell(exact(number)) for number in sortable(value))


def spell_values(values: Sequence[Value | str]) -> str:
    """Format the values of an axis; of more than `LISTED` values, the first and the last."""
    texts = list(map(spell_value, values))
    return ", ".join(texts) if len(texts) <= LISTED else f"{texts[0]} to {texts[-1]}"
