"""Draw docs/refine.png and count its points: a coarse grid of mu0, and what refine adds to it."""

from decimal import Decimal
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from vibrissa import StickingCurve, solve_curve
from vibrissa.figures import style
from vibrissa.study.codec import decode_grid, decode_key
from vibrissa.study.grid import Refinement, points_on_curves
from vibrissa.tables.refining import Line, refined_lines
from vibrissa.wording import markdown_table

PICTURE = Path(__file__).with_name("refine.png")
PAGE = Path(__file__).with_name("refine.md")
MARKS = ("<!-- made by docs/refine.py: make sketch -->\n", "<!-- end of it -->")
GRID = decode_grid({"theta": ["2"], "mu0": ["0.1:0.6:0.1"], "eta": ["0.85"], "dx0": ["0.001"]})
TOLERANCES = ("0.01", "0.001", "0.0001")
SHOWN = "0.001"
CLOSEST = Decimal("0.0005")


def refined(curve: StickingCurve, tolerance: str) -> Line:
    """Refine the grid on its curve."""
    ((_, points),) = points_on_curves([decode_key(["2", "0.85"])], {"main": GRID})
    refinement = Refinement(column="x0_slip", tolerance=Decimal(tolerance), closest=CLOSEST)
    (line,) = refined_lines(curve, points, {"main": refinement})
    return line


def counts(curve: StickingCurve) -> str:
    """Table of the points that tolerances take, and of a grid that is as fine everywhere."""
    rows = []
    for tolerance in TOLERANCES:
        halved = refined(curve, tolerance).halved
        places = sorted([*GRID.mu0, *halved.added])
        finest = min(stop - start for start, stop in pairwise(places))
        uniform = int((places[-1] - places[0]) / finest) + 1
        unmet = sum(stop - start for start, stop in halved.unmet)
        rows.append([tolerance, str(len(places)), f"{finest:f}", str(uniform), f"{float(unmet):g}"])
    head = ["tolerance / L", "points", "finest gap", "points of a grid as fine everywhere"]
    return markdown_table([*head, "left over, in mu0"], rows)


def draw(axes: Axes, curve: StickingCurve) -> None:
    """Draw the onset, and what straight lines between points make of it."""
    added = refined(curve, SHOWN).halved.added
    fine = {"marker": "o", "markersize": 3.5, "color": style.COLORS[0]}
    coarse = {"marker": "s", "markersize": 7, "color": style.COLORS[1], "fillstyle": "none"}
    for places, look, height, label in (
        (sorted([*GRID.mu0, *added]), fine, -0.006, f"with refine, tolerance {SHOWN}"),
        (GRID.mu0, coarse, -0.014, "the grid alone"),
    ):
        mu0 = np.array(places, dtype=float)
        label = f"{label}: {len(mu0)} points"
        axes.plot(mu0, curve.onset(mu0), linewidth=0.9, label=label, **look)
        axes.plot(mu0, np.full(len(mu0), height), "|", color=look["color"], markersize=7)
    axes.axvline(curve.mu_lock, color=style.SURFACE, linewidth=0.9, linestyle="--")
    axes.set_xlabel(style.FRICTION)
    axes.set_ylabel(r"onset of slip $x_{0,\mathrm{slip}}$ / $L$")
    axes.set_title(r"$\theta = 2$, $\eta = 0.85$; dashed: $\mu_\mathrm{lock}$; below: all points")
    axes.legend(loc="upper left")


def main() -> None:
    """Draw the picture and bring the page in line."""
    curve = solve_curve(2.0, 0.85)
    with style.applied():
        figure, axes = style.axes(3.6)
        draw(axes, curve)
        style.save(figure, [PICTURE])
    before, rest = PAGE.read_text(encoding="utf-8").split(MARKS[0])
    after = rest.split(MARKS[1])[1]
    page = f"{before}{MARKS[0]}{counts(curve)}\n{MARKS[1]}{after}"
    PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
