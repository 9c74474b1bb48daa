"""Figures of a study file: what each kind is drawn from, and the keys that it takes."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, ValidationInfo, create_model, model_validator

from vibrissa.study.axes import (
    AXES,
    MOUNTING_AXES,
    Mistake,
    Value,
    Values,
    at,
    refuse,
    spell_value,
    spell_values,
)
from vibrissa.study.sections import OptionalKey, Section

# What a figure is drawn from: key in the study file, and table. With an s the key is the section.
TABLES = {
    "grid": "stiction",
    "scan": "scans",
    "state": "states",
    "comparison": "comparisons",
}


@dataclass(frozen=True, kw_only=True)
class FigureKind:
    """A kind of figure; `vibrissa.figures` has the function that draws it, under the same name.

    Attributes
    ----------
    shows : str
        What it shows.
    source : str
        What it is drawn from: a key of `TABLES`.
    single : tuple of str
        Axes of which it shows one value. The key may be left out where the data have one.
    required : tuple of str
        Further keys that must be given.
    """

    shows: str
    source: str = "grid"
    single: tuple[str, ...] = ()
    required: tuple[str, ...] = ()

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys that it takes."""
        return ("kind", self.source, *self.single, *self.required, "caption")


_POINT = ("theta", "mu0", "eta", "dx0")
_MOUNTED = ("mu0", "dx0", *MOUNTING_AXES)


def _of_scan(shows: str) -> FigureKind:
    return FigureKind(shows=shows, source="scan", single=_POINT)


KINDS: Mapping[str, FigureKind] = {
    "taper": FigureKind(shows="x0,max over theta, a series for each mu0", single=("eta", "dx0")),
    "friction": FigureKind(shows="x0,max over mu0", single=("theta", "eta", "dx0")),
    "locking": FigureKind(shows="mu_lock over theta, a series for each eta"),
    "regimes": FigureKind(shows="slip, lying and locking over theta and mu0, a map for each eta"),
    "law": FigureKind(
        shows="x0_slip and its law near mu_lock, a series for each theta", single=("eta", "dx0")
    ),
    "past_lock": FigureKind(
        shows="x0_slip and sticking past mu_lock over mu0, a series for each theta",
        single=("eta", "dx0"),
    ),
    "mounting": FigureKind(
        shows="x0_slip, mu_lock and the loads on the clamp over an axis of the mounting",
        single=("eta", *_MOUNTED),
        required=("over",),
    ),
    "change": FigureKind(
        shows="per cent by which a mounting changes mu_lock and x0_slip, over theta and eta",
        single=_MOUNTED,
        required=("over",),
    ),
    "versus": FigureKind(
        shows="mu_lock of each taper less that of the least one, over the mounting and eta",
        single=_MOUNTED,
        required=("over",),
    ),
    "scan": _of_scan("shapes of one scan, step by step"),
    "period": _of_scan("shapes in the first period of one scan"),
    "signals": _of_scan("loads on the clamp in one scan"),
    "swing": _of_scan("one scan in space while the rod buckles laterally"),
    "margins": FigureKind(
        shows="stability in the plane and out of it over x0, for each theta",
        source="scan",
        single=("mu0", "eta", "dx0"),
    ),
    "state": FigureKind(shows="shapes of one or more states of the same eta", source="state"),
    "models": FigureKind(
        shows="errors of tip contact over theta, for each mu0",
        source="comparison",
        single=("eta",),
    ),
}


def _listed(names: Any) -> Any:
    return [names] if isinstance(names, str) else names


# Optional keys, one for each axis.
_Axes = create_model(
    "_Axes",
    __base__=Section,
    **{name: (Annotated[Value | None, at(axis)], None) for name, axis in AXES.items()},  # type: ignore[call-overload]
)


class Figure(_Axes):  # type: ignore[misc,valid-type]
    """A figure: its kind, what it is drawn from, and a caption."""

    kind: Literal[tuple(KINDS)]  # type: ignore[valid-type]
    caption: str = Field(default="", description="what the figure shows, one or a few sentences")
    grid: OptionalKey[str] = Field(default=None, description="name of the grid it is drawn from")
    scan: OptionalKey[str] = Field(default=None, description="name of the scan it is drawn from")
    state: OptionalKey[Annotated[list[str], BeforeValidator(_listed, str | list[str])]] = Field(
        default=None, description="name of the state it is drawn from, or a list of names"
    )
    comparison: OptionalKey[str] = Field(
        default=None, description="name of the comparison it is drawn from"
    )
    over: OptionalKey[Literal[MOUNTING_AXES]] = Field(  # type: ignore[valid-type]
        default=None, description="axis of the mounting that has several values"
    )

    @property
    def of_kind(self) -> FigureKind:
        """What its kind takes."""
        return KINDS[self.kind]

    @property
    def table(self) -> str:
        """Table that it is drawn from."""
        return TABLES[self.of_kind.source]

    @property
    def single(self) -> tuple[str, ...]:
        """Axes of which it shows one value."""
        return tuple(axis for axis in self.of_kind.single if axis != self.over)

    def selection(self) -> dict[str, Any]:
        """Rows of the table that are shown, as `vibrissa.figures.draw.draw` takes them."""
        source = self.of_kind.source
        chosen = {axis: getattr(self, axis) for axis in self.single}
        return {
            source: getattr(self, source),
            **{axis: value for axis, value in chosen.items() if value is not None},
        }

    @model_validator(mode="after")
    def _fits(self, info: ValidationInfo) -> Self:
        """Check the keys of the kind, and the data that it is drawn from."""
        given = self.model_fields_set
        source = self.of_kind.source
        mistakes: list[Mistake] = []
        allowed = self.of_kind.keys
        for key in sorted(given - set(allowed)):
            text = f"is not a key of kind {self.kind}; allowed: {', '.join(allowed)}"
            mistakes.append(((key,), text))
        for key in (source, *self.of_kind.required):
            if key not in given:
                mistakes.append(((), f"missing {key!r}"))
        # Sections that have mistakes of their own are not here.
        sections = (info.context or {}).get(f"{source}s")
        if not mistakes and sections is not None:
            named = getattr(self, source)
            for name in named if isinstance(named, list) else [named]:
                if name not in sections:
                    mistakes.append(((source,), unknown_name(name, source, sections)))
                else:
                    mistakes += self._misfits(name, sections[name].axes)
        if mistakes:
            refuse(mistakes)
        return self

    def _misfits(self, name: str, axes: Mapping[str, Values]) -> list[Mistake]:
        """Find axes of which the data have several values, or not the value that is asked for."""
        mistakes: list[Mistake] = []
        source = self.of_kind.source
        for axis in self.single:
            value, values = getattr(self, axis), axes.get(axis, (0.0,))
            if value is None and len(values) > 1:
                text = f"missing {axis!r}; {name!r} has several: {spell_values(values)}"
                mistakes.append(((), text))
            if value is not None and value not in values:
                text = f"{spell_value(value)} is not allowed; {name!r} has {spell_values(values)}"
                mistakes.append(((axis,), text))
        if self.over is None:
            several = [
                a for a in MOUNTING_AXES if a not in self.single and len(axes.get(a, ())) > 1
            ]
            for axis in several:
                text = f"{name!r} has several values of {axis}; allowed: one, or kind: mounting"
                mistakes.append(((source,), text))
        else:
            values = axes.get(self.over, (0.0,))
            if polynomials := [value for value in values if isinstance(value, tuple)]:
                text = (
                    f"{self.over} has polynomials ({spell_value(polynomials[0])}); allowed: numbers"
                )
                mistakes.append((("over",), text))
            elif self.kind == "change" and (len(values) != 2 or 0.0 not in values):
                text = f"{self.over} has {spell_values(values)}; allowed: two values, one of them 0"
                mistakes.append((("over",), text))
        mounted = [axis for axis in MOUNTING_AXES if axes.get(axis, (0.0,)) != (0.0,)]
        if self.kind == "swing" and mounted:
            text = f"{name!r} has a {mounted[0]}; a swing is followed in the ideal mounting"
            mistakes.append(((source,), text))
        return mistakes


def unknown_name(name: str, what: str, known: Mapping[str, Any]) -> str:
    """Say that nothing has a name, and which names there are."""
    allowed = ", ".join(sorted(known)) or "none is defined"
    return f"{name!r} is not the name of a {what}; allowed: {allowed}"
