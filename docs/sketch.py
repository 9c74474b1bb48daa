"""Draw the sketch of docs/model.md with the program's own solver."""

from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibrissa import StickingCurve, solve_curve
from vibrissa.figures import style, symbols
from vibrissa.files import write_atomically
from vibrissa.mechanics.elastica import deformed_shape
from vibrissa.mechanics.taper import diameter

PICTURE = Path(__file__).with_name("sketch.svg")
THICKNESS = 0.03  # drawn diameter of the base (L)
DARK, LIGHT, RED, BLUE = style.INK, "0.75", style.LOAD, style.COLORS[0]
# Text is drawn as outlines, as a browser may not have the typeface.
STYLE = style.SETTINGS | {
    "svg.fonttype": "path",
    "hatch.linewidth": 0.5,
    "font.size": 13.0,
    "axes.titlesize": 14.0,
}


def draw_rod(axes: Axes, curve: StickingCurve, x0: float, color: str) -> dict[str, float]:
    """Draw rod and clamp at one clamp displacement; return α and places on the rod."""
    state, s = curve.state(x0), np.linspace(0.0, 1.0, 201)
    f, alpha, s_c = float(state.f), float(state.alpha), float(state.s_c)
    x, y, phi = deformed_shape(curve.theta, f, alpha, curve.x1_init - x0, curve.eta, s, s_c)
    x += x0
    half = 0.5 * THICKNESS * diameter(s, curve.theta)
    across = half * np.sin(phi), half * np.cos(phi)
    axes.fill(
        np.append(x - across[0], (x + across[0])[::-1]),
        np.append(y + across[1], (y - across[1])[::-1]),
        facecolor=color,
    )
    ground(axes, (x0 - 0.05, x0 + 0.05), 0.0, -0.03)
    middle, contact = 90, int(np.searchsorted(s, s_c - 1e-9))
    return {
        "alpha": alpha,
        "x": x[middle],
        "y": y[middle],
        "phi": phi[middle],
        "x_c": x[contact],
        "x1": x[-1],
    }


def ground(axes: Axes, ends: tuple[float, float], y: float, depth: float) -> None:
    """Draw a fixed body with a straight edge."""
    axes.plot(ends, [y, y], color=DARK, linewidth=1.0)
    axes.fill_between(
        ends, y, y + depth, facecolor="none", hatch="////", edgecolor=DARK, linewidth=0.0
    )


def dimension(axes: Axes, start: tuple, stop: tuple, text: str, place: tuple) -> None:
    """Draw a dimension line with its symbol."""
    symbols.dimension(axes, start, stop)
    axes.text(*place, text, ha="center", va="center", backgroundcolor="white", zorder=3)


def contact_force(axes: Axes, at: tuple, alpha: float, size: float = 0.26) -> None:
    """Draw the force of the surface on the rod, and its inclination."""
    tail = symbols.force(axes, at, alpha, size, linewidth=1.8)
    axes.text(tail[0] + 0.03, tail[1], "$f$", color=RED, va="center")
    symbols.angle(axes, at, 0.17, (90.0, 90.0 + np.degrees(alpha)))
    way = 0.5 * np.pi + 0.55 * alpha
    axes.text(at[0] + 0.2 * np.cos(way), at[1] + 0.2 * np.sin(way), r"$\alpha$", ha="center")


def main() -> None:
    """Draw both kinds of contact."""
    figure = Figure(figsize=(10.0, 6.2), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.25, 1.0))

    eta, x0 = 0.85, 0.14
    curve = solve_curve(theta=2, eta=eta, contact="line")
    ground(left, (-0.14, 0.95), eta, 0.03)
    draw_rod(left, curve, 0.0, LIGHT)
    rod = draw_rod(left, curve, x0, BLUE)
    tip = (rod["x1"], eta)
    contact_force(left, tip, rod["alpha"])
    dimension(left, (0.0, -0.1), (x0, -0.1), "$x_0$", (0.5 * x0, -0.15))
    dimension(left, (0.0, -0.21), (tip[0], -0.21), "$x_1$", (0.5 * tip[0], -0.21))
    left.plot([tip[0]] * 2, [-0.23, eta - 0.03], color=DARK, linewidth=0.4)
    left.plot([0.0] * 2, [-0.23, -0.04], color=DARK, linewidth=0.4)
    dimension(left, (0.86, 0.0), (0.86, eta), r"$\eta$", (0.86, 0.5 * eta))
    left.plot([0.25, 0.9], [0.0, 0.0], color=DARK, linewidth=0.4)
    place = rod["x"], rod["y"]
    symbols.angle(left, place, 0.1, (0.0, np.degrees(rod["phi"])))
    left.text(place[0] + 0.12, place[1] + 0.06, r"$\varphi(s)$")
    # The load on the clamp, each part in its positive direction.
    symbols.arrow(left, (x0, 0.0), (x0 + 0.17, 0.0), color=RED, linewidth=1.8)
    left.text(x0 + 0.12, 0.025, "$f_x$", color=RED)
    symbols.arrow(left, (x0, 0.0), (x0, 0.17), color=RED, linewidth=1.8)
    left.text(x0 - 0.055, 0.14, "$f_y$", color=RED)
    look = {"arrowstyle": "-|>", "color": RED, "linewidth": 1.8, "connectionstyle": "arc3,rad=0.6"}
    left.annotate("", (x0 - 0.02, 0.085), (x0 + 0.085, -0.02), arrowprops=look)
    left.text(x0 + 0.085, 0.075, "$m$", color=RED)
    left.text(-0.01, 0.3, r"$\alpha = 0$", color="0.45", ha="right")
    symbols.arrow(left, (-0.14, 0.62), (-0.02, 0.62))
    symbols.arrow(left, (-0.14, 0.62), (-0.14, 0.74))
    left.text(-0.02, 0.64, "$x$")
    left.text(-0.12, 0.73, "$y$")
    left.text(0.93, eta + 0.06, "surface", ha="right")
    left.text(x0 + 0.08, -0.045, "clamp")
    left.set_title("tip contact")

    eta, x0 = 0.7, 0.1
    curve = solve_curve(theta=5, eta=eta, contact="line")
    ground(right, (-0.1, 0.68), eta, 0.03)
    rod = draw_rod(right, curve, x0, BLUE)
    contact_force(right, (rod["x_c"], eta), rod["alpha"])
    low = eta - 0.07
    dimension(right, (rod["x_c"], low), (rod["x1"], low), "", (0.0, 0.0))
    right.text(0.5 * (rod["x_c"] + rod["x1"]), low - 0.05, "$1 - s_c$", ha="center")
    right.set_title("line contact")
    for axes in (left, right):
        axes.set(aspect="equal", ylim=(-0.26, 1.16))
        axes.axis("off")
    with write_atomically(PICTURE) as temporary:
        figure.savefig(temporary, format="svg", metadata={"Date": None})


if __name__ == "__main__":
    with matplotlib.rc_context(STYLE):
        main()
