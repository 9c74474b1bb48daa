"""Symbols that all pictures share: surface, clamp, contact, force, motion, dimension, slip.

Positions are in units of L. A rod is drawn from its clamp upwards to the surface.
"""

from typing import Any, NamedTuple, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Arc

from vibrissa.figures.style import INK, LOAD, SURFACE, Look
from vibrissa.numerics.arrays import FloatArray

Point: TypeAlias = tuple[float, float]
# Depth of a fixed body, and half of the width of a clamp (L).
DEPTH, HALF_CLAMP = 0.03, 0.04
# Height of the arc of a slip as a share of its length, and its largest height (L).
ARCH, HIGHEST_ARCH = 0.5, 0.05
# Length of the arrow of a force (L).
FORCE = 0.2
HATCH: Look = {"facecolor": "none", "edgecolor": "#999999", "hatch": "//////", "linewidth": 0.0}
THIN_ARROW: Look = {"linewidth": 0.8, "color": INK, "shrinkA": 0.0, "shrinkB": 0.0}


class Arcs(NamedTuple):
    """Points of a line of arcs (L)."""

    x: FloatArray
    y: FloatArray


def surface(panel: Axes, eta: float) -> None:
    """Draw the surface, a fixed body above the height `eta`."""
    panel.axhline(eta, color=SURFACE, linewidth=0.8)
    panel.axhspan(eta, eta + DEPTH, **HATCH)


def clamp(panel: Axes, x: float, y: float = 0.0, **look: Any) -> None:
    """Draw the clamp at the base of a rod: a short edge, hatched below."""
    ends = [x - HALF_CLAMP, x + HALF_CLAMP]
    panel.plot(ends, [y, y], **{"color": INK, "linewidth": 1.0, "zorder": 3, **look})
    panel.fill_between(ends, y - DEPTH, y, **HATCH)


def contact(panel: Axes, x: float, y: float, color: str, is_real: bool = True) -> None:
    """Draw the contact point: filled, or hollow where the rod passes through the surface."""
    look: Look = {"color": color, "markerfacecolor": color if is_real else "white", "zorder": 4}
    panel.plot(x, y, "o", markersize=4, **look)


def arrow(panel: Axes, tail: Point, head: Point, **look: Any) -> None:
    """Draw an arrow from one point to another."""
    panel.annotate("", head, tail, arrowprops={"arrowstyle": "-|>", **THIN_ARROW, **look})


def dimension(panel: Axes, start: Point, stop: Point, **look: Any) -> None:
    """Draw a dimension line between two points."""
    panel.annotate("", stop, start, arrowprops={"arrowstyle": "<|-|>", **THIN_ARROW, **look})


def force(panel: Axes, at: Point, alpha: float, size: float = FORCE, **look: Any) -> Point:
    """Draw the force of the surface, an arrow into the rod; return its tail.

    `alpha` is its inclination (rad): the force is f (sin α, −cos α).
    """
    tail = at[0] - size * np.sin(alpha), at[1] + size * np.cos(alpha)
    arrow(panel, tail, at, color=LOAD, **{"linewidth": 1.4, **look})
    return tail


def angle(panel: Axes, at: Point, radius: float, ends: tuple[float, float]) -> None:
    """Draw the arc of an angle (degrees), and the line from which it is counted."""
    low, high = sorted(ends)
    panel.add_patch(
        Arc(at, 2 * radius, 2 * radius, theta1=low, theta2=high, color=INK, linewidth=0.8)
    )
    way = np.radians(ends[0])
    stop = at[0] + 1.3 * radius * np.cos(way), at[1] + 1.3 * radius * np.sin(way)
    panel.plot(*zip(at, stop, strict=True), color=INK, linewidth=0.7, linestyle=":")


def arcs_of_slips(start: FloatArray, stop: FloatArray, eta: float) -> Arcs:
    """Return the slips of a tip as one line, with a gap after each.

    A slip is an arc above the surface from the old to the new contact point, `start` to `stop`.
    """
    turn = np.append(np.linspace(np.pi, 0.0, 13), np.nan)
    middle, half = 0.5 * (start + stop)[:, None], 0.5 * (stop - start)[:, None]
    height = np.minimum(2.0 * ARCH * np.abs(half), HIGHEST_ARCH)
    x, y = middle + half * np.cos(turn), eta + DEPTH + 0.005 + height * np.sin(turn)
    return Arcs(x=x.ravel(), y=y.ravel())
