"""Figures of stick-slip scans: shapes of the rod and loads on the clamp."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibrissa.figures import labels, shapes, style, symbols
from vibrissa.figures.kinds import SCAN, kind
from vibrissa.figures.series import SYMBOLS
from vibrissa.figures.style import COLORS, DASHES, END, INK, SHAPE, START, Look

SHAPES = ("x0", "footpoint", "x1", "cycle", "phase", "shape_x", "shape_y")
# Largest number of panels with letters.
LETTERS = 26
REACTIONS = {"reaction_fx": "$f_x$", "reaction_fy": "$f_y$", "reaction_m": "$m$"}
BEGINS: Look = {"color": START, "linestyle": "-"}
ENDS: Look = {"color": END, "linestyle": (0, (4, 1.2))}
# Names of the first shape of a period, with its inclination if it is the same in all, and the last.
BEGUN, FREE = "sticking\nbegins", "sticking begins,\n$\\alpha = 0$"
ENDED = "last state\nof sticking"
# Room that the names need beside the shapes, and their distance from them (L).
ROOM, GAP = 0.4, 0.08


@kind("scan", columns=(*SCAN, *SHAPES), is_scaled_by_all=True)
def scan(rows: pd.DataFrame, every: pd.DataFrame | None = None) -> Figure:
    """Shapes of scans at every position of the clamp, and their slips (paper Figures 4 and 5).

    There is a panel for each θ and, below each other, for each μ0. All figures of the same scans
    have the same scale and the same axes.
    """
    return _figure(rows, rows if every is None else every, 0.7)


@kind("period", columns=(*SCAN, *SHAPES), is_scaled_by_all=True)
def period(rows: pd.DataFrame, every: pd.DataFrame | None = None) -> Figure:
    """Shapes of scans in the first period of sticking, a panel for each θ (paper Figure 3)."""
    return _figure(_first_period(rows), _first_period(rows if every is None else every), 1.2)


def _first_period(rows: pd.DataFrame) -> pd.DataFrame:
    """Keep the first period of sticking of each scan with its slip, and scans without a result."""
    return rows[(rows["cycle"] == 1) | rows["footpoint"].isna()]


def _figure(rows: pd.DataFrame, every: pd.DataFrame, linewidth: float) -> Figure:
    """Draw a panel for each θ and μ0; a note names each scan without a result."""
    solved = rows[rows["footpoint"].notna()]
    scans = [steps for _, steps in solved.groupby(["mu0", "theta"])]
    tapers, is_sheet = solved["theta"].nunique(), solved["mu0"].nunique() > 1
    columns = tapers if is_sheet else min(tapers, shapes.IN_A_ROW)
    usual = min(every["theta"].nunique(), shapes.IN_A_ROW)
    room = shapes.room_of(every[every["footpoint"].notna()])
    etas = [float(steps["eta"].iloc[0]) for steps in scans]
    figure, panels = shapes.panels(etas, room, columns, max(columns, usual))
    for i, (panel, steps) in enumerate(zip(panels, scans, strict=True)):
        _draw(panel, steps, linewidth)
        if len(scans) > 1:
            letter = f"({chr(ord('a') + i)}) " if len(scans) <= LETTERS else ""
            shown = ["theta", "mu0"] if is_sheet else ["theta"]
            values = [f"${SYMBOLS[name]} = {steps[name].iloc[0]:g}$" for name in shown]
            panel.set_title(letter + ", ".join(values), loc="left", fontsize=8)
    for panel, steps in zip(panels, scans, strict=True):
        _name_motion(panel, steps)
    _name_lines(panels[0], scans[0], linewidth)
    for theta in sorted(set(rows["theta"]) - set(solved["theta"])):
        style.no_result(panels[0], rf"$\theta = {theta:g}$")
    shapes.legend(figure, columns=2 if columns == 1 else 4)
    return figure


def _draw(panel: Axes, steps: pd.DataFrame, linewidth: float) -> None:
    """Draw the periods of a scan: what the rod passes over, its first and last shape, and slips."""
    sticking, slipping = steps[steps["phase"] == "stick"], steps[steps["phase"] == "slip"]
    begin, end = steps[begins(steps)], sticking.groupby("cycle").tail(1)
    # A period begins in the state into which the slip before it has led.
    shown = pd.concat([slipping.assign(cycle=slipping["cycle"] + 1), sticking])
    shapes.bands(panel, [rows for _, rows in shown.groupby("cycle")], SHAPE)
    shapes.draw(panel, begin, linewidth=linewidth, zorder=2.5, **BEGINS)
    shapes.draw(panel, end, linewidth=linewidth, zorder=2.6, **ENDS)
    tips = ["cycle", "x1"]
    slips = end[tips].merge(slipping[tips], on="cycle", suffixes=("", "_after"))
    if len(slips):
        start, stop = slips["x1"].to_numpy(), slips["x1_after"].to_numpy()
        arcs = symbols.arcs_of_slips(start, stop, float(steps["eta"].iloc[0]))
        panel.plot(*arcs, color=INK, linewidth=0.7)
    places = {0, int(steps["footpoint"].argmax()), len(steps) - 1}
    for row in (steps.iloc[place] for place in sorted(places)):
        symbols.clamp(panel, row["shape_x"][0], row["shape_y"][0])


def begins(steps: pd.DataFrame) -> pd.Series:
    """Whether a period of sticking begins in each step of a scan: the first, or after a slip."""
    return (steps["phase"] == "slip") | (np.arange(len(steps)) == 0)


def _name_motion(panel: Axes, steps: pd.DataFrame) -> None:
    """Draw the motion of the clamp, the length of the first period, and where the tip slips."""
    sticking = steps[(steps["cycle"] == 1) & (steps["phase"] == "stick")].iloc[-1]
    low = float(steps.iloc[0]["shape_y"][0]) - 0.075
    start, stop = sticking["footpoint"] - sticking["x0"], float(sticking["footpoint"])
    panel.plot([start, stop], [low, low], "|-", color=INK, linewidth=0.8, markersize=4)
    # The number within the formula would take half as long again to lay out.
    text = rf"$x_\mathrm{{0,max}}$ = {sticking['x0']:g}"
    panel.text(start, low - 0.03, text, va="top", fontsize=7)
    footpoint = steps["footpoint"]
    tail = float(footpoint.max()) + 0.06, float(steps.iloc[-1]["shape_y"][0])
    turns = (footpoint.diff() < 0.0).any()
    draw_arrow = symbols.dimension if turns else symbols.arrow
    draw_arrow(panel, tail, (tail[0] + 0.12, tail[1]))
    panel.text(tail[0] + 0.14, tail[1], "clamp", va="center", fontsize=7)
    if (steps["phase"] == "slip").any():
        tips = sorted([sticking["x1"], *steps["x1"][steps["phase"] == "slip"]])
        is_free = tips[0] - panel.get_xlim()[0] > 0.3
        place, side = (tips[0] - 0.02, "right") if is_free else (tips[-1] + 0.02, "left")
        high = float(sticking["eta"]) + 0.065
        panel.text(place, high, "tip slips", ha=side, va="center", fontsize=7)


def _name_lines(panel: Axes, steps: pd.DataFrame, linewidth: float) -> None:
    """Name the first and the last shape of a period beside them, or else in the legend."""
    begin, end = steps[begins(steps)], steps[steps["phase"] == "stick"].groupby("cycle").tail(1)
    begun = FREE if (begin["x0"] == 0.0).all() else BEGUN
    # The height at which each name points to its shape is a share of η.
    names = ((begun, 0.55, BEGINS), (ENDED, 0.25, ENDS))
    reaches = [float(x[: len(x) // 2].max()) for x in map(np.asarray, steps["shape_x"])]
    for rows, (text, share, look) in zip((begin, end), names, strict=True):
        last = rows.iloc[int(rows["footpoint"].argmax())]
        x, y = np.asarray(last["shape_x"]), np.asarray(last["shape_y"])
        place = int(np.argmin(np.abs(y - share * last["eta"])))
        beside = max(reaches) + GAP
        if panel.get_xlim()[1] - beside < ROOM:
            style.mean(panel, text.replace("\n", " "), linewidth=linewidth, **look)
        else:
            labels.beside(panel, text, (x[place], y[place]), beside, look["color"])


@kind(
    "signals",
    columns=(*SCAN, "footpoint", "cycle", "alpha", "stability", "stability_aside", *REACTIONS),
)
def signals(rows: pd.DataFrame) -> Figure:
    """Friction required to stick, loads on the clamp and stability over the clamp's position."""
    figure = style.page(4.6)
    inclination, forces, stability = figure.subplots(3, 1, sharex=True)
    x, mu0 = rows["footpoint"], float(rows["mu0"].iloc[0])
    inclination.plot(x, -np.tan(rows["alpha"]), color="black")
    inclination.axhspan(-mu0, mu0, color="#eeeeee", linewidth=0, zorder=0)
    # Room beyond the cone, so that its edge is not taken for the axis.
    inclination.set_ylim(-1.25 * mu0, 1.25 * mu0)
    inclination.set_yticks([-mu0, 0.0, mu0], [r"$-\mu_0$", "0", r"$\mu_0$"])
    inclination.set_ylabel(r"$-\tan\alpha$")
    inclination.set_title("grey: friction cone", loc="left", fontsize=7)
    for i, (name, label) in enumerate(REACTIONS.items()):
        forces.plot(x, rows[name], color=COLORS[i], linestyle=DASHES[i], label=label)
    forces.set_ylabel("load on the clamp")
    forces.set_title(r"$f_x$, $f_y$ in $E I_0/L^2$; $m$ in $E I_0/L$", loc="left", fontsize=7)
    stability.plot(x, rows["stability"], color=COLORS[3], label="in the plane")
    if rows["stability_aside"].notna().any():
        look: Look = {"color": COLORS[0], "linestyle": DASHES[1], "label": "out of the plane"}
        stability.plot(x, rows["stability_aside"], **look)
    stability.set(xlabel="position of the clamp / $L$", ylabel="smallest eigenvalue")
    stability.set_ylim(bottom=min(0.0, rows["stability"].min()))
    labels.at_ends(forces)
    labels.at_ends(stability)
    return figure
