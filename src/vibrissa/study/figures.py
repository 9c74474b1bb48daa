"""Figures of a study file: the kinds of figures, and the data and keys of each kind."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, Self, TypeAlias

from pydantic import BeforeValidator, Field, FiniteFloat, create_model, model_validator

from vibrissa.outcomes import Method
from vibrissa.study.axes import (
    AXES,
    LAW_AXES,
    MOUNTING_AXES,
    SURFACE_AXES,
    Values,
    in_list,
    sortable,
    spell_value,
    spell_values,
)
from vibrissa.study.sections import Mistakes, Name, Section

_Method: TypeAlias = Literal[tuple(one.value for one in Method)]  # type: ignore[valid-type]
# Data of a figure: its key in the study file, and its table. The key plus "s" names the section.
TABLES = {
    "grid": "stiction",
    "scan": "scans",
    "reading": "friction",
    "state": "states",
    "comparison": "comparisons",
}
# Axis of a figure of several readings: their names.
READINGS = "readings"
# Column with the names of the data, where it is not the key.
NAMED_IN = {"reading": READINGS}
# Further axes of scans, whose values a figure of scans may select.
SCAN_AXES: Mapping[str, Any] = {
    "surface": Annotated[list[Name] | None, BeforeValidator(in_list, str | list[str])],
    **{name: Annotated[Values | None, axis] for name, axis in (SURFACE_AXES | LAW_AXES).items()},
}
# Further axes of readings.
READ_AXES: Mapping[str, Any] = {
    "transducer": Annotated[list[str] | None, BeforeValidator(in_list, str | list[str])],
    "read_by": Annotated[list[_Method] | None, BeforeValidator(in_list, _Method | list[_Method])],
}
# Keys that every kind of figure takes.
LOOK = ("kind", "caption", "size", "formats", "axes")
# Key of a PNG file that has the parts which a phone shows below each other.
PARTS = "Parts"
# Name of the drawing function in a user's script.
DRAW = "draw"


@dataclass(frozen=True)
class FigureKind:
    """A kind of figure; `vibrissa.figures` has the function that draws it, under the same name.

    Attributes
    ----------
    shows : str
        What the figure shows, as the start of a caption.
    source : str
        Kind of the figure's data: a key of `TABLES`; empty if all kinds are allowed.
    single : tuple of str
        Axes of which a figure shows one value. The axes of the mounting are single, too, except the
        axis `over`. The key of a single axis may be omitted if the data have one value of it.
    required : str
        A further key that must be given; empty if there is none.
    frequencies : bool
        Whether the figure shows natural frequencies, which a study has only if it asks for them.
    lists : bool
        Whether the key `source` may be a list of names.
    mountings : bool
        Whether the axes of the mounting may have several values without `over`.
    table : str
        Name of the table; by default the one of the source.
    series : tuple of str
        Axes of which the first that is not `over` has a series for each value by default.
    free : tuple of str
        Further keys that may be given.
    has_shapes : bool
        Whether it shows shapes of the rod, which a scan then keeps.
    """

    shows: str
    source: str
    single: tuple[str, ...] = ()
    required: str = ""
    frequencies: bool = False
    lists: bool = False
    mountings: bool = False
    table: str = ""
    free: tuple[str, ...] = ()
    series: tuple[str, ...] = ()
    has_shapes: bool = False


_RUN = ("mu0", "eta", "dx0")
# What distinguishes scans of the same rod.
_SCAN = (*_RUN, *SCAN_AXES)
# The seeds of a random surface are averaged over.
_LAWLESS = tuple(axis for axis in SCAN_AXES if axis not in ("seed", "rough_seed"))
# Recordings of all surfaces and transducers are taken together unless some are selected.
_READ, _READ_SERIES = ("read_by",), ("eta", "theta", "dx0")
FIGURE_KINDS: Mapping[str, FigureKind] = {
    "taper": FigureKind(
        "clamp displacement x0,max over theta, a series for each mu0", "grid", ("eta", "dx0")
    ),
    "friction": FigureKind("clamp displacement x0,max over mu0", "grid", ("theta", "eta", "dx0")),
    "locking": FigureKind("critical friction mu_lock over theta, a series for each eta", "grid"),
    "regimes": FigureKind("slip, line contact and lock over theta and mu0, for each eta", "grid"),
    "law": FigureKind(
        "onset x0_slip and its power law near mu_lock, for each theta", "grid", ("eta", "dx0")
    ),
    "past_lock": FigureKind(
        "end of sticking over mu0, past mu_lock, a series for each theta", "grid", ("eta", "dx0")
    ),
    "onset": FigureKind(
        "clamp displacement x0,max and exact onset over any axis",
        "grid",
        tuple(AXES),
        "over",
        free=("by",),
        series=("theta", "mu0"),
    ),
    "map": FigureKind("a column over two axes", "grid", tuple(AXES), "over", free=("by", "value")),
    "mounting": FigureKind(
        "onset x0_slip, mu_lock and loads on the clamp over the mounting", "grid", _RUN, "over"
    ),
    "slopes": FigureKind(
        "slopes over each axis of the mounting as a table, and the lines that bend",
        "grid",
        ("mu0", "dx0"),
        lists=True,
        mountings=True,
    ),
    "change": FigureKind(
        "change of mu_lock and x0_slip in per cent by the mounting", "grid", ("mu0", "dx0"), "over"
    ),
    "versus": FigureKind(
        "difference of mu_lock from its value at the least taper", "grid", ("mu0", "dx0"), "over"
    ),
    "scan": FigureKind(
        "shapes and slips of scans, a panel for each theta and mu0",
        "scan",
        ("eta", "dx0", *SCAN_AXES),
        has_shapes=True,
    ),
    "period": FigureKind(
        "shapes in the first period, a panel for each theta", "scan", _SCAN, has_shapes=True
    ),
    "slip": FigureKind(
        "one slip: three rods, the friction cone, and loads on the clamp",
        "scan",
        ("theta", *_SCAN),
        has_shapes=True,
    ),
    "signals": FigureKind("loads on the clamp in one scan", "scan", ("theta", *_SCAN)),
    "swing": FigureKind(
        "shapes of a rod that buckles laterally", "scan", ("theta", *_SCAN), has_shapes=True
    ),
    "margins": FigureKind("stability in the plane and out of it over x0", "scan", _SCAN),
    "periods": FigureKind(
        "travel of the clamp, length of the slip and fall of the load, for each slip law",
        "scan",
        (*AXES, *_LAWLESS),
        "over",
        table="periods",
        free=("by",),
        series=("law", "theta"),
    ),
    "sawtooth": FigureKind(
        "load on the clamp over its position, with the slips, for each slip law",
        "scan",
        (*AXES, *SCAN_AXES),
        free=("by", "value"),
        series=("law",),
    ),
    "spectrum": FigureKind(
        "spectrum of the load on the clamp, for each slip law",
        "scan",
        (*AXES, *SCAN_AXES),
        free=("by", "value"),
        series=("law",),
    ),
    "frequencies": FigureKind(
        "first natural frequencies at the onset of slip over theta, a series for each mu0",
        "grid",
        ("eta", "dx0"),
        frequencies=True,
    ),
    "ringing": FigureKind(
        "natural frequencies over x0 in the first period, for each theta",
        "scan",
        _SCAN,
        frequencies=True,
    ),
    "accuracy": FigureKind(
        "errors and stated standard deviations of the friction that was read, over any axis",
        "reading",
        _READ,
        "over",
        lists=True,
        free=("by",),
        series=_READ_SERIES,
    ),
    "coverage": FigureKind(
        "part of the 95 % intervals of friction that contain the truth, over any axis",
        "reading",
        _READ,
        "over",
        lists=True,
        free=("by",),
        series=_READ_SERIES,
    ),
    "uncertainty": FigureKind(
        "stated standard deviation of friction over two axes",
        "reading",
        _READ,
        "over",
        free=("by",),
    ),
    "limits": FigureKind(
        "part by which the variance of friction falls if a quantity is exact, over any axis",
        "reading",
        (*_READ, "eta", "read_by"),
        "over",
    ),
    "state": FigureKind("shapes of one or more states of the same eta", "state", lists=True),
    "models": FigureKind(
        "error of x0_slip if line contact is neglected, over theta", "comparison", ("eta",)
    ),
    "script": FigureKind(
        "figure drawn by a Python file of your own", "", required="script", lists=True
    ),
}


_ALL_AXES = (*AXES, *SCAN_AXES, *READ_AXES)
_Limits: TypeAlias = tuple[FiniteFloat, FiniteFloat]


class AxesKeys(Section):
    """Limits and scales of the axes x and y, in the first panel and in panels that share them."""

    x: _Limits | None = Field(default=None, description="limits, as in [1, 3]")
    y: _Limits | None = Field(default=None, description="limits")
    log: list[Literal["x", "y"]] = Field(
        default=[], description="axes with a logarithmic scale, as in [y]"
    )

    @model_validator(mode="after")
    def _are_positive(self) -> Self:
        if any(min(getattr(self, axis) or [1.0]) <= 0.0 for axis in self.log):
            raise ValueError("limits of a logarithmic axis must be above 0")
        return self


# Optional keys, one for each axis: the values that are shown.
_Axes = create_model(
    "_Axes",
    __base__=Section,
    **{name: (Annotated[Values | None, axis], None) for name, axis in AXES.items()},  # type: ignore[call-overload]
    **{
        name: (
            kind,
            Field(default=None, description=f"for figures of scans: values of {name} shown"),
        )
        for name, kind in SCAN_AXES.items()
    },
    **{
        name: (
            kind,
            Field(default=None, description=f"for figures of readings: values of {name} shown"),
        )
        for name, kind in READ_AXES.items()
    },
)
_Inch: TypeAlias = Annotated[float, Field(ge=1, le=40)]
# Sections of the study file with the data of a figure: grids, scans, states or comparisons by name.
Sections: TypeAlias = Mapping[str, Any]


class Figure(_Axes):  # type: ignore[misc,valid-type]
    """A figure: its kind, what it is drawn from, the values that it shows, and how it looks."""

    kind: Literal[tuple(FIGURE_KINDS)] = Field(  # type: ignore[valid-type]
        description="kind of the figure"
    )
    caption: str = Field(
        default="",
        description="text below the figure; {theta}, {eta} and other axes stand for the values "
        "that are shown (default: a sentence made of the kind and the values)",
    )
    grid: Annotated[list[str] | None, BeforeValidator(in_list, str | list[str])] = Field(
        default=None, description="name of the grid with the data, or a list of names"
    )
    scan: str | None = Field(default=None, description="name of the scan with the data")
    reading: Annotated[list[str] | None, BeforeValidator(in_list, str | list[str])] = Field(
        default=None, description="name of the readings with the data, or a list of names"
    )
    state: Annotated[list[str] | None, BeforeValidator(in_list, str | list[str])] = Field(
        default=None, description="name of the state with the data, or a list of names"
    )
    comparison: str | None = Field(default=None, description="name of the comparison with the data")
    over: Literal[tuple(_ALL_AXES)] | None = Field(  # type: ignore[valid-type]
        default=None,
        description="axis of the abscissa, which has several values; kinds mounting, change and "
        "versus: an axis of the mounting",
    )
    by: Literal[(*_ALL_AXES, READINGS)] | None = Field(  # type: ignore[valid-type]
        default=None,
        description="axis with a series for each value (default: law for scans, theta for grids, "
        "eta for readings), or readings; kinds map and uncertainty: axis of the ordinate",
    )
    value: str | None = Field(
        default=None,
        description="column that is drawn: kind map x0_slip by default, kinds sawtooth and "
        "spectrum reaction_fx",
    )
    script: str | None = Field(
        default=None,
        description=f"Python file for kind script, relative to the study file; its function {DRAW} "
        "takes the rows as a pandas.DataFrame and returns a matplotlib Figure",
    )
    table: Literal["scans", "periods"] | None = Field(
        default=None,
        description="table of scans for kind script: scans, a row for each step (default), or "
        "periods",
    )
    size: tuple[_Inch, _Inch] | None = Field(
        default=None,
        description="width and height in inch (default width: 3.5 for a column or 7.2 for a page)",
    )
    formats: list[Literal["pdf", "svg", "apng"]] = Field(
        default=["pdf", "svg"],
        description="files that are made beside the PNG: pdf, svg; for kind scan also apng, an "
        "animation of the scans",
    )
    axes: AxesKeys | None = Field(
        default=None,
        description="limits and scale, as in {x: [1, 3], y: [0.001, 0.1], log: [y]}, of the first "
        "panel and of panels that share its axes",
    )

    @property
    def source(self) -> str:
        """Kind of the figure's data: a key of `TABLES`."""
        return next(key for key in TABLES if getattr(self, key))

    @property
    def names(self) -> list[str]:
        """Names of the grids, scans, states or comparisons of the figure."""
        return list(in_list(getattr(self, self.source)))

    def params(self) -> dict[str, Any]:
        """Return all inputs of the drawing, as plain values.

        The ``selection`` selects the rows to draw; see `vibrissa.figures.draw.draw`.
        """
        given = self.model_dump(mode="json", exclude_none=True)
        given |= {"by": self.series} if self.series else {}
        shown = [key for key in _ALL_AXES if key in given]
        named = NAMED_IN.get(self.source, self.source)
        selection = {named: given[self.source], **{key: given[key] for key in shown}}
        return {**given, "table": self.drawn_from, "selection": selection}

    @property
    def series(self) -> str | None:
        """Axis with a series for each value."""
        default = FIGURE_KINDS[self.kind].series
        # Along the axis of the series there are series of the next one.
        return self.by or next((axis for axis in default if axis != self.over), None)

    @property
    def drawn_from(self) -> str:
        """Name of the table with the data."""
        return self.table or FIGURE_KINDS[self.kind].table or TABLES[self.source]

    def _axes_of(self, section: Any) -> Mapping[str, Any]:
        """Return the axes that bear on what is shown; of scans, surface and law decide that."""
        narrowed = getattr(section, "narrowed", None)
        return narrowed(self.surface, self.law) if narrowed else section.axes

    def caption_of(self, sections: Sections) -> str:
        """Return the caption with the shown values filled in, or a default caption."""
        found: dict[str, set[Any]] = {}
        for name in self.names:
            for axis, values in self._axes_of(sections[name]).items():
                found.setdefault(axis, set()).update(getattr(self, axis, None) or values)
        texts = {axis: spell_values(sorted(found[axis], key=sortable)) for axis in found}
        if self.caption:
            return self.caption.format_map(texts)
        shows = FIGURE_KINDS[self.kind].shows
        mounted = [axis for axis in MOUNTING_AXES if texts.get(axis) == "0"]
        at = ", ".join(f"{axis} = {text}" for axis, text in texts.items() if axis not in mounted)
        return f"{shows[0].upper()}{shows[1:]}; {at}."

    @model_validator(mode="after")
    def _has_its_keys(self) -> Self:
        """Reject keys that the kind does not take, and figures that lack data, `over` or script."""
        mistakes, kind = Mistakes(), FIGURE_KINDS[self.kind]
        sources = [kind.source] if kind.source else list(TABLES)
        axes = [*AXES, *(SCAN_AXES if {"scan", "reading"} & set(sources) else ())]
        axes += READ_AXES if "reading" in sources else ()
        keys = [*LOOK, *sources, *axes, *kind.free, *filter(None, [kind.required])]
        if self.kind == "script" and self.scan:
            keys.append("table")
        for key in sorted(self.model_fields_set - set(keys)):
            mistakes.add(f"is not a key of kind {self.kind}; allowed: {', '.join(keys)}", key)
        if kind.required and not getattr(self, kind.required):
            mistakes.add(f"missing {kind.required!r}")
        if "apng" in self.formats and self.kind != "scan":
            mistakes.add("apng is a format of kind scan only", "formats")
        chosen = [source for source in sources if getattr(self, source)]
        if len(chosen) != 1:
            which = "the key" if len(sources) == 1 else "exactly one of the keys"
            mistakes.add(f"needs {which} {', '.join(map(repr, sources))}")
        elif not kind.lists and len(self.names) > 1:
            mistakes.add(f"a figure of kind {self.kind} shows one {chosen[0]}", chosen[0])
        mistakes.refuse()
        return self

    def misfits(self, sections: Sections, folder: Path) -> Mistakes:
        """Find keys that do not fit the figure's data, a wrong caption, and a missing script."""
        mistakes, script = Mistakes(), Path(self.script or "")
        is_below = not script.is_absolute() and ".." not in script.parts
        if self.script and not (is_below and (folder / script).is_file()):
            mistakes.add(
                f"there is no file {script} in the study file's folder or below it", "script"
            )
        for name in self.names:
            if name not in sections:
                mistakes.add(unknown_name(name, self.source, sections), self.source)
                return mistakes
            if self.source == "grid" and self.kind != "script":
                if not sections[name].is_product:
                    text = f"{name!r} does not have all combinations of its values, as a figure of "
                    mistakes.add(f"{text}kind {self.kind} needs; allowed: kind script", "grid")
                    continue
            self._check_data(mistakes, name, self._axes_of(sections[name]))
        if self.kind == "state" and len({sections[name].eta for name in self.names}) > 1:
            mistakes.add("a figure of kind state shows states of one eta", "state")
        try:
            self.caption_of(sections)
        except (LookupError, ValueError, AttributeError, TypeError) as error:
            allowed = ", ".join(f"{{{axis}}}" for axis in sections[self.names[0]].axes)
            text = f"a placeholder is wrong ({error}); allowed: {allowed}; for a brace write {{{{"
            mistakes.add(text, "caption")
        return mistakes

    def _check_data(self, mistakes: Mistakes, name: str, axes: Mapping[str, Values]) -> None:
        """Find axes with too many values, and requested values that the data do not have."""
        kind = FIGURE_KINDS[self.kind]
        several = {self.over, self.series}
        are_single = kind.source and not kind.mountings
        single = {*kind.single, *(MOUNTING_AXES if are_single else ())} - several
        for axis in _ALL_AXES:
            values = axes.get(axis, ())
            chosen = getattr(self, axis) or values
            has = f"{name!r} has {spell_values(values) or 'none'}"
            for value in set(chosen) - set(values):
                mistakes.add(f"{spell_value(value)} is not among the data; {has}", axis)
            if axis in single and len(chosen) > 1:
                mistakes.add(
                    f"a figure of kind {self.kind} shows one value of {axis}, but {has}; "
                    f"set {axis} to one of them"
                )
        if kind.mountings:
            varied = [axis for axis in MOUNTING_AXES if len(axes.get(axis, ())) > 1]
            if len(varied) != 1 or 0.0 not in axes[varied[0]]:
                has = ", ".join(varied) or "no axis of the mounting"
                mistakes.add(
                    f"{name!r} varies {has}; a figure of kind {self.kind} needs one axis of the "
                    "mounting with several values, one of them 0",
                    "grid",
                )
        if self.over:
            self._check_over(mistakes, getattr(self, self.over) or axes.get(self.over, ()))
        if self.kind in ("map", "uncertainty") and not self.by:
            mistakes.add("missing 'by': the axis of the ordinate")
        if self.kind == "versus" and len(self.theta or axes["theta"]) < 2:
            mistakes.add("versus needs two values of theta or more", "theta")

    def _check_over(self, mistakes: Mistakes, shown: Values) -> None:
        """Find values of the axis `over` that the kind cannot show."""
        kind = FIGURE_KINDS[self.kind]
        if kind.source == "grid" and not kind.free and self.over not in MOUNTING_AXES:
            text = f"{self.over} is not allowed; allowed: {', '.join(MOUNTING_AXES)}"
        elif any(isinstance(value, tuple) for value in shown):
            text = f"{self.over} has lists of coefficients; allowed: numbers"
        elif self.kind == "change" and not (len(shown) == 2 and 0.0 in shown):
            text = f"{self.over} has {spell_values(shown)}; allowed: two values, one of them 0"
        elif len(shown) < 2:
            text = f"{self.over} has {spell_values(shown)}; allowed: two values or more"
        else:
            return
        mistakes.add(text, "over")


def unknown_name(name: str, what: str, known: Mapping[str, Any]) -> str:
    """Error message for an unknown name, with the known names."""
    allowed = ", ".join(sorted(known)) or "none is defined"
    return f"{name!r} is not the name of a {what}; allowed: {allowed}"
