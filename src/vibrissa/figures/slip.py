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
THICKNESS, CONE = 0.03, 0.2
# Distance from each rod to the next, and room around them (L).
APART, BESIDE, BELOW, ABOVE = 1.2, 0.2, 0.2, 0.25
# Height of the names below the rods (L).
LOW = -0.13
# The three states: name and colour.
STATES = (
    ("sticking begins", START),
    ("last state of sticking", END),
    ("after the slip", "#009e73"),
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
    figure = style.page(5.2, style.PAGE)
    rods, needed, loads = figure.subplots(3, 1, height_ratios=(2.3, 1.0, 1.0))
    _rods(rods, states)
    _signals(needed, loads, rows[rows["cycle"] <= PERIODS], states)
    return figure


def _rods(panel: Axes, states: list[pd.Series]) -> None:
    """Draw the three rods side by side, with the forces on the first two and the slip."""
    begin, end, _ = states
    eta, mu0 = float(begin["eta"]), float(begin["mu0"])
    marks.surface(panel, eta)
    small: Look = {"fontsize": 7, "va": "center"}
    for number, (state, (name, color)) in enumerate(zip(states, STATES, strict=True), 1):
        right = (number - 1) * APART
        if number > 1:
            # The rod of the state before, to compare.
            before = states[number - 2]
            x, y = np.asarray(before["shape_x"]) + right, np.asarray(before["shape_y"])
            panel.plot(x, y, color=STATES[number - 2][1], linewidth=0.8, linestyle=DASHES[2])
        _rod(panel, state, color, right)
        clamp = right + float(state["footpoint"])
        marks.clamp(panel, clamp)
        panel.text(clamp, LOW, str(number), **_circled(color))
        panel.text(clamp + 0.06, LOW, name, color=color, **small)
    tips = [float(state["x1"] - (1.0 - state["s_c"])) for state in states]
    at = APART + tips[1], eta
    half = np.degrees(np.arctan(mu0))
    cone: Look = {"facecolor": LOAD, "alpha": 0.13, "linewidth": 0.0}
    panel.add_patch(Wedge(at, CONE, 90.0 - half, 90.0 + half, **cone))
    tail = marks.force(panel, at, float(end["alpha"]), CONE)
    words = "force at the edge\nof the friction cone"
    panel.text(tail[0] + 0.03, tail[1] - 0.02, words, color=LOAD, **small)
    ahead = marks.force(panel, (tips[0], eta), float(begin["alpha"]), CONE)
    panel.text(
        ahead[0] + 0.03, ahead[1] - 0.02, "force normal\nto the surface", color=LOAD, **small
    )
    arrow: Look = {"linewidth": 1.4, "color": INK}
    jump = [2 * APART + tip for tip in tips]
    marks.arrow(panel, (jump[1], eta + 0.1), (jump[2], eta + 0.1), **arrow)
    panel.text(jump[2] + 0.03, eta + 0.1, "the tip slips", **small)
    start, stop = (APART + float(state["footpoint"]) for state in (begin, end))
    low = 0.08
    panel.plot([start, stop], [low, low], "|-", color=INK, linewidth=0.8, markersize=4)
    text = rf"$x_{{0,\mathrm{{max}}}} = {end['x0']:g}\,L$:" + "\nmotion of the clamp"
    panel.text(stop + 0.05, low + 0.03, text, **small)
    left = min(float(np.min(state["shape_x"])) for state in states)
    reach = max(float(np.max(state["shape_x"])) for state in states)
    panel.set_xlim(left - BESIDE, reach + 2 * APART + BESIDE)
    panel.set(ylim=(-BELOW, eta + ABOVE), aspect="equal")
    panel.set_axis_off()


def _rod(panel: Axes, state: pd.Series, color: str, right: float) -> None:
    """Draw a rod with its taper, moved to the right; its thickness is exaggerated."""
    x, y, phi = (np.asarray(state[f"shape_{name}"]) for name in ("x", "y", "phi"))
    x = x + right
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
    # Clear of the line, and of the names of the loads below.
    text: Look = {"color": LOAD, "fontsize": 7, "ha": "left", "va": "center"}
    needed.annotate(
        rf"$\mu_0 = {mu0:g}$",
        (1.0, mu0),
        (4, 0),
        ("axes fraction", "data"),
        "offset points",
        **text,
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
    # Where the number of each state stands (points); the third state is one step after the second.
    beside = ((9.0, 0.0), (-9.0, 2.0), (10.0, 0.0))
    for number, ((_, color), state) in enumerate(zip(STATES, states, strict=True), 1):
        at = float(state["footpoint"]), -float(np.tan(state["alpha"]))
        needed.plot(*at, "o", color=color, markersize=3.5, zorder=3)
        place = beside[number - 1]
        needed.annotate(str(number), at, place, textcoords="offset points", **_circled(color))


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
