"""Figures of what a locked round rod does: how long it sticks, how stable it is, how it swings."""

import math
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from vibrissa.figures import style
from vibrissa.figures.kinds import POINT, SCAN, kind
from vibrissa.figures.series import Series
from vibrissa.figures.style import SURFACE, Look
from vibrissa.numerics.arrays import FloatArray
from vibrissa.tables.frames import swung_aside

FIRST_STEPS = ("footpoint", "cycle", "phase", "x1", "s_c", "phi1", "stability_aside")
MARGINS = {"stability": "in the plane", "stability_aside": "out of the plane"}
# Angles by which the plane of bending is shown turned (degrees).
TURNS = np.arange(0.0, 181.0, 30.0)
# Steps on each side of the swing that are shown with it, at most, and from how far away (L).
BESIDE, NEAR_SWING = 3, 0.3
# Depth is drawn to the right and upwards: how long it is, of its true length.
DEPTH = np.array([0.45, 0.3])


@kind(
    "past_lock", columns=(*POINT, "x0_slip", "ends_by", "x0_end", "x0_trail", "mu_lock", "x0_lock")
)
def past_lock(rows: pd.DataFrame) -> Figure:
    """How far the clamp moves until the tip slips, over μ0 to beyond μ_lock, for each θ."""
    figure = style.page(4.4)
    first, later = figure.subplots(2, 1, sharex=True)
    series = Series(rows["theta"], r"\theta")
    for theta, points in rows.sort_values("mu0").groupby("theta"):
        slips, locks = (points[points["status"] == name] for name in ("slip", "lock"))
        swings = locks["ends_by"] == "swings_aside"
        until = locks["x0_trail"].where(swings, locks["x0_end"])
        after = (until - 2.0 * locks["x0_end"]).where(swings)
        for panel, end in ((first, until), (later, after)):
            series.line(panel, theta, slips["mu0"], slips["x0_slip"])
            series.line(panel, theta, locks["mu0"], end, label=None)
            _mark_lock(panel, points, end, series.color(theta))
        thin: Look = {"linestyle": ":", "linewidth": 0.8, "label": None, "marker": ""}
        series.line(first, theta, locks["mu0"], locks["x0_end"].where(swings), **thin)
    style.mean(first, r"$\mu_\mathrm{lock}$", color="black", linewidth=0.8, linestyle="--")
    style.mean(first, "the rod swings aside", color="black", linewidth=0.8, linestyle=":")
    first.set_ylabel("end of first period / $L$")
    style.from_zero(first)
    later.set_ylabel("length of a later period / $L$")
    later.set_yscale("log")
    later.set_xlabel(style.FRICTION)
    series.explain([first, later])
    return figure


def _mark_lock(panel: Axes, points: pd.DataFrame, until: pd.Series, color: str) -> None:
    """Draw the asymptote from the onset at the lock to the end of sticking just beyond it."""
    known = until.dropna()
    if len(known):
        mu_lock, x0_lock = points["mu_lock"].iloc[0], points["x0_lock"].iloc[0]
        ends = [x0_lock, known.iloc[0]]
        panel.plot([mu_lock, mu_lock], ends, color=color, linewidth=0.8, linestyle="--")


@kind("margins", columns=(*SCAN, *FIRST_STEPS, "stability"))
def margins(rows: pd.DataFrame) -> Figure:
    """Stability in the plane and out of it over the first period of scans, for each θ."""
    figure = style.page(2.9, style.PAGE)
    panels = figure.subplots(1, 2, sharey=True)
    series = Series(rows["theta"], r"\theta")
    for theta, steps in _first_period(rows).groupby("theta"):
        color, swing = series.color(theta), _swing(steps)
        for panel, margin in zip(panels, MARGINS, strict=True):
            series.line(panel, theta, steps["footpoint"], steps[margin])
            panel.axvline(swing, color=color, linewidth=0.6, linestyle=":")
        panels[1].plot(swing, 0.0, "o", color=color, markersize=series.marker_size(4))
    for panel, name in zip(panels, MARGINS.values(), strict=True):
        panel.axhline(0.0, color=SURFACE, linewidth=0.6)
        panel.set_ylabel(f"smallest eigenvalue {name}")
        panel.set_xlabel("clamp displacement $x_0$ / $L$")
    under: Look = {"marker": "o", "linestyle": ":", "linewidth": 0.6, "color": "black"}
    style.mean(panels[1], "the clamp is under the contact point", **under)
    series.explain(list(panels))
    return figure


@kind("swing", columns=(*SCAN, *FIRST_STEPS, "shape_x", "shape_y"))
def swing(rows: pd.DataFrame) -> Figure:
    """Shapes in space of a rod that swings aside: before, at turns of its plane, and after."""
    steps = _first_period(rows).reset_index(drop=True)
    swung = swung_aside(steps)
    if not swung.any() or swung.all():
        return style.message("the rod does not swing aside in this scan")
    last = int(np.flatnonzero(swung)[0]) - 1
    figure = style.page(4.6)
    oblique, above = figure.subplots(2, 1, height_ratios=(1.7, 1.0))
    series = Series(TURNS, r"b\ /\ ^\circ")
    near = steps[(steps["footpoint"] - steps["footpoint"][last]).abs() < NEAR_SWING]
    for side, color, label in (
        (~swung, style.START, "before the swing"),
        (swung, style.END, "after it"),
    ):
        for _, row in _spread(near[side[near.index]]).iterrows():
            _rod(oblique, above, row, 0.0, color=color, linewidth=0.6, label=label)
    for turn in TURNS:
        _rod(oblique, above, steps.loc[last], turn, color=series.color(turn), linewidth=1.4)
    _surroundings(oblique, above, steps.loc[last], near["footpoint"])
    for panel, name in ((oblique, "$y$"), (above, "$z$ (from above)")):
        panel.set_aspect("equal")
        panel.set_xlabel("$x$ / $L$")
        panel.set_ylabel(f"{name} / $L$")
    style.legend(figure, ncols=3)
    series.colorbar([oblique, above])
    return figure


def _first_period(rows: pd.DataFrame) -> pd.DataFrame:
    """Leave out all but the first period of sticking of each scan."""
    return rows[(rows["cycle"] == 1) & (rows["phase"] == "stick")].sort_values("footpoint")


def _swing(steps: pd.DataFrame) -> float:
    """Where the clamp passes under the contact point in the steps of one scan; NaN if nowhere."""
    swung = swung_aside(steps)
    if not swung.any() or swung.all():
        return math.nan
    # The straight tail points away from the clamp.
    tail = (1.0 - steps["s_c"]) * np.where(swung, 1.0, -1.0)
    ahead = (steps["x1"] + tail - steps["footpoint"]).to_numpy()
    after = int(np.flatnonzero(swung)[0])
    pair = slice(after - 1, after + 1)
    return float(np.interp(0.0, -ahead[pair], steps["footpoint"].to_numpy()[pair]))


def _spread(steps: pd.DataFrame) -> pd.DataFrame:
    """Choose some of the steps, equally far apart, or all of a few."""
    return steps.iloc[np.linspace(0, len(steps) - 1, min(BESIDE, len(steps))).astype(int)]


def _rod(oblique: Axes, above: Axes, row: pd.Series, turn: float, **look: Any) -> None:
    """Draw a rod whose plane is turned by an angle (degrees) about the clamp's axis."""
    out, height = np.asarray(row["shape_x"]) - row["footpoint"], np.asarray(row["shape_y"])
    x = row["footpoint"] + out * np.cos(np.radians(turn))
    z = out * np.sin(np.radians(turn))
    oblique.plot(*_seen(x, height, z), solid_capstyle="round", **look)
    above.plot(x, z, solid_capstyle="round", **look)


def _seen(x: FloatArray, y: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where points in space are drawn: depth z is oblique."""
    return x + DEPTH[0] * z, y + DEPTH[1] * z


def _surroundings(oblique: Axes, above: Axes, row: pd.Series, clamps: pd.Series) -> None:
    """Draw the surface and the way of the clamp."""
    out = float(np.abs(np.asarray(row["shape_x"]) - row["footpoint"]).max())
    left, right = clamps.min() - out, clamps.max() + out
    x = np.array([left, right, right, left])
    z = out * np.array([-1.0, -1.0, 1.0, 1.0])
    corners = np.stack(_seen(x, np.full(4, row["eta"]), z), axis=-1)
    oblique.add_patch(Polygon(corners, facecolor="#eeeeee", edgecolor=SURFACE, zorder=0))
    for panel in (oblique, above):
        panel.plot(clamps, 0.0 * clamps, color="black", linewidth=0.6)
        panel.plot(row["footpoint"], 0.0, "s", color="black", markersize=4, label="clamp")
