"""Figures of a locked round rod: length of periods of sticking, stability, lateral buckling."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from vibrissa.figures import style
from vibrissa.figures.kinds import POINT, SCAN, kind
from vibrissa.figures.series import Series
from vibrissa.figures.style import SURFACE, THIN
from vibrissa.numerics.arrays import FloatArray
from vibrissa.study.axes import FREQUENCIES
from vibrissa.tables.frames import swung_aside

FIRST_STEPS = ("footpoint", "cycle", "phase", "stability_aside")
MARGINS = {"stability": "in the plane", "stability_aside": "out of the plane"}
# Angles of the plane of bending at which the buckling rod is drawn (degrees).
TURNS = pd.DataFrame({"turn": np.arange(0.0, 181.0, 30.0)})
# Largest number of steps drawn before and after lateral buckling, and their largest distance (L).
BESIDE, NEAR_SWING = 3, 0.3
# Oblique projection: shares of the depth z that are drawn to the right and upwards.
DEPTH = np.array([0.45, 0.3])


@kind(
    "past_lock", columns=(*POINT, "x0_slip", "ends_by", "x0_end", "x0_trail", "mu_lock", "x0_lock")
)
def past_lock(rows: pd.DataFrame) -> Figure:
    """Clamp displacement in the first and in later periods of sticking over μ0, for each θ."""
    figure = style.page(4.4)
    first, later = figure.subplots(2, 1, sharex=True)
    series = Series(rows, "theta")
    slips, locks = (rows[rows["status"] == name] for name in ("slip", "lock"))
    swing = locks["x0_end"].where(locks["ends_by"] == "swings_aside")
    until = locks["x0_trail"].where(swing.notna(), locks["x0_end"])
    locks = locks.assign(swing=swing, until=until, after=until - 2.0 * swing)
    for panel, end in ((first, "until"), (later, "after")):
        series.lines(panel, slips, "mu0", "x0_slip")
        series.lines(panel, locks, "mu0", end, label=None)
        # Jump from the onset at the lock to the end of sticking just above μ_lock.
        jumps = locks.dropna(subset=end).sort_values("mu0").drop_duplicates("theta")
        ends, colors = (jumps["x0_lock"], jumps[end]), jumps["theta"].map(series.color)
        panel.vlines(jumps["mu_lock"], *ends, colors=colors, linewidth=0.8, linestyles="--")
    dots: style.Look = {"linestyle": ":", "linewidth": 0.8}
    series.lines(first, locks, "mu0", "swing", label=None, marker="", **dots)
    style.mean(first, r"$\mu_\mathrm{lock}$", linestyle="--", **THIN)
    style.mean(first, "the rod buckles laterally", color="black", **dots)
    first.set_ylabel("end of first period / $L$")
    style.from_zero(first)
    later.set(xlabel=style.FRICTION, ylabel="length of a later period / $L$", yscale="log")
    series.explain([first, later])
    return figure


@kind("margins", columns=(*SCAN, *FIRST_STEPS, "stability"))
def margins(rows: pd.DataFrame) -> Figure:
    """Stability in the plane and out of it in the first period of sticking, for each θ."""
    figure = style.page(2.9, style.PAGE)
    panels = figure.subplots(1, 2, sharey=True)
    series = Series(rows, "theta")
    for panel, (margin, name) in zip(panels, MARGINS.items(), strict=True):
        series.lines(panel, _first_period(rows), "footpoint", margin)
        panel.axhline(0.0, color=SURFACE, linewidth=0.6)
        panel.set_xlabel("clamp displacement $x_0$ / $L$")
        panel.set_ylabel(f"smallest eigenvalue {name}")
    series.explain(list(panels))
    return figure


@kind("ringing", columns=(*SCAN, *FIRST_STEPS, *FREQUENCIES))
def ringing(rows: pd.DataFrame) -> Figure:
    """Natural frequencies in the first period of sticking, for each θ."""
    figure, panel = style.axes(3.0)
    series = Series(rows, "theta")
    first = _first_period(rows)
    for name, (which, look) in zip(FREQUENCIES, style.FREQUENCY_LOOKS.items(), strict=True):
        if first[name].notna().any():
            series.lines(panel, first, "footpoint", name, linestyle=look, label=None)
            style.mean(panel, which, linestyle=look, color="black")
    panel.set_xlabel("clamp displacement $x_0$ / $L$")
    panel.set_ylabel(style.FREQUENCY)
    style.from_zero(panel)
    series.explain(panel)
    return figure


@kind("swing", columns=(*SCAN, *FIRST_STEPS, "phi1", "shape_x", "shape_y"))
def swing(rows: pd.DataFrame) -> Figure:
    """Shapes of a rod in space before, during and after lateral buckling."""
    steps = _first_period(rows)
    swung = swung_aside(steps)
    if not swung.any() or swung.all():
        return style.message("the scan has no states after lateral buckling")
    figure = style.page(4.6)
    panels = figure.subplots(2, 1, height_ratios=(1.7, 1.0))
    last = steps[~swung].iloc[-1]
    near = steps[(steps["footpoint"] - last["footpoint"]).abs() < NEAR_SWING]
    for after, color, label in ((False, style.START, "before"), (True, style.END, "after")):
        some = near[swung[near.index] == after]
        for place in np.linspace(0, len(some) - 1, min(BESIDE, len(some))).astype(int):
            look = {"color": color, "linewidth": 0.6, "label": f"{label} it buckles"}
            _rod(panels, some.iloc[place], 0.0, **look)
    series = Series(TURNS, "turn")
    for turn in series.values:
        _rod(panels, last, turn, color=series.color(turn), linewidth=1.4)
    _surface(panels[0], last, near["footpoint"])
    for panel, name in zip(panels, ("$y$", "$z$ (from above)"), strict=True):
        panel.plot(near["footpoint"], 0.0 * near["footpoint"], color="black", linewidth=0.6)
        panel.plot(last["footpoint"], 0.0, "s", color="black", markersize=4, label="clamp")
        panel.set(aspect="equal", xlabel="$x$ / $L$", ylabel=f"{name} / $L$")
    series.explain(list(panels), ncols=3)
    return figure


def _first_period(rows: pd.DataFrame) -> pd.DataFrame:
    """Keep the first period of sticking of each scan."""
    return rows[(rows["cycle"] == 1) & (rows["phase"] == "stick")].sort_values("footpoint")


def _rod(panels: tuple[Axes, Axes], row: pd.Series, turn: float, **look: Any) -> None:
    """Draw a rod in side and top view, its plane turned by `turn` degrees about the clamp axis."""
    out, height = np.asarray(row["shape_x"]) - row["footpoint"], np.asarray(row["shape_y"])
    x = row["footpoint"] + out * np.cos(np.radians(turn))
    z = out * np.sin(np.radians(turn))
    panels[0].plot(*_seen(x, height, z), solid_capstyle="round", **look)
    panels[1].plot(x, z, solid_capstyle="round", **look)


def _seen(x: FloatArray, y: FloatArray | float, z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Project points in space obliquely onto the figure."""
    return x + DEPTH[0] * z, y + DEPTH[1] * z


def _surface(panel: Axes, row: pd.Series, clamps: pd.Series) -> None:
    """Draw the part of the surface that a rod reaches from these clamp positions."""
    out = float(np.abs(np.asarray(row["shape_x"]) - row["footpoint"]).max())
    left, right = clamps.min() - out, clamps.max() + out
    z = out * np.array([-1.0, -1.0, 1.0, 1.0])
    corners = np.stack(_seen(np.array([left, right, right, left]), row["eta"], z), axis=-1)
    panel.add_patch(Polygon(corners, facecolor="#eeeeee", edgecolor=SURFACE, zorder=0))
