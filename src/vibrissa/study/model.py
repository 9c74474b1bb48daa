"""The study file: its sections with their keys, and what has to fit together among them.

The schema, the reference page and the messages about mistakes are made from these classes.
"""

import math
from collections.abc import Iterator, Mapping
from functools import cached_property
from itertools import pairwise
from typing import Self

from pydantic import Field, model_validator

from vibrissa.decimals import spell
from vibrissa.outcomes import Contact, RodSection, Solver
from vibrissa.study.boxes import Box, disjoint, size
from vibrissa.study.claims import Claims
from vibrissa.study.costs import LONGEST_JOB, curve_seconds
from vibrissa.study.figures import AnyFigure
from vibrissa.study.grid import (
    MOUNTING_AXES,
    CurveKey,
    Grid,
    Refinement,
    curve_keys,
    most_added,
)
from vibrissa.study.mistakes import Location, Mistake
from vibrissa.study.values import (
    X1,
    ClampAngleAxis,
    ClampComplianceAxis,
    Count,
    CurvatureAxis,
    Dx0Axis,
    Eta,
    EtaAxis,
    Mu0Axis,
    Name,
    OptionalKey,
    Points,
    RefineSection,
    Section,
    StageAngleAxis,
    Theta,
    ThetaAxis,
)

# Curves per job, by default at least so many: a collocation curve takes milliseconds, a walk by
# shooting many seconds.
LEAST_BLOCK_SIZE = {Solver.COLLOCATION: 64, Solver.SHOOTING: 1}
# Points of a study, if it does not say otherwise: those of a table of 1 GB.
MAX_POINTS = 10_000_000
# Travel of the clamp in a cycle, by which the steps of scans are estimated; few are longer (L).
TRAVEL = 0.1
# Formats in which each figure is drawn.
FIGURE_ENDINGS = ("pdf", "svg", "png")
# Bound on the rows of a scan, each of which carries a shape.
LONGEST_SCAN = 1_000_000


class ComparisonSection(Points):
    """Points that are solved in both kinds of contact: all combinations of three axes."""

    theta: ThetaAxis
    mu0: Mu0Axis
    eta: EtaAxis


class _PeriodPoints(Points):
    """Points at which a period of sticking is solved: all combinations of their axes."""

    theta: ThetaAxis
    mu0: Mu0Axis
    eta: EtaAxis
    dx0: Dx0Axis
    clamp_angle: OptionalKey[ClampAngleAxis] = Field(default=None)
    clamp_compliance: OptionalKey[ClampComplianceAxis] = Field(default=None)
    curvature: OptionalKey[CurvatureAxis] = Field(default=None)
    stage_angle: OptionalKey[StageAngleAxis] = Field(default=None)

    @cached_property
    def grid(self) -> Grid:
        """The points."""
        return Grid(**self.axes)


class GridSection(_PeriodPoints):
    """Points at which a period of sticking is solved: all combinations of their axes."""

    refine: OptionalKey[RefineSection] = Field(
        default=None,
        description="add points where the grid is too coarse: the keys column, tolerance and "
        "closest (default: no points are added)",
    )

    @property
    def refinement(self) -> Refinement | None:
        """How points are added; None if they are not."""
        return None if self.refine is None else self.refine.refinement

    def most(self, axis: str) -> int:
        """Values of an axis, the most that may be added to it among them."""
        values = getattr(self.grid, axis)
        closest = {} if self.refinement is None else self.refinement.closest
        if axis not in closest:
            return len(values)
        gaps = (stop - start for start, stop in pairwise(values))
        return len(values) + sum(most_added(gap, closest[axis]) for gap in gaps)

    @property
    def most_curves(self) -> int:
        """Curves with the same step, the most that may be added among them.

        They are added along θ at each η of the grid, and along η at each θ.
        """
        thetas, etas = len(self.grid.theta), len(self.grid.eta)
        pairs = self.most("theta") * etas + thetas * self.most("eta") - thetas * etas
        return pairs * sum(1 for _ in self.grid.mountings())

    @property
    def count(self) -> int:
        """Number of points; where some may be added, with the most that can be."""
        if self.refine is None:
            return super().count
        return self.most_curves * self.most("mu0") * len(self.grid.dx0)


class ScanSection(_PeriodPoints):
    """Stick-slip scans, one at each point of a grid, each of the same number of cycles."""

    cycles: Count = Field(description="number of stick-slip cycles, a whole number from 1")


class StateSection(Points):
    """An equilibrium with a given contact point (x1, eta), the clamp at the origin."""

    theta: Theta
    eta: Eta
    x1: X1
    contact: OptionalKey[Contact] = Field(
        default=None,
        description="kind of contact of this state: point or line (default: the study's)",
    )

    @model_validator(mode="after")
    def _is_within_reach(self) -> Self:
        if self.x1**2 + self.eta**2 >= 1:
            raise ValueError("out of reach: a rod of length 1 needs x1^2 + eta^2 < 1")
        return self


class Study(Section):
    """One parameter study of the sticking period of a tapered rod."""

    name: Name = Field(
        alias="study",
        description="name of the study, letters, digits, _ and -; results go to `results/<study>/`",
    )
    contact: Contact = Field(
        default=Contact.POINT,
        description="kind of contact: point (the tip alone touches the surface) or line (the rod "
        "lies along the surface where it would pass through it)",
    )
    section: RodSection = Field(
        default=RodSection.ROUND,
        description="what the section lets the rod do: round (a self-locking rod swings aside, out "
        "of its plane) or planar (a strip, or a guided rod, stays in it)",
    )
    method: Solver = Field(
        default=Solver.COLLOCATION,
        description="how curves are solved: collocation or shooting (the paper's own, slow)",
    )
    block_size: OptionalKey[Count] = Field(
        default=None,
        description="sticking curves that one job solves, a whole number from 1 (default: an "
        "eighth of them, at least 64, at most ten minutes of work; shooting 1)",
    )
    max_points: Count = Field(
        default=MAX_POINTS,
        description="largest number of points that the study may have, and of steps of its scans, "
        "a whole number from 1; it stops a slip of the pen before any work",
    )
    grids: dict[Name, GridSection] = Field(
        min_length=1,
        description="named grids of study points; each is the product of its axes",
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
    claims: OptionalKey[Claims] = Field(
        default=None,
        description="names of the grids, the scan and the state by which the paper's statements "
        "are judged: taper (its Figure 6), friction (7), scan (3 to 5) and state (8)",
    )
    figures: dict[Name, AnyFigure] = Field(
        default={},
        description="named figures, each drawn from one grid, scan, state or comparison",
    )

    @property
    def blocks_name(self) -> str:
        """Contact, section and solver in one word: names the blocks' folder and their plan."""
        section = "" if self.section is RodSection.ROUND else f"-{self.section}"
        return f"{self.contact}{section}-{self.method}"

    @property
    def results(self) -> list[str]:
        """Files that the study makes for its reader, relative to `results/<study>/`."""
        tables = {
            "stiction": True,
            "scans": self.scans,
            "states": self.states,
            "comparisons": self.comparisons,
            "claims": self.claims,
        }
        return [
            *(f"tables/{name}.parquet" for name, wanted in tables.items() if wanted),
            *(f"figures/{name}.{ending}" for name in self.figures for ending in FIGURE_ENDINGS),
            *(["figures/captions.md"] if self.figures else []),
            *(["claims.md"] if self.claims else []),
            "report.html",
        ]

    @cached_property
    def point_grids(self) -> dict[str, Grid]:
        """Grids of the study's points, by name."""
        return {name: section.grid for name, section in self.grids.items()}

    @cached_property
    def refinements(self) -> dict[str, Refinement]:
        """How points are added to those grids to which they are, by name."""
        found = {name: section.refinement for name, section in self.grids.items()}
        return {name: refinement for name, refinement in found.items() if refinement is not None}

    @property
    def points_on_curve(self) -> int:
        """Most points that are read off one curve."""
        return sum(section.most("mu0") * len(section.grid.dx0) for section in self.grids.values())

    @cached_property
    def scan_grids(self) -> dict[str, Grid]:
        """Grids of the points at which the study has scans, by name."""
        return {name: section.grid for name, section in self.scans.items()}

    @cached_property
    def curves(self) -> list[Box]:
        """Curves that the study needs, in boxes that have none in common."""
        grids = [*self.point_grids.values(), *self.scan_grids.values()]
        return disjoint(grid.curves(self.method.by_step) for grid in grids)

    @property
    def curve_keys(self) -> list[CurveKey]:
        """Curves that the study needs, each once, ordered by η, then θ, then Δx0."""
        return list(curve_keys(self.curves))

    @property
    def curves_per_job(self) -> int:
        """Largest number of curves that one job solves."""
        if self.block_size:
            return self.block_size
        seconds = sum(curve_seconds(box, self.method, self.contact) for box in self.curves)
        return default_block_size(self.method, sum(map(size, self.curves)), seconds)

    def scan_steps(self, travel: float) -> int:
        """Estimate the steps of all scans from how far the clamp moves in a cycle (L)."""
        return sum(
            int(scan.count / len(scan.grid.dx0) * scan.cycles * travel / float(step)) + 1
            for scan in self.scans.values()
            for step in scan.grid.dx0
        )

    def _excess(self) -> Mistake | None:
        """Find whether there are too many points, without making one."""
        named: dict[str, Mapping[str, Points]] = {
            "grids": self.grids,
            "scans": self.scans,
            "comparisons": self.comparisons,
        }
        counts = {
            (section, name): points.count
            for section, entries in named.items()
            for name, points in entries.items()
        }
        if (total := sum(counts.values())) <= self.max_points:
            return None
        largest = max(counts, key=counts.__getitem__)
        text = (
            f"{counts[largest]:,} points, of {total:,} of the study, are not allowed; allowed: up "
            f"to {self.max_points:,} in all (the key max_points sets this limit)"
        )
        return Mistake(location=largest, text=text)

    def _mounting_mistakes(self) -> Iterator[Mistake]:
        """Find mountings that the method does not allow."""
        for kind, sections in (("grids", self.point_grids), ("scans", self.scan_grids)):
            for name, grid in sections.items():
                mounted = [axis for axis in grid.axes if axis in MOUNTING_AXES]
                if mounted and self.method is Solver.SHOOTING:
                    text = "is not allowed with method: shooting; collocation is"
                    yield Mistake(location=(kind, name, mounted[0]), text=text)

    def _shooting_mistakes(self, location: Location, refinement: Refinement) -> Iterator[Mistake]:
        """Find curves that would be added one by one, each by a long walk."""
        if self.method is Solver.SHOOTING:
            for axis in refinement.curve_axes:
                text = f"{axis!r} is not allowed with method: shooting; collocation is"
                yield Mistake(location=(*location, "closest", axis), text=text)

    def mistakes(self) -> Iterator[Mistake]:
        """Find what does not fit together, although each section is as it should be.

        Yields
        ------
        Mistake
        """
        if self.contact is Contact.LINE and self.method is Solver.SHOOTING:
            text = "'shooting' is not allowed with contact: line; allowed: collocation"
            yield Mistake(location=("method",), text=text)
        if (excess := self._excess()) is not None:
            yield excess
            return  # the rest looks at the points
        yield from self._mounting_mistakes()
        for name, section in self.grids.items():
            if section.refine is not None:
                place = ("grids", name, "refine")
                yield from section.refine.mistakes(place, name, self.point_grids, self.refinements)
                yield from self._shooting_mistakes(place, section.refine.refinement)
        for name, scan in self.scans.items():
            # The clamp moves by less than the rod's length in a cycle, by twice that in a first one
            # in which the rod swings aside.
            step = min(scan.grid.dx0)
            if (rows := (scan.cycles + 1) / step) > LONGEST_SCAN:
                text = (
                    f"{scan.cycles} cycles in steps of dx0 = {spell(step)} can take {rows:.1g} "
                    f"steps; allowed: (cycles + 1)/dx0 up to {LONGEST_SCAN:.0e}"
                )
                yield Mistake(location=("scans", name), text=text)
        if self.scans and (steps := self.scan_steps(TRAVEL)) > self.max_points:
            text = (
                f"some {steps:,} steps in all are not allowed; allowed: up to {self.max_points:,} "
                "(the key max_points sets this limit)"
            )
            yield Mistake(location=("scans",), text=text)
        named: dict[str, Mapping[str, Points]] = {
            "grid": self.grids,
            "scan": self.scans,
            "state": self.states,
            "comparison": self.comparisons,
        }
        for name, figure in self.figures.items():
            yield from figure.mistakes(("figures", name), named[figure.source])
        if self.claims is not None:
            if self.contact is not Contact.POINT:
                text = f"contact: {self.contact.value!r} is not allowed with it; point is"
                yield Mistake(location=("claims",), text=text)
            yield from self.claims.mistakes(named)
            for key, source in self.claims.sources.items():
                if source == "grid" and getattr(self.claims, key) in self.refinements:
                    text = f"{getattr(self.claims, key)!r} has refine; allowed: a grid without it"
                    yield Mistake(location=("claims", key), text=text)


def default_block_size(method: Solver, curves: int, seconds: float) -> int:
    """Curves per job where the study file does not say it.

    An eighth of the curves, for eight cores, but at least `LEAST_BLOCK_SIZE` and, if that allows
    it, no more than take `LONGEST_JOB`.

    Parameters
    ----------
    method : Solver
    curves : int
        Number of curves that the study needs.
    seconds : float
        What they may take together.

    Returns
    -------
    int
    """
    if method is Solver.SHOOTING:
        return LEAST_BLOCK_SIZE[method]
    longest = int(LONGEST_JOB * curves / seconds)
    return max(LEAST_BLOCK_SIZE[method], min(math.ceil(curves / 8), longest))
