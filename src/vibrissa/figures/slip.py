"""One slip: the poster that shows why a tip slips, and what the clamp feels."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Wedge

from vibrissa.figures import labels, style, symbols
from vibrissa.figures.kinds import SCAN, kind
from vibrissa.figures.style import COLORS, DASHES, END, INK, LOAD, START, Look

# Number of periods whose loads are drawn.
PERIODS = 3
# Drawn diameter of a rod's base (L), and radius of the friction cone (L).
THICKNESS, CONE = 0.03, 0.2
# Room around the rods (L).
LEFT, RIGHT, BELOW, ABOVE = 0.2, 0.4, 0.2, 0.25
# Heights of the names below the rods, and of the motion of the clamp (L).
LOW, SPAN = -0.13, 0.08
SMALL: Look = {"fontsize": 7, "va": "center"}
# Name and colour of each state.
THREE_STATES = (
    ("sticking begins", START),
    ("last state of sticking", END),
    ("after the slip", "#009e73"),
)
COLUMNS = ("footpoint", "x0", "x1", "s_c", "cycle", "phase", "alpha", "reaction_fx", "reaction_fy")


@kind("slip", columns=(*SCAN, *COLUMNS, "shape_x", "shape_y", "shape_phi"))
def slip(rows: pd.DataFrame) -> Figure:
    """One period of sticking and its slip: three rods, the friction cone, loads on the clamp."""
    first = rows[rows["cycle"] == 1]
    sticking, slipped = first[first["phase"] == "stick"], first[first["phase"] == "slip"]
    if slipped.empty:
        return style.message("the tip does not slip")
    states = [sticking.iloc[0], sticking.iloc[-1], slipped.iloc[0]]
    figure = style.page(5.2, style.PAGE)
    grid = figure.add_gridspec(3, 3, height_ratios=(2.3, 1.0, 1.0))
    rods = [figure.add_subplot(grid[0, column]) for column in range(3)]
    needed, loads = (figure.add_subplot(grid[line, :]) for line in (1, 2))
    _rods(rods, states)
    _signals(needed, loads, rows[rows["cycle"] <= PERIODS], states)
    return figure


def _rods(panels: Sequence[Axes], states: list[pd.Series]) -> None:
    """Draw a rod in each panel, with the forces on the first two and the slip."""
    begin, end, _ = states
    eta = float(begin["eta"])
    left = min(float(np.min(state["shape_x"])) for state in states)
    reach = max(float(np.max(state["shape_x"])) for state in states)
    before = None
    for number, (panel, state, (name, color)) in enumerate(
        zip(panels, states, THREE_STATES, strict=True), 1
    ):
        symbols.surface(panel, eta)
        if before is not None:
            # The rod of the state before, to compare.
            look: Look = {"color": THREE_STATES[number - 2][1], "linestyle": DASHES[2]}
            panel.plot(before["shape_x"], before["shape_y"], linewidth=0.8, **look)
        _rod(panel, state, color)
        clamp = float(state["footpoint"])
        symbols.clamp(panel, clamp)
        panel.text(clamp, LOW, str(number), **_circled(color))
        panel.text(clamp + 0.08, LOW, name, color=color, **SMALL)
        panel.set(xlim=(left - LEFT, reach + RIGHT), ylim=(-BELOW, eta + ABOVE), aspect="equal")
        panel.set_axis_off()
        before = state
    tips = [float(state["x1"] - (1.0 - state["s_c"])) for state in states]
    half = np.degrees(np.arctan(float(begin["mu0"])))
    cone: Look = {"facecolor": LOAD, "alpha": 0.13, "linewidth": 0.0}
    panels[1].add_patch(Wedge((tips[1], eta), CONE, 90.0 - half, 90.0 + half, **cone))
    forces = (
        (begin, "force normal\nto the surface"),
        (end, "force at the edge\nof the friction cone"),
    )
    for panel, tip, (state, words) in zip(panels[:2], tips[:2], forces, strict=True):
        tail = symbols.force(panel, (tip, eta), float(state["alpha"]), CONE)
        panel.text(tail[0] + 0.03, tail[1] - 0.02, words, color=LOAD, **SMALL)
    arrow: Look = {"linewidth": 1.4, "color": INK}
    symbols.arrow(panels[2], (tips[1], eta + 0.1), (tips[2], eta + 0.1), **arrow)
    panels[2].text(tips[2] + 0.03, eta + 0.1, "the tip slips", **SMALL)
    ends = [float(begin["footpoint"]), float(end["footpoint"])]
    line: Look = {"color": INK, "linewidth": 0.8, "markersize": 4}
    panels[1].plot(ends, [SPAN, SPAN], "|-", **line)
    text = rf"$x_{{0,\mathrm{{max}}}} = {end['x0']:g}\,L$:" + "\nmotion of the clamp"
    panels[1].text(ends[1] + 0.05, SPAN + 0.03, text, **SMALL)


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
    for number, ((_, color), state) in enumerate(zip(THREE_STATES, states, strict=True), 1):
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
