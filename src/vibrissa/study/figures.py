"""Figures of a study file: what each kind is drawn from, and the keys that it takes."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, ValidationInfo, create_model, model_validator

from vibrissa.study.axes import (
    AXES,
    MOUNTING_AXES,
    Axis,
    Values,
    sortable,
    spell_value,
    spell_values,
)
from vibrissa.study.sections import Mistakes, Section

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
# Values of an axis that a caption lists; of more it has the first and the last.
LISTED = 4


@dataclass(frozen=True)
class FigureKind:
    """A kind of figure; `vibrissa.figures` has the function that draws it, under the same name.

    Attributes
    ----------
    source : str
        What it is drawn from: a key of `TABLES`; empty if any may be given.
    single : tuple of str
        Axes of which it shows one value; the key may be left out where the data have one.
    required : str
        A further key that must be given.
    """

    shows: str
    source: str = "grid"
    single: tuple[str, ...] = ()
    required: str = ""


_RUN = ("mu0", "eta", "dx0")
_MOUNTED = ("mu0", "dx0", *MOUNTING_AXES)
KINDS: Mapping[str, FigureKind] = {
    "taper": FigureKind(
        "clamp displacement x0,max over theta, a series for each mu0", "grid", ("eta", "dx0")
    ),
    "friction": FigureKind("clamp displacement x0,max over mu0", "grid", ("theta", "eta", "dx0")),
    "locking": FigureKind("critical friction mu_lock over theta, a series for each eta"),
    "regimes": FigureKind("slip, lying and locking over theta and mu0, a map for each eta"),
    "law": FigureKind(
        "onset x0_slip and its law near mu_lock, a series for each theta", "grid", ("eta", "dx0")
    ),
    "past_lock": FigureKind(
        "onset x0_slip and sticking past mu_lock over mu0, a series for each theta",
        "grid",
        ("eta", "dx0"),
    ),
    "mounting": FigureKind(
        "onset x0_slip, mu_lock and the loads on the clamp over an axis of the mounting",
        "grid",
        ("eta", *_MOUNTED),
        required="over",
    ),
    "change": FigureKind(
        "per cent by which a mounting changes mu_lock and x0_slip, over theta and eta",
        "grid",
        _MOUNTED,
        required="over",
    ),
    "versus": FigureKind(
        "difference of mu_lock from that of the least taper, over the mounting and eta",
        "grid",
        _MOUNTED,
        required="over",
    ),
    "scan": FigureKind("shapes of scans, step by step, a panel for each theta", "scan", _RUN),
    "period": FigureKind(
        "shapes in the first period of scans, a panel for each theta", "scan", _RUN
    ),
    "signals": FigureKind("loads on the clamp in one scan", "scan", ("theta", *_RUN)),
    "swing": FigureKind(
        "shapes of one rod in space while it buckles laterally", "scan", ("theta", *_RUN)
    ),
    "margins": FigureKind(
        "stability in the plane and out of it over x0, for each theta", "scan", _RUN
    ),
    "state": FigureKind("shapes of one or more states of the same eta", "state"),
    "models": FigureKind("errors of tip contact over theta, for each mu0", "comparison", ("eta",)),
    "script": FigureKind("figure drawn by a Python file of your own", "", required="script"),
}
# Axes of which a figure can choose values, where these are not all of them.
CHOICE = {"state": (), "comparison": ("theta", "mu0", "eta")}


def _listed(names: Any) -> Any:
    return [names] if isinstance(names, str) else names


def _chosen(axis: Axis) -> BeforeValidator:
    """Return the validator of some values of an axis; of polynomials one, which is a list."""

    def values(written: Any) -> Values:
        if isinstance(written, list) and not axis.powers:
            return axis.values(written)
        return (axis.value(written),)

    text = f"{axis.meaning}: the values that are shown, one or a list"
    schema = Annotated[float | list[float], Field(description=text)]
    return BeforeValidator(values, json_schema_input_type=schema)


class AxesKeys(Section):
    """Limits and scales of the axes of the first panel and of panels that share them."""

    x: tuple[float, float] | None = Field(default=None, description="limits, as in [1, 3]")
    y: tuple[float, float] | None = Field(default=None, description="limits")
    log: list[Literal["x", "y"]] = Field(
        default=[], description="axes with a logarithmic scale, as in [y]"
    )

    @model_validator(mode="after")
    def _are_intervals(self) -> Self:
        for limits in filter(None, (self.x, self.y)):
            if not -float("inf") < limits[0] < limits[1] < float("inf"):
                raise ValueError(f"{list(limits)} is not allowed; allowed: [low, high], low < high")
        return self


# Optional keys, one for each axis.
_Axes = create_model(
    "_Axes",
    __base__=Section,
    **{name: (Annotated[Values | None, _chosen(axis)], None) for name, axis in AXES.items()},  # type: ignore[call-overload]
)
_Inch = Annotated[float, Field(ge=1, le=40)]
# Data of a figure: the sections with the axes of each grid, scan, state or comparison.
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
    grid: str | None = Field(default=None, description="name of the grid it is drawn from")
    scan: str | None = Field(default=None, description="name of the scan it is drawn from")
    state: Annotated[list[str] | None, BeforeValidator(_listed, str | list[str])] = Field(
        default=None, description="name of the state it is drawn from, or a list of names"
    )
    comparison: str | None = Field(
        default=None, description="name of the comparison it is drawn from"
    )
    over: Literal[MOUNTING_AXES] | None = Field(  # type: ignore[valid-type]
        default=None, description="axis of the mounting that has several values"
    )
    script: str | None = Field(
        default=None,
        description=f"Python file of kind script, relative to the study file; its function {DRAW} "
        "takes the rows as a pandas.DataFrame and returns a matplotlib Figure",
    )
    size: tuple[_Inch, _Inch] | None = Field(
        default=None,
        description="width and height in inch (default: 3.5 or 7.2 wide, a column or a page)",
    )
    formats: list[Literal[FORMATS[:-1]]] = Field(  # type: ignore[valid-type]
        default=list(FORMATS[:-1]), description="files that are made beside the PNG: pdf, svg"
    )
    axes: AxesKeys | None = Field(
        default=None,
        description="limits and scale, as in {x: [1, 3], y: [0, 0.1], log: [y]}, of the first "
        "panel and those that share its axes",
    )

    @property
    def source(self) -> str:
        """What it is drawn from: a key of `TABLES`; empty if that is missing."""
        given = (key for key in TABLES if getattr(self, key))
        return KINDS[self.kind].source or next(given, "")

    @property
    def names(self) -> list[str]:
        """Names of the grids, scans, states or comparisons of the figure."""
        named = getattr(self, self.source)
        return named if isinstance(named, list) else [named]

    @property
    def files(self) -> tuple[str, ...]:
        """Endings of its files."""
        return (*self.formats, FORMATS[-1])

    def params(self) -> dict[str, Any]:
        """All inputs of the drawing, as plain values.

        The ``selection`` has the rows that are shown, as `vibrissa.figures.draw.draw` takes them.
        """
        shown = {self.source, *AXES} - {self.over}
        return {
            "kind": self.kind,
            "table": TABLES[self.source],
            "selection": self.model_dump(mode="json", include=shown, exclude_none=True),
            "formats": self.files,
            **self.model_dump(mode="json", include={"size", "axes"}, exclude_none=True),
        }

    def shown_values(self, sections: Sections) -> dict[str, Values]:
        """Values of each axis that are shown of the data."""
        found: dict[str, set[Any]] = {}
        for name in self.names:
            for axis, values in sections[name].axes.items():
                found.setdefault(axis, set()).update(getattr(self, axis, None) or values)
        return {axis: tuple(sorted(values, key=sortable)) for axis, values in found.items()}

    def caption_of(self, sections: Sections) -> str:
        """Return the caption with the values that are shown, or one made of them."""
        texts = {axis: _spelled(shown) for axis, shown in self.shown_values(sections).items()}
        if self.caption:
            try:
                return self.caption.format_map(texts)
            except (LookupError, ValueError, AttributeError) as error:
                allowed = ", ".join(f"{{{axis}}}" for axis in texts)
                raise ValueError(
                    f"a placeholder is wrong ({error}); allowed: {allowed}; a brace itself is {{{{"
                ) from None
        shows = KINDS[self.kind].shows
        mounted = [axis for axis in MOUNTING_AXES if texts.get(axis) == "0"]
        at = ", ".join(f"{axis} = {text}" for axis, text in texts.items() if axis not in mounted)
        return f"{shows[0].upper()}{shows[1:]}; {at}."

    @model_validator(mode="after")
    def _has_its_keys(self, info: ValidationInfo) -> Self:
        mistakes = Mistakes()
        self._check_keys(mistakes)
        if self.script:
            mistakes.check("script", self._check_script, (info.context or {}).get("folder", Path()))
        mistakes.refuse()
        return self

    def misfits(self, sections: Sections) -> Mistakes:
        """Find what does not fit the data that it is drawn from."""
        mistakes = Mistakes()
        for name in self.names:
            if name in sections:
                self._check_data(mistakes, name, sections[name].axes)
            else:
                mistakes.add(unknown_name(name, self.source, sections), self.source)
        if not mistakes:
            mistakes.check("caption", self.caption_of, sections)
        return mistakes

    def _check_keys(self, mistakes: Mistakes) -> None:
        """Find keys that the kind does not take, and missing keys that it needs."""
        kind = KINDS[self.kind]
        sources = [kind.source] if kind.source else list(TABLES)
        chosen = CHOICE.get(self.source, AXES)
        keys = ["kind", *sources, *chosen, "caption", "size", "formats", "axes"]
        keys += [kind.required] if kind.required else []
        for key in sorted(self.model_fields_set - set(keys)):
            mistakes.add(f"is not a key of kind {self.kind}; allowed: {', '.join(keys)}", key)
        if kind.required and not getattr(self, kind.required):
            mistakes.add(f"missing {kind.required!r}")
        if len([source for source in sources if getattr(self, source)]) != 1:
            mistakes.add(f"missing {' or '.join(map(repr, sources))}: one is needed")

    def _check_script(self, folder: Path) -> None:
        """Check that the script can be read, and has the function that draws."""
        script = Path(str(self.script))
        if script.is_absolute() or ".." in script.parts:
            raise ValueError(
                f"{script} is not allowed; allowed: a file in or below the study file's folder"
            )
        path = folder / script
        try:
            names = compile(path.read_text(encoding="utf-8"), str(path), "exec").co_names
        except OSError as error:
            raise ValueError(f"{path} cannot be read: {error.strerror}") from None
        except (SyntaxError, ValueError) as error:
            raise ValueError(f"{path} is not valid Python: {error}") from None
        if DRAW not in names:
            raise ValueError(f"{path} has no function {DRAW}(table)")

    def _check_data(self, mistakes: Mistakes, name: str, axes: Mapping[str, Values]) -> None:
        """Find axes with several values in the data, or without the requested value."""
        kind = KINDS[self.kind]
        for axis, values in axes.items():
            chosen = getattr(self, axis, None) or values
            has = f"{name!r} has {spell_values(values)}"
            for value in set(chosen) - set(values):
                mistakes.add(f"{spell_value(value)} is not allowed; {has}", axis)
            is_single = axis in kind.single or (axis in MOUNTING_AXES and kind.source)
            if is_single and axis != self.over and len(chosen) > 1:
                mistakes.add(f"{self.kind} shows one value of {axis}; {has}")
        over = axes.get(self.over or "", (0.0,))
        if any(isinstance(value, tuple) for value in over):
            mistakes.add(f"{self.over} has polynomials; allowed: numbers", "over")
        elif self.kind == "change" and (len(over) != 2 or 0.0 not in over):
            text = f"{self.over} has {spell_values(over)}; allowed: two values, one of them 0"
            mistakes.add(text, "over")
        mounted = [axis for axis in MOUNTING_AXES if axes.get(axis, (0.0,)) != (0.0,)]
        if self.kind == "swing" and mounted:
            text = f"{name!r} has a {mounted[0]}; it is drawn in the ideal mounting alone"
            mistakes.add(text, self.source)


def _spelled(values: Values) -> str:
    """Spell the values of an axis in a caption."""
    texts = [spell_value(value) for value in values]
    if len(texts) > LISTED:
        return f"{texts[0]} to {texts[-1]}"
    return " and ".join(filter(None, (", ".join(texts[:-1]), texts[-1])))


def unknown_name(name: str, what: str, known: Mapping[str, Any]) -> str:
    """Error message for an unknown name, with the known names."""
    allowed = ", ".join(sorted(known)) or "none is defined"
    return f"{name!r} is not the name of a {what}; allowed: {allowed}"
