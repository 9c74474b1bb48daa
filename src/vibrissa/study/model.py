"""The study file: its sections with their keys, and checks that the sections fit together."""

from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import yaml
from pydantic import Field, FiniteFloat, PrivateAttr, field_validator, model_validator

from vibrissa.outcomes import Contact, RodSection, Solver
from vibrissa.study.axes import AXES, FREQUENCIES, MOUNTING_AXES, Eta, Theta, Values
from vibrissa.study.chunks import (
    MOST_RODS,
    SIZES,
    SIZES_BY_STEP,
    Chunk,
    chunks_of,
    number_of_points,
    sizes_of,
)
from vibrissa.study.claims import Claims
from vibrissa.study.figures import FIGURE_KINDS, Figure
from vibrissa.study.sections import Count, Mistakes, Name, Section

# Default largest number of points of a study: a table of 1 GB.
MAX_POINTS = 10_000_000
# The keys of the study file that determine each table.
_SOLVED_BY = ("study", "contact", "section", "method", "frequencies")
_KEYS = {
    "stiction": (*_SOLVED_BY, "grids"),
    "scans": (*_SOLVED_BY, "scans"),
    "states": ("study", "contact", "frequencies", "states"),
    "comparisons": ("study", "comparisons"),
    "claims": (*_SOLVED_BY, "grids", "scans", "states", "claims"),
}


class _Points(Section):
    """All combinations of the values of some axes."""

    theta: Annotated[Values, AXES["theta"]]
    mu0: Annotated[Values, AXES["mu0"]]
    eta: Annotated[Values, AXES["eta"]]

    @property
    def axes(self) -> dict[str, Values]:
        """Values of each axis in increasing order."""
        return {name: getattr(self, name) for name in AXES if name in type(self).model_fields}


class ComparisonSection(_Points):
    """Points that are solved in both kinds of contact: all combinations of theta, mu0 and eta."""


class GridSection(_Points):
    """Points at which a period of sticking is solved: all combinations of values of the axes."""

    dx0: Annotated[Values, AXES["dx0"]]
    clamp_angle: Annotated[Values, AXES["clamp_angle"]] = (0.0,)
    clamp_compliance: Annotated[Values, AXES["clamp_compliance"]] = (0.0,)
    curvature: Annotated[Values, AXES["curvature"]] = (0.0,)
    stage_angle: Annotated[Values, AXES["stage_angle"]] = (0.0,)


class ScanSection(GridSection):
    """Stick-slip scans, one at each point of a grid, each of the same number of cycles."""

    cycles: Count = Field(description="number of stick-slip cycles, a whole number from 1")


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


class Study(Section):
    """One parameter study of the sticking period of a tapered rod."""

    name: Name = Field(
        alias="study",
        description="name of the study, letters, digits, _ and -; results go to `results/<study>/`",
    )
    title: str = Field(default="", description="heading of the report (default: the name)")
    contact: Contact = Field(
        default=Contact.POINT,
        description="kind of contact: point (the tip alone touches the surface) or line (the rod "
        "lies along the surface where it would pass through it)",
    )
    section: RodSection = Field(
        default=RodSection.ROUND,
        description="cross-section: round (a self-locking rod buckles laterally) or planar (a "
        "strip, or a guided rod, stays in its plane)",
    )
    method: Solver = Field(
        default=Solver.COLLOCATION,
        description="solver: collocation, or shooting (the paper's own, slow)",
    )
    frequencies: int = Field(
        default=0,
        ge=0,
        le=len(FREQUENCIES),
        description="number of natural frequencies that the tables have, 0 to 2; they cost some "
        "milliseconds for each onset, step of a scan and state",
    )
    strict: bool = Field(
        default=False,
        description="whether a point with the status failed ends the run with an error",
    )
    chunk: dict[Literal[tuple(SIZES)], Count] = Field(  # type: ignore[valid-type]
        default={},
        description="largest number of values of an axis that one job solves, as in {theta: 16} "
        "(default: "
        + ", ".join(f"{axis} {size}" for axis, size in SIZES.items())
        + f", and {MOST_RODS} rods in all; all of mu0 and dx0)",
    )
    max_points: Count = Field(
        default=MAX_POINTS,
        description="largest number of points that the study may have, a whole number from 1; each "
        "cycle of a scan counts as a point; it catches a typing error before any work",
    )
    grids: dict[Name, GridSection] = Field(
        min_length=1, description="named grids of study points; each is the product of its axes"
    )
    scans: dict[Name, ScanSection] = Field(
        default={},
        description="named stick-slip scans; shapes and loads on the clamp are kept step by step",
    )
    states: dict[Name, StateSection] = Field(
        default={}, description="named single equilibria with a given position of the tip"
    )
    comparisons: dict[Name, ComparisonSection] = Field(
        default={}, description="named sets of points that are solved in both kinds of contact"
    )
    claims: Claims | None = Field(
        default=None,
        description="names of the grids, the scan and the state by which the paper's statements "
        "are judged",
    )
    figures: dict[Name, Figure] = Field(
        default={},
        description="named figures, each drawn from one grid, scan or comparison, or from states",
    )
    # The study file: its values (`written`), its `text` and its `folder`.
    _context: dict[str, Any] = PrivateAttr(default={})

    def model_post_init(self, context: Any) -> None:
        """Keep the raw content of the study file."""
        self._context = context

    @field_validator("scans", "states", "comparisons", "figures", mode="before")
    @classmethod
    def _may_be_empty(cls, value: Any) -> Any:
        return {} if value is None else value

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        """Reject sections that are valid alone but do not fit together."""
        mistakes = Mistakes()
        solved = (*self.grids.values(), *self.scans.values(), *self.comparisons.values())
        points = sum(number_of_points(one.axes) * getattr(one, "cycles", 1) for one in solved)
        if points > self.max_points:
            has = f"the study has {points:,} points, counting each cycle of a scan"
            mistakes.add(f"{has}; allowed: {self.max_points:,}", "max_points")
        if self.method is Solver.SHOOTING:
            axes = [grid.axes for grid in (*self.grids.values(), *self.scans.values())]
            is_ideal = all(one[axis] == (0.0,) for one in axes for axis in MOUNTING_AXES)
            if self.contact is Contact.LINE or not is_ideal:
                needs = "shooting needs `contact: point` and 0 for all axes of the mounting"
                mistakes.add(f"{needs}; allowed here: collocation", "method")
        for name, figure in self.figures.items():
            if FIGURE_KINDS[figure.kind].frequencies and not self.frequencies:
                mistakes.add("this kind needs `frequencies: 1` or 2", "figures", name, "kind")
            sections = getattr(self, f"{figure.source}s")
            for place, text in figure.misfits(sections, self.folder):
                mistakes.add(text, "figures", name, *place)
        for place, text in self.claims.misfits(self) if self.claims else ():
            mistakes.add(text, "claims", *place)
        mistakes.refuse()
        return self

    @property
    def results(self) -> list[str]:
        """Files that the study makes for its reader, relative to ``results/<study>/``."""
        return [
            *(f"tables/{name}.parquet" for name in self.tables),
            *self.figure_files,
            *(["figures/captions.md"] if self.figures else []),
            *(["claims.md"] if self.claims else []),
            "summary.txt",
            "report.html",
        ]

    @property
    def figure_files(self) -> list[str]:
        """Files of the figures, relative to ``results/<study>/``; the report shows the PNG."""
        return [
            f"figures/{name}.{ending}"
            for name, figure in self.figures.items()
            for ending in (*figure.formats, "png")
        ]

    @property
    def figure_params(self) -> dict[str, dict[str, Any]]:
        """All inputs of the drawing of each figure, with its caption and the user's script."""
        return {
            name: {
                **figure.params(),
                "caption": figure.caption_of(getattr(self, f"{figure.source}s")),
                "script": (self.folder / figure.script).as_posix() if figure.script else None,
            }
            for name, figure in self.figures.items()
        }

    @property
    def tables(self) -> list[str]:
        """Names of the tables that the study makes."""
        return [name for name, keys in _KEYS.items() if getattr(self, keys[-1])]

    @cached_property
    def chunks(self) -> dict[str, Chunk]:
        """Chunks of all grids by name; one job solves one chunk."""
        fixed = (SIZES_BY_STEP if self.method.by_step else {}) | self.chunk
        return {
            chunk.name: chunk
            for name, grid in self.grids.items()
            for chunk in chunks_of(name, grid.axes, sizes_of(grid.axes) | fixed)
        }

    @property
    def solver(self) -> dict[str, str]:
        """The solver and what it solves, as plain values."""
        return {"contact": self.contact, "section": self.section, "method": self.method}

    @property
    def solved(self) -> dict[str, Any]:
        """The solver, and what it computes at each point of a grid, as plain values."""
        return {**self.solver, "frequencies": self.frequencies}

    def chunk_part(self, name: str) -> str:
        """Return the inputs that determine a chunk, as text for the metadata of its table."""
        return self.chunks[name].part(self.solved)

    @property
    def folder(self) -> Path:
        """Folder of the study file, to which paths in it are relative."""
        return Path(self._context["folder"])

    @property
    def text(self) -> str:
        """Text of the study file, with changes from the command line appended as comments."""
        return str(self._context["text"])

    def part(self, table: str) -> str:
        """Part of the study file that determines a table, as text for the table's metadata."""
        written = self._context["written"]
        chosen = {key: written[key] for key in _KEYS[table] if key in written}
        return yaml.safe_dump(chosen, sort_keys=False)
