"""Figures of the periods of scans: what slip laws say of travel, slips, loads and frequency."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibrissa.figures import style
from vibrissa.figures.kinds import kind
from vibrissa.figures.maps import LABELS, symbol
from vibrissa.numerics.arrays import FloatArray
from vibrissa.study.axes import AXES, LAW_AXES, SURFACE_AXES
from vibrissa.tables.schemas import LOADS

KEYS = (*AXES, "surface", *SURFACE_AXES, *LAW_AXES, "status", "message")
LOAD_LABELS = {
    "reaction_fx": r"$F_x$ / $E I_0/L^2$",
    "reaction_fy": r"$F_y$ / $E I_0/L^2$",
    "reaction_m": r"$M$ / $E I_0/L$",
}
DASHES = ("-", "--", ":", "-.")
# Columns of the panels, with their labels.
PANELS = {
    "travel": r"travel of the clamp / $L$",
    "slip_length": r"length of the slip / $L$",
    "fall": r"fall of $F_x$ / $E I_0/L^2$",
}
# Number of periods that are drawn as a sawtooth.
TEETH = 6


class DrawnSeries(NamedTuple):
    """Rows of a series, with its name and its look."""

    name: str
    rows: pd.DataFrame
    look: style.Look


def lines_of(rows: pd.DataFrame, by: str) -> Iterator[DrawnSeries]:
    """Split rows by an axis; the law ``free`` comes first."""
    values = sorted(rows[by].dropna().unique(), key=lambda value: (value != "free", value))
    for place, value in enumerate(values):
        name = str(value) if isinstance(value, str) else f"${symbol(by)} = {value:g}$"
        look: style.Look = {
            "color": style.COLORS[place % len(style.COLORS)],
            "linestyle": DASHES[place % len(DASHES)],
        }
        yield DrawnSeries(name=name, rows=rows[rows[by] == value], look=look)


@kind(
    "periods",
    columns=(*KEYS, "period", "ends_by", "travel", "slip_length", *LOADS),
    keys=("over", "by"),
)
def periods(rows: pd.DataFrame, over: str, by: str) -> Figure:
    """Mean travel, slip length and fall of the load after the first period; bands: all values."""
    ended = rows[(rows["ends_by"] == "slip") & (rows["period"] > 1)]
    ended = ended.assign(fall=ended["reaction_fx_rest"] - ended["reaction_fx_onset"])
    if ended.empty:
        return style.message("no scan has a second period that ends with a slip")
    figure = style.page(2.5, style.PAGE)
    panels = figure.subplots(1, len(PANELS), sharex=True)
    for line in lines_of(ended, by):
        for panel, column in zip(panels, PANELS, strict=True):
            _summary(panel, line, over, column)
    for panel, label in zip(panels, PANELS.values(), strict=True):
        panel.set(xlabel=LABELS[over], ylabel=label)
        style.from_zero(panel)
    style.legend(figure)
    return figure


def _summary(panel: Axes, line: DrawnSeries, over: str, column: str) -> None:
    """Draw means over an axis and the band of all values; a level line without this axis."""
    if line.rows[over].isna().all():
        panel.axhline(line.rows[column].mean(), label=line.name, **line.look)
        return
    found = line.rows.groupby(over)[column].agg(["mean", "min", "max"])
    look = line.look | style.alone(found["mean"])
    panel.plot(found.index, found["mean"], label=line.name, **look)
    panel.fill_between(
        found.index, found["min"], found["max"], color=line.look["color"], alpha=0.15, linewidth=0
    )


@kind("sawtooth", columns=(*KEYS, "footpoint", "cycle", *LOAD_LABELS), keys=("by", "value"))
def sawtooth(rows: pd.DataFrame, by: str, value: str = "reaction_fx") -> Figure:
    """Draw a load over the position of the clamp, a panel for each law; slips are dotted."""
    lines = list(lines_of(rows[(rows["cycle"] <= TEETH)], by))
    figure = style.page(0.9 + 0.9 * len(lines), style.COLUMN)
    panels = figure.subplots(len(lines), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    for panel, line in zip(panels, lines, strict=True):
        x, load = line.rows["footpoint"], line.rows[value]
        panel.plot(x, load, color=line.look["color"], linewidth=0.8)
        panel.set_title(line.name, fontsize=8, loc="left", pad=2)
        panel.set_ylabel(LOAD_LABELS[value])
    panels[-1].set_xlabel("clamp position / $L$")
    return figure


@kind("spectrum", columns=(*KEYS, "footpoint", *LOAD_LABELS), keys=("by", "value"))
def spectrum(rows: pd.DataFrame, by: str, value: str = "reaction_fx") -> Figure:
    """Draw the amplitude of a load over its frequency along the path of the clamp."""
    figure, panel = style.axes(2.6)
    most = 0.0
    for line in lines_of(rows, by):
        load, step = line.rows[value].to_numpy(), line.rows["dx0"].iloc[0]
        frequency, amplitude = amplitudes(load, step)
        panel.plot(frequency, amplitude, label=line.name, linewidth=0.8, **line.look)
        most = max(most, 4.0 * frequency[1 + np.argmax(amplitude[1:])])
    panel.set(
        xlabel="frequency along the path / $1/L$", ylabel=f"amplitude of {LOAD_LABELS[value]}"
    )
    panel.set_xlim(0.0, min(most, float(frequency[-1])))
    style.from_zero(panel)
    style.legend(figure)
    return figure


class Spectrum(NamedTuple):
    """Frequencies (1/L) and amplitudes of a signal."""

    frequency: FloatArray
    amplitude: FloatArray


def amplitudes(signal: FloatArray, step: float) -> Spectrum:
    """Amplitudes of the Fourier components of a signal less its mean, with a Hann window.

    Parameters
    ----------
    signal : ndarray, shape (n,)
        Equally spaced values.
    step : float
        Distance between two values (L).
    """
    window = np.hanning(len(signal))
    # The scale for which a sine keeps its amplitude.
    amplitude = 2.0 * np.abs(np.fft.rfft((signal - signal.mean()) * window)) / window.sum()
    frequency: FloatArray = np.fft.rfftfreq(len(signal), step).astype(np.float64)
    return Spectrum(frequency=frequency, amplitude=amplitude)
