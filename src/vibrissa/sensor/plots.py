"""Drawings of results, in the units of their tables. Matplotlib is loaded with this module."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from vibrissa.outcomes import Status
from vibrissa.sensor.identification.periods import Grade, Periods
from vibrissa.sensor.quantities import Kind, Units
from vibrissa.sensor.series import Column
from vibrissa.sensor.transducer import CHANNELS
from vibrissa.sensor.whisker import Whisker
from vibrissa.sticking.api import Onset, solve_state

# How a period with a doubt of each grade is drawn, by a sign of its own and not by colour alone.
SIGNS = {"": ("o", "C0"), Grade.INFORMATION: ("s", "C0"), Grade.DOUBTFUL: ("^", "C1")} | {
    Grade.WRONG: ("x", "C3")
}


def shapes(whisker: Whisker, onset: Onset) -> Figure:
    """Draw the rod at α = 0, and at the onset of slip or, of a tip that locks, critical."""
    curve, units = whisker.curve, whisker.units
    last = (onset.x0_slip, "onset of slip")
    if onset.status is Status.LOCK:
        last = (curve.x0_lock, f"critical state, −tan α = {onset.mu_lock:.4g}")
    stage_angle = whisker.mounting.stage_angle
    figure = Figure(figsize=(5.0, 4.0), layout="constrained")
    axes = figure.add_subplot()
    (unit, name), s = units.told(units.unit(Kind.LENGTH), Kind.LENGTH), np.linspace(0.0, 1.0, 101)
    for x0, label in ((0.0, "α = 0"), last):
        x1, height = curve.contact_point(x0)
        state = solve_state(
            whisker.theta, float(height), float(x1), whisker.contact, whisker.mounting
        )
        x, y, _ = state.shape(s)
        axes.plot(
            (x + x0 * np.cos(stage_angle)) * unit,
            (y + x0 * np.sin(stage_angle)) * unit,
            label=label,
        )
    axes.axhline(whisker.eta * unit, color="0.5", linewidth=0.8)
    axes.set(aspect="equal", xlabel=f"x / {name}", ylabel=f"y / {name}")
    # In the axes it would lie on the rod.
    figure.legend(loc="outside lower center", ncols=2)
    return figure


def signals(columns: Mapping[str, Column]) -> Figure:
    """Draw the reactions over the position of the clamp."""
    figure = Figure(figsize=(7.0, 5.5), layout="constrained")
    panels = figure.subplots(3, 1, sharex=True)
    clamp = columns["footpoint"]
    for axes, name in zip(panels, CHANNELS, strict=True):
        axes.plot(clamp.values, columns[name].values, linewidth=0.8)
        axes.set_ylabel(f"{name} / {columns[name].unit}")
    panels[-1].set_xlabel(f"position of the clamp / {clamp.unit}")
    return figure


def friction_map(periods: Periods, units: Units) -> Figure:
    """Draw friction with its interval over the position of the tip, and how far it is in doubt."""
    unit, name = units.told(units.unit(Kind.LENGTH), Kind.LENGTH)
    tip = bool(np.isfinite(periods.contact).any())
    figure = Figure(figsize=(7.0, 3.5), layout="constrained")
    axes = figure.add_subplot()
    for grade, (marker, colour) in SIGNS.items():
        some = periods.take((periods.grade == grade) & np.isfinite(periods.mu0))
        if len(some):
            bars = np.stack([some.mu0 - some.low, some.high - some.mu0])
            axes.errorbar(
                (some.contact if tip else some.footpoint) * unit,
                some.mu0,
                np.maximum(bars, 0.0),
                fmt=marker,
                color=colour,
                markersize=4,
                label=grade or "no doubt",
            )
    if axes.containers and (periods.grade != "").any():
        axes.legend(title="doubts")
    axes.set_xlabel(f"position of the {'tip' if tip else 'clamp'} / {name}")
    axes.set_ylabel("static friction μ0, 95 %")
    return figure
