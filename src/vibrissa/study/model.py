"""The study file: its sections with their keys, and checks that the sections fit together."""

from functools import cached_property
from pathlib import Path
from typing import Any, Literal, Self

import yaml
from pydantic import (
    Field,
    PrivateAttr,
    field_validator,
    model_validator,
)

from vibrissa.outcomes import Contact, RodSection, Solver
from vibrissa.study.axes import FREQUENCIES, MOUNTING_AXES, POWERS
from vibrissa.study.chunks import (
    MOST_RODS,
    SIZES,
    SIZES_BY_STEP,
    Chunk,
)
from vibrissa.study.claims import Claims
from vibrissa.study.data_files import digest_of
from vibrissa.study.figure_data import ReadingData, ScanData
from vibrissa.study.figures import FIGURE_KINDS, Figure, Sections
from vibrissa.study.grids import ComparisonSection, Grid, StateSection
from vibrissa.study.points import PointsChunk, PointsSection
from vibrissa.study.readings import (
    MOST_RECORDINGS,
    ReadingChunk,
    ReadingSection,
    reading_chunks,
)
from vibrissa.study.scans import ScanChunk, ScanSection, scan_chunks, variants_of
from vibrissa.study.sections import Count, Mistakes, Name, Section
from vibrissa.study.surfaces import SurfaceSection, Variant

# Default largest number of points of a study: a table of 1 GB.
MAX_POINTS = 10_000_000
# The keys of the study file that determine each table.
_SOLVED_BY = ("study", "contact", "section", "method", "frequencies")
_KEYS = {
    "stiction": (*_SOLVED_BY, "grids"),
    "scans": (*_SOLVED_BY, "surfaces", "scans"),
    "periods": (*_SOLVED_BY, "surfaces", "scans"),
    "states": ("study", "contact", "frequencies", "states"),
    "comparisons": ("study", "comparisons"),
    "friction": ("study", "contact", "section", "surfaces", "scans", "readings"),
    "claims": (*_SOLVED_BY, "grids", "surfaces", "scans", "states", "claims"),
}


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
    chunk: dict[Literal[(*SIZES, "rods", "recordings")], Count] = Field(  # type: ignore[valid-type]
        default={},
        description="largest number of values of an axis, of rods, and of recordings, that one job "
        "solves, as in {theta: 16} (default: "
        + ", ".join(f"{axis} {size}" for axis, size in SIZES.items())
        + f", rods {MOST_RODS}, and recordings {MOST_RECORDINGS}; all of mu0 and dx0)",
    )
    max_points: Count = Field(
        default=MAX_POINTS,
        description="largest number of points that the study may have, a whole number from 1; each "
        "cycle of a scan and of a recording counts as a point, or each step if its path is given; "
        "it catches a typing error before any work",
    )
    grids: dict[Name, Grid] = Field(
        default={},
        description="named grids of study points; each is the product of its axes, or has the "
        "points of a file",
    )
    surfaces: dict[Name, SurfaceSection] = Field(
        default={}, description="named surfaces, over which scans go"
    )
    scans: dict[Name, ScanSection] = Field(
        default={},
        description="named stick-slip scans: steps with the loads on the clamp, and periods",
    )
    readings: dict[Name, ReadingSection] = Field(
        default={},
        description="named readings: friction read from simulated recordings of a scan",
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

    @field_validator(
        "grids",
        "surfaces",
        "scans",
        "readings",
        "states",
        "comparisons",
        "figures",
        mode="before",
    )
    @classmethod
    def _may_be_empty(cls, value: Any) -> Any:
        return {} if value is None else value

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        """Reject sections that are valid alone but do not fit together."""
        mistakes = Mistakes()
        self._check_surfaces(mistakes)
        self._check_readings(mistakes)
        if not (self.grids or self.scans or self.states or self.comparisons):
            allowed = "an entry of grids, scans, states or comparisons"
            mistakes.add(f"the study has nothing to solve; add {allowed}")
        # The further checks need entries that exist.
        mistakes.refuse()
        if self.points > self.max_points:
            has = f"the study has {self.points:,} points, counting each cycle or step of a scan"
            mistakes.add(f"{has}; allowed: {self.max_points:,}", "max_points")
        if self.method is Solver.SHOOTING:
            self._check_shooting(mistakes)
        self._check_figures(mistakes)
        for place, text in self.claims.misfits(self) if self.claims else ():
            mistakes.add(text, "claims", *place)
        mistakes.refuse()
        return self

    @property
    def points(self) -> int:
        """Number of points; each cycle or step of a scan and of a recording counts as one."""
        solved = (*self.grids.values(), *self.comparisons.values())
        recorded = (
            section.recordings * len(section.transducer) * self._scan_points(section.scan)
            for section in self.readings.values()
        )
        of_scans = map(self._scan_points, self.scans)
        return sum(section.number for section in solved) + sum(of_scans) + sum(recorded)

    def _check_shooting(self, mistakes: Mistakes) -> None:
        """Find what shooting does not solve."""
        axes = [grid.axes for grid in self.grids.values()]
        axes += [scan.rods for scan in self.scans.values()]
        is_ideal = all(one[axis] == (0.0,) for one in axes for axis in MOUNTING_AXES)
        if self.contact is Contact.LINE or not is_ideal:
            needs = "shooting needs `contact: point` and 0 for all axes of the mounting"
            mistakes.add(f"{needs}; allowed here: collocation", "method")
        for name, scan in self.scans.items():
            if scan.retracts:
                text = "the laws energy and damped, and a path backward, need "
                text += "`method: collocation`"
                mistakes.add(text, "scans", name)

    def _check_figures(self, mistakes: Mistakes) -> None:
        """Find figures that show what the study does not compute."""
        for name, figure in self.figures.items():
            if FIGURE_KINDS[figure.kind].frequencies and not self.frequencies:
                mistakes.add("this kind needs `frequencies: 1` or 2", "figures", name, "kind")
            source = self.scans.get(figure.scan or "")
            if source is not None and not source.each_step and figure.drawn_from == "scans":
                text = f"{figure.scan!r} has `each_step: false`: its table `scans` has no steps"
                mistakes.add(text, "figures", name, "scan")
            for place, text in figure.misfits(self._figure_data(figure.source), self.folder):
                mistakes.add(text, "figures", name, *place)

    def _check_surfaces(self, mistakes: Mistakes) -> None:
        """Find scans over unknown surfaces, surfaces that no scan uses, and wrong profiles."""
        used = {surface for scan in self.scans.values() for surface in scan.surface or ()}
        known = ", ".join(sorted(self.surfaces)) or "none is defined"
        for name, scan in self.scans.items():
            for surface in scan.surface or ():
                if surface not in self.surfaces:
                    text = f"{surface!r} is not the name of a surface; allowed: {known}"
                    mistakes.add(text, "scans", name, "surface")
                elif self.surfaces[surface].has_heights:
                    self._check_heights(mistakes, name, surface)
        for name, section in self.surfaces.items():
            if name not in used:
                text = f"no scan uses it; remove it, or set surface: {name} in a scan"
                mistakes.add(text, "surfaces", name)
            for place, text in section.misfits(self._context["folder"]):
                mistakes.add(text, "surfaces", name, *place)

    def _check_readings(self, mistakes: Mistakes) -> None:
        """Find readings of unknown scans, or of scans that no set-up describes."""
        known = ", ".join(sorted(self.scans)) or "none is defined"
        for name, section in self.readings.items():
            scan = self.scans.get(section.scan)
            if scan is None:
                text = f"{section.scan!r} is not the name of a scan; allowed: {known}"
                mistakes.add(text, "readings", name, "scan")
                continue
            if self.method is not Solver.COLLOCATION:
                mistakes.add("readings need `method: collocation`", "readings", name)
            for axis in POWERS:
                if any(isinstance(value, tuple) for value in getattr(scan, axis)):
                    text = f"{section.scan!r} has lists of coefficients; readings need numbers"
                    mistakes.add(text, "scans", section.scan, axis)
            for place, text in section.misfits(self._context["folder"]):
                mistakes.add(text, "readings", name, *place)

    def _check_heights(self, mistakes: Mistakes, scan: str, surface: str) -> None:
        """Find scans over heights that need another kind of contact or another solver."""
        if self.contact is not Contact.POINT:
            text = f"the surface {surface} has heights, which need `contact: point`"
            mistakes.add(text, "scans", scan, "surface")
        if self.method is Solver.SHOOTING:
            text = f"the surface {surface} has heights, which need `method: collocation`"
            mistakes.add(text, "scans", scan, "surface")

    def _scan_points(self, name: str) -> int:
        """Count the cycles of scans, or their steps."""
        return self.scans[name].points(self._surface_count(self.scans[name]))

    def _surface_count(self, scan: ScanSection) -> int:
        """Count the surfaces of a scan."""
        if scan.surface is None:
            return len(scan.mu0 or ())
        return sum(self.surfaces[name].count for name in scan.surface)

    def variants(self, scan: str) -> list[Variant]:
        """List the surfaces of scans, each with one value of each of its axes."""
        return variants_of(self.scans[scan], self.surfaces, self._context["folder"])

    def _figure_data(self, source: str) -> Sections:
        """Return the data of figures by name: each has ``axes``."""
        if source == "reading":
            return {
                name: ReadingData(section, self.scans[section.scan], self.surfaces)
                for name, section in self.readings.items()
            }
        if source != "scan":
            return dict(getattr(self, f"{source}s"))
        return {name: ScanData(scan, self.surfaces) for name, scan in self.scans.items()}

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

    @cached_property
    def figure_params(self) -> dict[str, dict[str, Any]]:
        """All inputs of the drawing of each figure, with its caption and the user's script."""
        return {
            name: {
                **figure.params(),
                "caption": figure.caption_of(self._figure_data(figure.source)),
                "script": (self.folder / figure.script).as_posix() if figure.script else None,
            }
            for name, figure in self.figures.items()
        }

    @property
    def tables(self) -> list[str]:
        """Names of the tables that the study makes."""
        return [name for name, keys in _KEYS.items() if getattr(self, keys[-1])]

    @property
    def with_shapes(self) -> set[str]:
        """Names of scans whose shapes are kept: the entry or a figure asks for them."""
        figures = [one for one in self.figures.values() if FIGURE_KINDS[one.kind].has_shapes]
        asking = {name for figure in figures for name in figure.names}
        return asking | {name for name, scan in self.scans.items() if scan.shapes}

    @cached_property
    def scan_chunks(self) -> dict[str, ScanChunk]:
        """Chunks of all scans by name; one job computes one chunk."""
        by_step = SIZES_BY_STEP if self.method.by_step else {}
        return {
            chunk.name: chunk
            for name, scan in self.scans.items()
            for chunk in scan_chunks(
                name,
                scan,
                self.variants(name),
                fixed=by_step | self.chunk,
                shapes=name in self.with_shapes,
            )
        }

    @cached_property
    def reading_chunks(self) -> dict[str, ReadingChunk]:
        """Chunks of all readings by name; one job simulates and reads one chunk."""
        return {
            chunk.name: chunk
            for name, section in self.readings.items()
            for chunk in reading_chunks(
                name,
                section,
                self.scans[section.scan],
                self.variants(section.scan),
                section.transducers(self.folder),
                most=self.chunk.get("recordings", MOST_RECORDINGS),
            )
        }

    @property
    def data_files(self) -> list[str]:
        """Files beside the study file that it names, relative to it."""
        measured = [name for surface in self.surfaces.values() for name in surface.files]
        scripts = [figure.script for figure in self.figures.values()]
        points = [grid.points for grid in self.grids.values() if isinstance(grid, PointsSection)]
        cards = [name for section in self.readings.values() for name in section.files]
        return sorted({name for name in (*measured, *scripts, *points, *cards) if name})

    @cached_property
    def chunks(self) -> dict[str, Chunk | PointsChunk]:
        """Chunks of all grids by name; one job solves one chunk."""
        return {
            chunk.name: chunk
            for name, grid in self.grids.items()
            for chunk in grid.chunks(name, self.method.by_step, self.chunk)
        }

    @property
    def solver(self) -> dict[str, str]:
        """The solver and what it solves, as plain values."""
        return {"contact": self.contact, "section": self.section, "method": self.method}

    @property
    def solver_settings(self) -> dict[str, Any]:
        """The solver, and what it computes at each point of a grid or scan, as plain values."""
        return {**self.solver, "frequencies": self.frequencies}

    def chunk_part(self, name: str) -> str:
        """Return the inputs that determine a chunk, as text for the metadata of its table."""
        return self.chunks[name].study_part(self.solver_settings)

    def scan_chunk_part(self, name: str) -> str:
        """Return the inputs that determine a chunk of scans, as text for its tables' metadata."""
        return self.scan_chunks[name].study_part(self.solver_settings)

    def reading_chunk_part(self, name: str) -> str:
        """Return the inputs that determine a chunk of readings, as text for its metadata."""
        return self.reading_chunks[name].study_part(self.reading_settings)

    @property
    def reading_settings(self) -> dict[str, str]:
        """What holds for all recordings of the study, as plain values."""
        return {"contact": self.contact, "section": self.section}

    @property
    def folder(self) -> Path:
        """Folder of the study file, to which paths in it are relative."""
        return Path(self._context["folder"])

    @property
    def text(self) -> str:
        """Text of the study file, with changes from the command line appended as comments."""
        return str(self._context["text"])

    def study_part(self, table: str) -> str:
        """Part of the study file that determines a table, as text for the table's metadata."""
        written = self._context["written"]
        chosen = {key: written[key] for key in _KEYS[table] if key in written}
        if "scans" in _KEYS[table]:
            # The content of a profile counts, wherever the file is.
            contents = {
                variant["surface"]: variant["content"]
                for name in self.scans
                for variant in self.variants(name)
                if "content" in variant
            }
            chosen |= {"profiles": contents} if contents else {}
        if "grids" in _KEYS[table]:
            points = {
                name: grid.table.digest()
                for name, grid in self.grids.items()
                if isinstance(grid, PointsSection)
            }
            chosen |= {"points": points} if points else {}
        if table == "friction":
            cards = {
                name: digest_of(self.folder / name)
                for section in self.readings.values()
                for name in section.files
            }
            chosen |= {"transducers": cards} if cards else {}
        if table == "scans" and self.with_shapes:
            chosen["with_shapes"] = sorted(self.with_shapes)
        return yaml.safe_dump(chosen, sort_keys=False)
