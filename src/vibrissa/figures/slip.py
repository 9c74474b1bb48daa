"""One slip: the poster that shows why a tip slips, and what the clamp feels."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Wedge

from vibrissa.figures import labels, marks, style
from vibrissa.figures.kinds import SCAN, kind
from vibrissa.figures.style import COLORS, DASHES, END, INK, LOAD, START, Look

# Number of periods whose loads are drawn.
PERIODS = 3
# Drawn diameter of a rod's base (L), and radius of the friction cone (L).
THICKNESS, CONE = 0.022, 0.2
# Distance of a number from its rod (L).
BESIDE = 0.05
# Limits of the panel with the rods, beside and around the rods (L).
LEFT, RIGHT, BELOW, ABOVE = 0.36, 0.42, 0.17, 0.27
# The three states: name, colour, height (share of η) and side (−1: left) of the name.
STATES = (
    ("sticking begins", START, 0.3, -1),
    ("last state of sticking", END, 0.8, -1),
    ("after the slip", "#009e73", 0.5, 1),
)
COLUMNS = ("footpoint", "x0", "x1", "s_c", "cycle", "phase", "alpha", "reaction_fx", "reaction_fy")


@kind("slip", columns=(*SCAN, *COLUMNS, "shape_x", "shape_y", "shape_phi"))
def slip(rows: pd.DataFrame) -> Figure:
    """One period of sticking and its slip: three rods, the friction cone, loads on the clamp."""
    rows = rows.sort_values("footpoint")
    first = rows[rows["cycle"] == 1]
    sticking, slipped = first[first["phase"] == "stick"], first[first["phase"] == "slip"]
    if slipped.empty:
        return style.message("the tip does not slip")
    states = [sticking.iloc[0], sticking.iloc[-1], slipped.iloc[0]]
    figure = style.page(3.7, style.PAGE)
    grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.25))
    rods = figure.add_subplot(grid[:, 0])
    needed, loads = (figure.add_subplot(grid[line, 1]) for line in (0, 1))
    _rods(rods, states)
    _signals(needed, loads, rows[rows["cycle"] <= PERIODS], states)
    return figure


def _rods(panel: Axes, states: list[pd.Series]) -> None:
    """Draw the three rods, with the forces on the first two, and the slip of the tip."""
    begin, end, after = states
    eta, mu0 = float(begin["eta"]), float(begin["mu0"])
    marks.surface(panel, eta)
    small: Look = {"fontsize": 7, "va": "center"}
    for number, state in enumerate(states, 1):
        name, color, share, side = STATES[number - 1]
        _rod(panel, state, color)
        y = share * eta
        x = float(np.interp(y, state["shape_y"], state["shape_x"])) + side * BESIDE
        panel.text(x, y, str(number), **_circled(color))
        ends = "right" if side < 0 else "left"
        panel.text(x + side * 0.04, y, name, color=color, ha=ends, **small)
    marks.clamp(panel, float(begin["footpoint"]))
    marks.clamp(panel, float(after["footpoint"]))
    tips = [float(state["x1"] - (1.0 - state["s_c"])) for state in states]
    half = np.degrees(np.arctan(mu0))
    cone: Look = {"facecolor": LOAD, "alpha": 0.13, "linewidth": 0.0}
    panel.add_patch(Wedge((tips[1], eta), CONE, 90.0 - half, 90.0 + half, **cone))
    tail = marks.force(panel, (tips[1], eta), float(end["alpha"]), CONE)
    panel.text(
        tail[0] + 0.02, tail[1], "force at the edge\nof the friction cone", color=LOAD, **small
    )
    arrow: Look = {"linewidth": 1.4, "color": INK}
    marks.arrow(panel, (tips[1], eta - 0.035), (tips[2], eta - 0.035), **arrow)
    panel.text(tips[2] + 0.015, eta - 0.05, "the tip slips", **small)
    low = -0.13
    start, stop = float(begin["footpoint"]), float(end["footpoint"])
    panel.plot([start, stop], [low, low], "|-", color=INK, linewidth=0.8, markersize=4)
    text = rf"$x_{{0,\mathrm{{max}}}} = {end['x0']:g}\,L$"
    panel.text(stop + 0.03, low, text + ": motion of the clamp", **small)
    left = min(float(np.min(state["shape_x"])) for state in states)
    right = max(float(np.max(state["shape_x"])) for state in states)
    panel.set(xlim=(left - LEFT, right + RIGHT), ylim=(-BELOW, eta + ABOVE), aspect="equal")
    panel.set_axis_off()


def _rod(panel: Axes, state: pd.Series, color: str) -> None:
    """Draw a rod with its taper; its thickness is exaggerated."""
    x, y, phi = (np.asarray(state[f"shape_{name}"]) for name in ("x", "y", "phi"))
    s = np.linspace(0.0, 1.0, len(x))
    half = 0.5 * THICKNESS * (1.0 - (1.0 - 1.0 / state["theta"]) * s)
    across = half * np.sin(phi), half * np.cos(phi)
    ends = np.append(x - across[0], (x + across[0])[::-1])
    panel.fill(ends, np.append(y + across[1], (y - across[1])[::-1]), facecolor=color, alpha=0.9)


def _signals(needed: Axes, loads: Axes, rows: pd.DataFrame, states: list[pd.Series]) -> None:
    """Draw −tan α and the loads on the clamp over the position of the clamp."""
    x, mu0 = rows["footpoint"], float(rows["mu0"].iloc[0])
    needed.plot(x, -np.tan(rows["alpha"]), color=INK)
    needed.axhline(mu0, color=LOAD, linewidth=0.9, linestyle=DASHES[1])
    needed.text(
        x.max(), mu0, rf"$\mu_0 = {mu0:g}$", color=LOAD, fontsize=7, ha="right", va="bottom"
    )
    needed.set_ylim(-0.12 * mu0, 1.3 * mu0)
    needed.set_title(r"friction that sticking needs, $-\tan\alpha$", loc="left", fontsize=8)
    needed.tick_params(labelbottom=False)
    for i, (name, label) in enumerate((("reaction_fx", "$f_x$"), ("reaction_fy", "$f_y$"))):
        loads.plot(x, rows[name], color=COLORS[i], linestyle=DASHES[i], label=label)
    loads.set_title(r"load on the clamp / $E I_0/L^2$", loc="left", fontsize=8)
    loads.set_xlabel("position of the clamp / $L$")
    for panel in (needed, loads):
        panel.set_xlim(x.min() - 0.03 * np.ptp(x), x.max())
    labels.at_ends(loads)
    for number, state in enumerate(states, 1):
        color = STATES[number - 1][1]
        at = float(state["footpoint"]), -float(np.tan(state["alpha"]))
        needed.plot(*at, "o", color=color, markersize=3.5, zorder=3)
        # The third state is one step after the second.
        right, up = ((-9.0, 9.0), (-10.0, 3.0), (10.0, 0.0))[number - 1]
        needed.annotate(str(number), at, (right, up), textcoords="offset points", **_circled(color))


def _circled(color: str) -> Look:
    """Return the look of a number in a circle."""
    circle: Look = {"boxstyle": "circle,pad=0.15", "facecolor": "white", "edgecolor": color}
    return {
        "fontsize": 7,
        "ha": "center",
        "va": "center",
        "color": color,
        "bbox": circle,
    }
