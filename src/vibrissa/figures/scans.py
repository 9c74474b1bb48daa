"""Figures of stick-slip scans: shapes of the rod and loads on the clamp."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibrissa.figures import shapes, style
from vibrissa.figures.kinds import SCAN, kind
from vibrissa.figures.style import COLORS, END, SHAPE, START, SURFACE, Look

SHAPES = ("x0", "footpoint", "cycle", "phase", "shape_x", "shape_y")
# Largest number of panels with letters.
LETTERS = 26
REACTIONS = {"reaction_fx": "$F_x$", "reaction_fy": "$F_y$", "reaction_m": "$M$"}


@kind("scan", columns=(*SCAN, *SHAPES))
def scan(rows: pd.DataFrame) -> Figure:
    """Shapes of scans at every clamp position, a panel for each θ (paper Figures 4 and 5)."""
    return _figure(rows, 0.6)


@kind("period", columns=(*SCAN, *SHAPES))
def period(rows: pd.DataFrame) -> Figure:
    """Shapes of scans in the first period of sticking, a panel for each θ (paper Figure 3)."""
    first = (rows["cycle"] == 1) & (rows["phase"] == "stick")
    return _figure(rows[first | rows["footpoint"].isna()], 1.2)


def _figure(rows: pd.DataFrame, linewidth: float) -> Figure:
    """Draw a panel for each θ; the legend names each θ without a result."""
    solved = rows[rows["footpoint"].notna()]
    scans = [steps.sort_values("footpoint") for _, steps in solved.groupby("theta")]
    figure, panels, is_narrow = shapes.panels(scans)
    for i, (panel, steps) in enumerate(zip(panels, scans, strict=True)):
        _draw(panel, steps, linewidth)
        if len(scans) > 1:
            letter = f"({chr(ord('a') + i)}) " if len(scans) <= LETTERS else ""
            text = rf"{letter}$\theta = {steps['theta'].iloc[0]:g}$"
            panel.text(1.0, 0.03, text, transform=panel.transAxes, ha="right")
    for label, color, width in (
        (r"$\alpha = 0$: sticking begins", START, linewidth),
        ("sticking", SHAPE, 0.6),
        ("last sticking state", END, linewidth),
    ):
        style.mean(panels[0], label, color=color, linewidth=width)
    for theta in sorted(set(rows["theta"]) - set(solved["theta"])):
        style.no_result(panels[0], rf"$\theta = {theta:g}$")
    style.legend(figure, beside=is_narrow)
    return figure


def _draw(panel: Axes, steps: pd.DataFrame, linewidth: float) -> None:
    """Draw all shapes of a scan, and highlight the first and last one of each period."""
    sticking = steps[steps["phase"] == "stick"]
    begin, end = steps[steps["x0"] == 0], sticking.groupby("cycle").tail(1)
    shapes.draw(panel, steps, color=SHAPE, linewidth=0.25)
    for ends, color in ((begin, START), (end, END)):
        shapes.draw(panel, ends, color=color, linewidth=linewidth, zorder=2.5)
        clamps: Look = {"color": color, "markersize": 6, "markeredgewidth": 0.8, "zorder": 3}
        x, y = ([shape[0] for shape in ends[name]] for name in ("shape_x", "shape_y"))
        panel.plot(x, y, "|", **clamps)


@kind(
    "signals",
    columns=(*SCAN, "footpoint", "cycle", "alpha", "stability", "stability_aside", *REACTIONS),
)
def signals(rows: pd.DataFrame) -> Figure:
    """Inclination of the contact force, clamp reactions and stability over the clamp's position."""
    figure = style.page(4.4)
    inclination, reactions, stability = figure.subplots(3, 1, sharex=True)
    rows = rows.sort_values("footpoint")
    x, mu0 = rows["footpoint"], rows["mu0"].iloc[0]
    inclination.plot(x, np.tan(rows["alpha"]), color="black")
    cone: Look = {"color": SURFACE, "linewidth": 0.8, "linestyle": "--"}
    inclination.axhline(mu0, label=r"friction cone $\pm\mu_0$", **cone)
    inclination.axhline(-mu0, **cone)
    inclination.set_ylabel(r"$\tan\alpha$")
    for (name, label), color in zip(REACTIONS.items(), COLORS, strict=False):
        reactions.plot(x, rows[name], color=color, label=label)
    reactions.set_ylabel("load on the clamp")
    stability.plot(x, rows["stability"], color=COLORS[3], label="stability in the plane")
    if rows["stability_aside"].notna().any():
        label = "stability out of the plane"
        stability.plot(x, rows["stability_aside"], color=COLORS[4], label=label)
    stability.set(xlabel="clamp position / $L$", ylabel="smallest eigenvalue")
    stability.set_ylim(bottom=min(0.0, rows["stability"].min()))
    style.legend(figure)
    return figure
