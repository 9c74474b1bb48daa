"""Figures of a locked round rod: length of periods of sticking, stability, lateral buckling."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from vibrissa.figures import labels, style, symbols
from vibrissa.figures.kinds import POINT, SCAN, kind
from vibrissa.figures.series import Series
from vibrissa.figures.style import SURFACE, THIN
from vibrissa.numerics.arrays import FloatArray
from vibrissa.study.axes import FREQUENCIES
from vibrissa.tables.frames import laterally_buckled

FIRST_STEPS = ("footpoint", "cycle", "phase", "stability_aside", "s_c")
MARGINS = {"stability": "in the plane", "stability_aside": "out of the plane"}
# Angles of the plane of bending at which the buckling rod is drawn (degrees).
TURNS = pd.DataFrame({"turn": np.arange(0.0, 181.0, 30.0)})
# Largest number of steps drawn before and after lateral buckling, and their largest distance (L).
BESIDE, NEAR_SWING = 3, 0.3
BEFORE: style.Look = {"color": style.START, "linestyle": "-"}
AFTER: style.Look = {"color": style.END, "linestyle": style.DASHES[1]}
# Width of the panels (inch), and room beside the rods (L).
WIDTH, OUTSIDE = 2.4, 0.05
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
    solid: style.Look = {"linestyle": "-"}
    for panel, end in ((first, "until"), (later, "after")):
        series.lines(panel, slips, "mu0", "x0_slip", label=None, **solid)
        series.lines(panel, locks, "mu0", end, **solid)
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
    labels.at_ends(first)
    labels.at_ends(later)
    series.explain([first, later])
    return figure


@kind("margins", columns=(*SCAN, *FIRST_STEPS, "stability"))
def margins(rows: pd.DataFrame) -> Figure:
    """Stability in the plane and out of it in the first period of sticking, for each θ."""
    figure = style.page(2.9, style.PAGE)
    panels = figure.subplots(1, 2, sharey=True)
    series = Series(rows, "theta")
    for panel, (margin, name) in zip(panels, MARGINS.items(), strict=True):
        series.lines(panel, _parted(_first_period(rows), margin), "footpoint", margin)
        panel.axhline(0.0, color=SURFACE, linewidth=0.6)
        panel.set_xlabel("clamp displacement $x_0$ / $L$")
        panel.set_ylabel(f"smallest eigenvalue {name}")
        labels.at_ends(panel)
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
            steps = _parted(first, name)
            series.lines(panel, steps, "footpoint", name, linestyle=look, label=None)
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
    swung = laterally_buckled(steps)
    if not swung.any() or swung.all():
        return style.message("the scan has no states after lateral buckling")
    last = steps[~swung].iloc[-1]
    near = steps[(steps["footpoint"] - last["footpoint"]).abs() < NEAR_SWING]
    figure, panels = _views(last, near["footpoint"])
    _surface(panels[0], last, near["footpoint"])
    for after, look, label in ((False, BEFORE, "before"), (True, AFTER, "after")):
        some = near[swung[near.index] == after]
        for place in np.linspace(0, len(some) - 1, min(BESIDE, len(some))).astype(int):
            _rod(panels, some.iloc[place], 0.0, linewidth=0.7, label=f"{label} it buckles", **look)
    series = Series(TURNS, "turn")
    for turn in series.values:
        _rod(panels, last, turn, color=series.color(turn), linewidth=1.4)
    for panel in panels:
        panel.plot(near["footpoint"], 0.0 * near["footpoint"], color="black", linewidth=0.6)
    symbols.clamp(panels[0], last["footpoint"])
    style.legend(figure)
    series.colorbar(list(panels))
    return figure


def _views(row: pd.Series, clamps: pd.Series) -> tuple[Figure, tuple[Axes, Axes]]:
    """Make two panels of one scale and one abscissa: obliquely from the side, and from above."""
    out = _reach(row)
    aside, deep = DEPTH * out
    left, right = clamps.min() - out - aside - OUTSIDE, clamps.max() + out + aside + OUTSIDE
    sizes = (row["eta"] + deep + 0.1 + OUTSIDE, 2.0 * out + 2.0 * OUTSIDE)
    scale = WIDTH / (right - left)
    figure = style.page(scale * sum(sizes) + 1.3)
    panels = figure.subplots(2, 1, sharex=True, height_ratios=sizes)
    panels[0].set(ylim=(-0.1, row["eta"] + deep + OUTSIDE), ylabel="$y$ / $L$")
    panels[1].set(ylim=(-out - OUTSIDE, out + OUTSIDE), ylabel="$z$ / $L$")
    panels[0].set_title("obliquely from the side", loc="left", fontsize=7)
    panels[1].set_title("from above", loc="left", fontsize=7)
    for panel in panels:
        panel.set(aspect="equal", xlim=(left, right))
    panels[1].set_xlabel("$x$ / $L$")
    return figure, (panels[0], panels[1])


def _first_period(rows: pd.DataFrame) -> pd.DataFrame:
    """Keep the first period of sticking of each scan."""
    return rows[(rows["cycle"] == 1) & (rows["phase"] == "stick")]


def _parted(steps: pd.DataFrame, name: str) -> pd.DataFrame:
    """Add a row without a value where contact jumps between tip and flank, as the value jumps."""
    steps = steps.sort_values(["theta", "footpoint"])
    flank, before = steps["s_c"] < 1.0, steps.shift()
    jumps = (flank != (before["s_c"] < 1.0)) & (steps["theta"] == before["theta"])
    between = 0.5 * (steps["footpoint"] + before["footpoint"])
    gaps = steps.assign(footpoint=between, **{name: np.nan})[jumps]
    return pd.concat([steps, gaps])


def _rod(panels: tuple[Axes, Axes], row: pd.Series, turn: float, **look: Any) -> None:
    """Draw a rod in side and top view, its plane turned by `turn` degrees about the clamp axis."""
    out, height = np.asarray(row["shape_x"]) - row["footpoint"], np.asarray(row["shape_y"])
    x = row["footpoint"] + out * np.cos(np.radians(turn))
    z = out * np.sin(np.radians(turn))
    panels[0].plot(*_seen(x, height, z), solid_capstyle="round", **look)
    panels[1].plot(x, z, solid_capstyle="round", **look)


def _reach(row: pd.Series) -> float:
    """Return the largest distance of a rod from the axis of its clamp (L)."""
    return float(np.abs(np.asarray(row["shape_x"]) - row["footpoint"]).max())


def _seen(x: FloatArray, y: FloatArray | float, z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Project points in space obliquely onto the figure."""
    return x + DEPTH[0] * z, y + DEPTH[1] * z


def _surface(panel: Axes, row: pd.Series, clamps: pd.Series) -> None:
    """Draw the part of the surface that a rod reaches from these clamp positions."""
    out = _reach(row)
    left, right = clamps.min() - out, clamps.max() + out
    z = out * np.array([-1.0, -1.0, 1.0, 1.0])
    corners = np.stack(_seen(np.array([left, right, right, left]), row["eta"], z), axis=-1)
    panel.add_patch(Polygon(corners, facecolor="#eeeeee", edgecolor=SURFACE, zorder=0))
