"""Drawings of the commands' results."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from vibrissa import solve_state
from vibrissa.design import Design
from vibrissa.files import write_atomically
from vibrissa.sensor import Identification, Whisker, WhiskerOnset
from vibrissa.sensor.quantities import Kind
from vibrissa.sensor.series import Column
from vibrissa.sensor.transducer import CHANNELS


def save(figure: Figure, picture: Path) -> None:
    """Write a figure as a whole."""
    with write_atomically(picture) as temporary:
        figure.savefig(temporary)


def shapes(whisker: Whisker, found: WhiskerOnset) -> Figure:
    """Draw the rod at α = 0 and at the onset of slip."""
    curve, units = whisker.curve, whisker.units
    stage_angle = whisker.mounting.stage_angle
    figure = Figure(figsize=(5.0, 4.0), layout="constrained")
    axes = figure.add_subplot()
    unit, s = units.unit(Kind.LENGTH), np.linspace(0.0, 1.0, 101)
    for x0, label in ((0.0, "α = 0"), (found.onset.x0_slip, "onset of slip")):
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
    name = units.name(Kind.LENGTH)
    axes.set(aspect="equal", xlabel=f"x / {name}", ylabel=f"y / {name}")
    axes.legend()
    return figure


def signals(columns: dict[str, Column]) -> Figure:
    """Draw the reactions over the position of the clamp."""
    figure = Figure(figsize=(7.0, 5.5), layout="constrained")
    panels = figure.subplots(3, 1, sharex=True)
    clamp = columns["footpoint"]
    for axes, name in zip(panels, CHANNELS, strict=True):
        axes.plot(clamp.values, columns[name].values, linewidth=0.8)
        axes.set_ylabel(f"{name} / {columns[name].unit}")
    panels[-1].set_xlabel(f"position of the clamp / {clamp.unit}")
    return figure


def friction_map(found: Identification) -> Figure:
    """Draw friction with its interval over the position of the tip."""
    periods, unit = found.periods, found.units.unit(Kind.LENGTH)
    figure = Figure(figsize=(7.0, 3.5), layout="constrained")
    axes = figure.add_subplot()
    bars = np.stack([periods.mu0 - periods.low, periods.high - periods.mu0])
    axes.errorbar(periods.contact * unit, periods.mu0, np.maximum(bars, 0.0), fmt=".", markersize=4)
    axes.set_xlabel(f"position of the tip / {found.units.name(Kind.LENGTH)}")
    axes.set_ylabel("static friction μ0, 95 %")
    return figure


def design(found: Design) -> Figure:
    """Draw the standard deviation over μ0, and all pairs (θ, η) that were solved."""
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    for values, label in (
        (found.deviations.total, "together"),
        (found.deviations.by_step, "by the step"),
        (found.deviations.by_reading, "by the readings"),
    ):
        left.plot(found.mu0, values, label=label)
    left.set(xlabel="static friction μ0", ylabel="standard deviation of μ0", ylim=(0.0, None))
    left.legend()
    pairs = found.pairs
    if pairs is not None:
        good = np.isfinite(found.pair_deviation)
        right.plot(pairs.theta[~good], pairs.eta[~good], ".", color="0.8", label="no rod")
        values = found.pair_deviation[good]
        dots = right.scatter(pairs.theta[good], pairs.eta[good], c=values, norm="log", s=18)
        if good.any():
            figure.colorbar(dots, ax=right, label="largest standard deviation of μ0")
        right.plot(found.theta, found.eta, "*", color="C3", markersize=12, label="the rod")
    right.set(xlabel="taper θ", ylabel="height η / L")
    right.legend(loc="lower right")
    return figure
