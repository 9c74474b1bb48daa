"""Figures of a study file: for each kind, what it is drawn from and which axes it fixes."""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Literal, get_args

from pydantic import BeforeValidator, Field

from vibrissa.decimals import spell
from vibrissa.study.grid import AXES, MOUNTING_AXES, ZERO
from vibrissa.study.mistakes import Location, Mistake, spell_axis, unknown_name
from vibrissa.study.values import (
    ClampAngle,
    ClampCompliance,
    Curvature,
    Dx0,
    Eta,
    Mu0,
    OptionalKey,
    Points,
    Section,
    StageAngle,
    Theta,
)


class Figure(Section):
    """A figure: its kind, what it is drawn from, and a caption.

    Attributes
    ----------
    table : str
        Table that the kind is drawn from.
    source : str
        Key that names what it is drawn from, such as a grid.
    """

    table: ClassVar[str]
    source: ClassVar[str]

    caption: str = Field(default="", description="what the figure shows, one or a few sentences")

    @classmethod
    def fixed_axes(cls) -> tuple[str, ...]:
        """Axes of which the kind shows a single value."""
        return tuple(axis for axis in (*AXES, *MOUNTING_AXES) if axis in cls.model_fields)

    def single_axes(self) -> tuple[str, ...]:
        """Axes of which this figure shows a single value."""
        return self.fixed_axes()

    def source_names(self) -> list[str]:
        """Names of what the figure is drawn from."""
        return [getattr(self, self.source)]

    def mistakes(self, location: Location, sections: Mapping[str, Points]) -> Iterator[Mistake]:
        """Find what the figure is drawn from and is not there, or has several of one axis.

        Parameters
        ----------
        location : tuple
            Of the figure.
        sections : mapping of Points
            What the figure can be drawn from, by name.

        Yields
        ------
        Mistake
        """
        for name in self.source_names():
            if name not in sections:
                yield unknown_name((*location, self.source), name, self.source, sections)
                continue
            axes = sections[name].axes
            for axis in MOUNTING_AXES:
                if axis not in type(self).model_fields and len(axes.get(axis, ())) > 1:
                    text = f"{name!r} has several values of {axis}; allowed: one, or kind: mounting"
                    yield Mistake(location=(*location, self.source), text=text)
            for axis in self.single_axes():
                value, values = getattr(self, axis), axes.get(axis, (ZERO,))
                if value is None and len(values) > 1:
                    text = f"missing {axis!r}; the data has several: {spell_axis(values)}"
                    yield Mistake(location=location, text=text)
                if value is not None and value not in values:
                    text = f"{spell(value)} is not allowed; the data has {spell_axis(values)}"
                    yield Mistake(location=(*location, axis), text=text)

    def selection(self) -> dict[str, Any]:
        """Rows of the table that are shown, as `vibrissa.figures.draw.draw` takes them."""
        values = {axis: getattr(self, axis) for axis in self.single_axes()}
        fixed = {
            axis: spell(value) if isinstance(value, tuple) else float(value)
            for axis, value in values.items()
            if value is not None
        }
        return {self.source: getattr(self, self.source), **fixed}


class _GridFigure(Figure):
    table = "stiction"
    source = "grid"

    grid: str = Field(description="name of the grid the figure is drawn from")


class TaperFigure(_GridFigure):
    """x0,max over theta, a series for each mu0."""

    kind: Literal["taper"]
    eta: OptionalKey[Eta] = None
    dx0: OptionalKey[Dx0] = None


class FrictionFigure(_GridFigure):
    """x0,max over mu0."""

    kind: Literal["friction"]
    theta: OptionalKey[Theta] = None
    eta: OptionalKey[Eta] = None
    dx0: OptionalKey[Dx0] = None


class MapFigure(_GridFigure):
    """mu_lock over theta (locking), or what happens over theta and mu0 (regimes), for each eta."""

    kind: Literal["locking", "regimes"]


class LawFigure(_GridFigure):
    """x0_slip and its law near mu_lock (law), or sticking beyond it, too (past_lock), over mu0.

    Both have a series for each theta; past_lock shows the end of the first period and, of round
    rods, the length of the later ones.
    """

    kind: Literal["law", "past_lock"]
    eta: OptionalKey[Eta] = None
    dx0: OptionalKey[Dx0] = None


class _OverMountingFigure(_GridFigure):
    """Base of the figures over an axis of the mounting."""

    over: Literal["clamp_angle", "clamp_compliance", "curvature", "stage_angle"] = Field(
        description="axis of the mounting that has several values; for change two, one of them 0"
    )
    mu0: OptionalKey[Mu0] = None
    dx0: OptionalKey[Dx0] = None
    clamp_angle: OptionalKey[ClampAngle] = None
    clamp_compliance: OptionalKey[ClampCompliance] = None
    curvature: OptionalKey[Curvature] = None
    stage_angle: OptionalKey[StageAngle] = None

    def single_axes(self) -> tuple[str, ...]:
        """All axes with a key of their own, but the one over which the figure is drawn."""
        return tuple(axis for axis in self.fixed_axes() if axis != self.over)

    def mistakes(self, location: Location, sections: Mapping[str, Points]) -> Iterator[Mistake]:
        """Find mistakes as in every figure, and an axis on which not all values are numbers."""
        yield from super().mistakes(location, sections)
        values = sections[self.grid].axes.get(self.over, ()) if self.grid in sections else ()
        if polynomials := [value for value in values if isinstance(value, tuple)]:
            text = f"{self.over} has polynomials ({spell(polynomials[0])}); allowed: numbers"
            yield Mistake(location=(*location, "over"), text=text)


class MountingFigure(_OverMountingFigure):
    """x0_slip, mu_lock and the loads on the clamp over an axis of the mounting, for each theta."""

    kind: Literal["mounting"]
    eta: OptionalKey[Eta] = None


class DeviationFigure(_OverMountingFigure):
    """What a deviation of the mounting changes (change); mu_lock of tapers compared (versus).

    change: mu_lock and x0_slip over theta and eta, in per cent; versus: mu_lock of each taper less
    that of the least one, over the mounting and eta.
    """

    kind: Literal["change", "versus"]

    def mistakes(self, location: Location, sections: Mapping[str, Points]) -> Iterator[Mistake]:
        """Find mistakes as in every figure, and too few or too many deviations."""
        yield from super().mistakes(location, sections)
        if self.kind == "change" and self.grid in sections:
            values = sections[self.grid].axes.get(self.over, (ZERO,))
            if len(values) != 2 or ZERO not in values:
                text = f"{self.over} has {spell_axis(values)}; allowed: two values, one of them 0"
                yield Mistake(location=(*location, "over"), text=text)


class ScanFigure(Figure):
    """One scan: its shapes (scan), first period (period), signals (signals) or swing (swing)."""

    table = "scans"
    source = "scan"

    kind: Literal["scan", "period", "signals", "swing"]
    scan: str = Field(description="name of the scan the figure is drawn from")
    theta: Theta
    mu0: Mu0
    eta: OptionalKey[Eta] = None
    dx0: OptionalKey[Dx0] = None

    def mistakes(self, location: Location, sections: Mapping[str, Points]) -> Iterator[Mistake]:
        """Find mistakes as in every figure, and a swing that the scan does not go through."""
        yield from super().mistakes(location, sections)
        axes = sections[self.scan].axes if self.scan in sections else {}
        mounted = [axis for axis in MOUNTING_AXES if axes.get(axis, (ZERO,)) != (ZERO,)]
        if self.kind == "swing" and mounted:
            text = f"{self.scan!r} has a {mounted[0]}; a swing is followed in the ideal mounting"
            yield Mistake(location=(*location, "scan"), text=text)


class MarginsFigure(Figure):
    """Stability in the plane and out of it over x0 in the first period, for each theta."""

    table = "scans"
    source = "scan"

    kind: Literal["margins"]
    scan: str = Field(description="name of the scan the figure is drawn from")
    mu0: OptionalKey[Mu0] = None
    eta: OptionalKey[Eta] = None
    dx0: OptionalKey[Dx0] = None


def _listed(names: Any) -> Any:
    return [names] if isinstance(names, str) else names


class StateFigure(Figure):
    """Shape of one state, or of several of the same eta."""

    table = "states"
    source = "state"

    kind: Literal["state"]
    state: Annotated[
        list[str],
        Field(
            min_length=1,
            description="name of the state the figure is drawn from, or a list of names",
        ),
        BeforeValidator(
            _listed, json_schema_input_type=str | Annotated[list[str], Field(min_length=1)]
        ),
    ]

    def source_names(self) -> list[str]:
        """Names of what the figure is drawn from."""
        return self.state


class ModelsFigure(Figure):
    """Errors of the point model over theta, for each mu0."""

    table = "comparisons"
    source = "comparison"

    kind: Literal["models"]
    comparison: str = Field(description="name of the comparison the figure is drawn from")
    eta: OptionalKey[Eta] = None


_Kind = (
    TaperFigure
    | FrictionFigure
    | MapFigure
    | LawFigure
    | MountingFigure
    | DeviationFigure
    | ScanFigure
    | MarginsFigure
    | StateFigure
    | ModelsFigure
)
KINDS: tuple[type[Figure], ...] = get_args(_Kind)
AnyFigure = Annotated[
    _Kind,
    Field(
        discriminator="kind", description="a figure: its kind, what it is drawn from, and a caption"
    ),
]
