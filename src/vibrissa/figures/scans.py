"""Figures of one stick-slip scan: the shapes of the rod, and what the clamp measures."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibrissa.figures import style
from vibrissa.figures.kinds import SCAN, kind
from vibrissa.figures.style import COLORS, END, SHAPE, START, SURFACE

LOCKED = "the tip locks"
SHAPES = ("x0", "footpoint", "cycle", "phase", "shape_x", "shape_y")
REACTIONS = {"reaction_fx": "$F_x$", "reaction_fy": "$F_y$", "reaction_m": "$M$"}


@kind("scan", columns=(*SCAN, *SHAPES))
def scan(rows: pd.DataFrame) -> Figure:
    """Shapes at every footpoint position of a scan (paper Figures 4 and 5)."""
    figure, axes = style.shape_axes(rows)
    _shapes(axes, rows, color=SHAPE, linewidth=0.2)
    _shapes(axes, rows[rows["x0"] == 0], color=START, linewidth=0.9)
    axes.plot([], [], color=START, linewidth=0.9, label=r"$\alpha = 0$: a period begins")
    axes.plot([], [], color=SHAPE, linewidth=0.8, label="sticking")
    _clamps(axes, rows, 1.5)
    _title(axes, rows, _cycles(rows))
    return figure


@kind("period", columns=(*SCAN, *SHAPES))
def period(rows: pd.DataFrame) -> Figure:
    """Shapes of the first period of sticking of a scan (paper Figure 3)."""
    rows = rows[(rows["cycle"] == 1) & (rows["phase"] == "stick")]
    last = "last step of sticking" if _locks(rows) else "last sticking state"
    figure, axes = style.shape_axes(rows)
    _shapes(axes, rows, color=SHAPE, linewidth=0.3)
    _shapes(axes, rows.iloc[[0]], color=START, linewidth=1.8)
    _shapes(axes, rows.iloc[[-1]], color=END, linewidth=1.8)
    axes.plot([], [], color=START, linewidth=1.8, label=r"first state, $\alpha = 0$")
    axes.plot([], [], color=END, linewidth=1.8, label=last)
    _clamps(axes, rows, 2.5)
    travel = rows["footpoint"].iloc[-1]
    _title(axes, rows, rf"one period of sticking, $x_{{0,\mathrm{{max}}}} = {travel:g}$")
    return figure


@kind(
    "signals",
    columns=(*SCAN, "footpoint", "cycle", "alpha", "stability", "stability_aside", *REACTIONS),
)
def signals(rows: pd.DataFrame) -> Figure:
    """Inclination of the contact force, clamp reactions and stability over the clamp's position."""
    figure = style.page(6.0)
    inclination, reactions, stability = figure.subplots(3, 1, sharex=True)
    rows = rows.sort_values("footpoint")
    x, mu0 = rows["footpoint"], rows["mu0"].iloc[0]
    inclination.plot(x, np.tan(rows["alpha"]), color=COLORS[0])
    for bound in (-mu0, mu0):
        inclination.axhline(bound, color=SURFACE, linewidth=0.8, linestyle="--")
    inclination.set_ylabel(r"$\tan\alpha$, friction cone $\pm\mu_0$")
    for (name, label), color in zip(REACTIONS.items(), COLORS, strict=False):
        reactions.plot(x, rows[name], color=color, label=label)
    reactions.set_ylabel("load on the clamp")
    reactions.legend(fontsize=9, ncols=3)
    stability.plot(x, rows["stability"], color=COLORS[3], label="in the plane")
    if rows["stability_aside"].notna().any():
        stability.plot(x, rows["stability_aside"], color=COLORS[4], label="out of the plane")
        stability.legend()
    stability.set_ylabel("smallest eigenvalue")
    stability.set_ylim(bottom=min(0.0, rows["stability"].min()))
    stability.set_xlabel("clamp position / $L$")
    _title(inclination, rows, _cycles(rows))
    return figure


def _shapes(axes: Axes, rows: pd.DataFrame, **look: Any) -> None:
    for x, y in zip(rows["shape_x"], rows["shape_y"], strict=True):
        axes.plot(x, y, solid_capstyle="round", **look)


def _clamps(axes: Axes, rows: pd.DataFrame, size: float) -> None:
    """Mark the positions of the clamp, and put the legend below."""
    step = rows["dx0"].iloc[0]
    look: dict[str, Any] = {"linestyle": "none", "marker": ".", "color": "black"}
    axes.plot(rows["footpoint"], 0 * rows["footpoint"], markersize=size, **look)
    axes.plot([], [], markersize=5, label=rf"clamp, $\Delta x_0 = {step:g}$", **look)
    axes.figure.legend(loc="outside lower center", ncols=3, fontsize=9)


def _locks(rows: pd.DataFrame) -> bool:
    return bool(rows["status"].iloc[0] == "lock")


def _cycles(rows: pd.DataFrame) -> str:
    """Say how many cycles a scan has."""
    cycles = int(rows["cycle"].max())
    return f"{cycles} stick-slip cycle{'s' if cycles > 1 else ''}"


def _title(axes: Axes, rows: pd.DataFrame, what: str) -> None:
    """Say which scan is shown, and what of it; of a tip that locks there is no more than that."""
    axes.set_title(f"{style.rod_of(rows)}: {LOCKED if _locks(rows) else what}")
