"""Grids, comparisons and single states of a study file: what is solved without a scan."""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Self, TypeAlias

from pydantic import Discriminator, Field, FiniteFloat, Tag, model_validator

from vibrissa.outcomes import Contact
from vibrissa.study.axes import AXES, Eta, Theta, Values
from vibrissa.study.chunks import (
    MOST_RODS,
    SIZES_BY_STEP,
    Chunk,
    chunks_of,
    number_of_points,
    sizes_of,
)
from vibrissa.study.points import PointsSection
from vibrissa.study.sections import Mistakes, Section, check_bores


class _ProductSection(Section):
    """All combinations of the values of some axes."""

    theta: Annotated[Values, AXES["theta"]]
    mu0: Annotated[Values, AXES["mu0"]]
    eta: Annotated[Values, AXES["eta"]]
    is_product: ClassVar[bool] = True

    @property
    def axes(self) -> dict[str, Values]:
        """Values of each axis in increasing order."""
        return {name: getattr(self, name) for name in AXES if name in type(self).model_fields}

    @property
    def number(self) -> int:
        """Number of points."""
        return number_of_points(self.axes)


class ComparisonSection(_ProductSection):
    """Points that are solved in both kinds of contact: all combinations of theta, mu0 and eta."""


class GridSection(_ProductSection):
    """Points at which a period of sticking is solved: all combinations of values of the axes."""

    dx0: Annotated[Values, AXES["dx0"]]
    clamp_angle: Annotated[Values, AXES["clamp_angle"]] = (0.0,)
    clamp_compliance: Annotated[Values, AXES["clamp_compliance"]] = (0.0,)
    curvature: Annotated[Values, AXES["curvature"]] = (0.0,)
    stiffening: Annotated[Values, AXES["stiffening"]] = (0.0,)
    bore: Annotated[Values, AXES["bore"]] = (0.0,)
    stage_angle: Annotated[Values, AXES["stage_angle"]] = (0.0,)

    @model_validator(mode="after")
    def _has_walls(self) -> Self:
        mistakes = Mistakes()
        check_bores(mistakes, self.bore, self.theta)
        mistakes.refuse()
        return self

    def chunks(self, grid: str, by_step: bool, fixed: Mapping[str, int]) -> Iterator[Chunk]:
        """Cut the grid into chunks; `fixed` has the largest numbers of values and of rods."""
        sizes = sizes_of(self.axes, fixed.get("rods", MOST_RODS))
        return chunks_of(grid, self.axes, sizes | (SIZES_BY_STEP if by_step else {}) | dict(fixed))


def _kind_of_grid(written: Any) -> str:
    """Return the kind of an entry of the section `grids`, by whether it names a file."""
    is_file = isinstance(written, Mapping) and "points" in written
    return "[PointsSection]" if is_file else "[GridSection]"


Grid: TypeAlias = Annotated[
    Annotated[GridSection, Tag("[GridSection]")] | Annotated[PointsSection, Tag("[PointsSection]")],
    Discriminator(_kind_of_grid),
]


class StateSection(Section):
    """An equilibrium with a given contact point (x1, eta) and the clamp at the origin."""

    theta: Theta = Field(description=AXES["theta"].meaning)
    eta: Eta = Field(description=AXES["eta"].meaning)
    x1: FiniteFloat = Field(
        description="position of the contact point along the surface in units of L, the clamp at 0"
    )
    contact: Contact | None = Field(
        default=None, description="kind of contact of this state (default: the study's)"
    )

    @property
    def axes(self) -> dict[str, Values]:
        """Values of each axis."""
        return {"theta": (self.theta,), "eta": (self.eta,), "x1": (self.x1,)}

    def params(self, contact: Contact) -> dict[str, Any]:
        """Return the solver's inputs; the study's `contact` applies if the state has none."""
        return self.model_dump(mode="json") | {"contact": (self.contact or contact).value}

    @model_validator(mode="after")
    def _is_within_reach(self) -> Self:
        if not self.x1**2 + self.eta**2 < 1:
            raise ValueError("out of reach: a rod of length 1 needs x1^2 + eta^2 < 1")
        return self
