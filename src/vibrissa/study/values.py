"""Names, values and axes as they stand in a study file: types, ranges and what each of them is.

The descriptions are what a message says to be allowed, and what the reference page shows.
"""

import math
from collections.abc import Iterator, Mapping
from decimal import Decimal
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Any, Self, TypeVar

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
    model_validator,
)
from pydantic_core import PydanticCustomError, PydanticKnownError

from vibrissa.decimals import Value, exact, order_of, polynomial, spell
from vibrissa.study.grid import ZERO, Grid, Refinement, count_of_steps, equal_steps
from vibrissa.study.mistakes import Location, Mistake


class Section(BaseModel):
    """Part of a study file: a mapping with known keys."""

    # Validators are built when the first study is read, not when a module is imported.
    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)


def _exact(value: Any) -> Decimal:
    """Exact value of a number as YAML reads it."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise PydanticKnownError("decimal_type")
    try:
        return exact(value)
    except ValueError:
        raise PydanticKnownError("finite_number") from None


def _given(value: Any) -> Any:
    """Refuse a key with nothing behind it: a key that is not needed is left out."""
    if value is None:
        raise PydanticCustomError("nothing", "nothing")
    return value


T = TypeVar("T")
# A key that may be left out; None stands for that.
OptionalKey = Annotated[T | None, BeforeValidator(_given)]
Count = Annotated[int, Field(strict=True, ge=1)]
Name = Annotated[
    str,
    Field(
        pattern="^[A-Za-z0-9][A-Za-z0-9_-]{0,99}$",
        description="a name of at most 100 letters, digits, _ and - (in quotes if YAML reads it "
        "as a number or no)",
    ),
]

EXACT = BeforeValidator(_exact)
_THETA = "taper factor, base over tip diameter, a number theta >= 1"
_MU0 = "coefficient of static friction, a number mu0 > 0"
_ETA = "distance between clamp and surface in units of L, a number 0 < eta < 1"
_DX0 = "step of the clamp displacement in units of L, a number dx0 >= 1.0e-9"
_X1 = "contact point's distance from the clamp along the surface in units of L, -1 < x1 < 1"
_STEP = "distance between the values of an axis, a number > 0"
Theta = Annotated[Decimal, Field(ge=1, description=_THETA), EXACT]
Mu0 = Annotated[Decimal, Field(gt=0, description=_MU0), EXACT]
Eta = Annotated[Decimal, Field(gt=0, lt=1, description=_ETA), EXACT]
Dx0 = Annotated[Decimal, Field(ge=1e-9, description=_DX0), EXACT]
X1 = Annotated[Decimal, Field(gt=-1, lt=1, description=_X1), EXACT]
_CLAMP_ANGLE = "inclination of the clamp in rad, a number -1.5 <= clamp_angle <= 1.5"
_CLAMP_COMPLIANCE = "turn of the clamp per moment in L/(E*I0), a number clamp_compliance >= 0"
_COEFFICIENT = "coefficient of the natural curvature of the rod in 1/L, a number in [-10, 10]"
_POLYNOMIAL = "one or more coefficients of 1, s, s^2, ... in the natural curvature in 1/L"
_CURVATURE = (
    "natural curvature of the rod in 1/L: a number in [-10, 10], or a list of the coefficients of "
    "1, s, s^2, ..."
)
_STAGE_ANGLE = "angle of the stage to the surface in rad, a number -1.5 <= stage_angle <= 1.5"
ClampAngle = Annotated[Decimal, Field(ge=-1.5, le=1.5, description=_CLAMP_ANGLE), EXACT]
ClampCompliance = Annotated[Decimal, Field(ge=0, description=_CLAMP_COMPLIANCE), EXACT]
Coefficient = Annotated[Decimal, Field(ge=-10, le=10, description=_COEFFICIENT), EXACT]
Curvature = Annotated[
    Annotated[Decimal, Field(ge=-10, le=10, description=_CURVATURE), EXACT, Tag("number")]
    | Annotated[
        list[Coefficient],
        Field(min_length=1, description=_POLYNOMIAL),
        AfterValidator(polynomial),
        Tag("array"),
    ],
    Discriminator(lambda value: "array" if isinstance(value, list) else "number"),
    Field(description=_CURVATURE),
]
StageAngle = Annotated[Decimal, Field(ge=-1.5, le=1.5, description=_STAGE_ANGLE), EXACT]
Step = Annotated[Decimal, Field(gt=0, description=_STEP), EXACT]


class Range(Section):
    """Equal steps from start to stop, both included."""

    start: Decimal
    stop: Decimal
    step: Step

    @cached_property
    def values(self) -> tuple[Decimal, ...]:
        """Values in increasing order."""
        return equal_steps(self.start, self.stop, self.step)

    @property
    def count(self) -> int:
        """Number of values."""
        return count_of_steps(self.start, self.stop, self.step) + 1

    @model_validator(mode="after")
    def _ends_in_a_step(self) -> Self:
        _ = self.count
        return self


class ThetaRange(Range):
    """Taper factors in equal steps, stop included."""

    start: Theta
    stop: Theta


class Mu0Range(Range):
    """Friction coefficients in equal steps, stop included."""

    start: Mu0
    stop: Mu0


class EtaRange(Range):
    """Distances in equal steps, stop included."""

    start: Eta
    stop: Eta


class Dx0Range(Range):
    """Steps of the clamp displacement in equal steps, stop included."""

    start: Dx0
    stop: Dx0


class ClampAngleRange(Range):
    """Inclinations of the clamp in equal steps, stop included."""

    start: ClampAngle
    stop: ClampAngle


class ClampComplianceRange(Range):
    """Compliances of the clamp in equal steps, stop included."""

    start: ClampCompliance
    stop: ClampCompliance


class CurvatureRange(Range):
    """Constant natural curvatures in equal steps, stop included."""

    start: Coefficient
    stop: Coefficient


class StageAngleRange(Range):
    """Angles of the stage in equal steps, stop included."""

    start: StageAngle
    stop: StageAngle


def _json_type(axis: Any) -> str | None:
    """Type of what stands for an axis, in the words of JSON Schema."""
    if isinstance(axis, list):
        return "array"
    return "object" if isinstance(axis, dict) else None


R = TypeVar("R", bound=Range)
# An axis of a study file: its values in any order, or a range.
_Axis = Annotated[
    Annotated[
        list[T], Field(min_length=1, description="a list of at least one number"), Tag("array")
    ]
    | Annotated[R, Tag("object")],
    Discriminator(_json_type),
]
_FORMS = "a list of numbers, or {start, stop, step} with stop included"
_THETAS = f"taper factors, each >= 1: {_FORMS}"
_MU0S = f"friction coefficients, each > 0: {_FORMS}"
_ETAS = f"distances between clamp and surface in units of L, each in (0, 1): {_FORMS}"
_DX0S = f"steps of the clamp displacement in units of L, each >= 1.0e-9: {_FORMS}"
ThetaAxis = Annotated[_Axis[Theta, ThetaRange], Field(description=_THETAS)]
Mu0Axis = Annotated[_Axis[Mu0, Mu0Range], Field(description=_MU0S)]
EtaAxis = Annotated[_Axis[Eta, EtaRange], Field(description=_ETAS)]
Dx0Axis = Annotated[_Axis[Dx0, Dx0Range], Field(description=_DX0S)]

_CLAMP_ANGLES = f"inclinations of the clamp in rad (default: 0), each in [-1.5, 1.5]: {_FORMS}"
_CLAMP_COMPLIANCES = f"compliances of the clamp in L/(E*I0) (default: 0), each >= 0: {_FORMS}"
_CURVATURES = (
    "natural curvatures of the rod in 1/L (default: 0): a list, of which each is a number in "
    "[-10, 10] or a list of the coefficients of 1, s, s^2, ..., or {start, stop, step} of numbers "
    "with stop included"
)
_STAGE_ANGLES = (
    f"angles of the stage to the surface in rad (default: 0), each in [-1.5, 1.5]: {_FORMS}"
)
ClampAngleAxis = Annotated[_Axis[ClampAngle, ClampAngleRange], Field(description=_CLAMP_ANGLES)]
ClampComplianceAxis = Annotated[
    _Axis[ClampCompliance, ClampComplianceRange], Field(description=_CLAMP_COMPLIANCES)
]
CurvatureAxis = Annotated[_Axis[Curvature, CurvatureRange], Field(description=_CURVATURES)]
StageAngleAxis = Annotated[_Axis[StageAngle, StageAngleRange], Field(description=_STAGE_ANGLES)]


class Points(Section):
    """Section that says at which points something is solved, by the values of some axes."""

    @cached_property
    def axes(self) -> dict[str, tuple[Any, ...]]:
        """Distinct values of each axis in increasing order; one where the axis is a number."""
        return {
            name: _distinct(value)
            for name, value in self
            if isinstance(value, Decimal | list | Range)
        }

    @property
    def count(self) -> int:
        """Number of points, found without their values; what a list repeats counts again."""
        lengths = [
            value.count if isinstance(value, Range) else len(value)
            for _, value in self
            if isinstance(value, list | Range)
        ]
        return math.prod(lengths)


def _distinct(written: Decimal | list[Value] | Range) -> tuple[Value, ...]:
    if isinstance(written, Range):
        return written.values
    return tuple(sorted(set(written), key=order_of)) if isinstance(written, list) else (written,)


# Columns of the table of grid points that refine can look at: its computed numbers.
STATE = (
    *("f", "alpha", "phi1", "s_c", "reaction_fx", "reaction_fy", "reaction_m"),
    *("stability", "stability_aside"),
)
ENDS = ("last", "slip", "end", "trail")
# Those of a curve as a whole do not change with mu0.
CURVE_COLUMNS = ("mu_lock", "x0_lock", "x1_init", *(f"{name}_init" for name in STATE))
REFINED_COLUMNS = (
    *("x0_slip", "x0_max", "n_steps", "x0_end", "x0_trail"),
    *(f"{name}_{end}" for end in ENDS for name in STATE),
    *CURVE_COLUMNS,
)
_COLUMN = (
    "column of the table of grid points that is to be known between its points: x0_slip, x0_max, "
    "n_steps, x0_end, x0_trail, mu_lock, x0_lock or x1_init, or one of "
    f"{', '.join(STATE)} with {', '.join(f'_{end}' for end in ENDS)} or _init"
)
_TOLERANCE = (
    "how far the column may be from a straight line between neighbouring points, in its unit, a "
    "number > 0"
)
_CLOSEST = "least distance in {} of an added point from the next, a number from 1.0e-6"


def _refined_column(name: str) -> str:
    """Name of a column that refine can look at."""
    if name not in REFINED_COLUMNS:
        raise PydanticKnownError("enum", {"expected": "a column"})
    return name


RefinedColumn = Annotated[
    str,
    Field(json_schema_extra={"enum": list(REFINED_COLUMNS)}, description=_COLUMN),
    AfterValidator(_refined_column),
]
_ClosestMu0 = Annotated[Decimal, Field(ge=1e-6, description=_CLOSEST.format("mu0")), EXACT]
_ClosestTheta = Annotated[Decimal, Field(ge=1e-6, description=_CLOSEST.format("theta")), EXACT]
_ClosestEta = Annotated[Decimal, Field(ge=1e-6, description=_CLOSEST.format("eta")), EXACT]


class ClosestSection(Section):
    """Axes along which refine adds points, and how close these may be to the next point."""

    mu0: OptionalKey[_ClosestMu0] = None
    theta: OptionalKey[_ClosestTheta] = None
    eta: OptionalKey[_ClosestEta] = None

    @property
    def axes(self) -> dict[str, Decimal]:
        """What is given, by axis."""
        return {axis: value for axis, value in self if value is not None}

    @model_validator(mode="after")
    def _has_an_axis(self) -> Self:
        if not self.axes:
            raise ValueError("allowed: one or more of mu0, theta and eta")
        return self


class RefineSection(Section):
    """Where points are added: between two of which a straight line does not tell a column."""

    column: RefinedColumn = "x0_slip"
    tolerance: Annotated[Decimal, Field(gt=0, description=_TOLERANCE), EXACT]
    closest: ClosestSection = Field(
        description="how close added points may be to the next one, by axis along which they are "
        "added: one or more of {mu0: ..., theta: ..., eta: ...}"
    )

    @property
    def refinement(self) -> Refinement:
        """How points are added."""
        return Refinement(column=self.column, tolerance=self.tolerance, closest=self.closest.axes)

    def mistakes(
        self,
        location: Location,
        name: str,
        grids: Mapping[str, Grid],
        refinements: Mapping[str, Refinement],
    ) -> Iterator[Mistake]:
        """Find axes to which no point can be added, or to which another grid adds points, too.

        Parameters
        ----------
        location : tuple
            Of the section.
        name : str
            Of the grid.
        grids : mapping of Grid
            The study's grids by name.
        refinements : mapping of Refinement
            Of those to which points are added.

        Yields
        ------
        Mistake
        """
        if self.column in CURVE_COLUMNS and "mu0" in self.closest.axes:
            text = f"{self.column} does not change with mu0; allowed: theta and eta in closest"
            yield Mistake(location=(*location, "column"), text=text)
        for axis, closest in self.closest.axes.items():
            values = getattr(grids[name], axis)
            widest = max((stop - start for start, stop in pairwise(values)), default=ZERO)
            if not widest:
                text = f"{axis} has one value, {spell(values[0])}; allowed: two or more in the grid"
                yield Mistake(location=location, text=text)
            elif 2 * closest > widest:
                text = (
                    f"{spell(closest)} is not allowed, as no point would be added; allowed: up to "
                    f"{spell(exact(widest / 2))}, half of the widest gap of {axis} in the grid"
                )
                yield Mistake(location=(*location, "closest", axis), text=text)
        for other in sorted(grids.keys() - {name}):
            gains = other in refinements and bool(refinements[other].curve_axes)
            yield from self._between(location, grids[name], other, grids[other], gains)

    def _between(
        self, location: Location, grid: Grid, name: str, other: Grid, gains: bool
    ) -> Iterator[Mistake]:
        """Find curves of another grid that lie where curves may be added: they would be doubled.

        To the other grid curves may be added, too, if it `gains` some.
        """
        if set(grid.mountings()).isdisjoint(other.mountings()):
            return
        for axis in self.refinement.curve_axes:
            across = "eta" if axis == "theta" else "theta"
            if not gains and set(getattr(grid, across)).isdisjoint(getattr(other, across)):
                continue
            values = getattr(grid, axis)
            inside = [v for v in getattr(other, axis) if values[0] < v < values[-1]]
            if foreign := sorted(set(inside) - set(values)):
                text = (
                    f"{axis} = {spell(foreign[0])} of the grid {name!r} lies between values of "
                    f"this grid, where refine may add the same curve; allowed: {axis} of other "
                    "grids that this grid has, too, or that lies beyond"
                )
                yield Mistake(location=(*location, "closest", axis), text=text)
