"""Scans of a study file, and the chunks in which they are computed."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise, product
from pathlib import Path
from typing import Annotated, Any, Self, TypeAlias

from pydantic import AfterValidator, BeforeValidator, Field, FiniteFloat, model_validator

from vibrissa.decimals import exact
from vibrissa.outcomes import SlipLaw
from vibrissa.study.axes import AXES, LAW_AXES, MOUNTING_AXES, Values, in_list, spell_value
from vibrissa.study.chunks import ROD_SECONDS, START_SECONDS, Chunk, chunks_of, number_of_points
from vibrissa.study.sections import Count, Mistakes, Name, Section, check_bores
from vibrissa.study.surfaces import PLANE, SurfaceSection, Variant

# Default largest number of values of each axis in a chunk, of surfaces, and of periods. A job then
# takes some 10 s.
SIZES = {"dx0": 4, "theta": 16, "eta": 16, **dict.fromkeys(MOUNTING_AXES, 4)}
MOST_SURFACES, MOST_PERIODS = 64, 2000
# Where a path is given, a period is taken to be this long (L), as periods are not known beforehand.
SHORT_PERIOD = 0.01
# Upper bound of the time of a period (s).
PERIOD_SECONDS = 0.1
# A slip law: its name and the values of the further axes that bear on it, by their names.
Law: TypeAlias = dict[str, Any]


class ScanSection(Section):
    """Scans: all combinations of values of the axes, of surfaces and of slip laws."""

    theta: Annotated[Values, AXES["theta"]]
    eta: Annotated[Values, AXES["eta"]]
    dx0: Annotated[tuple[float, ...], AXES["dx0"]]
    mu0: Annotated[Values | None, AXES["mu0"]] = None
    clamp_angle: Annotated[Values, AXES["clamp_angle"]] = (0.0,)
    clamp_compliance: Annotated[Values, AXES["clamp_compliance"]] = (0.0,)
    curvature: Annotated[Values, AXES["curvature"]] = (0.0,)
    stiffening: Annotated[Values, AXES["stiffening"]] = (0.0,)
    bore: Annotated[Values, AXES["bore"]] = (0.0,)
    stage_angle: Annotated[tuple[float, ...], AXES["stage_angle"]] = (0.0,)
    surface: Annotated[
        list[Name] | None,
        BeforeValidator(in_list, str | list[str]),
        Field(min_length=1),
        AfterValidator(lambda names: list(dict.fromkeys(names))),
    ] = Field(default=None, description="name of a surface, or a list of names; in place of mu0")
    law: Annotated[tuple[str, ...], LAW_AXES["law"]] = (SlipLaw.FREE.value,)
    kinetic_ratio: Annotated[tuple[float, ...] | None, LAW_AXES["kinetic_ratio"]] = None
    damping: Annotated[tuple[float, ...] | None, LAW_AXES["damping"]] = None
    cycles: Count | None = Field(
        default=None, description="number of stick-slip cycles, a whole number from 1"
    )
    to: Annotated[
        list[FiniteFloat] | None, BeforeValidator(in_list, float | list[float]), Field(min_length=1)
    ] = Field(
        default=None,
        description="position in units of L at which the clamp stops, or a list of turning "
        "points, as in [1.5, 0]; in place of cycles",
    )
    each_step: bool = Field(
        default=True,
        description="whether the table `scans` has a row for each step; false: only for the last "
        "step of each scan, so that many scans of small steps make no large table",
    )
    shapes: bool = Field(
        default=False,
        description="whether the table `scans` has the shape of the rod at each step; a figure "
        "that needs the shapes sets it",
    )

    @model_validator(mode="after")
    def _has_its_keys(self) -> Self:
        mistakes = Mistakes()
        for one, other in (("mu0", "surface"), ("cycles", "to")):
            given = [key for key in (one, other) if getattr(self, key) is not None]
            if not given:
                mistakes.add(f"missing {one!r} or {other!r}")
            if len(given) == 2:
                mistakes.add(f"has both {one!r} and {other!r}; remove one of them", other)
        slows = set(self.law) - {SlipLaw.FREE}
        if slows and self.kinetic_ratio is None:
            mistakes.add("missing 'kinetic_ratio': each law except free needs it", "law")
        if self.kinetic_ratio is not None and not slows:
            mistakes.add(
                "the law free has no kinetic friction; remove kinetic_ratio, or set law to "
                f"{SlipLaw.KINETIC}, {SlipLaw.ENERGY} or {SlipLaw.DAMPED}",
                "kinetic_ratio",
            )
        if SlipLaw.DAMPED in self.law and self.damping is None:
            mistakes.add("missing 'damping': the law damped needs it", "law")
        if SlipLaw.DAMPED not in self.law and self.damping is not None:
            text = "the law damped alone has a damping; remove damping, or add the law damped"
            mistakes.add(text, "damping")
        check_bores(mistakes, self.bore, self.theta)
        for place, (begin, end) in enumerate(pairwise([0.0, *(self.to or ())])):
            if abs(exact(end) - exact(begin)) < exact(max(self.dx0)):
                text = f"each part of the path must be at least one step dx0 = {max(self.dx0):g}"
                mistakes.add(f"{text} long", "to", place)
        mistakes.refuse()
        return self

    @property
    def axes(self) -> dict[str, Any]:
        """Values of each axis that the scan states, in increasing order."""
        values = {name: getattr(self, name) for name in (*AXES, *LAW_AXES)}
        return {name: found for name, found in values.items() if found is not None}

    @property
    def rods(self) -> dict[str, Values]:
        """Values of the axes of the rod and of the step."""
        return {name: getattr(self, name) for name in AXES if name != "mu0"}

    @property
    def laws(self) -> list[Law]:
        """Slip laws, each with its ratio and its damping; the law free comes first."""
        laws: list[Law] = [{"law": SlipLaw.FREE.value}] if SlipLaw.FREE in self.law else []
        for law in self.law:
            if law == SlipLaw.FREE:
                continue
            values = {"kinetic_ratio": self.kinetic_ratio or ()}
            if law == SlipLaw.DAMPED:
                values["damping"] = self.damping or ()
            laws += [
                {"law": law, **dict(zip(values, chosen, strict=True))}
                for chosen in product(*values.values())
            ]
        return laws

    @property
    def retracts(self) -> bool:
        """Whether a scan may need states in which the clamp is pulled back."""
        backward = any(end < begin for begin, end in pairwise([0.0, *(self.to or ())]))
        overshoots = any(SlipLaw(law).overshoots for law in self.law)
        return overshoots or backward or self.stage_angle[0] < 0.0

    def steps_or_slips(self, dx0: float) -> int:
        """Count the steps of a path, or the slips of a scan that ends after a number of them."""
        if self.to is None:
            return self.cycles or 0
        way = sum(abs(end - begin) for begin, end in pairwise([0.0, *self.to]))
        return int(way / dx0)

    @property
    def periods(self) -> int:
        """Number of periods in a scan; an estimate if the path is given."""
        return self.cycles or max(1, self.steps_or_slips(max(SHORT_PERIOD, min(self.dx0))))

    def points(self, surfaces: int) -> int:
        """Count the scans, each times its slips or steps, over a number of surfaces."""
        rods = number_of_points({name: self.rods[name] for name in self.rods if name != "dx0"})
        return rods * surfaces * len(self.laws) * sum(self.steps_or_slips(dx0) for dx0 in self.dx0)


def variants_of(
    section: ScanSection, surfaces: Mapping[str, SurfaceSection], folder: Path
) -> list[Variant]:
    """List the surfaces of scans; with `mu0` in place of surfaces, a plane for each coefficient."""
    if section.surface is None:
        return [{"surface": PLANE, "mu0": mu0} for mu0 in section.mu0 or ()]
    return [found for name in section.surface for found in surfaces[name].variants(name, folder)]


@dataclass(frozen=True, kw_only=True)
class ScanChunk:
    """Part of the scans of an entry: those over some surfaces, with some values of the axes.

    Attributes
    ----------
    scan_name : str
        Name of the scans in the study file.
    axes : mapping
        Values of the axes of the rod and of the step.
    first : int
        Number of the first surface among those of the scans, from 1.
    """

    scan_name: str
    axes: Mapping[str, Values]
    first: int
    surfaces: Sequence[Variant]
    laws: Sequence[Law]
    to: Sequence[float] | None
    cycles: int | None
    shapes: bool
    each_step: bool
    periods: int

    @cached_property
    def name(self) -> str:
        """Name such as ``laws/theta1_eta0.85_dx00.001_surface1``."""
        rods = Chunk(grid=self.scan_name, axes=self.axes).name
        return f"{rods}_dx0{spell_value(self.axes['dx0'][0])}_surface{self.first}"

    @property
    def params(self) -> dict[str, Any]:
        """Inputs that determine the rows, as plain values."""
        names = ("scan_name", "axes", "surfaces", "laws", "to", "cycles", "shapes", "each_step")
        return {name: getattr(self, name) for name in names}

    def study_part(self, solver: Mapping[str, str]) -> str:
        """Return the inputs that determine the chunk's rows, as text for its files' metadata."""
        # The content of a file counts, not its path, which may be another in an archive.
        inputs = {**self.params, **solver}
        inputs["surfaces"] = [
            {key: value for key, value in surface.items() if key not in ("profile", "heights")}
            for surface in self.surfaces
        ]
        return "".join(f"{key}: {value}\n" for key, value in inputs.items())

    def minutes(self) -> int:
        """Return the minutes to request from a cluster."""
        scans = number_of_points(self.axes) * len(self.surfaces) * len(self.laws)
        seconds = (
            START_SECONDS
            + ROD_SECONDS * number_of_points(self.axes)
            + PERIOD_SECONDS * scans * self.periods
        )
        return 1 + int(seconds / 60)


def scan_chunks(
    name: str,
    section: ScanSection,
    surfaces: Sequence[Variant],
    fixed: Mapping[str, int],
    shapes: bool,
) -> Iterator[ScanChunk]:
    """Cut scans into chunks.

    An axis has room for what the axes before it leave of `MOST_PERIODS`, so that a value appended
    to an axis of full chunks does not change how the others are cut.

    Parameters
    ----------
    fixed : mapping
        Largest number of values of some axes in a chunk, which replaces the default.
    """
    room = max(1, MOST_PERIODS // (section.periods * len(section.laws)))
    at_once = min(MOST_SURFACES, room)
    room = max(1, room // min(at_once, len(surfaces)))
    sizes = {}
    for axis, most in SIZES.items():
        sizes[axis] = fixed.get(axis, min(most, room))
        room = max(1, room // min(sizes[axis], len(section.rods[axis])))
    for chunk in chunks_of(name, section.rods, sizes):
        for first in range(0, len(surfaces), at_once):
            yield ScanChunk(
                scan_name=name,
                axes=chunk.axes,
                first=first + 1,
                surfaces=surfaces[first : first + at_once],
                laws=section.laws,
                to=section.to,
                cycles=section.cycles,
                shapes=shapes,
                each_step=section.each_step,
                periods=section.periods,
            )
