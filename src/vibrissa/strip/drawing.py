"""Drawing of a strip: loads and residuals over the clamp, friction along the surface."""

from io import StringIO
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibrissa.figures import style
from vibrissa.figures.labels import at_ends
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.quantities.units import CHANNEL_KINDS, Kind
from vibrissa.sensor import Grade, Identification, PeriodStatus
from vibrissa.sensor.identification.recording import FORCES, MOMENT
from vibrissa.sensor.identification.result import Residuals
from vibrissa.sensor.transducer import CHANNELS

# Largest number of points of a line; of a longer recording, extremes of equal parts are drawn.
MOST_POINTS = 4000
# Heights of the panels (inch).
LOADS = 1.15
RESIDUALS = 1.0
FRICTION = 2.1
# Symbols of the channels, and their looks as lines and as points.
SYMBOLS = {"force_x": r"$F_x$", "force_y": r"$F_y$", "moment_z": r"$M_z$"}
LINES: dict[str, style.Look] = {
    "force_x": {"color": style.COLORS[0], "linestyle": "-"},
    "force_y": {"color": style.COLORS[2], "linestyle": style.DASHES[1]},
    "moment_z": {"color": style.COLORS[1], "linestyle": "-"},
}
POINTS: dict[str, style.Look] = {
    "force_x": {"color": style.COLORS[0], "marker": "."},
    "force_y": {"color": style.COLORS[2], "marker": "+"},
    "moment_z": {"color": style.COLORS[1], "marker": "x"},
}
# Looks of periods, by grade; without colours, their marks differ.
LOOKS: dict[str, style.Look] = {
    "": {"color": style.COLORS[0], "marker": "o"},
    Grade.DOUBTFUL: {"color": style.COLORS[5], "marker": "D", "markerfacecolor": "white"},
    Grade.WRONG: {"color": style.LOAD, "marker": "X"},
}
NAMES = {
    "": r"$\mu_0$ and 95 % interval",
    Grade.DOUBTFUL: "doubtful",
    Grade.WRONG: "wrong: do not use",
}
# Two standard deviations: most residuals of a recording that fits are within them.
TWICE = 2.0


class AxisUnit(NamedTuple):
    """Factor from nondimensional values to those of an axis, and the unit to write there."""

    factor: float
    unit: str


def axis_of(identification: Identification, kind: Kind, values: FloatArray) -> AxisUnit:
    """Choose the unit of an axis: a prefix for small values in SI units."""
    unit = identification.units.unit(kind)
    name = identification.units.name(kind)
    largest = float(np.nanmax(np.abs(values), initial=0.0)) * unit
    if identification.units.nondimensional:
        return AxisUnit(factor=unit, unit=name.replace("*", "·").replace("^2", "²"))
    name = name.replace("N*m", "N·m")
    if largest >= 1.0 or not largest:
        return AxisUnit(factor=unit, unit=name)
    return (
        AxisUnit(factor=1e3 * unit, unit=f"m{name}")
        if largest >= 1e-3
        else AxisUnit(factor=1e6 * unit, unit=f"µ{name}")
    )


def extremes(values: FloatArray) -> IntArray:
    """Return the rows of at most `MOST_POINTS` values: all, or the extremes of equal parts."""
    if len(values) <= MOST_POINTS:
        return np.arange(len(values))
    parts = np.array_split(np.arange(len(values)), MOST_POINTS // 2)
    known = np.nan_to_num(values)
    ends = [(part[known[part].argmin()], part[known[part].argmax()]) for part in parts]
    return np.unique(ends)


def draw(identification: Identification) -> Figure:
    """Draw the strip of an identification; see this module."""
    readings = identification.recording.readings
    used = [i for i in range(len(CHANNELS)) if np.isfinite(readings[:, i]).any()]
    # Forces and moment have a panel each, as their units differ.
    groups = [[i for i in channels if i in used] for channels in (FORCES, [MOMENT])]
    loads = [channels for channels in groups if channels]
    residuals = identification.residuals
    heights = [LOADS for _ in loads]
    if residuals is not None:
        heights.append(RESIDUALS)
    with style.applied():
        figure = style.page(sum(heights) + FRICTION, style.PAGE)
        panels = figure.subplots(len(heights) + 1, height_ratios=[*heights, FRICTION])
        *above, below = panels
        for panel, channels in zip(above, loads, strict=False):
            _loads(panel, identification, channels)
        if residuals is not None:
            _residuals(above[-1], identification, residuals)
        _clamp_axes(identification, above)
        _friction(below, identification)
        style.legend(figure)
    return figure


def svg(identification: Identification) -> str:
    """Draw the strip as the text of an SVG element."""
    figure = draw(identification)
    file = StringIO()
    with style.applied():
        figure.savefig(file, format="svg", metadata={"Date": None})
    text = file.getvalue()
    return text[text.index("<svg") :]


def _loads(panel: Axes, identification: Identification, channels: list[int]) -> None:
    recording = identification.recording
    axis = axis_of(identification, CHANNEL_KINDS[channels[0]], recording.readings[:, channels])
    length = axis_of(identification, Kind.LENGTH, recording.clamp)
    for i in channels:
        rows = extremes(recording.readings[:, i])
        x, y = recording.clamp[rows] * length.factor, recording.readings[rows, i] * axis.factor
        name = CHANNELS[i]
        panel.plot(x, y, label=SYMBOLS[name], linewidth=0.8, **LINES[name])
    names = ", ".join(SYMBOLS[CHANNELS[i]] for i in channels)
    panel.set_ylabel(f"{names} / {axis.unit}")
    panel.margins(x=0.0)
    at_ends(panel)


def _residuals(panel: Axes, identification: Identification, residuals: Residuals) -> None:
    length = axis_of(identification, Kind.LENGTH, identification.recording.clamp)
    panel.axhspan(-TWICE, TWICE, color=style.SHAPE, linewidth=0.0, label="± 2 st. dev.")
    for i, name in enumerate(residuals.channels):
        values = residuals.values[:, i]
        rows = extremes(values)
        look: style.Look = {"linestyle": "none", "markersize": 2.5, **POINTS[name]}
        x = residuals.clamp[rows] * length.factor
        panel.plot(x, values[rows], label=f"residual of {SYMBOLS[name]}", **look)
    panel.set_ylabel("residual / st. dev.")
    panel.margins(x=0.0)


def _clamp_axes(identification: Identification, panels: list[Axes]) -> None:
    """Shade periods in doubt in the panels over the clamp, and name their common axis."""
    recording = identification.recording
    periods = identification.periods
    length = axis_of(identification, Kind.LENGTH, recording.clamp)
    line = recording.line
    starts = recording.clamp[np.searchsorted(line, periods.first_line).clip(max=len(line) - 1)]
    for grade in Grade:
        for at in np.flatnonzero(periods.grade == grade):
            span = np.array([starts[at], periods.footpoint[at]]) * length.factor
            for panel in panels:
                panel.axvspan(*span, color=LOOKS[grade]["color"], alpha=0.12, linewidth=0.0)
    for panel in panels:
        panel.set_xlim(*(np.array([recording.clamp.min(), recording.clamp.max()]) * length.factor))
        panel.tick_params(labelbottom=panel is panels[-1])
    if panels:
        panels[-1].set_xlabel(f"position of the clamp / {length.unit}")


def _friction(panel: Axes, identification: Identification) -> None:
    periods = identification.periods
    summary = identification.summary()
    at_tip = np.isfinite(periods.contact).any()
    places = periods.contact if at_tip else periods.footpoint
    length = axis_of(identification, Kind.LENGTH, places)
    x = places * length.factor
    slips = periods.status == PeriodStatus.SLIP
    if summary.used:
        low, high = summary.mean + summary.deviation * np.array([-1.0, 1.0])
        panel.axhspan(low, high, color=style.SHAPE, linewidth=0.0, label="mean ± st. dev.")
        panel.axhline(summary.mean, color=style.SURFACE, linewidth=0.8)
    for grade, look in LOOKS.items():
        rows = slips & (periods.grade == grade)
        if rows.any():
            _intervals(panel, identification, x, rows, {"label": NAMES[grade], **look})
    bounds = ~slips & np.isfinite(periods.low)
    look = {"color": style.INK, "marker": "^", "markerfacecolor": "white", "linestyle": "none"}
    if bounds.any():
        panel.plot(x[bounds], periods.low[bounds], label="lower bound: no slip recorded", **look)
    panel.set_ylabel(r"$\mu_0$")
    where = "position of the tip on the surface" if at_tip else "position of the clamp at the slip"
    panel.set_xlabel(f"{where} / {length.unit}")


def _intervals(
    panel: Axes, identification: Identification, x: FloatArray, rows: BoolArray, look: style.Look
) -> None:
    periods = identification.periods.take(rows)
    panel.vlines(x[rows], periods.low, periods.high, color=look["color"], linewidth=0.9)
    panel.plot(x[rows], periods.mu0, linestyle="none", **look)
