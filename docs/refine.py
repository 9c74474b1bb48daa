"""Draw docs/refine.png and count its points: a coarse grid of mu0, and what refine adds to it."""

from decimal import Decimal
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from vibrissa import StickingCurve, solve_curve
from vibrissa.figures import style
from vibrissa.study.codec import decode_grid, decode_key
from vibrissa.study.grid import CurveKey, Refinement, points_on_curves
from vibrissa.tables.refining import Line, curve_lines, refined_lines
from vibrissa.wording import markdown_table

PICTURE = Path(__file__).with_name("refine.png")
PAGE = Path(__file__).with_name("refine.md")
MARKS = ("<!-- {} made by docs/refine.py: make sketch -->\n", "<!-- end of {} -->")
GRID = decode_grid({"theta": ["2"], "mu0": ["0.1:0.6:0.1"], "eta": ["0.85"], "dx0": ["0.001"]})
TOLERANCES = ("0.01", "0.001", "0.0001")
SHOWN = "0.001"
CLOSEST = Decimal("0.0005")
TAPERS = decode_grid(
    {"theta": ["1", "2", "4", "8"], "mu0": ["0.2", "0.3", "0.4"], "eta": ["0.85"], "dx0": ["0.001"]}
)
CLOSEST_THETA = Decimal("0.01")


def refined(curve: StickingCurve, tolerance: str) -> Line:
    """Refine the grid on its curve."""
    ((_, points),) = points_on_curves([decode_key(["2", "0.85"])], {"main": GRID})
    closest = {"mu0": CLOSEST}
    refinement = Refinement(column="x0_slip", tolerance=Decimal(tolerance), closest=closest)
    (line,) = refined_lines(curve, points, {"main": refinement})
    return line


def curves_of(tolerance: str) -> list[Decimal]:
    """Values of θ that a coarse grid of θ and those that are added to it have."""
    closest = {"theta": CLOSEST_THETA}
    refinement = Refinement(column="x0_slip", tolerance=Decimal(tolerance), closest=closest)
    gaps = {"theta": list(pairwise(TAPERS.theta))}
    ((line, _),) = curve_lines("main", TAPERS, gaps, refinement, solve)
    return sorted([*TAPERS.theta, *line.halved.added])


@cache
def solve(key: CurveKey) -> StickingCurve:
    """Solve a curve once."""
    return solve_curve(float(key.theta), float(key.eta))


def curve_counts() -> str:
    """Table of the curves that tolerances take, and of a grid that is as fine everywhere."""
    rows = []
    for tolerance in TOLERANCES:
        values = curves_of(tolerance)
        finest = min(stop - start for start, stop in pairwise(values))
        uniform = int((values[-1] - values[0]) / finest) + 1
        rows.append([tolerance, str(len(values)), f"{finest:f}", str(uniform)])
    head = ["tolerance / L", "curves", "finest gap", "curves of a grid as fine everywhere"]
    return markdown_table(head, rows)


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
    page = PAGE.read_text(encoding="utf-8")
    for axis, table in (("mu0", counts(curve)), ("theta", curve_counts())):
        start, end = (mark.format(axis) for mark in MARKS)
        before, rest = page.split(start)
        _, after = rest.split(end)
        page = f"{before}{start}{table}\n{end}{after}"
    PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
