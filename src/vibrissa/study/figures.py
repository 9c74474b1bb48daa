"""Figures of a study file: what each kind is drawn from, and the keys that it takes."""

import ast
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from string import Formatter
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, ValidationInfo, create_model, model_validator

from vibrissa.study.axes import (
    AXES,
    MOUNTING_AXES,
    Axis,
    Mistake,
    Values,
    refuse,
    sortable,
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
# The report shows the PNG.
FORMATS = ("pdf", "svg", "png")
# Function of a user's script that draws.
DRAW = "draw"
# Axes of a comparison.
COMPARED = ("theta", "mu0", "eta")
# Values of an axis that a caption lists; of more it has the first and the last.
LISTED = 4


@dataclass(frozen=True, kw_only=True)
class FigureKind:
    """A kind of figure; `vibrissa.figures` has the function that draws it, under the same name.

    Attributes
    ----------
    shows : str
        What it shows.
    source : str
        What it is drawn from: a key of `TABLES`; empty if any may be given.
    single : tuple of str
        Axes of which it shows one value. The key may be left out where the data have one.
    required : tuple of str
        Further keys that must be given.
    panels : int
        Largest number of values of θ, where each has a panel of its own; 0 where there is none.
    is_to_scale : bool
        Whether it shows shapes, whose axes cannot be logarithmic.
    """

    shows: str
    source: str = "grid"
    single: tuple[str, ...] = ()
    required: tuple[str, ...] = ()
    panels: int = 0
    is_to_scale: bool = False


_RUN = ("mu0", "eta", "dx0")
_MOUNTED = ("mu0", "dx0", *MOUNTING_AXES)


def _of_scan(shows: str, *single: str, panels: int = 0) -> FigureKind:
    return FigureKind(
        shows=shows,
        source="scan",
        single=(*single, *_RUN),
        panels=panels,
        is_to_scale=shows.startswith("shapes"),
    )


KINDS: Mapping[str, FigureKind] = {
    "taper": FigureKind(
        shows="clamp displacement x0,max over theta, a series for each mu0", single=("eta", "dx0")
    ),
    "friction": FigureKind(
        shows="clamp displacement x0,max over mu0", single=("theta", "eta", "dx0")
    ),
    "locking": FigureKind(shows="critical friction mu_lock over theta, a series for each eta"),
    "regimes": FigureKind(shows="slip, lying and locking over theta and mu0, a map for each eta"),
    "law": FigureKind(
        shows="onset x0_slip and its law near mu_lock, a series for each theta",
        single=("eta", "dx0"),
    ),
    "past_lock": FigureKind(
        shows="onset x0_slip and sticking past mu_lock over mu0, a series for each theta",
        single=("eta", "dx0"),
    ),
    "mounting": FigureKind(
        shows="onset x0_slip, mu_lock and the loads on the clamp over an axis of the mounting",
        single=("eta", *_MOUNTED),
        required=("over",),
    ),
    "change": FigureKind(
        shows="per cent by which a mounting changes mu_lock and x0_slip, over theta and eta",
        single=_MOUNTED,
        required=("over",),
    ),
    "versus": FigureKind(
        shows="difference of mu_lock from that of the least taper, over the mounting and eta",
        single=_MOUNTED,
        required=("over",),
    ),
    "scan": _of_scan("shapes of scans, step by step, a panel for each theta", panels=6),
    "period": _of_scan("shapes in the first period of scans, a panel for each theta", panels=6),
    "signals": _of_scan("loads on the clamp in one scan", "theta"),
    "swing": _of_scan("shapes of one rod in space while it buckles laterally", "theta"),
    "margins": _of_scan("stability in the plane and out of it over x0, for each theta"),
    "state": FigureKind(
        shows="shapes of one or more states of the same eta", source="state", is_to_scale=True
    ),
    "models": FigureKind(
        shows="errors of tip contact over theta, for each mu0",
        source="comparison",
        single=("eta",),
    ),
    "script": FigureKind(
        shows="figure drawn by a Python file of your own", source="", required=("script",)
    ),
}


def _listed(names: Any) -> Any:
    return [names] if isinstance(names, str) else names


def _chosen(axis: Axis) -> BeforeValidator:
    """Return the validator of some values of an axis; of polynomials one, which is a list."""

    def values(written: Any) -> Values:
        if isinstance(written, list) and not axis.is_polynomial:
            return axis.values(written)
        return (axis.value(written),)

    return BeforeValidator(values, json_schema_input_type=float | list[float])


class AxesKeys(Section):
    """Limits and scale of the axes of a figure's first panel, and of those that share them."""

    x: OptionalKey[tuple[float, float]] = Field(default=None, description="limits, as in [1, 3]")
    y: OptionalKey[tuple[float, float]] = Field(default=None, description="limits")
    log: list[Literal["x", "y"]] = Field(
        default=[], description="axes with a logarithmic scale, as in [y]"
    )

    @model_validator(mode="after")
    def _are_intervals(self) -> Self:
        mistakes: list[Mistake] = []
        for axis, limits in (("x", self.x), ("y", self.y)):
            least = 0.0 if axis in self.log else -float("inf")
            if limits and not least < limits[0] < limits[1] < float("inf"):
                above = " above 0" * (axis in self.log)
                text = f"{list(limits)} is not allowed; allowed: [low, high], low < high{above}"
                mistakes.append(((axis,), text))
        if mistakes:
            refuse(mistakes)
        return self


# Optional keys, one for each axis.
_Axes = create_model(
    "_Axes",
    __base__=Section,
    **{name: (Annotated[Values | None, _chosen(axis)], None) for name, axis in AXES.items()},  # type: ignore[call-overload]
)
_Inch = Annotated[float, Field(ge=1, le=40)]
# Data of a figure: values of the axes by the name of a grid, a scan, a state or a comparison.
Sections = Mapping[str, Any]


class Figure(_Axes):  # type: ignore[misc,valid-type]
    """A figure: its kind, what it is drawn from, and how it looks."""

    kind: Literal[tuple(KINDS)] = Field(  # type: ignore[valid-type]
        description="what it shows"
    )
    caption: str = Field(
        default="",
        description="what the figure shows; {theta}, {eta} and other axes stand for the values "
        "that are shown (default: a sentence made of the kind and the values)",
    )
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
    script: OptionalKey[str] = Field(
        default=None,
        description=f"Python file of kind script, relative to the study file; its function {DRAW} "
        "takes the rows as a pandas.DataFrame and returns a matplotlib Figure",
    )
    size: OptionalKey[tuple[_Inch, _Inch]] = Field(
        default=None,
        description="width and height in inch (default: 3.5 or 7.2 wide, a column or a page)",
    )
    formats: list[Literal[FORMATS[:-1]]] = Field(  # type: ignore[valid-type]
        default=list(FORMATS[:-1]), description="files that are made beside the PNG: pdf, svg"
    )
    axes: OptionalKey[AxesKeys] = Field(
        default=None,
        description="limits and scale, as in {x: [1, 3], y: [0, 0.1], log: [y]}, of the first "
        "panel and those that share its axes",
    )

    @property
    def source(self) -> str:
        """What it is drawn from: a key of `TABLES`; empty if that is missing."""
        given = (key for key in TABLES if getattr(self, key) is not None)
        return KINDS[self.kind].source or next(given, "")

    @property
    def table(self) -> str:
        """Table that it is drawn from."""
        return TABLES[self.source]

    @property
    def names(self) -> list[str]:
        """Names of what it is drawn from."""
        named = getattr(self, self.source, None)
        return named if isinstance(named, list) else [named] if named else []

    @property
    def files(self) -> tuple[str, ...]:
        """Endings of its files."""
        return (*self.formats, FORMATS[-1])

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys that its kind takes."""
        kind = KINDS[self.kind]
        sources = (kind.source,) if kind.source else tuple(TABLES)
        chosen = () if self.source == "state" else COMPARED if "comparison" == self.source else AXES
        return ("kind", *sources, *kind.required, *chosen, "caption", "size", "formats", "axes")

    def selection(self) -> dict[str, Any]:
        """Rows of the table that are shown, as `vibrissa.figures.draw.draw` takes them."""
        chosen = {axis: getattr(self, axis) for axis in AXES if axis != self.over}
        plain = {
            axis: [list(value) if isinstance(value, tuple) else value for value in values]
            for axis, values in chosen.items()
            if values is not None
        }
        return {self.source: getattr(self, self.source), **plain}

    def params(self) -> dict[str, Any]:
        """All that its drawing depends on, as plain values."""
        look = self.model_dump(mode="json", include={"size", "axes"}, exclude_none=True)
        return {
            "kind": self.kind,
            "table": self.table,
            "selection": self.selection(),
            "formats": self.files,
            **look,
        }

    def values(self, sections: Sections) -> dict[str, Values]:
        """Values of each axis that are shown of the data."""
        found: dict[str, set[Any]] = {}
        for name in self.names:
            for axis, values in sections[name].axes.items():
                found.setdefault(axis, set()).update(getattr(self, axis, None) or values)
        return {axis: tuple(sorted(values, key=sortable)) for axis, values in found.items()}

    def told(self, sections: Sections) -> str:
        """Return the caption with the values that are shown, or one made of them."""
        texts = {axis: _spelled(values) for axis, values in self.values(sections).items()}
        if self.caption:
            return self.caption.format_map(texts)
        shows = KINDS[self.kind].shows
        mounted = [axis for axis in MOUNTING_AXES if texts.get(axis) == "0"]
        at = ", ".join(f"{axis} = {text}" for axis, text in texts.items() if axis not in mounted)
        return f"{shows[0].upper()}{shows[1:]}; {at}."

    @model_validator(mode="after")
    def _fits(self, info: ValidationInfo) -> Self:
        """Check the keys of the kind, and the data that it is drawn from."""
        context = info.context or {}
        mistakes = [*self._wrong_keys(), *self._wrong_script(context.get("folder"))]
        # Sections that have mistakes of their own are not here.
        sections = context.get(f"{self.source}s")
        if not mistakes and sections is not None:
            for name in self.names:
                if name not in sections:
                    mistakes.append(((self.source,), unknown_name(name, self.source, sections)))
                else:
                    mistakes += self._misfits(name, sections[name].axes)
            if not mistakes:
                mistakes += self._wrong_placeholders(self.values(sections))
        if mistakes:
            refuse(mistakes)
        return self

    def _wrong_keys(self) -> list[Mistake]:
        """Find keys that the kind does not take, or needs."""
        kind, given = KINDS[self.kind], self.model_fields_set
        mistakes: list[Mistake] = []
        for key in sorted(given - set(self.keys)):
            text = f"is not a key of kind {self.kind}; allowed: {', '.join(self.keys)}"
            mistakes.append(((key,), text))
        for key in (kind.source, *kind.required):
            if key and key not in given:
                mistakes.append(((), f"missing {key!r}"))
        if not kind.source and len(given & set(TABLES)) != 1:
            mistakes.append(((), f"needs one of the keys {', '.join(TABLES)}"))
        if kind.is_to_scale and self.axes and self.axes.log:
            mistakes.append((("axes", "log"), "is not allowed for shapes, which are to scale"))
        return mistakes

    def _wrong_script(self, folder: Path | None) -> list[Mistake]:
        """Check that the script can be read, and has the function that draws."""
        if self.script is None or folder is None:
            return []
        path = folder / self.script
        if Path(self.script).is_absolute() or ".." in Path(self.script).parts:
            text = (
                f"{self.script} is not allowed; allowed: a file in or below the study file's folder"
            )
            return [(("script",), text)]
        try:
            tree = ast.parse(path.read_text(encoding="utf-8"))
        except OSError as error:
            text = f"{path} cannot be read: {error.strerror}"
        except (SyntaxError, ValueError) as error:
            line = f":{error.lineno}" if isinstance(error, SyntaxError) else ""
            text = f"{path}{line} is not valid Python: {error}"
        else:
            functions = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
            if DRAW in functions:
                return []
            text = f"{path} has no function {DRAW}(table)"
        return [(("script",), text)]

    def _wrong_placeholders(self, values: Mapping[str, Values]) -> list[Mistake]:
        """Find placeholders in the caption that stand for nothing."""
        allowed = f"allowed: {', '.join(f'{{{axis}}}' for axis in values)}; a brace itself is {{{{"
        try:
            parts = list(Formatter().parse(self.caption))
        except ValueError as error:
            return [(("caption",), f"{error}; {allowed}")]
        return [
            (("caption",), f"{{{name}}} is not a placeholder; {allowed}")
            for _, name, form, conversion in parts
            if name is not None and (name not in values or form or conversion)
        ]

    def _misfits(self, name: str, axes: Mapping[str, Values]) -> list[Mistake]:
        """Find axes of which the data have several values, or not the value that is asked for."""
        mistakes: list[Mistake] = []
        kind, source = KINDS[self.kind], self.source
        for axis, values in axes.items():
            chosen = getattr(self, axis, None)
            for value in chosen or ():
                if value not in values:
                    text = f"{spell_value(value)} is not allowed; {name!r} has "
                    mistakes.append(((axis,), text + spell_values(values)))
            is_single = axis in kind.single or (axis in MOUNTING_AXES and kind.source)
            if is_single and axis != self.over and len(chosen or values) > 1:
                text = f"; {name!r} has several: {spell_values(values)}"
                mistakes.append(((), f"{self.kind} shows one value of {axis}{text}"))
            if kind.panels and axis == "theta" and len(chosen or values) > kind.panels:
                text = f"has a panel for each theta; allowed: up to {kind.panels}; choose with "
                mistakes.append(((), f"{text}'theta: [...]'"))
        mistakes += self._wrong_mounting(axes)
        mounted = [axis for axis in MOUNTING_AXES if axes.get(axis, (0.0,)) != (0.0,)]
        if self.kind == "swing" and mounted:
            text = f"{name!r} has a {mounted[0]}; a swing is followed in the ideal mounting"
            mistakes.append(((source,), text))
        return mistakes

    def _wrong_mounting(self, axes: Mapping[str, Values]) -> list[Mistake]:
        """Check the values of the axis of the mounting that the figure is drawn over."""
        if self.over is None:
            return []
        values = axes.get(self.over, (0.0,))
        if polynomials := [value for value in values if isinstance(value, tuple)]:
            text = f"{self.over} has polynomials ({spell_value(polynomials[0])}); allowed: numbers"
            return [(("over",), text)]
        if self.kind == "change" and (len(values) != 2 or 0.0 not in values):
            text = f"{self.over} has {spell_values(values)}; allowed: two values, one of them 0"
            return [(("over",), text)]
        return []


def _spelled(values: Values) -> str:
    """Spell the values of an axis in a caption."""
    texts = [spell_value(value) for value in values]
    if len(texts) > LISTED:
        return f"{texts[0]} to {texts[-1]}"
    return " and ".join(filter(None, (", ".join(texts[:-1]), texts[-1])))


def unknown_name(name: str, what: str, known: Mapping[str, Any]) -> str:
    """Say that nothing has a name, and which names there are."""
    allowed = ", ".join(sorted(known)) or "none is defined"
    return f"{name!r} is not the name of a {what}; allowed: {allowed}"
